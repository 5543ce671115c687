//! Plans the frames of commands without a robot, assuming no losses.
//!
//! Lengths and payloads are those of real frames. Checksums, and the payload of a session request, depend on robot,
//! boot, session and owner; the plan uses example values.

use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::session_after;
use groundwave_protocol::command::{
    BLOCK_WAYPOINTS, Command, FRAME_WAYPOINTS_MAX, Frame, Key, Message, Open, Order, Slots,
};
use groundwave_protocol::digest::digest;
use groundwave_protocol::telemetry::ACK_LINE_BYTES;

use super::delivery::order;
use crate::request::Request;
use crate::statistics::BITS_PER_BYTE;

/// Number of the example's robot, 1 to 99.
pub const ROBOT_ID: u8 = 7;

/// Boot counter of the example's robot.
pub const BOOT: u8 = 1;

/// Nonce of the example's station.
pub const OWNER: u16 = 677;

/// Receipt of the example station's STOPs.
const RECEIPT: u16 = OWNER << 5 | 1;

/// Plans commands in order, for a robot that has just booted.
#[derive(Clone, Debug, Default)]
pub struct Planner {
    /// Number of the robot's session.
    session: u8,
    era: u16,
    is_open: bool,
    sequence: u8,
    tag: u8,
}

/// Frames of one command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The request for a session, if the command needs one and none is open.
    pub opening: Option<Frame>,
    /// Frames of the command. On a bad channel, real frames are shorter, and some are repeated.
    pub frames: Vec<Frame>,
}

impl Plan {
    /// Number of bytes in all frames.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let frames = self.opening.iter().chain(&self.frames);
        frames.map(|frame| frame.as_bytes().len()).sum()
    }

    /// Minimum time on a radio of this baud rate, seconds: all frames and the shortest acknowledgement line, twice that
    /// line if a session must be opened first.
    #[must_use]
    pub fn at_least_s(&self, baud: u32) -> f64 {
        let acknowledgements = 1 + usize::from(self.opening.is_some());
        let bytes = (self.bytes() + acknowledgements * ACK_LINE_BYTES) as f64;
        bytes * f64::from(BITS_PER_BYTE) / f64::from(baud)
    }
}

impl Planner {
    /// Plans the next command.
    pub fn plan(&mut self, request: &Request) -> Plan {
        if *request == Request::Stop {
            if self.is_open {
                self.begin_session(false);
            }
            return Plan {
                opening: None,
                frames: vec![Message::Stop(Some(RECEIPT)).encode(Key::robot(ROBOT_ID))],
            };
        }
        let opening = (!self.is_open).then(|| self.open());
        let key = Key::session(ROBOT_ID, BOOT, self.session, OWNER).in_era(self.era);
        let mut messages = Vec::new();
        let order = match request {
            Request::Route(waypoints) => Some(self.stage(waypoints, &mut messages)),
            request => order(request),
        };
        if let Some(order) = order {
            self.sequence = (self.sequence + 1) & 0x3F;
            messages.push(Message::Command(Command {
                sequence: self.sequence,
                order,
            }));
        }
        Plan {
            opening,
            frames: messages.iter().map(|message| message.encode(key)).collect(),
        }
    }

    fn open(&mut self) -> Frame {
        let open = Open {
            boot: BOOT,
            replaces: self.session,
            owner: OWNER,
            era: Some(self.era),
        };
        self.begin_session(true);
        Message::Open(open).encode(Key::robot(ROBOT_ID))
    }

    fn begin_session(&mut self, is_open: bool) {
        (self.era, self.session) = session_after(self.era, self.session);
        self.is_open = is_open;
        self.sequence = 0;
        self.tag = 0;
    }

