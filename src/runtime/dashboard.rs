//! The dashboard's event loop.

use std::io;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use crossterm::event::{MouseButton, MouseEvent, MouseEventKind};
use tokio::sync::mpsc::{Sender, channel};
use tokio::time::{Instant as TokioInstant, sleep_until};

use super::pace::Pace;
use super::runs;
use super::{Driver, Keeper, Source};
use crate::capture::runs::Label;
use crate::event::{
    Effect, Event, FileKind, Gesture, Level, Moment, Notice, NoticeCode, Recording, Remark,
};
use crate::io::files;
use crate::io::signals::{Signal, Signals, stop_myself};
use crate::io::terminal::{self, Screen};
use crate::model::{MapLines, Shown, Ui};
use crate::parameter_file::ParameterFile;
use crate::playback::{Control, MARK_REACH};
use crate::route;
use crate::view;

/// Interval between updates of the recording's figures while lines arrive; these updates cause no extra frame.
const RECORDING_PERIOD: Duration = Duration::from_secs(1);

/// Interval between updates of the recording's figures on a silent link.
const RECORDING_PERIOD_SILENT: Duration = Duration::from_secs(2);

/// Interval between updates of the recording's figures while a recording starts or ends.
const RECORDING_PERIOD_BUSY: Duration = Duration::from_millis(100);

/// Maximum number of terminal events handled before other inputs.
const BATCH: usize = 32;

/// Time of an event of the terminal after which other inputs come first: a jump through a long session takes a while.
const SLOW: Duration = Duration::from_millis(10);

/// The parts of a dashboard.
pub struct Dashboard {
    /// The source of facts.
    pub source: Source,
    /// The operator's view of them.
    pub ui: Ui,
    /// Returns the recording's figures.
    pub recording: Box<dyn FnMut() -> Recording>,
    /// Events to handle first.
    pub first: Vec<Event>,
    /// Starts and ends recordings; `None` in a replay.
    pub keeper: Option<Keeper>,
}

/// Result of a dashboard.
pub struct Left {
    /// The operator's view at the end.
    pub ui: Ui,
    /// Describes what the robot was doing; `None` if no line was received.
    pub robot: Option<String>,
    /// The capture to replay next, if the operator chose one.
    pub replay: Option<String>,
}

/// Runs until the operator leaves, a signal arrives or the terminal is closed.
///
/// # Errors
/// If the terminal cannot be set up or written to.
pub async fn run(dashboard: Dashboard) -> io::Result<Left> {
    let mut signals = Signals::listen()?;
    let screen = Screen::take(dashboard.ui.wants_mouse())?;
    let mut keys = terminal::events()?;
    let (readers, mut read) = channel(4);
    let mut running = Running {
        keeper: dashboard.keeper,
        source: dashboard.source,
        ui: dashboard.ui,
        screen,
        readers,
        drawn: None,
        pace: Pace::default(),
        replay: None,
    };
    let mut recording = dashboard.recording;
    let mut shown = Recording::default();
    running.refresh();
    let (width, height) = running.screen.size();
    let mut leave = running.tell(Event::Resize { width, height })?;
    for event in dashboard.first {
        leave |= running.tell(event)?;
    }
    let mut asked_at: Option<Instant> = None;
    while !leave {
        let is_busy = running.keeper.as_ref().is_some_and(Keeper::is_busy);
        let (period, period_silent) = if is_busy {
            (RECORDING_PERIOD_BUSY, RECORDING_PERIOD_BUSY)
        } else {
            (RECORDING_PERIOD, RECORDING_PERIOD_SILENT)
        };
        if asked_at.is_none_or(|at| at.elapsed() >= period) {
            asked_at = Some(Instant::now());
            let now = recording();
            if now != shown {
                shown = now.clone();
                leave |= running.tell(Event::Recording(now))?;
            }
            leave |= running.tell_notices()?;
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
            event = keys.next() => match event {
                Some(event) => running.take_keys(event, &mut keys)?,
                // The terminal is closed, so there is no operator.
                None => true,
            },
            Some(event) = read.recv() => running.tell(event)?,
            changed = running.source.step() => {
                if changed {
                    running.refresh();
                }
                false
            }
            () = sleep_until_some(wake_at) => running.tick()?,
            () = sleep_until_some(asked_at.map(|at| at + period_silent)), if shown != Recording::default() || running.keeper.is_some() => false,
        };
    }
    let (source, ui, replay) = (running.source, running.ui, running.replay);
    let robot = source.present().last_words(source.now());
    Ok(Left { ui, robot, replay })
}

