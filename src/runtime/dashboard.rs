//! The dashboard's event loop.

use std::io;
use std::thread;
use std::time::{Duration, Instant};

use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio::time::{Instant as TokioInstant, sleep_until};

use super::Driver;
use crate::event::{Effect, Event, Moment, Recording, Replay};
use crate::io::files;
use crate::io::signals::{Signal, Signals, stop_myself};
use crate::io::terminal::{self, Screen};
use crate::model::Model;
use crate::route;
use crate::view;

/// No two frames come closer than this: a burst of bytes is drawn once.
const FRAME_PERIOD: Duration = Duration::from_millis(40);

/// How often it is asked what has been recorded.
const RECORDING_PERIOD: Duration = Duration::from_secs(1);

/// Terminal events taken at one go.
const BATCH: usize = 32;

/// Pauses a replay or changes its speed.
pub trait Player {
    /// Pauses or goes on; says how it plays now.
    fn pause(&mut self, paused: bool) -> Replay;
    /// Plays at a multiple of the recorded speed; says how it plays now.
    fn speed(&mut self, factor: f64) -> Replay;
}

/// Everything a dashboard joins together.
pub struct Dashboard {
    /// The station on its link.
    pub driver: Driver,
    /// What the screen knows.
    pub model: Model,
    /// The replay, if this is one.
    pub player: Option<Box<dyn Player>>,
    /// Says what has been recorded.
    pub recording: Box<dyn FnMut() -> Recording>,
    /// Events to begin with.
    pub first: Vec<Event>,
}

/// Runs until the operator leaves, a signal says so or the terminal is gone.
///
/// # Errors
/// When the terminal cannot be taken over or drawn to.
pub async fn run(dashboard: Dashboard) -> io::Result<()> {
    let mut signals = Signals::listen()?;
    let screen = Screen::take()?;
    let mut keys = terminal::events();
    let (readers, mut read) = channel(4);
    let mut running = Running {
        driver: dashboard.driver,
        model: dashboard.model,
        player: dashboard.player,
        screen,
        readers,
        drawn: None,
    };
    let mut recording = dashboard.recording;
    let mut told = Recording::default();
    let (width, height) = running.screen.size();
    let mut leave = running.tell(Event::Resize { width, height })?;
    for event in dashboard.first {
        leave |= running.tell(event)?;
    }
    let mut ask_at = Instant::now();
    while !leave {
        if Instant::now() >= ask_at {
            ask_at = Instant::now() + RECORDING_PERIOD;
            let now = recording();
            if now != told {
                told = now.clone();
                leave |= running.tell(Event::Recording(now))?;
            }
        }
        leave |= running.tell_all()?;
        running.draw_if_due()?;
        let wake_at = running.wake_at();
        leave |= tokio::select! {
            biased;
            signal = signals.next() => match signal {
                Signal::Leave => true,
                Signal::Suspend => {
                    running.suspend()?;
                    false
                }
            },
            event = keys.recv() => match event {
                Some(event) => running.take_keys(event, &mut keys)?,
                // The terminal is gone: nobody can see or steer any more.
                None => true,
            },
            Some(event) = read.recv() => running.tell(event)?,
            () = running.driver.step() => false,
            () = sleep_until_some(wake_at) => running.tell(Event::Tick)?,
            () = sleep_until(TokioInstant::from_std(ask_at)), if told != Recording::default() => false,
        };
    }
    Ok(())
}

struct Running {
    driver: Driver,
    model: Model,
    player: Option<Box<dyn Player>>,
    screen: Screen,
    /// For threads that read files: what they found comes back as an event.
    readers: Sender<Event>,
    drawn: Option<Drawn>,
}

/// The frame that is on the screen.
struct Drawn {
    at: Moment,
    revision: u64,
    /// When ages on it will be wrong.
    stale_at: Option<Moment>,
}

impl Running {
    /// Tells the model of an event and does what it asks for; says whether to leave.
    fn tell(&mut self, event: Event) -> io::Result<bool> {
        let effects = self.model.update(self.driver.now(), event);
        let mut leave = false;
        for effect in effects {
            leave |= self.act(effect)?;
        }
        Ok(leave)
    }

    fn tell_all(&mut self) -> io::Result<bool> {
        let mut leave = false;
        while let Some(event) = self.driver.poll_event() {
            leave |= self.tell(event)?;
        }
        Ok(leave)
    }

