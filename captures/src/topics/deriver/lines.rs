//! Messages that follow from a line.

use groundwave_lines::Content;
use groundwave_protocol::decoder::Received;
use groundwave_protocol::status_codes::Drive;
use groundwave_protocol::telemetry::{Ack, Body, StateLine, StatusLine};

use super::Deriver;
use crate::messages::UplinkEvent;
use crate::own_lines::Values;
use crate::topics::geometry::Place;
use crate::topics::log_messages::is_contact;
use crate::topics::{Topic, TopicMessage};

impl Deriver {
    pub(super) fn handle_line<E>(
        &mut self,
        received: &Received,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let now_ns = self.now_ns;
        let robot_ns = self.clock.handle_line(now_ns, received);
        self.encoder.telemetry(received);
        take(self.encoder.message(Topic::Telemetry, now_ns, robot_ns))?;
        self.handle_ack(*received.ack(), take)?;
        let Received::Line(line, _) = received else {
            return Ok(());
        };
        match &line.body {
            Body::State(state) => self.handle_state(state, robot_ns, take)?,
            Body::Status(status) => self.handle_status(status, robot_ns, take)?,
            Body::Counters(counters) => {
                let robot = Some((counters.robot_id, counters.version));
                self.is_new_robot |= self.robot != robot;
                self.robot = robot;
            }
            Body::Text(_) | Body::Parameter(_) | Body::Song(_) | Body::Abilities(_) => {}
            Body::Field(_) | Body::Values(_) => {
                if let Some(Content::Values(samples)) =
                    self.described.take(&line.body).map(|line| line.content)
                {
                    self.encoder.encode(&Values::from(&samples[..]));
                    take(self.encoder.message(Topic::Values, now_ns, robot_ns))?;
                }
            }
        }
        let encoder = &mut self.encoder;
        self.log_messages.handle_line(line, |level, text| {
            encoder.log(now_ns, level, "robot", text);
            take(encoder.message(Topic::Log, now_ns, None))
        })
    }

    /// Writes the robot's acknowledgement if it has changed.
    fn handle_ack<E>(
        &mut self,
        ack: Ack,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let said = (ack.boot, ack.session, ack.sequence, ack.outcome as u8);
        if self.ack.replace(said) == Some(said) {
            return Ok(());
        }
        self.encoder.encode(&UplinkEvent {
            code: Some(ack.outcome.code().to_owned()),
            boot: Some(ack.boot.into()),
            session: Some(ack.session.into()),
            sequence: Some(ack.sequence.into()),
            ..UplinkEvent::new(UplinkEvent::ACKNOWLEDGEMENT)
        });
        take(self.encoder.message(Topic::Uplink, self.now_ns, None))
    }

    fn handle_state<E>(
        &mut self,
        state: &StateLine,
        robot_ns: Option<u64>,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let now_ns = self.now_ns;
        let place = Place::of_robot(state.x_tenths_in, state.y_tenths_in, state.theta_deg);
        if state.drive == Drive::OdometerReset {
            self.path.forget();
            self.scene.forget();
        }
        self.encoder.transforms(now_ns, place);
        take(self.encoder.message(Topic::Tf, now_ns, robot_ns))?;
        self.encoder.pose(now_ns, place);
        take(self.encoder.message(Topic::Pose, now_ns, robot_ns))?;
        self.encoder.scan(now_ns, state);
        take(self.encoder.message(Topic::Sonar, now_ns, robot_ns))?;
        if self.path.handle_place(now_ns, place) {
            self.encoder.encode(&self.path.message(now_ns));
            take(self.encoder.message(Topic::Path, now_ns, robot_ns))?;
        }
        let is_bumped = is_contact(state.bump);
        if is_bumped && !self.was_bumped {
            self.scene.handle_bump(place);
        }
        self.was_bumped = is_bumped;
        self.give_scene(robot_ns, take)
    }

    fn handle_status<E>(
        &mut self,
        status: &StatusLine,
        robot_ns: Option<u64>,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.scene.set_target(status.target_in);
        if self.list_digest.replace(status.digest) != Some(status.digest) {
            self.encoder.encode(&UplinkEvent {
                list_digest: Some(status.digest),
                total: Some(status.list.count.into()),
                ..UplinkEvent::new(UplinkEvent::LIST)
            });
            take(self.encoder.message(Topic::Uplink, self.now_ns, None))?;
        }
        self.give_scene(robot_ns, take)
    }

    pub(super) fn give_scene<E>(
        &mut self,
        robot_ns: Option<u64>,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        if !self.scene.poll(self.now_ns) {
            return Ok(());
        }
        self.encoder.encode(&self.scene.message(self.now_ns));
        take(self.encoder.message(Topic::Markers, self.now_ns, robot_ns))
    }
}
