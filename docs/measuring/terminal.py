"""A program on a pseudo-terminal, its output with times, and its resources."""

import contextlib
import fcntl
import os
import pty
import select
import signal
import struct
import termios
import threading
import time

import machine

COLUMNS, ROWS = 120, 40
TICK_S = 0.02
#: Queries of programs, and the answers of a plain terminal; without an answer, programs would wait for seconds.
ANSWERS = {b"\x1b[c": b"\x1b[?62;22c", b"\x1b[6n": b"\x1b[1;1R"}


class Program:
    """Starts a program on a terminal of 120x40 or another size. A thread notes its output with times; a slow terminal
    reads a limited number of bytes per second."""

    def __init__(
        self,
        words: list[str],
        folder: str,
        environment: dict[str, str],
        first: bool = False,
        size: tuple[int, int] = (COLUMNS, ROWS),
        bytes_per_s: int = 0,
    ) -> None:
        self._bytes_per_s = bytes_per_s
        #: While this is set, the terminal reads nothing.
        self.is_stalled = threading.Event()
        wait, go = os.pipe()
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.environ.update({"TERM": "xterm-256color", "LANG": "C.UTF-8", **environment})
            if first:
                machine.give_precedence(os.getpid(), True)
            os.read(wait, 1)
            os.execvp(words[0], words)
        fcntl.ioctl(self.fd, termios.TIOCSWINSZ, struct.pack("HHHH", size[1], size[0], 0, 0))
        #: Times (seconds of the monotonic clock) and the output at them.
        self.written: list[tuple[float, bytes]] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        time.sleep(0.05)
        #: Time at which the program replaced the forked process.
        self.began = time.monotonic()
        os.write(go, b"!")
        os.close(wait)
        os.close(go)

    def _read(self) -> None:
        with contextlib.suppress(OSError):
            while data := os.read(self.fd, max(1, int(self._bytes_per_s * TICK_S)) if self._bytes_per_s else 65536):
                self.written.append((time.monotonic(), data))
                if self._bytes_per_s:
                    time.sleep(len(data) / self._bytes_per_s)
                while self.is_stalled.is_set():
                    time.sleep(TICK_S)
                for question, answer in ANSWERS.items():
                    if question in data:
                        os.write(self.fd, answer)

    def type(self, keys: bytes) -> float:
        """Presses keys; returns the time."""
        at = time.monotonic()
        os.write(self.fd, keys)
        return at

    def wait_for(self, text: bytes, patience_s: float = 30.0) -> float:
        """The time at which the output contained a text."""
        deadline = time.monotonic() + patience_s
        while time.monotonic() < deadline:
            so_far = b""
            for at, data in list(self.written):
                so_far += data
                if text in so_far:
                    return at
            time.sleep(TICK_S)
        tail = b"".join(data for _, data in self.written)[-300:]
        raise SystemExit(f"`{text.decode()}` was never written; the last was {tail!r}")

    def bytes_between(self, begin: float, end: float) -> int:
        return sum(len(data) for at, data in list(self.written) if begin <= at < end)

    def stop(self) -> None:
        """Ends the program, by a signal if it reacts to one."""
        for number in (signal.SIGTERM, signal.SIGKILL):
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)
            for _ in range(100):
                if os.waitpid(self.pid, os.WNOHANG)[0]:
                    with contextlib.suppress(OSError):
                        os.close(self.fd)
                    return
                time.sleep(TICK_S)


def wait_readable(fd: int, seconds: float) -> bool:
    return bool(select.select([fd], [], [], max(0.0, seconds))[0])
