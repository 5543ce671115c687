"""Wine with the library that it lacks.

usage: wine.py WINDOWS-PROGRAM [ARGUMENT ...]   runs a program; cargo's runner for tests
"""

import os
import pathlib
import subprocess
import sys

PREFIX = pathlib.Path(__file__).parents[2] / "target/wine"

# Wine 8 lacks the library of random numbers that Rust's standard library uses.
RANDOM = """
#include <windows.h>
BOOLEAN NTAPI SystemFunction036(PVOID, ULONG);
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE bytes, SIZE_T count) { return SystemFunction036(bytes, (ULONG)count); }
"""


def choose(prefix):
    """Makes Windows in a folder, if it is not there yet, for the programs that start later."""
    os.environ.update(WINEPREFIX=str(prefix), WINEDEBUG="-all")
    library = prefix / "drive_c/windows/system32/bcryptprimitives.dll"
    if not library.exists():
        prefix.mkdir(parents=True, exist_ok=True)
        subprocess.run(["wineboot", "-i"], check=True, timeout=300, stderr=subprocess.DEVNULL)
        compile_c(RANDOM, library, "-shared", "-ladvapi32")


def compile_c(code, program, *options):
    """Compiles C for Windows."""
    command = ["x86_64-w64-mingw32-gcc", "-O2", "-x", "c", "-", "-o", str(program), *options]
    subprocess.run(command, input=code.encode(), check=True)


def main():
    choose(PREFIX)
    sys.exit(subprocess.run(["wine", *sys.argv[1:]]).returncode)


if __name__ == "__main__":
    main()
