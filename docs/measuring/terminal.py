"""A program on a terminal of its own: what it writes, when, and what it takes."""

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
#: What terminals are asked, and a plain one says: who waits for that would wait for seconds.
ANSWERS = {b"\x1b[c": b"\x1b[?62;22c", b"\x1b[6n": b"\x1b[1;1R"}


class Program:
    """Started on a terminal of 120x40 or another size. A thread notes everything it writes with the moment at which it came; of a
    slow terminal it takes so many bytes a second."""

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
        #: While it is set the terminal takes nothing.
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
        #: Moments (seconds of the monotonic clock) and what came then.
        self.written: list[tuple[float, bytes]] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        time.sleep(0.05)
        #: When it took the place of the process that was forked for it.
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
        """Presses keys; returns when."""
        at = time.monotonic()
        os.write(self.fd, keys)
        return at

    def wait_for(self, text: bytes, patience_s: float = 30.0) -> float:
        """The moment at which it had written this."""
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
        """Ends it, in good order if it listens to that."""
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
