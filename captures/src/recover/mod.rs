//! Makes whole again what was interrupted or damaged.
//!
//! A recording called `run.mcap` is `run.mcap.partial` while it is written, with everything that came in, in
//! `run.mcap.journal`. After a crash both are there. Where the journal holds, the recording is made anew
//! from it; otherwise every chunk that holds is taken over as it is, and what the journal has before,
//! between and behind them is put there. The result is written to `run.mcap.recovering`, synced, and renamed in one step; only then do
//! the others go. Whenever this is interrupted, doing it again gives the same.

mod channels;
mod copy;
mod evidence;
mod files;
mod fill;
mod interrupted;
mod report;
mod scan;
mod survey;
mod temporary;

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read};
use std::path::Path;
use std::time::UNIX_EPOCH;

use ::mcap::io::MessageReader;
use ::mcap::sans_io::LinearReaderOptions;
pub use files::{
    Paths, claim, find_interrupted, free_part, is_in_use, is_own_name, refuse_own_name, set_aside,
};
pub use interrupted::Interrupted;
pub use report::{End, Missing, Outcome, Recovery};

use super::CaptureError;
use super::composer::{Composer, Session};
use super::event::{Level, NoticeCode};
use super::journal::{BEGIN, Kind};
use super::repair::Problem;
use super::topics::{Deriver, StationEvent};
use super::walk::{Damage, RECORD_BYTES_MAX, Walker};
use super::writer::{McapWriter, has_fixed_topics};
use copy::copy;
use evidence::{keep, keep_journal};
use files::{Locks, free_aside, rename_both};
use fill::{Balance, ChunkStart, Filler, event_key};
use scan::{Scan, Stretches};
use survey::{Survey, for_each_entry};
use temporary::Temporary;

const BUFFER_BYTES: usize = 1024 * 1024;

/// Uncompressed bytes of a chunk that is made anew. A recording under way ends one with every flush; what
/// replaces it shall not lose much more by a flipped bit.
const CHUNK_BYTES: usize = 8 * 1024;

