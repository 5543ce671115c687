//! Progress of long work, shown on a terminal.

use std::io::{self, IsTerminal, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::{erase_progress, say_progress};

/// Minimum duration of work that shows progress.
const SHOW_AFTER: Duration = Duration::from_millis(500);

/// Counts the bytes read from all files together.
pub(super) struct Progress {
    done: Arc<AtomicU64>,
    total: u64,
    began: Instant,
    is_shown: bool,
}

impl Progress {
    /// Progress over `total` bytes; shown only on a terminal and if the total is known.
    pub(super) fn new(total: Option<u64>, quiet: bool) -> Self {
        Self {
            done: Arc::default(),
            total: total.unwrap_or(0),
            began: Instant::now(),
            is_shown: !quiet && total.is_some() && io::stderr().is_terminal(),
        }
    }

    /// Counts the bytes read from `source`.
    pub(super) fn count<R: Read>(&self, source: R) -> Counting<R> {
        Counting {
            source,
            done: Arc::clone(&self.done),
        }
    }

    /// Shows the progress.
    pub(super) fn show(&self) {
        let passed = self.began.elapsed();
        if self.is_shown && passed >= SHOW_AFTER {
            let done = self.done.load(Ordering::Relaxed);
            erase_progress();
            say_progress(describe(done, self.total, passed));
        }
    }

    /// Erases the progress.
    pub(super) fn clear(&self) {
        if self.is_shown && self.began.elapsed() >= SHOW_AFTER {
            erase_progress();
        }
    }
}

/// Progress as text: `43 %, 0:12 left`.
fn describe(done: u64, total: u64, passed: Duration) -> String {
    let share = (done as f64 / total.max(1) as f64).min(1.0);
    if share <= 0.0 {
        return "0 %".to_owned();
    }
    let left_s = (passed.as_secs_f64() * (1.0 - share) / share).ceil() as u64;
    let per_cent = (share * 100.0).floor();
    format!("{per_cent} %, {}:{:02} left", left_s / 60, left_s % 60)
}

/// A source that counts its bytes.
pub(super) struct Counting<R> {
    source: R,
    done: Arc<AtomicU64>,
}

impl<R: Read> Read for Counting<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let read = self.source.read(to)?;
        self.done.fetch_add(read as u64, Ordering::Relaxed);
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_follows_from_time_passed() {
        let after = Duration::from_secs(30);
        assert_eq!(describe(0, 100, after), "0 %");
        assert_eq!(describe(25, 100, after), "25 %, 1:30 left");
        assert_eq!(describe(100, 100, after), "100 %, 0:00 left");
        assert_eq!(describe(200, 100, after), "100 %, 0:00 left");
        assert_eq!(describe(5, 0, after), "100 %, 0:00 left");
    }
}
