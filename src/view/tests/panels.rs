//! Alarms, plots, the robot from above, and a silent robot.

use groundwave_protocol::decoder::Lost;
use groundwave_protocol::status_codes::{Arm, Cliff, Power};
use groundwave_protocol::telemetry::HOLDERS;

use ratatui::style::{Color, Modifier};

use super::*;
use crate::event::{Moment, OutageCause};
use crate::model::Panel;
use crate::model::keys::{Action, Context, Keymap};
use crate::outages::Outage;

const SIZES: [(u16, u16); 3] = [(80, 24), (120, 40), (200, 60)];

fn mono() -> Config {
    Config {
        colors: Colors::Mono,
        ascii: true,
        ..Config::default()
    }
}

/// A robot with every sensor triggered.
fn busy(config: Config) -> Scene {
    let mut scene = flight(config);
    scene.state.bump = Bump::LeftCenter;
    scene.state.infrared = Infrared::Right;
    scene.state.sonar_left_in = Some(22);
    scene.state.sonar_right_in = Some(47);
    scene.state.cliff = Cliff::Right;
    scene.state.arm = Arm::MotionLeft;
    scene.hear();
    scene
}

#[test]
fn every_panel_has_a_key_and_a_place() {
    let key = |panel| Keymap::default().label(Context::Dashboard, Action::Show(panel));
    let mut scene = flight(Config::default());
    let offered = || {
        Panel::ALL
            .into_iter()
            .filter(|panel| *panel != Panel::Fields)
    };
    let all = screen(&scene, 200, 60);
    for row in Keymap::default().rows() {
        if let Action::Show(panel) = row.action {
            assert!(Panel::ALL.contains(&panel), "{panel:?}");
        }
    }
    for panel in offered() {
        let title = format!("── {} ", key(panel));
        assert!(all.contains(&title), "{panel:?}\n{all}");
        let number = key(panel).trim_start_matches('F').parse().unwrap();
        if scene.model.ui.panel != panel {
            scene.press(&[KeyCode::F(number)]);
        }
        for (width, height) in [(80, 24), (120, 40)] {
            let chosen = screen(&scene, width, height);
            assert!(chosen.contains(&title), "{panel:?}\n{chosen}");
        }
    }
    let tabs = screen(&scene, 80, 24);
    for panel in offered() {
        row(&tabs, &format!("{} {}", key(panel), panel.name()));
    }
}

#[test]
fn an_alarm_shows_on_every_screen_until_acknowledged() {
    let mut scene = flight(Config::default());
    scene.state.power = Power::Low;
    scene.hear();
    for (width, height) in SIZES {
        let screen = screen(&scene, width, height);
        let strip = screen.lines().nth(1).unwrap();
        assert!(strip.starts_with("✖ BATTERY LOW"), "{strip}");
        assert!(strip.ends_with("A: acknowledge"), "{strip}");
    }
    scene.press(&[KeyCode::F(8)]);
    let panel = screen(&scene, 80, 24);
    insta::assert_snapshot!("alarm_narrow", panel);
    row(&panel, "── F8 alarms");
    scene.type_text("z");
    let large = screen(&scene, 80, 24);
    insta::assert_snapshot!("alarms_enlarged", large);
    row(&large, "Send it home (m h) and charge it");
    row(&large, "· battery critical");
    row(&large, "(limit 11.2 V)");
    scene.type_text("A");
    let seen = screen(&scene, 80, 24);
    assert!(
        seen.lines().nth(1).unwrap().starts_with("── F8 alarms"),
        "{seen}"
    );
    row(&seen, "✔ BATTERY LOW");
    row(&seen, ", acknowledged");
}

#[test]
fn a_quiet_rule_shows_the_age_of_its_line() {
    let alarms = |scene: &mut Scene| {
        scene.press(&[KeyCode::F(8)]);
        scene.type_text("z");
        screen(scene, 80, 24)
    };
    let unknown = alarms(&mut Scene::new(Config::default()));
    row(&unknown, "· stalled          unknown");
    row(&unknown, "· robot silent     unknown");
    row(&unknown, "· lines not intact unknown");
    let mut scene = flight(Config::default());
    let fresh = alarms(&mut scene);
    row(&fresh, "· battery low      12.4 V (limit 11.6 V)");
    row(&fresh, "· stalled          quiet");
    scene.wait_ms(30_000);
    let old = screen(&scene, 80, 24);
    row(&old, "· battery low      ◌ 12.4 V (limit 11.6 V)");
    row(&old, "· stalled          ◌ quiet");
}

