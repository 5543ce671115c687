//! The terminal: taken over for the dashboard, and given back whatever happens.

use std::cell::RefCell;
use std::io::{self, IsTerminal, Write};
use std::panic;
use std::rc::Rc;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crossterm::event::{
    DisableBracketedPaste, EnableBracketedPaste, Event, KeyboardEnhancementFlags,
    PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
};
use crossterm::{cursor, execute, terminal};
use ratatui::backend::CrosstermBackend;
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};
use tokio::sync::mpsc::Receiver;

use super::mouse::{DisableClicks, EnableClicks};

/// Whether the terminal is ours now: what a panic has to undo.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Whether the mouse is asked for whenever the terminal is taken over.
static MOUSE: AtomicBool = AtomicBool::new(false);

type Canvas = Terminal<CrosstermBackend<Sheet>>;

/// A frame in memory, on its way to the terminal. A canvas that wrote to the terminal itself would show
/// the cursor when it is dropped, and panic when neither the terminal nor standard error is left.
#[derive(Clone, Default)]
struct Sheet(Rc<RefCell<Vec<u8>>>);

impl Write for Sheet {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Sheet {
    /// One frame, one write.
    fn print(&self) -> io::Result<()> {
        let mut frame = self.0.borrow_mut();
        let mut out = io::stdout().lock();
        let printed = out.write_all(&frame).and_then(|()| out.flush());
        frame.clear();
        printed
    }
}

/// Whether there is a terminal to draw on; a window that was closed is none.
#[must_use]
pub fn is_there() -> bool {
    io::stdout().is_terminal()
}

/// Rings the terminal's bell; nothing on the screen changes.
///
/// # Errors
/// When the terminal is gone.
pub fn ring() -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(b"\x07").and_then(|()| out.flush())
}

/// The terminal while the dashboard runs. Dropping it gives the terminal back.
pub struct Screen {
    canvas: Canvas,
    sheet: Sheet,
}

impl Screen {
    /// Takes the terminal over. Nothing is asked of it: a terminal that does not answer would cost
    /// seconds.
    ///
    /// # Errors
    /// When standard output is no terminal or refuses.
    pub fn take() -> io::Result<Self> {
        restore_on_panic();
        enter()?;
        let (width, height) = terminal::size()?;
        let sheet = Sheet::default();
        Ok(Self {
            canvas: canvas(&sheet, width, height)?,
            sheet,
        })
    }

    /// Asks for clicks and the wheel, from now on and after every suspension.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn use_mouse(&mut self) -> io::Result<()> {
        MOUSE.store(true, Ordering::SeqCst);
        execute!(io::stdout(), EnableClicks)
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&mut self) -> (u16, u16) {
        let area = self.canvas.get_frame().area();
        (area.width, area.height)
    }

    /// Takes a new size: the next frame is drawn whole.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn resize(&mut self, width: u16, height: u16) -> io::Result<()> {
        execute!(io::stdout(), terminal::Clear(terminal::ClearType::All))?;
        // A sheet of its own: the old canvas writes its farewell on the old one.
        self.sheet = Sheet::default();
        self.canvas = canvas(&self.sheet, width, height)?;
        Ok(())
    }

    /// Draws one frame; only what changed goes to the terminal.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn draw(&mut self, draw: impl FnOnce(&mut ratatui::Frame<'_>)) -> io::Result<()> {
        self.canvas.draw(draw)?;
        self.sheet.print()
    }

    /// Forgets what is on the screen: the next frame is drawn whole.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn clear(&mut self) -> io::Result<()> {
        let (width, height) = terminal::size()?;
        self.resize(width, height)
    }

    /// Gives the terminal back, runs `meanwhile`, takes it over again and draws everything anew.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn suspend(&mut self, meanwhile: impl FnOnce()) -> io::Result<()> {
        leave();
        meanwhile();
        enter()?;
        self.clear()
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        leave();
    }
}

/// A canvas that remembers nothing and asks the terminal nothing: its size comes with the resize event,
/// and `Terminal::clear` would ask where the cursor is and wait for an answer that our own reader takes
/// away.
fn canvas(sheet: &Sheet, width: u16, height: u16) -> io::Result<Canvas> {
    let backend = CrosstermBackend::new(sheet.clone());
    let viewport = Viewport::Fixed(Rect::new(0, 0, width, height));
    Terminal::with_options(backend, TerminalOptions { viewport })
}

fn enter() -> io::Result<()> {
    TAKEN.store(true, Ordering::SeqCst);
    terminal::enable_raw_mode()?;
    execute!(
        io::stdout(),
        terminal::EnterAlternateScreen,
        EnableBracketedPaste,
        PushKeyboardEnhancementFlags(
            KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES
                | KeyboardEnhancementFlags::REPORT_EVENT_TYPES
        ),
        cursor::Hide
    )?;
    if MOUSE.load(Ordering::SeqCst) {
        execute!(io::stdout(), EnableClicks)?;
    }
    Ok(())
}

fn leave() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        // Each step is tried whatever became of the one before: a closed terminal takes none.
        let _ = execute!(
            io::stdout(),
            DisableClicks,
            PopKeyboardEnhancementFlags,
            DisableBracketedPaste,
            terminal::LeaveAlternateScreen,
            cursor::Show
        );
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
            if sender.blocking_send(event).is_err() {
                return;
            }
        }
    });
    receiver
}
