//! A program on a pseudo-terminal, and its screen.

use std::env;
use std::fs;
use std::io::{Read, Write};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use etcetera::BaseStrategy as _;
use portable_pty::{Child, CommandBuilder, MasterPty, PtySize, native_pty_system};

/// Timeout of a test that hangs.
pub const PATIENCE: Duration = Duration::from_secs(30);

pub struct OnTerminal {
    screen: vt100::Parser<Clipboard>,
    output: Receiver<Vec<u8>>,
    reader: JoinHandle<()>,
    /// Whether the reader stops reading.
    blind: Arc<AtomicBool>,
    stall: Arc<Stall>,
    /// All bytes processed.
    pub raw: Vec<u8>,
    keys: Box<dyn Write + Send>,
    pub child: Program,
    master: Box<dyn MasterPty + Send>,
}

impl OnTerminal {
    pub fn start(program: &str, arguments: &[&str], columns: u16, rows: u16) -> Self {
        let size = PtySize {
            rows,
            cols: columns,
            pixel_width: 0,
            pixel_height: 0,
        };
        let pair = native_pty_system()
            .openpty(size)
            .expect("a pseudo-terminal");
        let mut command = CommandBuilder::new(program);
        command.args(arguments);
        command.cwd(env!("CARGO_MANIFEST_DIR"));
        command.env("TERM", "xterm-256color");
        command.env("LC_ALL", "C.UTF-8");
        command.env_remove("NO_COLOR");
        let state = toured();
        if env::var_os("XDG_RUNTIME_DIR").is_none() {
            // Tokens of shared links stay where processes without a terminal look for them.
            let strategy = etcetera::choose_base_strategy().expect("a home folder");
            let folder = strategy.state_dir().expect("a state folder");
            command.env("XDG_RUNTIME_DIR", folder);
        }
        command.env("XDG_STATE_HOME", state);
        let child = pair.slave.spawn_command(command).expect("the program");
        drop(pair.slave);
        let mut reader = pair.master.try_clone_reader().expect("its output");
        let (sender, output) = channel();
        let blind = Arc::new(AtomicBool::new(false));
        let is_blind = Arc::clone(&blind);
        let stall = Arc::new(Stall::default());
        let is_stalled = Arc::clone(&stall);
        let reader = thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(count @ 1..) = reader.read(&mut buffer) {
                if sender.send(buffer[..count].to_vec()).is_err() || is_blind.load(Ordering::SeqCst)
                {
                    break;
                }
                is_stalled.wait();
            }
        });
        Self {
            screen: vt100::Parser::new_with_callbacks(
                nonzero(rows),
                nonzero(columns),
                0,
                Clipboard::default(),
            ),
            output,
            reader,
            blind,
            stall,
            raw: Vec::new(),
            keys: pair.master.take_writer().expect("its input"),
            child: Program(child),
            master: pair.master,
        }
    }

    pub fn type_keys(&mut self, keys: &str) {
        self.keys
            .write_all(keys.as_bytes())
            .expect("the terminal takes keys");
        self.keys.flush().expect("the terminal takes keys");
    }

    pub fn resize(&mut self, columns: u16, rows: u16) {
        let size = PtySize {
            rows,
            cols: columns,
            pixel_width: 0,
            pixel_height: 0,
        };
        self.master.resize(size).expect("a new size");
        self.screen
            .screen_mut()
            .set_size(nonzero(rows), nonzero(columns));
    }

    /// Stops reading from the program, like a stalled ssh; a read in progress is finished.
    pub fn stall(&self) {
        self.stall.set(true);
    }

    pub fn go_on(&self) {
        self.stall.set(false);
    }

    /// The screen as text.
    pub fn text(&self) -> String {
        self.screen.screen().contents()
    }

    /// The text on the terminal's clipboard.
    pub fn copied(&self) -> String {
        let bytes = BASE64_STANDARD.decode(&self.screen.callbacks().0);
        String::from_utf8(bytes.expect("Base64")).expect("UTF-8")
    }

    /// The picture that a terminal with the kitty graphics protocol shows, if any.
    pub fn picture(&self) -> Option<Picture> {
        let raw = String::from_utf8_lossy(&self.raw);
        let (mut picture, mut arriving, mut data) = (None, None, String::new());
        let mut parts = raw.split("\x1b_G");
        let mut before = parts.next()?;
        for part in parts {
            // The last sequence may be unfinished.
            let Some((sequence, after)) = part.split_once("\x1b\\") else {
                break;
            };
            let (control, chunk) = sequence.split_once(';').unwrap_or((sequence, ""));
            if control.contains("a=d") {
                picture = None;
            } else if control.contains("a=T") {
                data.clear();
                arriving = Some(Picture::begin(before, control));
            }
            data.push_str(chunk);
            if let Some(mut whole) = arriving.take_if(|_| control.ends_with("m=0")) {
                whole.decode(&data);
                picture = Some(whole);
            }
            before = after;
        }
        picture
    }

    pub fn is_alternate(&self) -> bool {
        self.screen.screen().alternate_screen()
    }

    /// Waits until the screen matches.
    pub fn wait_for(&mut self, what: &str, mut shown: impl FnMut(&str) -> bool) {
        self.wait_for_terminal(what, |screen| shown(&screen.contents()));
    }

    /// Waits until the bytes of the program match.
    pub fn wait_for_raw(&mut self, what: &str, mut reached: impl FnMut(&Self) -> bool) {
        let deadline = Instant::now() + PATIENCE;
        while !reached(self) {
            let left = deadline.saturating_duration_since(Instant::now());
            let Ok(bytes) = self.output.recv_timeout(left) else {
                panic!("never saw: {what}. The screen:\n{}", self.text());
            };
            self.process(&bytes);
        }
    }

    /// Waits until the terminal matches.
    pub fn wait_for_terminal(
        &mut self,
        what: &str,
        mut reached: impl FnMut(&vt100::Screen) -> bool,
    ) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if reached(self.screen.screen()) {
                return;
            }
            let left = deadline.saturating_duration_since(Instant::now());
            let Ok(bytes) = self.output.recv_timeout(left) else {
                panic!("never saw: {what}. The screen:\n{}", self.text());
            };
            self.process(&bytes);
        }
    }

    fn process(&mut self, bytes: &[u8]) {
        self.raw.extend_from_slice(bytes);
        self.screen.process(bytes);
    }

    /// Waits until the program is stopped; continuing it earlier would have no effect.
    pub fn wait_until_stopped(&self) {
        let pid = self.child.process_id().expect("it runs").to_string();
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            let told = Command::new("ps")
                .args(["-o", "state=", "-p", &pid])
                .output()
                .expect("the system tells of its processes");
            if told.stdout.trim_ascii().starts_with(b"T") {
                return;
            }
        }
        panic!("it was never stopped");
    }

    /// Closes the terminal like a closed window: no descriptor of our side stays open. Returns the exit code. The
    /// program must be drawing, because its output wakes the reader, which then closes its descriptor.
    pub fn close(self) -> u32 {
        let Self {
            blind,
            keys,
            master,
            reader,
            mut child,
            ..
        } = self;
        blind.store(true, Ordering::SeqCst);
        drop(keys);
        drop(master);
        reader.join().expect("the reader lets go");
        child.exit_code()
    }

    /// Waits for the program to end; returns its exit code.
    pub fn wait(&mut self) -> u32 {
        let deadline = Instant::now() + PATIENCE;
        // The output ends with the program.
        while let Ok(bytes) = self
            .output
            .recv_timeout(deadline.saturating_duration_since(Instant::now()))
        {
            self.process(&bytes);
        }
        self.wait_stalled()
    }

    /// Waits for the program to end while its output is not read; returns its exit code.
    pub fn wait_stalled(&mut self) -> u32 {
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            if let Some(status) = self.child.0.try_wait().expect("it can be waited for") {
                return status.exit_code();
            }
            thread::yield_now();
        }
        panic!("it never ended. The screen:\n{}", self.text());
    }
}

