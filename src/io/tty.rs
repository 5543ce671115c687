//! Terminal devices on which nothing is waited for.

use std::io::Write;
use std::path::Path;

/// Another way into a device: it takes what it has room for, and never waits. Whether a write may wait belongs to what was
/// opened, so whoever has the device open otherwise is not concerned. `None` where the system has no such way.
#[cfg(unix)]
pub(super) fn without_waiting(path: &Path) -> Option<Box<dyn Write + Send>> {
    use std::fs::OpenOptions;
    use std::os::unix::fs::OpenOptionsExt;

    use rustix::fs::OFlags;

    let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    let mut options = OpenOptions::new();
    let device = options.write(true).custom_flags(flags.bits() as i32);
    Some(Box::new(device.open(path).ok()?))
}

#[cfg(not(unix))]
pub(super) fn without_waiting(_path: &Path) -> Option<Box<dyn Write + Send>> {
    None
}
