//! The way to the terminal, which never waits: a terminal that takes nothing holds up its picture and nobody else.

use std::io::{self, ErrorKind, Write};
use std::thread;
use std::time::{Duration, Instant};

/// How soon a terminal that took less than it was given is tried again; each time that it takes nothing twice as late.
const RETRY: Duration = Duration::from_millis(20);
const RETRY_MAX: Duration = Duration::from_millis(320);

/// Somebody has set a speed as low as this for its sake. Higher ones are what systems give any terminal: 9600 or 38400.
#[cfg(unix)]
const BELIEVED_BAUD_MAX: u32 = 4800;

/// Bits of a byte on a serial line, with start and stop.
#[cfg(unix)]
const BITS: u32 = 10;

/// Bytes on their way to the terminal.
pub(super) struct Outlet<W = Box<dyn Write + Send>> {
    terminal: W,
    /// What a byte takes on the terminal's line, where that is known to be slow.
    byte_time: Duration,
    waiting: Vec<u8>,
    retry: Duration,
    /// When all that was put has passed the line.
    passed_at: Option<Instant>,
}

impl Outlet {
    /// A way of its own to the terminal on standard output: what it is told about waiting must not concern the shell, which
    /// shares ours. Where the system has none, standard output itself, which may wait.
    pub(super) fn open() -> Self {
        Self::to(
            own_way().unwrap_or_else(|| Box::new(io::stdout())),
            byte_time(),
        )
    }
}

impl<W: Write> Outlet<W> {
    const fn to(terminal: W, byte_time: Duration) -> Self {
        Self {
            terminal,
            byte_time,
            waiting: Vec::new(),
            retry: RETRY,
            passed_at: None,
        }
    }

    /// Sends bytes; what the terminal does not take at once waits.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub(super) fn put(&mut self, now: Instant, bytes: &[u8]) -> io::Result<()> {
        let begin = self.passed_at.map_or(now, |at| at.max(now));
        self.passed_at = Some(begin + self.byte_time * bytes.len() as u32);
        self.waiting.extend_from_slice(bytes);
        self.push()
    }

    /// Sends of what waits as much as the terminal takes.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub(super) fn push(&mut self) -> io::Result<()> {
        while !self.waiting.is_empty() {
            match self.terminal.write(&self.waiting) {
                Ok(0) => break,
                Ok(count) => {
                    self.waiting.drain(..count);
                    self.retry = RETRY;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    self.retry = (self.retry * 2).min(RETRY_MAX);
                    break;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.terminal.flush()
    }

    /// When to look again whether there is room for another frame; `None` when there is.
    pub(super) fn busy_until(&self, now: Instant) -> Option<Instant> {
        if self.waiting.is_empty() {
            self.passed_at.filter(|at| *at > now)
        } else {
            Some(now + self.retry)
        }
    }

    /// Whether this is the end of what waits.
    pub(super) fn ends_with(&self, bytes: &[u8]) -> bool {
        self.waiting.ends_with(bytes)
    }

    /// Waits for the terminal to take everything, but not forever.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub(super) fn finish(&mut self, patience: Duration) -> io::Result<()> {
        let deadline = Instant::now() + patience;
        while !self.waiting.is_empty() && Instant::now() < deadline {
            thread::sleep(RETRY);
            self.push()?;
        }
        Ok(())
    }
}

#[cfg(unix)]
fn own_way() -> Option<Box<dyn Write + Send>> {
    use std::ffi::OsString;
    use std::os::unix::ffi::OsStringExt;

    use crate::io::tty;

    let named = rustix::termios::ttyname(io::stdout(), Vec::new()).ok();
    let named = named.map(|name| OsString::from_vec(name.into_bytes()));
    // The first belongs to whoever logged in, which need not be who runs this.
    let mut names = named.into_iter().chain(["/dev/tty".into()]);
    names.find_map(|name| tty::without_waiting(name.as_ref()))
}

#[cfg(not(unix))]
fn own_way() -> Option<Box<dyn Write + Send>> {
    None
}

/// What a byte takes by the speed that the terminal is set to, if it is a low one: `stty 2400`.
#[cfg(unix)]
fn byte_time() -> Duration {
    let set = rustix::termios::tcgetattr(io::stdout());
    match set.map_or(0, |set| set.output_speed()) {
        baud @ 1..=BELIEVED_BAUD_MAX => Duration::from_secs(1) * BITS / baud,
        _ => Duration::ZERO,
    }
}

#[cfg(not(unix))]
const fn byte_time() -> Duration {
    Duration::ZERO
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A terminal that has room for so many bytes.
    #[derive(Default)]
    struct Narrow {
        room: usize,
        taken: Vec<u8>,
    }

    impl Write for Narrow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let count = bytes.len().min(self.room);
            if count == 0 {
                return Err(ErrorKind::WouldBlock.into());
            }
            self.room -= count;
            self.taken.extend_from_slice(&bytes[..count]);
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    proptest! {
        /// Whatever room there is when: all bytes arrive, in order, and room is told of when nothing waits.
        #[test]
        fn nothing_is_lost_in_a_narrow_terminal(
            steps in prop::collection::vec((prop::collection::vec(any::<u8>(), 0..50), 0_usize..50), 1..20)
        ) {
            let now = Instant::now();
            let mut outlet = Outlet::to(Narrow::default(), Duration::ZERO);
            let mut put = Vec::new();
            for (bytes, room) in steps {
                outlet.put(now, &bytes).unwrap();
                put.extend(bytes);
                outlet.terminal.room += room;
                outlet.push().unwrap();
                prop_assert_eq!(outlet.busy_until(now).is_none(), outlet.terminal.taken.len() == put.len());
            }
            outlet.terminal.room = usize::MAX;
            outlet.push().unwrap();
            prop_assert_eq!(&outlet.terminal.taken, &put);
        }
    }

    /// At 2400 baud a frame of 480 bytes has passed after two seconds, and another one behind it after four.
    #[test]
    fn a_slow_line_has_room_when_the_last_frame_has_passed() {
        let terminal = Narrow {
            room: usize::MAX,
            ..Narrow::default()
        };
        let mut outlet = Outlet::to(terminal, Duration::from_secs(1) / 240);
        let begin = Instant::now();
        let at = |ms| begin + Duration::from_millis(ms);
        let is_busy = |outlet: &Outlet<Narrow>, ms| outlet.busy_until(at(ms)).is_some();
        outlet.put(begin, &[0; 480]).unwrap();
        assert!(is_busy(&outlet, 1990));
        assert!(!is_busy(&outlet, 2010));
        outlet.put(at(1000), &[0; 480]).unwrap();
        assert!(is_busy(&outlet, 3990));
        assert!(!is_busy(&outlet, 4010));
        // It does not run ahead after a pause.
        outlet.put(at(9000), &[0; 240]).unwrap();
        assert!(is_busy(&outlet, 9990));
        assert!(!is_busy(&outlet, 10_010));
    }
}
