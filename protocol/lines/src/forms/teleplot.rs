//! Lines of Teleplot: `>name:value`, `>name:time:value`, several values separated by `;`, then a unit after `§` and flags
//! after `|`. <https://github.com/nesnes/teleplot> describes them.

use std::borrow::Cow;

use super::{Cell, CellValue, is_label, number};
use crate::field::is_name;

/// The cells of a line (the newest of several values); `None` if the line is not Teleplot's. A text without a name and a
/// three-dimensional shape have no cells.
pub(crate) fn teleplot(line: &str) -> Option<Vec<Cell<'_>>> {
    let line = line.strip_prefix('>')?;
    if line.starts_with("3D|") {
        return Some(Vec::new());
    }
    let (line, flags) = line.rsplit_once('|').unwrap_or((line, ""));
    let (line, unit) = match line.split_once('§') {
        Some((line, unit)) => (line, Some(unit)),
        None => (line, None),
    };
    let (name, points) = line.split_once(':')?;
    let unit = unit.filter(|unit| is_name(unit));
    let has = |flag| flags.split(',').any(|given| given.trim() == flag);
    if !is_label(name) {
        return None;
    }
    let newest = points.trim_end_matches(';').rsplit(';').next()?;
    if has("t") {
        let text = match newest.split_once(':') {
            Some((time, text)) if number(time).is_some() => text,
            _ => newest,
        };
        let text = CellValue::Text(Cow::Borrowed(text));
        return Some(vec![Cell::new(name, text)]);
    }
    let mut parts = newest.split(':').map(number);
    if has("xy") {
        let cell = |axis: &str, value| Cell {
            unit,
            ..Cell::new(format!("{name}.{axis}"), value)
        };
        return Some(vec![cell("x", parts.next()??), cell("y", parts.next()??)]);
    }
    let first = parts.next()??;
    let value = match parts.next() {
        None => first,
        Some(second) => second?,
    };
    let cell = Cell::new(name, value);
    (parts.next().is_none()).then(|| vec![Cell { unit, ..cell }])
}
