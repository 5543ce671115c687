//! Values in columns, with or without a header.

use std::borrow::Cow;
use std::sync::LazyLock;

use super::{Cell, CellValue, is_label, number, with_unit};
use crate::FIELDS_MAX;
use crate::field::Field;

/// Names of columns without a header.
static UNNAMED: LazyLock<Vec<String>> =
    LazyLock::new(|| (1..=FIELDS_MAX).map(|n| format!("c{n}")).collect());

/// The columns of a robot's lines, as far as known.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    /// Names and units, from a header or a profile.
    names: Vec<(String, Option<String>)>,
    are_configured: bool,
    /// Number of columns of the previous line of values.
    previous: Option<usize>,
    /// Whether two consecutive lines had the same number of columns, or there was a header.
    is_known: bool,
}

/// A line of columns.
pub(crate) enum Row<'a> {
    Header,
    /// Values; `is_sure` is `false` for the first line without a header.
    Values {
        cells: Vec<Cell<'a>>,
        is_sure: bool,
    },
}

impl Columns {
    /// The columns of a profile.
    pub(crate) fn of(fields: &[Field]) -> Self {
        Self {
            names: fields
                .iter()
                .map(|field| (field.name.clone(), None))
                .collect(),
            are_configured: !fields.is_empty(),
            previous: None,
            is_known: !fields.is_empty(),
        }
    }

    /// Drops guessed columns, because the robot may be another one.
    pub(crate) fn interrupt(&mut self) {
        self.previous = None;
    }

    /// Reads a line; returns `None` if it has no columns.
    pub(crate) fn take<'a>(&mut self, line: &'a str) -> Option<Row<'a>> {
        let mut cells = split(line, cell)?;
        let count = cells.len();
        let has_numbers = cells
            .iter()
            .any(|cell| matches!(cell.value, CellValue::Number(_)));
        let is_tabular = || line.contains([';', '\t', ',', ':']);
        if !has_numbers && is_tabular() && self.take_header(&split(line, |word| word)?) {
            return Some(Row::Header);
        }
        let has_names = self.names.len() == count;
        if self.are_configured && !has_names {
            return None;
        }
        // Without a header, only the first column may be a text, such as a time of day.
        let are_values = cells
            .iter()
            .skip(usize::from(count > 1))
            .all(|cell| !matches!(cell.value, CellValue::Text(_)));
        if !(has_numbers && (has_names || are_values)) {
            self.previous = None;
            return None;
        }
        self.is_known |= self.previous == Some(count);
        self.previous = Some(count);
        if !has_names {
            self.names.clear();
        }
        for (at, cell) in cells.iter_mut().enumerate() {
            cell.name = match self.names.get(at) {
                Some((name, _)) => Cow::Owned(name.clone()),
                None => Cow::Borrowed(&UNNAMED[at]),
            };
        }
        Some(Row::Values {
            cells,
            is_sure: self.is_known || has_names,
        })
    }

    /// The unit of a column, from its header.
    pub(crate) fn unit(&self, name: &str) -> Option<&str> {
        let named = self.names.iter().find(|(known, _)| known == name);
        named.and_then(|(_, unit)| unit.as_deref())
    }

    /// Takes a line of names (with or without the Arduino plotter's colons); returns whether it is a header.
    fn take_header(&mut self, words: &[Cow<'_, str>]) -> bool {
        let labels = words
            .iter()
            .map(|word| with_unit(word.strip_suffix(':').unwrap_or(word).trim()));
        let labels: Vec<_> = labels.collect();
        if words.len() < 2 || !labels.iter().all(|(name, _)| is_label(name)) {
            return false;
        }
        if !self.are_configured {
            self.names = labels
                .into_iter()
                .map(|(name, unit)| (name.to_owned(), unit.map(str::to_owned)))
                .collect();
            self.is_known = false;
        }
        true
    }
}

/// A cell whose name is not known yet.
fn cell(word: Cow<'_, str>) -> Cell<'_> {
    let value = value(&word);
    Cell::new("", value.unwrap_or(CellValue::Text(word)))
}

/// A cell's value: a number (also with a decimal comma) or nothing; `None` for a text.
fn value<'a>(word: &str) -> Option<CellValue<'a>> {
    if word.is_empty() {
        return Some(CellValue::Missing);
    }
    number(word).or_else(|| {
        let (whole, part) = word.split_once(',')?;
        number(&format!("{whole}.{part}"))
    })
}

/// The words of a line, each passed to `make`, ignoring a separator at the end; `None` if there are too many.
fn split<'a, T>(line: &'a str, make: impl Fn(Cow<'a, str>) -> T) -> Option<Vec<T>> {
    let separator = [';', '\t', ',']
        .into_iter()
        .find(|separator| line.contains(*separator));
    let of_line = |word: &'a str| make(Cow::Borrowed(word));
    let words: Vec<T> = match separator {
        Some(separator) if line.contains('"') => split_quoted(line, separator)
            .into_iter()
            .map(make)
            .collect(),
        Some(separator) => {
            let line = line.strip_suffix(separator).unwrap_or(line);
            line.split(separator).map(str::trim).map(of_line).collect()
        }
        None => line.split_whitespace().map(of_line).collect(),
    };
    (1..=FIELDS_MAX).contains(&words.len()).then_some(words)
}

/// Splits a line into cells, some of them in quotation marks.
fn split_quoted(line: &str, separator: char) -> Vec<Cow<'_, str>> {
    let mut is_quoted = false;
    let ends_here = |c: char| {
        is_quoted ^= c == '"';
        c == separator && !is_quoted
    };
    let cells = line.split(ends_here);
    cells
        .map(|cell| Cow::Owned(cell.replace('"', "").trim().to_owned()))
        .collect()
}
