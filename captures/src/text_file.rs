//! Small text files that people write: labels, routes, scripts, configurations.

use std::fs;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use super::files;

/// Maximum length of a text in TOML, bytes. Its parser takes up to 230 times as much memory, and a label or a world may come from others.
pub const TOML_BYTES_MAX: u64 = 256 << 10;

/// Maximum length of any other text, bytes.
pub const BYTES_MAX: u64 = 4 << 20;

/// Reads a text file of at most `bytes_max`. Refuses pipes and devices, because opening one can block.
///
/// # Errors
/// If the file is not a regular file, is too long, is not UTF-8, or cannot be read.
pub fn read(path: &Path, bytes_max: u64) -> io::Result<String> {
    let about = fs::metadata(path)?;
    if about.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !about.is_file() {
        return Err(io::Error::other("it is not a regular file; choose a file"));
    }
    read_to_end(files::open(path)?, bytes_max)
}

/// Reads text of at most `bytes_max` from a stream to its end.
///
/// # Errors
/// If the text is too long, is not UTF-8, or cannot be read.
pub fn read_to_end(source: impl Read, bytes_max: u64) -> io::Result<String> {
    let mut bytes = Vec::new();
    source.take(bytes_max + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > bytes_max {
        let most = match bytes_max >> 20 {
            0 => format!("{} KiB", bytes_max >> 10),
            mib => format!("{mib} MiB"),
        };
        return Err(io::Error::new(
            ErrorKind::FileTooLarge,
            format!("it is longer than {most}; make it shorter, or choose another file"),
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
        let kind = |path: &Path| read(path, BYTES_MAX).unwrap_err().kind();
        fs::write(&path, "1,2\n").unwrap();
        assert_eq!(read(&path, BYTES_MAX).unwrap(), "1,2\n");
        fs::write(&path, [0xff]).unwrap();
        assert_eq!(kind(&path), ErrorKind::InvalidData);
        let file = fs::File::create(&path).unwrap();
        file.set_len(BYTES_MAX).unwrap();
        assert_eq!(read(&path, BYTES_MAX).unwrap().len() as u64, BYTES_MAX);
        file.set_len(BYTES_MAX + 1).unwrap();
        assert_eq!(kind(&path), ErrorKind::FileTooLarge);
        assert_eq!(kind(folder.path()), ErrorKind::IsADirectory);
        assert_eq!(kind(&folder.path().join("none")), ErrorKind::NotFound);
        #[cfg(unix)]
        assert_eq!(kind(Path::new("/dev/zero")), ErrorKind::Other);
    }
}
