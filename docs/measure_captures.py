#!/usr/bin/env python3
"""Time, CPU and peak memory of the tools on captures of a day and of a month.

    cargo build --release
    python3 -m venv /tmp/measuring && /tmp/measuring/bin/pip install mcap==1.6.0
    /tmp/measuring/bin/python docs/measure_captures.py [--month]

Linux only. The simulator makes the day: 86,400 s of prowling in the default house, 259,200 lines. The month is the
day 30 times, so that figures grow with the length alone. Each figure is that of the fastest of three runs. If the
Python package `mcap` is installed, its writer also writes the messages of the day, in turn with `export --to mcap`, so that
both run under the same conditions.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time

try:
    from mcap.reader import NonSeekingReader
    from mcap.writer import CompressionType, Writer
except ImportError:
    Writer = None

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
PROGRAM = os.path.join(ROOT, "target", "release", "groundwave")
DAY_S = 86_400
DAYS_OF_A_MONTH = 30


def measure(*words):
    """Wall seconds, CPU seconds and peak memory in MB of a run of the program."""
    began = time.monotonic()
    peak_kb = 0
    with tempfile.TemporaryFile() as complaints:
        process = subprocess.Popen([PROGRAM, *words], stdout=subprocess.DEVNULL, stderr=complaints)
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid != 0:
                break
            # The system's final figure includes the memory of this script, from which the process was forked.
            peak_kb = max(peak_kb, memory_kb(process.pid))
            time.sleep(0.005)
        took_s = time.monotonic() - began
        complaints.seek(0)
        if os.waitstatus_to_exitcode(status) != 0:
            raise SystemExit(f"{words}: {complaints.read().decode()}")
    return took_s, usage.ru_utime + usage.ru_stime, peak_kb / 1024


def memory_kb(pid):
    """Peak memory of a process so far, once it runs the program."""
    with open(f"/proc/{pid}/status") as file:
        lines = dict(line.split(":", 1) for line in file)
    has_begun = lines["Name"].strip() == os.path.basename(PROGRAM)
    return int(lines["VmHWM"].split()[0]) if has_begun and "VmHWM" in lines else 0


def table(folder, raw):
    mcap = os.path.join(folder, "a.mcap")
    runs = [
        ("`export`, MCAP", ["export", raw, "--to", "mcap", "-o", mcap, "-q", "--force"]),
        ("`export`, raw", ["export", mcap, "--to", "raw", "-o", os.path.join(folder, "b.txt"), "-q", "--force"]),
        ("`verify`, raw", ["verify", raw]),
        ("`verify`, MCAP against its raw file", ["verify", mcap, "--raw", raw]),
        ("`info`, MCAP", ["info", mcap]),
        ("`export`, CSV", ["export", mcap, "--to", "csv", "-o", os.path.join(folder, "a.csv"), "-q", "--force"]),
        ("`export`, JSON lines", ["export", mcap, "--to", "jsonl", "-o", os.path.join(folder, "a.jsonl"), "-q", "--force"]),
        ("`export`, SVG", ["export", mcap, "--to", "svg", "-o", os.path.join(folder, "a.svg"), "-q", "--force"]),
        ("`export`, PNG", ["export", mcap, "--to", "png", "-o", os.path.join(folder, "a.png"), "-q", "--force"]),
        ("`cut`, an hour of it", ["cut", mcap, "--from", "6h", "--to", "7h", "-o", os.path.join(folder, "c.mcap"), "-q", "--force"]),
    ]
    size = f"{os.path.getsize(raw) / 1e6:.1f} MB raw"
    print(f"| {size} | s | CPU s | peak MB |\n|---|---|---|---|")
    for name, words in runs:
        took_s, cpu_s, peak_mb = min(measure(*words) for _ in range(3))
        print(f"| {name} | {took_s:.2f} | {cpu_s:.2f} | {peak_mb:.0f} |", flush=True)
    print(f"\nThe MCAP has {os.path.getsize(mcap) / 1e6:.1f} MB.\n")


def beside_python(folder, raw):
    """CPU per message of `export --to mcap`, which decodes, derives and compresses, and of Python's writer, which gets the
    same messages already encoded."""
    ours, theirs = os.path.join(folder, "a.mcap"), os.path.join(folder, "python.mcap")
    convert = ["export", raw, "--to", "mcap", "-o", ours, "-q", "--force"]
    measure(*convert)
    with open(ours, "rb") as file:
        messages = [
            (schema, channel, message.log_time, message.data, message.publish_time, message.sequence)
            for schema, channel, message in NonSeekingReader(file).iter_messages(log_time_order=False)
        ]
    runs = [(measure(*convert)[1], write_by_python(theirs, messages)) for _ in range(3)]
    ours_us, theirs_us = (min(cpu_s) * 1e6 / len(messages) for cpu_s in zip(*runs))
    print(f"{len(messages):,} messages: `export --to mcap` takes {ours_us:.3f} us of CPU each, Python's writer {theirs_us:.2f} us.")
    print(f"{theirs_us / ours_us:.1f} times as much; {os.path.getsize(theirs) / 1e6:.1f} MB.\n", flush=True)


def write_by_python(path, messages):
    """CPU seconds."""
    began = time.process_time()
    with open(path, "wb") as file:
        writer = Writer(file, chunk_size=1 << 20, compression=CompressionType.ZSTD)
        writer.start()
        schemas, channels = {}, {}
        for schema, channel, log_time, data, publish_time, sequence in messages:
            if channel.id not in channels:
                if schema.id not in schemas:
                    schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.id]
                )
            writer.add_message(channels[channel.id], log_time, data, publish_time, sequence)
        writer.finish()
    return time.process_time() - began


def main():
    with tempfile.TemporaryDirectory() as folder:
        day = os.path.join(folder, "day.txt")
        with open(day, "wb") as file:
            simulate = ["cargo", "run", "--release", "--quiet", "-p", "sr04-sim", "--example", "capture"]
            subprocess.run([*simulate, "--", "house", "1", str(DAY_S)], stdout=file, cwd=ROOT, check=True)
        table(folder, day)
        if Writer is not None:
            beside_python(folder, day)
        if "--month" in sys.argv:
            month = os.path.join(folder, "month.txt")
            with open(month, "wb") as to:
                for _ in range(DAYS_OF_A_MONTH):
                    with open(day, "rb") as file:
                        shutil.copyfileobj(file, to)
            table(folder, month)


if __name__ == "__main__":
    main()
