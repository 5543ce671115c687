//! Where a dashboard's facts come from, and which moment of them is on the screen.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use tokio::sync::mpsc::Receiver;

use super::Driver;
use crate::event::{Event, Level, Moment, Notice, NoticeCode};
use crate::model::{Change, Facts};
use crate::timeline::past::{self, REMEMBERED};
use crate::timeline::{Finding, History, Past, Player, Reel, Scene};
use crate::travel::{Mark, Playback, Travel};

/// Steps through a capture before keys get their turn.
const STEPS: usize = 512;

/// The source of facts.
pub enum Session {
    /// A station on its link.
    Live(Box<Live>),
    /// A capture.
    Replay(Box<Replay>),
}

/// A station on its link, and its past.
pub struct Live {
    /// The station.
    pub driver: Driver,
    /// What is known now.
    facts: Facts,
    player: Player<Past>,
    /// The screen shows the past.
    is_away: bool,
    /// When the past on the screen was last advanced.
    advanced_at: Moment,
}

impl Live {
    /// A session that begins with these facts.
    #[must_use]
    pub fn new(driver: Driver, facts: Facts) -> Self {
        let now = driver.now();
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).ok();
        let unix = unix.and_then(|unix| unix.checked_sub(now));
        let first = Past::new(facts.clone(), now, 0);
        let reel = Reel::new(History::default(), first, past::SPACING);
        Self {
            driver,
            facts,
            player: Player::of_session(reel, unix),
            is_away: false,
            advanced_at: now,
        }
    }

    /// Takes an event and remembers it; returns what it changed on the screen.
    fn take(&mut self, event: &Event) -> Change {
        let now = self.driver.now();
        // Time alone raises alarms.
        let is_due = self.facts.poll_timeout().is_some_and(|at| at <= now);
        let change = self.facts.update(now, event);
        if Facts::takes(event) || is_due {
            let history = self.player.reel_mut().supply_mut();
            history.push(now, event.clone());
        }
        self.keep(now);
        Change {
            is_shown: change.is_shown && !self.is_away,
            ..change
        }
    }

    /// Keeps a state now and then, and forgets what is old.
    fn keep(&mut self, now: Moment) {
        let reel = self.player.reel_mut();
        let history = reel.supply();
        let mut oldest = now.saturating_sub(REMEMBERED);
        if history.is_full() {
            oldest = oldest.max(history.quarter_at().unwrap_or(oldest));
        }
        if reel.wants(now) {
            let next = history.count();
            reel.keep(Past::new(self.facts.clone(), now, next));
        }
        if let Some(next) = reel.forget_before(oldest).map(Past::next) {
            reel.supply_mut().forget_before(next);
        }
        self.stretch(now);
    }

    /// Lets the span that can be shown reach from the oldest remembered moment until now.
    fn stretch(&mut self, now: Moment) {
        let from = self.player.reel().oldest_at().unwrap_or(now);
        self.player.set_span(from, now);
    }

    fn advance(&mut self, now: Moment) {
        self.stretch(now);
        self.advanced_at = now;
        let plays = !self.player.is_paused();
        self.player.advance(now);
        if plays && self.player.is_at_end() {
            self.come_back();
        }
    }

    /// Returns what the operator is told, and what is recorded.
    fn travel(&mut self, travel: Travel) -> Vec<Event> {
        let now = self.driver.now();
        let told = self.go(now, travel);
        let marked = self.player.take_marked().map(|(at, is_set)| {
            let ago = now.saturating_sub(at);
            Event::Mark(Mark { ago, is_set })
        });
        told.into_iter().chain(marked).collect()
    }

    fn go(&mut self, now: Moment, travel: Travel) -> Option<Event> {
        self.stretch(now);
        if !self.is_away {
            self.advanced_at = now;
            self.player.rest();
            match travel {
                Travel::Speed(_) | Travel::Newest | Travel::GiveUp => return None,
                Travel::Mark => {
                    self.player.handle(now, travel);
                    return self.note();
                }
                Travel::TogglePause => {
                    self.player.handle(now, Travel::Newest);
                    self.is_away = true;
                    return None;
                }
                _ => {
                    self.is_away = self.player.leave_newest(now, travel);
                    return if self.is_away { None } else { self.note() };
                }
            }
        }
        self.player.handle(now, travel);
        if travel == Travel::Newest {
            self.come_back();
        }
        None
    }

    /// The player's note as a line for the log, where the playback line does not show it.
    fn note(&self) -> Option<Event> {
        let text = self.player.playback().note?;
        Some(Event::Notice(Notice::new(
            NoticeCode::Playback,
            Level::Info,
            text,
        )))
    }

    fn come_back(&mut self) {
        self.player.rest();
        self.is_away = false;
    }
}

