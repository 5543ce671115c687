//! The operator's label of a run, in a small TOML file beside its capture.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::event::Remark;
use crate::hint::words;
use crate::text_file;

/// A run's name and remarks, and whether the run is void.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Label {
    /// Name of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Reason why the run is void; `None` if it is valid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub void: Option<String>,
    /// Remarks in the order they were made.
    #[serde(default, rename = "note", skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<Note>,
}

/// A remark.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Note {
    /// Time of the remark, seconds since the capture began; `None` for a remark about the whole run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
    /// Text of the remark.
    pub text: String,
}

/// The hint for an error of writing a label; may be empty.
fn hint(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; the label is kept beside its capture: copy the capture to a writable folder"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "; make room",
        _ => "",
    }
}

/// A label could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum LabelError {
    /// The operating system reported an error.
    #[error("cannot {action} {}: {}{}", path.display(), words(error), hint(error))]
    File {
        /// The action that failed.
        action: &'static str,
        /// The label's file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// The file cannot be parsed; it is not changed.
    #[error("{} is not a valid label: {problem}; correct it, or delete it to start again", path.display())]
    Malformed {
        /// The label's file.
        path: PathBuf,
        /// The mistake and its place.
        problem: String,
    },
}

/// End of the name of a label.
const SUFFIX: &str = ".run.toml";

/// Path of the label of a capture: `evening.mcap.run.toml`.
#[must_use]
pub fn file_of(capture: &Path) -> PathBuf {
    let mut name = capture.as_os_str().to_owned();
    name.push(SUFFIX);
    name.into()
}

/// Whether the path is the path of a label.
#[must_use]
pub fn is_label(path: &Path) -> bool {
    path.as_os_str()
        .as_encoded_bytes()
        .ends_with(SUFFIX.as_bytes())
}

