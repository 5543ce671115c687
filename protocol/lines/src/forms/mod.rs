//! The forms of lines, each a function from a line to its cells.

pub(crate) mod csv;
mod json;
mod nmea;
mod pairs;
mod teleplot;

use std::borrow::Cow;

pub(crate) use json::json;
pub(crate) use nmea::{Origin, nmea};
pub(crate) use pairs::pairs;
pub(crate) use teleplot::teleplot;

use crate::field::{Role, is_name};

/// A value in a line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cell<'a> {
    pub(crate) name: Cow<'a, str>,
    pub(crate) unit: Option<&'a str>,
    /// Role given by the form itself, if any.
    pub(crate) role: Option<Role>,
    pub(crate) value: CellValue<'a>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CellValue<'a> {
    Number(f64),
    Text(Cow<'a, str>),
    /// No measurement: `nan`, an empty cell, or `null`.
    Missing,
}

impl<'a> Cell<'a> {
    pub(crate) fn new(name: impl Into<Cow<'a, str>>, value: CellValue<'a>) -> Self {
        Self {
            name: name.into(),
            unit: None,
            role: None,
            value,
        }
    }
}

/// The value of a word: a number, a truth value or nothing; `None` for other text.
pub(crate) fn number<'a>(word: &str) -> Option<CellValue<'a>> {
    let first = *word.as_bytes().first()?;
    if first.is_ascii_digit() || matches!(first, b'+' | b'-' | b'.') {
        // `parse` also takes words such as `-infinity`, which count as missing.
        let number: f64 = word.parse().ok()?;
        return Some(finite(number));
    }
    match word.to_ascii_lowercase().as_str() {
        "true" => Some(CellValue::Number(1.0)),
        "false" => Some(CellValue::Number(0.0)),
        "nan" | "inf" | "ovf" | "null" | "none" | "n/a" => Some(CellValue::Missing),
        _ => None,
    }
}

pub(crate) fn finite<'a>(number: f64) -> CellValue<'a> {
    if number.is_finite() {
        CellValue::Number(number)
    } else {
        CellValue::Missing
    }
}

/// Whether a word can name a value without a profile: it begins with a letter and contains no separator.
fn is_label(text: &str) -> bool {
    let first = text.chars().next();
    is_name(text)
        && first.is_some_and(|first| first.is_alphabetic() || first == '_')
        && !text.contains(['{', '}', '"', '<', '>', '*', '?', '!', '@', '|', ';', ','])
}

/// Splits `temp (C)` or `temp [C]` into name and unit.
fn with_unit(label: &str) -> (&str, Option<&str>) {
    let bracketed = |open, close| {
        let (name, unit) = label.strip_suffix(close)?.split_once(open)?;
        let (name, unit) = (name.trim_end(), unit.trim());
        (is_label(name) && is_name(unit)).then_some((name, Some(unit)))
    };
    bracketed('(', ')')
        .or_else(|| bracketed('[', ']'))
        .unwrap_or((label, None))
}
