//! Handling of lines from the robot.

use super::super::{SESSION_LAST, US_PER_BYTE, session_after};
use super::turn::{PATIENCE_BYTES, Turn};
use super::{
    CommandStatus, Duplex, FORGET_BYTES, Fop, FopEvent, LATCH_TO_END_BYTES, LONG_LINES,
    LONG_LINES_IN_A_ROW, MISMATCHES_MAX, RECEIPT_COUNT_BITS, RECEIPT_COUNT_MAX, STOP_BLIND_US,
    Session, Work, next_tag,
};
use crate::LINE_BYTES;
use crate::command::Order;
use crate::decoder::Received;
use crate::failsafe::Failsafe;
use crate::status_codes::Link;
use crate::telemetry::{ACK_LINE_BYTES, Ack, Body, Detail, Outcome, SEQUENCE_MODULUS};

impl Fop {
    /// Takes the time at which bytes arrived, including noise.
    pub fn handle_carrier(&mut self, now_us: u64) {
        self.carrier.hear(now_us);
    }

    /// Takes an intact line; `arrived_us` is the time at which its last byte was read.
    pub fn handle_received(&mut self, arrived_us: u64, received: &Received) {
        if !self.is_ours(received) || self.is_late(arrived_us, received) {
            return;
        }
        self.judge_downlink(arrived_us, received);
        self.carrier.judge();
        self.heard_us = arrived_us;
        let is_next = received.sequence() == (self.latest_line + 1) % SEQUENCE_MODULUS;
        self.latest_line = received.sequence();
        match received {
            Received::Line(line, _) => {
                self.turn = None;
                self.paused_bytes = 0;
                self.judge_duplex(is_next);
                self.handle_body(&line.body);
            }
            Received::Ack(line) => {
                self.long_lines = 0;
                if line.listens {
                    if let Some(stopping) = &mut self.stopping {
                        stopping.blind_us = arrived_us + STOP_BLIND_US;
                    }
                    self.duplex = Duplex::Half;
                } else if self.duplex == Duplex::Unknown {
                    self.duplex = Duplex::Full;
                }
                self.turn = line.listens.then(|| Turn::begin(arrived_us));
                self.paused_bytes = if line.listens { PATIENCE_BYTES } else { 0 };
                if line.listens {
                    self.carrier.take();
                }
            }
        }
        let latched_us = arrived_us
            .saturating_sub(LATCH_TO_END_BYTES * self.pacer.us_per_byte() + self.config.latency_us);
        self.handle_ack(arrived_us, *received.ack(), latched_us);
    }

    /// Judges at a long line whether the robot takes turns. A robot that does sends a line G after each long line, however the station
    /// is configured.
    fn judge_duplex(&mut self, is_next: bool) {
        let (long_lines, enough) = match self.duplex {
            Duplex::Full => return,
            Duplex::Unknown => (self.long_lines + 1, LONG_LINES),
            Duplex::Half if is_next => (self.long_lines + 1, LONG_LINES_IN_A_ROW),
            Duplex::Half => (1, LONG_LINES_IN_A_ROW),
        };
        self.long_lines = long_lines;
        if long_lines >= enough {
            self.duplex = Duplex::Full;
            self.long_lines = 0;
        }
    }

    /// Judges the downlink. The robot sends without a pause, so bytes missing between two lines were lost.
    fn judge_downlink(&mut self, arrived_us: u64, received: &Received) {
        let intact = match received {
            Received::Line(..) => LINE_BYTES,
            Received::Ack(_) => ACK_LINE_BYTES,
        };
        if self.latest_ack.is_some() {
            let elapsed_us = arrived_us.saturating_sub(self.heard_us);
            // A faster robot pauses between its lines, so their sequences show the loss.
            let all = if self.pacer.us_per_byte() < US_PER_BYTE {
                let ahead = received.sequence() + SEQUENCE_MODULUS - self.latest_line;
                u64::from(ahead % SEQUENCE_MODULUS).max(1) * intact as u64
            } else {
                (elapsed_us / self.pacer.us_per_byte()).saturating_sub(self.paused_bytes)
            };
            let all = all.min(FORGET_BYTES);
            self.downlink.judge(intact as u32, all as u32);
        }
    }

    fn handle_body(&mut self, body: &Body) {
        match body {
            Body::State(state) => {
                self.wants_keepalive = state.link != Link::Ok;
            }
            Body::Counters(counters) => {
                if let Some(failsafe) = counters.failsafe {
                    self.note_failsafe(failsafe);
                }
            }
            Body::Abilities(abilities) => {
                self.abilities = Some(*abilities);
                self.follow_rate();
                self.settle_refusal();
                self.refuse_beyond();
            }
            _ => {}
        }
    }

    /// Keeps the shortest silence, because a line may be older than the order, and an order may be lost.
    pub(super) fn note_failsafe(&mut self, failsafe: Failsafe) {
        let silence_us = u64::from(failsafe.silence_s) * 1_000_000;
        let known_us = self.failsafe_silence_us.unwrap_or(silence_us);
        self.failsafe_silence_us = Some(known_us.min(silence_us));
    }

