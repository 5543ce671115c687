#!/usr/bin/env python3
"""What `groundwave watch` costs: CPU, memory, bytes to the terminal, time to the first frame.

    cargo build --release && python3 docs/measure.py [SECONDS]

Linux only. Starts a simulated robot in a process of its own and a dashboard at 120x40 that records, hands the radio's bytes
over in clumps of 16 ms as a USB adapter does, and reads /proc. What the machine itself takes is measured beside it: a
`cat` of the same clumps and a start of `groundwave --version`. Where those are dear, so is everything.
"""

import fcntl
import os
import pty
import select
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time

PROGRAM = os.path.join(os.path.dirname(__file__), "..", "target", "release", "groundwave")
CLUMP_S = 0.016
STARTS = 9
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def relay(robot: str, listener: socket.socket, silent: threading.Event) -> None:
    """Passes the robot's bytes on in clumps; a silent radio passes nothing."""
    client, _ = listener.accept()
    fd = os.open(robot, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
    while True:
        time.sleep(CLUMP_S)
        try:
            data = os.read(fd, 4096)
        except BlockingIOError:
            continue
        if data and not silent.is_set():
            try:
                client.sendall(data)
            except OSError:
                return


def cpu_s(pid: int) -> float:
    with open(f"/proc/{pid}/stat", encoding="ascii") as stat:
        fields = stat.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_S


def status_kib(pid: int, key: str) -> int:
    with open(f"/proc/{pid}/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith(key))


def drain(fd: int, seconds: float) -> int:
    """Reads what the dashboard writes; returns how many bytes it was."""
    total, end = 0, time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        if select.select([fd], [], [], left)[0]:
            total += len(os.read(fd, 65536))
    return total


def start(robot: str, folder: str, silent: threading.Event) -> tuple[int, int, float]:
    """A dashboard on a radio of its own: its process, its terminal, milliseconds until its first frame."""
    listener = socket.create_server(("127.0.0.1", 0))
    threading.Thread(target=relay, args=(robot, listener, silent), daemon=True).start()
    link = f"tcp:127.0.0.1:{listener.getsockname()[1]}"
    began = time.monotonic()
    pid, fd = pty.fork()
    if pid == 0:
        os.environ.update(TERM="xterm-256color", LANG="C.UTF-8", LINES="40", COLUMNS="120")
        time.sleep(0.1)
        os.execv(PROGRAM, [PROGRAM, "watch", link, "--record", os.path.join(folder, "run.mcap"), "--force"])
    fcntl.ioctl(fd, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
    seen = b""
    while b"motors" not in seen:
        seen += os.read(fd, 65536)
    return pid, fd, (time.monotonic() - began - 0.1) * 1000


def cat(robot: str, silent: threading.Event, seconds: float) -> float:
    """Per cent of a core that `cat` takes for the same clumps: the least that any reader takes."""
    listener = socket.create_server(("127.0.0.1", 0))
    threading.Thread(target=relay, args=(robot, listener, silent), daemon=True).start()
    with socket.create_connection(listener.getsockname()) as radio:
        process = subprocess.Popen(["cat"], stdin=radio, stdout=subprocess.DEVNULL)
        before = cpu_s(process.pid)
        time.sleep(seconds)
        used_s = cpu_s(process.pid) - before
        process.kill()
        process.wait()
    return used_s / seconds * 100


def bare_start_ms() -> float:
    """Milliseconds to start the program, say its version and leave: the median of some."""
    times = []
    for _ in range(STARTS):
        began = time.monotonic()
        subprocess.run([PROGRAM, "--version"], stdout=subprocess.DEVNULL, check=True)
        times.append((time.monotonic() - began) * 1000)
    return sorted(times)[STARTS // 2]


def stop(pid: int, fd: int) -> None:
    os.kill(pid, 15)
    os.close(fd)
    os.waitpid(pid, 0)


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 30.0
    folder = tempfile.mkdtemp()
    sim = subprocess.Popen([PROGRAM, "sim"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    robot = sim.stdout.readline().strip()
    silent = threading.Event()
    print(f"cat of the same      {cat(robot, silent, seconds):8.2f} % of a core")
    print(f"bare start           {bare_start_ms():8.1f} ms")
    firsts = []
    for _ in range(STARTS):
        pid, fd, first_ms = start(robot, folder, silent)
        stop(pid, fd)
        firsts.append(first_ms)
    print(f"first frame          {sorted(firsts)[STARTS // 2]:8.1f} ms after exec, median of {STARTS}")
    pid, fd, _ = start(robot, folder, silent)

    drain(fd, 5.0)
    before = cpu_s(pid)
    written = drain(fd, seconds)
    print(f"3 lines/s, 120x40    {(cpu_s(pid) - before) / seconds * 100:8.2f} % of a core")
    print(f"to the terminal      {written / seconds / 1000:8.2f} kB/s")
    print(f"resident, recording  {status_kib(pid, 'VmRSS') / 1024:8.1f} MiB, {status_kib(pid, 'Threads')} threads")

    silent.set()
    drain(fd, 65.0)
    before = cpu_s(pid)
    written = drain(fd, seconds)
    print(f"silent for a minute  {(cpu_s(pid) - before) / seconds * 100:8.2f} % of a core, {written / seconds:.0f} bytes/s")
    stop(pid, fd)
    sim.terminate()
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
