#!/usr/bin/env python3
"""Effect of a slow terminal on `groundwave watch`, as a Markdown table.

    cargo build --release
    python3 -m venv /tmp/measuring && /tmp/measuring/bin/pip install -r docs/measuring/requirements.txt
    /tmp/measuring/bin/python docs/measure_slow.py             about 6 minutes

Linux only. The terminal has 80x24 and no colours (NO_COLOR, TERM=vt100) and accepts a limited number of bytes per
second; *set* marks a terminal that reports its speed (`stty 2400`). The serial line is that of measure.py, and STOP
is pressed repeatedly. *Behind* is the age of the screen at each moment at which the terminal reads: the time since
the first line that it does not show yet. *Stalled* reads nothing for forty seconds, in which STOP is pressed too:
more than a pseudo-terminal can buffer.
"""

import argparse
import datetime
import os
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "measuring"))

import machine
import times
from line import SerialLine
from programs import GROUNDWAVE, our_line
from terminal import Program

SIZE = (80, 24)
SETTLE_S = 5.0
STALL_S = 40.0
#: Name of the terminal, bytes per second that it accepts (0: unlimited), whether its speed is set.
TERMINALS = (
    ("fast", 0, False),
    ("2,400 bytes/s", 2400, False),
    ("1,200 bytes/s", 1200, False),
    ("600 bytes/s", 600, False),
    ("480 bytes/s, set", 480, True),
    ("240 bytes/s, set", 240, True),
    ("stalled", 0, False),
)


def trial(bytes_per_s: int, is_set: bool, stalls: bool, seconds: float, program: str) -> list[str]:
    """The cells of one row."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "run.mcap")
        serial = SerialLine()
        serial.robot(program)
        words = [program, "watch", serial.path, "--record", file]
        if is_set:
            words = ["sh", "-c", f'stty {bytes_per_s * 10}; exec "$@"', "sh", *words]
        environment = {"HOME": folder, "NO_COLOR": "1", "TERM": "vt100"}
        dashboard = Program(words, folder, environment, size=SIZE, bytes_per_s=bytes_per_s)
        time.sleep(SETTLE_S)
        begin = time.monotonic()
        if stalls:
            dashboard.is_stalled.set()
        keys_s = times.to_line(dashboard, serial, b"", b" ", b"", int(STALL_S if stalls else seconds))
        since = time.monotonic() if stalls else begin
        dashboard.is_stalled.clear()
        time.sleep(SETTLE_S)
        end = time.monotonic()
        behind_s = times.behind(dashboard, serial, our_line, since, end, SIZE)
        written = dashboard.bytes_between(begin, end) / (end - begin)
        dashboard.stop()
        sent = [packet for at, packet in list(serial.sent) if at < end - 1]
        serial.end()
        raw = subprocess.run([program, "export", file, "--to", "raw", "-o", "-"], capture_output=True, check=False).stdout
        lost = sum(packet.strip() not in raw for packet in sent)
    return [
        f"{written:.0f}",
        _two(keys_s, 1000, 2),
        _two(behind_s, 1, 2),
        f"{lost} of {len(sent)}",
    ]


def _two(values: list[float], factor: float, digits: int) -> str:
    if not values:
        return "none came"
    low, high = (times.percentile(values, share) * factor for share in (0.5, 1.0))
    return f"{low:.{digits}f}, {high:.{digits}f} ({len(values)})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=40.0, help="for how long each row is taken (40)")
    parser.add_argument("--only", metavar="NAME", help="this terminal alone")
    parser.add_argument("--program", default=GROUNDWAVE, help="what to measure (the release build)")
    options = parser.parse_args()
    about, commit = machine.describe(), machine.commit()
    machine.be_prompt()
    print(f"Machine: {about}. {datetime.date.today()}, commit {commit}.\n")
    print("| terminal | bytes/s that it took | key to serial byte, ms (p50, slowest) | behind, s (p50, most) | lines lost from the recording |")
    print("|---|---|---|---|---|")
    for name, bytes_per_s, is_set in [it for it in TERMINALS if not options.only or options.only in it[0]]:
        print(f"measuring {name} ...", file=sys.stderr)
        cells = trial(bytes_per_s, is_set, name == "stalled", options.seconds, os.path.abspath(options.program))
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