/// A picture of the kitty graphics protocol.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Row and column of its top left cell, counted from 1.
    pub place: (u16, u16),
    /// Number of columns and rows that it covers.
    pub cells: (u32, u32),
    /// Width and height in pixels.
    pub size: (u32, u32),
    pub palette: Vec<u8>,
    /// Index in the palette of each pixel; 0 is transparent.
    pub pixels: Vec<u8>,
}

impl Picture {
    /// A picture without pixels, with the place to which the terminal moved the cursor before it.
    fn begin(before: &str, control: &str) -> Self {
        let number = |text: &str| text.parse().expect("a number");
        let (_, place) = before.rsplit_once("\x1b[").expect("a place");
        let (row, column) = place.split_once(';').expect("a row and a column");
        let value = |key: &str| {
            let found = control.split(',').find_map(|part| part.strip_prefix(key));
            u32::from(number(found.expect("a size")))
        };
        Self {
            place: (number(row), number(column.trim_end_matches('H'))),
            cells: (value("c="), value("r=")),
            ..Self::default()
        }
    }

    fn decode(&mut self, data: &str) {
        let png = BASE64_STANDARD.decode(data).expect("Base64");
        let decoder = png::Decoder::new(std::io::Cursor::new(png));
        let mut reader = decoder.read_info().expect("a PNG");
        let mut packed = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut packed).expect("pixels");
        let info = reader.info();
        self.size = (info.width, info.height);
        self.palette = info.palette.as_deref().expect("a palette").to_vec();
        self.pixels = packed
            .iter()
            .flat_map(|byte| [byte >> 4, byte & 0xF])
            .collect();
    }
}

/// The program's text for the clipboard, as sent.
#[derive(Default)]
struct Clipboard(Vec<u8>);

impl vt100::Callbacks for Clipboard {
    fn copy_to_clipboard(&mut self, _: &mut vt100::Screen, _: &[u8], data: &[u8]) {
        self.0 = data.to_vec();
    }
}

/// A state folder of an operator who has seen the tour.
fn toured() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("toured");
    fs::create_dir_all(folder.join("groundwave")).expect("a folder");
    fs::write(folder.join("groundwave/tour-ended"), "").expect("a file");
    folder
}

/// Blocks the reader while the terminal is stalled.
#[derive(Default)]
struct Stall {
    is_on: Mutex<bool>,
    changed: Condvar,
}

impl Stall {
    fn set(&self, is_on: bool) {
        *self.is_on.lock().expect("no reader panics") = is_on;
        self.changed.notify_all();
    }

    fn wait(&self) {
        let is_on = self.is_on.lock().expect("no test panics here");
        let _is_off = self.changed.wait_while(is_on, |is_on| *is_on);
    }
}

fn nonzero(cells: u16) -> NonZero<u16> {
    NonZero::new(cells).expect("a terminal has cells")
}

/// A running program, killed when dropped.
pub struct Program(Box<dyn Child + Send + Sync>);

impl Program {
    pub fn process_id(&self) -> Option<u32> {
        self.0.process_id()
    }

    fn exit_code(&mut self) -> u32 {
        self.0.wait().expect("an exit code").exit_code()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // The program has usually ended already.
        let _ = self.0.kill();
    }
}
