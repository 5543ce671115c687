//! Distinguishes the lines of robots that share a channel.

use super::Received;
use super::counting::LATE_LINES_MAX;
use super::reckoning::SILENCE_MS;
use crate::telemetry::SEQUENCE_MODULUS;

/// Minimum number of another robot's lines after which it replaces the followed one, unless that is heard between them: a minute of a busy
/// radio. A robot that is silent for less, as behind a wall, stays the followed one.
const REPLACED_AFTER: u8 = 180;

/// Minimum silence of a followed robot that is replaced, if the ground's time is known, ms: a fast radio brings its lines sooner.
const REPLACED_AFTER_MS: u64 = 59_000;

/// Maximum number of other robots that are known at the same time.
pub const OTHERS_MAX: usize = 4;

/// Maximum number of lines missing between two lines that are taken for the same robot's without its id. If another robot sent the second one, the
/// robot's own next lines count as late then, and not as a hundred lost lines.
const NEAR: u8 = LATE_LINES_MAX;

/// The followed robot and other robots on its channel. Most lines contain their robot's id. Any other line belongs to the
/// robot with the same boot counter; if several robots have it, to the one whose sequence the line continues most closely. If it continues no
/// known robot, a later line with an id, or near the followed robot's, decides: the robot may have restarted, or was not heard for long, or another robot may be on the channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Robots {
    own: Option<Robot>,
    /// The latest line, while no id is known.
    unnamed: Option<Place>,
    /// The other robots, in the order in which they appeared.
    others: [Option<Robot>; OTHERS_MAX],
    /// Whether no other robot replaces the followed one.
    is_held: bool,
    /// Id of the robot that was followed before.
    replaced_id: Option<u8>,
}

#[derive(Clone, Copy, Debug)]
struct Robot {
    id: u8,
    latest: Place,
    /// Number of lines with this robot's id since the latest line of the followed robot.
    in_a_row: u8,
}

impl Robot {
    const fn new(id: u8, latest: Place) -> Self {
        Self {
            id,
            latest,
            in_a_row: 0,
        }
    }
}

/// The ground's time without a line of the followed robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Silence {
    pub(super) ms: u64,
    /// Maximum number of lines that the robot can have sent in it.
    pub(super) lines_max: u64,
}

impl Silence {
    const fn is_long(self) -> bool {
        self.ms >= SILENCE_MS
    }
}

/// A line's place in a robot's life.
#[derive(Clone, Copy, Debug)]
struct Place {
    boot: u8,
    sequence: u8,
}

impl Place {
    const fn of(received: &Received) -> Self {
        Self {
            boot: received.ack().boot,
            sequence: received.sequence(),
        }
    }

    /// Number of lines between an earlier line of the same boot and this one. A robot does not send the same sequence twice in a row.
    const fn skipped_since(self, earlier: Self) -> u8 {
        (self.sequence + SEQUENCE_MODULUS - earlier.sequence - 1) % SEQUENCE_MODULUS
    }

    /// Whether this line comes soon after another one of the same boot.
    const fn follows(self, earlier: Self) -> bool {
        self.boot == earlier.boot && self.skipped_since(earlier) <= NEAR
    }

    /// Whether this line may be of the robot whose latest line is given, or a late one of it.
    const fn continues(self, latest: Self) -> bool {
        let is_late = latest.skipped_since(self) < LATE_LINES_MAX;
        let is_repeated = latest.sequence == self.sequence;
        self.boot == latest.boot && (self.follows(latest) || is_late || is_repeated)
    }
}

/// The robot that sent a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sender {
    /// The followed robot.
    Own,
    /// Another robot, by its place among the other robots.
    Other(usize),
    /// The robot that is followed from this line on; the lines before it are another robot's.
    Successor,
    /// The robot that is followed from this line on. The lines before it, which show no id, are its own or another robot's: as its own, this
    /// number of lines would be missing between the latest of them and this line.
    Unclear(u8),
    /// A later line decides, with [`Robots::sent_own`]. If the followed robot sent this one, this number of lines is missing before it.
    Undecided(u8),
}

impl Robots {
    /// Takes a line after a time without a line of the followed robot, if the ground's time is known; returns its sender. The first
    /// robot received is followed. After a silence, an only robot's lines are not expected to be near each other.
    pub(super) fn take(&mut self, received: &Received, silence: Option<Silence>) -> Sender {
        let latest = Place::of(received);
        let id = id_of(received);
        if self.own.is_none() {
            self.own = id.map(|id| Robot::new(id, latest));
            let has_invalid_id = id.is_none() && received.robot_id().is_some();
            let before = core::mem::replace(&mut self.unnamed, (!has_invalid_id).then_some(latest));
            let unclear = before.filter(|before| !has_invalid_id && !latest.continues(*before));
            return unclear.map_or(Sender::Own, |before| {
                Sender::Unclear(latest.skipped_since(before))
            });
        }
        let Some(id) = id else {
            let sender = self.sender_of(latest, silence);
            self.follow(sender, latest);
            return sender;
        };
        let mut robot = Robot::new(id, latest);
        let Some(own) = self.own.filter(|own| own.id != id) else {
            self.own = Some(robot);
            for other in self.others.iter_mut().flatten() {
                other.in_a_row = 0;
            }
            return Sender::Own;
        };
        let place = self.place_of(id);
        let before = self.others[place].filter(|other| other.id == id);
        robot.in_a_row = before.map_or(0, |before| before.in_a_row).saturating_add(1);
        let is_long = silence.is_none_or(|silence| silence.ms >= REPLACED_AFTER_MS);
        if self.is_held || robot.in_a_row < REPLACED_AFTER || !is_long {
            self.others[place] = Some(robot);
            return Sender::Other(place);
        }
        self.own = Some(robot);
        self.others[place] = Some(own);
        self.replaced_id = Some(own.id);
        for other in self.others.iter_mut().flatten() {
            other.in_a_row = 0;
        }
        Sender::Successor
    }

