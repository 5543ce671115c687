"""Compares what the program computes on two machines: simulations, recordings and pictures must be the same bytes.

usage: linux.py X86_64-PROGRAM AARCH64-PROGRAM
"""

import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).parents[2]
CAPTURE = ROOT / "captures/house-noisy.txt"


def run(command, **options):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, timeout=600, **options)


def outputs(program, folder):
    """What one machine makes: names and contents."""
    folder.mkdir()
    trace = folder / "trace.csv"
    run([*program, "sim", "--seed", "11", "--listen", "127.0.0.1:0", "--duration", "120s", "--time-factor", "1000", "--trace", str(trace)])
    for form in ["mcap", "csv", "jsonl", "svg", "png"]:
        run([*program, "export", str(CAPTURE), "--to", form, "-o", str(folder / f"capture.{form}"), "--quiet"])
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def main():
    programs = [[sys.argv[1]], ["qemu-aarch64-static", sys.argv[2]]]
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        one, other = (outputs(program, work / str(index)) for index, program in enumerate(programs))
        assert one.keys() == other.keys() and len(one) == 6, (one.keys(), other.keys())
        for name in one:
            assert one[name], f"{name} is empty"
            assert one[name] == other[name], f"{name} differs between x86-64 and ARM"
            print(f"{name}: {len(one[name])} bytes, the same")
        # A static program needs nothing but the kernel.
        prison = work / "prison"
        prison.mkdir()
        (prison / "groundwave").write_bytes(pathlib.Path(sys.argv[1]).read_bytes())
        (prison / "groundwave").chmod(0o755)
        version = run(["chroot", str(prison), "/groundwave", "--version"]) if os.geteuid() == 0 else None
        print("alone in a folder:", version.stdout.decode().strip() if version else "skipped, chroot needs root")


main()
