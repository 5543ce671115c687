//! Hints for errors of the operating system about files.

use std::io;
use std::path::Path;

/// A file name quoted for a shell, so that it can be copied from a hint.
#[must_use]
pub fn shell_word(path: &Path) -> String {
    let name = path.display().to_string();
    // The folder keeps a leading dash from being read as an option.
    let name = if name.starts_with('-') && name != "-" {
        format!("./{name}")
    } else {
        name
    };
    let separates = if cfg!(windows) { '\\' } else { '/' };
    let is_plain = |letter: char| {
        letter.is_alphanumeric() || letter == separates || "/._-+=:,@%".contains(letter)
    };
    if !name.is_empty() && name.chars().all(is_plain) {
        name
    } else if cfg!(windows) {
        format!("\"{name}\"")
    } else {
        format!("'{}'", name.replace('\'', r"'\''"))
    }
}

/// A message without the numbers of the operating system's errors, which say nothing to a person.
#[must_use]
pub fn without_numbers(message: &str) -> String {
    let mut parts = message.split(" (os error ");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once(')') {
            Some((number, rest)) if number.parse::<i32>().is_ok() => text.push_str(rest),
            _ => text.extend([" (os error ", part]),
        }
    }
    text
}

/// Why a file cannot be read, and what to do.
#[must_use]
pub fn of_reading(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "file not found; check the path".to_owned(),
        io::ErrorKind::IsADirectory => {
            "it is a folder; name a file in it, or a quoted pattern: 'FOLDER/*.mcap'".to_owned()
        }
        io::ErrorKind::PermissionDenied => {
            "permission denied; `ls -l` shows who may read it".to_owned()
        }
        io::ErrorKind::InvalidData => "it is not text; name a text file".to_owned(),
        _ => without_numbers(&error.to_string()),
    }
}

/// Why a file cannot be written, and what to do.
#[must_use]
pub fn of_writing(error: &io::Error) -> String {
    let hint = match error.kind() {
        io::ErrorKind::NotFound => return "folder not found; create the folder first".to_owned(),
        io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
            "; a file has the name of the folder"
        }
        io::ErrorKind::IsADirectory => "; name a file in it",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "; free some space",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "; choose a writable folder"
        }
        _ => "",
    };
    format!("{}{hint}", without_numbers(&error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn quoted_name_is_one_word_for_a_shell() {
        for name in [
            "run.mcap",
            "/tmp/my run 1.mcap",
            "it's.mcap",
            "--help",
            "$HOME;ls",
            "~x",
            "Straße.mcap",
        ] {
            let line = format!("printf %s {}", shell_word(Path::new(name)));
            let said = std::process::Command::new("sh")
                .args(["-c", &line])
                .output();
            let said = String::from_utf8(said.unwrap().stdout).unwrap();
            assert_eq!(said.trim_start_matches("./"), name, "{line}");
        }
        assert_eq!(shell_word(Path::new("a/run.mcap")), "a/run.mcap");
    }

    #[test]
    fn numbers_of_errors_are_removed() {
        let error = io::Error::from_raw_os_error(2).to_string();
        let message = without_numbers(&format!("cannot do it: {error}; try again ({error})"));
        assert!(!message.contains("os error"), "{message}");
        assert!(message.contains("; try again ("), "{message}");
        for text in ["", "a (os error", "a (os error x) b", "a (os error 2"] {
            assert_eq!(without_numbers(text), text);
        }
    }

    #[test]
    fn common_read_errors_have_a_hint() {
        for kind in [
            io::ErrorKind::NotFound,
            io::ErrorKind::IsADirectory,
            io::ErrorKind::PermissionDenied,
            io::ErrorKind::InvalidData,
        ] {
            let words = of_reading(&kind.into());
            assert!(words.contains("; "), "{words}");
        }
        let other = io::Error::other("the disk is on fire");
        assert_eq!(of_reading(&other), "the disk is on fire");
    }
}
