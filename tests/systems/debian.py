"""Installs the Debian packages in a new Debian and uses the program there.

usage: debian.py AMD64-PACKAGE ARM64-PACKAGE
Needs root, debootstrap and qemu-user-static.
"""

import contextlib
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

UNIT = "usr/lib/systemd/user/groundwave@.service"
PLACES = [
    "usr/bin/groundwave",
    "usr/share/man/man1/groundwave-send.1.gz",
    "usr/share/bash-completion/completions/groundwave",
    "usr/lib/udev/rules.d/60-groundwave.rules",
    UNIT,
    "usr/share/doc/groundwave/copyright",
]
PATIENCE_S = 60


class Debian:
    """A Debian in a folder, and the words before each program that is not of this machine."""

    def __init__(self, root):
        self.root = root
        self.emulator = []

    def command(self, *words):
        environment = ["env", "-i", "HOME=/root", "PATH=/usr/sbin:/usr/bin:/sbin:/bin"]
        return ["chroot", str(self.root), *environment, *words]

    def run(self, *words, code=0):
        done = subprocess.run(self.command(*words), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300)
        text = done.stdout.decode()
        assert done.returncode == code, (words, done.returncode, text)
        return text

    def groundwave(self, *words):
        return self.run(*self.emulator, "/usr/bin/groundwave", *words)

    @contextlib.contextmanager
    def background(self, *words):
        process = subprocess.Popen(self.command(*words), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def install(debian, package):
    shutil.copy(package, debian.root / "groundwave.deb")
    debian.run("apt-get", "install", "-qq", "-y", "/groundwave.deb")
    for place in PLACES:
        assert (debian.root / place).is_file(), place


def use(debian):
    """A robot, a command, a recording and a table of it."""
    with debian.background(*debian.emulator, "/usr/bin/groundwave", "sim", "--listen", "127.0.0.1:0") as robot:
        address = robot.stdout.readline().decode().strip()
        assert address.startswith("tcp:"), address
        assert "confirmed" in debian.groundwave("send", address, "mode", "prowl")
        debian.groundwave("record", address, "-o", "/root/a.mcap", "--duration", "5s")
        assert "good" in debian.groundwave("verify", "/root/a.mcap")
        debian.groundwave("export", "/root/a.mcap", "--to", "csv", "-o", "/root/a.csv")
        assert (debian.root / "root/a.csv").read_text().count("\n") > 5
        if not debian.emulator:
            use_unit(debian, address)
    for name in ["a.mcap", "a.csv"]:
        (debian.root / "root" / name).unlink()


def use_unit(debian, address):
    """Runs the commands of the systemd unit: it records, sends for others, and ends cleanly when told to."""
    lines = (debian.root / UNIT).read_text().splitlines()
    commands = dict(line.split("=", 1) for line in lines if line.startswith("Exec"))
    prepare, start = (shlex.split(commands[key].replace("%h", "/root").replace("%i", address)) for key in ["ExecStartPre", "ExecStart"])
    debian.run(*prepare)
    with debian.background(*start) as recorder:
        deadline = time.monotonic() + PATIENCE_S
        while subprocess.run(debian.command("groundwave", "send", "--via", "stop"), capture_output=True).returncode != 0:
            assert time.monotonic() < deadline and recorder.poll() is None, "no command through the recorder"
            time.sleep(0.2)
        recorder.terminate()
        assert recorder.wait(PATIENCE_S) == 0
    recordings = [path.relative_to(debian.root) for path in (debian.root / "root/groundwave").glob("*.mcap")]
    assert len(recordings) == 1, recordings
    assert "good" in debian.groundwave("verify", f"/{recordings[0]}")


def main():
    amd64, arm64 = sys.argv[1:3]
    with tempfile.TemporaryDirectory(prefix="groundwave-debian-") as folder:
        subprocess.run(["debootstrap", "--variant=minbase", "bookworm", folder], check=True, stdout=subprocess.DEVNULL)
        debian = Debian(pathlib.Path(folder))
        install(debian, amd64)
        use(debian)
        debian.run("apt-get", "purge", "-qq", "-y", "groundwave")
        assert not any((debian.root / place).exists() for place in PLACES)
        print("amd64 package: installed, used, removed", flush=True)
        shutil.copy(shutil.which("qemu-aarch64-static"), debian.root)
        debian.emulator = ["/qemu-aarch64-static"]
        debian.run("dpkg", "--add-architecture", "arm64")
        install(debian, arm64)
        use(debian)
        print("arm64 package: installed, used", flush=True)


main()
