//! The number of files and sockets that the program may open. Libraries panic at the limit, so the program checks it at the start.

use std::io;

/// Maximum number of files and sockets that any command needs, without clients of a shared link.
pub const ANY_COMMAND: usize = 24;

/// Makes sure that `count` further files can be opened; raises the program's limit as far as the system allows.
///
/// # Errors
/// The system's error of opening too many files.
pub fn ensure(count: usize) -> io::Result<()> {
    try_to_open(count).or_else(|_| {
        raise_limit();
        try_to_open(count)
    })
}

#[cfg(unix)]
fn try_to_open(count: usize) -> io::Result<()> {
    use std::os::fd::AsFd as _;
    let stdin = io::stdin();
    let open = (0..count).map(|_| stdin.as_fd().try_clone_to_owned());
    open.collect::<io::Result<Vec<_>>>().map(drop)
}

#[cfg(unix)]
fn raise_limit() {
    use rustix::process::{Resource, getrlimit, setrlimit};
    let mut limit = getrlimit(Resource::Nofile);
    limit.current = limit.maximum;
    // The next attempt shows whether the limit was raised.
    let _ = setrlimit(Resource::Nofile, limit);
}

#[cfg(not(unix))]
fn try_to_open(_: usize) -> io::Result<()> {
    Ok(())
}

#[cfg(not(unix))]
fn raise_limit() {}
