//! The drawing thread: the only writer to the terminal. It takes the newest frame, so a stalled terminal delays only drawing.

use std::io::{self, ErrorKind, Write};
use std::mem;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::{self, ThreadId};
use std::time::Duration;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use ratatui::backend::CrosstermBackend;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};

use super::After;

const BELL: &[u8] = b"\x07";

/// Pause before another write to a terminal that another program made non-blocking.
const RETRY: Duration = Duration::from_millis(20);

/// A terminal for the drawing thread.
pub(super) struct Device {
    pub(super) output: Box<dyn Write + Send>,
    /// Time for one byte on a slow serial line; zero elsewhere.
    pub(super) byte_time: Duration,
    pub(super) size: Rect,
    /// Sequences that set the terminal up, and that restore it.
    pub(super) enter: Vec<u8>,
    pub(super) leave: Vec<u8>,
}

/// A handle to the drawing thread.
#[derive(Clone)]
pub(super) struct Drawing(Arc<Shared>);

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
    thread: OnceLock<ThreadId>,
}

/// A drawn page, and bytes to write after it.
struct Frame {
    page: Buffer,
    after: Option<After>,
}

#[derive(Default)]
struct State {
    /// The newest frame, if the thread has not taken it.
    frame: Option<Frame>,
    /// A blank page for drawing the next frame.
    spare: Option<Buffer>,
    is_redraw: bool,
    rings: bool,
    /// The sequence that puts the newest text on the clipboard.
    copied: Vec<u8>,
    stage: Stage,
    /// The thread's result, once it has restored the terminal or failed.
    result: Option<io::Result<()>>,
}

#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Stage {
    #[default]
    Drawing,
    /// The thread restores the terminal as soon as it can.
    Ending,
    /// The terminal did not take the last bytes in time; the thread writes no more.
    Abandoned,
}

impl Drawing {
    /// Starts the thread, which first sets up the terminal.
    ///
    /// # Errors
    /// If no thread can be started.
    pub(super) fn start(device: Device) -> io::Result<Self> {
        let shared = Arc::<Shared>::default();
        let drawing = Self(Arc::clone(&shared));
        let work = move || {
            // The thread is new, so this is set once.
            let _ = shared.thread.set(thread::current().id());
            let result = run(&shared, device);
            shared.lock().result = Some(result);
            shared.changed.notify_all();
        };
        thread::Builder::new().name("drawing".into()).spawn(work)?;
        Ok(drawing)
    }

    /// Whether the caller is the drawing thread itself.
    pub(super) fn is_current(&self) -> bool {
        self.0.thread.get() == Some(&thread::current().id())
    }

