//! Finishes recordings: turns unfinished and damaged files into indexed ones.
//!
//! The result is derived from the observations that can be read. It is written beside the file, read back, synced and
//! renamed over it, so an interrupted attempt changes nothing.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use ::mcap::io::MessageReader;
use ::mcap::records::Metadata;
use ::mcap::sans_io::LinearReaderOptions;

use super::CaptureError;
use super::backup;
use super::files::{self, Lock};
use super::interrupted::{is_library, is_unfinished};
use super::mcap_reader::Channels;
use super::observations::{Item, Observation, Observations};
use super::record::RECORD_BYTES_MAX;
use super::repair::{Damage, Problem};
use super::schema::DESCRIPTORS;
use super::session::RECOVERY;
use super::session_writer::{CHUNK_BYTES, SessionWriter};
use super::source::open_file;
use super::temporary::Temporary;

use super::recovery::LISTED_MAX;
pub use super::recovery::{Missing, Outcome, Recovery};

const BUFFER_BYTES: usize = 1024 * 1024;

/// Maximum number of chunks; limits the share of a recording lost with one damaged chunk, and the length of the index.
const CHUNKS: u64 = 1024;

/// Minimum length of a chunk in a short recording, uncompressed bytes.
const CHUNK_BYTES_MIN: u64 = 11 * 1024;

// Readers refuse a chunk that contains only a schema and no message.
const _: () = assert!(CHUNK_BYTES_MIN > DESCRIPTORS.len() as u64 + 1024);

/// Finishes an unfinished recording, or rebuilds a damaged one from its readable parts; reports saved and lost parts.
///
/// # Errors
/// If the file is not a recording or is in use, or a disk fails. The file is then unchanged.
pub fn recover(path: &Path) -> Result<Recovery, CaptureError> {
    // Before a lock, which a device may not have.
    open_file(path)?;
    let lock = Lock::take(path).map_err(|error| CaptureError::Open {
        path: path.to_owned(),
        error,
    })?;
    let Some(_lock) = lock else {
        return Err(CaptureError::UnderWay(path.to_owned()));
    };
    if is_unfinished(path) {
        return finish(path, &AtomicU64::default());
    }
    let (survey, channels) = read(path, Channels::new(), |_| Ok(()))?;
    if survey.damage.is_empty()
        && !survey.has_bad_end
        && let Some(messages) = count_if_whole(path, &AtomicU64::default())
    {
        return Ok(survey.report(path, Outcome::Whole, messages));
    }
    rewrite(path, channels, &AtomicU64::default())
}

/// Finishes a recording that the caller has locked; counts its steps in `progress`.
///
/// # Errors
/// The errors of [`recover`].
pub(super) fn finish(path: &Path, progress: &AtomicU64) -> Result<Recovery, CaptureError> {
    rewrite(path, Channels::new(), progress)
}

fn rewrite(
    path: &Path,
    channels: Channels,
    progress: &AtomicU64,
) -> Result<Recovery, CaptureError> {
    let step = || progress.fetch_add(1, Ordering::Relaxed);
    // Renaming over a link would leave the file that it points to.
    let link = path.is_symlink().then(|| fs::canonicalize(path).ok());
    let path = &link.flatten().unwrap_or_else(|| path.to_owned());
    let temporary = Temporary::create(path)?;
    let failed = |error| temporary.failed(error);
    let bytes = fs::metadata(path).map_or(0, |about| about.len());
    let chunk_bytes = (bytes / CHUNKS).clamp(CHUNK_BYTES_MIN, CHUNK_BYTES);
    let output = BufWriter::with_capacity(BUFFER_BYTES, &temporary.file);
    let mut writer = SessionWriter::with_chunks(output, chunk_bytes).map_err(failed)?;
    let (survey, _) = read(path, channels, |item| {
        step();
        match item {
            Item::Table(table) if table.name == RECOVERY => Ok(()),
            item => writer.handle_item(item).map_err(failed),
        }
    })?;
    if survey.is_compressed_by_others {
        return Err(CaptureError::Compression(path.clone()));
    }
    if survey.observations == 0 {
        return Err(CaptureError::NothingLeft(path.clone()));
    }
    let has_loss = survey.has_loss();
    if has_loss {
        writer.write_metadata(&survey.table()).map_err(failed)?;
    }
    writer.finish().map_err(failed)?;
    let Some(messages) = count_if_whole(&temporary.path, progress) else {
        return Err(CaptureError::NotConfirmed(path.clone()));
    };
    let (copy, _) = read(&temporary.path, Channels::new(), |_| {
        step();
        Ok(())
    })?;
    if (copy.rx_end, copy.tx_end) != (survey.rx_end, survey.tx_end) {
        return Err(CaptureError::NotConfirmed(path.clone()));
    }
    let is_damaged = has_loss || !survey.damage.is_empty() || !survey.is_unfinished;
    let outcome = if has_loss {
        Outcome::Partly
    } else {
        Outcome::Recovered
    };
    let mut recovery = survey.report(path, outcome, messages);
    if is_damaged {
        recovery.original = Some(backup::keep(path)?);
    }
    temporary.put_in_place()?;
    Ok(recovery)
}

