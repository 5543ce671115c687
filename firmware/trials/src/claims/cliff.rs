//! The cliff guard.

use crate::arena::{Arena, arena};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, loss, success, value};
use crate::run::{Run, Setup};
use crate::seeds::Rng;
use groundwave_protocol::command::{Drive, Message};
use groundwave_protocol::status_codes::Layer;
use sr04_firmware::board::Edges;
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Pose, Simulation};

pub(super) const ALL: &[&Experiment] = &[&APPROACHES, &BESIDE];

const APPROACHES: Experiment = Experiment {
    name: "cliff",
    trials: [60, 1200],
    run: approaches,
    claims: &[
        Claim {
            part: "cliff",
            says: "approaches to an edge 1 to 6 ft away on the landing: prowling at 4 to 12 in/s without and with \
                   bumpers, manual driving forward and backward in any arc: falls",
            figure: Figure::Share,
            required: Required::AtMost(0.0),
            shortfall: None,
        },
        Claim {
            part: "ablation",
            says: "approaches: cost of switching the cliff guard off",
            figure: Figure::Mean {
                unit: "points",
                digits: 1,
            },
            required: Required::MoreThan(0.0),
            shortfall: None,
        },
        Claim {
            part: "cliff",
            says: "approaches: longest stop until the robot first stands, from the first tick with the edge in the \
                   direction of travel until the robot stands or has not seen the edge for two ticks: at most 1 in",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "cliff",
            says: "the same: mean length",
            figure: Figure::Mean {
                unit: "in",
                digits: 2,
            },
            required: Required::AtMost(1.0),
            shortfall: None,
        },
    ],
};

const HOURS: f64 = 4.0;

const BESIDE: Experiment = Experiment {
    name: "cliff-hours",
    trials: [1, 25],
    run: beside,
    claims: &[Claim {
        part: "cliff",
        says: "4 h of prowling beside the stairs, whole robot on a bench supply: falls per hour",
        figure: Figure::PerHour,
        required: Required::AtMost(0.0),
        shortfall: None,
    }],
};

fn approaches(trial: &Trial) -> Vec<Option<Reading>> {
    let [guarded, unguarded] = [1, 0].map(|guard| approach(trial, guard));
    let stop_in = guarded.and_then(|approach| approach.stop_in);
    let [guarded, unguarded] =
        [guarded, unguarded].map(|approach| approach.map(|approach| approach.fell));
    vec![
        guarded.map(Reading::Success),
        guarded
            .zip(unguarded)
            .and_then(|(guarded, unguarded)| loss(!guarded, !unguarded)),
        stop_in.and_then(|length_in| success(length_in <= STOP_IN)),
        stop_in.and_then(value),
    ]
}

/// Maximum distance of a stop, inches.
const STOP_IN: f64 = 1.0;

/// Result of an approach.
#[derive(Clone, Copy, Debug)]
struct Approach {
    fell: bool,
    /// Longest stop until the robot first stood, inches; `None` if the edge was detected during a turn on the spot or beside the path,
    /// where the robot need not stop.
    stop_in: Option<f64>,
}

/// Observes a robot until it first stands at an edge. A robot that passes an edge in an arc loses sight of it and meets
/// it again; each sighting is a stop of its own.
#[derive(Clone, Copy, Debug, Default)]
struct Stop {
    state: Approaching,
    /// Longest finished stop, inches.
    longest_in: Option<f64>,
}

/// State of an approach.
#[derive(Clone, Copy, Debug, Default)]
enum Approaching {
    #[default]
    Unseen,
    /// Distance driven at first sight, whether the robot drove ahead, and, while the edge is out of sight, for how many
    /// ticks and since which distance.
    Seen {
        path_in: f64,
        ahead: bool,
        unseen: Option<(u32, f64)>,
    },
    Over,
}

impl Stop {
    fn watch(&mut self, simulation: &Simulation) {
        let truth = simulation.truth();
        let seen = simulation.inputs().cliff.unwrap_or_default();
        self.observe(seen, truth.speed_in_s, truth.path_in);
    }

