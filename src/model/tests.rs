//! What the model says and wants, from lines and keys made by hand.

use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use groundwave_protocol::letters::{Arm, Bump, Cliff, Drive, Layer, LayerMask, LayerState, Mode};
use groundwave_protocol::telemetry::{AckLine, ListPlace};
use groundwave_protocol::{WAYPOINTS_MAX, Waypoint};

use super::chart::Focus;
use super::motors::{Holder, suppressed};
use super::testing::{Scene, state};
use super::{Config, Overlay, why};
use crate::event::{CommandId, CommandStep, Effect, Event, Failure, LinkEvent, Moment, Replay};
use crate::request::Request;

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

#[test]
fn stop_never_asks_and_works_under_everything() {
    for (keys, stop) in [
        ("", ' '),
        ("?", ' '),
        ("d", ' '),
        ("dy", ' '),
        ("C", ' '),
        (":goto 4", 's'),
        ("lroute", 's'),
    ] {
        let mut scene = scene();
        scene.type_text(keys);
        let effects = match stop {
            's' => scene.ctrl('s'),
            key => scene.type_text(&key.to_string()),
        };
        assert_eq!(effects, [STOP], "after `{keys}`");
        assert_eq!(scene.model.overlay, Overlay::None, "after `{keys}`");
    }
}

#[test]
fn hazardous_commands_ask_first() {
    for (keys, wanted) in [
        ("C", Request::Route(Vec::new())),
        ("d", Request::Mode(Mode::User)),
        (
            "O",
            Request::Pose {
                position: Waypoint::default(),
                theta_deg: 0,
            },
        ),
        (
            ":set-pose 1 2 90\n",
            Request::Pose {
                position: Waypoint { x_in: 1, y_in: 2 },
                theta_deg: 90,
            },
        ),
        (":clear\n", Request::Route(Vec::new())),
        (":mode user\n", Request::Mode(Mode::User)),
    ] {
        let mut scene = scene();
        let typed = |scene: &mut Scene| {
            let mut effects = scene.type_text(keys.trim_end());
            if keys.ends_with('\n') {
                effects.extend(scene.press(&[KeyCode::Enter]));
            }
            effects
        };
        assert_eq!(typed(&mut scene), [], "{keys}");
        assert_eq!(scene.type_text("n"), [], "{keys}");
        assert_eq!(typed(&mut scene), [], "{keys}");
        assert_eq!(scene.type_text("y"), [Effect::Send(wanted)], "{keys}");
    }
}

#[test]
fn a_held_arrow_drives_and_letting_go_stops() {
    let mut scene = scene();
    scene.type_text("dy");
    let ahead = Effect::Drive {
        velocity_in_s: 8,
        rotation_in_s: 0,
    };
    assert_eq!(scene.press(&[KeyCode::Up]), [ahead]);
    let due = scene.model.poll_timeout().expect("a lease runs");
    scene.now = due;
    assert_eq!(scene.event(Event::Tick), [Effect::DriveEnd]);
    assert_eq!(scene.model.poll_timeout(), None);

    scene.press(&[KeyCode::Left]);
    let release = KeyEvent::new_with_kind(KeyCode::Left, KeyModifiers::NONE, KeyEventKind::Release);
    assert_eq!(scene.event(Event::Key(release)), [Effect::DriveEnd]);

    scene.press(&[KeyCode::Up]);
    assert_eq!(scene.press(&[KeyCode::Esc]), [Effect::DriveEnd]);
    assert_eq!(scene.model.overlay, Overlay::None);
}

#[test]
fn nobody_drives_over_a_link_that_only_receives() {
    let mut scene = scene();
    scene.event(Event::Link(LinkEvent::Opened {
        name: "radio".to_owned(),
        can_send: false,
    }));
    assert_eq!(scene.type_text("dy"), []);
    assert_eq!(scene.model.overlay, Overlay::None);
}

#[test]
fn a_layer_key_asks_for_the_opposite_of_what_was_asked_or_reported() {
    let mut scene = scene();
    let sonar = LayerMask::NONE.with(Layer::Sonar);
    let disable = Request::Disable(sonar);
    assert_eq!(scene.type_text("4"), [Effect::Send(disable.clone())]);
    scene.event(Event::Command {
        id: CommandId(1),
        step: CommandStep::Queued(disable),
    });
    assert_eq!(
        scene.type_text("4"),
        [Effect::Send(Request::Enable(sonar))],
        "asked, not yet answered"
    );
    assert_eq!(scene.type_text("5"), [], "photo is not fitted");
    let mut unheard = Scene::new(Config::default());
    assert_eq!(unheard.type_text("4"), [], "nobody knows what is allowed");
}

