//! Makes whole again what was interrupted or damaged.
//!
//! A recording called `run.mcap` is `run.mcap.partial` while it is written, with everything that came in, in
//! `run.mcap.journal`. After a crash both are there. Where the journal holds, the recording is made anew
//! from it; otherwise every chunk that holds is taken over as it is, and what the journal has beyond them
//! is added. The result is written to `run.mcap.recovering`, synced, and renamed in one step; only then do
//! the others go. Whenever this is interrupted, doing it again gives the same.

mod report;
mod walk;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use ::mcap::io::MessageReader;
use ::mcap::sans_io::LinearReaderOptions;
use prost::Message;
use serde::Serialize;

pub use walk::Damage;

use super::CaptureError;
use super::composer::{Composer, Session};
use super::journal::{Entry, JournalReader, Kind};
use super::messages::{RawBytes, UplinkEvent, UplinkStep};
use super::rotation::part_name;
use super::topics::{Deriver, StationEvent, Topic};
use super::writer::records::{HEAD_BYTES, Reader, op};
use super::writer::{Attachment, LIBRARY, McapWriter, next_record};
use walk::{Found, RECORD_BYTES_MAX, Walker};

const BUFFER_BYTES: usize = 1024 * 1024;

/// The files of one recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Paths {
    /// The finished recording.
    pub target: PathBuf,
    /// The recording under way.
    pub partial: PathBuf,
    /// Its side-car.
    pub journal: PathBuf,
}

impl Paths {
    /// From the name of the recording, or from that of one of the other files.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let target = match path.extension().and_then(|extension| extension.to_str()) {
            Some("partial" | "journal") => path.with_extension(""),
            _ => path.to_owned(),
        };
        Self {
            partial: with_suffix(&target, ".partial"),
            journal: with_suffix(&target, ".journal"),
            target,
        }
    }

    /// Whether there is any of them.
    #[must_use]
    pub fn exist(&self) -> bool {
        self.are_interrupted() || self.target.exists()
    }

    /// Whether there is a recording that was never finished.
    #[must_use]
    pub fn are_interrupted(&self) -> bool {
        self.partial.exists() || self.journal.exists()
    }
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(suffix);
    name.into()
}

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The recording is whole; nothing was done.
    Whole,
    /// Everything that was received is in the recording.
    Recovered,
    /// Something is missing; the rest was saved.
    Partly,
}

/// What was saved and what was not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recovery {
    /// The recording.
    pub path: PathBuf,
    /// What was done.
    pub outcome: Outcome,
    /// Messages in the recording now.
    pub messages: u64,
    /// Bytes of the radio in the recording now.
    pub rx_bytes: u64,
    /// Bytes to the radio.
    pub tx_bytes: u64,
    /// Bytes of the radio that were received and are lost: where in the stream, and how many.
    pub rx_missing: Vec<Missing>,
    /// Chunks taken over as they were.
    pub chunks_kept: u64,
    /// Places of the old file that are of no use, in its order.
    pub damage: Vec<Damage>,
    /// Bytes of the radio that came from the journal.
    pub rx_from_journal: u64,
    /// Bytes of the journal that are of no use.
    pub journal_damaged_bytes: u64,
    /// Where the old file is, when something of it was of no use.
    pub original: Option<PathBuf>,
}

/// A step in the stream of received bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Bytes of the stream before it.
    pub offset: u64,
    /// Bytes missing.
    pub bytes: u64,
}

/// Whether another program writes this recording now, or makes it whole.
#[must_use]
pub fn is_in_use(paths: &Paths) -> bool {
    [&paths.partial, &paths.journal]
        .into_iter()
        .any(|path| File::open(path).is_ok_and(|file| lock(&file).is_none()))
}

/// `None` when another program has it. A file system that knows no locks has nobody else.
fn lock(file: &File) -> Option<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => None,
        Ok(()) | Err(TryLockError::Error(_)) => Some(()),
    }
}

