//! The alarm of a blind infrared detector, for the real robot program in generated houses.

use std::sync::Arc;
use std::time::Duration;

use groundwave::event::{AlarmStatus, Event};
use groundwave::model::{Config, Facts};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::status_codes::Infrared;
use groundwave_protocol::telemetry::Body;
use sr04_sim::{Simulation, SimulationConfig, World};

use crate::common::{on_all_cores, seeds};

const HOUR_MS: u64 = 3_600_000;

/// Codes of the alarms that a robot raises while it prowls, and the time until then; its left detector may be dead in its lines.
fn alarms(seed: u64, hours: u64, is_left_dead: bool) -> Vec<(String, Duration)> {
    let config = SimulationConfig::new(World::generated(seed), seed);
    let mut simulation = Simulation::new(&config);
    let (mut decoder, mut facts) = (Decoder::default(), Facts::new(Arc::new(Config::default())));
    let mut begun = Vec::new();
    for ms in 0..hours * HOUR_MS {
        simulation.step();
        let now = Duration::from_millis(ms);
        while let Some(byte) = simulation.poll_downlink() {
            for received in decoder.lines(&[byte]) {
                let Received::Line(mut line, raw) = received else {
                    continue;
                };
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
                let alarms = facts.alarm_events(now);
                let new = alarms.filter(|alarm| alarm.status == AlarmStatus::Begun);
                begun.extend(new.map(|alarm| (alarm.code, now)));
            }
        }
    }
    begun
}

/// The robot itself still sees with its left detector, so it touches less on that side than a blind one.
#[test]
fn dead_infrared_detector_is_named() {
    let alarms = alarms(2, 1, true);
    let blind: Vec<_> = alarms.iter().map(|(code, _)| code.as_str()).collect();
    assert_eq!(blind, ["left_side_blind"], "{alarms:?}");
}

#[test]
fn working_infrared_detectors_are_not_called_blind() {
    on_all_cores(seeds(2), |seed| {
        let alarms = alarms(seed, 2, false);
        let blind = alarms.iter().find(|(code, _)| code.ends_with("_blind"));
        assert_eq!(blind, None, "seed {seed}");
    });
}
