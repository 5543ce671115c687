"""What `docs/measure.py` is made of: the machine, the serial line, the terminal, the programs, and times between them."""
