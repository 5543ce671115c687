#!/usr/bin/env python3
"""Checks the C library: strict warnings at every level, all vectors, random bytes under the sanitizers, sizes on AVR, examples.

Needs a C compiler (`CC`, else `cc`) and `c++`; measures sizes and compiles the sketches if `avr-gcc` is there. Prints a line for each check; the exit
status is 1 when one of them fails.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Iterator

HERE = Path(__file__).resolve().parent
LIBRARY = HERE.parent / "src" / "groundwave.c"
VECTORS = HERE.parent.parent / "vectors"
sys.path.insert(0, str(HERE.parent.parent / "reference"))

import groundwave_wire as wire  # noqa: E402

CC = os.environ.get("CC", "cc")
WARNINGS = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
SANITIZERS = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
LEVELS = range(1, 6)
# Limits on the ATmega2560: bytes of flash by level, and of RAM at level 5 without the lists.
FLASH_MAX = {1: 1024, 5: 10 * 1024}
RAM_MAX = 640
SIZE_WAYPOINTS = 8
# Fields of the judge's robot.
FIELDS = 9
AVR = ["-mmcu=atmega2560", "-Os", "-ffunction-sections", "-fdata-sections"]

Vector = dict[str, Any]


class Judge:
    """The program `judge.c`: answers questions, one a line."""

    def __init__(self, program: Path, separator: str = "\t") -> None:
        self.separator = separator
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)

    def ask(self, *words: Any) -> str:
        assert self.process.stdin and self.process.stdout
        self.process.stdin.write(self.separator.join(str(word) for word in words) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise AssertionError(f"the judge ended at {words!r}")
        return answer.rstrip("\n")

    def end(self) -> None:
        assert self.process.stdin
        self.process.stdin.close()
        if self.process.wait() != 0:
            raise AssertionError(f"the judge ended with {self.process.returncode}")


def in_hex(text: str) -> str:
    return text.encode("latin-1").hex() or "-"


def or_none(value: int | None) -> int:
    return -1 if value is None else value


def same(got: Any, expected: Any) -> None:
    if got != expected:
        raise AssertionError(f"got {got!r}, expected {expected!r}")


def arguments(fields: Vector) -> list[Any]:
    """The words that describe a line to the judge."""
    letters = ["off", "quiet", "raised", "holds"]
    match fields["type"]:
        case "A":
            layers = "".join(
                [".", "-", letter.lower(), letter][letters.index(state)]
                for letter, state in zip("BTISLMD", fields["layers"])
            )
            names = ["x_tenths_in", "y_tenths_in", "theta_deg", "velocity_in_s", "rotation_in_s", "wheel_left_in_s",
                     "wheel_right_in_s", "sonar_left_in", "sonar_right_in", "photo_left_pct", "photo_right_pct"]
            flags = ["bump", "infrared", "cliff", "arm", "drive", "power", "link", "mode"]
            return [or_none(fields[name]) for name in names] + [fields[name] for name in flags] + [layers]
        case "B":
            x, y = fields["target_in"] or (0, 0)
            return [fields["robot_id"], fields["battery_dv"], int(fields["target_in"] is not None), x, y,
                    fields["list_driven"], fields["list_count"], fields["digest"], fields["max_count"],
                    or_none(fields["photo_left"]), or_none(fields["photo_right"]), fields["fitted"], fields["allowed"],
                    fields["boots"], fields["odometer_resets"]]
        case "C":
            names = ["robot_id", "uptime_s", "boots", "version_major", "version_minor"]
            more = ["frames_heard", "frames_rejected", "ticks_late", "bumps"]
            return ([fields[name] for name in names] + fields["ticks_won"] + [fields[name] for name in more]
                    + [fields["failsafe_silence_s"] or 0, fields["failsafe_mode"] or "-"])
        case "T":
            return [fields["text"] or " "]
        case "P":
            names = ["place", "count", "name", "value", "kept", "least", "most"]
            return [fields[name] for name in names] + [fields["unit"] or " "]
        case "F":
            return [fields["place"], fields["name"], fields["decimals"], fields["unit"] or " "]
        case "V":
            return ["-" if value is None else value for value in fields["values"]]
        case "S":
            return [len(fields["notes"])] + [number for note in fields["notes"] for number in note]
        case _:
            return []


def check_lines(judge: Judge, vector: Vector) -> None:
    """Lines that the library can send; those that no robot may send are the reader's affair."""
    if "fields" not in vector:
        return
    fields = vector["fields"]
    if fields["type"] == "I" or (fields["type"] == "F" and fields["count"] != FIELDS):
        return  # Fixed when the library is compiled: the transcripts of the levels have them.
    if fields["type"] == "A" and "cannot_hear" in fields["ack"]:
        answer = judge.ask("level-1", fields["sequence"], fields["ack"]["robot_id"], *arguments(fields))
        same(bytes.fromhex(answer).decode("latin-1"), vector["line"])
        return
    ack = wire.from_six(wire.encode_ack(fields["ack"]))
    answer = judge.ask(fields["type"], fields["sequence"], ack, *arguments(fields))
    same(bytes.fromhex(answer).decode("latin-1"), vector["line"])


