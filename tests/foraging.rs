//! Robots that forage for themselves, alone and with the ground's help.

use groundwave::event::{Event, GROUND, SuggestionCode, SuggestionStatus};
use groundwave::model::Advise;
use groundwave::request::Request;
use groundwave_protocol::status_codes::Mode;
use sr04_sim::{Pose, SimulationConfig, World};

use crate::advice::Dashboard;
use crate::common::on_all_cores;

/// A robot with its wheels as built that prowls and forages in a generated house. It starts before its dock, facing away from it; `None` if
/// the house has no room there.
fn start(seed: u64, charge: f64, advise: Advise) -> Option<Dashboard> {
    let world = World::generated(seed);
    let place = world.before_dock(7.0)?;
    let start = Pose {
        theta_deg: place.theta_deg + 180.0,
        ..place
    };
    let mut house = SimulationConfig::new(world.started_at(start)?, seed);
    house.conditions.charge = charge;
    let mut robot = Dashboard::of(&house, advise);
    for words in [&["param", "set", "forage", "1"][..], &["mode", "prowl"]] {
        robot.co.deliver(Request::from_words(words).unwrap());
    }
    Some(robot)
}

/// Distance of the robot's own position from the true one, inches.
fn error_in(robot: &Dashboard) -> f64 {
    let truth = robot.co.simulation.truth().pose;
    let state = robot.state.expect("a line A");
    let (x_in, y_in) = (
        f64::from(state.x_tenths_in) / 10.0,
        f64::from(state.y_tenths_in) / 10.0,
    );
    (x_in - truth.x_in).hypot(y_in - truth.y_in)
}

/// Commands that the station sent by itself.
fn unasked(robot: &Dashboard) -> Vec<String> {
    let events = robot.co.events.iter();
    let asked = events.filter_map(|(_, event)| match event {
        Event::Asked { request, by, .. } if by.as_deref() == Some(GROUND) => {
            Some(request.to_string())
        }
        _ => None,
    });
    asked.collect()
}

/// Charge with which a battery is low after three quarters of an hour.
const THIRD: f64 = 0.33;

/// The station sends the robot to its dock while the battery lasts; on the dock, the robot's pose becomes right.
#[test]
fn the_station_sends_a_robot_to_its_dock_while_the_battery_lasts() {
    let runs = on_all_cores(40_103..40_107, |seed| {
        let mut robot = start(seed, THIRD, Advise::Auto)?;
        // Not by chance on the way.
        let docks = |it: &Dashboard| {
            let forages = it.state.is_some_and(|state| state.mode == Mode::Forage);
            forages && it.co.simulation.truth().is_docked
        };
        let docked = robot.run_until(2 * 3600, docks);
        let charge = robot.co.simulation.truth().charge;
        robot.run(60);
        Some((docked, charge, error_in(&robot), unasked(&robot)))
    });
    for run in &runs {
        println!("{run:.2?}");
    }
    let runs: Vec<_> = runs.iter().filter_map(|(_, run)| run.as_ref()).collect();
    let helped = runs.iter().filter(|(docked, charge, error_in, sent)| {
        let was_sent = sent.iter().any(|words| words == "mode dock");
        *docked && *charge > 0.1 && *error_in < 24.0 && was_sent
    });
    assert!(helped.count() >= 2, "{runs:?}");
}

/// An operator who stopped the robot has stopped it for good: a suggestion is all that the station makes.
#[test]
fn a_robot_that_was_stopped_is_not_driven_to_its_dock() {
    let mut robot = start(40_101, THIRD, Advise::Auto).expect("a dock");
    robot.run(25 * 60);
    robot.co.deliver(Request::Stop);
    let sent = unasked(&robot).len();
    robot.suggestions.clear();
    let place = robot.co.simulation.truth().pose;
    let suggests = |it: &Dashboard| {
        let mut begun = it.suggestions.iter();
        begun.any(|it| it.code == SuggestionCode::DockNow && it.status == SuggestionStatus::Begun)
    };
    assert!(robot.run_until(3600, suggests), "{:?}", robot.suggestions);
    robot.run(5 * 60);
    let new = unasked(&robot).split_off(sent);
    assert!(
        new.iter().all(|words| words.starts_with("set-pose")),
        "{new:?}"
    );
    let truth = robot.co.simulation.truth().pose;
    assert!((truth.x_in - place.x_in).hypot(truth.y_in - place.y_in) < 3.0);
    robot.accept();
    let docked = |it: &Dashboard| it.co.simulation.truth().is_docked;
    println!(
        "docked: {}, {:?}",
        robot.run_until(1800, docked),
        unasked(&robot).split_off(sent)
    );
}

/// Hours until the battery is empty, at most 24, and the number of times on the dock.
fn day(seed: u64, advise: Advise) -> Option<(f64, u32)> {
    let mut robot = start(seed, 1.0, advise)?;
    let (mut was_docked, mut dockings) = (false, 0);
    for second in 0..24 * 3600_u32 {
        robot.run(1);
        let truth = robot.co.simulation.truth();
        dockings += u32::from(truth.is_docked && !was_docked);
        was_docked = truth.is_docked;
        if truth.charge <= 0.01 {
            return Some((f64::from(second) / 3600.0, dockings));
        }
    }
    Some((24.0, dockings))
}

/// Prints how many robots lasted for a day, alone and with the ground; houses that were not used for tuning.
#[test]
#[ignore = "takes an hour"]
fn days_in_many_houses() {
    for advise in [Advise::Suggest, Advise::Auto] {
        let days = on_all_cores(62_000..62_012, |seed| day(seed, advise));
        println!("{advise:?}: {days:.1?}");
        let days: Vec<_> = days.iter().filter_map(|(_, day)| *day).collect();
        let full = days.iter().filter(|(hours, _)| *hours >= 24.0).count();
        println!("{advise:?}: never empty {full} of {}", days.len());
    }
}
