//! Splits bytes into lines, in bounded memory.

/// Maximum length of a line that either side accepts, bytes; the longest route needs less than half.
pub const LINE_MAX: usize = 16 * 1024;

/// A line is longer than [`LINE_MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a line is longer than {LINE_MAX} bytes")]
pub struct TooLong;

/// Splits bytes into lines.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    begun: Vec<u8>,
}

impl Lines {
    /// Takes bytes up to the end of a line. Returns the number of bytes taken (at least one unless `bytes` is empty) and the
    /// line without its line feed. A line that is too long is dropped.
    ///
    /// # Errors
    /// If the line grows too long.
    pub fn take(&mut self, bytes: &[u8]) -> (usize, Result<Option<Vec<u8>>, TooLong>) {
        let end = bytes.iter().position(|&byte| byte == b'\n');
        let run = &bytes[..end.unwrap_or(bytes.len())];
        if self.begun.len() + run.len() > LINE_MAX {
            self.begun.clear();
            return (end.map_or(bytes.len(), |end| end + 1), Err(TooLong));
        }
        self.begun.extend_from_slice(run);
        match end {
            Some(end) => (end + 1, Ok(Some(std::mem::take(&mut self.begun)))),
            None => (bytes.len(), Ok(None)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8], chunk: usize) -> Vec<Result<Vec<u8>, TooLong>> {
        let mut lines = Lines::default();
        let mut found = Vec::new();
        for mut chunk in bytes.chunks(chunk) {
            while !chunk.is_empty() {
                let (taken, line) = lines.take(chunk);
                found.extend(line.transpose());
                chunk = &chunk[taken..];
            }
        }
        found
    }

    #[test]
    fn lines_are_the_same_however_the_bytes_arrive() {
        let text = b"one\n\ntwo\nhalf";
        let wanted = vec![Ok(b"one".to_vec()), Ok(vec![]), Ok(b"two".to_vec())];
        for chunk in 1..=text.len() {
            assert_eq!(lines(text, chunk), wanted, "in chunks of {chunk}");
        }
    }

    #[test]
    fn a_line_without_an_end_is_refused_in_bounded_memory() {
        let flood = vec![b'x'; 4 * LINE_MAX];
        let found = lines(&flood, 100);
        assert!(!found.is_empty() && found.iter().all(Result::is_err));
        let longest = [vec![b'x'; LINE_MAX], b"\n".to_vec()].concat();
        assert_eq!(lines(&longest, 1000), [Ok(vec![b'x'; LINE_MAX])]);
    }
}