    /// Keeps the followed robot, or lets another one replace it again.
    pub(super) const fn hold(&mut self, is_held: bool) {
        self.is_held = is_held;
    }

    /// The place of another robot's id among the other robots; if there is none, the first free place or the last one.
    fn place_of(&self, id: u8) -> usize {
        let mut others = self.others.iter();
        let known = others.position(|other| other.is_some_and(|other| other.id == id));
        let free = || self.others.iter().position(Option::is_none);
        known.or_else(free).unwrap_or(OTHERS_MAX - 1)
    }

    /// The sender of a line without an id.
    fn sender_of(&self, line: Place, silence: Option<Silence>) -> Sender {
        let Some(own) = self.own else {
            return Sender::Own;
        };
        let is_own_boot = line.boot == own.latest.boot;
        let silence = silence.filter(|silence| silence.is_long());
        let fits =
            |silence: Silence| u64::from(line.skipped_since(own.latest)) <= silence.lines_max;
        let may_follow = line.continues(own.latest) || silence.is_some_and(fits);
        let undecided = Sender::Undecided(if is_own_boot {
            line.skipped_since(own.latest)
        } else {
            line.sequence
        });
        if self.others[0].is_none() {
            return if is_own_boot && may_follow {
                Sender::Own
            } else {
                undecided
            };
        }
        let skipped = |robot: Robot| line.skipped_since(robot.latest);
        let others = self.others.iter().enumerate();
        let nearest = others
            .filter_map(|(place, other)| Some((place, (*other)?)))
            .filter(|(_, other)| other.latest.boot == line.boot)
            .min_by_key(|(_, other)| skipped(*other));
        match nearest {
            Some((place, other)) => {
                // After a silence of the followed robot, or several lines of the other one, that is more likely.
                let is_heard = silence.is_none() && other.in_a_row <= 1;
                let is_own = is_own_boot
                    && (skipped(own) < skipped(other)
                        || is_heard && skipped(own) == skipped(other));
                if !is_own {
                    Sender::Other(place)
                } else if may_follow {
                    Sender::Own
                } else {
                    // A line of another robot, most of whose lines were lost, may be anywhere.
                    undecided
                }
            }
            None if is_own_boot => Sender::Own,
            None => undecided,
        }
    }

    fn follow(&mut self, sender: Sender, line: Place) {
        let robot = match sender {
            Sender::Other(place) => &mut self.others[place],
            Sender::Own | Sender::Successor | Sender::Unclear(_) => &mut self.own,
            Sender::Undecided(_) => return,
        };
        if let Some(robot) = robot {
            robot.latest = line;
        }
    }

    /// Decides by the `next` line, which is not taken yet, whether the followed robot sent the undecided lines from `first` to `last`; `None`
    /// if that remains open.
    pub(super) fn sent_own(
        &mut self,
        first: &Received,
        last: &Received,
        next: &Received,
        silence: Option<Silence>,
    ) -> Option<bool> {
        let own = self.own?;
        let (line, last) = (Place::of(first), Place::of(last));
        let next_line = Place::of(next);
        let follows = next_line.follows(last);
        let skipped = next_line.skipped_since(own.latest);
        let is_own = match id_of(next) {
            Some(id) if id != own.id => {
                return follows.then_some(false);
            }
            None if matches!(self.sender_of(next_line, silence), Sender::Other(_)) => {
                return None;
            }
            // The robot is where it was before, unless it numbers its lines through and shows a wrong boot.
            _ if next_line.continues(own.latest)
                && !(follows && next_line.skipped_since(last) < skipped) =>
            {
                line.skipped_since(own.latest) < skipped
            }
            None if silence.is_some_and(Silence::is_long) && own.latest.boot == next_line.boot => {
                line.boot == next_line.boot
            }
            // Only an id shows that the robot is elsewhere.
            None => return None,
            // A line that is not between two others of one boot is a hundred lines away, or another robot's; no robot boots eight times between them.
            Some(_) if own.latest.boot == next_line.boot => {
                line.boot == next_line.boot && line.skipped_since(own.latest) < skipped
            }
            Some(_) => true,
        };
        if is_own {
            self.follow(Sender::Own, last);
        }
        Some(is_own)
    }

    /// Whether only the followed robot can have sent a line, as far as is known.
    pub(super) fn may_have_sent(&self, received: &Received) -> bool {
        let is_alone = self.others.iter().all(Option::is_none);
        is_alone && id_of(received).is_none_or(|id| self.own_id().is_none_or(|own| own == id))
    }

    /// Id of the followed robot; `None` before the first line that shows it.
    pub(super) fn own_id(&self) -> Option<u8> {
        self.own.map(|robot| robot.id)
    }

    /// Ids of the other robots.
    pub(super) fn other_ids(&self) -> [Option<u8>; OTHERS_MAX] {
        self.others.map(|other| other.map(|robot| robot.id))
    }

    /// Id of the robot that was followed before the present one; `None` if there is none.
    pub(super) const fn replaced_id(&self) -> Option<u8> {
        self.replaced_id
    }
}

/// The id in a line. No robot has the id 0.
fn id_of(received: &Received) -> Option<u8> {
    received.robot_id().filter(|id| *id != 0)
}
