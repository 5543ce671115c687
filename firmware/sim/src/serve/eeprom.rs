//! The boot counter in a file, as a robot keeps it in its EEPROM.

use std::fs;
use std::io;
use std::path::Path;

use super::ServeError;

/// Counts a boot: reads the counter (none yet is 0), adds one, stores and returns it.
pub(super) fn count_boot(path: &Path) -> Result<u16, ServeError> {
    let fail = |problem: String| ServeError::Eeprom {
        path: path.to_owned(),
        problem,
    };
    let boots = match fs::read_to_string(path) {
        Ok(text) => parse(&text).ok_or_else(|| {
            fail("it does not read `boots=NUMBER`; remove it to start from 1".to_owned())
        })?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => 0,
        Err(error) => return Err(fail(error.to_string())),
    };
    let boots = boots.wrapping_add(1);
    // Replaced in one step, so that a crash leaves the old counter or the new one.
    let mut partial = path.as_os_str().to_owned();
    partial.push(".partial");
    fs::write(&partial, format!("boots={boots}\n"))
        .and_then(|()| fs::rename(&partial, path))
        .map_err(|error| fail(error.to_string()))?;
    Ok(boots)
}

fn parse(text: &str) -> Option<u16> {
    text.trim().strip_prefix("boots=")?.parse().ok()
}