    /// Passes a frame to the thread; replaces a waiting frame.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub(super) fn draw(
        &self,
        size: Rect,
        draw: impl FnOnce(&mut Buffer) -> Option<After>,
    ) -> io::Result<()> {
        let spare = self.0.lock().spare.take();
        let spare = spare.filter(|page| page.area == size);
        let mut page = spare.unwrap_or_else(|| Buffer::empty(size));
        let after = draw(&mut page);
        self.order(|state| {
            if let Some(mut unseen) = state.frame.replace(Frame { page, after }) {
                unseen.page.reset();
                state.spare = Some(unseen.page);
            }
        })
    }

    /// Makes the thread write the next frame completely.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub(super) fn redraw(&self) -> io::Result<()> {
        self.order(|state| state.is_redraw = true)
    }

    /// Rings the bell.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub(super) fn ring(&self) -> io::Result<()> {
        self.order(|state| state.rings = true)
    }

    /// Puts a text on the clipboard; replaces a waiting text.
    ///
    /// # Errors
    /// If the terminal is closed.
    pub(super) fn copy(&self, text: &str) -> io::Result<()> {
        let sequence = format!("\x1b]52;c;{}\x1b\\", BASE64_STANDARD.encode(text));
        self.order(|state| state.copied = sequence.into_bytes())
    }

    fn order(&self, change: impl FnOnce(&mut State)) -> io::Result<()> {
        let mut state = self.0.lock();
        match state.result.take() {
            Some(Err(error)) => return Err(error),
            Some(Ok(())) => return Err(ErrorKind::BrokenPipe.into()),
            None => change(&mut state),
        }
        drop(state);
        self.0.changed.notify_all();
        Ok(())
    }

    /// Ends the thread. The thread restores the terminal if that takes at most `patience`.
    pub(super) fn end(&self, patience: Duration) {
        let mut state = self.0.lock();
        state.stage = Stage::Ending;
        self.0.changed.notify_all();
        let has_work = |state: &mut State| state.result.is_none();
        let waited = self.0.changed.wait_timeout_while(state, patience, has_work);
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        state.stage = Stage::Abandoned;
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for work; returns the newest frame, whether to write it completely, and bytes to write before it: bell and
    /// clipboard. `None` at the end.
    fn next(&self) -> Option<(Option<Frame>, bool, Vec<u8>)> {
        let is_idle = |state: &mut State| {
            state.stage == Stage::Drawing
                && state.frame.is_none()
                && !state.rings
                && state.copied.is_empty()
        };
        let waited = self.changed.wait_while(self.lock(), is_idle);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        if state.stage != Stage::Drawing {
            return None;
        }
        let frame = state.frame.take();
        let is_redraw = frame.is_some() && mem::take(&mut state.is_redraw);
        let mut before = mem::take(&mut state.copied);
        if mem::take(&mut state.rings) {
            before.extend(BELL);
        }
        Some((frame, is_redraw, before))
    }

    /// Waits for a slow line; returns early at the end.
    fn rest(&self, duration: Duration) {
        if !duration.is_zero() {
            let goes_on = |state: &mut State| state.stage == Stage::Drawing;
            let _waited = self
                .changed
                .wait_timeout_while(self.lock(), duration, goes_on);
        }
    }
}

/// Body of the thread: sets up the terminal, draws until the end, and restores the terminal.
fn run(shared: &Shared, device: Device) -> io::Result<()> {
    let mut output = Output {
        device: device.output,
        byte_time: device.byte_time,
        shared,
        bytes: device.enter,
    };
    output.flush()?;
    let options = TerminalOptions {
        viewport: Viewport::Fixed(device.size),
    };
    let mut terminal = Terminal::with_options(CrosstermBackend::new(output), options)?;
    let result = draw_frames(shared, &mut terminal, &device.leave);
    if result.is_err() {
        // Dropping the terminal would report the error on standard error, and panic if standard error is closed, too.
        mem::forget(terminal);
    }
    result
}

/// Draws frames until the end, then restores the terminal.
fn draw_frames(
    shared: &Shared,
    terminal: &mut Terminal<CrosstermBackend<Output<'_>>>,
    leave: &[u8],
) -> io::Result<()> {
    while let Some((frame, is_redraw, before)) = shared.next() {
        terminal.backend_mut().write_all(&before)?;
        if let Some(Frame { mut page, after }) = frame {
            if is_redraw || page.area != terminal.get_frame().area() {
                terminal.resize(page.area)?;
            }
            // The thread returns its blank page for the next frame.
            terminal.draw(|frame| mem::swap(frame.buffer_mut(), &mut page))?;
            shared.lock().spare = Some(page);
            if let Some(after) = after {
                terminal.backend_mut().write_all(&after())?;
            }
        }
        Write::flush(terminal.backend_mut())?;
    }
    if shared.lock().stage == Stage::Ending {
        terminal.backend_mut().write_all(leave)?;
        Write::flush(terminal.backend_mut())?;
    }
    Ok(())
}

/// Collects the bytes of a frame, and writes them together.
struct Output<'a> {
    device: Box<dyn Write + Send>,
    byte_time: Duration,
    shared: &'a Shared,
    bytes: Vec<u8>,
}