impl Label {
    /// The label of a capture; an empty label if there is no file.
    ///
    /// # Errors
    /// If the file cannot be read or parsed.
    pub fn of(capture: &Path) -> Result<Self, LabelError> {
        let path = file_of(capture);
        let text = match text_file::read(&path, text_file::TOML_BYTES_MAX) {
            Ok(text) => text,
            // A label's name is longer than its capture's.
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::NotFound | ErrorKind::InvalidFilename
                ) =>
            {
                return Ok(Self::default());
            }
            Err(error) => {
                return Err(LabelError::File {
                    action: "read",
                    path,
                    error,
                });
            }
        };
        Self::parse(&text).map_err(|problem| LabelError::Malformed { path, problem })
    }

    /// Reads a label from its text.
    ///
    /// # Errors
    /// The mistake and its place.
    pub fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let before = text.get(..at).unwrap_or(text);
            let line = before.matches('\n').count() + 1;
            format!("line {line}: {}", error.message())
        })
    }

    /// Saves the label beside the capture. After a failure, the old label is intact.
    ///
    /// # Errors
    /// If the label cannot be written.
    pub fn keep(&self, capture: &Path) -> Result<(), LabelError> {
        let path = file_of(capture);
        self.write(&path).map_err(|error| LabelError::File {
            action: "write",
            path,
            error,
        })
    }

    fn write(&self, path: &Path) -> io::Result<()> {
        let text = toml::to_string(self).map_err(io::Error::other)?;
        if text.len() as u64 > text_file::TOML_BYTES_MAX {
            return Err(io::Error::other(
                "it has too many notes; begin a shorter label",
            ));
        }
        let mut new = path.as_os_str().to_owned();
        new.push(".new");
        let new = PathBuf::from(new);
        // A file that an interrupted attempt left.
        let _ = fs::remove_file(&new);
        let mut file = File::create_new(&new)?;
        file.write_all(text.as_bytes())
            .and_then(|()| file.sync_all())
            .and_then(|()| fs::rename(&new, path))
            .inspect_err(|_| {
                // An incomplete file is useless.
                let _ = fs::remove_file(&new);
            })
    }

    /// Applies a remark of the operator. `at_s` is the time of a note, seconds since the capture began; other remarks have none.
    pub fn take(&mut self, at_s: Option<f64>, remark: &Remark) {
        match remark {
            Remark::Name(name) => self.name = Some(name.clone()),
            Remark::Note(text) => self.remark(at_s, text),
            Remark::Void(reason) => self.void = Some(reason.clone()),
            Remark::Counts => self.void = None,
        }
    }

    /// Removes and returns the notes close to a moment, seconds since the capture began.
    pub fn remove_notes(&mut self, at_s: f64, reach_s: f64) -> Vec<Note> {
        let is_close = |note: &mut Note| {
            note.at_s
                .is_some_and(|noted_s| (noted_s - at_s).abs() < reach_s)
        };
        self.notes.extract_if(.., is_close).collect()
    }

    /// Adds a remark about a moment or the whole run.
    pub fn remark(&mut self, at_s: Option<f64>, text: &str) {
        self.notes.push(Note {
            at_s,
            text: text.to_owned(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Some names of captures are too long for a label beside them.
    #[test]
    fn a_long_name_has_no_label() {
        let folder = tempfile::tempdir().unwrap();
        let capture = folder.path().join("a".repeat(250) + ".txt");
        assert_eq!(Label::of(&capture).unwrap(), Label::default());
    }

    proptest! {
        #[test]
        fn kept_label_is_read_again(
            name in proptest::option::of(".{0,40}"),
            void in proptest::option::of(".{0,40}"),
            notes in proptest::collection::vec((proptest::option::of(0.0..1e6_f64), ".{0,60}"), 0..5),
        ) {
            let folder = tempfile::tempdir().unwrap();
            let capture = folder.path().join("evening.mcap");
            let mut label = Label { name, void, notes: Vec::new() };
            for (at_s, text) in notes {
                label.remark(at_s, &text);
            }
            label.keep(&capture).unwrap();
            prop_assert_eq!(Label::of(&capture).unwrap(), label);
            prop_assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        }
    }

    #[test]
    fn notes_close_to_a_moment_are_removed() {
        let mut label = Label::default();
        for (at_s, text) in [(None, "whole"), (Some(1.0), "here"), (Some(1.3), "close")] {
            label.remark(at_s, text);
        }
        let removed = label.remove_notes(1.1, 0.25);
        let texts: Vec<&str> = removed.iter().map(|note| &*note.text).collect();
        assert_eq!(texts, ["here", "close"]);
        assert_eq!(label.remove_notes(1.1, 0.25), []);
        assert_eq!(label.notes.len(), 1);
        assert_eq!(label.notes[0].text, "whole");
    }

    #[test]
    fn without_a_label_there_is_nothing_to_say() {
        let folder = tempfile::tempdir().unwrap();
        let label = Label::of(&folder.path().join("none.mcap")).unwrap();
        assert_eq!(label, Label::default());
    }

    #[test]
    fn a_folder_that_may_not_be_written_has_a_remedy() {
        let error = LabelError::File {
            action: "write",
            path: "run.mcap.run.toml".into(),
            error: ErrorKind::PermissionDenied.into(),
        };
        let said = error.to_string();
        assert!(
            said.contains("copy the capture to a writable folder"),
            "{said}"
        );
    }

    #[test]
    fn an_unreadable_label_is_reported_and_not_changed() {
        let folder = tempfile::tempdir().unwrap();
        let capture = folder.path().join("evening.mcap");
        fs::write(file_of(&capture), "name = \"x\"\nvoide = \"y\"\n").unwrap();
        let error = Label::of(&capture).unwrap_err().to_string();
        assert!(error.contains("evening.mcap.run.toml"), "{error}");
        assert!(error.contains("line 2"), "{error}");
        assert!(error.contains("voide"), "{error}");
    }
}