/// Recordings in a folder that were interrupted and that nobody writes now, by the names they are to
/// have.
#[must_use]
pub fn find_interrupted(folder: &Path) -> Vec<PathBuf> {
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut found: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            let name = path.to_string_lossy();
            name.ends_with(".mcap.partial") || name.ends_with(".mcap.journal")
        })
        .map(|path| Paths::of(&path))
        .filter(|paths| !is_in_use(paths))
        .map(|paths| paths.target)
        .collect();
    found.sort();
    found.dedup();
    found
}

/// Makes room for a recording of that name: an interrupted one gets another, which is returned, and can
/// be recovered at leisure.
///
/// # Errors
/// When it is being written now, or cannot be renamed.
pub fn set_aside(path: &Path) -> Result<Option<PathBuf>, CaptureError> {
    let paths = Paths::of(path);
    if !paths.are_interrupted() {
        return Ok(None);
    }
    if is_in_use(&paths) {
        return Err(CaptureError::InUse(path.to_owned()));
    }
    let aside = (2..).map(|n| Paths::of(&part_name(path, n)));
    let Some(aside) = aside.into_iter().find(|aside| !aside.exist()) else {
        return Ok(None);
    };
    for (from, to) in [
        (&paths.journal, &aside.journal),
        (&paths.partial, &aside.partial),
    ] {
        match fs::rename(from, to) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(write_error(from, error));
            }
            _ => {}
        }
    }
    Ok(Some(aside.target))
}

/// Makes a recording whole, whichever of its files is named, and says what was saved.
///
/// # Errors
/// When there is no such recording, it is being written now, or a disk fails. Nothing is lost then.
pub fn recover(path: &Path) -> Result<Recovery, CaptureError> {
    let paths = Paths::of(path);
    if is_in_use(&paths) {
        return Err(CaptureError::InUse(paths.target));
    }
    let _locks = Locks::take(&paths);
    if !paths.are_interrupted() {
        let scan = Scan::of(&paths.target)?;
        if is_whole(&paths.target) {
            return Ok(scan.report(&paths, Outcome::Whole));
        }
        return repair(&paths, &paths.target, scan);
    }
    if paths.target.exists() && is_whole(&paths.target) && holds_everything(&paths)? {
        // It was finished, and only the tidying up was interrupted.
        let scan = Scan::of(&paths.target)?;
        tidy_up(&paths)?;
        return Ok(scan.report(&paths, Outcome::Whole));
    }
    if paths.target.exists() {
        let aside = set_aside_unlocked(&paths)?;
        return recover_interrupted(&aside);
    }
    recover_interrupted(&paths)
}

/// Makes a recording anew from its journal, because it does not have everything.
pub(super) fn rebuild(paths: &Paths) -> Result<(), CaptureError> {
    let survey = Survey::of(&paths.journal)?;
    from_journal(paths, &survey)?;
    tidy_up(paths)
}

/// Bytes of the radio in a recording of which every checksum holds and no byte is missing.
pub(super) fn received_bytes(path: &Path) -> Option<u64> {
    let scan = Scan::of(path).ok()?;
    let is_good = scan.damage.is_empty() && scan.missing.is_empty();
    is_good.then_some(scan.rx_end)
}

/// A rename is on the disk when its folder is.
pub(super) fn sync_folder(path: &Path) {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    // Not every system can; then there is nothing to be done about it.
    if let Ok(folder) = File::open(folder.unwrap_or(Path::new("."))) {
        let _ = folder.sync_all();
    }
}

