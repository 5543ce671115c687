//! The instructions of a program, from the listing of `avr-objdump --disassemble`.

use std::collections::BTreeMap;

/// Instructions by their address.
pub(super) type Program = BTreeMap<u32, Instruction>;

pub(super) struct Instruction {
    pub(super) mnemonic: String,
    pub(super) operands: Vec<String>,
    /// Address of the next instruction in memory.
    pub(super) next: u32,
    /// Address to which the instruction branches, jumps or calls.
    pub(super) target: Option<u32>,
    /// Name of the function that contains the instruction.
    pub(super) function: String,
}

/// Parses a listing: lines `address:<tab>bytes<tab>mnemonic<tab>operands<tab>; comment` below `address <function>:`.
pub(super) fn parse(listing: &str) -> Program {
    let mut program = Program::new();
    let mut function = String::new();
    for line in listing.lines() {
        if let Some((_, name)) = line.split_once(" <")
            && let Some(name) = name.strip_suffix(">:")
        {
            name.clone_into(&mut function);
        }
        let mut columns = line.split('\t').map(str::trim);
        let Some(address) = columns.next().and_then(|text| hex(text.strip_suffix(':')?)) else {
            continue;
        };
        let (Some(bytes), Some(mnemonic)) = (columns.next(), columns.next()) else {
            continue;
        };
        let operands = columns.next().unwrap_or_default();
        let comment = columns.next().unwrap_or_default();
        let operands: Vec<String> = operands.split(", ").map(str::to_owned).collect();
        let absolute = operands
            .first()
            .and_then(|operand| hex(operand.strip_prefix("0x")?));
        let relative = comment
            .strip_prefix("; 0x")
            .and_then(|text| hex(text.split(' ').next()?));
        let next = address + bytes.split(' ').count() as u32;
        let instruction = Instruction {
            mnemonic: mnemonic.to_owned(),
            operands,
            next,
            target: relative.or(absolute),
            function: function.clone(),
        };
        program.insert(address, instruction);
    }
    program
}

fn hex(text: &str) -> Option<u32> {
    u32::from_str_radix(text, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_listing_gives_addresses_operands_and_targets() {
        let program = parse(
            "\n0000012c <__mulqi3>:\n     12c:\t86 9f       \tmul\tr24, r22\n     12e:\t0e 94 9a a8 \tcall\t0x15134\t; 0x15134 <__muluhisi3>\n     132:\tf1 f7       \tbrne\t.-4      \t; 0x130 <x>\n     134:\t08 95       \tret\n",
        );
        let instruction = |address: u32| &program[&address];
        assert_eq!(program.len(), 4);
        assert_eq!(instruction(0x12c).operands, ["r24", "r22"]);
        assert_eq!(instruction(0x12c).function, "__mulqi3");
        assert_eq!(instruction(0x12e).next, 0x132);
        assert_eq!(instruction(0x12e).target, Some(0x1_5134));
        assert_eq!(instruction(0x132).target, Some(0x130));
        assert_eq!(instruction(0x134).mnemonic, "ret");
        assert_eq!(instruction(0x134).target, None);
    }
}
