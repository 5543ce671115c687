//! When the robot's pose, its wheels and a scan are suggested.

use groundwave_mapping::{Compass, CorrectedPose};
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::{ParameterName, StateLine};

use super::Suggestion;
use crate::event::{Figure, SuggestionCode};
use crate::model::chart::Pose;
use crate::model::reported_parameters::Parameters;
use crate::model::robot::Robot;
use crate::request::{Amount, Request, Tuning};

/// Multiple of a 95 % interval from which a value is clearly outside.
const CLEARLY: f64 = 1.5;

/// Minimum errors worth a command: degrees, inches, and difference of the wheels as a share of their diameter.
const HEADING_LEAST_DEG: f64 = 5.0;
const POSITION_LEAST_IN: f64 = 6.0;
const WHEELS_LEAST: f64 = 0.002;

/// The wheels for which the heading would not drift, if they differ clearly from the robot's.
pub(super) fn set_wheels(compass: &Compass, parameters: &Parameters) -> Option<Suggestion> {
    let wheels = compass.wheels()?;
    let difference = compass.wheel_difference();
    if difference.value.abs() < (CLEARLY * difference.half).max(WHEELS_LEAST) {
        return None;
    }
    let set = |name: &str, value_in: f64| {
        let known = parameters
            .heard()
            .iter()
            .find(|line| line.name.as_str() == name)?;
        let value = (value_in * 1000.0).round() as i32;
        let name = ParameterName::new(name);
        (known.least..=known.most)
            .contains(&value)
            .then_some(Request::Parameter(Tuning::Set(name, Amount::Counts(value))))
    };
    Some(Suggestion {
        code: SuggestionCode::WheelsDiffer,
        requests: vec![
            set("wheel-left", wheels.left_in)?,
            set("wheel-right", wheels.right_in)?,
        ],
        target_in: None,
        figures: vec![Figure {
            code: "wheels".to_owned(),
            value: 100.0 * difference.value,
            half: Some(100.0 * difference.half),
            unit: "%".to_owned(),
        }],
    })
}

/// Errors of the robot's own pose.
struct Off {
    moved_in: f64,
    turned_deg: f64,
}

/// The errors of the robot's pose if it is clearly outside of the estimate's intervals.
fn clearly_off(state: &StateLine, pose: &CorrectedPose) -> Option<Off> {
    let believed = Pose::of(state);
    let (x_in, y_in) = (believed.x_in - pose.x_in, believed.y_in - pose.y_in);
    let turned_deg = believed.theta_deg - pose.theta_deg.value;
    let turned_deg = ((turned_deg + 540.0).rem_euclid(360.0) - 180.0).abs();
    let moved_in = x_in.hypot(y_in);
    let is_turned = turned_deg >= HEADING_LEAST_DEG.max(CLEARLY * pose.theta_deg.half);
    let is_moved = moved_in >= POSITION_LEAST_IN && pose.ellipse.multiple((x_in, y_in)) >= CLEARLY;
    (is_turned || is_moved).then_some(Off {
        moved_in,
        turned_deg,
    })
}

/// Whether the robot's own pose is clearly outside of the estimate's intervals.
pub(super) fn is_clearly_off(state: &StateLine, pose: &CorrectedPose) -> bool {
    clearly_off(state, pose).is_some()
}

/// The estimated pose, if the robot's is clearly outside its intervals.
pub(super) fn set_pose(state: &StateLine, pose: &CorrectedPose) -> Option<Suggestion> {
    if state.mode == Mode::Calibrate {
        return None;
    }
    let Off {
        moved_in,
        turned_deg,
    } = clearly_off(state, pose)?;
    let figure = |code: &str, value, half, unit: &str| Figure {
        code: code.to_owned(),
        value,
        half: Some(half),
        unit: unit.to_owned(),
    };
    Some(Suggestion {
        code: SuggestionCode::PoseOff,
        requests: vec![Request::Pose {
            position: Waypoint::new(pose.x_in.round() as i16, pose.y_in.round() as i16)?,
            theta_deg: pose.theta_deg.value.round().rem_euclid(360.0) as u16,
        }],
        target_in: None,
        figures: vec![
            figure("position", moved_in, pose.ellipse.long_in, "in"),
            figure("heading", turned_deg, pose.theta_deg.half, "deg"),
        ],
    })
}

/// A scan, if the robot can scan in its mode.
pub(super) fn scan(robot: &Robot) -> Option<Suggestion> {
    let stays = matches!(
        robot.mode()?,
        Mode::Stop | Mode::User | Mode::Passive | Mode::Calibrate
    );
    (robot.turns_on_request() && !stays).then(|| Suggestion {
        code: SuggestionCode::HeadingUnknown,
        requests: vec![Request::Scan],
        target_in: None,
        figures: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use groundwave_mapping::{Ellipse, Interval};

    use super::*;
    use crate::event::SuggestionStatus;

    #[test]
    fn pose_must_be_clearly_outside_its_intervals() {
        for (x_in, theta_deg, half_deg, suggested) in [
            // The ellipse is 8 in long along X.
            (0.0, 0.0, 4.0, None),
            (0.0, 5.9, 4.0, None),
            (0.0, 6.1, 4.0, Some("set-pose 0 0 6")),
            (0.0, 353.8, 4.0, Some("set-pose 0 0 354")),
            (0.0, 4.9, 1.0, None),
            (0.0, 359.6, 4.0, None),
            (-11.9, 0.0, 4.0, None),
            (-12.4, 0.0, 4.0, Some("set-pose -12 0 0")),
            (14.0, 359.8, 4.0, Some("set-pose 14 0 0")),
            // Beyond the waypoints that the protocol has.
            (20_000.0, 0.0, 4.0, None),
        ] {
            let pose = CorrectedPose {
                x_in,
                y_in: 0.0,
                theta_deg: Interval {
                    value: theta_deg,
                    half: half_deg,
                },
                ellipse: Ellipse {
                    long_in: 8.0,
                    short_in: 4.0,
                    bearing_deg: 90.0,
                },
            };
            let suggestion = set_pose(&StateLine::BLANK, &pose);
            let words = suggestion.map(|it| it.requests[0].to_string());
            let what = format!("x {x_in}, {theta_deg} within {half_deg}");
            assert_eq!(words.as_deref(), suggested, "{what}");
        }
    }

    #[test]
    fn reason_is_in_figures() {
        let pose = CorrectedPose {
            x_in: -12.4,
            y_in: 0.0,
            theta_deg: Interval {
                value: 353.0,
                half: 4.0,
            },
            ellipse: Ellipse {
                long_in: 8.0,
                short_in: 4.0,
                bearing_deg: 90.0,
            },
        };
        let suggestion = set_pose(&StateLine::BLANK, &pose).expect("a suggestion");
        assert_eq!(
            suggestion.event(SuggestionStatus::Begun).to_string(),
            "suggestion begun: set-pose -12 0 353 (position off by 12.4 +-8.0 in, heading off by 7.0 +-4.0 deg)"
        );
    }
}