struct Running {
    keeper: Option<Keeper>,
    source: Source,
    ui: Ui,
    screen: Screen,
    /// Queue for the results of threads that work on files.
    readers: Sender<Event>,
    drawn: Option<Drawn>,
    pace: Pace,
    /// The capture to replay after this dashboard.
    replay: Option<String>,
}

/// The displayed frame.
struct Drawn {
    revision: u64,
    /// Time at which displayed ages are outdated.
    stale_at: Option<Moment>,
}

impl Running {
    /// Handles an event and carries out its effects; returns whether to leave.
    fn tell(&mut self, event: Event) -> io::Result<bool> {
        let change = self.source.take(&event);
        let now = self.source.now();
        let effects = self.ui.update(now, event, self.source.present(), change);
        let mut leave = false;
        for effect in effects {
            leave |= self.act(effect)?;
        }
        Ok(leave)
    }

    /// Shows the recorder's notices.
    fn tell_notices(&mut self) -> io::Result<bool> {
        let mut leave = false;
        while let Some((level, text)) = self.keeper.as_ref().and_then(Keeper::poll_notice) {
            leave |= self.tell(Event::Notice(Notice::new(
                NoticeCode::Recording,
                level,
                text,
            )))?;
        }
        Ok(leave)
    }

    fn tell_all(&mut self) -> io::Result<bool> {
        let mut leave = false;
        while let Some(event) = self.source.driver().and_then(Driver::poll_event) {
            leave |= self.tell(event)?;
        }
        Ok(leave)
    }

