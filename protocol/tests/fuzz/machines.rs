//! Both ends of delivery under steps taken from arbitrary bytes.

use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{Action, CommandStatus, Config, Farm, Fop, FopEvent, Task};
use groundwave_protocol::command::{Command, Key, Message, Open, Order, RECEIPT_MAX};
use groundwave_protocol::decoder::Received;
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::telemetry::{Ack, AckLine, Detail, Outcome};

const ROBOT_ID: u8 = 7;
const OWNER: u16 = 0x2A5;

/// Reads an input; after its end, reads zeros.
struct Input<'a>(&'a [u8]);

impl Input<'_> {
    fn byte(&mut self) -> u8 {
        match self.0.split_first() {
            Some((first, rest)) => {
                self.0 = rest;
                *first
            }
            None => 0,
        }
    }

    fn word(&mut self) -> u16 {
        u16::from_be_bytes([self.byte(), self.byte()])
    }
}

/// Frames with the robot's own key, because others would fail the checksum; the input gives type and content.
pub fn farm(input: &[u8]) {
    let mut input = Input(input);
    let mut farm = Farm::new(ROBOT_ID, u16::from(input.byte()));
    let mut receiver = Receiver::default();
    while !input.0.is_empty() {
        let before = farm.clone();
        let message = message(&mut input, &farm);
        let key = if message.is_sessionless() {
            Key::robot(ROBOT_ID)
        } else {
            farm.key().unwrap_or(Key::EVERY_ROBOT)
        };
        for &byte in message.encode(key).as_bytes() {
            let Some(heard) = receiver.handle_byte(byte, ROBOT_ID, farm.key()) else {
                continue;
            };
            match farm.handle(&heard) {
                Action::Stop => assert!(!farm.is_open(), "STOP ends the session"),
                Action::Execute(_) => {
                    assert!(before.is_open());
                    assert_ne!(farm.ack().sequence, before.ack().sequence);
                    farm.conclude(Outcome::ALL[usize::from(input.byte() & 7)]);
                    let again = farm.handle(&heard);
                    assert_eq!(again, Action::Heard, "no command executes twice");
                }
                Action::ListReplaced => assert_eq!(farm.ack().outcome, Outcome::Done),
                Action::Drive(_) | Action::Heard => {
                    let same = farm.lists().active() == before.lists().active();
                    assert!(same, "a list was replaced without an action");
                }
            }
            assert_eq!(Ack::decode(farm.ack().encode()), Some(farm.ack()));
        }
    }
}

fn message(input: &mut Input, farm: &Farm) -> Message {
    let ack = farm.ack();
    let kind = input.byte();
    if kind < 32 {
        return Message::Stop((kind > 0).then(|| input.word() & RECEIPT_MAX));
    }
    if kind < 96 {
        return Message::Open(Open {
            boot: ack.boot ^ u8::from(kind & 1 == 1),
            replaces: ack.session,
            owner: input.word() & 0x3FF | 1,
            era: match farm.ack_in(1).detail {
                Detail::Era { era } if kind & 2 == 0 => Some(era ^ u16::from(kind >> 2 & 1)),
                _ => None,
            },
        });
    }
    let length = usize::from(input.byte() % 84).min(input.0.len());
    let (said, rest) = input.0.split_at(length);
    input.0 = rest;
    // By chance, one sequence in 64 fits.
    let sequence = ack.sequence.wrapping_add(kind & 3);
    let content = [&[b"CWDL"[usize::from(kind) % 4]], said].concat();
    match Message::parse(&content) {
        Some(Message::Command(command)) => Message::Command(Command {
            sequence,
            ..command
        }),
        Some(message) => message,
        None => Message::Command(Command {
            sequence,
            order: Order::Scan,
        }),
    }
}

