//! Reads the values of lines from bytes.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use regex::Regex;

use crate::checksum::Checksum;
use crate::field::{Field, is_name};
use crate::forms::csv::{Columns, Row};
use crate::forms::{self, Cell, CellValue, Origin};
use crate::profile::{Form, Profile, ProfileError};
use crate::runs::line_bytes;
use crate::{FIELDS_MAX, LINE_BYTES_MAX, TEXT_CHARS_MAX};

/// Number of consecutive lines without a value after which an unknown robot's text is shown.
const TEXTS_MIN: u8 = 3;

/// Lengths of Groundwave's lines without line ends; a damaged Groundwave line must not count as text.
const WIRE_LENGTHS: [usize; 2] = [78, 12];

/// A line of the robot's own.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLine {
    /// The line without its end, at most [`TEXT_CHARS_MAX`] characters; bytes that are not text are replaced.
    pub text: String,
    /// Content of the line.
    pub content: Content,
}

/// Content of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Values; empty if the line has none in its form.
    Values(Vec<Sample>),
    /// Text without a value.
    Text,
    /// The line is unreadable: the checksum is wrong, or the line is not text or too long.
    Damaged,
}

/// A value of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The field; all samples of a field share one allocation.
    pub field: Arc<Field>,
    /// Value of the field.
    pub value: Value,
}

/// The value of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A finite number, scaled.
    Number(f64),
    /// Text, at most [`TEXT_CHARS_MAX`] characters.
    Text(Arc<str>),
}

/// Finds values in received bytes.
#[derive(Clone, Debug)]
pub struct Recognizer {
    form: Form,
    checksum: Checksum,
    pattern: Option<Regex>,
    replies: Vec<String>,
    columns: Columns,
    origin: Origin,
    /// Fields, by their name in the line.
    fields: BTreeMap<String, Arc<Field>>,
    left_out: u64,
    /// The unfinished line.
    line: Vec<u8>,
    is_too_long: bool,
    /// Whether the beginning of the current line is missing.
    is_skipping: bool,
    /// Whether the beginning of the current line may be missing.
    is_first: bool,
    standing: Standing,
}

/// Knowledge about a robot's lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    /// The lines are the robot's own, by a profile.
    Configured,
    /// It is unknown whether the lines are the robot's own; contains the number of consecutive lines of text.
    Unknown(u8),
    /// The lines are the robot's own.
    Own,
    /// The lines are Groundwave's.
    Wire,
}

impl Default for Recognizer {
    fn default() -> Self {
        Self {
            form: Form::Auto,
            checksum: Checksum::None,
            pattern: None,
            replies: Vec::new(),
            columns: Columns::default(),
            origin: Origin::default(),
            fields: BTreeMap::new(),
            left_out: 0,
            line: Vec::new(),
            is_too_long: false,
            is_skipping: false,
            is_first: true,
            standing: Standing::Unknown(0),
        }
    }
}

impl Recognizer {
    /// A recognizer for the lines that a profile describes; [`Recognizer::default`] has no profile.
    ///
    /// # Errors
    /// A mistake in the profile.
    pub fn new(profile: &Profile) -> Result<Self, ProfileError> {
        let pattern = profile.compile()?;
        let columns = match profile.form {
            Form::Csv => Columns::of(&profile.fields),
            _ => Columns::default(),
        };
        let fields = profile.fields.iter();
        Ok(Self {
            form: profile.form,
            checksum: profile.checksum,
            pattern,
            replies: profile.replies.clone(),
            columns,
            fields: fields
                .map(|field| (field.name.clone(), Arc::new(field.clone())))
                .collect(),
            standing: Standing::Configured,
            ..Self::default()
        })
    }

    /// The fields found so far and those of the profile, sorted by name.
    pub fn fields(&self) -> impl Iterator<Item = &Arc<Field>> {
        self.fields.values()
    }

    /// Number of values left out because there were already [`FIELDS_MAX`] fields.
    #[must_use]
    pub const fn left_out(&self) -> u64 {
        self.left_out
    }