    /// Whether a line is from the robot of this station; learns the robot's id while nothing is sent to a robot.
    fn is_ours(&mut self, received: &Received) -> bool {
        let Some(robot_id) = received.robot_id() else {
            return true;
        };
        let may_change = self.robot_id.is_none() || !self.holds_robot();
        if self.config.robot_id.is_none() && may_change && self.robot_id != Some(robot_id) {
            // Nothing of the robot before is true of this one.
            if self.robot_id.is_some() {
                self.latest_ack = None;
                self.era = None;
                self.failsafe_silence_us = None;
            }
            self.robot_id = Some(robot_id);
            self.abilities = None;
            self.follow_rate();
        }
        self.robot_id == Some(robot_id)
    }

    /// Recognizes the confirmation of a STOP: its receipt. Only the receipt shows that the robot took a STOP after this station's
    /// request: a late line may contain the state after a STOP and before another station's order.
    fn check_stop(&mut self, ack: Ack) {
        let Some(stopping) = &mut self.stopping else {
            return;
        };
        let receipt = stopping.receipt;
        if ack.detail != (Detail::Stopped { receipt }) || !stopping.has_left {
            return self.check_earlier_stops(ack);
        }
        if stopping.is_renewed {
            stopping.has_left = false;
            stopping.earlier = 0;
        } else {
            self.stopping = None;
        }
        let confirmed = CommandStatus::Confirmed { digest: None };
        self.push(FopEvent::Stop(confirmed));
    }

    /// Recognizes an earlier receipt. It confirms the earlier requests, but not the latest.
    fn check_earlier_stops(&mut self, ack: Ack) {
        let (Some(stopping), Detail::Stopped { receipt }) = (&mut self.stopping, ack.detail) else {
            return;
        };
        let later = stopping.receipt.wrapping_sub(receipt) & RECEIPT_COUNT_MAX;
        let is_ours = receipt >> RECEIPT_COUNT_BITS == stopping.receipt >> RECEIPT_COUNT_BITS;
        if is_ours && (1..=stopping.earlier).contains(&later) {
            stopping.earlier = later - 1;
            self.push(FopEvent::EarlierStop { later });
        }
    }

    /// Takes the era of an acknowledgement, or increments the era when the session numbers restart.
    fn note_era(&mut self, ack: Ack) {
        let before = self.latest_ack.filter(|before| before.boot == ack.boot);
        self.era = match (ack.detail, before) {
            (Detail::Era { era }, _) => Some(era),
            (_, None) => None,
            (_, Some(before)) if ack.session < before.session => {
                self.era.map(|era| session_after(era, SESSION_LAST).0)
            }
            _ => self.era,
        };
    }

    fn handle_ack(&mut self, now_us: u64, ack: Ack, latched_us: u64) {
        self.note_era(ack);
        self.latest_ack = Some(ack);
        if self.is_unheard() {
            return self.refuse_unheard();
        }
        self.check_stop(ack);
        self.check_session(now_us, ack, latched_us);
        let Session::Open { number, .. } = self.session else {
            return;
        };
        if ack.session != number {
            return;
        }
        let mut news = false;
        let has_lists = !matches!(ack.detail, Detail::Era { .. });
        if let Some(Work::List(transfer)) = &mut self.work
            && has_lists
        {
            news = transfer.handle_detail(ack.detail, latched_us);
            if news {
                let (acknowledged, total) = (transfer.acknowledged(), transfer.count());
                self.push(FopEvent::Task(CommandStatus::Progress {
                    acknowledged,
                    total,
                }));
            }
        }
        if let Some(outstanding) = &mut self.outstanding {
            if ack.sequence == outstanding.command.sequence & 7 {
                self.outstanding = None;
                // Only arriving waypoints count as progress: activation may fail repeatedly.
                news |= ack.outcome != Outcome::ListIncomplete;
                self.conclude(now_us, ack.outcome);
            } else if outstanding
                .ends_us
                .is_some_and(|ends_us| ends_us <= latched_us)
            {
                outstanding.ends_us = None;
            }
        }
        if news {
            self.progress_us = now_us;
        }
    }

    fn conclude(&mut self, now_us: u64, outcome: Outcome) {
        match (&mut self.work, outcome) {
            (None, _) | (Some(Work::List(_)), Outcome::ListIncomplete) => {}
            (Some(Work::List(transfer)), Outcome::DigestMismatch)
                if self.mismatches < MISMATCHES_MAX =>
            {
                self.mismatches += 1;
                self.tag = next_tag(self.tag);
                transfer.restart(self.tag);
            }
            (Some(work), Outcome::Done) => {
                let digest = match work {
                    Work::List(transfer) => Some(transfer.digest()),
                    Work::Order(Order::Activate { digest, .. }) => Some(*digest),
                    Work::Order(_) => None,
                };
                self.end(CommandStatus::Confirmed { digest });
            }
            (Some(_), refused) => self.refuse(now_us, refused),
        }
    }
}
