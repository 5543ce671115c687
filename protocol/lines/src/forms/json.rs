//! JSON objects, one per line.

use std::borrow::Cow;

use serde_json::Value;

use super::{Cell, CellValue, finite};
use crate::FIELDS_MAX;

/// The values of an object; nested values are named `outer.inner`, and array elements by their index. `None` if the line is not an
/// object.
pub(crate) fn json(line: &str) -> Option<Vec<Cell<'static>>> {
    if !line.starts_with('{') {
        return None;
    }
    let object: Value = serde_json::from_str(line).ok()?;
    let mut cells = Vec::new();
    flatten(String::new(), object, &mut cells);
    Some(cells)
}

/// Collects nested values. The parser limits the depth.
fn flatten(path: String, value: Value, cells: &mut Vec<Cell<'static>>) {
    if cells.len() >= FIELDS_MAX {
        return;
    }
    let inner = |name: &str| match path.as_str() {
        "" => name.to_owned(),
        path => format!("{path}.{name}"),
    };
    let value = match value {
        Value::Object(object) => {
            for (name, value) in object {
                flatten(inner(&name), value, cells);
            }
            return;
        }
        Value::Array(values) => {
            for (at, value) in values.into_iter().enumerate() {
                flatten(inner(&at.to_string()), value, cells);
            }
            return;
        }
        Value::Null => CellValue::Missing,
        Value::Bool(is_set) => CellValue::Number(f64::from(u8::from(is_set))),
        Value::Number(number) => number.as_f64().map_or(CellValue::Missing, finite),
        Value::String(text) => CellValue::Text(Cow::Owned(text)),
    };
    cells.push(Cell::new(path, value));
}
