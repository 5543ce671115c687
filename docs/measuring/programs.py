"""The measured programs, used as in their manuals."""

import os
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass

import line
import machine

GROUNDWAVE = os.path.join(machine.ROOT, "target", "release", "groundwave")


@dataclass(frozen=True)
class Contestant:
    """A program, and the parameters of its measurements."""

    name: str
    #: Its arguments, from the path of the serial line and the name of a new file.
    words: Callable[[str, str], list[str]]
    #: Feeder of the serial line; `None` for a program without one.
    feed: Callable[[line.SerialLine], None] | None
    #: Bytes that mark the first complete screen.
    first_paint: bytes
    #: The text on the screen that shows a packet; `None` for packets that it does not show.
    shown: Callable[[bytes], str | None] | None = None
    #: Keys typed once before the measurement.
    setup: bytes = b""
    #: Keys typed before each measured key.
    ahead: bytes = b""
    #: The measured key; empty if no key causes bytes on the line.
    key: bytes = b""
    #: Bytes that the answer to the key must contain; other bytes are unrelated.
    answer: bytes = b""
    #: Its version, and the reason for empty columns.
    version: tuple[str, ...] = ("--version",)
    remark: str = ""

    def is_here(self) -> bool:
        return shutil.which(self.words("", "")[0]) is not None


def _installed(name: str) -> str:
    """Path of a program in the Python environment, else in the system."""
    beside = os.path.join(os.path.dirname(sys.executable), name)
    return beside if os.path.exists(beside) else name


def our_line(packet: bytes) -> str | None:
    """The text of a robot's line as the dashboard shows it; `None` for acknowledgement lines."""
    return packet[:78].decode("ascii", "replace").rstrip() if packet[:1] in (b"A", b"B", b"C") and len(packet) > 70 else None


def _sentence(packet: bytes) -> str:
    return packet.decode("ascii").strip()


def _attitude(packet: bytes) -> str | None:
    """ATTITUDE is message 30; its first field is its time."""
    if packet[7] != 30:
        return None
    return f"time_boot_ms : {int.from_bytes(packet[10:14], 'little')},"


def _robot(serial: line.SerialLine) -> None:
    serial.robot(GROUNDWAVE)


OURS = (
    Contestant(
        "groundwave watch",
        lambda path, file: [GROUNDWAVE, "watch", path],
        _robot,
        b"motors",
        shown=our_line,
        key=b" ",
        remark="nothing is recorded; the key is STOP",
    ),
    Contestant(
        "groundwave watch --record",
        lambda path, file: [GROUNDWAVE, "watch", path, "--record", file + ".mcap"],
        _robot,
        b"motors",
        shown=our_line,
        key=b" ",
        remark="every byte is in a file before anything looks at it",
    ),
)

CONTESTANTS = (
    *OURS,
    Contestant(
        "MAVProxy",
        lambda path, file: [_installed("mavproxy.py"), f"--master={path}", "--baudrate=57600", f"--logfile={file}.tlog"],
        lambda serial: serial.packets(line.mavlink()),
        b"Connect",
        shown=_attitude,
        setup=b"watch ATTITUDE\n",
        ahead=b"disarm",
        key=b"\n",
        answer=rb"\xfd.{6}\x4c\x00\x00|\xfe.{4}\x4c",
        remark="records to tlog; `watch ATTITUDE` shows each packet; the key is Enter after `disarm`",
    ),
    Contestant(
        "gpsmon",
        lambda path, _: ["gpsmon", path],
        lambda serial: serial.packets(line.nmea()),
        b"NMEA0183>",
        shown=_sentence,
        version=("-V",),
        remark="records nothing; its first screen waits for the first packet; to a pseudo-terminal it sends nothing (`Raw send failed`)",
    ),
    Contestant(
        "picocom",
        lambda path, file: ["picocom", "--quiet", "--noinit", "--imap", "lfcrlf", "--logfile", file + ".txt", path],
        _robot,
        b"",
        shown=our_line,
        key=b"x",
        version=("--help",),
        remark="records raw; the bytes as they come and a key as it is pressed: the least that any program takes",
    ),
    Contestant(
        "btm",
        lambda _path, _file: [_installed("btm")],
        None,
        b"CPU",
        remark="draws once a second; it has no serial line",
    ),
)