/// Keeps other programs away while it lives.
struct Locks(#[expect(dead_code, reason = "held, not used")] Vec<File>);

impl Locks {
    fn take(paths: &Paths) -> Self {
        let files = [&paths.partial, &paths.journal].into_iter();
        Self(
            files
                .filter_map(|path| File::open(path).ok())
                .inspect(|file| {
                    // Whoever has it by now is told by the renames that fail.
                    let _ = lock(file);
                })
                .collect(),
        )
    }
}

/// What there is in an MCAP.
#[derive(Debug, Default)]
struct Scan {
    library: String,
    messages: u64,
    chunks: u64,
    rx_end: u64,
    tx_end: u64,
    latest_ns: u64,
    missing: Vec<Missing>,
    damage: Vec<Damage>,
    topics: Topics,
    /// A chunk that holds has them.
    has_channels: bool,
    earliest_ns: u64,
}

impl Scan {
    fn of(path: &Path) -> Result<Self, CaptureError> {
        let mut walker = open(path)?;
        let mut scan = Self::default();
        let read_error = |error| CaptureError::Read {
            path: path.to_owned(),
            error,
        };
        while let Some(found) = walker.next().map_err(read_error)? {
            match found {
                Found::Header(library) => {
                    library.clone_into(&mut scan.library);
                    scan.topics = Topics::of(library);
                }
                Found::Chunk(chunk) => {
                    scan.chunks += 1;
                    let mut topics = std::mem::take(&mut scan.topics);
                    topics.for_each_message(chunk.content, |message| scan.take(&message));
                    scan.topics = topics;
                    scan.has_channels |= has_channels(chunk.content);
                }
                Found::Damage(damage) | Found::Cut(damage) => scan.damage.push(damage),
                Found::Channel(record) => scan.topics.add(&record[HEAD_BYTES..]),
                Found::Schema(_) | Found::Metadata(_) | Found::Attachment(_) => {}
            }
        }
        if scan.damage.is_empty() && !walker.data_holds().map_err(read_error)? {
            scan.damage.push(Damage {
                offset: 0,
                bytes: 0,
                problem: "every chunk holds, and something between them does not: a table or an index",
            });
        }
        Ok(scan)
    }

    fn take(&mut self, message: &Raw<'_>) {
        if self.messages == 0 {
            self.earliest_ns = message.log_time_ns;
        }
        self.messages += 1;
        self.latest_ns = self.latest_ns.max(message.log_time_ns);
        let end = match message.topic {
            Some(Topic::RawRx) => &mut self.rx_end,
            Some(Topic::RawTx) => &mut self.tx_end,
            _ => return,
        };
        let Ok(raw) = RawBytes::decode(message.data) else {
            return;
        };
        if raw.stream_offset > *end && message.topic == Some(Topic::RawRx) {
            self.missing.push(Missing {
                offset: *end,
                bytes: raw.stream_offset - *end,
            });
        }
        *end = raw.stream_offset + raw.data.len() as u64;
    }

    fn report(self, paths: &Paths, outcome: Outcome) -> Recovery {
        Recovery {
            path: paths.target.clone(),
            outcome,
            messages: self.messages,
            rx_bytes: self.rx_end - self.missing.iter().map(|m| m.bytes).sum::<u64>(),
            tx_bytes: self.tx_end,
            rx_missing: self.missing,
            chunks_kept: self.chunks,
            damage: self.damage,
            rx_from_journal: 0,
            journal_damaged_bytes: 0,
            original: None,
        }
    }
}

/// A message in a chunk.
struct Raw<'a> {
    topic: Option<Topic>,
    log_time_ns: u64,
    data: &'a [u8],
}

/// Which topic a channel is.
#[derive(Debug)]
enum Topics {
    /// Ours always have the same numbers, and need not be readable to be known.
    Fixed,
    /// As the channels say.
    Said(BTreeMap<u16, Topic>),
}

impl Default for Topics {
    fn default() -> Self {
        Self::Said(BTreeMap::new())
    }
}

impl Topics {
    fn of(library: &str) -> Self {
        if library == LIBRARY {
            Self::Fixed
        } else {
            Self::default()
        }
    }

    /// Takes what a channel record says.
    fn add(&mut self, body: &[u8]) {
        let Self::Said(topics) = self else {
            return;
        };
        let mut fields = Reader(body);
        if let (Some(id), Some(_), Some(name)) = (fields.u16(), fields.u16(), fields.text())
            && let Some(topic) = Topic::from_name(name)
        {
            topics.insert(id, topic);
        }
    }

    fn get(&self, channel_id: u16) -> Option<Topic> {
        match self {
            Self::Fixed => {
                let number = usize::from(channel_id).checked_sub(1)?;
                Topic::ALL.get(number).copied()
            }
            Self::Said(topics) => topics.get(&channel_id).copied(),
        }
    }

