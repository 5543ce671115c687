//! Reports of mouse clicks and the wheel, without movements: those would wake the program constantly.

/// Enables reports of clicks and the wheel.
#[cfg(not(windows))]
pub(super) const ENABLE: &[u8] = b"\x1b[?1000h\x1b[?1006h";

/// Disables reports of clicks and the wheel.
#[cfg(not(windows))]
pub(super) const DISABLE: &[u8] = b"\x1b[?1006l\x1b[?1000l";

/// Enables or disables mouse reports in a Windows console, which takes a call and not a sequence.
///
/// # Errors
/// If the system refuses.
#[cfg(windows)]
pub(super) fn report(is_on: bool) -> std::io::Result<()> {
    use crossterm::event::{DisableMouseCapture, EnableMouseCapture};
    let mut output = std::io::stdout();
    if is_on {
        crossterm::execute!(output, EnableMouseCapture)
    } else {
        crossterm::execute!(output, DisableMouseCapture)
    }
}
