//! Recovers interrupted recordings in the folder of the current recording.

use std::path::{Path, PathBuf};

use super::Keeper;
use crate::capture::{CaptureError, interrupted, recover};
use crate::event::Level;

impl Keeper {
    /// Recovers interrupted recordings in the folder of a recording.
    pub(super) fn recover_beside(&self, path: &Path) {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut inner = self.lock();
        self.spawn(&mut inner, move |keeper| {
            let mut failed = Vec::new();
            for path in interrupted::find_interrupted(&folder) {
                let notice = match recover::recover(&path) {
                    Ok(recovery) => (recovery.level(), recovery.headline()),
                    // Another program has begun to recover the recording.
                    Err(CaptureError::UnderWay(_)) => continue,
                    Err(error) => {
                        failed.push((path, error));
                        continue;
                    }
                };
                keeper.lock().notices.push_back(notice);
            }
            if let Some(text) = hopeless(&failed) {
                keeper.lock().notices.push_back((Level::Warning, text));
            }
        });
    }
}

/// One line about the recordings that could not be recovered. Every start reports them, so the line says how to prevent
/// that.
fn hopeless(failed: &[(PathBuf, CaptureError)]) -> Option<String> {
    let (path, error) = failed.first()?;
    let name = path.display();
    Some(match failed.len() {
        1 => format!("an interrupted recording cannot be recovered: {error}; move or delete it"),
        count => format!(
            "{count} interrupted recordings cannot be recovered, {name} first: {error}; `groundwave recover FOLDER` says \
             why; move or delete them"
        ),
    })
}
