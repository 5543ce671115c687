//! The alarm of a blind infrared detector, for the real robot program in generated houses.

use std::sync::Arc;
use std::time::Duration;

use groundwave::event::{AlarmStatus, Event};
use groundwave::model::{Config, Facts};
use groundwave_protocol::status_codes::Infrared;
use groundwave_protocol::telemetry::Body;
use sr04_sim::{SimulationConfig, World};

use crate::common::{lines, on_all_cores, seeds};

/// Codes of the alarms that a robot raises while it prowls, and the time until then; its left detector may be dead in its lines.
fn alarms(seed: u64, hours: u64, is_left_dead: bool) -> Vec<(String, Duration)> {
    let config = SimulationConfig::new(World::generated(seed), seed);
    let mut facts = Facts::new(Arc::new(Config::default()));
    let mut begun = Vec::new();
    lines(
        &config,
        Duration::from_hours(hours),
        |now, mut line, raw| {
            if let Body::State(state) = &mut line.body
                && is_left_dead
            {
                state.infrared = match state.infrared {
                    Infrared::Left => Infrared::None,
                    Infrared::Both => Infrared::Right,
                    other => other,
                };
            }
            let line = Box::new(line);
            facts.update(now, &Event::Line { line, raw });
            let alarms = facts.alarm_events();
            let new = alarms.filter(|alarm| alarm.status == AlarmStatus::Begun);
            begun.extend(new.map(|alarm| (alarm.code, now)));
        },
    );
    begun
}

fn is_blind((code, _): &(String, Duration)) -> bool {
    code.ends_with("_side_blind")
}

/// The robot itself still sees with its left detector, so it touches less on that side than a blind one.
#[test]
fn dead_infrared_detector_is_named() {
    let mut alarms = alarms(8, 1, true);
    alarms.retain(is_blind);
    assert!(!alarms.is_empty());
    let is_left = |(code, _): &(String, Duration)| code == "left_side_blind";
    assert!(alarms.iter().all(is_left), "{alarms:?}");
}

#[test]
fn working_infrared_detectors_are_not_called_blind() {
    on_all_cores(seeds(2), |seed| {
        let alarms = alarms(seed, 2, false);
        assert_eq!(alarms.iter().find(|it| is_blind(it)), None, "seed {seed}");
    });
}