    fn take_keys(
        &mut self,
        first: crossterm::event::Event,
        keys: &mut Receiver<crossterm::event::Event>,
    ) -> io::Result<bool> {
        let mut leave = self.take_key(first)?;
        for _ in 1..BATCH {
            match keys.try_recv() {
                Ok(event) => leave |= self.take_key(event)?,
                Err(_) => break,
            }
        }
        Ok(leave)
    }

    fn take_key(&mut self, event: crossterm::event::Event) -> io::Result<bool> {
        use crossterm::event::Event as Terminal;
        match event {
            Terminal::Key(key) => self.tell(Event::Key(key)),
            Terminal::Paste(text) => self.tell(Event::Paste(text)),
            Terminal::Resize(width, height) => {
                self.screen.resize(width, height)?;
                self.tell(Event::Resize { width, height })
            }
            Terminal::FocusGained | Terminal::FocusLost | Terminal::Mouse(_) => Ok(false),
        }
    }

    fn act(&mut self, effect: Effect) -> io::Result<bool> {
        match effect {
            Effect::Send(request) => {
                self.driver.request(request);
            }
            Effect::Drive {
                velocity_in_s,
                rotation_in_s,
            } => self.driver.drive(velocity_in_s, rotation_in_s),
            Effect::DriveEnd => self.driver.drive_end(),
            Effect::CancelCommands => self.driver.cancel(),
            Effect::LoadRoute(path) => self.load_route(path),
            Effect::SaveRoute {
                path,
                text,
                overwrite,
            } => self.save_route(path, text, overwrite),
            Effect::ReplayPause(paused) => {
                if let Some(replay) = self.player.as_mut().map(|player| player.pause(paused)) {
                    return self.tell(Event::Replay(replay));
                }
            }
            Effect::ReplaySpeed(factor) => {
                if let Some(replay) = self.player.as_mut().map(|player| player.speed(factor)) {
                    return self.tell(Event::Replay(replay));
                }
            }
            Effect::Ring => terminal::ring()?,
            Effect::Redraw => self.screen.clear()?,
            Effect::Suspend => self.suspend()?,
            Effect::Quit => return Ok(true),
        }
        Ok(false)
    }

    /// On a thread of its own: a disk may take its time, and STOP may not wait for it.
    fn load_route(&self, path: String) {
        let readers = self.readers.clone();
        thread::spawn(move || {
            let route = files::read_text(&path)
                .and_then(|text| route::parse(&path, &text).map_err(|error| error.to_string()));
            // A dashboard that is gone wants no route.
            let _ = readers.blocking_send(Event::RouteLoaded { path, route });
        });
    }

    /// As [`Self::load_route`].
    fn save_route(&self, path: String, text: String, overwrite: bool) {
        let readers = self.readers.clone();
        thread::spawn(move || {
            let saved = files::write_text(&path, &text, overwrite);
            // A dashboard that is gone has left the file behind, as it was asked to.
            let _ = readers.blocking_send(Event::RouteSaved { path, saved });
        });
    }

    fn suspend(&mut self) -> io::Result<()> {
        self.screen.suspend(stop_myself)?;
        let (width, height) = self.screen.size();
        self.tell(Event::Resize { width, height })?;
        Ok(())
    }

    /// When the screen has to be drawn again, if nothing else happens.
    fn due(&self) -> Option<Moment> {
        let Some(drawn) = &self.drawn else {
            return Some(Moment::ZERO);
        };
        let earliest = drawn.at + FRAME_PERIOD;
        if self.model.revision() == drawn.revision {
            drawn.stale_at.map(|at| at.max(earliest))
        } else {
            Some(earliest)
        }
    }

    /// When to wake up although nothing happens.
    fn wake_at(&self) -> Option<Instant> {
        let at = [self.due(), self.model.poll_timeout()]
            .into_iter()
            .flatten()
            .min()?;
        Some(Instant::now() + at.saturating_sub(self.driver.now()))
    }

    fn draw_if_due(&mut self) -> io::Result<()> {
        let now = self.driver.now();
        if self.due().is_some_and(|at| at <= now) {
            let model = &self.model;
            self.screen.draw(|frame| view::draw(model, now, frame))?;
            self.drawn = Some(Drawn {
                at: now,
                revision: model.revision(),
                stale_at: model.redraw_at(now),
            });
        }
        Ok(())
    }
}

async fn sleep_until_some(at: Option<Instant>) {
    match at {
        Some(at) => sleep_until(TokioInstant::from_std(at)).await,
        None => std::future::pending().await,
    }
}
