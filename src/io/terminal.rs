//! The terminal: set up for the dashboard, and restored on every exit.

mod drawing;
#[cfg(unix)]
mod escape;
mod events;
mod input;

use std::io::{self, IsTerminal, Write};
use std::panic;
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;

use crossterm::event::{DisableBracketedPaste, EnableBracketedPaste};
#[cfg(not(windows))]
use crossterm::event::{
    KeyboardEnhancementFlags, PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
};
use crossterm::style::ResetColor;
use crossterm::{cursor, queue, terminal};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;

use self::drawing::{Device, Drawing};
pub use self::events::Events;
pub use self::input::events;
use super::mouse;

/// The drawing thread of the terminal in use; a panic ends it.
static CURRENT: Mutex<Option<Drawing>> = Mutex::new(None);

/// Maximum time for a terminal to take the last bytes.
const PATIENCE: Duration = Duration::from_secs(1);

/// Maximum speed that is taken for a real serial line, bit/s; systems report a higher speed for every terminal.
#[cfg(unix)]
const BELIEVED_BAUD_MAX: u32 = 4800;

/// Minimum speed of a serial line for pictures, bit/s.
#[cfg(unix)]
const PICTURES_BAUD_MIN: u32 = 1_000_000;

/// Bits of a byte on a serial line, with start and stop.
#[cfg(unix)]
const BITS_PER_BYTE: u32 = 10;

/// Maximum screen that is drawn, columns and rows: as many as a display of 7680 x 4320 pixels shows in characters of 12 x 13. It takes 40 MiB;
/// a terminal that claims 65535 x 65535 would need 4 G cells.
const SIZE_MAX: (u16, u16) = (640, 320);

/// Whether standard output is a terminal.
#[must_use]
pub fn is_there() -> bool {
    io::stdout().is_terminal()
}

/// Makes the bytes that the drawing thread writes after a frame.
pub type After = Box<dyn FnOnce() -> Vec<u8> + Send>;

/// The terminal while the dashboard runs. Dropping it restores the terminal.
pub struct Screen {
    drawing: Drawing,
    size: Rect,
    has_mouse: bool,
}

impl Screen {
    /// Sets up the terminal, also for clicks and the wheel if `has_mouse`. Does not query the terminal: a terminal that does
    /// not answer would cost seconds.
    ///
    /// # Errors
    /// If standard output is not a terminal, or the system refuses.
    pub fn take(has_mouse: bool) -> io::Result<Self> {
        restore_on_panic();
        let size = size()?;
        Ok(Self {
            drawing: enter(size, has_mouse)?,
            size,
            has_mouse,
        })
    }

    /// Rings the terminal's bell.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub fn ring(&self) -> io::Result<()> {
        self.drawing.ring()
    }

    /// Asks the terminal to put a text on the clipboard (OSC 52). Not every terminal supports this.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub fn copy(&self, text: &str) -> io::Result<()> {
        self.drawing.copy(text)
    }

    /// Size of the screen, columns and rows.
    #[must_use]
    pub const fn size(&self) -> (u16, u16) {
        (self.size.width, self.size.height)
    }

    /// Sets a new size; the next frame is written completely.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub fn resize(&mut self, width: u16, height: u16) -> io::Result<()> {
        self.size = area(width, height);
        self.drawing.redraw()
    }

    /// Draws a frame in memory and passes it to the drawing thread. A busy terminal gets only the newest frame.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub fn draw(&self, draw: impl FnOnce(&mut Buffer) -> Option<After>) -> io::Result<()> {
        self.drawing.draw(self.size, draw)
    }

    /// Reads the terminal's size again; the next frame is written completely.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub fn redraw(&mut self) -> io::Result<()> {
        self.size = size()?;
        self.drawing.redraw()
    }

    /// Restores the terminal, runs `meanwhile` and sets the terminal up again.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub fn suspend(&mut self, meanwhile: impl FnOnce()) -> io::Result<()> {
        leave();
        meanwhile();
        self.size = size()?;
        self.drawing = enter(self.size, self.has_mouse)?;
        Ok(())
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        leave();
    }
}

fn size() -> io::Result<Rect> {
    terminal::size().map(|(width, height)| area(width, height))
}

/// The part of a terminal that is drawn on.
fn area(width: u16, height: u16) -> Rect {
    let (columns, rows) = SIZE_MAX;
    Rect::new(0, 0, width.min(columns), height.min(rows))
}

