//! Work on several files: expands patterns, uses all cores, returns results in order.

use std::collections::BTreeMap;
use std::fs;
use std::num::NonZero;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use super::cli::Captures;
use super::progress::Progress;
use super::{Exit, Fault, say_fault};

/// Interval between progress messages.
const PROGRESS_EVERY: Duration = Duration::from_millis(200);

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
    (text.contains(['*', '?', '[']) && !path.exists()).then_some(text)
}

fn expand(pattern: &str) -> Result<Vec<PathBuf>, Fault> {
    let bad =
        |problem: &dyn std::fmt::Display| Fault::new(Exit::Usage, format!("{pattern}: {problem}"));
    let found = glob::glob(pattern).map_err(|error| bad(&error))?;
    let files: Result<Vec<_>, _> = found.collect();
    let mut files = files.map_err(|error| bad(&error))?;
    files.extend(not_utf8(pattern));
    files.sort();
    // A pattern without a match is reported later, like a missing file.
    if files.is_empty() {
        return Ok(vec![PathBuf::from(pattern)]);
    }
    Ok(files)
}

/// The files whose name matches the pattern but is not UTF-8; `glob` skips them.
fn not_utf8(pattern: &str) -> Vec<PathBuf> {
    let path = Path::new(pattern);
    let name = path.file_name().and_then(|name| name.to_str());
    let Some(name) = name.and_then(|name| glob::Pattern::new(name).ok()) else {
        return Vec::new();
    };
    let folder = path.parent().and_then(Path::to_str).unwrap_or_default();
    let folders = match folder {
        "" => vec![PathBuf::from(".")],
        folder => glob::glob(folder).map_or(Vec::new(), |found| found.flatten().collect()),
    };
    let entries = folders.iter().flat_map(fs::read_dir).flatten().flatten();
    let names = entries.map(|entry| entry.path());
    names
        .filter(|path| {
            let file = path.file_name().unwrap_or_default();
            file.to_str().is_none() && name.matches(&file.to_string_lossy())
        })
        .map(|path| path.strip_prefix(".").map_or(path.clone(), Path::to_owned))
        .collect()
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
