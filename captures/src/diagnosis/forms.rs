//! The forms of the fields, by line type and column (SPEC.md section 5), and the likely cause of a wrong form.

use groundwave_protocol::telemetry::LineType;

use super::kind::{self, Kind};

/// First column, last column, name of the field and its form.
type Field = (usize, usize, &'static str, &'static str);

const ALL: &[Field] = &[
    (1, 1, "type", "the letter of a line"),
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

const PARAMETER: &[Field] = &[
    (
        5,
        9,
        "place",
        "dd/dd, from 01, the first not above the second",
    ),
    (
        11,
        28,
        "name",
        "lower case letters, digits and hyphens, then spaces",
    ),
    (30, 35, "value", "a sign and five digits"),
    (37, 42, "value after a reset", "a sign and five digits"),
    (44, 49, "least value", "a sign and five digits"),
    (51, 56, "greatest value", "a sign and five digits"),
    (58, 68, "unit", "printable ASCII"),
];

const ABILITIES: &[Field] = &[
    (5, 6, "robot id", "01 to 99"),
    (8, 8, "level", "1 to 5"),
    (10, 12, "capacity", "000 to 300"),
    (14, 22, "modes", "its letter of PRHXUWGFC or ."),
    (24, 27, "readings", "its letter of BWSI or ."),
    (29, 33, "rate", "five digits, from 00030"),
    (35, 35, "fields", "0 to 9"),
];

const OWN_FIELD: &[Field] = &[
    (5, 7, "place", "d/d, from 1, the first not above the second"),
    (
        9,
        26,
        "name",
        "lower case letters, digits and hyphens, then spaces",
    ),
    (28, 28, "decimals", "0 to 5"),
    (30, 40, "unit", "printable ASCII"),
];

const VALUES: &[Field] = &[
    (5, 10, "value 1", "a sign and five digits, or hyphens"),
    (12, 17, "value 2", "a sign and five digits, or hyphens"),
    (19, 24, "value 3", "a sign and five digits, or hyphens"),
    (26, 31, "value 4", "a sign and five digits, or hyphens"),
    (33, 38, "value 5", "a sign and five digits, or hyphens"),
    (40, 45, "value 6", "a sign and five digits, or hyphens"),
    (47, 52, "value 7", "a sign and five digits, or hyphens"),
    (54, 59, "value 8", "a sign and five digits, or hyphens"),
    (61, 66, "value 9", "a sign and five digits, or hyphens"),
];

const ACK: &[Field] = &[
    (1, 1, "type", "K or G"),
    (2, 3, "sequence", "two digits"),
    (4, 8, "acknowledgement", "five 6-bit characters, ` to _"),
];

const fn fields(line_type: LineType) -> &'static [Field] {
    match line_type {
        LineType::State => STATE,
        LineType::Status => STATUS,
        LineType::Counters => COUNTERS,
        LineType::Text => TEXT,
        LineType::Song => SONG,
        LineType::Parameter => PARAMETER,
        LineType::Abilities => ABILITIES,
        LineType::Field => OWN_FIELD,
        LineType::Values => VALUES,
    }
}

/// An unreadable field.
pub(super) struct Misread {
    /// Place and content of the field, and the expected form.
    pub place: String,
    /// The likely cause.
    pub kind: &'static Kind,
}

/// Describes the unreadable field at a column, and its likely cause.
pub(super) fn judge(line: &[u8], column: usize) -> Misread {
    let letter = line.first().copied().unwrap_or(b'?');
    let is_short = line.len() < 20;
    let shown = char::from(letter).escape_default();
    let all = if is_short { ACK } else { ALL };
    let own = LineType::from_letter(letter).filter(|_| !is_short);
    let found = all
        .iter()
        .chain(own.map_or(&[][..], fields))
        .find(|(first, last, ..)| (*first..=*last).contains(&column));
    let Some(&(first, last, name, form)) = found else {
        return Misread {
            place: format!("line {shown}, column {column}: expected a space"),
            kind: kind::SPACE,
        };
    };
    let end = last.min(line.len());
    let whole = line.get(first - 1..end).unwrap_or_default();
    // Each flag and each layer is a separate field.
    let content = if is_letters(form) && last > first {
        line.get(column - 1..column).unwrap_or_default()
    } else {
        whole
    };
    let text = String::from_utf8_lossy(content);
    let place = format!("line {shown}, column {column}, {name}: \"{text}\", expected {form}");
    let kind = if column == 1 {
        kind::TYPE
    } else {
        likely(content, whole, column - first, form)
    };
    Misread { place, kind }
}

/// Whether a form consists of single letters.
fn is_letters(form: &str) -> bool {
    form.contains("letter") && !form.starts_with("lower case letters") || form.starts_with("one of")
}