def check_frames(judge: Judge, vector: Vector) -> None:
    robot = [vector["robot_id"], vector["boot"], vector["session"], vector["owner"], vector.get("era", 0)]
    answer = judge.ask("frame", *robot, in_hex(vector["frame"]))
    if "error" in vector or vector["message"] is None:
        same(answer, vector.get("error", "none"))
        return
    got = dict(pair.partition("=")[::2] for pair in answer.split(" "))
    expected = {}
    for name, value in vector["message"].items():
        match name, value:
            case "waypoints", _:
                expected[name] = ",".join(str(number) for point in value for number in point)
            case "order", None:
                expected[name] = "?"
            case _, None:
                expected[name] = ""
            case _:
                expected[name] = str(value)
    same(got, expected)


def check_conversation(judge: Judge, vector: Vector) -> None:
    if "boots" in vector:
        same(judge.ask("boot", vector["robot_id"], vector["boots"]), "booted")
        return
    answer = judge.ask("hear", vector.get("outcome", 0), in_hex(vector["frame"]))
    expected = [vector["action"], vector["ack_characters"], str(vector["active_count"]), str(vector["active_digest"])]
    same(answer.split("\t"), expected)


def check_checksums(judge: Judge, vector: Vector) -> None:
    same(judge.ask("crc", vector["init"], in_hex(vector["text"])), vector["remainder"])


def check_digests(judge: Judge, vector: Vector) -> None:
    numbers = [number for point in vector["waypoints"] for number in point]
    same(judge.ask("digest", len(vector["waypoints"]), *numbers), str(vector["digest"]))


CHECKS = {"checksums": check_checksums, "digests": check_digests, "lines": check_lines, "frames": check_frames,
          "conversation": check_conversation}


def check_levels(folder: Path) -> str:
    """The library at each level against the transcript of that level."""
    count = 0
    for level in LEVELS:
        run(CC, *WARNINGS, *SANITIZERS, f"-DGW_LEVEL={level}", HERE / "transcript.c", "-o", folder / "transcript")
        robot = Judge(folder / "transcript", " ")
        path = VECTORS / f"level-{level}.jsonl"
        for number, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            step = json.loads(text)
            try:
                if "boots" in step:
                    same(robot.ask("boot", step["robot_id"], step["boots"], step["patience_bytes"]), "booted")
                elif "hears" in step:
                    answer = robot.ask("hear", in_hex(step["hears"]))
                    same(answer, str(step.get("outcome", answer)))
                else:
                    same(bytes.fromhex(robot.ask("line")).decode("latin-1"), step["line"])
            except AssertionError as error:
                raise AssertionError(f"{path.name}, line {number}, {step['about']}: {error}") from error
            count += 1
        robot.end()
    return f"{count} steps of transcripts"


