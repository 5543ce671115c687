//! What the facts of a live session report to its recording and to other programs: alarms, suggestions and the ground's estimate.

use groundwave_captures::messages::{CorrectedMessage, EstimateMessage, FloorKind, FloorMessage};
use groundwave_mapping::{CELL_IN, FloorCell, FloorMap};
use groundwave_protocol::telemetry::{Body, Reading as Measured};

use crate::event::{AlarmAnswer, AlarmEvent, AlarmStatus, Answer, Event, Moment};
use crate::model::ground::Statement;
use crate::model::{Facts, JOINED_LATER};

/// Maximum number of acknowledgements that wait for their alarms.
const AHEAD_MAX: usize = 64;

/// Least time between two poses.
const POSE_EVERY: Moment = Moment::from_secs(1);

/// Least time between two floors, and between two equal ones, which a new file of a recording needs.
const FLOOR_EVERY: Moment = Moment::from_mins(1);
const SAME_FLOOR_EVERY: Moment = Moment::from_mins(10);

/// Least time between two reports of an unknown heading.
const UNKNOWN_EVERY: Moment = Moment::from_mins(1);

/// The estimates that were reported last.
#[derive(Debug, Default)]
pub struct Reports {
    /// Acknowledgements of alarms that may begin here until a time.
    ahead: Vec<(AlarmAnswer, Moment)>,
    pose_due: Moment,
    unknown_due: Moment,
    is_unknown: bool,
    floor_due: Moment,
    floor: Option<(Moment, FloorMap)>,
    /// Since when the frame of the floor is the same.
    since: Option<Moment>,
}

impl Reports {
    /// The events that follow from an event which the facts have taken.
    #[must_use]
    pub fn take(&mut self, now: Moment, event: &Event, facts: &Facts) -> Vec<Event> {
        let mut answers = self.acknowledged_ahead(now, facts);
        if let Event::AlarmAnswer(answer) = event {
            let reported = facts.answer_event(answer);
            if reported.is_none() && answer.answer == Answer::Acknowledged {
                self.ahead.truncate(AHEAD_MAX - 1);
                self.ahead.push((answer.clone(), now + JOINED_LATER));
            }
            answers.extend(reported);
        }
        let alarms = facts.alarm_events().chain(answers).map(Event::Alarm);
        let suggestions = facts.suggestion_events().iter().cloned();
        let mut events: Vec<_> = alarms.chain(suggestions.map(Event::Suggestion)).collect();
        if let Event::Line { line, .. } = event
            && matches!(line.body, Body::State(_))
        {
            events.extend(self.pose(now, facts).map(Event::Estimate));
            events.extend(self.floor(now, facts).map(Box::new).map(Event::Floor));
        }
        events
    }

    /// Events of alarms that begin now and were acknowledged in another program before.
    fn acknowledged_ahead(&mut self, now: Moment, facts: &Facts) -> Vec<AlarmEvent> {
        self.ahead.retain(|(_, until)| now <= *until);
        let begun: Vec<String> = facts
            .alarm_events()
            .filter(|alarm| alarm.status == AlarmStatus::Begun)
            .map(|alarm| alarm.code)
            .collect();
        let ahead = self
            .ahead
            .extract_if(.., |(it, _)| begun.contains(&it.alarm));
        ahead
            .filter_map(|(answer, _)| facts.answer_event(&answer))
            .collect()
    }

    /// The pose once a second, or an unknown one once, and at most once a minute.
    fn pose(&mut self, now: Moment, facts: &Facts) -> Option<EstimateMessage> {
        if !facts.robot.measures(Measured::Sonars) {
            return None;
        }
        let state = facts.robot.state?.value;
        let corrected = match facts.ground.statement? {
            Statement::HeadingUnknown | Statement::Lifted => None,
            Statement::Pose(pose) => Some(CorrectedMessage {
                x_in: pose.x_in,
                y_in: pose.y_in,
                theta_deg: pose.theta_deg.value,
                theta_half_deg: pose.theta_deg.half,
                long_in: pose.ellipse.long_in,
                short_in: pose.ellipse.short_in,
                bearing_deg: pose.ellipse.bearing_deg,
            }),
        };
        let is_unknown = corrected.is_none();
        let is_due = if is_unknown {
            !self.is_unknown && now >= self.unknown_due
        } else {
            now >= self.pose_due
        };
        if !is_due {
            return None;
        }
        self.pose_due = now + POSE_EVERY;
        self.is_unknown = is_unknown;
        if is_unknown {
            self.unknown_due = now + UNKNOWN_EVERY;
        }
        Some(EstimateMessage {
            odometer_x_in: f64::from(state.x_tenths_in) / 10.0,
            odometer_y_in: f64::from(state.y_tenths_in) / 10.0,
            odometer_theta_deg: f64::from(state.theta_deg),
            corrected,
        })
    }

    fn floor(&mut self, now: Moment, facts: &Facts) -> Option<FloorMessage> {
        let since = facts.ground.since();
        if std::mem::replace(&mut self.since, since) != since {
            self.floor_due = now;
            // The floor before is in another frame.
            if self.floor.take().is_some() {
                return FloorMessage::new((0.0, 0.0), CELL_IN, 1, [FloorKind::Unknown]);
            }
        }
        if now < self.floor_due {
            return None;
        }
        let map = facts.ground.floor_map()?;
        self.floor_due = now + FLOOR_EVERY;
        let is_told = self
            .floor
            .as_ref()
            .is_some_and(|(at, last)| *last == map && now.saturating_sub(*at) < SAME_FLOOR_EVERY);
        if is_told {
            return None;
        }
        let cells = map.cells.iter().map(|cell| match cell {
            FloorCell::Unknown => FloorKind::Unknown,
            FloorCell::Free => FloorKind::Free,
            FloorCell::Obstacle => FloorKind::Obstacle,
            FloorCell::Drop => FloorKind::Drop,
        });
        let floor = FloorMessage::new(map.corner_in, CELL_IN, map.columns, cells);
        self.floor = Some((now, map));
        floor
    }
}