#[test]
fn a_wide_status_row_has_a_running_clock() {
    let config = Config {
        unix: Some(Moment::from_secs(86_400 * 20_000 + 9 * 3600 + 59 * 60 + 50)),
        ..Config::default()
    };
    let mut scene = flight(config);
    let clock = |scene: &Scene, width| {
        let now = scene.now.as_secs() + 9 * 3600 + 59 * 60 + 50;
        let clock = format!("{:02}:{:02}Z  PROWL", now / 3600, now / 60 % 60);
        screen(scene, width, 40)
            .lines()
            .next()
            .unwrap()
            .contains(&clock)
    };
    assert!(clock(&scene, 120) && !clock(&scene, 80));
    // Also on a silent link, at exactly this second.
    scene.wait_ms(200_000);
    for _ in 0..10 {
        let at = scene.redraw_at().unwrap();
        scene.now = at;
        if (at.as_secs() + 50).is_multiple_of(60) {
            break;
        }
    }
    assert!(
        (scene.now.as_secs() + 50).is_multiple_of(60),
        "{:?}",
        scene.now
    );
    assert!(screen(&scene, 120, 40).contains("Z  ◌ PROWL"));
}

#[test]
fn without_color_an_alarm_has_its_shape() {
    let mut scene = flight(mono());
    scene.state.power = Power::Critical;
    scene.hear();
    scene.press(&[KeyCode::F(8)]);
    let screen = screen(&scene, 120, 40);
    assert!(screen.is_ascii(), "{screen}");
    insta::assert_snapshot!("alarms_ascii", screen);
    row(&screen, "X BATTERY CRITICAL");
    row(&screen, "+1 more  A: acknowledge");
}

#[test]
fn the_robot_from_above_highlights_triggered_sensors() {
    for (config, name) in [(Config::default(), "above"), (mono(), "above_ascii")] {
        let mut scene = busy(config);
        scene.press(&[KeyCode::F(3)]);
        let narrow = screen(&scene, 80, 24);
        insta::assert_snapshot!(format!("{name}_narrow"), narrow);
        let wide = screen(&scene, 120, 40);
        insta::assert_snapshot!(format!("{name}_wide"), wide);
        for screen in [&narrow, &wide] {
            row(screen, "22 in !");
            row(screen, "EDGE");
            row(screen, "motion left");
            row(screen, "61 %");
        }
    }
    let scene = busy(Config::default());
    let wide = screen(&scene, 120, 40);
    assert!(!wide.contains("from above"));
}

#[test]
fn every_panel_has_a_place_on_a_large_screen() {
    let mut scene = busy(Config::default());
    scene.hear_status();
    let screen = screen(&scene, 200, 60);
    insta::assert_snapshot!("large", screen);
    for title in [
        "map",
        "who holds",
        "F2 sensors",
        "F3 from above",
        "F4 plots",
        "F5 commands",
        "F6 log",
        "F7 link",
        "F8 alarms",
        "raw",
    ] {
        row(&screen, &format!("── {title}"));
    }
}

#[test]
fn plots_have_gaps_in_silence() {
    let mut scene = flight(Config::default());
    scene.wait_ms(12_000);
    scene.drive(30, 3.0, 2);
    scene.hear_status();
    scene.press(&[KeyCode::F(4)]);
    let narrow = screen(&scene, 80, 24);
    insta::assert_snapshot!("plots_narrow", narrow);
    row(&narrow, "── F4 plots");
    row(&narrow, "T: 1 min");
    row(&narrow, "wheels in/s");
    scene.type_text("z");
    let large = screen(&scene, 120, 40);
    insta::assert_snapshot!("plots_enlarged", large);
    for name in [
        "wheels in/s",
        "sonar in",
        "darkness %",
        "battery V",
        "loss %",
    ] {
        row(&large, name);
    }
    scene.type_text("T");
    row(&screen(&scene, 120, 40), "T: 10 min");
    let mut ascii = flight(mono());
    ascii.drive(30, 3.0, 2);
    ascii.press(&[KeyCode::F(4)]);
    assert!(screen(&ascii, 80, 24).is_ascii());
}

