//! Remembers that the operator has seen the tour of the demo, by a file in the state folder.

use std::fs;
use std::path::PathBuf;

use etcetera::BaseStrategy as _;

/// Whether the tour has not been completed yet.
pub(super) fn is_due() -> bool {
    path().is_none_or(|path| !path.exists())
}

/// Records that the tour has ended. If the file cannot be written, the next demo shows the tour again.
pub(super) fn end() {
    if let Some(path) = path() {
        let _ = path.parent().map(fs::create_dir_all);
        let _ = fs::write(path, "");
    }
}

fn path() -> Option<PathBuf> {
    let strategy = etcetera::choose_base_strategy().ok()?;
    let folder = strategy.state_dir().unwrap_or_else(|| strategy.data_dir());
    Some(folder.join("groundwave").join("tour-ended"))
}
