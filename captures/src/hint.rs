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

/// Describes an error of the operating system in words; all messages use this text.
#[must_use]
pub fn words(error: &io::Error) -> String {
    if error.get_ref().is_some() {
        return plain(&error.to_string());
    }
    let words = match error.kind() {
        io::ErrorKind::StorageFull => "the disk is full",
        io::ErrorKind::QuotaExceeded => "your share of the disk is used up",
        io::ErrorKind::FileTooLarge => "the file would be larger than the system allows",
        io::ErrorKind::ReadOnlyFilesystem => "the disk is read-only",
        io::ErrorKind::NotFound => "not found",
        io::ErrorKind::PermissionDenied => "permission denied",
        io::ErrorKind::AddrInUse => "another program uses the address",
        io::ErrorKind::BrokenPipe => "the other end closed the connection",
        io::ErrorKind::ConnectionReset | io::ErrorKind::ConnectionAborted => {
            "the other end broke the connection"
        }
        _ if error
            .raw_os_error()
            .is_some_and(|number| NO_MORE_FILES.contains(&number)) =>
        {
            "too many open files; raise their limit with `ulimit -n`"
        }
        _ => return in_lower_case(&system_words(error)),
    };
    words.to_owned()
}

/// Unix error numbers for too many open files, in the program and in the system.
const NO_MORE_FILES: &[i32] = if cfg!(unix) { &[24, 23] } else { &[] };

/// The system's description of an error, without the error number.
fn system_words(error: &io::Error) -> String {
    let text = error.to_string();
    match next_number(&text) {
        Some((words, ..)) => words.to_owned(),
        None => text,
    }
}

/// The text with its first letter in lower case, unless the first word is an abbreviation.
fn in_lower_case(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) if letters.as_str().starts_with(char::is_lowercase) => {
            first.to_lowercase().collect::<String>() + letters.as_str()
        }
        _ => text.to_owned(),
    }
}

/// A message of another library, with the system's errors in it replaced by [`words`].
#[must_use]
pub fn plain(message: &str) -> String {
    let mut text = String::new();
    let mut rest = message;
    while let Some((before, number, after)) = next_number(rest) {
        let error = io::Error::from_raw_os_error(number);
        match before.strip_suffix(&system_words(&error)) {
            Some(before) => text.extend([before, &words(&error)]),
            None => text.push_str(before),
        }
        rest = after;
    }
    text + rest
}

/// Finds the first "(os error N)"; returns the text before it, the number and the text after it.
fn next_number(text: &str) -> Option<(&str, i32, &str)> {
    let begin = " (os error ";
    text.match_indices(begin).find_map(|(at, _)| {
        let (number, after) = text[at + begin.len()..].split_once(')')?;
        Some((&text[..at], number.parse().ok()?, after))
    })
}

/// Reason why a file cannot be read, with a hint.
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
        _ => words(error),
    }
}

/// Reason why a file cannot be written, with a hint.
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
    format!("{}{hint}", words(error))
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
    fn errors_of_the_system_are_worded() {
        let error = io::Error::from_raw_os_error(2).to_string();
        let message = plain(&format!("cannot do it: {error}; try again ({error})"));
        assert_eq!(message, "cannot do it: not found; try again (not found)");
        for text in ["", "a (os error", "a (os error x) b", "a (os error 2"] {
            assert_eq!(plain(text), text);
        }
        assert_eq!(plain("it failed (os error 2)."), "it failed.");
        let own = io::Error::new(io::ErrorKind::NotFound, "no such robot");
        assert_eq!(words(&own), "no such robot");
    }

    #[cfg(unix)]
    #[test]
    fn no_error_of_the_system_shows_its_number() {
        for number in 1..=200 {
            let words = words(&io::Error::from_raw_os_error(number));
            assert!(!words.contains("os error") && !words.is_empty(), "{words}");
        }
        let words = |number| words(&io::Error::from_raw_os_error(number));
        assert_eq!(words(28), "the disk is full");
        let of_glibc_or_musl = ["input/output error", "I/O error"];
        assert!(of_glibc_or_musl.contains(&&*words(5)), "{}", words(5));
        assert!(words(24).contains("`ulimit -n`"));
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
