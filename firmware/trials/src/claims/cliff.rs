//! The cliff guard.

use super::{loss, success, value};
use crate::arena::{Arena, arena};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial};
use crate::run::{Run, Setup};
use crate::seeds::Dice;
use groundwave_protocol::command::{Drive, Message};
use groundwave_protocol::letters::Layer;
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
                   bumpers, by hand forward and backward in any bow; falls",
            figure: Figure::Share,
            required: Required::AtMost(0.0),
            shortfall: None,
        },
        Claim {
            part: "ablation",
            says: "approaches: what switching the cliff guard off costs",
            figure: Figure::Mean {
                unit: "points",
                digits: 1,
            },
            required: Required::MoreThan(0.0),
            shortfall: None,
        },
        Claim {
            part: "cliff",
            says: "approaches: from the tick that first sees the edge before the robot to where it stands, at most \
                   1 in",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: Some(
                "in one of a thousand, by hand in a bow, the edge is grazed and out of sight before the wheels stand; the hand drives on, and the way to its second stop is counted with the first",
            ),
        },
        Claim {
            part: "cliff",
            says: "the same: how far that is",
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
        says: "4 h of prowling beside the stairs, whole robot on a bench supply: falls an hour",
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
        stop_in.and_then(|way_in| success(way_in <= STOP_IN)),
        stop_in.and_then(value),
    ]
}

/// It stops within this.
const STOP_IN: f64 = 1.0;

/// How an approach ends.
#[derive(Clone, Copy, Debug)]
struct Approach {
    fell: bool,
    /// Way from the tick that first saw an edge to where the robot first stood; `None` when the edge was seen
    /// as it turned on the spot, or beside its way, which need not stop it.
    stop_in: Option<f64>,
}

/// Follows a robot from the tick that first sees an edge until it stands.
#[derive(Clone, Copy, Debug, Default)]
enum Stop {
    #[default]
    Before,
    /// What the way was then, and whether the robot was going ahead.
    Seen {
        path_in: f64,
        ahead: bool,
    },
    After(Option<f64>),
}

impl Stop {
    fn watch(self, simulation: &Simulation) -> Self {
        let truth = simulation.truth();
        match self {
            Self::Before => {
                let (edges, ahead) = (simulation.inputs().cliff, truth.speed_in_s > 0.0);
                // Its bows are so wide that both wheels go the same way.
                let is_on_the_way = edges.is_some_and(|edges| {
                    truth.speed_in_s.abs() >= DRIVING_IN_S
                        && if ahead {
                            edges.left || edges.center || edges.right
                        } else {
                            edges.rear
                        }
                });
                match edges.is_some_and(Edges::any) {
                    true if is_on_the_way => Self::Seen {
                        path_in: truth.path_in,
                        ahead,
                    },
                    true => Self::After(None),
                    false => self,
                }
            }
            Self::Seen { path_in, ahead } => {
                let onward_in_s = if ahead {
                    truth.speed_in_s
                } else {
                    -truth.speed_in_s
                };
                if onward_in_s < STANDING_IN_S {
                    Self::After(Some(truth.path_in - path_in))
                } else {
                    self
                }
            }
            Self::After(_) => self,
        }
    }
}

/// Slower than this it turns on the spot.
const DRIVING_IN_S: f64 = 1.0;

/// Slower than this it stands, or goes back.
const STANDING_IN_S: f64 = 0.1;

/// How it ends; `None` when it meets no edge within a minute.
fn approach(trial: &Trial, guard: i16) -> Option<Approach> {
    let stairs = arena("stairs");
    let mut dice = trial.dice();
    let by_hand = trial.index % 3 == 2;
    let backward = by_hand && dice.below(2) == 1;
    let start = before_an_edge(&stairs, &mut dice, backward);
    let top_speed = 4 + dice.below(9) as i16;
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
            dice.below(5) as i8 - 2,
        )
    });
    let (mut count, mut stop) = (0, Stop::default());
    let mut meets = |run: &mut Run, seconds: f64| {
        let mut met = false;
        for tick in 0..(seconds * 20.0) as u32 {
            if let Some((velocity_in_s, rotation_in_s)) = by_hand
                && tick % 5 == 0
            {
                count += 1;
                let heard = run.heard();
                run.send(&Message::Drive(Drive {
                    velocity_in_s,
                    rotation_in_s,
                    heard,
                    count,
                }));
            }
            run.tick();
            stop = stop.watch(&run.simulation);
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
    // And some time for what it does next.
    let fell = fell || meets(&mut run, 10.0).1;
    let stop_in = match stop {
        Stop::After(way_in) => way_in,
        Stop::Before | Stop::Seen { .. } => None,
    };
    Some(Approach { fell, stop_in })
}

/// A place with an edge 1 to 6 ft ahead of the nose, or behind the tail, and nothing between.
fn before_an_edge(stairs: &Arena, dice: &mut Dice, backward: bool) -> Pose {
    let ahead = if backward { -1.0 } else { 1.0 };
    loop {
        let place = stairs.somewhere(dice);
        let (sin, cos) = place.theta_deg.to_radians().sin_cos();
        let along = |way_in: f64| Pose {
            x_in: place.x_in + ahead * way_in * sin,
            y_in: place.y_in + ahead * way_in * cos,
            ..place
        };
        let has_floor = |at: Pose| stairs.world.has_floor(at.x_in, at.y_in);
        let edge_in = (4..24).map(|step| f64::from(step) * 3.0).find(|&way_in| {
            let at = along(way_in);
            !has_floor(at) || !stairs.has_room(at)
        });
        if edge_in.is_some_and(|way_in| !has_floor(along(way_in))) {
            return place;
        }
    }
}

fn beside(trial: &Trial) -> Vec<Option<Reading>> {
    let stairs = arena("stairs");
    let start = stairs.somewhere(&mut trial.dice());
    let mut setup = Setup::new(trial, stairs.started_at(start));
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

    #[test]
    fn without_the_guard_it_falls() {
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
