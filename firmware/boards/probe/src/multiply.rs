//! Products of 8 and 16 bits, which the compiler calls because its own multiplication is switched off.
//!
//! LLVM's back end for this chip loses products: it saves the status register in `r0` while a product is there. So
//! `.cargo/config.toml` forbids it the instruction `mul`, and `cargo xtask avr` looks for the fault in the program.

use core::arch::global_asm;

// Arguments in r24 and r22, or in r25:r24 and r23:r22; the result replaces the first. `mul` leaves its product in r1:r0,
// and r1 must be zero on return. The assembler knows no `mul` here either, so its three forms are written as words.
global_asm!(
    ".global __mulqi3",
    "__mulqi3:",
    ".word 0x9F86 ; mul r24, r22",
    "mov r24, r0",
    "clr r1",
    "ret",
    ".global __mulhi3",
    "__mulhi3:",
    ".word 0x9F86 ; mul r24, r22",
    "movw r18, r0",
    ".word 0x9F87 ; mul r24, r23",
    "add r19, r0",
    ".word 0x9F96 ; mul r25, r22",
    "add r19, r0",
    "movw r24, r18",
    "clr r1",
    "ret",
);
