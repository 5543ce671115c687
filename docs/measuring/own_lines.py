#!/usr/bin/env python3
"""CPU time of the dashboard of a robot with its own lines: 1,000 lines/s of two values, as at 115,200 baud.

    cargo build --release
    python3 docs/measuring/own_lines.py                     Teleplot lines, 60 s
    python3 docs/measuring/own_lines.py --form csv --seconds 20

Linux only; needs no packages. The terminal has 120x40. User and system time are read from /proc.
"""

import argparse
import math
import os
import pty
import sys
import tempfile
import threading
import time
import tty

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from machine import cpu_s
from terminal import Program

LINES_PER_S = 1000
PERIOD_S = 0.004
SETTLE_S = 5.0

FORMS = {
    "teleplot": lambda n, a, b: b">%s:%05.2f\n" % ((b"temp", a) if n % 2 else (b"volt", b)),
    "csv": lambda n, a, b: b"%04.1f,%04.1f\n" % (a, b),
}


class Robot:
    """Writes lines to a pseudo-terminal until the end of this program."""

    def __init__(self, form: str) -> None:
        self._fd, other = pty.openpty()
        tty.setraw(other)
        self.path = os.ttyname(other)
        self.lines = 0
        self._line = FORMS[form]
        threading.Thread(target=self._write, daemon=True).start()

    def _write(self) -> None:
        began = time.monotonic()
        while True:
            due = int((time.monotonic() - began) * LINES_PER_S)
            numbers = range(self.lines, due)
            lines = [self._line(n, 45 + 40 * math.sin(n / 300), 45 + 40 * math.cos(n / 700)) for n in numbers]
            os.write(self._fd, b"".join(lines))
            self.lines = due
            time.sleep(PERIOD_S)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="target/release/groundwave")
    parser.add_argument("--form", choices=FORMS, default="teleplot")
    parser.add_argument("--seconds", type=float, default=60.0)
    options = parser.parse_args()
    robot = Robot(options.form)
    with tempfile.TemporaryDirectory() as folder:
        homes = {"XDG_CONFIG_HOME": folder, "XDG_STATE_HOME": folder}
        words = [os.path.abspath(options.program), "watch", robot.path, "--baud", "115200"]
        program = Program(words, folder, homes)
        program.wait_for(b"fields")
        time.sleep(SETTLE_S)
        began, before, lines = time.monotonic(), cpu_s(program.pid), robot.lines
        time.sleep(options.seconds)
        passed = time.monotonic() - began
        share = (cpu_s(program.pid) - before) / passed
        rate = (robot.lines - lines) / passed
        print(f"{share:.1%} of a core in {passed:.0f} s, {rate:.0f} lines/s ({options.form}), to the terminal "
              f"{program.bytes_between(began, began + passed) / passed:.0f} bytes/s")
        program.stop()


if __name__ == "__main__":
    main()
