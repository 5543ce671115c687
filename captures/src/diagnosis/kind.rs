//! The kinds of mistakes: a stable code, the likely cause and the remedy.

use serde::Serialize;

/// A kind of mistake, with its likely cause and remedy.
#[derive(Debug, PartialEq, Eq, Serialize)]
pub struct Kind {
    /// Stable code.
    pub code: &'static str,
    /// Section of SPEC.md that holds the rule.
    pub section: u8,
    /// Likely cause.
    pub cause: &'static str,
    /// Remedy.
    pub remedy: &'static str,
}

const fn kind(code: &'static str, section: u8, cause: &'static str, remedy: &'static str) -> Kind {
    Kind {
        code,
        section,
        cause,
        remedy,
    }
}

macro_rules! kinds {
    ($($name:ident = $code:literal, $section:literal, $cause:literal, $remedy:literal;)*) => {
        $(#[doc = $cause]
        pub const $name: &Kind = &kind($code, $section, $cause, $remedy);)*

        /// All kinds.
        pub const ALL: &[&Kind] = &[$($name),*];
    };
}

kinds! {
    SIGN = "missing-sign", 3, "the sign is missing", "print a sign always, for zero and positive numbers too: %+03d";
    EXTRA_SIGN = "extra-sign", 3, "this number has no sign", "print digits only";
    PADDING = "padding", 3, "the number is padded with spaces", "pad with zeros: %03d, with a sign %+03d";
    ZERO = "negative-zero", 3, "zero has a minus sign", "print zero with a plus: round first, then choose the sign";
    DOT = "decimal-point", 3, "the decimal point is missing, misplaced or a comma", "print one full stop where the form has it, and none in whole numbers";
    NUMBER = "not-a-number", 3, "the value is not a number", "check for division by 0 and for missing readings before printing";
    RANGE = "range", 3, "the value is out of range", "let the value saturate or wrap as the line's table says";
    LETTER_CASE = "letter-case", 5, "the letter has the wrong case", "copy the letter of the table; capital and small letters differ";
    LETTER = "letter", 5, "the letter is not allowed in this column", "copy a letter of the table, or a full stop or hyphen";
    HYPHENS = "hyphens", 5, "hyphens are not allowed here", "send a value; only some fields can be without one";
    SIX_BIT_SPACE = "six-bit-zero", 3, "the value 0 is sent as a space", "send a backtick (0x60) for the value 0";
    SIX_BIT = "six-bit", 3, "the character is not a 6-bit character", "send 0x20 + value for 1 to 63 and a backtick for 0; this is not Base64";
    UPPER_CASE = "two-holders", 5, "two layers control the motors", "write at most one layer in upper case, the others in lower case";
    SPACE = "column", 5, "the previous field is too long, or this field begins too early", "write each field at its column in the table, not one after another";
    TYPE = "line-type", 5, "the line type is unknown", "begin lines with a letter of section 5; use line T for text of your own";
    PAIR = "pair", 5, "the two fields disagree", "send both values or hyphens for both; never more waypoints reached than listed";
    FIELD = "field", 5, "the field does not have the form in the table", "compare it with the line's table";
    CRC_START = "crc-start", 4, "the checksum starts from 0", "start from 0xFFFFFF";
    CRC_INVERTED = "crc-inverted", 4, "the checksum is inverted at the end", "leave out the final exclusive-or";
    CRC_REFLECTED = "crc-reflected", 4, "the checksum is reflected", "take the most significant bit of each byte first";
    CRC_POLYNOMIAL = "crc-polynomial", 4, "the checksum has another polynomial", "use 0x7B01BD; 0xBD80DE is Koopman's name for it";
    CRC_16 = "crc-16", 4, "the checksum is a CRC-16", "compute CRC-24 and send it as four 6-bit characters";
    CRC_XOR = "crc-xor", 4, "the checksum is an exclusive-or or a sum", "compute CRC-24 and send it as four 6-bit characters";
    CRC_HEX = "crc-hex", 4, "the checksum is in hexadecimal", "send it as four 6-bit characters";
    CRC_ZERO = "crc-zero", 3, "the checksum has a space instead of a backtick", "send a backtick (0x60) for the value 0";
    CRC_ORDER = "crc-order", 4, "the checksum's characters are reversed", "send the most significant character first";
    CRC_BYTES = "crc-bytes", 4, "the remainder's bytes are reversed", "shift each byte to the top of the remainder, as in the example of section 4";
    CRC_LINE_FEED = "crc-line-feed", 4, "the checksum includes the previous line end", "begin it at the line's letter";
    CRC_COLUMNS = "crc-columns", 4, "the checksum covers the wrong columns", "cover columns 1 to 74; in lines K and G, columns 1 to 8";
    CRC_STALE = "crc-stale", 4, "the checksum was computed before the line was complete", "compute it last, over the bytes that are sent";
    CRC_CHARACTERS = "crc-characters", 4, "the checksum's characters are not 6-bit ones", "send 0x20 + value for 1 to 63 and a backtick for 0; this is not Base64";
    CRC_BINARY = "crc-binary", 4, "the checksum is in three bytes", "send it as four 6-bit characters";
    CRC_CONSTANT = "crc-constant", 4, "the checksum is wrong by the same bits in every line", "start from 0xFFFFFF, and send the remainder unchanged";
    CRC_UNKNOWN = "crc-unknown", 4, "the checksum fits no usual mistake", "compare it step by step with vectors/checksums.jsonl";
    LINE_END = "line-end", 3, "the line does not end with CR LF", "end it with one CR LF (\\r\\n); println adds its own";
    LENGTH = "length", 5, "a field is longer or shorter than its columns", "give every field a fixed width: %+04d and %03d instead of %d";
    BETWEEN = "between-lines", 7, "other bytes come between the lines", "end lines with CR LF once and without a NUL, and print text in lines T only";
    STUCK = "sequence-stuck", 5, "the sequence does not change", "add one for every line";
    JUMP = "sequence-jump", 5, "the sequence jumps", "add one for every line of any type, from 00 to 99";
    PER_TYPE = "sequence-per-type", 5, "each line type has its own sequence", "count the lines of all types together";
    WRAP = "sequence-wrap", 5, "the sequence restarts too early", "count to 99, then from 0";
    BOOT_SAME = "boot-same", 7, "the robot restarts with the same boot counter", "keep the counter in memory that survives a reset, and add one before the first line";
    BOOT_CHANGES = "boot-changes", 6, "the boot counter changes without a restart", "add one once, before the first line";
    BOOT_DISAGREES = "boot-disagrees", 6, "the boot counters of the line and its acknowledgement disagree", "put boots modulo 8 into bits 29-27";
    ID_DISAGREES = "id-disagrees", 6, "the robot ids of the line and its acknowledgement disagree", "put the same id into columns 5-6 and bits 6-0";
    ID_ZERO = "id-zero", 6, "the acknowledgement has robot id 0", "give the robot an id from 1 to 99";
    TWO_ROBOTS = "two-robots", 1, "two robots are on the channel", "give one of them another channel";
    HEARING = "hearing", 6, "only some lines say that the robot cannot hear", "send this in every line, or in none";
    NO_ERA = "era-missing", 11, "the acknowledgement does not show the era", "show the era in lines whose sequence modulo 3 is 1";
    ERA_TWICE = "era-twice", 11, "two consecutive lines show the era", "show the era only in lines whose sequence modulo 3 is 1";
    DIGEST_EMPTY = "digest-empty", 10, "the digest of an empty list is wrong", "send the digest 0x41D912FF while the list is empty";
    UPTIME = "uptime", 5, "the uptime does not count seconds", "count seconds since boot; one line is a third of a second";
    LINE_RATE = "line-rate", 2, "more than 12 lines begin in a second", "pause between lines above 2400 baud, and count the uptime in seconds";
    ABILITIES = "abilities", 5, "line I and the other lines disagree", "state in line I what the robot has";
    NO_ABILITIES = "abilities-missing", 5, "no line I comes", "send line I after boot, after each open and at least every 20 s; only a robot with everything may leave it out";
    NO_STATE = "no-state", 7, "there is no line A between two other lines", "send a line A after every other line";
    ONLY_STATE = "only-state", 7, "lines B and C come too rarely", "send five lines A, then B or C in turn";
}
