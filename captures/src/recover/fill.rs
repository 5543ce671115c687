//! What a journal has, put where the chunks of a damaged recording lack it.
//!
//! Journal and chunks are in the order in which everything happened. Before a chunk is taken over, the
//! entries come that lie between it and what there is already: bytes by their place in the stream, events
//! by their time. Neither file is held in memory; of the events that the chunks have, a hash each is.

use std::collections::HashSet;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};

use super::Missing;
use super::temporary::Temporary;
use crate::CaptureError;
use crate::composer::Composer;
use crate::journal::{Entry, JournalReader, Kind, Waste};

/// Where a chunk that holds begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChunkStart {
    /// Time of its earliest message; nanoseconds since 1970.
    pub(super) at_ns: u64,
    pub(super) rx: StreamStart,
    pub(super) tx: StreamStart,
}

/// Where a stream goes on in a chunk, or in the first after it that has any of the stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct StreamStart {
    pub(super) offset: u64,
    /// The chunk itself has some of the stream.
    pub(super) is_here: bool,
}

impl StreamStart {
    /// No chunk has any more of the stream.
    pub(super) const END: Self = Self {
        offset: u64::MAX,
        is_here: false,
    };
}

impl ChunkStart {
    /// Behind the last chunk.
    pub(super) const END: Self = Self {
        at_ns: u64::MAX,
        rx: StreamStart::END,
        tx: StreamStart::END,
    };
}

/// What is in neither file, and what came from the journal.
#[derive(Debug, Default)]
pub(super) struct Balance {
    pub(super) rx_missing: Vec<Missing>,
    pub(super) tx_missing: u64,
    pub(super) rx_from_journal: u64,
}

impl Balance {
    /// Takes note of a step before bytes of a stream.
    pub(super) fn step(&mut self, kind: Kind, have: u64, offset: u64) {
        let bytes = offset.saturating_sub(have);
        match kind {
            Kind::Rx if bytes > 0 => self.rx_missing.push(Missing {
                offset: have,
                bytes,
            }),
            Kind::Tx => self.tx_missing += bytes,
            _ => {}
        }
    }
}

/// Key of an event: the same for the entry of a journal and for the message made of it.
pub(super) fn event_key(kind: Kind, at_ns: u64, data: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    (kind as u8, at_ns, data).hash(&mut hasher);
    hasher.finish()
}

/// A journal that is read as far as it is wanted.
pub(super) struct Filler {
    path: PathBuf,
    /// `None` when there is no journal.
    reader: Option<JournalReader<BufReader<File>>>,
    next: Option<Entry>,
    rx_end: u64,
    /// The events that the chunks have.
    known: HashSet<u64>,
}

impl Filler {
    pub(super) fn open(path: &Path, known: HashSet<u64>) -> Result<Self, CaptureError> {
        let reader = match JournalReader::open(path) {
            Ok(reader) => Some(reader),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => {
                return Err(CaptureError::Open {
                    path: path.to_owned(),
                    error,
                });
            }
        };
        Ok(Self {
            path: path.to_owned(),
            reader,
            next: None,
            rx_end: 0,
            known,
        })
    }

    /// What of the journal was of no use; `None` when there is none.
    pub(super) fn waste(&self) -> Option<Waste> {
        self.reader.as_ref().map(JournalReader::waste)
    }

    /// Where the stream of received bytes ends in the journal, as far as it has been read.
    pub(super) const fn rx_end(&self) -> u64 {
        self.rx_end
    }

    /// Writes everything that comes before a chunk and is not there yet.
    pub(super) fn fill_up_to<W: Write>(
        &mut self,
        composer: &mut Composer<W>,
        start: &ChunkStart,
        balance: &mut Balance,
        output: &Temporary,
    ) -> Result<(), CaptureError> {
        let failed = |error| output.failed(error);
        while let Some(mut entry) = self.take_next()? {
            let (have, limit) = match entry.kind {
                Kind::Session => continue,
                Kind::Event => {
                    if entry.at_ns > start.at_ns {
                        self.next = Some(entry);
                        break;
                    }
                    let key = event_key(entry.kind, entry.at_ns, &entry.data);
                    if !self.known.contains(&key) {
                        composer.handle_entry(&entry).map_err(failed)?;
                    }
                    continue;
                }
                Kind::Rx => (composer.deriver().rx_bytes(), start.rx),
                Kind::Tx => (composer.deriver().tx_bytes(), start.tx),
            };
            let end = entry.end();
            if entry.kind == Kind::Rx {
                self.rx_end = self.rx_end.max(end);
            }
            if end <= have {
                continue;
            }
            let is_later = !limit.is_here && entry.at_ns > start.at_ns;
            if entry.offset.max(have) >= limit.offset || is_later {
                self.next = Some(entry);
                break;
            }
            balance.step(entry.kind, have, entry.offset);
            if entry.kind == Kind::Rx {
                balance.rx_from_journal += end.min(limit.offset) - entry.offset.max(have);
            }
            if end > limit.offset {
                // What is behind the chunk may still be wanted.
                let mut before = entry.clone();
                before.data.truncate((limit.offset - entry.offset) as usize);
                composer.handle_entry(&before).map_err(failed)?;
                entry.data.drain(..before.data.len());
                entry.offset = limit.offset;
                self.next = Some(entry);
                break;
            }
            composer.handle_entry(&entry).map_err(failed)?;
        }
        // A line that the chunk goes on with cannot be told from one whose rest is lost.
        composer.end_line().map_err(failed)
    }

    fn take_next(&mut self) -> Result<Option<Entry>, CaptureError> {
        if let Some(entry) = self.next.take() {
            return Ok(Some(entry));
        }
        let Some(reader) = &mut self.reader else {
            return Ok(None);
        };
        reader.next_entry().map_err(|error| CaptureError::Read {
            path: self.path.clone(),
            error,
        })
    }
}
