//! What the operating system says of a file, in words for a person, with what to do about it.

use std::io;

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

#[cfg(test)]
mod tests {
    use super::*;

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
