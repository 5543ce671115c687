//! A robot with lines of its own.

use groundwave_lines::{Profile, Recognizer};
use groundwave_protocol::telemetry::{
    AbilitiesLine, Body, FieldLine, ParameterName, Printable, ValuesLine,
};

use super::*;
use crate::event::Moment;
use std::sync::Arc;

/// Ten lines a second that a recognizer reads.
fn speaking(mut recognizer: Recognizer, line: impl Fn(u32) -> String) -> Scene {
    let mut scene = Scene::new(Config::default());
    for n in 0..100 {
        scene.now += Moment::from_millis(100);
        let bytes = line(n);
        for run in bytes.as_bytes().split_inclusive(|byte| *byte == b'\n') {
            if let Some(line) = recognizer.take(run, false) {
                scene.event(Event::Own(line));
            }
        }
    }
    scene
}

fn guessed() -> Scene {
    speaking(Recognizer::default(), |n| {
        format!("temp:{},volt=11.9V,mode:auto\r\n", f64::from(n % 20) / 2.0)
    })
}

#[test]
fn unknown_fields_are_listed_and_plotted() {
    let mut scene = guessed();
    for (width, height) in [(80, 24), (120, 40), (200, 60)] {
        let text = screen(&scene, width, height);
        for shown in [
            "F9 fields",
            "temp             9.5",
            "volt             11.9 V",
            "auto",
            "10.0/s",
        ] {
            assert!(text.contains(shown), "{shown}\n{text}");
        }
        for empty in [
            "who holds the motors",
            "F5 commands",
            "sensors",
            "map",
            "WEAK",
            "loss ",
            "m modes",
            "w add",
        ] {
            assert!(!text.contains(empty), "{empty}\n{text}");
        }
        row(&text, "temp:9.5,volt=11.9V,mode:auto");
    }
    insta::assert_snapshot!("own_fields", screen(&scene, 120, 40));
    let config = Arc::make_mut(&mut scene.model.ui.config);
    config.own_commands = vec!["stop".to_owned()];
    row(&screen(&scene, 120, 40), "F5 commands");
    scene.press(&[KeyCode::Down, KeyCode::Enter]);
    let large = screen(&scene, 120, 40);
    assert!(!large.contains("F6 log"), "{large}");
    row(&large, "── volt V ");
    scene.press(&[KeyCode::F(2)]);
    row(
        &screen(&scene, 120, 40),
        "nothing from this robot for panel sensors",
    );
    scene.now += Moment::from_secs(9);
    row(&screen(&scene, 120, 40), "SILENT for 9 s");
}

#[test]
fn roles_draw_the_map() {
    let profile = Profile {
        form: groundwave_lines::Form::Csv,
        fields: serde_json::from_str(
            r#"[{"name":"x","unit":"cm","role":"x"},{"name":"y","unit":"cm","role":"y"},{"name":"h","unit":"deg","role":"heading"},
                {"name":"batt","unit":"mV","role":"battery"},{"name":"mode","role":"mode"},{"name":"bump","role":"bump"}]"#,
        )
        .unwrap(),
        ..Profile::default()
    };
    let mut scene = speaking(Recognizer::new(&profile).unwrap(), |n| {
        let bump = u8::from(n > 50);
        format!(
            "{},{},90,{},auto,{bump}\n",
            f64::from(n) * 2.54,
            -25.4,
            12_000 - n
        )
    });
    let text = screen(&scene, 120, 40);
    row(&text, "map: x +99 y -10 in, 90 deg");
    row(&text, "11.9 V");
    row(&text, "▶");
    row(&text, "bumper hit at (56, -10)");
    row(&text, "the robot reports mode auto");
    insta::assert_snapshot!("own_map", text);
    scene.state.mode = Mode::Prowl;
    scene.hear();
    let both = screen(&scene, 120, 40);
    row(&both, "who holds the motors");
    row(&both, "F9 fields");
}

/// A robot of level 3 without battery, wheel and sonar readings, and with a field of its own.
#[test]
fn line_i_hides_the_readings_that_the_robot_lacks() {
    let mut scene = flight(Config::default());
    assert!(screen(&scene, 120, 40).contains(" V"));
    scene.hear_line(Body::Abilities(AbilitiesLine {
        robot_id: 7,
        level: 3,
        capacity: 40,
        measured: 0,
        fields: 1,
        ..AbilitiesLine::FULL
    }));
    scene.hear_line(Body::Field(FieldLine {
        place: 1,
        count: 1,
        name: ParameterName::new("motor-current"),
        decimals: 2,
        unit: Printable::new("A"),
    }));
    scene.hear_line(Body::Values(ValuesLine::new([Some(125)])));
    scene.hear();
    scene.press(&[KeyCode::F(2)]);
    let sensors = screen(&scene, 200, 60);
    for absent in ["sonar ", "battery ", " of +"] {
        assert!(!sensors.contains(absent), "{absent}\n{sensors}");
    }
    row(&sensors, "requested");
    scene.press(&[KeyCode::F(9)]);
    row(&screen(&scene, 120, 40), "motor-current    1.25 A");
}

#[test]
fn a_battery_of_zero_volts_is_none() {
    let mut scene = flight(Config::default());
    scene.status.battery_dv = 0;
    for _ in 0..60 {
        scene.hear();
        scene.hear_status();
    }
    let text = screen(&scene, 200, 60);
    assert!(!text.contains("0.0 V"), "{text}");
}
