//! Work on several files: expands patterns, uses all cores, returns results in order.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, FileType};
use std::num::NonZero;
use std::ops::ControlFlow;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use glob::{Pattern, PatternError};

use super::cli::Captures;
use super::input;
use super::progress::Progress;
use super::{Exit, Fault, say_fault};

/// Interval between progress messages.
const PROGRESS_EVERY: Duration = Duration::from_millis(200);

/// Characters that make a name a pattern.
const SPECIAL: [char; 3] = ['*', '?', '['];

/// The named captures; patterns that the shell has not expanded are expanded.
pub(super) fn files(named: &Captures) -> Result<Vec<PathBuf>, Fault> {
    let mut files = Vec::new();
    for path in &named.files {
        match pattern(path) {
            Some(pattern) => files.extend(expand(pattern)?),
            _ => files.push(path.clone()),
        }
    }
    Ok(files)
}

/// The path as a pattern, unless a file with this name exists.
pub(super) fn pattern(path: &Path) -> Option<&str> {
    let text = path.to_str()?;
    (text.contains(SPECIAL) && !path.exists()).then_some(text)
}

fn expand(pattern: &str) -> Result<Vec<PathBuf>, Fault> {
    let bad = |error: &PatternError| Fault::new(Exit::Usage, format!("{pattern}: {error}"));
    Pattern::new(pattern).map_err(|error| bad(&error))?;
    let mut found = BTreeSet::from([PathBuf::new()]);
    for part in Path::new(pattern).components() {
        found = match (part, part.as_os_str().to_str()) {
            (Component::Normal(_), Some("**")) => folders_in(found)?,
            (Component::Normal(_), Some(name)) if name.contains(SPECIAL) => {
                let name = Pattern::new(name).map_err(|error| bad(&error))?;
                matching(&found, &name)?
            }
            _ => found.into_iter().map(|path| path.join(part)).collect(),
        };
    }
    found.retain(|path| fs::symlink_metadata(path).is_ok());
    // A pattern without a match is reported later, like a missing file.
    if found.is_empty() {
        return Ok(vec![PathBuf::from(pattern)]);
    }
    Ok(found.into_iter().collect())
}

/// The entries of these folders whose name matches.
fn matching(folders: &BTreeSet<PathBuf>, name: &Pattern) -> Result<BTreeSet<PathBuf>, Fault> {
    let mut found = BTreeSet::new();
    for folder in folders {
        for (path, _) in entries(folder)? {
            let file = path.file_name().unwrap_or_default();
            if name.matches(&file.to_string_lossy()) {
                found.insert(path);
            }
        }
    }
    Ok(found)
}

/// These folders and all below them, except for linked folders, because links may form a loop.
fn folders_in(tops: BTreeSet<PathBuf>) -> Result<BTreeSet<PathBuf>, Fault> {
    let mut found = BTreeSet::new();
    let mut left: Vec<PathBuf> = tops.into_iter().collect();
    while let Some(folder) = left.pop() {
        let below = entries(&folder)?;
        left.extend(
            below
                .into_iter()
                .filter_map(|(path, kind)| kind.is_dir().then_some(path)),
        );
        found.insert(folder);
    }
    Ok(found)
}

/// Path and kind of each entry of a folder; nothing if it is not a folder. The path "" is the current folder.
fn entries(folder: &Path) -> Result<Vec<(PathBuf, FileType)>, Fault> {
    let is_here = folder.as_os_str().is_empty();
    let place = if is_here { Path::new(".") } else { folder };
    if !place.is_dir() {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for entry in fs::read_dir(place).map_err(|error| input::cannot_read(place, error))? {
        let entry = entry.map_err(|error| input::cannot_read(place, error))?;
        // An entry may have been removed meanwhile.
        if let Ok(kind) = entry.file_type() {
            found.push((folder.join(entry.file_name()), kind));
        }
    }
    Ok(found)
}

/// Runs `work` for each file on all cores and passes the results to `take` in the order of the files; `take` may end
/// early. Faults are printed, except for the last one, which is returned.
pub(super) fn each<T: Send>(
    files: &[PathBuf],
    quiet: bool,
    work: impl Fn(usize, &Progress) -> Result<T, Fault> + Sync,
    mut take: impl FnMut(usize, T) -> Result<ControlFlow<()>, Fault>,
) -> Result<(), Fault> {
    let progress = Progress::new(total_bytes(files), quiet);
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    let next = AtomicUsize::new(0);
    let is_over = AtomicBool::new(false);
    let mut fault: Option<Fault> = None;
    thread::scope(|scope| {
        let (sender, results) = sync_channel(workers);
        for _ in 0..workers.min(files.len()) {
            let (sender, progress) = (sender.clone(), &progress);
            let (next, is_over, work) = (&next, &is_over, &work);
            scope.spawn(move || {
                while !is_over.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= files.len() || sender.send((index, work(index, progress))).is_err()
                    {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let mut waiting = BTreeMap::new();
        let mut turn = 0;
        'all: loop {
            match results.recv_timeout(PROGRESS_EVERY) {
                Ok((index, result)) => drop(waiting.insert(index, result)),
                Err(RecvTimeoutError::Timeout) => progress.show(),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            while let Some(result) = waiting.remove(&turn) {
                progress.clear();
                turn += 1;
                match result.and_then(|result| take(turn - 1, result)) {
                    Ok(ControlFlow::Continue(())) => {}
                    Ok(ControlFlow::Break(())) => break 'all,
                    Err(found) => {
                        if let Some(earlier) = fault.replace(found) {
                            say_fault(&earlier);
                        }
                    }
                }
            }
        }
        is_over.store(true, Ordering::Relaxed);
        drop(results);
    });
    progress.clear();
    fault.map_or(Ok(()), Err)
}

/// Total size of all files, bytes; `None` if one is not a regular file.
fn total_bytes(files: &[PathBuf]) -> Option<u64> {
    let bytes = |path: &PathBuf| {
        let about = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        Some(about.len())
    };
    files.iter().map(bytes).sum()
}
