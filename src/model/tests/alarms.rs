//! Alarms: when they are raised, how long they last, and when they end.

mod answers;

use super::*;
use crate::event::{AlarmAnswer, AlarmStatus, Answer, Level, LinkEvent, Recording};
use crate::model::{AlarmSetting, Limits, Operand, Severity};
use groundwave_protocol::status_codes::{Cliff, Link, Power};
use groundwave_protocol::telemetry::Body;

/// Names of the raised alarms, with whether each is active and acknowledged.
fn raised(scene: &Scene) -> Vec<(&str, bool, bool)> {
    let all = scene.model.facts.alarms.all(&scene.model.ui.attended);
    all.filter_map(|shown| {
        let raised = shown.raised?;
        Some((
            &*shown.rule.name,
            raised.over_at.is_none(),
            raised.is_acknowledged,
        ))
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
    let mut told: Vec<Vec<(String, bool)>> = Vec::new();
    for power in [Power::Ok, Power::Low, Power::Low, Power::Charging] {
        scene.state.power = power;
        scene.hear_line(Body::State(scene.state));
        let changes = scene.model.facts.alarm_changes.iter();
        told.push(
            changes
                .map(|change| (change.rule.code.to_string(), change.is_active))
                .collect(),
        );
    }
    let expected = [
        vec![],
        vec![("battery_low".to_owned(), true)],
        vec![],
        vec![("battery_low".to_owned(), false)],
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

/// While the link was lost, the robot could not be heard: its silence counts from the moment the link is open again.
/// What was not read while this station was suspended says nothing about the robot.
#[test]
fn a_suspension_does_not_make_the_robot_silent() {
    for is_suspended in [false, true] {
        let mut scene = scene();
        scene.hear();
        scene.wait_ms(7000);
        if is_suspended {
            scene.event(Event::Suspended(Moment::from_secs(7)));
        }
        scene.event(Event::Recording(Recording::default()));
        let is_silent = raised(&scene)
            .iter()
            .any(|(name, ..)| *name == "robot silent");
        assert_eq!(is_silent, !is_suspended);
    }
}

#[test]
fn a_link_that_is_open_again_does_not_make_the_robot_silent() {
    let mut scene = scene();
    scene.event(Event::Link(LinkEvent::Lost {
        reason: "gone".to_owned(),
    }));
    scene.wait_ms(20_000);
    scene.event(Event::Link(LinkEvent::Opened {
        name: "sim".to_owned(),
        can_send: true,
    }));
    scene.wait_ms(4_000);
    scene.event(Event::Tick);
    let silent = |scene: &Scene| {
        let all = raised(scene);
        all.iter().any(|(name, ..)| *name == "robot silent")
    };
    assert!(!silent(&scene), "{:?}", raised(&scene));
    scene.wait_ms(1_500);
    scene.event(Event::Tick);
    assert!(silent(&scene), "{:?}", raised(&scene));
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
    // Sixteen seconds at three lines per second.
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

/// An alarm of the configuration.
fn setting(name: &str, field: &str) -> AlarmSetting {
    AlarmSetting {
        name: name.to_owned(),
        field: Some(field.to_owned()),
        ..AlarmSetting::default()
    }
}

/// Types a command.
fn say(scene: &mut Scene, command: &str) -> Vec<Effect> {
    scene.type_text(command);
    scene.press(&[KeyCode::Enter])
}

fn scene_with(alarms: Vec<AlarmSetting>) -> Scene {
    Scene::new(Config {
        alarms,
        ..Config::default()
    })
}

#[test]
fn a_limit_on_any_field_raises_an_alarm_after_its_time_and_ends_it_at_its_clear() {
    let mut scene = scene_with(vec![AlarmSetting {
        below: Some(12.0),
        clear: Some(12.5),
        for_s: Some(3.0),
        severity: Some(Severity::Warning),
        ..setting("Weak battery", "battery")
    }]);
    let volts = |scene: &mut Scene, dv| {
        scene.status.battery_dv = dv;
        scene.hear_status();
    };
    volts(&mut scene, 120);
    scene.wait_ms(4000);
    volts(&mut scene, 120);
    assert_eq!(raised(&scene), [], "the limit itself is well");
    volts(&mut scene, 119);
    assert_eq!(raised(&scene), [], "too short");
    scene.wait_ms(3000);
    scene.status.battery_dv = 118;
    scene.hear_line(Body::Status(scene.status));
    assert_eq!(raised(&scene), [("Weak battery", true, false)]);
    let events: Vec<_> = scene.model.facts.alarm_events().collect();
    assert_eq!(events.len(), 1);
    assert_eq!(events[0].code, "weak_battery");
    assert_eq!(events[0].level, Level::Warning);
    assert_eq!(events[0].status, AlarmStatus::Begun);
    assert_eq!((events[0].value, events[0].limit), (Some(11.8), Some(12.0)));
    assert_eq!(events[0].unit, "V");
    volts(&mut scene, 124);
    assert_eq!(raised(&scene), [("Weak battery", true, false)]);
    scene.wait_ms(2000);
    for (answer, status) in [
        (":shelve Weak battery 1m", AlarmStatus::Shelved),
        (":acknowledge Weak battery", AlarmStatus::Acknowledged),
    ] {
        let effects = say(&mut scene, answer);
        let Some(Effect::AnswerAlarm(event)) = effects.first() else {
            panic!("{effects:?}");
        };
        assert_eq!(event.status, status);
        assert_eq!(event.began_at, events[0].began_at, "{answer}");
        assert_eq!((event.value, event.limit), (Some(12.4), Some(12.0)));
    }
    volts(&mut scene, 125);
    assert_eq!(raised(&scene), []);
    let effects = say(&mut scene, ":shelve Weak battery 1m");
    assert!(
        matches!(&effects[..], [Effect::AnswerAlarm(event)] if event.began_at.is_none() && event.value.is_none()),
        "no cause is shown: {effects:?}"
    );
}

#[test]
fn a_field_may_equal_a_word_or_a_number() {
    for (field, equals) in [
        ("mode", Operand::Word("home".to_owned())),
        ("mode", Operand::Word("go_home".to_owned())),
    ] {
        let mut scene = scene_with(vec![AlarmSetting {
            equals: Some(equals),
            ..setting("homeward", field)
        }]);
        scene.hear();
        assert_eq!(raised(&scene), []);
        scene.state.mode = Mode::GoHome;
        scene.hear();
        assert_eq!(raised(&scene), [("homeward", true, false)]);
        scene.state.mode = Mode::Prowl;
        scene.hear();
        assert_eq!(raised(&scene), [("homeward", false, false)]);
    }
}

#[test]
fn built_in_alarms_are_changed_or_switched_off_by_name() {
    let mut scene = scene_with(vec![
        AlarmSetting {
            name: "battery low".to_owned(),
            severity: Some(Severity::Warning),
            hint: Some("have a look".to_owned()),
            ..AlarmSetting::default()
        },
        AlarmSetting {
            name: "battery_critical".to_owned(),
            enabled: false,
            ..AlarmSetting::default()
        },
    ]);
    scene.state.power = Power::Critical;
    scene.hear();
    assert_eq!(raised(&scene), [("battery low", true, false)]);
    let rules = scene.model.facts.alarms.rules();
    let low = rules.iter().find(|rule| rule.code == "battery_low");
    let low = low.expect("it is there");
    assert_eq!((low.level, &*low.hint), (Level::Warning, "have a look"));
    assert_eq!(rules.len(), 12);
}

#[test]
fn the_default_configuration_names_every_built_in_alarm() {
    let text = include_str!("../../commands/config/default.toml");
    let listed = text.split_once("A name of a built-in alarm").unwrap().1;
    for rule in &*crate::model::alarms::rules(&Limits::default(), &[]) {
        assert!(listed.contains(&*rule.code), "{}", rule.code);
    }
}
