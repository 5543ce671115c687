//! Floor that a prowling robot has seen and never visited: alone, by the operator's acceptance, and with `--advise=auto`.

use std::collections::BTreeSet;

use groundwave::event::{Event, SuggestionCode, SuggestionStatus};
use groundwave::model::Advise;
use groundwave::request::Request;
use groundwave_protocol::status_codes::Mode;
use sr04_sim::{SimulationConfig, World};

use crate::advice::Dashboard;
use crate::common::on_all_cores;

/// The station suggests a visit to floor that the robot has only seen. The operator accepts it, and the robot drives where it has not been
/// before.
#[test]
fn suggested_visit_leads_where_the_robot_has_not_been() {
    let runs = on_all_cores(20_400..20_406, |seed| {
        let mut robot = Dashboard::new(World::generated(seed), seed, 0.0, Advise::Suggest);
        let mut path = Vec::new();
        for _ in 0..40 * 60 {
            robot.run(1);
            let truth = robot.co.simulation.truth().pose;
            path.push((truth.x_in, truth.y_in));
            let newest = robot.suggestions.last();
            let newest = newest.filter(|it| it.status == SuggestionStatus::Begun);
            if newest.is_some_and(|it| it.code == SuggestionCode::Unvisited) {
                break;
            }
        }
        let suggestion = robot.suggestions.pop()?;
        robot.accept();
        robot.run(10);
        let mut new_in: f64 = 0.0;
        for _ in 0..10 * 60 {
            robot.run(1);
            let far_in = path.iter().map(|place| robot.distance_in(*place));
            new_in = new_in.max(far_in.fold(f64::MAX, f64::min));
            if robot.has_stopped() {
                return Some((true, new_in, suggestion.to_string()));
            }
        }
        Some((false, new_in, suggestion.to_string()))
    });
    for run in &runs {
        println!("{run:?}");
    }
    let runs = runs.iter().filter_map(|(_, run)| run.as_ref());
    let visits = runs.filter(|(arrived, new_in, _)| *arrived && *new_in > 20.0);
    assert!(visits.count() >= 3);
}

/// With `--advise=auto`, the station sends a prowling robot to floor that it has only seen, and lets it prowl on from there.
#[test]
fn the_station_sends_a_prowling_robot_where_it_has_not_been() {
    let runs = on_all_cores(20_400..20_406, |seed| {
        let mut robot = Dashboard::new(World::generated(seed), seed, 0.0, Advise::Auto);
        robot.run(45 * 60);
        let ways = robot.suggestions.iter().filter(|it| {
            let is_detour = matches!(it.code, SuggestionCode::Held | SuggestionCode::Unvisited);
            is_detour && it.status == SuggestionStatus::Accepted
        });
        let events = robot.co.events.iter();
        let prowls = events.filter(|(_, event)| {
            matches!(event, Event::Asked { request: Request::Mode(Mode::Prowl), by, .. } if by.is_some())
        });
        let counts = (ways.count(), prowls.count());
        let prowled_on = robot.run_until(6 * 60, |it| {
            it.state.is_some_and(|state| state.mode == Mode::Prowl)
        });
        (counts, prowled_on)
    });
    for run in &runs {
        println!("{run:?}");
    }
    let sum = |of: fn(&(usize, usize)) -> usize| -> usize {
        runs.iter().map(|(_, (counts, _))| of(counts)).sum()
    };
    assert!(sum(|it| it.0) >= 3 && sum(|it| it.1) >= 2);
    assert!(runs.iter().all(|(_, (_, prowled_on))| *prowled_on));
}

/// A square foot of floor.
type Square = (i32, i32);

/// Distance between looks at the floor, and the least clearance of the robot's middle, inches.
const STEP_IN: i32 = 3;
const CLEAR_IN: f64 = 6.0;

fn square(x_in: f64, y_in: f64) -> Square {
    let foot = |inches: f64| (inches / 12.0).floor() as i32;
    (foot(x_in), foot(y_in))
}

/// The squares that the middle of a robot can reach from the origin.
fn reachable(world: &World) -> BTreeSet<Square> {
    let place = |(column, row): (i32, i32)| (f64::from(column * STEP_IN), f64::from(row * STEP_IN));
    let mut seen = BTreeSet::from([(0, 0)]);
    let mut open = vec![(0, 0)];
    let mut squares = BTreeSet::new();
    while let Some((column, row)) = open.pop() {
        let (x_in, y_in) = place((column, row));
        squares.insert(square(x_in, y_in));
        for next in [
            (column + 1, row),
            (column - 1, row),
            (column, row + 1),
            (column, row - 1),
        ] {
            let (x_in, y_in) = place(next);
            if world.clearance_in(x_in, y_in) >= CLEAR_IN
                && world.has_floor(x_in, y_in)
                && seen.insert(next)
            {
                open.push(next);
            }
        }
    }
    squares
}

/// Share of the reachable floor on which the middle of a robot has been in 8 h on a bench supply, percent.
fn covered_pct(seed: u64, advise: Advise) -> f64 {
    let world = World::generated(seed);
    let reachable = reachable(&world);
    let mut house = SimulationConfig::new(world, seed);
    house.conditions.supply_v = Some(12.4);
    let mut robot = Dashboard::of(&house, advise);
    let mut visited = BTreeSet::new();
    for _ in 0..8 * 3600 {
        robot.run(1);
        let truth = robot.co.simulation.truth().pose;
        visited.insert(square(truth.x_in, truth.y_in));
    }
    100.0 * visited.intersection(&reachable).count() as f64 / reachable.len() as f64
}

/// The figures of docs/acceptance.md; houses that were not used for tuning.
#[test]
#[ignore = "takes half an hour"]
fn floor_of_many_houses() {
    for advise in [Advise::Suggest, Advise::Auto] {
        let mut shares = on_all_cores(63_000..63_012, |seed| covered_pct(seed, advise));
        println!("{advise:?}: {shares:.0?}");
        shares.sort_by(|(_, one), (_, other)| one.total_cmp(other));
        let (worst, median) = (shares[0].1, f64::midpoint(shares[5].1, shares[6].1));
        println!("{advise:?}: floor covered {median:.0} %, worst {worst:.0} %");
    }
}
