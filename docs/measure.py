#!/usr/bin/env python3
"""Cost and response times of `groundwave watch` as a Markdown table; with --beside, compared with other programs.

    cargo build --release
    python3 -m venv /tmp/measuring && /tmp/measuring/bin/pip install -r docs/measuring/requirements.txt
    /tmp/measuring/bin/python docs/measure.py                  about a quarter of an hour
    /tmp/measuring/bin/python docs/measure.py --beside         half an hour; MAVProxy, gpsmon, picocom and btm too

Linux only. A pseudo-terminal delivers a line three times per second, in bunches of 16 ms like a USB adapter; the
terminal has 120x40. CPU, memory and processes are read from /proc; times are those of the monotonic clock. --only
NAME measures one program; --seconds and --keys set the duration. As root, the script has a higher priority than the
measured program; otherwise the times include its own wait for a core. On a busy machine, --first gives the measured
program the priority that it would have on an idle one.
"""

import argparse
import datetime
import os
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "measuring"))

import machine
import times
from line import SerialLine
from programs import CONTESTANTS, OURS, Contestant
from terminal import Program

STARTS = 9
SETTLE_S = 6.0
SILENCE_S = 62.0

#: Measured figures, and the goals.
ROWS = {
    "cpu": ("CPU, % of a core", "0.6"),
    "bytes": ("bytes/s to the terminal", ""),
    "memory": ("resident, MiB", "16"),
    "threads": ("threads", ""),
    "bare": ("bare start (`--version`), ms", ""),
    "paint": (f"first paint, ms (median of {STARTS}, slowest)", "15"),
    "screen quiet": ("last byte to screen, ms (p50, p99)", "5"),
    "screen busy": ("the same with every core busy", "15"),
    "key quiet": ("key to serial byte, ms (p50, p99)", "5"),
    "key busy": ("the same with every core busy", "15"),
    "silent": ("silent for a minute: CPU, %; bytes/s", ""),
}


class Trial:
    """Measures one program; returns the results by row."""

    def __init__(self, contestant: Contestant, options: argparse.Namespace, folder: str) -> None:
        self.contestant, self.folder, self.is_first = contestant, folder, options.first
        self.seconds, self.keys = options.seconds, options.keys
        self.cells: dict[str, str] = {}
        self._started = 0

    def run(self) -> dict[str, str]:
        self.cells["bare"] = f"{self._bare_start_ms():.1f}"
        self._starts()
        serial, program = self._start()
        if self.contestant.setup:
            time.sleep(2.0)
            program.type(self.contestant.setup)
        time.sleep(SETTLE_S)
        self._costs(program)
        self._prompt(program, serial, "quiet")
        machine.give_precedence(program.pid, False)
        with machine.every_core_busy():
            time.sleep(self.seconds)
            self._prompt(program, serial, "busy")
        if self.contestant in OURS:
            self._silence(program, serial)
        program.stop()
        serial.end()
        return self.cells

    def _start(self) -> tuple[SerialLine, Program]:
        serial = SerialLine()
        if self.contestant.feed:
            self.contestant.feed(serial)
        self._started += 1
        file = os.path.join(self.folder, f"run-{self._started}")
        return serial, Program(self.contestant.words(serial.path, file), self.folder, {"HOME": self.folder}, self.is_first)

    def _bare_start_ms(self) -> float:
        words = [self.contestant.words("", "")[0], *self.contestant.version]
        took_ms = []
        for _ in range(STARTS):
            began = time.monotonic()
            subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False, cwd=self.folder)
            took_ms.append((time.monotonic() - began) * 1000)
        return statistics.median(took_ms)

    def _starts(self) -> None:
        took_ms = []
        for _ in range(STARTS):
            serial, program = self._start()
            took_ms.append((program.wait_for(self.contestant.first_paint) - program.began) * 1000)
            program.stop()
            serial.end()
        self.cells["paint"] = f"{statistics.median(took_ms):.1f}, {max(took_ms):.1f}"

    def _costs(self, program: Program) -> None:
        begin, before_s = time.monotonic(), machine.cpu_s(program.pid)
        time.sleep(self.seconds)
        end, after_s = time.monotonic(), machine.cpu_s(program.pid)
        self.cells["cpu"] = f"{(after_s - before_s) / (end - begin) * 100:.2f}"
        self.cells["bytes"] = f"{program.bytes_between(begin, end) / (end - begin):.0f}"
        self.cells["memory"] = f"{machine.resident_mib(program.pid):.1f}"
        self.cells["threads"] = f"{machine.threads(program.pid)}"

    def _prompt(self, program: Program, serial: SerialLine, when: str) -> None:
        it = self.contestant
        if it.shown:
            since = time.monotonic() - self.seconds
            self.cells[f"screen {when}"] = _two(times.to_screen(program, serial, it.shown, since))
        if it.key:
            self.cells[f"key {when}"] = _two(times.to_line(program, serial, it.ahead, it.key, it.answer, self.keys))

    def _silence(self, program: Program, serial: SerialLine) -> None:
        serial.is_silent.set()
        time.sleep(SILENCE_S)
        begin, before_s = time.monotonic(), machine.cpu_s(program.pid)
        time.sleep(self.seconds)
        used_s, took_s = machine.cpu_s(program.pid) - before_s, time.monotonic() - begin
        self.cells["silent"] = f"{used_s / took_s * 100:.2f}; {program.bytes_between(begin, begin + took_s) / took_s:.0f}"


