//! The terminal: taken over for the dashboard, and given back whatever happens.

mod burst;
mod outlet;
mod sheet;

use std::io::{self, IsTerminal};
use std::panic;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crossterm::event::{
    DisableBracketedPaste, EnableBracketedPaste, Event, KeyboardEnhancementFlags,
    PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
};
use crossterm::style::ResetColor;
use crossterm::{cursor, queue, terminal};
use ratatui::buffer::Buffer;
use tokio::sync::mpsc::Receiver;

use self::outlet::Outlet;
use self::sheet::Sheet;
use super::mouse::{DisableClicks, EnableClicks};

/// Whether the terminal is ours now: what a panic has to undo.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Whether the mouse is asked for whenever the terminal is taken over.
static MOUSE: AtomicBool = AtomicBool::new(false);

/// How long a terminal that takes nothing is waited for when it is given back.
const PATIENCE: Duration = Duration::from_secs(1);

/// Keys of one burst follow each other within this; nobody types so fast.
const BURST: Duration = Duration::from_millis(25);

const BELL: &[u8] = b"\x07";

/// Whether there is a terminal to draw on; a window that was closed is none.
#[must_use]
pub fn is_there() -> bool {
    io::stdout().is_terminal()
}

/// The terminal while the dashboard runs. Dropping it gives the terminal back.
pub struct Screen {
    sheet: Sheet,
    outlet: Outlet,
}

impl Screen {
    /// Takes the terminal over. Nothing is asked of it: a terminal that does not answer would cost
    /// seconds.
    ///
    /// # Errors
    /// When standard output is no terminal or refuses.
    pub fn take() -> io::Result<Self> {
        restore_on_panic();
        let outlet = enter()?;
        let (width, height) = terminal::size()?;
        Ok(Self {
            sheet: Sheet::new(width, height),
            outlet,
        })
    }

    /// Asks for clicks and the wheel, from now on and after every suspension.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn use_mouse(&mut self) -> io::Result<()> {
        MOUSE.store(true, Ordering::SeqCst);
        let mut words = Vec::new();
        queue!(words, EnableClicks)?;
        self.outlet.put(Instant::now(), &words)
    }

    /// Rings the terminal's bell; nothing on the screen changes. One that waits to be rung is not rung twice.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn ring(&mut self) -> io::Result<()> {
        if self.outlet.ends_with(BELL) {
            return Ok(());
        }
        self.outlet.put(Instant::now(), BELL)
    }

    /// Columns and rows.
    #[must_use]
    pub const fn size(&self) -> (u16, u16) {
        self.sheet.size()
    }

    /// Takes a new size: the next frame is drawn whole.
    pub fn resize(&mut self, width: u16, height: u16) {
        self.sheet = Sheet::new(width, height);
    }

    /// Whether the terminal has room for a frame: it has taken the last one. Sends it what it has not taken so far.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn has_room(&mut self) -> io::Result<bool> {
        self.outlet.push()?;
        Ok(self.busy_until().is_none())
    }

    /// When to look for room again; `None` when there is some.
    #[must_use]
    pub fn busy_until(&self) -> Option<Instant> {
        self.outlet.busy_until(Instant::now())
    }

    /// Draws one frame; only what changed goes to the terminal. What it does not take at once waits; nothing else does.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn draw(&mut self, draw: impl FnOnce(&mut Buffer)) -> io::Result<()> {
        let frame = self.sheet.draw(draw);
        self.outlet.put(Instant::now(), &frame)
    }

    /// Forgets what is on the screen: the next frame is drawn whole.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn clear(&mut self) -> io::Result<()> {
        let (width, height) = terminal::size()?;
        self.resize(width, height);
        Ok(())
    }

    /// Gives the terminal back, runs `meanwhile`, takes it over again and draws everything anew.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn suspend(&mut self, meanwhile: impl FnOnce()) -> io::Result<()> {
        leave();
        meanwhile();
        self.outlet = enter()?;
        self.clear()
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        leave();
    }
}

fn enter() -> io::Result<Outlet> {
    TAKEN.store(true, Ordering::SeqCst);
    terminal::enable_raw_mode()?;
    let mut words = Vec::new();
    queue!(
        words,
        terminal::EnterAlternateScreen,
        // What a terminal draws wider than we know ends at its margin.
        terminal::DisableLineWrap,
        EnableBracketedPaste,
        PushKeyboardEnhancementFlags(
            KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES
                | KeyboardEnhancementFlags::REPORT_EVENT_TYPES
        ),
        cursor::Hide
    )?;
    if MOUSE.load(Ordering::SeqCst) {
        queue!(words, EnableClicks)?;
    }
    let mut outlet = Outlet::open();
    outlet.put(Instant::now(), &words)?;
    Ok(outlet)
}

fn leave() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        // Each step is tried whatever became of the one before: a closed terminal takes none.
        let mut words = Vec::new();
        let _ = queue!(
            words,
            ResetColor,
            DisableClicks,
            PopKeyboardEnhancementFlags,
            DisableBracketedPaste,
            terminal::EnableLineWrap,
            terminal::LeaveAlternateScreen,
            cursor::Show
        );
        // A frame that is half taken does not matter: an escape ends what was begun.
        let mut outlet = Outlet::open();
        let put = outlet.put(Instant::now(), &words);
        let _ = put.and_then(|()| outlet.finish(PATIENCE));
        let _ = terminal::disable_raw_mode();
    }
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

/// Keys, pastes and sizes, read on a thread of their own.
#[must_use]
pub fn events() -> Receiver<Event> {
    let (sender, receiver) = tokio::sync::mpsc::channel(64);
    thread::spawn(move || {
        while let Ok(event) = crossterm::event::read() {
            let is_escape = burst::is_escape(&event);
            if sender.blocking_send(event).is_err() {
                return;
            }
            if !is_escape {
                continue;
            }
            let Ok(events) = burst::after_escape(next_in_burst) else {
                return;
            };
            for event in events {
                if sender.blocking_send(event).is_err() {
                    return;
                }
            }
        }
    });
    receiver
}

fn next_in_burst() -> io::Result<Option<Event>> {
    if crossterm::event::poll(BURST)? {
        crossterm::event::read().map(Some)
    } else {
        Ok(None)
    }
}