/// Starts a drawing thread, which sets up the terminal.
fn enter(size: Rect, has_mouse: bool) -> io::Result<Drawing> {
    #[cfg(windows)]
    if !crossterm::ansi_support::supports_ansi() {
        return Err(io::Error::other(
            "this console does not understand escape sequences; use Windows Terminal, or Windows 10 or newer",
        ));
    }
    terminal::enable_raw_mode()?;
    let drawing = start(size, has_mouse).inspect_err(|_| {
        let _ = terminal::disable_raw_mode();
    })?;
    *CURRENT.lock().unwrap_or_else(PoisonError::into_inner) = Some(drawing.clone());
    Ok(drawing)
}

fn start(size: Rect, has_mouse: bool) -> io::Result<Drawing> {
    let mut enter = Vec::new();
    queue!(
        enter,
        terminal::EnterAlternateScreen,
        // Characters that are wider on the terminal than counted end at the margin.
        terminal::DisableLineWrap,
        EnableBracketedPaste,
        ResetColor,
        terminal::Clear(terminal::ClearType::All),
        cursor::Hide
    )?;
    // A Windows console always reports releases of keys, and refuses this command.
    #[cfg(not(windows))]
    queue!(
        enter,
        PushKeyboardEnhancementFlags(
            KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES
                | KeyboardEnhancementFlags::REPORT_EVENT_TYPES
        )
    )?;
    if has_mouse {
        #[cfg(not(windows))]
        enter.extend_from_slice(mouse::ENABLE);
        #[cfg(windows)]
        mouse::report(true)?;
    }
    Drawing::start(Device {
        output: output(),
        byte_time: byte_time(),
        size,
        enter,
        leave: leaving()?,
    })
}

/// The sequences that restore the terminal.
fn leaving() -> io::Result<Vec<u8>> {
    let mut leave = Vec::new();
    #[cfg(not(windows))]
    {
        leave.extend_from_slice(mouse::DISABLE);
        queue!(leave, PopKeyboardEnhancementFlags)?;
    }
    queue!(
        leave,
        ResetColor,
        DisableBracketedPaste,
        terminal::EnableLineWrap,
        terminal::LeaveAlternateScreen,
        cursor::Show
    )?;
    Ok(leave)
}

/// Ends the drawing thread and restores the terminal. Every step is tried: a closed terminal fails each of them.
fn leave() {
    let current = CURRENT
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take();
    let Some(drawing) = current else { return };
    if drawing.is_current() {
        // The drawing thread itself panicked; it cannot wait for itself.
        let _ = leaving().and_then(|sequences| output().write_all(&sequences));
    } else {
        drawing.end(PATIENCE);
    }
    #[cfg(windows)]
    let _ = mouse::report(false);
    let _ = terminal::disable_raw_mode();
}

/// Standard output without the buffer and the lock of the standard library, which a stalled terminal would hold.
fn output() -> Box<dyn Write + Send> {
    #[cfg(unix)]
    {
        use std::fs::File;
        use std::os::fd::AsFd;
        if let Ok(handle) = io::stdout().as_fd().try_clone_to_owned() {
            return Box::new(File::from(handle));
        }
    }
    Box::new(io::stdout())
}

/// Time for one byte at the terminal's speed if the speed is low (`stty 2400`); otherwise zero.
#[cfg(unix)]
fn byte_time() -> Duration {
    let settings = rustix::termios::tcgetattr(io::stdout());
    match settings.map_or(0, |settings| settings.output_speed()) {
        baud @ 1..=BELIEVED_BAUD_MAX => Duration::from_secs(1) * BITS_PER_BYTE / baud,
        _ => Duration::ZERO,
    }
}

/// Whether standard output is a serial line too slow for pictures. A pseudo-terminal is not, whatever speed it reports.
#[cfg(unix)]
#[must_use]
pub fn is_slow_line() -> bool {
    let name = rustix::termios::ttyname(io::stdout(), Vec::new());
    let is_pseudo = name.is_ok_and(|name| {
        let name = name.to_string_lossy();
        // `/dev/ttys001` is a pseudo-terminal of macOS, `/dev/ttyS1` a serial line.
        name.starts_with("/dev/pts/") || name.starts_with("/dev/ttys")
    });
    let settings = rustix::termios::tcgetattr(io::stdout());
    !is_pseudo && settings.map_or(0, |settings| settings.output_speed()) < PICTURES_BAUD_MIN
}

/// Whether standard output is a serial line too slow for pictures.
#[cfg(not(unix))]
#[must_use]
pub const fn is_slow_line() -> bool {
    false
}

#[cfg(not(unix))]
const fn byte_time() -> Duration {
    Duration::ZERO
}

fn restore_on_panic() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let report = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            leave();
            report(info);
        }));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_of_any_size_needs_bounded_memory() {
        assert_eq!(area(80, 24), Rect::new(0, 0, 80, 24));
        let largest = Buffer::empty(area(u16::MAX, u16::MAX));
        assert_eq!(largest.content.len(), 640 * 320);
    }
}