/// Makes a recording whole, whichever of its files is named, and says what was saved.
///
/// # Errors
/// When there is no such recording, it is being written now, or a disk fails. Nothing is lost then.
pub fn recover(path: &Path) -> Result<Recovery, CaptureError> {
    let paths = Paths::of(path);
    refuse_foreign(&paths)?;
    let Some(_locks) = Locks::take(&paths) else {
        return Err(CaptureError::UnderWay(paths.target));
    };
    if !paths.are_interrupted() {
        let scan = Scan::of(&paths.target)?;
        if scan.bad_end.is_none() && is_whole(&paths.target) {
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
    from_journal(paths, &survey, Vec::new())?;
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
            if scan.as_ref().is_none_or(Scan::is_empty)
                || (survey.is_complete() && survey.rx_end >= rx_end && survey.tx_end >= tx_end) =>
        {
            let damage = scan.map(|scan| scan.damage).unwrap_or_default();
            let recovery = from_journal(paths, &survey, damage)?;
            tidy_up(paths)?;
            Ok(recovery)
        }
        (_, Some(scan)) => repair(paths, &paths.partial, scan),
        (_, None) => Err(CaptureError::Open {
            path: paths.target.clone(),
            error: io::ErrorKind::NotFound.into(),
        }),
    }
}

/// Makes the recording from its journal alone; `damage` is that of the unfinished file.
fn from_journal(
    paths: &Paths,
    survey: &Survey,
    damage: Vec<Damage>,
) -> Result<Recovery, CaptureError> {
    let fallback = Session {
        link: "unknown".to_owned(),
        start: UNIX_EPOCH,
        notes: BTreeMap::new(),
        configuration: String::new(),
    };
    let session = survey.session.as_ref().unwrap_or(&fallback);
    let temporary = Temporary::create(paths)?;
    let failed = |error| temporary.failed(error);
    let output = BufWriter::with_capacity(BUFFER_BYTES, &temporary.file);
    let mut composer = Composer::new(output, session).map_err(failed)?;
    composer.writer().limit_chunks(CHUNK_BYTES);
    for_each_entry(&paths.journal, |entry| {
        composer.handle_entry(entry).map_err(failed)
    })?;
    let missing: u64 = survey.missing.iter().map(|missing| missing.bytes).sum();
    // What was in the unfinished file is no loss if the journal has everything.
    let has_loss = !damage.is_empty() && !survey.is_complete();
    let mut recovery = Recovery {
        path: paths.target.clone(),
        outcome: if has_loss || survey.has_gaps() {
            Outcome::Partly
        } else {
            Outcome::Recovered
        },
        messages: 0,
        rx_bytes: survey.rx_end - missing,
        tx_bytes: survey.tx_end - survey.missing_tx,
        rx_missing: survey.missing.clone(),
        chunks_kept: 0,
        damage,
        rx_from_journal: survey.rx_end - missing,
        journal_damaged_bytes: survey.waste.bytes,
        end: End::of_journal(survey.waste),
        original: None,
        journal_kept: None,
    };
    recovery.messages = finish(composer, &recovery, &temporary)?;
    if has_loss {
        recovery.original = Some(keep(paths, &paths.partial, &paths.target)?);
    }
    recovery.journal_kept = keep_journal(paths, survey.waste)?;
    temporary.put_in_place(paths)?;
    Ok(recovery)
}

/// Takes over what holds of `source`, and adds what a journal has beyond it.
fn repair(paths: &Paths, source: &Path, mut scan: Scan) -> Result<Recovery, CaptureError> {
    if scan
        .damage
        .iter()
        .any(|damage| damage.problem == Problem::Lz4)
    {
        return Err(CaptureError::Compression(source.to_owned()));
    }
    if scan.is_empty() && !paths.journal.exists() {
        return Err(CaptureError::NothingLeft(source.to_owned()));
    }
    if scan.has_nameless {
        return Err(CaptureError::NoChannels(source.to_owned()));
    }
    let temporary = Temporary::create(paths)?;
    let failed = |error| temporary.failed(error);
    let output = BufWriter::with_capacity(BUFFER_BYTES, &temporary.file);
    let mut writer = McapWriter::empty(output, &scan.library).map_err(failed)?;
    writer.limit_chunks(CHUNK_BYTES);
    let mut topics = scan.known_topics();
    let has_lost_topics = has_fixed_topics(&scan.library) && !scan.has_channels;
    if has_lost_topics {
        writer.register_topics();
    }
    let (schemas, channels) = (scan.declared.schemas(), scan.declared.channels());
    writer.declare(schemas, channels).map_err(failed)?;
    let mut composer = Composer::around(writer, Deriver::new());
    if has_lost_topics {
        let note = StationEvent::notice(
            NoticeCode::BeginningMissing,
            Level::Warning,
            "the beginning of this recording could not be saved",
        );
        composer
            .handle_event(scan.earliest_ns, &note)
            .map_err(failed)?;
    }
    let mut filler = Filler::open(&paths.journal, std::mem::take(&mut scan.events))?;
    let mut starts = std::mem::take(&mut scan.starts).into_iter();
    let mut stretches = Stretches::default();
    let mut balance = Balance::default();
    let mut walker = open(source)?;
    let read_error = |error| CaptureError::Read {
        path: source.to_owned(),
        error,
    };
    while let Some(part) = walker.next_part().map_err(read_error)? {
        if stretches.begins_with(&part, &topics)
            && let Some(start) = starts.next()
        {
            filler.fill_up_to(&mut composer, &start, &mut balance, &temporary)?;
        }
        copy(&mut composer, &mut topics, &part, &mut balance).map_err(failed)?;
    }
    filler.fill_up_to(&mut composer, &ChunkStart::END, &mut balance, &temporary)?;
    let waste = filler.waste();
    let (scan_rx_end, ends_badly) = (scan.rx_end, scan.bad_end.is_some());
    let mut recovery = scan.report(paths, Outcome::Partly);
    let is_clean = recovery.damage.iter().all(|damage| damage.bytes == 0);
    let missing: u64 = balance.rx_missing.iter().map(|missing| missing.bytes).sum();
    recovery.rx_bytes = composer.deriver().rx_bytes() - missing;
    recovery.tx_bytes = composer.deriver().tx_bytes() - balance.tx_missing;
    recovery.rx_missing = balance.rx_missing;
    recovery.rx_from_journal = balance.rx_from_journal;
    recovery.journal_damaged_bytes = waste.map_or(0, |waste| waste.bytes);
    // A record that was being written when everything stopped is no loss if the journal has what was in it.
    let is_interrupted = source == paths.partial;
    let has_journal = is_interrupted && paths.journal.exists();
    let is_short = filler.rx_end() < scan_rx_end;
    let is_held =
        is_clean || (has_journal && !is_short && waste.is_some_and(|waste| !waste.has_damage()));
    if recovery.rx_missing.is_empty() && balance.tx_missing == 0 && is_held {
        recovery.outcome = Outcome::Recovered;
    }
    let is_followed =
        |damage: &Damage| walker.has_data_end() || damage.offset + damage.bytes < walker.offset();
    let has_damage = recovery
        .damage
        .iter()
        .any(|damage| !is_interrupted || !is_held || is_followed(damage));
    recovery.end = match waste {
        Some(_) if is_short => End::JournalShort,
        Some(waste) => End::of_journal(waste),
        None if is_interrupted => End::NoJournal,
        None if walker.has_data_end() => End::Known,
        None => End::FileCut,
    };
    recovery.messages = finish(composer, &recovery, &temporary)?;
    if has_damage || (ends_badly && !is_interrupted) {
        recovery.original = Some(keep(paths, source, &paths.target)?);
    }
    if let Some(waste) = waste {
        recovery.journal_kept = keep_journal(paths, waste)?;
    }
    temporary.put_in_place(paths)?;
    tidy_up(paths)?;
    Ok(recovery)
}

/// Says in the recording itself what was done to it, and finishes it; returns its messages.
fn finish<W: io::Write>(
    mut composer: Composer<W>,
    recovery: &Recovery,
    temporary: &Temporary,
) -> Result<u64, CaptureError> {
    let failed = |error| temporary.failed(error);
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
    let aside = free_aside(&paths.target);
    rename_both(paths, &aside)?;
    Ok(aside)
}

/// Whether a finished recording has all that its journal or an unfinished copy of it has.
fn holds_everything(paths: &Paths) -> Result<bool, CaptureError> {
    let have = Scan::of(&paths.target)?;
    let mut holds = have.missing.is_empty() && have.damage.is_empty();
    if paths.journal.exists() {
        let survey = Survey::of(&paths.journal)?;
        holds &= have.rx_end == survey.rx_end && have.tx_end == survey.tx_end;
        for_each_entry(&paths.journal, |entry| {
            let is_event = matches!(entry.kind, Kind::Event);
            let key = event_key(entry.kind, entry.at_ns, &entry.data);
            holds &= !is_event || have.events.contains(&key);
            Ok(())
        })?;
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

/// Files that only have the names of ours are somebody else's.
fn refuse_foreign(paths: &Paths) -> Result<(), CaptureError> {
    let begins_with = |path: &Path, magic: &[u8]| {
        let mut begin = Vec::new();
        let read = File::open(path).and_then(|file| {
            let mut file = file.take(magic.len() as u64);
            file.read_to_end(&mut begin)
        });
        // One that cannot be read is told of by whoever reads on; one that was cut is ours.
        read.is_err() || magic.starts_with(&begin)
    };
    if !begins_with(&paths.partial, ::mcap::MAGIC) && Scan::of(&paths.partial)?.chunks == 0 {
        return Err(CaptureError::Foreign(paths.partial.clone()));
    }
    if !begins_with(&paths.journal, &BEGIN) {
        let mut entries = 0;
        for_each_entry(&paths.journal, |_| {
            entries += 1;
            Ok(())
        })?;
        if entries == 0 {
            return Err(CaptureError::Foreign(paths.journal.clone()));
        }
    }
    Ok(())
}

fn open(path: &Path) -> Result<Walker<File>, CaptureError> {
    File::open(path)
        .map(Walker::new)
        .map_err(|error| CaptureError::Open {
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