    /// Takes the detected edges, the speed and the distance driven, once per tick.
    fn observe(&mut self, seen: Edges, speed_in_s: f64, now_in: f64) {
        match &mut self.state {
            Approaching::Unseen if seen.any() => {
                let ahead = speed_in_s > 0.0;
                // The arcs are so wide that both wheels turn in the same direction.
                let is_on_the_way = speed_in_s.abs() >= DRIVING_IN_S
                    && if ahead {
                        seen.meets(Edges::FRONT)
                    } else {
                        seen.meets(Edges::REAR)
                    };
                self.state = if is_on_the_way {
                    Approaching::Seen {
                        path_in: now_in,
                        ahead,
                        unseen: None,
                    }
                } else {
                    Approaching::Over
                };
            }
            Approaching::Seen {
                path_in,
                ahead,
                unseen,
            } => {
                let onward_in_s = if *ahead { speed_in_s } else { -speed_in_s };
                *unseen = match *unseen {
                    _ if seen.any() => None,
                    Some((ticks, since_in)) => Some((ticks + 1, since_in)),
                    None => Some((1, now_in)),
                };
                let (end_in, next) = match *unseen {
                    Some((LOST_TICKS, since_in)) => (since_in, Approaching::Unseen),
                    _ if onward_in_s < STANDING_IN_S => (now_in, Approaching::Over),
                    _ => return,
                };
                let length_in = end_in - *path_in;
                self.longest_in = Some(self.longest_in.unwrap_or(0.0).max(length_in));
                self.state = next;
            }
            Approaching::Unseen | Approaching::Over => {}
        }
    }
}

/// Number of ticks without detection after which the edge is out of sight.
const LOST_TICKS: u32 = 2;

/// Speed below which the robot counts as turning on the spot, in/s.
const DRIVING_IN_S: f64 = 1.0;

/// Speed below which the robot stands or reverses, in/s.
const STANDING_IN_S: f64 = 0.1;

/// Result of an approach; `None` if it meets no edge within a minute.
fn approach(trial: &Trial, guard: i16) -> Option<Approach> {
    let stairs = arena("stairs");
    let mut rng = trial.rng();
    let by_hand = trial.index % 3 == 2;
    let backward = by_hand && rng.below(2) == 1;
    let start = before_an_edge(&stairs, &mut rng, backward);
    let top_speed = 4 + rng.below(9) as i16;
    let layers: &[Layer] = match trial.index % 3 {
        0 => &[],
        _ => &[Layer::Bumpers],
    };
    let mut run = Setup::new(trial, stairs.started_at(start))
        .only(layers)
        .with(Parameter::TopSpeed, top_speed)
        .with(Parameter::CliffGuard, guard)
        .start();
    let by_hand = by_hand.then(|| {
        let speed = top_speed as i8;
        (
            if backward { -speed } else { speed },
            rng.below(5) as i8 - 2,
        )
    });
    let (mut count, mut stop) = (0, Stop::default());
    let mut meets = |run: &mut Run, seconds: f64| {
        let mut met = false;
        for tick in 0..(seconds * 20.0) as u32 {
            if let Some((velocity_in_s, rotation_in_s)) = by_hand
                && tick % 5 == 0
            {
                count = u8::wrapping_add(count, 1);
                let heard = run.heard();
                run.send(&Message::Drive(Drive {
                    velocity_in_s,
                    rotation_in_s,
                    heard,
                    count,
                }));
            }
            run.tick();
            stop.watch(&run.simulation);
            let edges = run.simulation.inputs().cliff;
            met |= edges.is_some_and(Edges::any);
            if run.simulation.truth().has_fallen {
                return (true, true);
            }
            if met && by_hand.is_none() && tick % 20 == 19 {
                break;
            }
        }
        (met, false)
    };
    let (met, fell) = meets(&mut run, 60.0);
    if !met {
        return None;
    }
    // Time for the reaction of the robot.
    let fell = fell || meets(&mut run, 10.0).1;
    Some(Approach {
        fell,
        stop_in: stop.longest_in,
    })
}

