//! Alarms: when they are raised, how long they last, and when they end.

use super::*;
use crate::event::{Level, LinkEvent, Recording};
use crate::model::Limits;
use groundwave_protocol::status_codes::{Cliff, Link, Power};
use groundwave_protocol::telemetry::Body;

/// Names of the raised alarms; whether each is active, and acknowledged.
fn raised(scene: &Scene) -> Vec<(&'static str, bool, bool)> {
    let all = scene.model.facts.alarms.all(&scene.model.ui.acknowledged);
    all.filter_map(|(rule, _, raised)| {
        let raised = raised?;
        Some((rule.name, raised.over_at.is_none(), raised.is_acknowledged))
    })
    .collect()
}

fn rings(effects: &[Effect]) -> usize {
    effects
        .iter()
        .filter(|&effect| *effect == Effect::Ring)
        .count()
}

#[test]
fn a_battery_is_low_when_it_has_been_for_a_while_and_until_it_is_well_above() {
    let mut scene = scene();
    let volts = |scene: &mut Scene, dv| {
        scene.status.battery_dv = dv;
        scene.hear_status();
    };
    volts(&mut scene, 115);
    assert_eq!(raised(&scene), [], "a motor that starts");
    volts(&mut scene, 119);
    volts(&mut scene, 116);
    scene.wait_ms(5000);
    volts(&mut scene, 115);
    assert_eq!(raised(&scene), [("battery low", true, false)]);
    volts(&mut scene, 118);
    assert_eq!(raised(&scene), [("battery low", true, false)], "hysteresis");
    volts(&mut scene, 119);
    assert_eq!(
        raised(&scene),
        [("battery low", false, false)],
        "kept until seen"
    );
    scene.type_text(" ");
    assert_eq!(raised(&scene).len(), 1, "STOP acknowledges nothing");
    scene.type_text("A");
    assert_eq!(raised(&scene), []);
}

#[test]
fn the_facts_tell_once_that_an_alarm_is_raised_and_ended() {
    let mut scene = scene();
    let mut told: Vec<Vec<(&str, bool)>> = Vec::new();
    for power in [Power::Ok, Power::Low, Power::Low, Power::Charging] {
        scene.state.power = power;
        scene.hear_line(Body::State(scene.state));
        let changes = scene.model.facts.alarm_changes.iter();
        told.push(
            changes
                .map(|change| (change.rule.code, change.is_active))
                .collect(),
        );
    }
    let expected = [
        vec![],
        vec![("battery_low", true)],
        vec![],
        vec![("battery_low", false)],
    ];
    assert_eq!(told, expected);
}

#[test]
fn acknowledged_active_alarm_stays_in_the_panel_only() {
    let mut scene = scene();
    scene.state.power = Power::Critical;
    scene.hear();
    let both = [
        ("battery critical", true, false),
        ("battery low", true, false),
    ];
    assert_eq!(raised(&scene), both);
    assert_eq!(scene.calling(), 2);
    scene.type_text("A");
    assert_eq!(raised(&scene).len(), 2, "it is still so");
    assert_eq!(scene.calling(), 0);
    scene.state.power = Power::Charging;
    scene.hear();
    assert_eq!(raised(&scene), []);
}

#[test]
fn each_rule_is_raised_by_its_own_cause() {
    type Change = fn(&mut Scene);
    let cases: [(&str, Change); 8] = [
        ("stalled", |scene| scene.state.drive = Drive::Stalled),
        ("fallen or lifted", |scene| {
            scene.state.cliff = Cliff::Several;
        }),
        ("bumper jammed", |scene| scene.state.bump = Bump::Jammed),
        ("failsafe", |scene| scene.state.link = Link::Failsafe),
        ("battery critical", |scene| {
            scene.state.power = Power::Critical;
        }),
        ("lines not intact", |scene| scene.lose(1)),
        ("recording failed", |scene| {
            scene.event(Event::Recording(Recording {
                problem: Some("the disk is full".to_owned()),
                ..Recording::default()
            }));
        }),
        ("link lost", |scene| {
            let reason = "unplugged".to_owned();
            scene.event(Event::Link(LinkEvent::Lost { reason }));
        }),
    ];
    for (name, change) in cases {
        let mut scene = scene();
        change(&mut scene);
        for _ in 0..40 {
            if name == "lines not intact" {
                scene.lose(1);
            }
            scene.hear();
        }
        let names: Vec<_> = raised(&scene).iter().map(|(name, ..)| *name).collect();
        assert!(names.contains(&name), "{name}: {names:?}");
    }
}

#[test]
fn silence_and_thrashing_are_alarms_too() {
    let mut scene = scene();
    scene.type_text("b");
    scene.wait_ms(4900);
    scene.event(Event::Tick);
    assert_eq!(raised(&scene), []);
    let due = scene.redraw_at().expect("ages go on");
    scene.now = due;
    let drawn = scene.model.ui.revision();
    let effects = scene.event(Event::Tick);
    assert_eq!(raised(&scene), [("robot silent", true, false)]);
    assert_eq!(rings(&effects), 1);
    assert_ne!(scene.model.ui.revision(), drawn);
    scene.hear();
    assert_eq!(raised(&scene), [("robot silent", false, false)]);
    scene.type_text("A");
    let before = scene.model.facts.tally().alarms;
    // Sixteen seconds of it, at three lines a second.
    for n in 0..54 {
        let (quiet, holds) = [
            (Layer::Infrared, Layer::Bumpers),
            (Layer::Bumpers, Layer::Infrared),
        ][n % 2];
        scene.layers(&[(quiet, LayerState::Quiet), (holds, LayerState::Holds)]);
        scene.hear();
    }
    assert_eq!(raised(&scene), [("layers thrash", true, false)]);
    assert_eq!(
        scene.model.facts.tally().alarms,
        before + 1,
        "to be jumped to"
    );
}

#[test]
fn one_alarm_rings_once_and_is_logged_once() {
    let mut scene = scene();
    scene.state.drive = Drive::Stalled;
    let mut rung = 0;
    for _ in 0..30 {
        scene.wait_ms(333);
        rung += rings(&scene.event(Event::Tick));
        scene.hear();
    }
    let logged = scene.model.facts.log.newest_first();
    let logged: Vec<_> = logged.filter(|entry| entry.level == Level::Alarm).collect();
    assert_eq!(logged.len(), 1);
    assert!(
        logged[0].text.starts_with("stalled: "),
        "{}",
        logged[0].text
    );
    assert!(rung <= 1);
}

#[test]
fn limits_come_from_the_configuration() {
    let mut scene = Scene::new(Config {
        limits: Limits {
            battery_low_dv: 130,
            battery_for_s: 0,
            ..Limits::default()
        },
        ..Config::default()
    });
    scene.hear_status();
    assert_eq!(raised(&scene), [("battery low", true, false)]);
}

#[test]
fn nothing_is_raised_after_the_session() {
    let mut scene = scene();
    scene.event(Event::Link(LinkEvent::Ended));
    scene.wait_ms(60_000);
    scene.event(Event::Tick);
    assert_eq!(raised(&scene), []);
}
