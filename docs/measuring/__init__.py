"""Parts of `docs/measure.py`: the machine, the serial line, the terminal, the programs, and the times between them."""
