//! The floor map of a whole session.

use std::fmt;
use std::time::Duration;

use groundwave_protocol::telemetry::Line;

use crate::compass::{Compass, Seen};
use crate::floor_map::FloorMap;

/// Least time between two copies of the estimate.
const COPY_EVERY: Duration = Duration::from_secs(1);

/// Makes the map of a session. If the heading is not known well at the end, the map ends where it last was.
#[derive(Clone, Debug, Default)]
pub struct Mapper {
    compass: Compass,
    /// Beginning of the first frame.
    first: Option<Duration>,
    /// The newest copy with a well-known heading and a map.
    copy: Option<(Duration, Compass)>,
}

/// The map of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionMap {
    /// The map, in the world's frame ([`Compass::floor_map`]).
    pub map: FloorMap,
    /// Time up to which it has what was seen, if the heading is not known well at the end.
    pub until: Option<Duration>,
    /// What it is made of, for a map of several runs.
    pub(crate) seen: Seen,
}

/// Reason why there is no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoMap {
    /// No line A was received.
    NoPose,
    /// The directions of too few walls were seen.
    WallsUnknown,
    /// The heading was never known well while there were walls.
    HeadingUnknown,
}

impl fmt::Display for NoMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoPose => "no position was received",
            Self::WallsUnknown => "the robot has not passed enough walls",
            Self::HeadingUnknown => "the robot's heading was never known well",
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
        if is_due && self.compass.maps_well() {
            self.copy = Some((now, self.compass.clone()));
        }
    }

    /// Time from which on the map has what was seen, if the robot got a new pose or was restarted.
    #[must_use]
    pub fn since(&self) -> Option<Duration> {
        let since = self.compass.since();
        since.filter(|_| since != self.first)
    }

    /// The map since the pose was set.
    ///
    /// # Errors
    /// If nothing can be placed.
    pub fn finish(self) -> Result<SessionMap, NoMap> {
        self.compass.since().ok_or(NoMap::NoPose)?;
        let (until, compass) = match self.copy {
            _ if self.compass.maps_well() => (None, self.compass),
            Some((at, copy)) => (Some(at), copy),
            None if self.compass.knows_walls() => return Err(NoMap::HeadingUnknown),
            None => return Err(NoMap::WallsUnknown),
        };
        let seen = compass.seen().ok_or(NoMap::WallsUnknown)?;
        let map = seen.floor_map().ok_or(NoMap::WallsUnknown)?;
        Ok(SessionMap { map, until, seen })
    }
}
