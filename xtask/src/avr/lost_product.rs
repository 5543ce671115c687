//! A fault of LLVM's back end for this chip: a product in `r0` is overwritten before it is read.
//!
//! To reach far into the stack, the back end saves the status register (I/O address 0x3f) in `r0`, changes the stack or frame pointer
//! and restores the status. It forgets that `mul` may have left a product in `r0`. So between the save and the restore
//! only the restore may read `r0`, and after it nothing may read `r0` until it is written.

use std::collections::BTreeSet;

use super::listing::{Instruction, Program};

const STATUS: &str = "0x3f";
const R0: &str = "r0";

pub(super) struct Found {
    /// Number of places that save the status register in `r0`.
    pub(super) saves: usize,
    /// One line for each place where a product is lost.
    pub(super) faults: Vec<String>,
}

/// Searches every path that begins at a save of the status register.
pub(super) fn find(program: &Program) -> Found {
    let mut found = Found {
        saves: 0,
        faults: Vec::new(),
    };
    for (address, instruction) in program {
        let is_save = instruction.is("in", &[R0, STATUS]);
        // An interrupt has pushed `r0` before and pushes the status now.
        if !is_save
            || program
                .get(&instruction.next)
                .is_some_and(|next| next.is("push", &[R0]))
        {
            continue;
        }
        found.saves += 1;
        if let Some(read) = first_wrong_read(program, instruction.next) {
            let function = &instruction.function;
            found.faults.push(format!(
                "{function}: r0 saves the status at {address:x} and is read at {read:x}"
            ));
        }
    }
    found
}

/// Address of an instruction that reads `r0` and gets the status register instead of a product.
fn first_wrong_read(program: &Program, begin: u32) -> Option<u32> {
    let mut seen = BTreeSet::new();
    let mut paths = vec![(begin, false)];
    while let Some((address, is_restored)) = paths.pop() {
        let Some(instruction) = program.get(&address) else {
            continue;
        };
        if !seen.insert((address, is_restored)) {
            continue;
        }
        if !is_restored && instruction.is("out", &[STATUS, R0]) {
            paths.push((instruction.next, true));
        } else if instruction.reads_r0() {
            return Some(address);
        } else if !instruction.ends_r0() {
            for next in instruction.successors(program) {
                paths.push((next, is_restored));
            }
        }
    }
    None
}

impl Instruction {
    fn is(&self, mnemonic: &str, operands: &[&str]) -> bool {
        self.mnemonic == mnemonic && self.operands == operands
    }

    /// Whether the instruction writes its first operand without reading it.
    fn only_writes_first(&self) -> bool {
        let loads = [
            "mov", "movw", "ldd", "ld", "lds", "ldi", "in", "pop", "lpm", "elpm",
        ];
        let clears = self.mnemonic == "eor" && self.operands.first() == self.operands.get(1);
        clears || loads.contains(&self.mnemonic.as_str())
    }

    fn multiplies(&self) -> bool {
        self.mnemonic.starts_with("mul") || self.mnemonic.starts_with("fmul")
    }

    fn reads_r0(&self) -> bool {
        // `movw` names the lower register of a pair.
        let clears = self.mnemonic == "eor" && self.only_writes_first();
        let read = self
            .operands
            .get(usize::from(self.only_writes_first())..)
            .unwrap_or_default();
        !clears && read.iter().any(|operand| operand == R0)
    }

    /// Whether `r0` has another value afterwards, or control leaves the function: no caller and no callee expects `r0`.
    fn ends_r0(&self) -> bool {
        let leaves = [
            "ret", "reti", "call", "rcall", "icall", "eicall", "ijmp", "eijmp",
        ];
        let writes =
            self.only_writes_first() && self.operands.first().is_some_and(|operand| operand == R0);
        writes || self.multiplies() || leaves.contains(&self.mnemonic.as_str())
    }

    fn successors(&self, program: &Program) -> Vec<u32> {
        let mnemonic = self.mnemonic.as_str();
        let skips = ["cpse", "sbrc", "sbrs", "sbic", "sbis"].contains(&mnemonic);
        let jumps = ["jmp", "rjmp"].contains(&mnemonic);
        let branches = mnemonic.starts_with("br") && mnemonic != "break";
        let skipped = program
            .get(&self.next)
            .filter(|_| skips)
            .map(|next| next.next);
        let target = self.target.filter(|_| jumps || branches);
        let next = Some(self.next).filter(|_| !jumps);
        [next, skipped, target].into_iter().flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::listing::parse;
    use super::*;

    /// A program of two-byte instructions, from address 0.
    fn found(instructions: &[&str]) -> Found {
        let lines = instructions.iter().enumerate().map(|(n, instruction)| {
            format!(
                "{:6x}:\t00 00       \t{}\n",
                n * 2,
                instruction.replacen(' ', "\t", 1)
            )
        });
        let listing = "00000000 <f>:\n".to_owned() + &lines.collect::<String>();
        find(&parse(&listing))
    }

    const SAVE: &str = "in r0, 0x3f";
    const RESTORE: &str = "out 0x3f, r0";

    #[test]
    fn a_product_that_is_read_after_the_restore_is_lost() {
        let found = found(&[
            "mul r24, r22",
            SAVE,
            "sbiw r28, 0x3f",
            RESTORE,
            "mov r24, r0",
            "ret",
        ]);
        assert_eq!(found.saves, 1);
        assert_eq!(
            found.faults,
            ["f: r0 saves the status at 2 and is read at 8"]
        );
    }

    #[test]
    fn a_product_that_is_read_before_the_restore_is_lost() {
        assert_eq!(
            found(&[SAVE, "add r24, r0", RESTORE, "ret"]).faults.len(),
            1
        );
        assert_eq!(
            found(&[SAVE, "movw r24, r0", RESTORE, "ret"]).faults.len(),
            1
        );
        assert_eq!(
            found(&[SAVE, RESTORE, "std Y+1, r0", "ret"]).faults.len(),
            1
        );
    }

    #[test]
    fn a_restored_status_that_nothing_else_reads_is_right() {
        for after in ["mul r24, r22", "eor r0, r0", "pop r0", "call 0x100", "ret"] {
            let found = found(&[SAVE, "sbiw r28, 0x3f", RESTORE, after, "mov r24, r0", "ret"]);
            assert_eq!((found.saves, found.faults.len()), (1, 0), "{after}");
        }
    }

    #[test]
    fn branches_and_skips_are_followed() {
        let branch = "breq .+4 \t; 0x8 <f+0x8>";
        assert_eq!(
            found(&[SAVE, RESTORE, branch, "ret", "mov r24, r0"])
                .faults
                .len(),
            1
        );
        assert_eq!(
            found(&[SAVE, RESTORE, "sbrc r24, 0", "pop r0", "mov r24, r0"])
                .faults
                .len(),
            1
        );
        let around = "rjmp .+4 \t; 0x8 <f+0x8>";
        assert_eq!(
            found(&[SAVE, RESTORE, around, "mov r24, r0", "ret"])
                .faults
                .len(),
            0
        );
    }

    #[test]
    fn an_interrupt_that_pushes_the_status_is_no_save() {
        assert_eq!(
            found(&["push r0", SAVE, "push r0", "mul r24, r22", "reti"]).saves,
            0
        );
    }
}