/// Plots shade outages as `info` lists them: from the last line to the next one, or to now while an outage lasts.
#[test]
fn outages_are_shaded_in_plots() {
    let mut scene = flight(mono());
    scene.press(&[KeyCode::F(4)]);
    scene.type_text("z");
    // The limits of an alarm are drawn the same way, in separate rows.
    let shaded = |scene: &Scene| {
        let shown = screen(scene, 120, 40);
        let row = row(&shown, "wheels in/s").to_owned();
        row.matches(':').count()
    };
    assert_eq!(shaded(&scene), 0);
    let begin = scene.now;
    let outage = |end| {
        Event::Outage(Outage {
            cause: OutageCause::Silent,
            begin,
            end,
            lost: Lost::default(),
        })
    };
    scene.wait_ms(6_000);
    scene.event(outage(None));
    let lasting = shaded(&scene);
    assert!(lasting > 5, "{lasting}");
    scene.wait_ms(6_000);
    let longer = shaded(&scene);
    assert!(longer > lasting, "{longer} after {lasting}");
    scene.drive(1, 3.0, 2);
    let end = scene.now;
    scene.drive(3, 3.0, 2);
    let ended = shaded(&scene);
    assert!(ended.abs_diff(longer) <= 2, "{ended} after {longer}");
    scene.event(outage(Some(end)));
    assert_eq!(shaded(&scene), ended, "its lines are known now");
}

#[test]
fn stale_values_are_dim_marked_and_named() {
    let mut scene = flight(demo());
    scene.hear();
    scene.wait_ms(12_000);
    scene.event(Event::Tick);
    let silent = screen(&scene, 120, 40);
    row(&silent, "◌ PROWL  ◌ 12.4 V");
    row(&silent, "map: ◌ x ");
    row(&silent, "◌ stale: sensors, battery");
    row(&silent, "link: totals; airtime over 20 s ──────");
    row(&silent, "✖ ROBOT SILENT");
    for name in ["bumper", "infrared", "wheels", "battery", "drive"] {
        let aged = |row: &str| row.contains(&format!("{name:<9}")) && row.contains('◌');
        assert!(silent.lines().any(aged), "{name}");
    }
}

/// The radius in the legend, inches.
fn radius(scene: &Scene) -> Option<u32> {
    let screen = screen(scene, 120, 40);
    let (_, rest) = screen.split_once("reckoned, within ")?;
    rest.split(' ').next()?.parse().ok()
}

#[test]
fn a_silent_robot_has_a_growing_ghost() {
    let mut scene = flight(Config::default());
    scene.state.bump = Bump::None;
    (scene.state.wheel_left_in_s, scene.state.wheel_right_in_s) = (10, 10);
    scene.hear();
    assert_eq!(radius(&scene), None, "it is heard");
    let mut last = 0;
    for _ in 0..8 {
        scene.wait_ms(2000);
        let grown = radius(&scene).unwrap();
        assert!(grown > last, "{grown} after {last}");
        last = grown;
    }
    insta::assert_snapshot!("ghost", screen(&scene, 120, 40));
    scene.hear();
    assert_eq!(radius(&scene), None);
    scene.wait_ms(10_000);
    scene.event(Event::Link(LinkEvent::Ended));
    let stands = radius(&scene);
    scene.wait_ms(20_000);
    assert_eq!(radius(&scene), stands, "time stands still");
}

#[test]
fn each_rung_shows_its_latest_change() {
    let mut scene = flight(Config::default());
    for _ in 0..12 {
        scene.hear();
    }
    let wide = screen(&scene, 120, 40);
    let rung = row(&wide, "1 ▶ BUMPERS");
    assert!(rung.contains(" 4 s"), "{rung}");
    let quiet = row(&wide, "7 · dead reckoning");
    assert!(quiet.contains("18 s"), "{quiet}");
}

/// The reversed cells of the row.
fn lit(scene: &Scene, width: u16, height: u16) -> String {
    let buffer = buffer(scene, width, height);
    let cells = buffer.content().iter();
    let lit = cells.filter(|cell| cell.modifier.contains(Modifier::REVERSED));
    lit.map(ratatui::buffer::Cell::symbol).collect()
}

