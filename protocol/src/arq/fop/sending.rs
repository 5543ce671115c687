//! Chooses the next frame.

use super::turn::Turn;
use super::{
    ALIVE_PERIOD_US, CommandStatus, DRIVE_PERIOD_US, Duplex, Fop, FopEvent, KEEPALIVES_PER_SILENCE,
    KNOCK_PERIOD_US, Outstanding, RECEIPT_COUNT_MAX, SEQUENCE_LAST, STOP_BLIND_US, STOP_PERIOD_US,
    Session, TAG_LAST, Work,
};
use crate::command::{
    BLOCK_WAYPOINTS, Command, Drive, Frame, Keepalive, Key, Message, Open, Order,
};
use crate::failsafe::SILENCE_MIN_S;

/// Room for any frame except a waypoint frame, bytes; waypoint frames are cut to the available room.
const ROOM_MIN: u64 = 29;

impl Fop {
    /// Bytes to send to the radio now. Call until `None` is returned.
    pub fn poll_transmit(&mut self, now_us: u64) -> Option<&[u8]> {
        if self.pacer.is_idle() && !self.is_unheard() {
            self.take_silence(now_us);
            let room = self.room(now_us);
            if room < ROOM_MIN {
                self.end_turn(now_us);
            } else if let Some((message, key)) = self.next_frame(now_us, room) {
                let frame = message.encode(key);
                let length = frame.as_bytes().len() as u64;
                let ends_us = self.pacer.begin(now_us, frame);
                if let Some(turn) = &mut self.turn {
                    turn.take(length, ends_us);
                    self.paused_bytes += length;
                }
                self.spoke_us = ends_us;
                self.note_sent(&message, ends_us);
            } else if self.must_knock() && now_us >= self.knock_us {
                self.pacer.begin(now_us, Frame::knock());
                self.knock_us = now_us + KNOCK_PERIOD_US;
            } else {
                self.end_turn(now_us);
            }
        }
        self.pacer.poll(now_us)
    }

    /// Ends the turn if frames were sent in it or its time is over.
    fn end_turn(&mut self, now_us: u64) {
        if self.turn.is_some_and(Turn::is_used) {
            self.turn = None;
            self.pacer.begin(now_us, Frame::over());
        } else if self.turn.is_some_and(|turn| turn.room(now_us) == 0) {
            self.turn = None;
        }
    }

    /// Number of bytes that may be sent without a pause; unlimited in full duplex.
    fn room(&self, now_us: u64) -> u64 {
        if !self.is_half_duplex() {
            return u64::MAX;
        }
        let blind = self
            .stopping
            .is_some_and(|stopping| now_us >= stopping.blind_us);
        match self.turn {
            Some(turn) => turn.room(now_us),
            None if blind => ROOM_MIN,
            None => 0,
        }
    }

    /// Time at which the robot's silence means that it listens; `None` if there is nothing to send.
    pub(super) fn silent_at_us(&self) -> Option<u64> {
        let is_wanted = self.work.is_some() || self.drive.is_some() || self.stopping.is_some();
        let is_useful = is_wanted && self.is_half_duplex() && self.turn.is_none();
        self.carrier.silent_at_us().filter(|_| is_useful)
    }

    fn take_silence(&mut self, now_us: u64) {
        if self.silent_at_us().is_some_and(|at_us| now_us >= at_us) {
            self.turn = self.carrier.take().map(Turn::begin);
        }
    }

    /// Time at which the next keepalive is due, microseconds; `None` if the robot needs none.
    pub(super) fn keepalive_us(&self) -> Option<u64> {
        let silence_us = self
            .failsafe_silence_us
            .unwrap_or(u64::from(SILENCE_MIN_S) * 1_000_000);
        (self.wants_keepalive && self.is_open())
            .then(|| self.spoke_us + silence_us / KEEPALIVES_PER_SILENCE)
    }

    /// Whether there is a task or hand drive, but id, session or duplex of the robot are unknown.
    pub(super) fn must_knock(&self) -> bool {
        !self.is_half_duplex()
            && (self.work.is_some() || self.drive.is_some())
            && (self.latest_ack.is_none()
                || self.robot_id.is_none()
                || self.era.is_none()
                || self.duplex == Duplex::Unknown)
    }

