//! Every panel and state at every size, with and without colours: each shows its facts, and no word is clipped.

use std::fmt::Write as _;

use groundwave_protocol::status_codes::{Arm, Cliff, Power};

use super::link::measured;
use super::time::{flight_at, playback};
use super::*;
use crate::event::Moment;
use crate::model::Large;
use crate::playback::Playback;
use crate::view::CLIPPED;

pub(super) const SIZES: [(u16, u16); 3] = [(80, 24), (120, 40), (200, 60)];

/// A state of the screen.
pub(super) struct State {
    pub(super) name: &'static str,
    pub(super) make: fn(Config) -> Scene,
    /// Texts that each snapshot of the state contains.
    facts: &'static [&'static str],
}

pub(super) const STATES: &[State] = &[
    State {
        name: "waiting",
        make: |config| Scene::new(config),
        facts: &["no line yet", "no data", "R: record", "no rec"],
    },
    State {
        name: "tour",
        make: |config| {
            let mut scene = flight(config);
            scene.model.ui.begin_tour();
            scene
        },
        facts: &[
            "tour 1/8  Press Space: the robot stops",
            "Esc: no tour",
            "Space STOP",
        ],
    },
    State {
        name: "sensors",
        make: |config| chosen(busy(config), 2),
        facts: &[
            "F2 sensors",
            "22 in",
            "47 in",
            "of  -6",
            "last: ",
            "i trace",
        ],
    },
    State {
        name: "above",
        make: |config| chosen(busy(config), 3),
        facts: &["F3 from above", "22 in !", "EDGE", "motion left", "61 %"],
    },
    State {
        name: "plots",
        make: |config| {
            let mut scene = flight(config);
            scene.wait_ms(12_000);
            scene.drive(30, 3.0, 2);
            scene.hear_status();
            chosen(scene, 4)
        },
        facts: &[
            "F4 plots",
            "T: 1 min",
            "wheels in/s",
            "|-30 s",
            "now|",
            "T longer",
        ],
    },
    State {
        name: "commands",
        make: |config| {
            let mut scene = flight(config);
            commanded(&mut scene);
            chosen(scene, 5)
        },
        facts: &[
            "F5 commands",
            "REFUSED: not",
            "not confirmed",
            "queued",
            "x give up",
        ],
    },
    State {
        name: "lists",
        make: |config| {
            let mut scene = flight(config);
            scene.status.list = ListPlace {
                driven: 3,
                count: 12,
            };
            scene.hear_status();
            scene.press(&[KeyCode::Left; 4]);
            scene.type_text("w");
            scene.press(&[KeyCode::Esc]);
            chosen(scene, 5)
        },
        facts: &[
            "robot's route, not of this",
            "driven 3/12",
            "draft: 1 waypoint",
            "S send",
        ],
    },
    State {
        name: "log",
        make: |config| chosen(flight(config), 6),
        facts: &[
            "F6 log",
            "right bumper hit at (79, 39)",
            "INFRARED: something near",
        ],
    },
    State {
        name: "link",
        make: |config| chosen(measured(config), 7),
        facts: &[
            "F7 link",
            "loss 6.0 %, none damaged",
            "in 80 B",
            "37 frames",
            "in 0.4 s",
            "airtime ",
        ],
    },
    State {
        name: "alarms",
        make: |config| {
            let mut scene = flight(config);
            scene.state.power = Power::Critical;
            scene.hear();
            chosen(scene, 8)
        },
        facts: &[
            "BATTERY CRITICAL",
            "F8 alarms",
            "+1 more",
            "A: acknowledge",
            "A ack",
        ],
    },
    State {
        name: "silent",
        make: |config| {
            let mut scene = flight(config);
            scene.state.bump = Bump::None;
            (scene.state.wheel_left_in_s, scene.state.wheel_right_in_s) = (10, 10);
            scene.hear();
            scene.wait_ms(30_000);
            scene.event(Event::Tick);
            scene
        },
        facts: &["ROBOT SILENT", "stale: ", "reckoned, within"],
    },
    State {
        name: "lost",
        make: |config| {
            let mut scene = flight(config);
            scene.event(Event::Link(LinkEvent::Lost {
                reason: "the device is gone".to_owned(),
            }));
            scene.wait_ms(4500);
            scene
        },
        facts: &[
            "LINK LOST 4 s",
            "the device is gone",
            "Check cable, network or station",
        ],
    },
    State {
        name: "ended",
        make: |config| {
            let mut scene = flight(config);
            scene.event(Event::Link(LinkEvent::Ended));
            scene
        },
        facts: &["session ended"],
    },
    State {
        name: "past",
        make: |config| {
            let mut scene = flight_at(config, |scene| playback(scene, true));
            scene.state.power = Power::Low;
            scene.hear();
            scene
        },
        facts: &[
            "PAST 2 m",
            "BATTERY LOW",
            "commands go to the robot now",
            "p pause",
        ],
    },
    State {
        name: "replay",
        make: |config| flight_at(config, |scene| playback(scene, false)),
        facts: &["REPLAY ", "p pause", ", . line"],
    },
    State {
        name: "replay_being_read",
        make: |config| {
            flight_at(config, |scene| Playback {
                read_until: Some(Moment::from_mins(1)),
                is_partial: true,
                repeat: Some((Moment::from_secs(3), Some(Moment::from_secs(9)))),
                ..playback(scene, false)
            })
        },
        facts: &["REPLAY", "still reading"],
    },
    State {
        name: "help",
        make: |config| typed(config, "?"),
        facts: &[
            "keys",
            "STOP (Ctrl-S while typing)",
            "driving Space STOP",
            "Esc: back",
            "PgDn: ",
        ],
    },
    State {
        name: "help_of_commands",
        make: |config| {
            let mut scene = typed(config, ":help");
            scene.press(&[KeyCode::Enter]);
            scene
        },
        facts: &[
            "commands",
            "goto X Y",
            "failsafe M 30s",
            "PgDn: keys",
            "Esc: back",
        ],
    },
    State {
        name: "palette",
        make: |config| {
            let mut scene = flight(config);
            scene.ctrl('p');
            scene
        },
        facts: &["commands", "STOP", "modes: prowl", "Enter do it"],
    },
    State {
        name: "question",
        make: |config| typed(config, "d"),
        facts: &["Drive by hand?", "y yes", "n no", "Space STOP"],
    },
    State {
        name: "driving",
        make: |config| {
            let mut scene = typed(config, "dy");
            scene.state.mode = Mode::User;
            scene.hear();
            scene
        },
        facts: &["HAND DRIVE 8 in/s", "arrows hold to drive", "Esc let go"],
    },
    State {
        name: "typing",
        make: |config| {
            let mut scene = typed(config, ":mode prawl");
            scene.press(&[KeyCode::Enter]);
            scene
        },
        facts: &[":mode prawl", "did you mean `prowl`?", "Ctrl-S STOP"],
    },
    State {
        name: "jumping",
        make: |config| typed(config, "N"),
        facts: &[
            "to the last",
            "a alarm",
            "b bump",
            "c command",
            "m mark",
            "Esc back",
        ],
    },
    State {
        name: "tracing",
        make: |config| typed(config, "i"),
        facts: &["line A, columns", "arrows value and line"],
    },
    State {
        name: "why",
        make: |config| {
            let mut scene = flight(config);
            commanded(&mut scene);
            scene.type_text("y");
            scene
        },
        facts: &[
            "why, at 00:15",
            "suppressed  sonar, prowl",
            "wheels requested -6 -6",
            "no edge sensors",
        ],
    },
    State {
        name: "runs",
        make: |config| {
            let mut scene = typed(config, ":runs runs");
            scene.press(&[KeyCode::Enter]);
            scene.event(Event::Runs(Ok(listed())));
            scene.press(&[KeyCode::Char('c'), KeyCode::Up]);
            scene
        },
        facts: &[
            "runs in runs",
            "2026-11-19 19:02",
            "evening.mcap",
            "(void: the cat)",
            "Enter replay",
            "c compare",
        ],
    },
    State {
        name: "comparison",
        make: |config| {
            let mut scene = typed(config, ":compare a.mcap b.mcap");
            scene.press(&[KeyCode::Enter]);
            scene.event(Event::Overlaid(Ok(overlaid())));
            scene
        },
        facts: &["closing error", "+9.0 in", "on average", "Esc back"],
    },
    State {
        name: "route",
        make: |config| {
            let mut scene = drafting(config);
            scene.type_text("b>");
            scene
        },
        facts: &["route: 4, ", "about ", "S send", "draft"],
    },
    State {
        name: "drafting",
        make: |config| {
            let mut scene = flight(config);
            scene.press(&[KeyCode::Left; 4]);
            scene.type_text("w");
            scene
        },
        facts: &["arrows move", "w add", "S send", "u undo", "Esc back"],
    },
];

