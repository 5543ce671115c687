//! Layer 7: the list of points.

use super::{success, value};
use crate::arena::{arena, seen_from};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial};
use crate::run::{Setup, believed, distance_in};
use groundwave_protocol::Waypoint;
use groundwave_protocol::letters::Mode;
use sr04_sim::Pose;

pub(super) const ALL: &[&Experiment] = &[&ROUTE];

const POINTS: usize = 4;
const LIMIT_S: f64 = 600.0;

const ROUTE: Experiment = Experiment {
    name: "route",
    trials: [20, 300],
    run: route,
    claims: &[
        Claim {
            part: "7 Dead reckoning",
            says: "4 points anywhere in the cluttered living room, whole robot: the last one believed reached, \
                   within 6 in, in 10 min",
            figure: Figure::Share,
            required: Required::AtLeast(95.0),
            shortfall: Some("not looked into yet"),
        },
        Claim {
            part: "7 Dead reckoning",
            says: "the same, when it has arrived: where it then really is from the last point",
            figure: Figure::Mean {
                unit: "in",
                digits: 1,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

fn route(trial: &Trial) -> Vec<Option<Reading>> {
    let room = arena("living-room");
    let mut dice = trial.dice();
    let start = room.somewhere(&mut dice);
    let points: Vec<Waypoint> = (0..POINTS)
        .map(|_| {
            let point = seen_from(start, room.somewhere(&mut dice));
            Waypoint {
                x_in: point.x_in.round() as i16,
                y_in: point.y_in.round() as i16,
            }
        })
        .collect();
    let last = points.last().map_or(Pose::default(), |point| Pose {
        x_in: point.x_in.into(),
        y_in: point.y_in.into(),
        theta_deg: 0.0,
    });
    let mut run = Setup::new(trial, room.started_at(start))
        .calibrated()
        .start();
    run.route(&points);
    let ended = run.until(LIMIT_S, |simulation| {
        simulation.robot().mode() == Mode::Stop
    });
    // Odometry goes on while the robot comes to rest: half an inch.
    let arrived = ended.is_some()
        && usize::from(run.simulation.robot().driven()) == POINTS
        && distance_in(believed(&run.simulation), last) <= 6.5;
    let off = arrived.then(|| distance_in(run.pose(), last));
    vec![success(arrived), off.and_then(value)]
}