#[test]
fn a_value_is_traced_to_its_columns() {
    let mut scene = flight(Config::default());
    scene.hear_status();
    scene.type_text("i");
    scene.press(&[KeyCode::Right; 6]);
    let narrow = screen(&scene, 80, 24);
    insta::assert_snapshot!("trace_narrow", narrow);
    row(
        &narrow,
        "left wheel: line A, columns 31-33: `-05`, <1 s old",
    );
    row(&narrow, "A46 +075.9");
    assert_eq!(lit(&scene, 80, 24), "-05");
    assert_eq!(lit(&scene, 120, 40), "-05");
    scene.press(&[KeyCode::Down, KeyCode::Right]);
    row(
        &screen(&scene, 80, 24),
        "battery: line B, columns 8-11: `12.4`",
    );
    assert_eq!(lit(&scene, 80, 24), "12.4");
    scene.press(&[KeyCode::Down, KeyCode::Left]);
    row(
        &screen(&scene, 80, 24),
        "odometer resets: line B, columns 64-65",
    );
    scene.press(&[KeyCode::Esc]);
    assert_eq!(lit(&scene, 80, 24), "");
}

#[test]
fn the_why_window_is_about_the_shown_moment() {
    let mut scene = flight(Config::default());
    commanded(&mut scene);
    scene.type_text("y");
    let narrow = screen(&scene, 80, 24);
    insta::assert_snapshot!("why_narrow", narrow);
    row(&narrow, " why, at 00:15 ");
    row(
        &narrow,
        "BUMPERS hold the motors, for <1 s: right bumper hit; backs off",
    );
    row(&narrow, "suppressed  sonar, prowl");
    row(&narrow, "wheels requested -6 -6, measured -5 -6 in/s");
    row(&narrow, "command     disable sonar, <1 s ago: queued");
    row(&narrow, "right bumper hit at (79, 39)");
    scene.wait_ms(60_000);
    row(
        &screen(&scene, 80, 24),
        "stale       ◌ by its last line, 1 m 00 s ago",
    );
    let mut ascii = flight(mono());
    ascii.type_text("y");
    assert!(screen(&ascii, 80, 24).is_ascii());
}

#[test]
fn a_route_is_followed_from_draft_to_driven() {
    let mut scene = flight(Config::default());
    scene.press(&[KeyCode::Left; 4]);
    scene.type_text("w");
    scene.press(&[KeyCode::F(5)]);
    let says = |scene: &Scene, words: &str| {
        row(&screen(scene, 200, 60), words);
    };
    says(&scene, "◇ draft: 1 waypoint, not sent");
    let effects = scene.type_text("S");
    let [Effect::Send(Request::Route(route))] = &effects[..] else {
        panic!("sending the draft gave {effects:?}");
    };
    let digest = digest(route.iter());
    let step = |scene: &mut Scene, status| {
        scene.wait_ms(300);
        scene.status_of(1, status);
    };
    scene.wait_ms(300);
    scene.ask(1, Request::Route(route.clone()));
    says(&scene, "… queued");
    step(&mut scene, CommandStatus::Sent { frames: 3 });
    says(&scene, "… sent 3 frames");
    let (acknowledged, total) = (1, 1);
    step(
        &mut scene,
        CommandStatus::Progress {
            acknowledged,
            total,
        },
    );
    says(&scene, "… holds 1/1, sent 3 frames");
    step(
        &mut scene,
        CommandStatus::Confirmed {
            digest: Some(digest),
        },
    );
    says(&scene, "✔ confirmed in 0.9 s");
    scene.state.mode = Mode::Stop;
    scene.hear();
    says(&scene, "✔ confirmed in 0.9 s. Press m p to drive");
    scene.status.digest = digest;
    scene.status.list = ListPlace {
        driven: 1,
        count: 1,
    };
    scene.hear_status();
    says(&scene, "✔ done 1/1");
    scene.status.digest ^= 1;
    scene.hear_status();
    says(&scene, "replaced, driven 1/1");
}

#[test]
fn without_colors_alarms_are_bold_or_reversed() {
    let config = Config {
        colors: Colors::Mono,
        ..Config::default()
    };
    let mut scene = busy(config);
    scene.state.power = Power::Critical;
    scene.hear();
    for (width, height) in [(80, 24), (120, 40), (200, 60)] {
        let page = buffer(&scene, width, height);
        assert!(
            page.content
                .iter()
                .all(|cell| (cell.fg, cell.bg) == (Color::Reset, Color::Reset))
        );
        let called = page[(0, 1)].modifier;
        assert!(
            called.intersects(Modifier::BOLD | Modifier::REVERSED),
            "{called:?}"
        );
        assert!(
            page.content
                .iter()
                .any(|cell| cell.modifier.is_empty() && cell.symbol() != " ")
        );
    }
}

