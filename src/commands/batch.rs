//! Many files at once: patterns, all cores, results in order.

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
use super::{Exit, Fault, say};

/// How often a person is told how far it is.
const TOLD_EVERY: Duration = Duration::from_millis(200);

/// The captures that were named. Patterns that the shell has left alone are expanded here.
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

/// The name as a pattern; a file may be called like one.
pub(super) fn pattern(path: &Path) -> Option<&str> {
    let text = path.to_str()?;
    (text.contains(['*', '?', '[']) && !path.exists()).then_some(text)
}

fn expand(pattern: &str) -> Result<Vec<PathBuf>, Fault> {
    let bad =
        |problem: &dyn std::fmt::Display| Fault::new(Exit::Usage, format!("{pattern}: {problem}"));
    let found = glob::glob(pattern).map_err(|error| bad(&error))?;
    let files: Result<Vec<_>, _> = found.collect();
    let files = files.map_err(|error| bad(&error))?;
    // One that matches nothing is named in its turn, as a file that is not there is.
    if files.is_empty() {
        return Ok(vec![PathBuf::from(pattern)]);
    }
    Ok(files)
}

/// Does `work` for each file, by its place in `files`, on all cores, and hands what comes of it to `take` in
/// their order. `take` may end it early. One bad file does not hide the others: every fault is told, and the
/// last one is left to the caller.
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
        let mut early = BTreeMap::new();
        let mut turn = 0;
        'all: loop {
            match results.recv_timeout(TOLD_EVERY) {
                Ok((index, result)) => drop(early.insert(index, result)),
                Err(RecvTimeoutError::Timeout) => progress.show(),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            while let Some(result) = early.remove(&turn) {
                progress.clear();
                turn += 1;
                match result.and_then(|result| take(turn - 1, result)) {
                    Ok(ControlFlow::Continue(())) => {}
                    Ok(ControlFlow::Break(())) => break 'all,
                    Err(found) => {
                        if let Some(earlier) = fault.replace(found) {
                            say(format_args!("groundwave: {earlier}"));
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

/// Bytes in all files together; `None` where one of them is a pipe.
fn total_bytes(files: &[PathBuf]) -> Option<u64> {
    let bytes = |path: &PathBuf| {
        let about = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        Some(about.len())
    };
    files.iter().map(bytes).sum()
}