#[test]
fn a_route_is_drafted_on_the_map_and_sent() {
    let mut scene = scene();
    scene.press(&[KeyCode::Up, KeyCode::Up]);
    scene.type_text("w");
    scene.press(&[KeyCode::Right, KeyCode::Enter, KeyCode::Right]);
    scene.type_text("wu");
    assert_eq!(scene.model.chart.draft, route(&[(0, 12), (6, 12)]));
    let sent = Request::Route(route(&[(0, 12), (6, 12)]));
    assert_eq!(scene.type_text("S"), [Effect::Send(sent.clone())]);
    assert!(scene.model.chart.draft.is_empty());
    assert_eq!(scene.type_text("S"), [], "nothing is left to send");
    scene.command(1, sent, CommandStep::Failed(Failure::TimedOut));
    assert_eq!(
        scene.model.chart.draft,
        route(&[(0, 12), (6, 12)]),
        "what did not arrive can be sent again"
    );
}

#[test]
fn a_draft_never_outgrows_the_robots_list() {
    let mut scene = scene();
    scene.press(&[KeyCode::Up]);
    for _ in 0..WAYPOINTS_MAX + 5 {
        scene.type_text("w");
    }
    assert_eq!(scene.model.chart.draft.len(), WAYPOINTS_MAX);
    assert_eq!(scene.type_text("S").len(), 1);
}

#[test]
fn a_route_file_is_read_by_somebody_else() {
    for keys in ["l tour.txt ", ":route tour.txt"] {
        let mut scene = scene();
        scene.type_text(keys);
        assert_eq!(
            scene.press(&[KeyCode::Enter]),
            [Effect::LoadRoute("tour.txt".to_owned())]
        );
        let waypoints = route(&[(48, 0), (48, 48)]);
        scene.event(Event::RouteLoaded {
            path: "tour.txt".to_owned(),
            route: Ok(waypoints.clone()),
        });
        assert_eq!(scene.model.chart.draft, waypoints);
        scene.event(Event::RouteLoaded {
            path: "tour.txt".to_owned(),
            route: Err("tour.txt:2:1: `x` is not a whole number".to_owned()),
        });
        assert_eq!(scene.model.chart.draft, waypoints, "the draft stays");
        let newest = scene.model.log.newest_first().next().expect("a log entry");
        assert!(newest.text.starts_with("tour.txt:2:1"));
    }
}

#[test]
fn typed_words_are_those_of_the_command_line() {
    let mut scene = scene();
    scene.type_text(":goto 48 -36");
    let goto = Request::Route(route(&[(48, -36)]));
    assert_eq!(scene.press(&[KeyCode::Enter]), [Effect::Send(goto)]);
    scene.type_text(":mode prawl");
    assert_eq!(scene.press(&[KeyCode::Enter]), []);
    let Overlay::Text(entry) = &scene.model.overlay else {
        panic!("the text stays to be mended");
    };
    assert!(entry.error.as_ref().is_some_and(|e| e.contains("prawl")));
    scene.press(&[KeyCode::Backspace; 3]);
    scene.event(Event::Paste("owl\nstop".to_owned()));
    assert_eq!(
        scene.press(&[KeyCode::Enter]),
        [Effect::Send(Request::Mode(Mode::Prowl))],
        "one line of what was pasted"
    );
    scene.type_text(":route");
    scene.press(&[KeyCode::Enter]);
    let Overlay::Text(entry) = &scene.model.overlay else {
        panic!("the text stays to be mended");
    };
    assert!(
        entry
            .error
            .as_ref()
            .is_some_and(|e| e.starts_with("`route` takes"))
    );
}

