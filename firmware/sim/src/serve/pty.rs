//! A pseudo-terminal that behaves like a serial port with a radio behind it.

use std::os::fd::OwnedFd;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::pty::OpenptFlags;
use rustix::termios::{OptionalActions, QueueSelector};

use super::error::ServeError;
use super::link_file::LinkFile;
use super::port::Port;

/// Time after which unread bytes are dropped, so that a late reader receives current data.
const STALE: Duration = Duration::from_secs(1);

const BAUD: u32 = 2400;

/// Maximum number of bytes per read.
const READ_MAX: usize = 256;

/// The master side. The slave side is kept open so that it stays raw and never hangs up.
#[derive(Debug)]
pub struct Pty {
    master: OwnedFd,
    slave: OwnedFd,
    copy_only: bool,
    /// Bytes in the slave's input queue after the last write, and the time of the last read.
    queued: u64,
    read_at: Instant,
    _link: Option<LinkFile>,
}

impl Pty {
    /// Opens a pseudo-terminal; returns it with its path.
    ///
    /// # Errors
    ///
    /// When the system has no pseudo-terminal left, or the link cannot be made.
    pub fn open(link: Option<&Path>, copy_only: bool) -> Result<(Self, String), ServeError> {
        let (master, slave, path) = open_pair().map_err(|errno| ServeError::Pty(errno.into()))?;
        let link = link
            .map(|link| LinkFile::make(link, Path::new(&path)))
            .transpose()?;
        let port = Self {
            master,
            slave,
            copy_only,
            queued: 0,
            read_at: Instant::now(),
            _link: link,
        };
        Ok((port, path))
    }

    fn drop_unread(&mut self, now: Instant) {
        // If flushing fails, the queue's own limit applies.
        let _ = rustix::termios::tcflush(&self.slave, QueueSelector::IFlush);
        self.queued = 0;
        self.read_at = now;
    }

    fn drop_stale(&mut self, now: Instant) {
        let unread = rustix::io::ioctl_fionread(&self.slave).unwrap_or(0);
        if unread == 0 || unread < self.queued {
            self.read_at = now;
        }
        self.queued = unread;
        if now.saturating_duration_since(self.read_at) > STALE {
            self.drop_unread(now);
        }
    }
}

impl Port for Pty {
    fn write(&mut self, bytes: &[u8], now: Instant) {
        self.drop_stale(now);
        let mut left = bytes;
        while !left.is_empty() {
            match rustix::io::write(&self.master, left) {
                Ok(count) => {
                    left = left.get(count..).unwrap_or_default();
                    self.queued += count as u64;
                }
                Err(Errno::INTR) => {}
                // Full: only at high time factors, where bytes cannot become stale first.
                Err(_) => {
                    self.drop_unread(now);
                    break;
                }
            }
        }
    }

    fn read(&mut self, into: &mut Vec<u8>) {
        let mut bytes = [0; READ_MAX];
        if let Ok(count) = rustix::io::read(&self.master, &mut bytes)
            && !self.copy_only
        {
            into.extend(bytes.get(..count).unwrap_or_default());
        }
    }
}

fn open_pair() -> rustix::io::Result<(OwnedFd, OwnedFd, String)> {
    let master = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    rustix::io::fcntl_setfd(&master, rustix::io::FdFlags::CLOEXEC)?;
    rustix::pty::grantpt(&master)?;
    rustix::pty::unlockpt(&master)?;
    let name = rustix::pty::ptsname(&master, Vec::new())?;
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    let slave = rustix::fs::open(&name, flags, Mode::empty())?;
    let mut termios = rustix::termios::tcgetattr(&slave)?;
    termios.make_raw();
    // A pseudo-terminal has no speed; it is set for programs that query it.
    let _ = termios.set_speed(BAUD);
    rustix::termios::tcsetattr(&slave, OptionalActions::Now, &termios)?;
    let status = rustix::fs::fcntl_getfl(&master)?;
    rustix::fs::fcntl_setfl(&master, status | OFlags::NONBLOCK)?;
    Ok((master, slave, name.to_string_lossy().into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::event::{PollFd, PollFlags, Timespec};

    fn wait_readable(terminal: &OwnedFd) {
        let mut poll = [PollFd::new(terminal, PollFlags::IN)];
        let limit = Timespec {
            tv_sec: 20,
            tv_nsec: 0,
        };
        assert_eq!(
            rustix::event::poll(&mut poll, Some(&limit)),
            Ok(1),
            "no data within 20 s"
        );
    }

    fn read(terminal: &OwnedFd) -> Vec<u8> {
        wait_readable(terminal);
        let mut bytes = [0; 64];
        let count = rustix::io::read(terminal, &mut bytes).unwrap();
        bytes[..count].to_vec()
    }

    #[test]
    fn late_reader_receives_current_data() {
        let (mut pty, path) = Pty::open(None, false).unwrap();
        let terminal =
            rustix::fs::open(path, OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap();
        let begun = Instant::now();
        pty.write(b"fresh", begun);
        assert_eq!(read(&terminal), b"fresh");
        pty.write(b"old", begun + STALE / 2);
        wait_readable(&terminal);
        pty.write(b"", begun + STALE);
        pty.write(b"", begun + STALE * 3);
        pty.write(b"new", begun + STALE * 3);
        assert_eq!(read(&terminal), b"new");
    }
}