    fn for_each_message<'a>(&mut self, content: &'a [u8], mut take: impl FnMut(Raw<'a>)) {
        let mut rest = Reader(content);
        while let Some((opcode, body)) = next_record(&mut rest) {
            let mut fields = Reader(body);
            if opcode == op::CHANNEL {
                self.add(body);
            } else if opcode == op::MESSAGE
                && let (Some(channel_id), Some(_), Some(log_time_ns), Some(_)) =
                    (fields.u16(), fields.u32(), fields.u64(), fields.u64())
            {
                take(Raw {
                    topic: self.get(channel_id),
                    log_time_ns,
                    data: fields.0,
                });
            }
        }
    }
}

fn has_channels(content: &[u8]) -> bool {
    let mut rest = Reader(content);
    std::iter::from_fn(|| next_record(&mut rest)).any(|(opcode, _)| opcode == op::CHANNEL)
}

/// What there is in a journal.
struct Survey {
    session: Option<Session>,
    rx_end: u64,
    tx_end: u64,
    damaged_bytes: u64,
    /// Received bytes that its entries do not have.
    missing: Vec<Missing>,
    missing_tx: u64,
}

impl Survey {
    fn of(path: &Path) -> Result<Self, CaptureError> {
        let mut survey = Self {
            session: None,
            rx_end: 0,
            tx_end: 0,
            damaged_bytes: 0,
            missing: Vec::new(),
            missing_tx: 0,
        };
        survey.damaged_bytes = for_each_entry(path, |entry| {
            let end = entry.offset + entry.data.len() as u64;
            match entry.kind {
                Kind::Session => survey.session = serde_json::from_slice(&entry.data).ok(),
                Kind::Rx => {
                    if entry.offset > survey.rx_end {
                        survey.missing.push(Missing {
                            offset: survey.rx_end,
                            bytes: entry.offset - survey.rx_end,
                        });
                    }
                    survey.rx_end = survey.rx_end.max(end);
                }
                Kind::Tx => {
                    survey.missing_tx += entry.offset.saturating_sub(survey.tx_end);
                    survey.tx_end = survey.tx_end.max(end);
                }
                Kind::Uplink | Kind::Log => {}
            }
            Ok(())
        })?;
        Ok(survey)
    }

    /// It has everything from the beginning up to its end.
    const fn is_complete(&self) -> bool {
        self.session.is_some() && self.missing.is_empty() && self.missing_tx == 0
    }
}

/// Returns the bytes that are of no use.
fn for_each_entry(
    path: &Path,
    mut take: impl FnMut(&Entry) -> Result<(), CaptureError>,
) -> Result<u64, CaptureError> {
    let read_error = |error| CaptureError::Read {
        path: path.to_owned(),
        error,
    };
    let mut reader = JournalReader::open(path).map_err(|error| CaptureError::Open {
        path: path.to_owned(),
        error,
    })?;
    while let Some(entry) = reader.next_entry().map_err(read_error)? {
        take(&entry)?;
    }
    Ok(reader.damaged_bytes())
}

fn recover_interrupted(paths: &Paths) -> Result<Recovery, CaptureError> {
    let survey = if paths.journal.exists() {
        Some(Survey::of(&paths.journal)?)
    } else {
        None
    };
    let scan = if paths.partial.exists() {
        Some(Scan::of(&paths.partial)?)
    } else {
        None
    };
    let (rx_end, tx_end) = scan
        .as_ref()
        .map_or((0, 0), |scan| (scan.rx_end, scan.tx_end));
    match (survey, scan) {
        (Some(survey), scan)
            if survey.is_complete() && survey.rx_end >= rx_end && survey.tx_end >= tx_end =>
        {
            let mut recovery = from_journal(paths, &survey)?;
            recovery.damage = scan.map(|scan| scan.damage).unwrap_or_default();
            tidy_up(paths)?;
            Ok(recovery)
        }
        (_, Some(scan)) => repair(paths, &paths.partial, scan),
        (Some(survey), None) => {
            let recovery = from_journal(paths, &survey)?;
            tidy_up(paths)?;
            Ok(recovery)
        }
        (None, None) => Err(CaptureError::Open {
            path: paths.target.clone(),
            error: io::ErrorKind::NotFound.into(),
        }),
    }
}

