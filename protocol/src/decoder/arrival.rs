//! What arrived of the followed robot: intact lines, and lines A that can be repaired.

use super::{Decoder, End, Received};
use crate::telemetry::{Body, Line, SEQUENCE_MODULUS, repaired};

/// Maximum number of lines by which a repaired line is ahead of the newest intact one: three seconds, while its place is beyond doubt.
const AHEAD_MAX: u8 = 9;

/// What arrived of the followed robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// An intact line.
    Line(Received),
    /// A line A with one flipped bit, as it was sent. It counts as damaged: it is for an estimate of the pose, is not shown as telemetry, and
    /// proves no command.
    Repaired(Line),
}

impl Decoder {
    /// The next intact line of the followed robot, as [`Decoder::next_own_line`] returns it, or its next repaired line A. Counters and
    /// intact lines are the same.
    pub fn next_arrival(&mut self, bytes: &mut &[u8]) -> Option<Arrival> {
        loop {
            match self.next_own_end(bytes)? {
                End::Line(received) => return Some(Arrival::Line(received)),
                End::Damaged => {
                    if let Some(line) = self.repaired() {
                        return Some(Arrival::Repaired(line));
                    }
                }
            }
        }
    }

    /// The newest damaged line, repaired, if one flipped bit makes it a line A that comes soon after the followed robot's newest intact
    /// line, in the same boot. Once another robot was heard, nothing is repaired: a line A may have no id.
    fn repaired(&self) -> Option<Line> {
        let sent = repaired(self.seen().last_chunk()?)?;
        let line = Line::parse(&sent).ok()?;
        let newest = self.newest.as_ref()?;
        let ahead = (line.sequence + SEQUENCE_MODULUS - newest.sequence) % SEQUENCE_MODULUS;
        let is_own = line.ack.boot == newest.boot
            && (1..=AHEAD_MAX).contains(&ahead)
            && self.undecided[0].is_none()
            && self.robots.may_have_sent(&Received::Line(line, sent));
        (is_own && matches!(line.body, Body::State(_))).then_some(line)
    }
}