def _two(times_s: list[float]) -> str:
    if not times_s:
        return "none came"
    p50, p99 = (times.percentile(times_s, share) * 1000 for share in (0.5, 0.99))
    return f"{p50:.2f}, {p99:.2f} ({len(times_s)})"


def version(contestant: Contestant) -> str:
    words = [contestant.words("", "")[0], *contestant.version]
    told = subprocess.run(words, capture_output=True, text=True, check=False)
    lines = [line.strip() for line in (told.stdout + told.stderr).splitlines() if any(c.isdigit() for c in line)]
    return lines[0] if lines else contestant.name


def table(columns: dict[str, dict[str, str]]) -> str:
    lines = [
        "| | " + " | ".join(columns) + " | goal |",
        "|---" * (len(columns) + 2) + "|",
    ]
    for row, (name, goal) in ROWS.items():
        cells = [column.get(row, "–") for column in columns.values()]
        lines.append(f"| {name} | " + " | ".join(cells) + f" | {goal} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--beside", action="store_true", help="measure the other programs too")
    parser.add_argument("--only", metavar="NAME", help="measure this program alone")
    parser.add_argument("--seconds", type=float, default=60.0, help="for how long each figure is taken (60)")
    parser.add_argument("--keys", type=int, default=100, help="how many keys are pressed (100)")
    parser.add_argument("--first", action="store_true", help="while quiet, let what is measured run before all else on the machine")
    options = parser.parse_args()
    chosen = [it for it in CONTESTANTS if options.beside or it in OURS]
    if options.only:
        chosen = [it for it in CONTESTANTS if options.only in it.name]
    about, commit = machine.describe(), machine.commit()
    is_prompt = machine.be_prompt()
    columns, notes = {}, []
    for contestant in chosen:
        if not contestant.is_here():
            notes.append(f"{contestant.name}: not installed here")
            continue
        print(f"measuring {contestant.name} ...", file=sys.stderr)
        with tempfile.TemporaryDirectory() as folder:
            columns[contestant.name] = Trial(contestant, options, folder).run()
        notes.append(f"{contestant.name}: {version(contestant)}; {contestant.remark}")
    print(f"Machine: {about}. {datetime.date.today()}, commit {commit}. Each figure over {options.seconds:.0f} s or")
    print(f"{options.keys} keys; in brackets how many times there are. The measuring {'has' if is_prompt else 'has no'} precedence{', and so has what is measured while quiet' if options.first else ''}.\n")
    print(table(columns) + "\n")
    print("\n".join(f"- {note}." for note in notes))


if __name__ == "__main__":
    main()
