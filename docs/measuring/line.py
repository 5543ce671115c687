"""A serial line on a pseudo-terminal, with three packets per second."""

import contextlib
import math
import os
import pty
import subprocess
import threading
import time
import tty
from collections.abc import Iterator

from terminal import wait_readable

#: Interval at which a USB adapter delivers bytes; at 2400 baud four arrive in that time.
CLUMP_S, CLUMP_BYTES = 0.016, 4
PACKETS_PER_S = 3


class SerialLine:
    """A program opens `path`; the bytes that it sends are noted with their times."""

    def __init__(self) -> None:
        self._fd, self._other = pty.openpty()
        tty.setraw(self._other)
        self.path = os.ttyname(self._other)
        #: Packets sent completely, with the time of their last byte.
        self.sent: list[tuple[float, bytes]] = []
        #: Bytes sent by the program, with their times.
        self.received: list[tuple[float, bytes]] = []
        self.is_silent = threading.Event()
        self._is_over = threading.Event()
        self._threads: list[threading.Thread] = []

    def robot(self, program: str) -> None:
        """A simulated robot at the other end, which receives the program's bytes."""
        sim = subprocess.Popen([program, "sim"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        robot = os.open(sim.stdout.readline().strip(), os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(robot)
        self._run(self._relay, robot, sim)
        self._run(self._hear, robot)

    def packets(self, packets: Iterator[bytes]) -> None:
        """Given packets; the program's bytes are ignored."""
        self._run(self._pace, packets)
        self._run(self._hear, None)

    def end(self) -> None:
        """Waits until the robot has ended, because a running one would disturb the next measurement."""
        self._is_over.set()
        for thread in self._threads:
            thread.join()

    def _run(self, target, *arguments) -> None:
        thread = threading.Thread(target=target, args=arguments, daemon=True)
        thread.start()
        self._threads.append(thread)

    def _write(self, data: bytes) -> float:
        at = time.monotonic()
        with contextlib.suppress(OSError):
            os.write(self._fd, data)
        return at

    def _relay(self, robot: int, sim: subprocess.Popen) -> None:
        line, data, at = b"", b"", 0.0
        while not self._is_over.wait(CLUMP_S):
            # Written bytes are noted a bunch later, because the system delivers them while this thread sleeps.
            *whole, line = (line + data).split(b"\n")
            self.sent += [(at, packet) for packet in whole]
            data = b""
            with contextlib.suppress(BlockingIOError):
                data = os.read(robot, 4096)
            if self.is_silent.is_set():
                data = b""
            if data:
                at = self._write(data)
        sim.terminate()
        sim.wait()

    def _pace(self, packets: Iterator[bytes]) -> None:
        due = time.monotonic()
        for packet in packets:
            due = max(due + 1 / PACKETS_PER_S, time.monotonic())
            for place in range(0, len(packet), CLUMP_BYTES):
                at = self._write(packet[place : place + CLUMP_BYTES])
                if self._is_over.wait(CLUMP_S):
                    return
            self.sent.append((at, packet))
            if self._is_over.wait(max(0.0, due - time.monotonic())):
                return

    def _hear(self, robot: int | None) -> None:
        while not self._is_over.is_set():
            if not wait_readable(self._fd, 0.2):
                continue
            with contextlib.suppress(OSError):
                data = os.read(self._fd, 4096)
                self.received.append((time.monotonic(), data))
                if robot is not None:
                    os.write(robot, data)


def nmea() -> Iterator[bytes]:
    """A receiver at rest that sends the sentences GGA, RMC and GLL in turn."""
    begin = time.monotonic()
    count = 0
    while True:
        now = int(time.monotonic() - begin) + 3600
        clock = f"{now // 3600 % 24:02}{now // 60 % 60:02}{now % 60:02}.{count % 100:02}"
        body = (
            f"GPGGA,{clock},4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
            f"GPRMC,{clock},A,4807.038,N,01131.000,E,000.0,000.0,221126,003.1,W,A",
            f"GPGLL,4807.038,N,01131.000,E,{clock},A,A",
        )[count % 3]
        count += 1
        sum_of_bytes = 0
        for character in body.encode():
            sum_of_bytes ^= character
        yield f"${body}*{sum_of_bytes:02X}\r\n".encode()


def mavlink() -> Iterator[bytes]:
    """A vehicle that rolls: ATTITUDE twice, HEARTBEAT once in three packets."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect  # installed for `--beside` alone

    vehicle = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    count = 0
    while True:
        if count % 3 == 0:
            message = vehicle.heartbeat_encode(dialect.MAV_TYPE_GROUND_ROVER, dialect.MAV_AUTOPILOT_ARDUPILOTMEGA, 81, 0, 3)
        else:
            angle = math.sin(count / 10)
            message = vehicle.attitude_encode(1000 + count, angle, -angle, 0.5, 0.0, 0.0, 0.0)
        count += 1
        yield bytes(message.pack(vehicle))