    /// The next message, most urgent first.
    fn next_frame(&mut self, now_us: u64, room: u64) -> Option<(Message, Key)> {
        if let Some(mut stopping) = self.stopping {
            if now_us < stopping.next_us {
                return None;
            }
            if stopping.is_renewed {
                stopping.receipt = self.next_receipt();
                stopping.is_renewed = false;
                let earlier = stopping.earlier + u16::from(stopping.has_left);
                stopping.earlier = earlier.min(RECEIPT_COUNT_MAX);
                stopping.has_left = false;
                self.stopping = Some(stopping);
            }
            let key = self.robot_id.map_or(Key::EVERY_ROBOT, Key::robot);
            return Some((Message::Stop(Some(stopping.receipt)), key));
        }
        let wants_drive = self
            .drive
            .is_some_and(|drive| now_us >= drive.next_us.min(drive.until_us));
        let wants_keepalive = self.keepalive_us().is_some_and(|at| now_us >= at);
        if self.work.is_none() && !wants_drive && !wants_keepalive {
            return None;
        }
        if self.is_used_up() {
            self.session = Session::None;
        }
        match self.session {
            Session::None => {
                let ack = self.latest_ack?;
                self.robot_id?;
                self.era?;
                if self.duplex == Duplex::Unknown {
                    return None;
                }
                self.session = Session::Opening {
                    boot: ack.boot,
                    replaces: ack.session,
                    sent_us: None,
                };
                self.next_frame(now_us, room)
            }
            Session::Opening {
                boot,
                replaces,
                sent_us: None,
            } => {
                let open = Open {
                    boot,
                    replaces,
                    owner: self.config.owner,
                    era: Some(self.era?),
                };
                Some((Message::Open(open), Key::robot(self.robot_id?)))
            }
            Session::Opening { .. } => None,
            Session::Open { key, .. } => {
                let heard = self.latest_line;
                let keepalive = Message::Keepalive(Keepalive { heard });
                let message = if wants_drive && now_us >= self.alive_us {
                    self.alive_us = now_us + ALIVE_PERIOD_US;
                    Some(keepalive)
                } else if wants_drive {
                    self.next_drive(now_us)
                } else {
                    self.next_of_work(room)
                };
                message
                    .or(wants_keepalive.then_some(keepalive))
                    .map(|message| (message, key))
            }
        }
    }

    /// Whether another command or list would repeat the number of an earlier one of the session.
    fn is_used_up(&self) -> bool {
        self.is_open()
            && self.outstanding.is_none()
            && (self.sequence == SEQUENCE_LAST || self.tag > TAG_LAST)
    }

    fn next_drive(&mut self, now_us: u64) -> Option<Message> {
        let drive = self.drive.as_mut()?;
        drive.next_us = now_us + DRIVE_PERIOD_US;
        let mut speeds = (drive.velocity_in_s, drive.rotation_in_s);
        if now_us >= drive.until_us {
            self.drive = None;
            speeds = (0, 0);
        }
        self.drive_count = (self.drive_count + 1) & 0xF;
        Some(Message::Drive(Drive {
            velocity_in_s: speeds.0,
            rotation_in_s: speeds.1,
            heard: self.latest_line,
            count: self.drive_count,
        }))
    }

    fn next_of_work(&mut self, room: u64) -> Option<Message> {
        let order = match self.work.as_ref()? {
            Work::List(transfer) => {
                if let Some(slots) = transfer.next(room) {
                    return Some(Message::Waypoints(slots));
                }
                Order::Activate {
                    tag: transfer.tag(),
                    count: transfer.count(),
                    digest: transfer.digest(),
                }
            }
            Work::Order(order) => *order,
        };
        match self.outstanding {
            None => Some(Message::Command(Command {
                sequence: (self.sequence + 1) & 0x3F,
                order,
            })),
            Some(Outstanding {
                command,
                ends_us: None,
            }) => Some(Message::Command(command)),
            Some(outstanding) => self.repeat(outstanding),
        }
    }

    /// Uses the idle uplink to repeat the frame that has waited longest for its acknowledgement.
    fn repeat(&self, outstanding: Outstanding) -> Option<Message> {
        let (oldest_us, is_lossy) = match &self.work {
            Some(Work::List(transfer)) => (transfer.oldest_us(), transfer.is_lossy()),
            _ => (None, self.downlink.frame_blocks() == 1),
        };
        // Repeating delays a half-duplex robot's acknowledgements, so it is useful only if many frames are lost.
        let is_kept = self
            .turn
            .is_some_and(|turn| !is_lossy || !turn.may_repeat());
        if is_kept || !is_lossy && oldest_us.is_none() {
            return None;
        }
        match (&self.work, oldest_us) {
            (Some(Work::List(transfer)), Some(oldest_us))
                if outstanding
                    .ends_us
                    .is_some_and(|ends_us| ends_us >= oldest_us) =>
            {
                transfer.repeat().map(Message::Waypoints)
            }
            _ => Some(Message::Command(outstanding.command)),
        }
    }

    fn note_sent(&mut self, message: &Message, ends_us: u64) {
        match message {
            Message::Stop(_) => {
                if let Some(stopping) = &mut self.stopping {
                    stopping.next_us = ends_us + STOP_PERIOD_US;
                    stopping.blind_us = ends_us + STOP_BLIND_US;
                    if !core::mem::replace(&mut stopping.has_left, true) {
                        self.push(FopEvent::Stop(CommandStatus::Sent { frames: 1 }));
                    }
                }
                return;
            }
            Message::Open(_) => {
                if let Session::Opening { sent_us, .. } = &mut self.session {
                    *sent_us = Some(ends_us);
                }
            }
            Message::Command(command) => {
                if let Order::Failsafe(Some(failsafe)) = command.order {
                    self.note_failsafe(failsafe);
                }
                self.sequence = command.sequence;
                self.outstanding = Some(Outstanding {
                    command: *command,
                    ends_us: Some(ends_us),
                });
            }
            Message::Waypoints(slots) => {
                if let Some(Work::List(transfer)) = &mut self.work {
                    let first = usize::from(slots.first_block);
                    let blocks = slots.waypoints().len().div_ceil(BLOCK_WAYPOINTS);
                    transfer.sent(first..first + blocks, ends_us);
                }
            }
            Message::Drive(_) | Message::Keepalive(_) => return,
        }
        if self.work.is_some() {
            self.frames += 1;
            self.push(FopEvent::Task(CommandStatus::Sent {
                frames: self.frames,
            }));
        }
    }
}