/// A position with an edge 1 to 6 ft ahead of the nose, or behind the tail, and no obstacle between.
fn before_an_edge(stairs: &Arena, rng: &mut Rng, backward: bool) -> Pose {
    let ahead = if backward { -1.0 } else { 1.0 };
    loop {
        let place = stairs.somewhere(rng);
        let (sin, cos) = place.theta_deg.to_radians().sin_cos();
        let along = |distance_in: f64| Pose {
            x_in: place.x_in + ahead * distance_in * sin,
            y_in: place.y_in + ahead * distance_in * cos,
            ..place
        };
        let has_floor = |at: Pose| stairs.world.has_floor(at.x_in, at.y_in);
        let edge_in = (4..24)
            .map(|step| f64::from(step) * 3.0)
            .find(|&distance_in| {
                let at = along(distance_in);
                !has_floor(at) || !stairs.has_room(at)
            });
        if edge_in.is_some_and(|distance_in| !has_floor(along(distance_in))) {
            return place;
        }
    }
}

fn beside(trial: &Trial) -> Vec<Option<Reading>> {
    let mut setup = Setup::anywhere(trial, "stairs");
    setup.config.conditions.supply_v = Some(12.4);
    let fallen_s = setup
        .start()
        .until(HOURS * 3600.0, |simulation| simulation.truth().has_fallen);
    vec![Some(Reading::Events {
        count: u32::from(fallen_s.is_some()),
        hours: fallen_s.map_or(HOURS, |seconds| seconds / 3600.0),
    })]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Longest stop of a drive with the given detections and speeds per tick.
    fn longest_in(ticks: &[(bool, f64)]) -> Option<f64> {
        let (mut stop, mut now_in) = (Stop::default(), 0.0);
        for &(center, speed_in_s) in ticks {
            let seen = if center { Edges::AHEAD } else { Edges::NONE };
            stop.observe(seen, speed_in_s, now_in);
            now_in += speed_in_s / 20.0;
        }
        stop.longest_in
    }

    #[test]
    fn stop_ends_where_the_robot_stands() {
        let ways = [(false, 10.0), (true, 10.0), (true, 4.0), (true, 0.0)];
        assert_eq!(longest_in(&ways), Some(0.7));
        assert_eq!(longest_in(&ways[..3]), None);
        // Later ticks are ignored.
        let again = [&ways[..], &[(true, 10.0); 40], &[(true, 0.0)]].concat();
        assert_eq!(longest_in(&again), Some(0.7));
    }

    #[test]
    fn stop_ends_where_the_edge_is_lost_and_the_next_is_another() {
        let grazed = [(true, 10.0), (false, 6.0), (false, 10.0), (false, 10.0)];
        let counted_in = longest_in(&grazed).expect("the stop has ended");
        assert!((counted_in - 0.5).abs() < 1e-9, "{counted_in}");
        let stopped = [(true, 10.0), (true, 12.0), (true, 0.0)];
        let counted_in = longest_in(&[&grazed[..], &stopped].concat()).expect("the stop has ended");
        assert!((counted_in - 1.1).abs() < 1e-9, "{counted_in}");
        // A single tick without detection does not end the stop.
        let flickers = [(true, 10.0), (false, 10.0), (true, 10.0), (true, 0.0)];
        let counted_in = longest_in(&flickers).expect("the stop has ended");
        assert!((counted_in - 1.5).abs() < 1e-9, "{counted_in}");
    }

    #[test]
    fn edge_seen_while_turning_on_the_spot_is_not_a_stop() {
        assert_eq!(longest_in(&[(true, 0.5), (true, 10.0), (true, 0.0)]), None);
    }

    #[test]
    fn robot_without_the_guard_falls() {
        use crate::seeds::{Purpose, Seed};
        let falls = (0..12).any(|index| {
            let trial = Trial {
                index: index * 3,
                seed: Seed::nth(Purpose::Tuning, index),
                trace: None,
                traced: std::cell::Cell::new(0),
            };
            approach(&trial, 0).is_some_and(|approach| approach.fell)
        });
        assert!(falls);
    }
}