#[test]
fn active_is_what_the_robot_acknowledged_until_it_says_otherwise() {
    let list = Request::Route(route(&[(1, 2), (3, 4)]));
    let mut scene = scene();
    let active = |scene: &Scene| scene.model.ledger.active().map(|a| (a.digest, a.driven));
    for step in [
        CommandStep::Queued(list.clone()),
        CommandStep::Sent { frames: 1 },
        CommandStep::Progress {
            acknowledged: 2,
            total: 2,
        },
    ] {
        scene.event(Event::Command {
            id: CommandId(1),
            step,
        });
        assert_eq!(active(&scene), None, "delivered is not active");
    }
    scene.event(Event::Command {
        id: CommandId(1),
        step: CommandStep::Proven { digest: Some(7) },
    });
    assert_eq!(active(&scene), Some((7, None)), "active is not driven");
    scene.status.digest = 7;
    scene.status.list = ListPlace {
        driven: 1,
        count: 2,
    };
    scene.hear_status();
    assert_eq!(active(&scene), Some((7, Some(scene.status.list))));
    scene.status.digest = 8;
    scene.hear_status();
    assert_eq!(active(&scene), None, "another list is driven");

    scene.command(2, list, CommandStep::Proven { digest: Some(9) });
    assert_eq!(active(&scene), Some((9, None)));
    scene.ack.boot = 1;
    scene.hear();
    assert_eq!(active(&scene), None, "the robot restarted");
}

