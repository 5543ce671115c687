//! Pairs `name:value` and `name=value`, several per line, each with or without a unit.

use super::{Cell, CellValue, is_label, number, with_unit};
use std::borrow::Cow;

/// Maximum length of a unit after a value, characters.
const UNIT_CHARS_MAX: usize = 6;

const SEPARATORS: [char; 4] = [',', ';', '\t', ' '];

/// The pairs of a line; `None` if the line contains other text, or no number.
pub(crate) fn pairs(line: &str) -> Option<Vec<Cell<'_>>> {
    let mut cells = Vec::new();
    let mut rest = line.trim();
    while !rest.is_empty() {
        let (label, after) = rest.split_once([':', '='])?;
        let (name, unit) = with_unit(label.trim());
        if !is_label(name) {
            return None;
        }
        let after = after.trim_start_matches([' ']);
        let word_end = after.find(SEPARATORS).unwrap_or(after.len());
        let (word, after) = after.split_at(word_end);
        let (value, own_unit) = value(word)?;
        let (next_unit, after) = match own_unit {
            None => unit_after(after),
            unit => (unit, after),
        };
        let unit = unit.or(next_unit.filter(|_| matches!(value, CellValue::Number(_))));
        let mut cell = Cell::new(name, value);
        cell.unit = unit;
        cells.push(cell);
        rest = after.trim_start_matches(SEPARATORS);
    }
    let has_number = |cell: &Cell<'_>| !matches!(cell.value, CellValue::Text(_));
    cells.iter().any(has_number).then_some(cells)
}

/// A value and the unit that follows it without a space: `11.9V`.
fn value(word: &str) -> Option<(CellValue<'_>, Option<&str>)> {
    if let Some(value) = number(word) {
        return Some((value, None));
    }
    let is_numeric = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+');
    let split = word.find(|c| !is_numeric(c)).unwrap_or(word.len());
    let (figures, unit) = word.split_at(split);
    if let Some(value) = number(figures)
        && is_unit(unit)
    {
        return Some((value, Some(unit)));
    }
    let is_word = is_label(word) && !word.contains([':', '=']);
    is_word.then_some((CellValue::Text(Cow::Borrowed(word)), None))
}

/// A unit after a value and a space: `21.5 C`. A word before `:` or `=` is the next name.
fn unit_after(rest: &str) -> (Option<&str>, &str) {
    let Some(after) = rest.strip_prefix(' ') else {
        return (None, rest);
    };
    let end = after.find(SEPARATORS).unwrap_or(after.len());
    let (word, after) = after.split_at(end);
    let is_name = word.contains([':', '=']) || after.trim_start().starts_with([':', '=']);
    if is_unit(word) && !is_name {
        (Some(word), after)
    } else {
        (None, rest)
    }
}

fn is_unit(word: &str) -> bool {
    let is_sign = |c: char| c.is_alphabetic() || "°%/²³^µΩ".contains(c);
    !word.is_empty()
        && word.chars().count() <= UNIT_CHARS_MAX
        && word
            .chars()
            .enumerate()
            .all(|(at, c)| is_sign(c) || at > 0 && c.is_ascii_digit())
}
