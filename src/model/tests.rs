//! The model's facts and effects, from constructed lines and keys.

use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{
    Arm, Bump, Cliff, Drive, Layer, LayerMask, LayerState, Link, Mode,
};
use groundwave_protocol::telemetry::{AckLine, HOLDERS, ListPlace};
use groundwave_protocol::{WAYPOINTS_MAX, Waypoint};

use super::map::Focus;
use super::motors::{Holder, suppressed};
use super::testing::{Scene, listed, overlaid, playback, state};
use super::{Config, Overlay, Panel};
use crate::event::{CommandId, CommandStatus, Effect, Event, Failure, LinkEvent, Moment};
use crate::request::Request;

mod alarms;
mod automatic;
mod chart;
mod ground;
mod keys;
mod ledger;
mod motors;
mod routes;
mod runs;

const STOP: Effect = Effect::Send(Request::Stop);

fn scene() -> Scene {
    let mut scene = Scene::new(Config::default());
    scene.hear_status();
    scene.hear();
    scene
}

fn route(points: &[(i16, i16)]) -> Vec<Waypoint> {
    let waypoint = |&(x_in, y_in): &(i16, i16)| Waypoint { x_in, y_in };
    points.iter().map(waypoint).collect()
}

/// The boot counter of a line is modulo 8; lines B and C distinguish boots with equal counters.
#[test]
fn a_restart_is_noticed_although_the_short_boot_counter_agrees() {
    let restarts = |scene: &Scene| {
        let told = scene.model.facts.log.newest_first();
        told.filter(|entry| entry.text == "the robot restarted")
            .map(|entry| entry.times)
            .sum::<u32>()
    };
    let mut scene = scene();
    scene.hear_status();
    scene.hear_ticks(500, [0; 9]);
    scene.hear_ticks(510, [0; 9]);
    assert_eq!(restarts(&scene), 0);
    scene.status.boots += 64;
    scene.hear_status();
    assert_eq!(restarts(&scene), 1, "line B says so");
    scene.status.boots -= 64;
    scene.hear_ticks(520, [0; 9]);
    assert_eq!(restarts(&scene), 2, "line C says so");
    scene.hear_ticks(519, [0; 9]);
    assert_eq!(restarts(&scene), 3, "time ran backwards");
    scene.hear_ticks(999_999, [0; 9]);
    let before = restarts(&scene);
    scene.hear_ticks(3, [0; 9]);
    assert_eq!(restarts(&scene), before, "the count of seconds goes round");
    // A restart is logged once, at the first line that shows it.
    scene.ack.boot = (scene.ack.boot + 1) % 8;
    scene.hear();
    scene.hear_status();
    scene.hear_ticks(1, [0; 9]);
    assert_eq!(restarts(&scene), before + 1);
}

#[test]
fn ages_tick_on_a_silent_link_and_stand_still_on_a_closed_one() {
    let mut scene = scene();
    let heard = scene.now;
    let mut ticks = 0;
    while scene.now < heard + Moment::from_mins(2) {
        let due = scene.redraw_at().expect("ages go on");
        assert!(due > scene.now);
        scene.now = due;
        ticks += 1;
    }
    assert_eq!(ticks, 60 + 6, "by the second, then by ten");
    scene.event(Event::Link(LinkEvent::Ended));
    assert_eq!(scene.redraw_at(), None);
}

#[test]
fn hidden_events_cause_no_redraw() {
    let mut scene = scene();
    scene.event(Event::Ack(AckLine {
        sequence: 3,
        ack: scene.ack,
        listens: false,
    }));
    let drawn = scene.model.ui.revision();
    scene.event(Event::Tick);
    scene.event(Event::Ack(AckLine {
        sequence: 4,
        ack: scene.ack,
        listens: false,
    }));
    assert_eq!(scene.model.ui.revision(), drawn);
    scene.hear();
    assert_ne!(scene.model.ui.revision(), drawn);
}

