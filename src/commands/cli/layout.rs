//! Layout of the help texts below the options.

use std::iter;

use crate::io::ports;
use crate::view::wrap;

/// Width of the narrowest supported terminal.
const COLUMNS: usize = 80;

/// Last column at which an explanation may begin beside its example; later ones go below the example.
const EXPLAINED_AT_MAX: usize = 34;

/// Indentation of an explanation below its example.
const BELOW: usize = 6;

/// The port in the examples of the help texts.
const PORT: &str = "/dev/ttyUSB0";

/// Joins the lines of each paragraph (clap wraps paragraphs), and fits indented rows into 80 columns. Examples name the port as this
/// system does.
pub(super) fn laid_out(text: &str) -> String {
    let text = text.replace(PORT, ports::EXAMPLE);
    let mut rows: Vec<String> = Vec::new();
    let mut is_in_paragraph = false;
    for line in text.lines() {
        let is_prose = !line.is_empty() && !line.starts_with(' ');
        match rows.last_mut() {
            Some(paragraph) if is_prose && is_in_paragraph => {
                paragraph.push(' ');
                paragraph.push_str(line);
            }
            _ if is_prose || line.len() < COLUMNS => rows.push(line.to_owned()),
            _ => rows.extend(narrow(line)),
        }
        is_in_paragraph = is_prose;
    }
    rows.join("\n")
}

/// Wraps the second column of a row.
fn narrow(line: &str) -> Vec<String> {
    let Some((head, tail)) = line.rsplit_once("  ") else {
        return vec![line.to_owned()];
    };
    let at = line.len() - tail.len();
    let (first, at) = if at <= EXPLAINED_AT_MAX {
        (None, at)
    } else {
        (Some(head.trim_end().to_owned()), BELOW)
    };
    let room = COLUMNS - 1 - at;
    let mut explained = wrap(tail, room, room)
        .into_iter()
        .map(|row| format!("{:at$}{row}", ""));
    let beside = match first {
        Some(head) => head,
        None => explained.next().map_or_else(String::new, |row| {
            format!("{}{}", &line[..at], row.trim_start())
        }),
    };
    iter::once(beside).chain(explained).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paragraphs_are_joined_and_rows_fit_80_columns() {
        let text = "\
Examples:
  groundwave sim                            prints the path of a pseudo-terminal: cat it, tio it, watch it
  groundwave demo
  stop        motors off; needs no session and no proof of the sender, and every sender is believed

These two lines
are one paragraph.";
        let wanted = "\
Examples:
  groundwave sim
      prints the path of a pseudo-terminal: cat it, tio it, watch it
  groundwave demo
  stop        motors off; needs no session and no proof of the sender, and
              every sender is believed

These two lines are one paragraph.";
        assert_eq!(laid_out(text), wanted);
    }
}
