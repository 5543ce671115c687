//! What the robot has said of itself, and when.

use groundwave_protocol::letters::{Bump, Infrared, Layer, LayerMask};
use groundwave_protocol::telemetry::{Body, CountersLine, Line, StateLine, StatusLine};

use super::history::History;
use crate::event::Moment;
use crate::request::Standing;

/// A value and the moment it arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading<T> {
    pub(crate) value: T,
    pub(crate) at: Moment,
}

impl<T> Reading<T> {
    /// How old it is.
    pub(crate) fn age(&self, now: Moment) -> Moment {
        now.saturating_sub(self.at)
    }
}

/// A line A is expected three times a second; older than this it is stale.
pub(crate) const STATE_STALE: Moment = Moment::from_secs(2);

/// A line B is expected every two seconds.
pub(crate) const STATUS_STALE: Moment = Moment::from_secs(8);

/// The newest line of each kind and what outlives it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Robot {
    pub(crate) state: Option<Reading<StateLine>>,
    pub(crate) status: Option<Reading<StatusLine>>,
    pub(crate) counters: Option<Reading<CountersLine>>,
    /// The newest contact, however long ago.
    pub(crate) bump: Option<Reading<Bump>>,
    /// The newest detection, however long ago.
    pub(crate) infrared: Option<Reading<Infrared>>,
    /// Battery voltage over the whole session, decivolts.
    pub(crate) volts: History,
}

impl Robot {
    pub(super) fn take(&mut self, now: Moment, line: &Line) {
        match line.body {
            Body::State(state) => {
                if touches(state.bump) {
                    self.bump = Some(reading(now, state.bump));
                }
                if detects(state.infrared) {
                    self.infrared = Some(reading(now, state.infrared));
                }
                self.state = Some(reading(now, state));
            }
            Body::Status(status) => {
                self.volts.push(now, status.battery_dv);
                self.status = Some(reading(now, status));
            }
            Body::Counters(counters) => self.counters = Some(reading(now, counters)),
            Body::Text(_) | Body::Parameter(_) | Body::Song(_) => {}
        }
    }

    /// Layers this firmware has; `None` until it has said so.
    pub(crate) fn fitted(&self) -> Option<LayerMask> {
        self.status.map(|status| status.value.fitted)
    }

    /// Layers the robot says the operator allows.
    pub(crate) fn allowed(&self) -> Option<LayerMask> {
        self.status.map(|status| status.value.allowed)
    }

    /// What it is set to, for the reason of a refusal.
    pub(crate) fn standing(&self) -> Standing {
        Standing::new(self.state.map(|state| state.value.mode), self.allowed())
    }

    /// Whether the firmware is known to lack a layer.
    pub(crate) fn lacks(&self, layer: Layer) -> bool {
        self.fitted().is_some_and(|fitted| !fitted.contains(layer))
    }
}

const fn reading<T>(at: Moment, value: T) -> Reading<T> {
    Reading { value, at }
}

/// Whether something presses the bumper.
pub(crate) const fn touches(bump: Bump) -> bool {
    !matches!(bump, Bump::None | Bump::NotFitted)
}

/// Whether an infrared detector sees something.
pub(crate) const fn detects(infrared: Infrared) -> bool {
    matches!(infrared, Infrared::Left | Infrared::Right | Infrared::Both)
}