#[test]
fn the_caret_is_visible_after_any_text() {
    let mut scene = flight(Config::default());
    scene.type_text(":");
    scene.event(Event::Paste(format!("{}abc", "漢".repeat(90))));
    for width in [80, 100, 120] {
        row(&screen(&scene, width, 24), "abc▏");
        scene.press(&[KeyCode::Left]);
        row(&screen(&scene, width, 24), "ab▏c");
        scene.press(&[KeyCode::End]);
    }
}

#[test]
fn a_contact_counts_before_the_robots_next_count() {
    let mut scene = Scene::new(Config::default());
    scene.hear_ticks(1, [0; HOLDERS]);
    scene.hear();
    row(&screen(&scene, 120, 40), "bumps 2,");
    for _ in 0..3 {
        scene.state.bump = Bump::Center;
        scene.hear();
        scene.state.bump = Bump::None;
        scene.hear();
    }
    row(&screen(&scene, 120, 40), "bumps 3,");
}

#[test]
fn measured_walls_stand_for_walls_that_are_not_known() {
    let mut scene = Scene::new(Config::default());
    for step in 0..4 {
        scene.state.y_tenths_in += 20;
        scene.state.sonar_left_in = Some(40 - 2 * step);
        scene.hear();
    }
    row(&screen(&scene, 120, 40), "walls: measured");
    scene.event(Event::Truth(house()));
    assert!(!screen(&scene, 120, 40).contains("walls: measured"));
    scene.type_text("t");
    row(&screen(&scene, 120, 40), "walls: measured");
}

#[test]
fn local_time_stands_beside_utc_on_request() {
    let scene = |local_offset_s| {
        Scene::new(Config {
            unix: Some(Moment::from_hours(23)),
            local_offset_s,
            ..demo()
        })
    };
    assert!(screen(&scene(None), 120, 40).contains(" 23:00Z  "));
    let beside = screen(&scene(Some(-5400)), 120, 40);
    assert!(beside.contains(" 23:00Z, 21:30 local  "), "{beside}");
    let ahead = screen(&scene(Some(7200)), 120, 40);
    assert!(ahead.contains(" 23:00Z, 01:00 local  "), "{ahead}");
}

/// Mode and holder agree as soon as the robot confirms STOP, before its next line A.
#[test]
fn a_confirmed_stop_is_also_in_the_headline() {
    let mut scene = flight(demo());
    row(&screen(&scene, 120, 40), "BUMPERS hold the motors");
    scene.command(9, Request::Stop, CommandStatus::Confirmed { digest: None });
    let stopped = screen(&scene, 120, 40);
    row(&stopped, "holds the motors: stopped");
    row(&stopped, "  STOP  ");
    assert!(!stopped.contains("HOLDS"), "{stopped}");
}

/// The layers are off in mode Stop; a robot that leaves it does not drive without them.
#[test]
fn a_mode_confirmed_after_a_stop_does_not_drive_without_layers() {
    let mut scene = flight(demo());
    scene.state.mode = Mode::Stop;
    scene.state.bump = Bump::None;
    scene.layers(&Layer::ALL.map(|layer| (layer, LayerState::Off)));
    scene.hear();
    let home = Request::Mode(Mode::GoHome);
    scene.command(9, home, CommandStatus::Confirmed { digest: None });
    let screen = screen(&scene, 120, 40);
    row(&screen, "  HOME  ");
    assert!(!screen.contains("drives without"), "{screen}");
}

/// On a large screen, the map takes the rows that the commands leave empty.
#[test]
fn few_commands_leave_their_rows_to_the_map() {
    let scene = flight(demo());
    let large = screen(&scene, 200, 60);
    let row_of = |words: &str| large.lines().position(|row| row.contains(words));
    let (commands, raw) = (row_of("F5 commands"), row_of("raw: the newest line"));
    let rows = raw.zip(commands).map(|(raw, commands)| raw - commands);
    assert_eq!(rows, Some(7), "{large}");
    assert!(row_of("F6 log") < commands, "{large}");
}
