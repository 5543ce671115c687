//! The floor map of a whole session.

use std::fmt;
use std::time::Duration;

use groundwave_protocol::telemetry::Line;

use crate::compass::Compass;
use crate::floor_map::FloorMap;

/// Half of the heading's 95 % interval up to which it is known well: a longer leg would be drawn beside its room.
const WELL_DEG: f64 = 20.0;

/// Time between two copies of the state.
const COPY_EVERY: Duration = Duration::from_mins(1);

/// Makes the map of a session; where the heading is not known well any more, the map ends.
#[derive(Clone, Debug, Default)]
pub struct Mapper {
    compass: Compass,
    /// Beginning of the first frame.
    first: Option<Duration>,
    /// A copy from when the heading was known well.
    copy: Option<(Duration, Compass)>,
}

/// The map of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionMap {
    /// The map, in the world's frame ([`Compass::floor_map`]).
    pub map: FloorMap,
    /// Time from which on it has what was seen, if the robot got a new pose or was restarted.
    pub from: Option<Duration>,
    /// Time up to which it has what was seen, if the heading is not known well from there on.
    pub until: Option<Duration>,
}

/// Reason why there is no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoMap {
    /// No line A was received.
    NoPose,
    /// The directions of too few walls were seen.
    WallsUnknown,
    /// The heading was lost before it was known well.
    HeadingUnknown,
}

impl fmt::Display for NoMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoPose => "no position was received",
            Self::WallsUnknown => "the robot has not passed enough walls",
            Self::HeadingUnknown => "its heading may be wrong by a quarter turn",
        })
    }
}

impl std::error::Error for NoMap {}

impl Mapper {
    /// Takes a line that arrived at a time.
    pub fn handle_line(&mut self, now: Duration, line: &Line) {
        let since = self.compass.since();
        self.compass.handle_line(now, line);
        if self.compass.since() != since {
            self.first = self.first.or(self.compass.since());
            self.copy = None;
        }
        let is_due = self
            .copy
            .as_ref()
            .is_none_or(|(at, _)| now.saturating_sub(*at) >= COPY_EVERY);
        if is_due && self.is_known_well() {
            self.copy = Some((now, self.compass.clone()));
        }
    }

    /// The map since the pose was set.
    ///
    /// # Errors
    /// If nothing can be placed.
    pub fn finish(self) -> Result<SessionMap, NoMap> {
        let since = self.compass.since().ok_or(NoMap::NoPose)?;
        let is_lost = self.compass.heading_error_deg().is_none();
        let (until, compass) = match self.copy {
            Some((at, copy)) if !self.is_known_well() => (Some(at), copy),
            None if is_lost => return Err(NoMap::HeadingUnknown),
            _ => (None, self.compass),
        };
        Ok(SessionMap {
            map: compass.floor_map().ok_or(NoMap::WallsUnknown)?,
            from: (self.first != Some(since)).then_some(since),
            until,
        })
    }

    fn is_known_well(&self) -> bool {
        let error = self.compass.heading_error_deg();
        error.is_some_and(|error| error.half <= WELL_DEG)
    }
}