    /// Drops the unfinished line, because bytes are missing.
    pub fn interrupt(&mut self) {
        self.line.clear();
        self.is_too_long = false;
        self.is_skipping = true;
        self.columns.interrupt();
    }

    /// Begins again on a newly opened link: the robot may be another one, and its first line may lack its beginning.
    pub fn reopen(&mut self) {
        self.interrupt();
        self.is_skipping = false;
        self.is_first = true;
        if self.standing == Standing::Wire {
            self.standing = Standing::Unknown(0);
        }
    }

    /// Takes one of the [`runs`](crate::runs()) of bytes, and whether it ended an intact Groundwave line. Returns
    /// the ended line, unless it is Groundwave's, empty, a header, or from a robot whose form is not known yet.
    pub fn take(&mut self, run: &[u8], is_wire: bool) -> Option<OwnLine> {
        if is_wire {
            self.line.clear();
            (self.is_too_long, self.is_skipping, self.is_first) = (false, false, false);
            if self.standing != Standing::Configured {
                self.standing = Standing::Wire;
            }
            return None;
        }
        if self.standing == Standing::Wire {
            return None;
        }
        let is_empty = self.line.is_empty() && !self.is_too_long && run.starts_with(b"\n");
        if is_empty {
            (self.is_skipping, self.is_first) = (false, false);
            return None;
        }
        let Some((b'\n', end)) = run[..line_bytes(run)].split_last() else {
            self.keep(run);
            return None;
        };
        let mut line = std::mem::take(&mut self.line);
        let is_too_long =
            std::mem::take(&mut self.is_too_long) || line.len() + end.len() > LINE_BYTES_MAX;
        line.extend_from_slice(&end[..end.len().min(LINE_BYTES_MAX)]);
        let bytes = line.trim_ascii_end();
        let content = match bytes {
            _ if std::mem::take(&mut self.is_skipping) => None,
            _ if is_too_long => self.damaged(),
            [] => None,
            bytes => self.read(bytes),
        };
        self.is_first = false;
        let own = content.map(|content| OwnLine {
            text: cut(&String::from_utf8_lossy(bytes)).to_owned(),
            content,
        });
        line.clear();
        self.line = line;
        own
    }

    fn keep(&mut self, run: &[u8]) {
        self.is_too_long |= self.line.len() + run.len() > LINE_BYTES_MAX;
        if !self.is_too_long {
            self.line.extend_from_slice(run);
        }
    }

    /// The content of an unreadable line; `None` for noise before the robot's first line.
    fn damaged(&self) -> Option<Content> {
        let is_known = matches!(self.standing, Standing::Own | Standing::Configured);
        is_known.then_some(Content::Damaged)
    }

    fn read(&mut self, line: &[u8]) -> Option<Content> {
        let is_control = |c: char| c.is_control() && c != '\t';
        let Some(text) = str::from_utf8(line)
            .ok()
            .filter(|text| !text.contains(is_control))
        else {
            self.columns.interrupt();
            return self.damaged();
        };
        let Some(content) = self.checksum.strip(text) else {
            return self.damaged();
        };
        if self.replies.iter().any(|reply| begins_with(content, reply)) {
            return self.take_text(content);
        }
        let Some(found) = self.cells(content) else {
            return self.take_text(content);
        };
        let Found::Cells(cells) = found else {
            return None;
        };
        // The first line may lack its beginning, including names.
        let is_known = |cell: &Cell<'_>| self.fields.contains_key(cell.name.as_ref());
        let is_named = !content.starts_with(['{', '$', '>']);
        if self.is_first && is_named && !cells.iter().all(is_known) {
            return None;
        }
        if self.standing != Standing::Configured {
            self.standing = Standing::Own;
        }
        Some(Content::Values(self.samples(cells)))
    }