    /// Handles an event of the terminal and those that wait behind it. After one that took long, and in a flood, STOP and Ctrl-C come first,
    /// and signals are looked for.
    fn take_keys(
        &mut self,
        first: crossterm::event::Event,
        keys: &mut terminal::Events,
    ) -> io::Result<bool> {
        let (mut leave, mut next) = (false, Some(first));
        for _ in 0..BATCH {
            let Some(event) = next else {
                break;
            };
            let began = Instant::now();
            leave |= self.take_key(event.clone())?;
            if began.elapsed() > SLOW {
                keys.hurry(Some(&event), |key| self.ui.is_stop(*key));
                return Ok(leave);
            }
            next = keys.poll();
        }
        if let Some(event) = next {
            leave |= self.take_key(event)?;
            keys.hurry(None, |key| self.ui.is_stop(*key));
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
                let (width, height) = self.screen.size();
                self.tell(Event::Resize { width, height })
            }
            Terminal::Mouse(mouse) => self.take_mouse(mouse),
            Terminal::FocusGained | Terminal::FocusLost => Ok(false),
        }
    }

    fn take_mouse(&mut self, mouse: MouseEvent) -> io::Result<bool> {
        let gesture = match mouse.kind {
            MouseEventKind::Down(MouseButton::Left) => Gesture::Click,
            MouseEventKind::ScrollUp => Gesture::Wheel(1),
            MouseEventKind::ScrollDown => Gesture::Wheel(-1),
            _ => return Ok(false),
        };
        let size = self.screen.size();
        let (shown, now) = self.shown();
        match view::spot(shown, now, size, mouse.column, mouse.row) {
            Some(on) => self.tell(Event::Pointer { on, gesture }),
            None => Ok(false),
        }
    }

    /// The shown facts with the view, and their moment.
    fn shown(&self) -> (Shown<'_>, Moment) {
        let (facts, at) = self.source.shown();
        let shown = Shown {
            facts,
            present: self.source.present(),
            ui: &self.ui,
        };
        (shown, at)
    }

    fn act(&mut self, effect: Effect) -> io::Result<bool> {
        match effect {
            Effect::Send(request) => self.at_station(|driver| {
                driver.request(request);
            }),
            Effect::SendUnasked(request) => {
                self.at_station(|driver| driver.request_unasked(request));
            }
            Effect::Drive {
                velocity_in_s,
                rotation_in_s,
            } => self.at_station(|driver| driver.drive(velocity_in_s, rotation_in_s)),
            Effect::DriveEnd => self.at_station(Driver::drive_end),
            Effect::CancelCommands => self.at_station(Driver::cancel),
            Effect::AnswerAlarm(alarm) => self.at_station(|driver| driver.answer_alarm(alarm)),
            Effect::Suggestion(suggestion) => {
                self.at_station(|driver| driver.tell(Event::Suggestion(suggestion)));
            }
            Effect::Playback(control) => return self.play(control),
            Effect::ToggleRecording => match &self.keeper {
                Some(keeper) => keeper.toggle(),
                None => {
                    return self.tell(Event::Notice(Notice::new(
                        NoticeCode::Recording,
                        Level::Warning,
                        "a capture is shown: there is nothing to record",
                    )));
                }
            },
            Effect::Label {
                capture,
                remark,
                ago,
            } => {
                if let Remark::Note(text) = &remark {
                    self.source.add_noted_mark(ago, text.clone());
                }
                self.label(capture, remark, ago);
            }
            Effect::ListRuns(folder) => self.work_on_files(move || Event::Runs(runs::list(folder))),
            Effect::CompareRuns(captures) => {
                self.work_on_files(move || Event::Overlaid(runs::overlay(&captures)));
            }
            Effect::ListFiles {
                beginning,
                extensions,
            } => self.work_on_files(move || {
                let files = files::beginning_with(&beginning, extensions);
                Event::Files { beginning, files }
            }),
            Effect::LoadRoute(path) => self.work_on_files(move || {
                let route = files::read_text(&path)
                    .and_then(|text| route::parse(&path, &text).map_err(|error| error.to_string()));
                Event::RouteLoaded { path, route }
            }),
            Effect::LoadParameters(path) => self.work_on_files(move || {
                let read = files::read_text(&path).and_then(|text| {
                    ParameterFile::parse(&path, &text).map_err(|error| error.to_string())
                });
                Event::ParametersLoaded { read }
            }),
            Effect::Save {
                kind,
                path,
                text,
                overwrite,
            } => self.work_on_files(move || {
                let alike = |old: &str| match kind {
                    FileKind::Route => route::parse(&path, old).is_ok(),
                    FileKind::Parameters => ParameterFile::parse(&path, old).is_ok(),
                };
                let saved = files::check_replaced(&path, alike)
                    .and_then(|()| files::write_text(&path, &text, overwrite));
                Event::Saved { kind, path, saved }
            }),
            Effect::Notice(notice) => return self.tell(Event::Notice(notice)),
            Effect::Copy(text) => self.screen.copy(&text)?,
            Effect::Ring => self.screen.ring()?,
            Effect::Redraw => self.screen.redraw()?,
            Effect::Suspend => self.suspend()?,
            Effect::Quit => return Ok(true),
            Effect::Replay(capture) => {
                self.replay = Some(capture);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Carries out the operator's wish at the station. A replay has no robot and its own events.
    fn at_station(&mut self, act: impl FnOnce(&mut Driver)) {
        if let Some(driver) = self.source.driver() {
            act(driver);
        }
    }

    fn play(&mut self, control: Control) -> io::Result<bool> {
        let events = self.source.handle(control);
        if let Some((capture, at)) = self.removed_mark(&events) {
            self.forget_notes(capture, at);
        }
        self.refresh();
        let mut leave = false;
        for event in events {
            if let (Event::Mark(_), Some(keeper)) = (&event, &self.keeper) {
                keeper.event_sink()(Instant::now(), &event);
            }
            leave |= self.tell(event)?;
        }
        Ok(leave)
    }

    /// Handles the passing of time.
    fn tick(&mut self) -> io::Result<bool> {
        if self.source.advance() {
            self.refresh();
        }
        self.tell(Event::Tick)
    }

    /// Brings the view to the shown moment.
    fn refresh(&mut self) {
        self.ui.show_moment(self.source.playback());
    }

    /// Runs `work` on a thread, because STOP must not wait for a slow disk; its event comes back, if it has one.
    fn work_on_files<E: Into<Option<Event>>>(&self, work: impl FnOnce() -> E + Send + 'static) {
        let readers = self.readers.clone();
        thread::spawn(move || {
            if let Some(event) = work().into() {
                // The dashboard may have ended.
                let _ = readers.blocking_send(event);
            }
        });
    }

    /// Capture and moment of a mark that the operator removed.
    fn removed_mark(&mut self, events: &[Event]) -> Option<(String, Moment)> {
        if let Source::Capture(source) = &mut self.source {
            let (at, is_set) = source.player.take_marked()?;
            let capture = self.ui.config.capture.clone()?;
            return (!is_set).then_some((capture, at));
        }
        let ago = events.iter().find_map(|event| match event {
            Event::Mark(mark) if !mark.is_set => Some(mark.ago),
            _ => None,
        })?;
        let recording = &self.source.present().recording;
        let capture = recording.mcap.as_ref().or(recording.tee.as_ref())?;
        let keeper = self.keeper.as_ref()?;
        let now = keeper.moment_of(Path::new(capture), Instant::now())?;
        Some((capture.clone(), now.saturating_sub(ago)))
    }

    /// Removes the notes of a removed mark, and tells it once that is done.
    fn forget_notes(&self, capture: String, at: Moment) {
        let stays = match &self.source {
            Source::Capture(source) if source.player.is_recorded_mark(at) => {
                "; the recording keeps its mark"
            }
            _ => "",
        };
        self.work_on_files(move || {
            let path = Path::new(&capture);
            let removed = Label::of(path).and_then(|mut label| {
                let removed = label.remove_notes(at.as_secs_f64(), MARK_REACH.as_secs_f64());
                if !removed.is_empty() {
                    label.keep(path)?;
                }
                Ok(removed)
            });
            let (level, text) = match removed {
                Ok(notes) if notes.is_empty() => return None,
                Ok(notes) => {
                    let texts: Vec<String> = notes.into_iter().map(|note| note.text).collect();
                    let texts = texts.join("; ");
                    (Level::Info, format!("note removed: {texts}{stays}"))
                }
                Err(error) => (Level::Warning, error.to_string()),
            };
            let notice = Notice::new(NoticeCode::Label, level, text);
            Some(Event::Notice(notice))
        });
    }

    /// Labels a capture, with an entry in its log at the shown moment.
    fn label(&self, capture: String, remark: Remark, ago: Moment) {
        let notice = |level, text| Event::Notice(Notice::new(NoticeCode::Label, level, text));
        let said = notice(Level::Info, remark.to_string());
        let now = Instant::now();
        let at = match (&self.source, &self.keeper) {
            (Source::Capture(_), _) => Some(self.source.now().saturating_sub(ago)),
            (Source::Live(_), Some(keeper)) => {
                keeper.event_sink()(now, &said);
                let at = keeper.moment_of(Path::new(&capture), now);
                at.map(|at| at.saturating_sub(ago))
            }
            (Source::Live(_), None) => None,
        };
        self.work_on_files(move || {
            let path = Path::new(&capture);
            let kept = Label::of(path).and_then(|mut label| {
                label.take(at.map(seconds), &remark);
                label.keep(path)
            });
            kept.map_or_else(|error| notice(Level::Warning, error.to_string()), |()| said)
        });
    }

    fn suspend(&mut self) -> io::Result<()> {
        self.screen.suspend(stop_myself)?;
        let (width, height) = self.screen.size();
        self.tell(Event::Resize { width, height })?;
        Ok(())
    }

    /// Time of the next frame if nothing else happens.
    fn due(&self) -> Option<Moment> {
        let Some(drawn) = &self.drawn else {
            return Some(Moment::ZERO);
        };
        let earliest = self.pace.earliest();
        if self.ui.revision() == drawn.revision {
            drawn.stale_at.map(|at| at.max(earliest))
        } else {
            Some(earliest)
        }
    }

    /// Time to wake up if nothing happens.
    fn wake_at(&mut self) -> Option<Instant> {
        let host = self.source.host_now();
        let timeouts = [self.ui.poll_timeout(), self.source.poll_timeout()];
        let at = timeouts.into_iter().chain([self.due()]).flatten().min();
        let at = at.map(|at| Instant::now() + at.saturating_sub(host));
        [at, self.source.wake_at()].into_iter().flatten().min()
    }

    /// Passes a frame to the drawing thread if one is due.
    fn draw_if_due(&mut self) -> io::Result<()> {
        let host = self.source.host_now();
        if self.due().is_some_and(|at| at <= host) {
            let (facts, now) = self.source.shown();
            let shown = Shown {
                facts,
                present: self.source.present(),
                ui: &self.ui,
            };
            let has_pixels = self.ui.config.lines == MapLines::Pixels;
            self.screen.draw(|page| {
                let picture = view::draw_with_picture(shown, now, page);
                // Encoding takes longer than drawing, so the drawing thread does it.
                has_pixels.then(|| -> terminal::After {
                    Box::new(move || view::Picture::sequences(picture.as_ref()))
                })
            })?;
            self.pace.drew(host);
            self.drawn = Some(Drawn {
                revision: self.ui.revision(),
                stale_at: shown.redraw_at(now),
            });
        }
        Ok(())
    }
}

/// A moment in seconds, rounded up to milliseconds: a mark on a line is not before the line.
fn seconds(at: Moment) -> f64 {
    at.as_nanos().div_ceil(1_000_000) as f64 / 1000.0
}

async fn sleep_until_some(at: Option<Instant>) {
    match at {
        Some(at) => sleep_until(TokioInstant::from_std(at)).await,
        None => std::future::pending().await,
    }
}
