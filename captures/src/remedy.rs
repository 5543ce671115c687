//! What the operating system says of a file, in words for a person, with what to do about it.

use std::io;
use std::path::Path;

/// The name of a file as a shell takes it: what a person copies out of a remedy works, blanks or not.
#[must_use]
pub fn shell_word(path: &Path) -> String {
    let name = path.display().to_string();
    // An option is none behind a folder.
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

/// Why a file cannot be read.
#[must_use]
pub fn of_reading(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => {
            "there is no such file; look whether the name and the folder are right".to_owned()
        }
        io::ErrorKind::IsADirectory => {
            "it is a folder; name a file in it, or several in quotes: 'FOLDER/*.mcap'".to_owned()
        }
        io::ErrorKind::PermissionDenied => "you may not read it; `ls -l` shows who may".to_owned(),
        io::ErrorKind::InvalidData => "it is no text; name a text file".to_owned(),
        _ => error.to_string(),
    }
}

/// Why a file cannot be written.
#[must_use]
pub fn of_writing(error: &io::Error) -> String {
    let remedy = match error.kind() {
        io::ErrorKind::NotFound => "; make the directory first",
        io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
            "; a file stands where the directory should be"
        }
        io::ErrorKind::IsADirectory => "; name a file in it",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "; make room",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "; choose a directory you may write to"
        }
        _ => "",
    };
    format!("{error}{remedy}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_shell_takes_a_name_for_one_word() {
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
    fn what_happens_to_people_has_a_remedy() {
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
