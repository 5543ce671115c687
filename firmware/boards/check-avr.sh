#!/usr/bin/env bash
# Links the robot's program for an ATmega2560 and prints its size. Fails if state and buffers take too much of the
# chip's RAM, or if the program contains core::fmt, which this target miscompiles.
#
# Needs Debian's rustc-web cargo-web rust-web-src gcc-avr binutils-avr avr-libc, or RUSTC and CARGO_AVR set to another
# compiler with rust-src for `-Zbuild-std` (a nightly).
set -euo pipefail

ram_max=6144
cd "$(dirname "$0")/probe"

export PATH=/usr/bin:$PATH RUSTC=${RUSTC:-/usr/bin/rustc} RUSTC_BOOTSTRAP=1
unset RUSTFLAGS CARGO_ENCODED_RUSTFLAGS CARGO_BUILD_TARGET RUSTC_WORKSPACE_WRAPPER RUSTC_WRAPPER
"${CARGO_AVR:-/usr/bin/cargo}" build --release --locked --target-dir target
elf=target/avr-none/release/probe.elf

avr-size -A "$elf"
ram=$(avr-size -A "$elf" | awk '$1 == ".data" || $1 == ".bss" || $1 == ".noinit" { sum += $2 } END { print sum }')
flash=$(avr-size -A "$elf" | awk '$1 == ".data" || $1 == ".text" { sum += $2 } END { print sum }')
echo "flash $flash of 262144 bytes, RAM for state and buffers $ram of 8192 bytes (at most $ram_max)"

failed=0
if [ "$ram" -gt "$ram_max" ]; then
    echo "check-avr: state and buffers take $ram bytes of RAM, $((ram - ram_max)) too many:" \
        "'avr-nm --size-sort -S $PWD/$elf' names the largest" >&2
    failed=1
fi
if symbols=$(avr-nm "$elf" | grep core3fmt); then
    echo "check-avr: the program contains core::fmt: look for format strings, unwrap on a Result, and" \
        "panics with arguments" >&2
    echo "$symbols" >&2
    failed=1
fi
exit $failed
