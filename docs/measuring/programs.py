"""The programs that are measured, each as its own manual says it is used."""

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
    """A program and how its times are taken."""

    name: str
    #: Its words, for the path of the serial line and the name of a new file.
    words: Callable[[str, str], list[str]]
    #: What comes down the line; `None` for a program that has none.
    feed: Callable[[line.SerialLine], None] | None
    #: Written when its first screen is there.
    first_paint: bytes
    #: The text on the screen that shows a packet; `None` for packets that it does not show.
    shown: Callable[[bytes], str | None] | None = None
    #: Typed once before the times are taken.
    setup: bytes = b""
    #: Typed ahead of the key whose time is taken.
    ahead: bytes = b""
    #: The key whose time is taken; none where no key leads to the line.
    key: bytes = b""
    #: What has to be in the bytes that answer the key; other bytes come by themselves.
    answer: bytes = b""
    #: How its version is told, and why a column is empty.
    version: tuple[str, ...] = ("--version",)
    remark: str = ""

    def is_here(self) -> bool:
        return shutil.which(self.words("", "")[0]) is not None


def _installed(name: str) -> str:
    """A program of the environment that runs this, or of the system."""
    beside = os.path.join(os.path.dirname(sys.executable), name)
    return beside if os.path.exists(beside) else name


def our_line(packet: bytes) -> str | None:
    """The line of the robot that the dashboard shows as it came; acknowledgements have none."""
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
