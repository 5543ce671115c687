//! How far long work is, for a person at a terminal.

use std::io::{self, IsTerminal, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::say_progress;

/// Work that is done sooner than this is not talked about.
const PATIENCE: Duration = Duration::from_millis(500);

/// Erases the line that the cursor is in, on terminals of all kinds.
const ERASE: &str = "\x1b[2K\r";

/// Bytes read of all files together, and how many there are.
pub(super) struct Progress {
    done: Arc<AtomicU64>,
    total: u64,
    began: Instant,
    is_shown: bool,
}

impl Progress {
    /// Of work on so many bytes; none if their number is not known. Only a terminal is told.
    pub(super) fn new(total: Option<u64>, quiet: bool) -> Self {
        Self {
            done: Arc::default(),
            total: total.unwrap_or(0),
            began: Instant::now(),
            is_shown: !quiet && total.is_some() && io::stderr().is_terminal(),
        }
    }

    /// A source whose bytes count.
    pub(super) fn count<R: Read>(&self, source: R) -> Counting<R> {
        Counting {
            source,
            done: Arc::clone(&self.done),
        }
    }

    /// Says how far it is.
    pub(super) fn show(&self) {
        let passed = self.began.elapsed();
        if self.is_shown && passed >= PATIENCE {
            let done = self.done.load(Ordering::Relaxed);
            say_progress(format_args!(
                "{ERASE}{}",
                in_words(done, self.total, passed)
            ));
        }
    }

    /// Takes back what was said.
    pub(super) fn clear(&self) {
        if self.is_shown && self.began.elapsed() >= PATIENCE {
            say_progress(ERASE);
        }
    }
}

/// `43 %, 0:12 left`
fn in_words(done: u64, total: u64, passed: Duration) -> String {
    let share = (done as f64 / total.max(1) as f64).min(1.0);
    if share <= 0.0 {
        return "0 %".to_owned();
    }
    let left_s = (passed.as_secs_f64() * (1.0 - share) / share).ceil() as u64;
    let per_cent = (share * 100.0).floor();
    format!("{per_cent} %, {}:{:02} left", left_s / 60, left_s % 60)
}

/// Counts what is read.
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
    fn the_time_left_follows_from_the_time_passed() {
        let after = Duration::from_secs(30);
        assert_eq!(in_words(0, 100, after), "0 %");
        assert_eq!(in_words(25, 100, after), "25 %, 1:30 left");
        assert_eq!(in_words(100, 100, after), "100 %, 0:00 left");
        assert_eq!(in_words(200, 100, after), "100 %, 0:00 left");
        assert_eq!(in_words(5, 0, after), "100 %, 0:00 left");
    }
}