    /// Splits waypoints into as few frames as possible; returns the order that activates them.
    fn stage(&mut self, waypoints: &[Waypoint], messages: &mut Vec<Message>) -> Order {
        if !waypoints.is_empty() {
            self.tag = self.tag % 31 + 1;
        }
        let firsts = (0..).step_by(FRAME_WAYPOINTS_MAX / BLOCK_WAYPOINTS);
        for (first_block, chunk) in firsts.zip(waypoints.chunks(FRAME_WAYPOINTS_MAX)) {
            messages.push(Message::Waypoints(Slots::new(self.tag, first_block, chunk)));
        }
        Order::Activate {
            tag: if waypoints.is_empty() { 0 } else { self.tag },
            count: waypoints.len() as u16,
            digest: digest(waypoints.iter()),
        }
    }
}

#[cfg(test)]
mod tests {
    use groundwave_protocol::arq::{Action, Farm};
    use groundwave_protocol::receiver::Receiver;
    use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
    use groundwave_protocol::telemetry::Outcome;

    use super::*;

    /// The robot's end of the uplink, for tests.
    struct Robot {
        receiver: Receiver,
        farm: Farm,
    }

    impl Robot {
        fn new() -> Self {
            Self {
                receiver: Receiver::default(),
                farm: Farm::new(ROBOT_ID, u16::from(BOOT)),
            }
        }

        fn hear(&mut self, frame: &Frame) -> Action {
            let key = self.farm.key();
            let mut bytes = frame.as_bytes().iter();
            let message = bytes.find_map(|&byte| self.receiver.handle_byte(byte, ROBOT_ID, key));
            let action = self
                .farm
                .handle(&message.unwrap_or_else(|| panic!("{frame:?}")));
            if matches!(action, Action::Execute(_)) {
                self.farm.conclude(Outcome::Done);
            }
            action
        }
    }

    fn line(count: i16) -> Vec<Waypoint> {
        (0..count).map(|n| Waypoint { x_in: n, y_in: -n }).collect()
    }

    #[test]
    fn a_robot_that_receives_the_plan_executes_the_request() {
        let mut robot = Robot::new();
        let mut planner = Planner::default();
        let sonar = LayerMask::NONE.with(Layer::Sonar);
        for request in [
            Request::Mode(Mode::Reactive),
            Request::Route(line(1)),
            Request::Route(line(37)),
            Request::Disable(sonar),
            Request::Stop,
            Request::Stop,
            Request::Route(line(300)),
            Request::Route(Vec::new()),
            Request::Failsafe(None),
        ] {
            let plan = planner.plan(&request);
            if let Some(frame) = &plan.opening {
                assert_eq!(robot.hear(frame), Action::Heard);
                assert!(robot.farm.is_open(), "{request}");
            }
            let actions: Vec<Action> = plan.frames.iter().map(|frame| robot.hear(frame)).collect();
            let expected = match &request {
                Request::Stop => Action::Stop,
                Request::Route(_) => Action::ListReplaced,
                request => Action::Execute(order(request).unwrap()),
            };
            assert_eq!(actions.last(), Some(&expected), "{request}");
            if let Request::Route(waypoints) = &request {
                assert_eq!(robot.farm.lists().active(), waypoints);
            }
        }
    }

    #[test]
    fn the_least_time_is_that_of_the_wire() {
        let mut planner = Planner::default();
        let first = planner.plan(&Request::Mode(Mode::Prowl));
        // `O` with 6 characters and `C` with 3, checksums of 4 and line feeds; two acknowledgements of 14.
        assert_eq!(first.bytes(), 13 + 10);
        assert!((first.at_least_s(2400) - 51.0 / 240.0).abs() < 1e-9);
        let second = planner.plan(&Request::Mode(Mode::Prowl));
        assert_eq!((second.opening, second.bytes()), (None, 10));
        assert!((second.at_least_s(300) - 24.0 / 30.0).abs() < 1e-9);
        // 100 waypoints of 5 characters, 9 more bytes in each of 7 frames, and `A` in the end.
        let list = planner.plan(&Request::Route(line(100)));
        assert_eq!(list.frames.len(), 8);
        let activate = list.frames.last().unwrap().as_bytes().len();
        assert_eq!(list.bytes(), 500 + 7 * 9 + activate);
    }
}
