//! Small text files that people write: labels, routes, scripts, configurations.

use std::fs;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use super::files;

/// Maximum length of a text file, bytes (4 MiB).
const BYTES_MAX: u64 = 4 << 20;

/// Reads a text file. Refuses pipes and devices, because opening one can block.
///
/// # Errors
/// If the file is not a regular file, is longer than 4 MiB, is not UTF-8, or cannot be read.
pub fn read(path: &Path) -> io::Result<String> {
    let about = fs::metadata(path)?;
    if about.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !about.is_file() {
        return Err(io::Error::other("it is not a regular file; choose a file"));
    }
    read_to_end(files::open(path)?)
}

/// Reads text from a stream to its end.
///
/// # Errors
/// If the text is longer than 4 MiB, is not UTF-8, or cannot be read.
pub fn read_to_end(source: impl Read) -> io::Result<String> {
    let mut bytes = Vec::new();
    source.take(BYTES_MAX + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(io::Error::new(
            ErrorKind::FileTooLarge,
            "it is longer than 4 MiB; choose a text file",
        ));
    }
    String::from_utf8(bytes).map_err(|_| ErrorKind::InvalidData.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_short_text_in_a_regular_file_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let kind = |path: &Path| read(path).unwrap_err().kind();
        fs::write(&path, "1,2\n").unwrap();
        assert_eq!(read(&path).unwrap(), "1,2\n");
        fs::write(&path, [0xff]).unwrap();
        assert_eq!(kind(&path), ErrorKind::InvalidData);
        let file = fs::File::create(&path).unwrap();
        file.set_len(BYTES_MAX).unwrap();
        assert_eq!(read(&path).unwrap().len() as u64, BYTES_MAX);
        file.set_len(BYTES_MAX + 1).unwrap();
        assert_eq!(kind(&path), ErrorKind::FileTooLarge);
        assert_eq!(kind(folder.path()), ErrorKind::IsADirectory);
        assert_eq!(kind(&folder.path().join("none")), ErrorKind::NotFound);
        #[cfg(unix)]
        assert_eq!(kind(Path::new("/dev/zero")), ErrorKind::Other);
    }
}