/// The content of a recording.
#[derive(Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent findings")]
struct Survey {
    is_unfinished: bool,
    observations: u64,
    rx_end: u64,
    tx_end: u64,
    rx_bytes_missing: u64,
    rx_missing: Vec<Missing>,
    tx_missing: u64,
    damage: Vec<Damage>,
    /// Number of lost and damaged parts that are not listed.
    unlisted: u64,
    /// Number of damaged parts.
    damaged_places: u64,
    /// A damaged part has bytes, and was skipped.
    has_skipped: bool,
    /// A chunk is compressed in a way that only others use.
    is_compressed_by_others: bool,
    /// Whether the file is cut off: an unfinished file within a record, a finished file before its end mark.
    is_cut: bool,
    /// Whether the summary is damaged.
    has_bad_end: bool,
    /// Number of messages with an unknown topic.
    nameless: u64,
}

/// Reads a recording, starting with known channels, and passes its items to `take`; returns its content and all
/// channels.
fn read(
    path: &Path,
    channels: Channels,
    mut take: impl FnMut(Item) -> Result<(), CaptureError>,
) -> Result<(Survey, Channels), CaptureError> {
    let file = files::open(path).map_err(|error| CaptureError::Open {
        path: path.to_owned(),
        error,
    })?;
    let read_error = |error| CaptureError::Read {
        path: path.to_owned(),
        error,
    };
    let mut survey = Survey::default();
    let mut observations = Observations::with_channels(file, channels);
    while let Some(item) = observations.next_item().map_err(read_error)? {
        survey.take(&item);
        take(item)?;
    }
    survey.has_bad_end = observations.has_bad_end();
    survey.nameless = observations.nameless();
    survey.is_cut = if survey.is_unfinished {
        observations.is_torn()
    } else {
        !observations.has_ended()
    };
    Ok((survey, observations.channels()))
}

/// The end of bytes that come after missing ones. Offsets of a damaged recording may be any.
const fn end_of(offset: u64, missing: u64, data: &[u8]) -> u64 {
    offset
        .saturating_add(missing)
        .saturating_add(data.len() as u64)
}

impl Survey {
    fn take(&mut self, item: &Item) {
        let observation = match item {
            Item::Observation { observation, .. } => observation,
            Item::Library(library) => {
                self.is_unfinished = is_library(library);
                return;
            }
            Item::Damage(damage) => return self.take_damage(damage),
            Item::Table(_) | Item::Attachment(_) => return,
        };
        self.observations += 1;
        match observation {
            Observation::Received(raw) => {
                if let Some((bytes, data)) = raw.after(self.rx_end) {
                    let offset = self.rx_end;
                    if bytes > 0 {
                        self.rx_bytes_missing += bytes;
                        if self.rx_missing.len() < LISTED_MAX {
                            self.rx_missing.push(Missing { offset, bytes });
                        } else {
                            self.unlisted += 1;
                        }
                    }
                    self.rx_end = end_of(offset, bytes, data);
                }
            }
            Observation::Sent(raw) => {
                if let Some((step, data)) = raw.after(self.tx_end) {
                    self.tx_missing = self.tx_missing.saturating_add(step);
                    self.tx_end = end_of(self.tx_end, step, data);
                }
            }
            Observation::Event(_) => {}
        }
    }

    /// Adds a damaged part; joins it to the previous one if they are adjacent.
    fn take_damage(&mut self, damage: &Damage) {
        self.has_skipped |= damage.bytes > 0;
        self.is_compressed_by_others |= damage.problem == Problem::Lz4;
        match self.damage.last_mut() {
            Some(last)
                if last.problem == damage.problem
                    && last.offset + last.bytes == damage.offset
                    && last.times_ns.is_none()
                    && damage.times_ns.is_none() =>
            {
                last.bytes += damage.bytes;
            }
            _ => {
                self.damaged_places += 1;
                if self.damage.len() < LISTED_MAX {
                    self.damage.push(damage.clone());
                } else {
                    self.unlisted += 1;
                }
            }
        }
    }

    fn has_loss(&self) -> bool {
        let is_short = self.is_cut && !self.is_unfinished;
        let is_incomplete =
            is_short || self.nameless > 0 || self.rx_bytes_missing > 0 || self.tx_missing > 0;
        is_incomplete || self.has_skipped
    }

    /// The metadata table that lists the losses.
    fn table(&self) -> Metadata {
        let metadata = [
            ("rx_bytes_missing", self.rx_bytes_missing.to_string()),
            ("damaged_places", self.damaged_places.to_string()),
        ];
        let metadata = metadata.map(|(name, value)| (name.to_owned(), value));
        Metadata {
            name: RECOVERY.to_owned(),
            metadata: BTreeMap::from(metadata),
        }
    }

    fn report(self, path: &Path, outcome: Outcome, messages: u64) -> Recovery {
        Recovery {
            path: path.to_owned(),
            outcome,
            messages,
            rx_bytes: self.rx_end - self.rx_bytes_missing,
            tx_bytes: self.tx_end - self.tx_missing,
            is_cut: self.is_cut,
            nameless: self.nameless,
            rx_bytes_missing: self.rx_bytes_missing,
            rx_missing: self.rx_missing,
            damage: self.damage,
            unlisted: self.unlisted,
            original: None,
        }
    }
}

/// Number of messages in a file with only valid checksums, index included, as the `mcap` crate reads it; `None`
/// for a damaged file. Counts its steps in `progress`.
fn count_if_whole(path: &Path, progress: &AtomicU64) -> Option<u64> {
    let file = File::open(path).ok()?;
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(RECORD_BYTES_MAX);
    let mut reader = MessageReader::new_with_options(BufReader::new(file), options);
    reader.try_fold(0, |count, message| {
        progress.fetch_add(1, Ordering::Relaxed);
        message.ok().map(|_| count + 1)
    })
}
