//! Route files: one waypoint `X,Y` per line, in whole inches; `#` begins a comment.

use std::fmt::Write as _;

use groundwave_protocol::{WAYPOINT_LIMIT_IN, WAYPOINTS_MAX, Waypoint};

/// Reason why a text is not a route.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RouteError {
    /// A field is not a valid coordinate.
    #[error(
        "{file}:{line}:{column}: `{found}` is not a whole number of inches from -{WAYPOINT_LIMIT_IN} to {WAYPOINT_LIMIT_IN}; a line reads `X,Y`, and `#` begins a comment"
    )]
    Coordinate {
        /// Name of the file.
        file: String,
        /// Line of the text, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The text found.
        found: String,
    },
    /// A line does not contain two numbers.
    #[error(
        "{file}:{line}:{column}: `{found}` is not two numbers with a comma between them; a line reads `X,Y`, and `#` begins a comment"
    )]
    Shape {
        /// Name of the file.
        file: String,
        /// Line of the text, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The text found.
        found: String,
    },
    /// There are more waypoints than the robot can hold.
    #[error("{file}:{line}:1: this is waypoint {}; the robot holds {WAYPOINTS_MAX}", WAYPOINTS_MAX + 1)]
    TooMany {
        /// Name of the file.
        file: String,
        /// Line of the text, from 1.
        line: usize,
    },
    /// The file contains no waypoints.
    #[error(
        "{file}: no waypoints; write one `X,Y` per line, or use `clear` to delete the robot's route"
    )]
    Empty {
        /// Name of the file.
        file: String,
    },
}

/// Parses a route; errors name the `file`.
///
/// # Errors
/// The first mistake, with file, line and column.
pub fn parse(file: &str, text: &str) -> Result<Vec<Waypoint>, RouteError> {
    let mut waypoints = Vec::new();
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let content = line.split('#').next().unwrap_or_default();
        if content.trim().is_empty() {
            continue;
        }
        if waypoints.len() == WAYPOINTS_MAX {
            return Err(RouteError::TooMany {
                file: file.to_owned(),
                line: number,
            });
        }
        waypoints.push(parse_line(file, number, content)?);
    }
    if waypoints.is_empty() {
        return Err(RouteError::Empty {
            file: file.to_owned(),
        });
    }
    Ok(waypoints)
}

fn parse_line(file: &str, line: usize, content: &str) -> Result<Waypoint, RouteError> {
    let mut fields = Vec::new();
    let mut start = 0;
    for field in content.split(',') {
        let indent = field.len() - field.trim_start().len();
        let column = content[..start + indent].chars().count() + 1;
        fields.push((column, field.trim()));
        start += field.len() + 1;
    }
    let [(x_column, x), (y_column, y)] = fields[..] else {
        return Err(RouteError::Shape {
            file: file.to_owned(),
            line,
            column: fields
                .get(2)
                .or(fields.first())
                .map_or(1, |(column, _)| *column),
            found: content.trim().to_owned(),
        });
    };
    let part = |column, text: &str| {
        text.parse()
            .ok()
            .filter(|value| (-WAYPOINT_LIMIT_IN..=WAYPOINT_LIMIT_IN).contains(value))
            .ok_or_else(|| RouteError::Coordinate {
                file: file.to_owned(),
                line,
                column,
                found: text.to_owned(),
            })
    };
    Ok(Waypoint {
        x_in: part(x_column, x)?,
        y_in: part(y_column, y)?,
    })
}

/// Writes a route that [`parse`] reads back.
#[must_use]
pub fn format(waypoints: &[Waypoint]) -> String {
    waypoints.iter().fold(String::new(), |mut text, waypoint| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{}", waypoint.x_in, waypoint.y_in);
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_empty_lines_and_spaces_are_skipped() {
        let text = "\u{feff}# once around the sofa\r\n\r\n 48 , -12 # first\n0,0\n-9999,+9999\n";
        let wanted = [(48, -12), (0, 0), (-9999, 9999)].map(|(x_in, y_in)| Waypoint { x_in, y_in });
        assert_eq!(parse("r.txt", text), Ok(wanted.to_vec()));
    }

    #[test]
    fn formatted_route_parses_to_the_same() {
        let route: Vec<Waypoint> = (0..300)
            .map(|n| Waypoint {
                x_in: n - 150,
                y_in: 3 * n,
            })
            .collect();
        assert_eq!(parse("r.txt", &format(&route)), Ok(route));
    }

    #[test]
    fn errors_name_file_line_and_column() {
        for (text, message) in [
            ("1,2\n 3, four\n", "r.txt:2:5: `four` is not a whole number"),
            ("1,2\n10000,0\n", "r.txt:2:1: `10000` is not a whole number"),
            ("1.5,0\n", "r.txt:1:1: `1.5` is not"),
            ("1,2\n7\n", "r.txt:2:1: `7` is not two numbers"),
            (
                "X Y\n1,2\n",
                "r.txt:1:1: `X Y` is not two numbers with a comma",
            ),
            (
                "40 30\n",
                "r.txt:1:1: `40 30` is not two numbers with a comma",
            ),
            ("1,2,3\n", "r.txt:1:5: `1,2,3` is not two numbers"),
            ("# nothing\n", "r.txt: no waypoints"),
        ] {
            let error = parse("r.txt", text).expect_err(text).to_string();
            assert!(error.starts_with(message), "{error}");
        }
        let long = "0,0\n".repeat(301);
        let error = parse("r.txt", &long)
            .expect_err("301 waypoints")
            .to_string();
        assert!(
            error.starts_with("r.txt:301:1: this is waypoint 301"),
            "{error}"
        );
    }
}
