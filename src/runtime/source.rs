//! Sources of a dashboard's facts: a live station or a capture.

use std::time::{Instant, SystemTime, UNIX_EPOCH};

use tokio::sync::mpsc::Receiver;

use super::{Driver, Reports};
use crate::event::{Event, Moment};
use crate::model::{Change, Facts};
use crate::playback::{CaptureState, Control, Finding, LivePlayer, Playback, Player};

/// Maximum number of steps through a capture before keys are handled.
const STEPS: usize = 512;

/// A source of facts that can also play its past.
pub enum Source {
    /// A station on its link.
    Live(Box<LiveSource>),
    /// A capture.
    Capture(Box<CaptureSource>),
}

/// A station on its link.
pub struct LiveSource {
    driver: Driver,
    player: LivePlayer,
    reports: Reports,
}

impl LiveSource {
    /// A session that begins with the given facts.
    #[must_use]
    pub fn new(driver: Driver, facts: Facts) -> Self {
        let now = driver.now();
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).ok();
        let unix = unix.and_then(|unix| unix.checked_sub(now));
        let player = LivePlayer::new(facts, now, unix);
        Self {
            driver,
            player,
            reports: Reports::default(),
        }
    }
}

/// A capture, and the findings of the thread that reads it to its end.
pub struct CaptureSource {
    /// The capture.
    pub player: Player<CaptureState>,
    /// Findings of the reading thread.
    pub findings: Receiver<Finding>,
    /// Instant at which the host's time is zero.
    pub started: Instant,
}

impl CaptureSource {
    fn take(&mut self, finding: Finding) {
        match finding {
            Finding::State(state) => {
                let at = state.moment();
                self.player.timeline_mut().keep(*state);
                self.player.set_read(at);
            }
            Finding::Marks(marks) => self.player.set_recorded_marks(marks),
            Finding::End(at) => self.player.set_read_through(at),
        }
    }
}

impl Source {
    /// Current time: since a live session began, or the displayed moment of a capture.
    pub(super) fn now(&self) -> Moment {
        match self {
            Self::Live(live) => live.driver.now(),
            Self::Capture(capture) => capture.player.at(),
        }
    }

    /// The host's time.
    pub(super) fn host_now(&self) -> Moment {
        match self {
            Self::Live(live) => live.driver.now(),
            Self::Capture(capture) => capture.started.elapsed(),
        }
    }

    /// The station, if there is one.
    pub(super) fn driver(&mut self) -> Option<&mut Driver> {
        match self {
            Self::Live(live) => Some(&mut live.driver),
            Self::Capture(_) => None,
        }
    }

    /// The facts as of now.
    pub(super) fn present(&self) -> &Facts {
        match self {
            Self::Live(live) => live.player.present(),
            Self::Capture(capture) => capture.player.facts(),
        }
    }

    /// The facts at the moment on the screen, and that moment.
    pub(super) fn shown(&self) -> (&Facts, Moment) {
        match self {
            Self::Live(live) => live.player.shown(live.driver.now()),
            Self::Capture(capture) => (capture.player.facts(), capture.player.at()),
        }
    }

    /// State of playback; `None` while the screen shows the present.
    pub(super) fn playback(&self) -> Option<Playback> {
        match self {
            Self::Live(live) => live.player.playback(),
            Self::Capture(capture) => Some(capture.player.playback()),
        }
    }

    /// Adds the text of a mark that was set some time before now.
    pub(super) fn add_noted_mark(&mut self, ago: Moment, text: String) {
        let at = self.now().saturating_sub(ago);
        match self {
            Self::Live(live) => live.player.add_noted_mark(at, text),
            Self::Capture(capture) => capture.player.add_noted_mark(at, text),
        }
    }

    /// Waits for an input; returns whether the screen has changed. Cancel-safe.
    pub(super) async fn step(&mut self) -> bool {
        match self {
            Self::Live(live) => {
                live.driver.step().await;
                false
            }
            Self::Capture(capture) => match capture.findings.recv().await {
                Some(finding) => {
                    capture.take(finding);
                    true
                }
                None => std::future::pending().await,
            },
        }
    }

    /// Takes an event of a live session; returns its effect on the screen. A capture has its own events.
    pub(super) fn take(&mut self, event: &Event) -> Change {
        match self {
            Self::Live(live) => {
                let now = live.driver.now();
                let change = live.player.take(now, event);
                for report in live.reports.take(now, event, live.player.present()) {
                    live.driver.tell(report);
                }
                change
            }
            Self::Capture(_) => Change::default(),
        }
    }

    /// Shows another moment; returns events for the log and the recording.
    pub(super) fn handle(&mut self, control: Control) -> Vec<Event> {
        match self {
            Self::Live(live) => live.player.handle(live.driver.now(), control),
            Self::Capture(capture) => {
                capture.player.handle(capture.started.elapsed(), control);
                Vec::new()
            }
        }
    }

    /// Advances the playback; returns whether the screen changes.
    pub(super) fn advance(&mut self) -> bool {
        let host = self.host_now();
        match self {
            Self::Live(live) => live.player.advance(host),
            Self::Capture(capture) => {
                let has_changed = capture.player.work(STEPS);
                capture.player.advance(host) || has_changed
            }
        }
    }

    /// Time of the next call of [`Self::advance`].
    pub(super) fn wake_at(&mut self) -> Option<Instant> {
        let host = self.host_now();
        let at = match self {
            Self::Live(live) => live.player.wake_at(),
            Self::Capture(capture) if capture.player.has_work() => Some(host),
            Self::Capture(capture) => capture.player.wake_at(),
        };
        at.map(|at| Instant::now() + at.saturating_sub(host))
    }

    /// Time at which an alarm is due in a live session; a capture raises its own alarms.
    pub(super) fn poll_timeout(&self) -> Option<Moment> {
        match self {
            Self::Live(live) => live.player.present().poll_timeout(),
            Self::Capture(_) => None,
        }
    }
}
