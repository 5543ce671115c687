//! Raw captures: the bytes of the radio, and nothing else.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};

use super::error::create;
use super::source::Chunk;
use super::{CaptureError, Existing, presence};

/// Appends what is read from the radio to a file, each read in one write and without a buffer, so that
/// a killed program has lost nothing.
#[derive(Debug)]
pub struct RawWriter {
    path: PathBuf,
    file: File,
    bytes: u64,
    problem: Option<CaptureError>,
    /// The file is not where its name says.
    gone: Option<CaptureError>,
}

impl RawWriter {
    /// Creates the file.
    ///
    /// # Errors
    /// When it exists and may not be touched, or cannot be made.
    pub fn create(path: impl Into<PathBuf>, existing: Existing) -> Result<Self, CaptureError> {
        let path = path.into();
        Ok(Self {
            file: create(&path, existing, true)?,
            path,
            bytes: 0,
            problem: None,
            gone: None,
        })
    }

    /// Writes what was just read, before anything else sees it. Nothing here fails: after an error
    /// nothing more is written, so that the file is exactly the beginning of the stream;
    /// [`Self::problem`] and [`Self::finish`] tell.
    pub fn write(&mut self, bytes: &[u8]) {
        if self.problem.is_some() {
            return;
        }
        if let Err(error) = self.write_all(bytes) {
            self.problem = Some(CaptureError::Write {
                path: self.path.clone(),
                error,
            });
        }
    }

    fn write_all(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            match self.file.write(bytes) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(written) => {
                    self.bytes += written as u64;
                    bytes = &bytes[written..];
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Looks whether the file is still where its name says; [`Self::problem`] tells. What comes is written
    /// on even if it is not, for a file that was only moved has it.
    pub fn look(&mut self) {
        if self.gone.is_none() {
            self.gone = presence::check(&self.file, &self.path).err();
        }
    }

    /// Waits until the disk has everything; returns how many bytes that is.
    ///
    /// # Errors
    /// What went wrong since the start, that the file was taken away, or that the disk will not. A pipe or a device that knows nothing
    /// of disks has had its bytes when it took them.
    pub fn finish(mut self) -> Result<u64, CaptureError> {
        self.look();
        if let Some(problem) = self.problem.or(self.gone) {
            return Err(problem);
        }
        let Err(error) = self.file.sync_data() else {
            return Ok(self.bytes);
        };
        let has_no_disk = matches!(
            error.kind(),
            io::ErrorKind::InvalidInput
                | io::ErrorKind::Unsupported
                | io::ErrorKind::ReadOnlyFilesystem
        );
        let is_file = self.file.metadata().is_ok_and(|about| about.is_file());
        if has_no_disk && !is_file {
            return Ok(self.bytes);
        }
        Err(CaptureError::Write {
            path: self.path,
            error,
        })
    }

    /// Where the bytes go.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes written.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Why writing has ended, or why it leads nowhere.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let problem = self.problem.as_ref().or(self.gone.as_ref());
        problem.map(ToString::to_string)
    }
}

const BUFFER_BYTES: usize = 64 * 1024;

/// Reads a raw capture line by line, noise or not.
///
/// The time of each chunk is that of a 2400-baud radio that never paused. Chunks end after a line
/// feed, or after 80 bytes without one, however the bytes arrive.
pub struct RawReader<R> {
    source: R,
    buffer: Box<[u8]>,
    /// What has been read and not yet given out.
    unread: std::ops::Range<usize>,
    ended: bool,
    offset: u64,
}

impl<R: Read> RawReader<R> {
    /// A reader from the beginning of `source`.
    pub fn new(source: R) -> Self {
        Self {
            source,
            buffer: vec![0; BUFFER_BYTES].into(),
            unread: 0..0,
            ended: false,
            offset: 0,
        }
    }

    /// The next bytes and when their last one arrived.
    ///
    /// # Errors
    /// When reading fails.
    pub fn next_chunk(&mut self) -> io::Result<Option<Chunk<'_>>> {
        let length = loop {
            let unread = &self.buffer[self.unread.clone()];
            let reach = unread.len().min(LINE_BYTES);
            if let Some(line_feed) = unread[..reach].iter().position(|&b| b == b'\n') {
                break line_feed + 1;
            }
            if reach == LINE_BYTES || self.ended {
                break reach;
            }
            self.fill()?;
        };
        if length == 0 {
            return Ok(None);
        }
        let start = self.unread.start;
        self.unread.start += length;
        self.offset += length as u64;
        Ok(Some(Chunk {
            at: on_the_wire(self.offset),
            bytes: &self.buffer[start..start + length],
        }))
    }

    fn fill(&mut self) -> io::Result<()> {
        self.buffer.copy_within(self.unread.clone(), 0);
        self.unread = 0..self.unread.len();
        let read = loop {
            match self.source.read(&mut self.buffer[self.unread.end..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => break read?,
            }
        };
        self.unread.end += read;
        self.ended = read == 0;
        Ok(())
    }
}

/// How long so many bytes take at 2400 baud.
pub(super) fn on_the_wire(bytes: u64) -> Duration {
    const RATE: u64 = BYTES_PER_S as u64;
    let part = Duration::from_nanos(bytes % RATE * 1_000_000_000 / RATE);
    Duration::from_secs(bytes / RATE) + part
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands out a few bytes at a time.
    struct Trickle<'a>(&'a [u8], usize);

    impl Read for Trickle<'_> {
        fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
            self.0
                .take(self.1 as u64)
                .read(to)
                .inspect(|&n| self.0 = &self.0[n..])
        }
    }

    fn chunks(source: impl Read) -> Vec<(Duration, Vec<u8>)> {
        let mut reader = RawReader::new(source);
        let mut chunks = Vec::new();
        while let Some(chunk) = reader.next_chunk().unwrap() {
            chunks.push((chunk.at, chunk.bytes.to_vec()));
        }
        chunks
    }

    #[test]
    fn chunks_do_not_depend_on_how_the_bytes_arrive() {
        let mut stream = b"noise\n\n".to_vec();
        stream.extend([b'x'; 200]);
        stream.extend(b"\r\nrest");
        let whole = chunks(&stream[..]);
        assert_eq!(
            whole.iter().flat_map(|c| c.1.clone()).collect::<Vec<_>>(),
            stream
        );
        assert_eq!(whole[0].1, b"noise\n");
        assert_eq!(whole.last().unwrap().1, b"rest");
        for step in [1, 2, 3, 7, 79, 80, 81] {
            assert_eq!(
                chunks(Trickle(&stream, step)),
                whole,
                "{step} bytes at a time"
            );
        }
    }

    #[test]
    fn three_lines_take_a_second() {
        let stream = [b'.'; 481];
        let at = chunks(&stream[..])
            .into_iter()
            .map(|c| c.0)
            .collect::<Vec<_>>();
        assert_eq!(at[2], Duration::from_secs(1));
        assert_eq!(at[5], Duration::from_secs(2));
        assert!(at.is_sorted());
    }
}