impl Write for Output<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let bytes = mem::take(&mut self.bytes);
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            match self.device.write(rest) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => rest = &rest[count..],
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => thread::sleep(RETRY),
                Err(error) => return Err(error),
            }
        }
        self.device.flush()?;
        self.shared.rest(self.byte_time * bytes.len() as u32);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use ratatui::style::Style;

    use super::*;

    /// Timeout after which a test counts as hanging.
    const PATIENCE: Duration = Duration::from_secs(20);

    const SIZE: Rect = Rect::new(0, 0, 4, 1);

    /// A terminal that asks the test before each write, and fails without an answer.
    struct Gated {
        asks: Sender<String>,
        permits: Receiver<()>,
    }

    impl Write for Gated {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let _ = self.asks.send(String::from_utf8_lossy(bytes).into_owned());
            let permit = self.permits.recv();
            permit.map_err(|_| io::Error::from(ErrorKind::BrokenPipe))?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// A drawing thread, its requests to write, and the sender of permits.
    fn gated(byte_time: Duration) -> (Drawing, Receiver<String>, Sender<()>) {
        let (asks, asked) = channel();
        let (permit, permits) = channel();
        let device = Device {
            output: Box::new(Gated { asks, permits }),
            byte_time,
            size: SIZE,
            enter: b"<enter>".to_vec(),
            leave: b"<leave>".to_vec(),
        };
        (Drawing::start(device).expect("a thread"), asked, permit)
    }

    fn draw(drawing: &Drawing, text: &str) {
        let written = drawing.draw(SIZE, |page| {
            page.set_string(0, 0, text, Style::new());
            None
        });
        written.expect("a terminal");
    }

    fn next(asked: &Receiver<String>) -> String {
        asked.recv_timeout(PATIENCE).expect("a write")
    }

    #[test]
    fn a_stalled_terminal_gets_the_newest_frame_and_is_restored() {
        let (drawing, asked, permit) = gated(Duration::ZERO);
        assert_eq!(next(&asked), "<enter>");
        permit.send(()).expect("the thread");
        draw(&drawing, "old");
        assert!(next(&asked).contains("old"));
        for text in ["two", "few", "new"] {
            draw(&drawing, text);
            drawing.ring().expect("a terminal");
        }
        permit.send(()).expect("the thread");
        let newest = next(&asked);
        assert!(
            newest.starts_with('\x07') && newest.contains("new"),
            "{newest:?}"
        );
        for _ in 0..9 {
            permit.send(()).expect("the thread");
        }
        drawing.end(PATIENCE);
        let last: String = asked.iter().collect();
        assert!(last.starts_with("<leave>"), "{last:?}");
    }

    #[test]
    fn a_picture_follows_its_page() {
        let (drawing, asked, permit) = gated(Duration::ZERO);
        for _ in 0..9 {
            permit.send(()).expect("the thread");
        }
        let written = drawing.draw(SIZE, |page| {
            page.set_string(0, 0, "page", Style::new());
            Some(Box::new(|| b"<picture>".to_vec()))
        });
        written.expect("a terminal");
        let mut all = String::new();
        while !all.ends_with("<picture>") {
            all += &next(&asked);
        }
        assert!(all.contains("page"), "{all:?}");
    }

    #[test]
    fn a_stalled_terminal_does_not_delay_the_end() {
        let (drawing, asked, permit) = gated(Duration::ZERO);
        assert_eq!(next(&asked), "<enter>");
        drawing.end(Duration::ZERO);
        // The terminal accepts bytes again when another program has it.
        permit.send(()).expect("the thread");
        let last: String = asked.iter().collect();
        assert!(!last.contains("<leave>"), "{last:?}");
    }

    #[test]
    fn a_closed_terminal_is_an_error_of_a_later_frame() {
        let (drawing, asked, permit) = gated(Duration::ZERO);
        drop(permit);
        assert_eq!(asked.iter().count(), 1);
        // The thread has dropped the device; its result follows.
        let deadline = std::time::Instant::now() + PATIENCE;
        while drawing.ring().is_ok() {
            assert!(std::time::Instant::now() < deadline);
            thread::yield_now();
        }
    }

    /// The end comes while the thread waits for a slow line.
    #[test]
    fn the_end_does_not_wait_for_a_slow_line() {
        let (drawing, asked, permit) = gated(PATIENCE);
        assert_eq!(next(&asked), "<enter>");
        for _ in 0..9 {
            permit.send(()).expect("the thread");
        }
        drawing.end(PATIENCE);
        let last: String = asked.iter().collect();
        assert!(last.starts_with("<leave>"), "{last:?}");
    }
}