#[test]
fn a_long_session_takes_no_more_room_than_a_short_one() {
    let mut scene = scene();
    for n in 0..20_000_u32 {
        scene.state.bump = [Bump::None, Bump::Left][n as usize / 3 % 2];
        scene.drive(1, 4.0, if n % 50 < 10 { 9 } else { 0 });
        if n % 10 == 0 {
            scene.hear_text(&format!("line {n}"));
            scene.ask(n, Request::Scan);
        }
    }
    let model = &scene.model.facts;
    assert!(model.chart.bumps.len() <= 256);
    assert!(model.chart.trail.recent().count() <= 1024);
    assert!(model.chart.trail.older().count() <= 4096);
    assert!(model.log.newest_first().count() <= 256);
    assert!(model.ledger.entries().count() <= 64);
}

#[test]
fn an_adapter_that_is_back_under_another_name_is_reported() {
    let mut scene = scene();
    let opened = |name: &str| {
        Event::Link(LinkEvent::Opened {
            name: name.to_owned(),
            can_send: true,
        })
    };
    let lost = Event::Link(LinkEvent::Lost {
        reason: "unplugged".to_owned(),
    });
    let newest = |scene: &Scene| {
        scene
            .model
            .facts
            .log
            .newest_first()
            .next()
            .map(|e| e.text.clone())
    };
    scene.event(opened("/dev/ttyUSB0"));
    scene.event(lost.clone());
    scene.event(opened("/dev/ttyUSB0"));
    assert_eq!(newest(&scene).as_deref(), Some("/dev/ttyUSB0 is back"));
    scene.event(lost);
    scene.event(opened("/dev/ttyUSB1"));
    assert_eq!(newest(&scene).as_deref(), Some("back as /dev/ttyUSB1"));
}

#[test]
fn a_song_and_a_low_battery_ring_the_bell_once_when_it_was_asked_for() {
    use groundwave_protocol::status_codes::Power;
    use groundwave_protocol::telemetry::{Ack, Body, Line, Note, SongLine, StateLine};
    assert!(!Config::default().bell, "off by default");
    for keys in ["", "b", "bb"] {
        let mut scene = Scene::new(Config::default());
        scene.type_text(keys);
        let song = SongLine::new([Note { hz: 523, ticks: 4 }]);
        let power = |power| Body::State(StateLine { power, ..state() });
        let mut rings = 0;
        for (sequence, body) in (0..).zip([
            power(Power::Ok),
            Body::Song(song),
            power(Power::Low),
            power(Power::Low),
            power(Power::Critical),
        ]) {
            let line = Line {
                sequence,
                body,
                ack: Ack::default(),
            };
            let effects = scene.event(Event::Line {
                line: Box::new(line),
                raw: line.encode(),
            });
            rings += effects
                .iter()
                .filter(|&effect| *effect == Effect::Ring)
                .count();
        }
        assert_eq!(rings, if keys == "b" { 3 } else { 0 });
    }
}

#[test]
fn the_last_words_name_the_mode_and_the_failsafe() {
    let mut scene = Scene::new(Config::default());
    let said = |scene: &Scene| scene.model.facts.last_words(scene.now);
    assert_eq!(said(&scene), None);
    scene.hear();
    let prowls = "the robot is still in mode prowl";
    assert_eq!(said(&scene).as_deref(), Some(prowls));
    scene.failsafe = Some(Failsafe {
        silence_s: 30,
        mode: Mode::GoHome,
    });
    scene.hear_ticks(1, [0; HOLDERS]);
    scene.state.link = Link::Armed;
    scene.hear();
    let guarded = format!("{prowls}; failsafe: home after 30 s of silence, armed");
    assert_eq!(said(&scene), Some(guarded));
    scene.state.link = Link::Ok;
    scene.state.mode = Mode::Stop;
    scene.hear();
    assert_eq!(said(&scene).as_deref(), Some("the robot is stopped"));
    scene.wait_ms(12_000);
    let silent = "the robot was in mode stop when last heard, 12 s ago";
    assert_eq!(said(&scene).as_deref(), Some(silent));
}

#[test]
fn the_last_words_name_commands_without_confirmation() {
    let mut scene = Scene::new(Config::default());
    scene.hear();
    let confirmed = CommandStatus::Confirmed { digest: None };
    scene.command(1, Request::Mode(Mode::GoHome), confirmed);
    scene.ask(2, Request::Stop);
    let said = scene.model.facts.last_words(scene.now);
    let unconfirmed = "the robot is still in mode prowl; not confirmed: stop";
    assert_eq!(said.as_deref(), Some(unconfirmed));
}