def run(*command: Any) -> str:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} ended with {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def compile_all(folder: Path) -> str:
    for level in LEVELS:
        flags = ["-Wconversion", "-O2", f"-DGW_LEVEL={level}", "-c", LIBRARY, "-o", folder / "library.o"]
        run(CC, *WARNINGS, *flags)
        # As sketches include it.
        run("c++", "-std=c++11", "-Wall", "-Wextra", "-Werror", "-x", "c++", *flags[1:])
        run(CC, *WARNINGS, "-DGW_FIELDS=2", "-DGW_LINE_I", *flags)
    return f"levels 1 to {max(LEVELS)} without a warning, as C99 and as C++11"


def check_vectors(folder: Path) -> str:
    run(CC, *WARNINGS, *SANITIZERS, HERE / "judge.c", "-o", folder / "judge")
    judge = Judge(folder / "judge")
    count, failures = 0, []
    for path in sorted(VECTORS.glob("*.jsonl")):
        check = CHECKS.get(path.stem.split("-")[0])
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if check is None:
                continue
            try:
                check(judge, json.loads(line))
                count += 1
            except AssertionError as error:
                failures.append(f"{path.name}, line {number}: {error}")
    judge.end()
    if failures or count < 400:
        raise AssertionError("\n  ".join([f"{count} vectors passed"] + failures))
    return f"{count} vectors"


def check_random(folder: Path) -> str:
    for level in range(2, 6):
        run(CC, *WARNINGS, *SANITIZERS, f"-DGW_LEVEL={level}", "-DGW_FIELDS=3", HERE / "random.c", LIBRARY, "-o", folder / "random")
        run(folder / "random", 1, 300_000)
    return "300,000 random and damaged frames at each level, under the sanitizers"


def section_sizes(elf: Path) -> dict[str, int]:
    rows = (line.split() for line in run("avr-size", "-A", elf).splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) == 3 and row[1].isdigit()}


def check_sizes(folder: Path) -> str:
    if shutil.which("avr-gcc") is None:
        return "not measured: no avr-gcc"
    figures = []
    for level in LEVELS:
        flags = [*AVR, "-std=c99", "-Wl,--gc-sections", f"-DGW_LEVEL={level}", f"-DGW_WAYPOINTS={SIZE_WAYPOINTS}"]
        elf, empty = folder / "sizes.elf", folder / "empty.elf"
        run("avr-gcc", *flags, HERE / "size.c", LIBRARY, "-o", elf)
        run("avr-gcc", *flags, "-DGW_EMPTY", HERE / "size.c", "-o", empty)
        with_it, without = section_sizes(elf), section_sizes(empty)
        growth = {name: with_it.get(name, 0) - without.get(name, 0) for name in (".text", ".data", ".bss")}
        flash = growth[".text"] + growth[".data"]
        ram = growth[".data"] + growth[".bss"] - (2 * SIZE_WAYPOINTS * 4 if level >= 3 else 0)
        figures.append(f"level {level}: {flash} B of flash, {ram} B of RAM")
        if flash > FLASH_MAX.get(level, flash) or (level == 5 and ram > RAM_MAX):
            raise AssertionError(f"too large on an ATmega2560: {figures[-1]}")
    return "ATmega2560, without the lists: " + "; ".join(figures)


def check_sketches(folder: Path) -> str:
    """Compiles the Arduino sketches as the builder does, with declarations of the parts of Arduino that they use."""
    if shutil.which("avr-g++") is None:
        return "not compiled: no avr-g++"
    names = []
    for sketch in sorted((HERE.parent / "examples").glob("*/*.ino")):
        run("avr-g++", *AVR, "-std=gnu++11", "-Wall", "-Wextra", "-Werror", "-include", HERE / "arduino" / "Arduino.h", "-I",
            HERE / "arduino", "-I", LIBRARY.parent, "-x", "c++", "-c", sketch, "-o", folder / "sketch.o")
        names.append(sketch.stem)
    return ", ".join(names)


def check_host(folder: Path) -> str:
    for level in LEVELS:
        run(CC, *WARNINGS, f"-DGW_LEVEL={level}", HERE.parent / "examples/Host/host.c", LIBRARY, "-lm", "-o", folder / "host")
    return "examples/Host at each level"


def main() -> int:
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        for check in (compile_all, check_vectors, check_levels, check_random, check_host, check_sizes, check_sketches):
            try:
                print(f"{check.__name__}: {check(Path(name))}")
            except AssertionError as error:
                failed += 1
                print(f"{check.__name__}: FAILED\n  {error}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