/// Any acknowledgement and any user action may come at any time: each result follows from the latest line, or from an earlier refusal
/// that a line I could have explained, and timeouts are in the future.
pub fn fop(input: &[u8]) {
    let mut input = Input(input);
    let mut fop = Fop::new(Config::new(OWNER));
    let mut now_us = 0;
    let mut sequence = 0;
    let mut unexplained = Vec::new();
    while !input.0.is_empty() {
        let mut line = None;
        match input.byte() % 8 {
            0..=2 => {
                sequence = (sequence + input.byte() % 4) % 100;
                let ack = ack(&mut input);
                line = Some(ack);
                if matches!(ack.outcome, Outcome::Unknown | Outcome::BadValue) {
                    unexplained.push(ack.outcome);
                }
                fop.handle_received(now_us, &Received::Ack(ack_line(sequence, ack)));
            }
            3 => {
                let theta_deg = input.word();
                let position = Waypoint::default();
                fop.start(
                    now_us,
                    Task::Order(Order::Pose {
                        position,
                        theta_deg,
                    }),
                );
            }
            4 => {
                let list = [Waypoint { x_in: 1, y_in: 2 }; 40];
                let count = usize::from(input.byte()) % list.len();
                fop.start(now_us, Task::List(&list[..count]));
            }
            5 => now_us += u64::from(input.word()) << (input.byte() % 10),
            6 => fop.drive(
                now_us,
                input.byte() as i8,
                input.byte() as i8,
                now_us + 300_000,
            ),
            _ if input.byte() < 128 => fop.stop(now_us),
            _ => fop.cancel(),
        }
        check_events(&mut fop, line, &mut unexplained);
        now_us = run(&mut fop, now_us);
        check_events(&mut fop, None, &mut unexplained);
    }
}

/// An acknowledgement line.
fn ack_line(sequence: u8, ack: Ack) -> AckLine {
    AckLine {
        sequence,
        ack,
        listens: false,
    }
}

/// An acknowledgement near that of a robot in a session, because random ones would never open a session.
fn ack(input: &mut Input) -> Ack {
    let (a, b) = (input.byte(), input.byte());
    let detail = match a >> 6 {
        0 if b >> 6 == 1 => Detail::Era {
            era: input.byte().into(),
        },
        1 if b >> 5 == 1 => Detail::CannotHear { robot_id: ROBOT_ID },
        1 if b >> 6 == 1 => Detail::Stopped {
            receipt: OWNER << 5 | 1,
        },
        0 => Detail::Staging {
            first_missing: input.byte() & 0x7F,
            tag: b & 3,
            window: input.byte(),
        },
        1 => Detail::Idle {
            owner: 0,
            robot_id: ROBOT_ID,
        },
        2 => Detail::Idle {
            owner: OWNER,
            robot_id: ROBOT_ID,
        },
        _ => Detail::Idle {
            owner: input.word() & 0x3FF,
            robot_id: b & 0x7F,
        },
    };
    Ack {
        boot: a & 1,
        session: a >> 1 & 7,
        sequence: b & 7,
        outcome: Outcome::ALL[usize::from(b >> 3 & 7)],
        detail,
    }
}

/// `unexplained` has the refusals since the end of the previous task that may take effect later than their line.
fn check_events(fop: &mut Fop, line: Option<Ack>, unexplained: &mut Vec<Outcome>) {
    while let Some(event) = fop.poll_event() {
        let is_end = matches!(&event, FopEvent::Task(status) if status.is_end());
        match event {
            FopEvent::Task(CommandStatus::Confirmed { .. }) => {
                assert_eq!(line.map(|ack| ack.outcome), Some(Outcome::Done), "made up");
            }
            FopEvent::Task(CommandStatus::Refused(outcome)) => {
                let now = line.is_some_and(|ack| ack.outcome == outcome);
                assert!(now || unexplained.contains(&outcome), "made up");
            }
            FopEvent::Session(Ok(())) => {
                let ours = |ack: Ack| matches!(ack.detail, Detail::Idle { owner: OWNER, .. });
                assert!(line.is_some_and(ours), "a session that is not ours");
            }
            FopEvent::Stop(CommandStatus::Confirmed { .. }) => {
                assert!(line.is_some(), "confirmed without a line");
            }
            _ => {}
        }
        if is_end {
            unexplained.clear();
        }
    }
}

/// Polls like a caller through two timeouts; returns the time afterwards.
fn run(fop: &mut Fop, mut now_us: u64) -> u64 {
    let mut standing = 0;
    for _ in 0..16 {
        fop.handle_timeout(now_us);
        let mut bytes = 0;
        while let Some(chunk) = fop.poll_transmit(now_us) {
            assert!(!chunk.is_empty());
            bytes += chunk.len();
            assert!(bytes <= 17, "more than the wire takes now");
        }
        match fop.poll_timeout() {
            Some(at_us) if at_us <= now_us => standing += 1,
            Some(at_us) if at_us < now_us + 50_000 => {
                standing = 0;
                now_us = at_us;
            }
            _ => return now_us,
        }
        assert!(
            standing < 3,
            "asks to be called again at once, for ever: {now_us} {fop:?}"
        );
    }
    now_us
}