/// The boot counter in every line is modulo 8: lines B and C tell the robots apart in which it agrees.
#[test]
fn a_restart_is_noticed_although_the_short_boot_counter_agrees() {
    let restarts = |scene: &Scene| {
        let told = scene.model.log.newest_first();
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
    // One restart is told once, whichever line is the first to tell.
    scene.ack.boot = (scene.ack.boot + 1) % 8;
    scene.hear();
    scene.hear_status();
    scene.hear_ticks(1, [0; 9]);
    assert_eq!(restarts(&scene), before + 1);
}

#[test]
fn after_a_restart_the_map_starts_afresh() {
    let mut scene = scene();
    scene.drive(10, 3.0, 0);
    scene.state.bump = Bump::Left;
    scene.hear();
    assert_eq!(scene.model.chart.bumps.len(), 1);
    scene.ack.boot = (scene.ack.boot + 1) % 8;
    scene.state.bump = Bump::None;
    (scene.state.x_tenths_in, scene.state.y_tenths_in) = (0, 0);
    scene.hear();
    assert_eq!(scene.model.chart.bumps.len(), 0, "a mark in another frame");
    assert_eq!(scene.model.chart.trail.recent().count(), 1);
}

#[test]
fn ages_tick_on_a_silent_link_and_stand_still_on_a_closed_one() {
    let mut scene = scene();
    let heard = scene.now;
    let mut ticks = 0;
    while scene.now < heard + Moment::from_mins(2) {
        let due = scene.model.redraw_at(scene.now).expect("ages go on");
        assert!(due > scene.now);
        scene.now = due;
        ticks += 1;
    }
    assert_eq!(ticks, 60 + 6, "by the second, then by ten");
    scene.event(Event::Replay(Replay {
        paused: true,
        speed: 1.0,
    }));
    assert_eq!(scene.model.redraw_at(scene.now), None);
    scene.event(Event::Replay(Replay {
        paused: false,
        speed: 1.0,
    }));
    assert!(scene.model.redraw_at(scene.now).is_some());
    scene.event(Event::Link(LinkEvent::Ended));
    assert_eq!(scene.model.redraw_at(scene.now), None);
}

#[test]
fn what_the_screen_does_not_show_does_not_draw_it() {
    let mut scene = scene();
    scene.event(Event::Ack(AckLine {
        sequence: 3,
        ack: scene.ack,
        listens: false,
    }));
    let drawn = scene.model.revision();
    scene.event(Event::Tick);
    scene.event(Event::Ack(AckLine {
        sequence: 4,
        ack: scene.ack,
        listens: false,
    }));
    assert_eq!(scene.model.revision(), drawn);
    scene.hear();
    assert_ne!(scene.model.revision(), drawn);
}

#[test]
fn shares_come_from_the_robots_count_of_ticks_across_its_wrap() {
    let mut scene = scene();
    for _ in 0..10 {
        scene.hear();
    }
    assert_eq!(
        scene.model.motors.share(Holder::Prowl),
        Some(1.0),
        "by the lines while there is no count"
    );
    scene.hear_ticks(10, [0, 4090, 0, 0, 0, 0, 0, 0, 100]);
    scene.hear_ticks(20, [0, 44, 0, 0, 0, 0, 0, 0, 250]);
    let share = |layer| scene.model.motors.share(Holder::Layer(layer));
    assert_eq!(share(Layer::Bumpers), Some(0.25));
    assert_eq!(share(Layer::Sonar), Some(0.0));
    assert_eq!(scene.model.motors.share(Holder::Prowl), Some(0.75));
    scene.hear_ticks(3, [0; 9]);
    assert_eq!(
        scene.model.motors.share(Holder::Layer(Layer::Bumpers)),
        Some(0.0),
        "after a restart the lines speak again"
    );
}

#[test]
fn motors_that_change_hands_with_every_line_thrash() {
    let mut scene = scene();
    for n in 0..12 {
        let thrashes = scene.model.motors.thrashes(scene.now);
        assert_eq!(thrashes, n > 6, "{n} holders");
        let (quiet, holds) = [
            (Layer::Infrared, Layer::Bumpers),
            (Layer::Bumpers, Layer::Infrared),
        ][n % 2];
        scene.layers(&[(quiet, LayerState::Quiet), (holds, LayerState::Holds)]);
        scene.hear();
    }
    for _ in 0..30 {
        scene.hear();
    }
    assert!(!scene.model.motors.thrashes(scene.now));
}

#[test]
fn steering_is_no_thrashing() {
    let mut scene = scene();
    for n in 0..40 {
        let state = [LayerState::Holds, LayerState::Quiet][n % 2];
        scene.layers(&[(Layer::Sonar, state)]);
        scene.hear();
        assert!(!scene.model.motors.thrashes(scene.now));
    }
}

#[test]
fn only_what_is_below_the_holder_is_suppressed() {
    let mut line = state();
    line.layers.set(Layer::Infrared, LayerState::Raised);
    assert_eq!(
        suppressed(Holder::of(&line), &line),
        [],
        "prowl suppresses nobody"
    );
    line.layers.set(Layer::Sonar, LayerState::Holds);
    line.layers.set(Layer::DeadReckoning, LayerState::Raised);
    let below = [Holder::Layer(Layer::DeadReckoning), Holder::Prowl];
    assert_eq!(suppressed(Holder::of(&line), &line), below);
}

#[test]
fn the_holder_is_told_from_layers_and_mode() {
    let mut line = state();
    assert_eq!(Holder::of(&line), Holder::Prowl);
    line.mode = Mode::Reactive;
    assert_eq!(Holder::of(&line), Holder::Nobody);
    line.mode = Mode::User;
    assert_eq!(Holder::of(&line), Holder::Layer(Layer::User));
    line.layers.set(Layer::Bumpers, LayerState::Holds);
    assert_eq!(Holder::of(&line), Holder::Layer(Layer::Bumpers));
}

#[test]
fn a_guard_that_took_the_motors_is_named_and_not_who_won_them() {
    let mut scene = scene();
    let sentence = |scene: &Scene| {
        let holder = scene.model.motors.holder().expect("a line A came").value;
        why::why(holder, &scene.state, &scene.model.robot, scene.now)
    };
    scene.state.cliff = Cliff::Center;
    scene.layers(&[(Layer::Bumpers, LayerState::Raised)]);
    scene.hear();
    assert_eq!(Holder::of(&scene.state), Holder::CliffGuard);
    assert!(sentence(&scene).starts_with("no floor ahead; "));
    let both = [Holder::Layer(Layer::Bumpers), Holder::Prowl];
    assert_eq!(suppressed(Holder::CliffGuard, &scene.state), both);

    // With the guard switched off it was prowl that drove the robot there.
    scene.hear_parameter("cliff-guard", 0);
    scene.state.cliff = Cliff::Several;
    scene.hear();
    let holder = scene.model.motors.holder().map(|held| held.value);
    assert_eq!(holder, Some(Holder::Prowl));
    assert_eq!(
        sentence(&scene),
        "no floor on several sides, and nothing guards"
    );
    scene.hear_parameter("cliff-guard", 1);
    scene.state.cliff = Cliff::None;
    scene.hear();
    assert_eq!(sentence(&scene), "nothing in the way");

    scene.state.arm = Arm::Up;
    scene.hear();
    assert_eq!(sentence(&scene), "stands until the arm is down");
    scene.layers(&[(Layer::Bumpers, LayerState::Holds)]);
    assert_eq!(Holder::of(&scene.state), Holder::Layer(Layer::Bumpers));
}

#[test]
fn a_bump_is_marked_where_it_happened_and_once() {
    let mut scene = scene();
    scene.state.theta_deg = 90;
    scene.state.x_tenths_in = 1000;
    scene.state.bump = Bump::Center;
    for _ in 0..4 {
        scene.hear();
    }
    let marks: Vec<(f64, f64)> = scene
        .model
        .chart
        .bumps
        .iter()
        .map(|mark| (mark.x_in.round(), mark.y_in.round()))
        .collect();
    assert_eq!(marks, [(106.0, 0.0)], "on the rim of the robot, ahead");
}

#[test]
fn after_an_odometer_reset_the_map_starts_afresh() {
    let mut scene = scene();
    scene.drive(30, 4.0, 2);
    assert!(scene.model.chart.trail.recent().count() > 10);
    scene.state.drive = Drive::OdometerReset;
    (scene.state.x_tenths_in, scene.state.y_tenths_in) = (0, 0);
    scene.hear();
    assert_eq!(scene.model.chart.trail.recent().count(), 1);
}

#[test]
fn a_gap_in_the_telemetry_is_a_gap_in_the_trail() {
    let mut scene = scene();
    scene.drive(5, 4.0, 0);
    scene.wait_ms(5000);
    scene.drive(5, 4.0, 0);
    let gaps = scene.model.chart.trail.recent().filter(|p| !p.joined);
    assert_eq!(gaps.count(), 2, "where it starts and after the silence");
}

#[test]
fn the_map_follows_in_jumps() {
    let mut scene = scene();
    scene.type_text("f");
    assert_eq!(scene.model.chart.focus, Focus::Robot);
    let mut jumps = 0;
    let mut middle = scene.model.chart.middle();
    for _ in 0..60 {
        scene.drive(1, 3.0, 0);
        if scene.model.chart.middle() != middle {
            middle = scene.model.chart.middle();
            jumps += 1;
        }
    }
    assert!((4..=8).contains(&jumps), "{jumps}");
}

#[test]
fn a_long_session_takes_no_more_room_than_a_short_one() {
    let mut scene = scene();
    for n in 0..20_000_u32 {
        scene.state.bump = [Bump::None, Bump::Left][n as usize / 3 % 2];
        scene.drive(1, 4.0, if n % 50 < 10 { 9 } else { 0 });
        if n % 10 == 0 {
            scene.hear_text(&format!("line {n}"));
            let id = CommandId(n);
            scene.event(Event::Command {
                id,
                step: CommandStep::Queued(Request::Scan),
            });
        }
    }
    let model = &scene.model;
    assert!(model.chart.bumps.len() <= 256);
    assert!(model.chart.trail.recent().count() <= 1024);
    assert!(model.chart.trail.older().count() <= 4096);
    assert!(model.log.newest_first().count() <= 256);
    assert!(model.ledger.entries().count() <= 64);
}

#[test]
fn an_adapter_that_is_back_under_another_name_says_so() {
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
fn a_command_of_somebody_elses_says_whose_it_is() {
    let mut scene = scene();
    let (id, by) = (CommandId(1), "pid 7 via ./x.sock".to_owned());
    scene.command(1, Request::Scan, CommandStep::Sent { frames: 1 });
    scene.event(Event::Asked { id, by: by.clone() });
    let entry = scene.model.ledger.entries().next();
    assert_eq!(entry.and_then(|entry| entry.by.clone()), Some(by.clone()));
    let newest = scene.model.log.newest_first().next();
    assert_eq!(
        newest.map(|entry| entry.text.clone()),
        Some(format!("scan: asked by {by}"))
    );
}

#[test]
fn a_song_and_a_low_battery_ring_the_bell_once_unless_it_is_silenced() {
    use groundwave_protocol::letters::Power;
    use groundwave_protocol::telemetry::{Ack, Body, Line, Note, SongLine, StateLine};
    for silent in [false, true] {
        let mut scene = Scene::new(Config {
            silent,
            ..Config::default()
        });
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
        assert_eq!(rings, if silent { 0 } else { 3 });
    }
}
