"""The machine: its description, the resources of a process, and artificial load."""

import contextlib
import gc
import os
import platform
import subprocess
import sys

TICKS_PER_S = os.sysconf("SC_CLK_TCK")
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


def describe() -> str:
    """Processor, cores, memory, system and other load, in one line."""
    with open("/proc/cpuinfo", encoding="utf-8") as lines:
        models = {line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")}
    with open("/proc/meminfo", encoding="ascii") as lines:
        memory_gib = int(next(lines).split()[1]) / 2**20
    with open("/etc/os-release", encoding="utf-8") as lines:
        system = next((line.split("=", 1)[1].strip().strip('"') for line in lines if line.startswith("PRETTY_NAME")), "Linux")
    load = os.getloadavg()[0]
    return (
        f"{os.cpu_count()} cores ({', '.join(sorted(models)) or 'unknown'}), {memory_gib:.0f} GiB, {system}, "
        f"Linux {platform.release()}, Python {platform.python_version()}, load {load:.1f} at the beginning"
    )


def commit() -> str:
    """The current commit, marked if files differ from it."""
    words = ["git", "describe", "--always", "--dirty", "--exclude=*"]
    return subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip() or "unknown"


def be_prompt() -> bool:
    """Raises the priority of this script above the measured programs, and switches garbage collection off, so that
    times do not include its own delays."""
    gc.disable()
    sys.setswitchinterval(1e-4)
    try:
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(1))
    except PermissionError:
        return False
    return True


def give_precedence(pid: int, is_given: bool) -> None:
    """Raises or restores the priority of all threads of a process, as if the machine were idle."""
    policy, priority = (os.SCHED_RR, 1) if is_given else (os.SCHED_OTHER, 0)
    for member in family(pid):
        for task in _tasks(member):
            with contextlib.suppress(OSError):
                os.sched_setscheduler(int(task), policy, os.sched_param(priority))


def family(pid: int) -> list[int]:
    """A process and its descendants."""
    found = [pid]
    for parent in found:
        for task in _tasks(parent):
            with contextlib.suppress(OSError), open(f"/proc/{parent}/task/{task}/children", encoding="ascii") as children:
                found += [int(child) for child in children.read().split()]
    return found


def cpu_s(pid: int) -> float:
    """CPU seconds of a process and its children; to the nanosecond if the system counts them."""
    return sum(_cpu_s(member) for member in family(pid))


def resident_mib(pid: int) -> float:
    return sum(_status(member, "VmRSS") for member in family(pid)) / 1024


def threads(pid: int) -> int:
    return sum(_status(member, "Threads") for member in family(pid))


@contextlib.contextmanager
def every_core_busy():
    """A busy process on each core."""
    spin = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for process in spin:
            process.kill()
            process.wait()


def _tasks(pid: int) -> list[str]:
    with contextlib.suppress(OSError):
        return os.listdir(f"/proc/{pid}/task")
    return []


def _cpu_s(pid: int) -> float:
    with contextlib.suppress(OSError):
        total_ns = 0
        for task in _tasks(pid):
            with open(f"/proc/{pid}/task/{task}/schedstat", encoding="ascii") as stat:
                total_ns += int(stat.read().split()[0])
        return total_ns / 1e9
    with open(f"/proc/{pid}/stat", encoding="ascii") as stat:
        fields = stat.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_S


def _status(pid: int, key: str) -> int:
    with contextlib.suppress(OSError), open(f"/proc/{pid}/status", encoding="ascii") as status:
        return next((int(line.split()[1]) for line in status if line.startswith(key + ":")), 0)
    return 0
