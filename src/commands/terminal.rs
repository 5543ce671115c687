//! Checks that the dashboard has a terminal, and reports terminal errors.

use std::io;

use super::{Exit, Fault};
use crate::hint;
use crate::io::terminal;

/// Refuses to show a dashboard without a terminal; `instead` names a command that needs none.
pub(super) fn needed(instead: &str) -> Result<(), Fault> {
    if terminal::is_there() {
        return Ok(());
    }
    Err(Fault::new(
        Exit::Usage,
        format!("the dashboard needs a terminal; use `{instead}` instead"),
    ))
}

/// The fault for a terminal error. A closed terminal is not a fault; it ends the session.
pub(super) fn failed(error: &io::Error) -> Result<(), Fault> {
    if !terminal::is_there() {
        return Ok(());
    }
    Err(Fault::new(
        Exit::Failed,
        format!("the terminal failed: {}", hint::words(error)),
    ))
}