/// A capture that is played, and the findings of the thread that reads it through.
pub struct Replay {
    /// The capture.
    pub player: Player<Scene>,
    /// Findings so far.
    pub findings: Receiver<Finding>,
    /// The host's time counts from here.
    pub started: Instant,
}

impl Replay {
    fn take(&mut self, finding: Finding) {
        match finding {
            Finding::State(scene) => {
                let at = scene.moment();
                self.player.reel_mut().keep(*scene);
                self.player.set_read(at);
            }
            Finding::Marks(marks) => self.player.set_recorded_marks(marks),
            Finding::End(at) => self.player.set_read_through(at),
        }
    }
}

impl Session {
    /// The present: the time since a live session began, or the moment shown of a capture.
    pub(super) fn now(&self) -> Moment {
        match self {
            Self::Live(live) => live.driver.now(),
            Self::Replay(replay) => replay.player.at(),
        }
    }

    /// The time of the host.
    pub(super) fn host_now(&self) -> Moment {
        match self {
            Self::Live(live) => live.driver.now(),
            Self::Replay(replay) => replay.started.elapsed(),
        }
    }

    /// The station, if there is one.
    pub(super) fn driver(&mut self) -> Option<&mut Driver> {
        match self {
            Self::Live(live) => Some(&mut live.driver),
            Self::Replay(_) => None,
        }
    }

    /// What is known at the present.
    pub(super) fn present(&self) -> &Facts {
        match self {
            Self::Live(live) => &live.facts,
            Self::Replay(replay) => replay.player.facts(),
        }
    }

    /// What is known at the moment on the screen, and that moment.
    pub(super) fn shown(&self) -> (&Facts, Moment) {
        match self {
            Self::Live(live) if live.is_away => (live.player.facts(), live.player.at()),
            Self::Live(_) | Self::Replay(_) => (self.present(), self.now()),
        }
    }

    /// Where the screen stands in time; `None` when it shows now.
    pub(super) fn playback(&self) -> Option<Playback> {
        match self {
            Self::Live(live) => live.is_away.then(|| live.player.playback()),
            Self::Replay(replay) => Some(replay.player.playback()),
        }
    }

    /// Waits for something to happen; says whether what the screen shows changed by itself. Nothing is lost when
    /// the wait is abandoned.
    pub(super) async fn step(&mut self) -> bool {
        match self {
            Self::Live(live) => {
                live.driver.step().await;
                false
            }
            Self::Replay(replay) => match replay.findings.recv().await {
                Some(finding) => {
                    replay.take(finding);
                    true
                }
                None => std::future::pending().await,
            },
        }
    }

    /// Takes an event as a fact of a live session; returns what it changed on the screen. The facts of a capture are
    /// its own.
    pub(super) fn take(&mut self, event: &Event) -> Change {
        match self {
            Self::Live(live) => live.take(event),
            Self::Replay(_) => Change::default(),
        }
    }

    /// Shows another moment; returns what the operator is told about it, and what is recorded.
    pub(super) fn travel(&mut self, travel: Travel) -> Vec<Event> {
        match self {
            Self::Live(live) => live.travel(travel),
            Self::Replay(replay) => {
                replay.player.handle(replay.started.elapsed(), travel);
                Vec::new()
            }
        }
    }

    /// Lets time pass in what is shown of the past; says whether the screen has to follow.
    pub(super) fn advance(&mut self) -> bool {
        let host = self.host_now();
        match self {
            Self::Live(live) if live.is_away => {
                live.advance(host);
                true
            }
            Self::Live(_) => false,
            Self::Replay(replay) => {
                let has_changed = replay.player.work(STEPS);
                replay.player.advance(host) || has_changed
            }
        }
    }

    /// When to call [`Self::advance`].
    pub(super) fn wake_at(&mut self) -> Option<Instant> {
        let host = self.host_now();
        let at = match self {
            // The age of the moment shown changes every second.
            Self::Live(live) if live.is_away => {
                let plays = live.player.wake_at();
                Some(plays.unwrap_or(live.advanced_at + Duration::from_secs(1)))
            }
            Self::Live(_) => None,
            Self::Replay(replay) if replay.player.has_work() => Some(host),
            Self::Replay(replay) => replay.player.wake_at(),
        };
        at.map(|at| Instant::now() + at.saturating_sub(host))
    }

    /// When an alarm is due at the present; the facts of a capture raise theirs themselves.
    pub(super) fn poll_timeout(&self) -> Option<Moment> {
        match self {
            Self::Live(live) => live.facts.poll_timeout(),
            Self::Replay(_) => None,
        }
    }
}
