//! Opens and loses sessions.

use super::{CommandStatus, Failure, Fop, FopEvent, Session, Work};
use crate::command::Key;
use crate::telemetry::{Ack, Detail};

impl Fop {
    pub(super) fn check_session(&mut self, now_us: u64, ack: Ack, latched_us: u64) {
        match &mut self.session {
            Session::None => {}
            Session::Opening {
                boot,
                replaces,
                sent_us,
            } => {
                let ours =
                    matches!(ack.detail, Detail::Idle { owner, .. } if owner == self.config.owner);
                if ack.boot != *boot {
                    // No command is lost yet: open a session in the robot's new life.
                    self.session = Session::None;
                } else if ack.session == *replaces {
                    if sent_us.is_some_and(|ends_us| ends_us <= latched_us) {
                        *sent_us = None;
                    }
                } else if matches!(ack.detail, Detail::Era { .. }) {
                    // The next line shows the owner.
                } else if ack.session == *replaces % 7 + 1
                    && ours
                    && let Some(era) = self.era
                {
                    self.session = Session::Open {
                        boot: ack.boot,
                        number: ack.session,
                        era,
                        key: Key::session(
                            self.robot_id.unwrap_or(0),
                            ack.boot,
                            ack.session,
                            self.config.owner,
                        )
                        .in_era(era),
                    };
                    self.sequence = 0;
                    self.tag = 0;
                    self.drive_count = 0;
                    self.progress_us = now_us;
                    if let Some(Work::List(transfer)) = &mut self.work {
                        self.tag = 1;
                        transfer.restart(1);
                    }
                    self.push(FopEvent::Session(Ok(())));
                } else if ack.is_closed() {
                    // A STOP has closed the session.
                    self.session = Session::None;
                } else {
                    self.lose_session(Failure::TakenOver);
                }
            }
            Session::Open {
                boot, number, era, ..
            } => {
                let shown = match ack.detail {
                    Detail::Era { era } => Some(era),
                    _ => None,
                };
                if ack.boot != *boot {
                    self.lose_session(Failure::RobotRestarted);
                } else if ack.session != *number && shown.is_some() {
                    // The next line shows who ended the session.
                } else if shown.is_some_and(|shown| shown != *era) {
                    self.lose_session(Failure::TakenOver);
                } else if ack.session != *number {
                    self.lose_session(if ack.is_closed() {
                        Failure::Stopped
                    } else {
                        Failure::TakenOver
                    });
                } else if matches!(ack.detail, Detail::Idle { owner, .. } if owner != self.config.owner)
                {
                    self.lose_session(Failure::TakenOver);
                }
            }
        }
    }

    pub(super) fn lose_session(&mut self, failure: Failure) {
        if self.is_open() {
            self.push(FopEvent::Session(Err(failure)));
        }
        self.session = Session::None;
        self.drive = None;
        self.failsafe_silence_us = None;
        self.fail(failure);
    }

    pub(super) fn fail(&mut self, failure: Failure) {
        self.settle_refusal();
        if self.outstanding.take().is_some() {
            // The robot may have received the command, so this session cannot use its sequence again.
            self.session = Session::None;
        }
        if self.work.take().is_some() {
            self.push(FopEvent::Task(CommandStatus::Failed(failure)));
        }
    }
}
