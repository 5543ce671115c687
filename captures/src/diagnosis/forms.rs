//! The forms of the fields, by type of line and column (SPEC.md section 5).

/// First column, last column, name of the field and its form.
type Field = (usize, usize, &'static str, &'static str);

const ALL: &[Field] = &[
    (1, 1, "type", "one of A B C P S T"),
    (2, 3, "sequence", "two digits"),
    (70, 74, "acknowledgement", "five 6-bit characters, ` to _"),
];

const STATE: &[Field] = &[
    (5, 10, "X", "+123.4, or whole inches from 1000 on"),
    (12, 17, "Y", "+123.4, or whole inches from 1000 on"),
    (19, 21, "theta", "000 to 359"),
    (23, 25, "requested speed", "a sign and two digits"),
    (27, 29, "requested rotation", "a sign and two digits"),
    (31, 33, "left wheel", "a sign and two digits"),
    (35, 37, "right wheel", "a sign and two digits"),
    (39, 41, "left sonar", "three digits or hyphens"),
    (43, 45, "right sonar", "three digits or hyphens"),
    (47, 48, "left photocell", "two digits or hyphens"),
    (50, 51, "right photocell", "two digits or hyphens"),
    (53, 53, "bumper", "one of . L C R l r S A J -"),
    (54, 54, "infrared", "one of . L R B J -"),
    (55, 55, "floor edge", "one of . L C R A -"),
    (56, 56, "arm", "one of . u a L R B T -"),
    (57, 57, "drive", "one of . s X 0 o"),
    (58, 58, "power", "one of . l ! d +"),
    (59, 59, "link", "one of . f F"),
    (61, 61, "mode", "one of P R H X U W G F C"),
    (
        62,
        68,
        "layers",
        ". - or the layer's letter, at most one in upper case",
    ),
];

const STATUS: &[Field] = &[
    (5, 6, "robot id", "01 to 99"),
    (8, 11, "battery", "two digits, a point and a digit"),
    (
        13,
        17,
        "target X",
        "a sign and four digits, or hyphens in X and Y",
    ),
    (
        19,
        23,
        "target Y",
        "a sign and four digits, or hyphens in X and Y",
    ),
    (
        25,
        31,
        "waypoints",
        "ddd/ddd, the first not above the second",
    ),
    (33, 38, "digest", "six 6-bit characters"),
    (40, 41, "max_count", "two digits"),
    (43, 45, "left photocell", "000 to 255, or hyphens"),
    (47, 49, "right photocell", "000 to 255, or hyphens"),
    (51, 58, "layers", ". - or the layer's letter of UBTISLMD"),
    (60, 62, "boots", "three digits"),
    (64, 65, "odometer resets", "two digits"),
];

const COUNTERS: &[Field] = &[
    (5, 6, "robot id", "01 to 99"),
    (8, 13, "seconds since boot", "six digits"),
    (15, 17, "boots", "three digits"),
    (19, 23, "version", "two digits, a point and two digits"),
    (25, 42, "ticks won", "nine numbers of two 6-bit characters"),
    (44, 46, "frames heard", "three digits"),
    (48, 50, "frames rejected", "three digits"),
    (52, 54, "late ticks", "three digits"),
    (56, 59, "contacts", "four digits"),
    (61, 64, "failsafe silence", "0010 to 4095, or hyphens"),
    (
        66,
        66,
        "failsafe mode",
        "a mode's letter but U and C, or a hyphen with the silence",
    ),
];

const TEXT: &[Field] = &[(5, 68, "text", "printable ASCII")];
const SONG: &[Field] = &[(5, 67, "notes", "three 6-bit characters each, then spaces")];
const PARAMETER: &[Field] = &[(5, 68, "parameter", "the form of line P")];

/// What stands at a column and what was expected there.
pub(super) fn expected(line: &[u8], column: usize) -> String {
    let letter = line.first().copied().unwrap_or(b'?');
    let fields = match letter {
        b'A' => STATE,
        b'B' => STATUS,
        b'C' => COUNTERS,
        b'T' => TEXT,
        b'S' => SONG,
        b'P' => PARAMETER,
        _ => &[],
    };
    let letter = char::from(letter);
    let field = ALL.iter().chain(fields);
    let Some((_, _, name, form)) = field
        .clone()
        .find(|(first, last, ..)| (*first..=*last).contains(&column))
    else {
        return format!("line {letter}, column {column}: expected a space");
    };
    format!("line {letter}, column {column}, {name}: expected {form}")
}