/// The likely cause of a field with a wrong form. `offset` is the wrong character's position in the whole field.
fn likely(content: &[u8], whole: &[u8], offset: usize, form: &str) -> &'static Kind {
    let text = String::from_utf8_lossy(content);
    let digits = text.trim_start_matches([' ', '+', '-']);
    let is_number =
        !digits.is_empty() && digits.bytes().all(|it| it.is_ascii_digit() || it == b'.');
    if form.contains("6-bit") {
        let bad = |byte: &&u8| !(b'!'..=b'`').contains(*byte);
        return match content.iter().find(bad) {
            Some(b' ') => kind::SIX_BIT_SPACE,
            Some(_) => kind::SIX_BIT,
            None => kind::RANGE,
        };
    }
    if form.starts_with("lower case letters") && text.bytes().any(|it| it.is_ascii_uppercase()) {
        return kind::LETTER_CASE;
    }
    if form.starts_with("lower case letters") || form.starts_with("printable") {
        return kind::FIELD;
    }
    if is_letters(form) {
        return letters(content, whole, offset, form);
    }
    let is_signed = form.starts_with("a sign") || form.starts_with('+');
    let is_zero = digits.bytes().all(|it| matches!(it, b'0' | b'.'));
    let lower = text.trim().to_ascii_lowercase();
    if lower.contains("nan") || lower.contains("inf") || lower.contains('?') {
        kind::NUMBER
    } else if form.contains("hyphens in X and Y")
        && (is_number || text.bytes().all(|it| it == b'-'))
        && has_form(content, form)
    {
        kind::PAIR
    } else if text.bytes().all(|it| it == b'-') {
        kind::HYPHENS
    } else if is_signed && is_number && is_zero && text.starts_with('-') {
        kind::ZERO
    } else if is_signed && is_number && text.starts_with(|it: char| it.is_ascii_digit())
        || is_signed
            && is_number
            && text.starts_with(' ')
            && !text.starts_with("  ")
            && digits.len() + 1 == content.len()
    {
        kind::SIGN
    } else if text.contains(' ') {
        kind::PADDING
    } else if !is_signed && text.starts_with(['+', '-']) {
        kind::EXTRA_SIGN
    } else if text.contains(',') || is_number && !has_point(&text, form) {
        kind::DOT
    } else if form.contains("not above") {
        kind::PAIR
    } else if is_number {
        kind::RANGE
    } else {
        kind::FIELD
    }
}

/// Whether a number has a decimal point where its form has one.
fn has_point(text: &str, form: &str) -> bool {
    let points = text.matches('.').count();
    if form.starts_with('+') {
        return points == 0 || points == 1 && text.find('.') == text.len().checked_sub(2);
    }
    points == usize::from(form.contains("point"))
}

/// Whether the content matches a form of a sign and digits, or hyphens.
fn has_form(content: &[u8], form: &str) -> bool {
    let is_signed =
        matches!(content, [b'+' | b'-', digits @ ..] if digits.iter().all(u8::is_ascii_digit));
    let is_negative_zero =
        content.first() == Some(&b'-') && content[1..].iter().all(|it| *it == b'0');
    form.contains("sign")
        && (is_signed && !is_negative_zero || content.iter().all(|it| *it == b'-'))
}

fn letters(content: &[u8], whole: &[u8], offset: usize, form: &str) -> &'static Kind {
    let Some(&byte) = content.first() else {
        return kind::LETTER;
    };
    if form.contains("at most one in upper case") {
        let layer = b"BTISLMD".get(offset);
        let before = whole.get(..offset).unwrap_or_default();
        if layer == Some(&byte) && before.iter().any(u8::is_ascii_uppercase) {
            return kind::UPPER_CASE;
        }
        return kind::LETTER;
    }
    let swapped = if byte.is_ascii_uppercase() {
        byte.to_ascii_lowercase()
    } else {
        byte.to_ascii_uppercase()
    };
    let options = form.split_whitespace().filter(|it| it.len() == 1);
    let is_listed = options.clone().any(|it| it.as_bytes() == [swapped])
        || form.contains("UBTISLMD") && b"UBTISLMD".get(offset) == Some(&swapped)
        || form.contains("PRHXUWGFC") && b"PRHXUWGFC".get(offset) == Some(&swapped)
        || form.starts_with("a mode") && b"PRHXWGF".contains(&swapped);
    if swapped != byte && is_listed {
        kind::LETTER_CASE
    } else if byte == b'-' {
        kind::HYPHENS
    } else {
        kind::LETTER
    }
}

/// Whether the letter is a line type (SPEC.md section 5).
pub(super) fn is_type(letter: u8) -> bool {
    LineType::from_letter(letter).is_some()
}