    fn cells<'a>(&mut self, line: &'a str) -> Option<Found<'a>> {
        let cells = match self.form {
            Form::Csv => return self.row(line),
            Form::Pairs => forms::pairs(line),
            Form::Json => forms::json(line),
            Form::Nmea => forms::nmea(line, &mut self.origin),
            Form::Teleplot => forms::teleplot(line),
            Form::Regex => self.groups(line),
            Form::ArduinoPlotter => match forms::pairs(line) {
                None => return self.row(line),
                cells => cells,
            },
            Form::Auto => match line.as_bytes().first() {
                Some(b'{') => forms::json(line),
                Some(b'$') => forms::nmea(line, &mut self.origin),
                Some(b'>') => forms::teleplot(line),
                _ => match forms::pairs(line) {
                    None => return self.row(line),
                    cells => cells,
                },
            },
        };
        cells.map(Found::Cells)
    }

    fn row<'a>(&mut self, line: &'a str) -> Option<Found<'a>> {
        Some(match self.columns.take(line)? {
            Row::Values { cells, is_sure } if is_sure || self.standing == Standing::Configured => {
                Found::Cells(cells)
            }
            Row::Values { .. } | Row::Header => Found::Nothing,
        })
    }

    fn groups<'a>(&self, line: &'a str) -> Option<Vec<Cell<'a>>> {
        let pattern = self.pattern.as_ref()?;
        let groups = pattern.captures(line)?;
        let names = pattern.capture_names().flatten();
        let cells = names.filter_map(|name| {
            let word = groups.name(name)?.as_str();
            let text = || CellValue::Text(Cow::Borrowed(word));
            let value = forms::number(word.trim()).unwrap_or_else(text);
            Some(Cell::new(name.to_owned(), value))
        });
        Some(cells.collect())
    }

    fn take_text(&mut self, text: &str) -> Option<Content> {
        if let Standing::Unknown(lines) = &mut self.standing {
            if WIRE_LENGTHS.contains(&text.len()) || text.chars().count() < 2 {
                *lines = 0;
                return None;
            }
            *lines += 1;
            if *lines < TEXTS_MIN {
                return None;
            }
            self.standing = Standing::Own;
        }
        Some(Content::Text)
    }

    fn samples(&mut self, cells: Vec<Cell<'_>>) -> Vec<Sample> {
        let mut samples = Vec::with_capacity(cells.len());
        for cell in cells {
            let Some(field) = self.field(&cell) else {
                continue;
            };
            let value = match cell.value {
                CellValue::Number(number) => number * field.scale + field.offset,
                CellValue::Text(text) => {
                    let value = Value::Text(cut(&text).into());
                    samples.push(Sample { field, value });
                    continue;
                }
                CellValue::Missing => continue,
            };
            if value.is_finite() {
                let value = Value::Number(value);
                samples.push(Sample { field, value });
            }
        }
        samples
    }

    /// The field of a cell; creates an unknown field. `None` if there are too many.
    fn field(&mut self, cell: &Cell<'_>) -> Option<Arc<Field>> {
        if let Some(field) = self.fields.get(cell.name.as_ref()) {
            return Some(Arc::clone(field));
        }
        if self.fields.len() >= FIELDS_MAX || !is_name(&cell.name) {
            self.left_out += 1;
            return None;
        }
        let unit = cell.unit.or_else(|| self.columns.unit(&cell.name));
        let field = Arc::new(Field {
            role: cell.role,
            ..Field::named(&cell.name, unit)
        });
        self.fields
            .insert(cell.name.clone().into_owned(), Arc::clone(&field));
        Some(field)
    }
}

/// Whether a line begins with these words: not with the beginning of a longer one.
fn begins_with(line: &str, words: &str) -> bool {
    line.strip_prefix(words).is_some_and(|rest| {
        !(words.ends_with(char::is_alphanumeric) && rest.starts_with(char::is_alphanumeric))
    })
}

enum Found<'a> {
    Cells(Vec<Cell<'a>>),
    /// No values: a header, or columns that the next line must confirm.
    Nothing,
}

/// The first characters of a text.
fn cut(text: &str) -> &str {
    let end = text.char_indices().nth(TEXT_CHARS_MAX);
    end.map_or(text, |(at, _)| &text[..at])
}
