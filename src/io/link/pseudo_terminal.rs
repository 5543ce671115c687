//! The identity of a pseudo-terminal. Numbers of pseudo-terminals are reused: after the robot's has gone, its name may be any other program's, such as a shell's.

use std::path::Path;

/// Maximum number of symbolic links to a terminal.
const MAX_LINKS: usize = 8;

/// The inode of a file, and the time of its latest change.
type Inode = (u64, i64, i64);

/// A pseudo-terminal, and the symbolic links that lead to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PseudoTerminal {
    links: Vec<Inode>,
    terminal: Inode,
}

impl PseudoTerminal {
    /// Finds a pseudo-terminal that numbers name; `None` for other files.
    pub(super) fn find(path: &Path) -> Option<Self> {
        let (mut path, mut links) = (path.to_owned(), Vec::new());
        loop {
            let inode = inode(&path)?;
            let Ok(target) = path.read_link() else {
                return path.starts_with("/dev/pts").then_some(Self {
                    links,
                    terminal: inode,
                });
            };
            if links.len() == MAX_LINKS {
                return None;
            }
            links.push(inode);
            path = path
                .parent()
                .map_or(target.clone(), |folder| folder.join(target));
        }
    }

    /// Whether a terminal found under the same name belongs to another program: it is not this one, and no link to it was recreated.
    pub(super) fn is_replaced_by(&self, now: &Self) -> bool {
        self.terminal != now.terminal && self.links == now.links
    }
}

#[cfg(unix)]
fn inode(path: &Path) -> Option<Inode> {
    use std::os::unix::fs::MetadataExt as _;
    let found = path.symlink_metadata().ok()?;
    Some((found.ino(), found.ctime(), found.ctime_nsec()))
}

#[cfg(not(unix))]
fn inode(_: &Path) -> Option<Inode> {
    None
}
