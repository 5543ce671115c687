//! The robot's program for an `ATmega2560`: linked, measured, and searched for the faults of its compiler.
//!
//! Needs Debian's gcc-avr, binutils-avr and avr-libc, in addition to its compiler.

use std::path::Path;
use std::process::Command;

use crate::{capture, debian, root};

mod listing;
mod lost_product;

/// Flash of the chip in bytes.
const FLASH: usize = 256 << 10;

/// RAM of the chip in bytes.
const RAM: usize = 8 << 10;

/// Maximum RAM for state and buffers, bytes; the rest is for the stack.
const STATIC_MAX: usize = 6 << 10;

/// Builds the probe and checks its program.
pub(crate) fn check() -> Result<(), String> {
    let probe = root().join("firmware/boards/probe");
    debian::build(&probe)?;
    check_program(&debian::boards().join("avr-none/release/probe.elf"))
}

/// Prints the program's sizes and searches it for faults.
pub(crate) fn check_program(elf: &Path) -> Result<(), String> {
    let sizes = output("avr-size", &["-A"], elf)?;
    let section = |name: &str| size_of_section(&sizes, name);
    let flash = section(".text") + section(".data");
    let ram = section(".data") + section(".bss") + section(".noinit");
    let program = listing::parse(&output("avr-objdump", &["--disassemble"], elf)?);
    let found = lost_product::find(&program);
    println!(
        "flash {flash} of {FLASH} bytes, RAM for state and buffers {ram} of {RAM} bytes (at most {STATIC_MAX}), {} saves of the status register in r0, {} lost products",
        found.saves,
        found.faults.len()
    );
    if ram > STATIC_MAX {
        return Err(format!(
            "state and buffers take {ram} bytes of RAM, {} too many: `avr-nm --size-sort -S {}` names the largest",
            ram - STATIC_MAX,
            elf.display()
        ));
    }
    if !found.faults.is_empty() {
        return Err(format!(
            "the compiler lost products, so the program computes wrong values: is `mul` switched off in .cargo/config.toml?\n{}",
            found.faults.join("\n")
        ));
    }
    let symbols = output("avr-nm", &[], elf)?;
    let formatting: Vec<&str> = symbols
        .lines()
        .filter(|line| line.contains("core3fmt"))
        .collect();
    if !formatting.is_empty() {
        return Err(format!(
            "the program contains core::fmt, which this target miscompiles: look for format strings, unwrap on a Result, and panics with arguments\n{}",
            formatting.join("\n")
        ));
    }
    Ok(())
}

fn size_of_section(sizes: &str, name: &str) -> usize {
    sizes
        .lines()
        .map(str::split_whitespace)
        .find_map(|mut words| (words.next()? == name).then(|| words.next()?.parse().ok())?)
        .unwrap_or_default()
}

fn output(tool: &str, options: &[&str], elf: &Path) -> Result<String, String> {
    capture(Command::new(tool).args(options).arg(elf))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_has_its_size_and_a_missing_one_none() {
        let sizes = "probe.elf  :\nsection  size  addr\n.data  512  8389120\n.bss  5007  8389632\n";
        assert_eq!(size_of_section(sizes, ".data"), 512);
        assert_eq!(size_of_section(sizes, ".bss"), 5007);
        assert_eq!(size_of_section(sizes, ".noinit"), 0);
    }
}