/// Makes the recording from its journal alone.
fn from_journal(paths: &Paths, survey: &Survey) -> Result<Recovery, CaptureError> {
    let fallback = Session {
        link: "unknown".to_owned(),
        start: UNIX_EPOCH,
        notes: BTreeMap::new(),
        configuration: String::new(),
    };
    let session = survey.session.as_ref().unwrap_or(&fallback);
    let temporary = Temporary::create(paths)?;
    let failed = |error| write_error(&temporary.path, error);
    let output = BufWriter::with_capacity(BUFFER_BYTES, &temporary.file);
    let mut composer = Composer::new(output, session).map_err(failed)?;
    for_each_entry(&paths.journal, |entry| {
        composer.handle_entry(entry).map_err(failed)
    })?;
    let missing: u64 = survey.missing.iter().map(|missing| missing.bytes).sum();
    let mut recovery = Recovery {
        path: paths.target.clone(),
        outcome: if missing == 0 {
            Outcome::Recovered
        } else {
            Outcome::Partly
        },
        messages: 0,
        rx_bytes: survey.rx_end - missing,
        tx_bytes: survey.tx_end - survey.missing_tx,
        rx_missing: survey.missing.clone(),
        chunks_kept: 0,
        damage: Vec::new(),
        rx_from_journal: survey.rx_end - missing,
        journal_damaged_bytes: survey.damaged_bytes,
        original: None,
    };
    recovery.messages = finish(composer, &recovery, &temporary)?;
    temporary.put_in_place(paths)?;
    Ok(recovery)
}

/// Takes over what holds of `source`, and adds what a journal has beyond it.
fn repair(paths: &Paths, source: &Path, scan: Scan) -> Result<Recovery, CaptureError> {
    if scan.chunks == 0 && !paths.journal.exists() {
        return Err(CaptureError::NothingLeft(source.to_owned()));
    }
    let temporary = Temporary::create(paths)?;
    let failed = |error| write_error(&temporary.path, error);
    let output = BufWriter::with_capacity(BUFFER_BYTES, &temporary.file);
    let mut writer = McapWriter::empty(output, &scan.library).map_err(failed)?;
    let mut topics = Topics::of(&scan.library);
    let has_lost_topics = matches!(topics, Topics::Fixed) && !scan.has_channels;
    if has_lost_topics {
        writer.register_topics();
    }
    let mut composer = Composer::around(writer, Deriver::new());
    if has_lost_topics {
        let note = StationEvent::note("the beginning of this recording could not be saved");
        composer
            .handle_event(scan.earliest_ns, &note)
            .map_err(failed)?;
    }
    let mut walker = open(source)?;
    let read_error = |error| CaptureError::Read {
        path: source.to_owned(),
        error,
    };
    while let Some(found) = walker.next().map_err(read_error)? {
        copy(&mut composer, &mut topics, &found).map_err(failed)?;
    }
    let before = composer.deriver().rx_bytes();
    let mut journal_damaged_bytes = 0;
    let mut late = Vec::new();
    if paths.journal.exists() {
        journal_damaged_bytes = for_each_entry(&paths.journal, |entry| {
            let is_event = matches!(entry.kind, Kind::Uplink | Kind::Log);
            if is_event && entry.at_ns <= scan.latest_ns {
                return Ok(());
            }
            if entry.kind == Kind::Rx && entry.offset > composer.deriver().rx_bytes() {
                late.push(Missing {
                    offset: composer.deriver().rx_bytes(),
                    bytes: entry.offset - composer.deriver().rx_bytes(),
                });
            }
            composer.handle_entry(entry).map_err(failed)
        })?;
    }
    let after = composer.deriver().rx_bytes();
    let mut recovery = scan.report(paths, Outcome::Partly);
    let is_clean = recovery.damage.iter().all(|damage| damage.bytes == 0);
    let stepped: u64 = late.iter().map(|missing| missing.bytes).sum();
    recovery.rx_missing.extend(late);
    recovery.rx_from_journal = after.saturating_sub(before + stepped);
    recovery.rx_bytes += recovery.rx_from_journal;
    recovery.journal_damaged_bytes = journal_damaged_bytes;
    // A record that was being written when everything stopped is no loss if the journal has what was in it.
    let is_interrupted = source == paths.partial;
    let has_journal = is_interrupted && paths.journal.exists();
    if recovery.rx_missing.is_empty() && (is_clean || has_journal) {
        recovery.outcome = Outcome::Recovered;
    }
    let has_damage = recovery
        .damage
        .iter()
        .any(|damage| !is_interrupted || damage.offset + damage.bytes < walker.length());
    if has_damage {
        recovery.original = Some(keep_original(paths, source)?);
    }
    recovery.messages = finish(composer, &recovery, &temporary)?;
    temporary.put_in_place(paths)?;
    tidy_up(paths)?;
    Ok(recovery)
}