/// A robot with every sensor triggered.
pub(super) fn busy(config: Config) -> Scene {
    let mut scene = flight(config);
    scene.state.bump = Bump::LeftCenter;
    scene.state.sonar_left_in = Some(22);
    scene.state.sonar_right_in = Some(47);
    scene.state.cliff = Cliff::Right;
    scene.state.arm = Arm::MotionLeft;
    scene.hear();
    scene
}

/// The scene with a chosen panel, after the message about it has expired.
fn chosen(mut scene: Scene, key: u8) -> Scene {
    if key > 2 {
        scene.press(&[KeyCode::F(key)]);
    }
    scene
}

pub(super) fn typed(config: Config, keys: &str) -> Scene {
    let mut scene = flight(config);
    scene.type_text(keys);
    scene
}

fn without_colors(ascii: bool) -> Config {
    Config {
        colors: if ascii { Colors::Mono } else { Colors::Dark },
        ascii,
        ..demo()
    }
}

/// The texts clipped while a screen was drawn.
fn clipped(scene: &Scene, width: u16, height: u16) -> Vec<String> {
    CLIPPED.take();
    screen(scene, width, height);
    CLIPPED.take()
}

#[test]
fn every_state_shows_its_facts_at_every_size_with_and_without_colors() {
    let mut missing = Vec::new();
    for State { name, make, facts } in STATES {
        let mut pictures = String::new();
        for ascii in [false, true] {
            let scene = make(without_colors(ascii));
            for (width, height) in SIZES {
                let shown = screen(&scene, width, height);
                let untold = facts.iter().filter(|fact| !shown.contains(**fact));
                missing.extend(untold.map(|fact| format!("{name} at {width}x{height}: {fact}")));
                assert!(!ascii || shown.is_ascii(), "{name}\n{shown}");
                // At the largest size the variants differ in glyphs only.
                if !ascii || width < 200 {
                    let look = if ascii { ", monochrome, ASCII" } else { "" };
                    write!(pictures, "== {width}x{height}{look}\n{shown}").unwrap();
                }
            }
        }
        insta::assert_snapshot!(format!("every_{name}"), pictures);
    }
    assert_eq!(missing, [""; 0]);
}

#[test]
fn no_text_is_clipped_without_a_mark() {
    for State { name, make, .. } in STATES {
        for ascii in [false, true] {
            let mut scene = make(without_colors(ascii));
            for enlarged in [
                None,
                Some(Large::Panel),
                Some(Large::Map),
                Some(Large::Ladder),
            ] {
                scene.model.ui.enlarged = enlarged;
                for (width, height) in [
                    (80, 24),
                    (90, 30),
                    (110, 34),
                    (120, 40),
                    (170, 44),
                    (200, 60),
                ] {
                    let cut = clipped(&scene, width, height);
                    assert_eq!(cut, [""; 0], "{name} at {width}x{height}");
                }
            }
        }
    }
}
