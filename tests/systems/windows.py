"""Drives the program for Windows under Wine as a person would: dashboard, COM port, commands, recordings.

usage: windows.py WINDOWS-PROGRAM PROGRAM
PROGRAM is this system's: it simulates the robot behind the COM port. Needs wine and x86_64-w64-mingw32-gcc.
"""

import fcntl
import json
import os
import pathlib
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time

import wine as windows

CLOSE = pathlib.Path(__file__).with_name("close.c")

PATIENCE_S = 60


class Terminal:
    """The program on a terminal of 120 columns."""

    def __init__(self, wine, *words):
        self.master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
        self.seen = b""
        self.process = subprocess.Popen(
            [*wine, *words], stdin=slave, stdout=slave, stderr=slave, start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )
        os.close(slave)

    def wait_for(self, *patterns):
        """Reads until each pattern has been on the screen since the last call."""
        deadline = time.monotonic() + PATIENCE_S
        while not all(re.search(pattern, self.seen) for pattern in patterns):
            left = deadline - time.monotonic()
            assert left > 0 and select.select([self.master], [], [], left)[0], (patterns, self.seen[-3000:])
            try:
                self.seen += os.read(self.master, 65536)
            except OSError:
                raise AssertionError((patterns, self.seen[-3000:])) from None
        self.seen = b""

    def type(self, keys):
        os.write(self.master, keys)

    def read_for(self, seconds):
        deadline = time.monotonic() + seconds
        while (left := deadline - time.monotonic()) > 0:
            if select.select([self.master], [], [], left)[0]:
                os.read(self.master, 65536)

    def end(self):
        """The exit code; what the program still prints is read."""
        deadline = time.monotonic() + PATIENCE_S
        while self.process.poll() is None and time.monotonic() < deadline:
            if select.select([self.master], [], [], 0.1)[0]:
                try:
                    os.read(self.master, 65536)
                except OSError:
                    break
        return self.process.wait(PATIENCE_S)


def main():
    program, native = (str(pathlib.Path(word).resolve()) for word in sys.argv[1:3])
    with tempfile.TemporaryDirectory(prefix="groundwave-wine-") as folder:
        os.chdir(folder)
        os.environ["TERM"] = "xterm-256color"
        wine = ["wine", program]
        robot = subprocess.Popen([native, "sim", "--pty", "robot"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            prepare(wine, pathlib.Path(folder))
            for check in [a_demo, a_com_port, recordings, closed_windows, killed_recordings, a_network, what_is_not_there]:
                check(wine)
                print(check.__name__.replace("_", " "), "ok", flush=True)
        finally:
            robot.kill()
            subprocess.run(["wineserver", "-k"])


def prepare(wine, folder):
    windows.choose(folder / "prefix")
    windows.compile_c(CLOSE.read_text(), "close.exe")
    port = os.path.realpath("robot")
    subprocess.run(
        ["wine", "reg", "add", r"HKLM\Software\Wine\Ports", "/v", "COM3", "/d", port, "/f"],
        check=True, stdout=subprocess.DEVNULL,
    )
    subprocess.run(["wineserver", "-w"])
    assert "COM3" in run(wine, "ports")


def run(wine, *words, code=0):
    done = subprocess.run([*wine, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=PATIENCE_S)
    text = done.stdout.decode(errors="replace")
    assert done.returncode == code, (words, done.returncode, text)
    return text


def a_demo(wine):
    drive(wine, "demo")


def a_com_port(wine):
    assert "confirmed" in run(wine, "send", "COM3", "mode", "prowl")
    drive(wine, "watch", "COM3")
    assert "confirmed" in run(wine, "send", "COM3", "stop")
    assert "COM9" in run(wine, "send", "COM9", "stop", code=4)


def drive(wine, *words):
    """Opens a dashboard, stops the robot with the space bar and leaves; the recording tells whether the robot obeyed."""
    name = f"{words[0]}.mcap"
    terminal = Terminal(wine, *words, "--record", name)
    terminal.wait_for(rb"HOLDS")
    terminal.type(b" ")
    terminal.read_for(5)
    terminal.type(b"q")
    assert terminal.end() == 0
    assert "good" in run(wine, "verify", name)
    run(wine, "export", name, "--to", "jsonl", "-o", f"{name}.jsonl")
    events = [json.loads(line) for line in pathlib.Path(f"{name}.jsonl").read_text().splitlines()]
    commands = [event for event in events if event.get("event") == "command"]
    stops = [event["command_id"] for event in commands if event.get("command") == "stop"]
    statuses = [event["status"] for event in commands if event["command_id"] in stops]
    assert statuses and statuses[-1] == "confirmed", commands


def recordings(wine):
    run(wine, "record", "COM3", "-o", "a.mcap", "--duration", "5s")
    assert "good" in run(wine, "verify", "a.mcap")
    run(wine, "export", "a.mcap", "--to", "csv", "-o", "a.csv")
    assert pathlib.Path("a.csv").read_text().count("\n") > 5
    terminal = Terminal(wine, "record", "COM3", "-o", "key.mcap")
    wait_for_size("key.mcap", 20_000)
    terminal.type(b"\x03")
    assert terminal.end() == 0
    assert "good" in run(wine, "verify", "key.mcap")


def wait_for_size(name, size):
    deadline = time.monotonic() + PATIENCE_S
    while not pathlib.Path(name).exists() or pathlib.Path(name).stat().st_size < size:
        assert time.monotonic() < deadline, name
        time.sleep(0.1)


def closed_windows(wine):
    # Wine tells a program nothing of a closed window, so close.exe does as Windows does.
    for words in [("record", "COM3", "-o", "closed.mcap"), ("watch", "COM3", "--record", "screen.mcap")]:
        terminal = Terminal([wine[0], "close.exe", wine[1]], *words)
        wait_for_size(words[-1], 20_000)
        pathlib.Path("close").touch()
        assert terminal.end() == 0
        assert pathlib.Path("closed").read_text() == "0", words
        pathlib.Path("close").unlink()
        assert "good" in run(wine, "verify", words[-1])


def killed_recordings(wine):
    # A terminal that goes away kills the program under Wine.
    for name, kill in [("gone.mcap", lambda victim: os.close(victim.master)), ("killed.mcap", lambda _: subprocess.run(["wineserver", "-k"]))]:
        victim = Terminal(wine, "record", "COM3", "-o", name)
        wait_for_size(name, 20_000)
        kill(victim)
        victim.process.wait(PATIENCE_S)
        assert "recovered" in run(wine, "recover", name)
        assert "good" in run(wine, "verify", name)


def a_network(wine):
    simulator = subprocess.Popen([*wine, "sim", "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    address = simulator.stdout.readline().decode().strip()
    assert address.startswith("tcp:"), address
    try:
        assert "confirmed" in run(wine, "send", address, "mode", "prowl")
        terminal = Terminal(wine, "record", address, "-o", "b.mcap", "--duration", "3s")
        assert terminal.end() == 0
        assert "good" in run(wine, "verify", "b.mcap")
    finally:
        simulator.send_signal(signal.SIGKILL)


def what_is_not_there(wine):
    assert "--listen" in run(wine, "sim", "--pty", "robot", code=2)
    assert "Unix sockets" in run(wine, "watch", "unix:robot.sock", "--headless", code=4)


main()