/// Writes one thing that holds, and lets the deriver know of it.
fn copy<W: io::Write>(
    composer: &mut Composer<W>,
    topics: &mut Topics,
    found: &Found<'_>,
) -> io::Result<()> {
    match found {
        Found::Chunk(chunk) => {
            composer.writer().copy_chunk(chunk)?;
            topics.for_each_message(chunk.content, |message| recall(composer, &message));
            Ok(())
        }
        Found::Schema(record) => {
            composer.writer().add_schema(record);
            Ok(())
        }
        Found::Channel(record) => {
            topics.add(&record[HEAD_BYTES..]);
            composer.writer().add_channel(record);
            Ok(())
        }
        Found::Metadata(body) => {
            let mut fields = Reader(body);
            match (fields.text(), fields.map()) {
                // What an earlier recovery said is said anew.
                (Some("recovery"), _) | (None, _) | (_, None) => Ok(()),
                (Some(name), Some(map)) => composer.writer().write_metadata(name, &map),
            }
        }
        Found::Attachment(body) => {
            let mut fields = Reader(body);
            let (Some(time_ns), Some(_), Some(name), Some(media_type), Some(bytes)) = (
                fields.u64(),
                fields.u64(),
                fields.text(),
                fields.text(),
                fields.u64(),
            ) else {
                return Ok(());
            };
            let data = usize::try_from(bytes).ok().and_then(|n| fields.take(n));
            composer.writer().attach(&Attachment {
                name,
                media_type,
                time_ns,
                data: data.unwrap_or_default(),
            })
        }
        Found::Header(_) | Found::Damage(_) | Found::Cut(_) => Ok(()),
    }
}

fn recall<W: io::Write>(composer: &mut Composer<W>, message: &Raw<'_>) {
    let entry = |kind, offset, data| Entry {
        kind,
        at_ns: message.log_time_ns,
        offset,
        data,
    };
    let entry = match message.topic {
        Some(Topic::RawRx) => RawBytes::decode(message.data)
            .ok()
            .map(|raw| entry(Kind::Rx, raw.stream_offset, raw.data)),
        Some(Topic::RawTx) => RawBytes::decode(message.data)
            .ok()
            .map(|raw| entry(Kind::Tx, raw.stream_offset, raw.data)),
        Some(Topic::Uplink) => UplinkEvent::decode(message.data)
            .ok()
            .filter(|event| !matches!(event.step(), UplinkStep::Acknowledged | UplinkStep::List))
            .map(|_| entry(Kind::Uplink, 0, message.data.to_vec())),
        _ => None,
    };
    if let Some(entry) = entry {
        composer.recall(&entry);
    }
}

/// Says in the recording itself what was done to it, and finishes it; returns its messages.
fn finish<W: io::Write>(
    mut composer: Composer<W>,
    recovery: &Recovery,
    temporary: &Temporary,
) -> Result<u64, CaptureError> {
    let failed = |error| write_error(&temporary.path, error);
    let missing: u64 = recovery.rx_missing.iter().map(|m| m.bytes).sum();
    let about = [
        ("rx_bytes_missing", missing.to_string()),
        (
            "rx_bytes_from_journal",
            recovery.rx_from_journal.to_string(),
        ),
        ("chunks_kept", recovery.chunks_kept.to_string()),
        ("damaged_places", recovery.damage.len().to_string()),
    ];
    let about = about.map(|(name, value)| (name.to_owned(), value)).into();
    composer.end_line().map_err(failed)?;
    composer
        .writer()
        .write_metadata("recovery", &about)
        .map_err(failed)?;
    let messages = composer.writer().message_count();
    composer.finish().map_err(failed)?;
    Ok(messages)
}

/// What is being written, until it takes the place of what was there.
struct Temporary {
    path: PathBuf,
    file: File,
}

impl Temporary {
    fn create(paths: &Paths) -> Result<Self, CaptureError> {
        let path = with_suffix(&paths.target, ".recovering");
        // One that is there was left by a recovery that was interrupted.
        let file = File::create(&path).map_err(|error| CaptureError::Create {
            path: path.clone(),
            error,
        })?;
        Ok(Self { path, file })
    }

    fn put_in_place(self, paths: &Paths) -> Result<(), CaptureError> {
        self.file
            .sync_all()
            .and_then(|()| fs::rename(&self.path, &paths.target))
            .map_err(|error| write_error(&self.path, error))?;
        sync_folder(&paths.target);
        Ok(())
    }
}

/// The damaged file under another name: it is evidence.
fn keep_original(paths: &Paths, source: &Path) -> Result<PathBuf, CaptureError> {
    let kept = with_suffix(&paths.target, ".damaged");
    if kept.exists() {
        return Ok(kept);
    }
    fs::hard_link(source, &kept)
        .or_else(|_| fs::copy(source, &kept).map(|_| ()))
        .map_err(|error| write_error(&kept, error))?;
    Ok(kept)
}

fn tidy_up(paths: &Paths) -> Result<(), CaptureError> {
    for path in [&paths.partial, &paths.journal] {
        match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(write_error(path, error));
            }
            _ => {}
        }
    }
    Ok(())
}

fn set_aside_unlocked(paths: &Paths) -> Result<Paths, CaptureError> {
    let free = (2..)
        .map(|n| Paths::of(&part_name(&paths.target, n)))
        .find(|aside| !aside.exist());
    let aside = free.unwrap_or_else(|| paths.clone());
    for (from, to) in [
        (&paths.journal, &aside.journal),
        (&paths.partial, &aside.partial),
    ] {
        match fs::rename(from, to) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(write_error(from, error));
            }
            _ => {}
        }
    }
    Ok(aside)
}

/// Whether a finished recording has all that its journal or an unfinished copy of it has.
fn holds_everything(paths: &Paths) -> Result<bool, CaptureError> {
    let have = Scan::of(&paths.target)?;
    let mut holds = have.missing.is_empty() && have.damage.is_empty();
    if paths.journal.exists() {
        let survey = Survey::of(&paths.journal)?;
        holds &= have.rx_end == survey.rx_end && have.tx_end == survey.tx_end;
    }
    if paths.partial.exists() {
        let scan = Scan::of(&paths.partial)?;
        holds &= have.rx_end >= scan.rx_end && have.messages >= scan.messages;
    }
    Ok(holds)
}

/// Whether every checksum holds, the index included, by the code of others.
fn is_whole(path: &Path) -> bool {
    let Ok(file) = File::open(path) else {
        return false;
    };
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(RECORD_BYTES_MAX);
    let mut reader = MessageReader::new_with_options(BufReader::new(file), options);
    reader.all(|message| message.is_ok())
}

fn open(path: &Path) -> Result<Walker, CaptureError> {
    Walker::open(path).map_err(|error| CaptureError::Open {
        path: path.to_owned(),
        error,
    })
}

fn write_error(path: &Path, error: io::Error) -> CaptureError {
    CaptureError::Write {
        path: path.to_owned(),
        error,
    }
}
