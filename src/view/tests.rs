//! The screen as text: snapshots, and the important facts in each.

use crossterm::event::KeyCode;
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::{Bump, Infrared, Layer, LayerMask, LayerState, Link, Mode};
use groundwave_protocol::telemetry::{ListPlace, Outcome};
use groundwave_protocol::{LINE_BYTES, Waypoint};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;

mod enlarged;
mod every;
mod ground;
mod link;
mod narrow;
mod own;
mod palette;
mod panels;
mod parameters;
mod pointer;
mod property;
mod rebound;
mod time;
mod windows;

use super::draw;
use crate::event::{
    CommandId, CommandStatus, Effect, Event, Failure, Level, LineRate, LinkEvent, Moment, Notice,
    NoticeCode, Reception, Recording, Truth,
};
use crate::model::testing::{Scene, listed, overlaid};
use crate::model::{Colors, Config, Large, Shown};
use crate::request::{Request, Tuning};
use crate::safe_text::is_control;

fn buffer(scene: &Scene, width: u16, height: u16) -> Buffer {
    buffer_of(Shown::from(&scene.model), scene.now, width, height)
}

fn buffer_of(shown: Shown<'_>, now: Moment, width: u16, height: u16) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal
        .draw(|frame| draw(shown, now, frame.buffer_mut()))
        .unwrap();
    terminal.backend().buffer().clone()
}

/// The rows of the screen without trailing spaces.
fn screen(scene: &Scene, width: u16, height: u16) -> String {
    text(&buffer(scene, width, height))
}

/// The rows of a page, without the spaces at their ends.
fn text(buffer: &Buffer) -> String {
    let Rect { width, height, .. } = buffer.area;
    let rows = (0..height).map(|row| {
        let cells = (0..width).map(|column| buffer[(column, row)].symbol());
        cells.collect::<String>().trim_end().to_owned() + "\n"
    });
    rows.collect()
}

/// The row of a screen that contains a text.
fn row<'a>(screen: &'a str, words: &str) -> &'a str {
    screen
        .lines()
        .find(|row| row.contains(words))
        .unwrap_or_else(|| panic!("no `{words}` in\n{screen}"))
}

fn house() -> Truth {
    let (west, east, south, north) = (-120.0, 300.0, -150.0, 180.0);
    Truth {
        walls: vec![
            [(west, south), (east, south)],
            [(east, south), (east, north)],
            [(east, north), (west, north)],
            [(west, north), (west, south)],
            [(90.0, south), (90.0, -20.0)],
            [(90.0, 30.0), (90.0, north)],
        ],
        blocks: vec![
            [(87.0, south), (93.0, -20.0)],
            [(87.0, 30.0), (93.0, north)],
        ],
        furniture: vec![[(-60.0, 100.0), (0.0, 100.0)], [(0.0, 100.0), (0.0, north)]],
        circles: vec![((40.0, -60.0), 9.0), ((200.0, 60.0), 14.0)],
    }
}

/// A robot that has prowled through a house and has just bumped.
fn flight(config: Config) -> Scene {
    use LayerState::{Holds, Quiet, Raised};
    let mut scene = Scene::new(config);
    scene.event(Event::Truth(house()));
    scene.event(Event::Recording(Recording {
        mcap: Some("groundwave-20250314T092653Z.mcap".to_owned()),
        ..Recording::default()
    }));
    scene.hear_status();
    scene.hear_text("SR04 1.00 ready");
    scene.drive(12, 3.3, 0);
    scene.state.infrared = Infrared::Left;
    scene.layers(&[(Layer::Infrared, Holds), (Layer::Sonar, Raised)]);
    scene.state.rotation_in_s = 8;
    scene.drive(6, 2.5, 14);
    scene.state.infrared = Infrared::None;
    scene.layers(&[(Layer::Infrared, Quiet), (Layer::Sonar, Holds)]);
    scene.hear_ticks(30, [0, 0, 0, 100, 50, 0, 0, 0, 400]);
    scene.drive(20, 3.3, 1);
    scene.lose(2);
    scene.hear_ticks(60, [0, 20, 0, 160, 120, 0, 0, 0, 850]);
    scene.hear_status();
    scene.state.bump = Bump::Right;
    scene.state.velocity_in_s = -6;
    scene.state.wheel_left_in_s = -5;
    scene.state.wheel_right_in_s = -6;
    scene.state.rotation_in_s = 0;
    scene.state.sonar_left_in = None;
    scene.state.sonar_right_in = Some(31);
    scene.layers(&[(Layer::Bumpers, Holds), (Layer::Sonar, Raised)]);
    scene.drive(2, 0.0, 0);
    scene
}

/// Text that controls a terminal by C0 and C1, changes its direction and breaks a line.
const HOSTILE: &str = "\u{1b}]0;x\u{7}\u{9b}2J a\u{202e}b\u{2066}\u{61c}c\u{2028}\u{202e}\nFORGED";

#[test]
fn no_cell_holds_a_control_character() {
    let mut scene = Scene::new(demo());
    scene.event(Event::Link(LinkEvent::Opened {
        name: HOSTILE.to_owned(),
        can_send: true,
    }));
    let notice = Notice::new(NoticeCode::Recording, Level::Alarm, HOSTILE);
    scene.event(Event::Notice(notice));
    scene.event(Event::Link(LinkEvent::Lost {
        reason: HOSTILE.to_owned(),
    }));
    let mut two = (*overlaid()).clone();
    two.comparison.runs[0].capture = HOSTILE.to_owned();
    two.comparison.runs[1].void = Some(HOSTILE.to_owned());
    two.problems = vec![HOSTILE.to_owned()];
    for has_window in [false, true] {
        if has_window {
            scene.event(Event::Overlaid(Ok(two.clone().into())));
        }
        for (width, height) in [(80, 24), (120, 40)] {
            let page = buffer(&scene, width, height);
            let bad = page
                .content
                .iter()
                .find(|cell| cell.symbol().contains(is_control));
            assert_eq!(bad, None, "{width}x{height}");
            let screen = text(&page);
            assert!(
                screen.contains("2J") && !screen.contains("│ FORGED"),
                "{screen}"
            );
        }
    }
}

fn demo() -> Config {
    Config {
        raw_copy: Some("cat /dev/pts/5".to_owned()),
        ..Config::default()
    }
}

/// A confirmed route of two waypoints, a refused command, a timed-out one and a queued one.
fn commanded(scene: &mut Scene) -> u32 {
    scene.press(&[KeyCode::Left; 8]);
    scene.type_text("w");
    scene.press(&[KeyCode::Down; 8]);
    scene.type_text("w");
    let effects = scene.type_text("S");
    let [Effect::Send(Request::Route(route))] = &effects[..] else {
        panic!("sending the draft gave {effects:?}");
    };
    let digest = digest(route.iter());
    scene.command(
        1,
        Request::Mode(Mode::Prowl),
        CommandStatus::Confirmed { digest: None },
    );
    scene.command(
        2,
        Request::Route(route.clone()),
        CommandStatus::Confirmed {
            digest: Some(digest),
        },
    );
    scene.command(3, Request::Scan, CommandStatus::Refused(Outcome::NotFitted));
    scene.command(
        4,
        Request::Mode(Mode::Reactive),
        CommandStatus::Failed(Failure::TimedOut),
    );
    scene.ask(5, Request::Disable(LayerMask::NONE.with(Layer::Sonar)));
    scene.hear();
    digest
}

#[test]
fn a_flight_at_120_by_40() {
    let scene = flight(demo());
    let screen = screen(&scene, 120, 40);
    insta::assert_snapshot!(screen);
    row(&screen, "BUMPERS hold the motors: right bumper hit; backs");
    row(&screen, "off; suppress SONAR, PROWL");
    row(&screen, "newest <1 s");
    row(&screen, "right bumper hit at (79, 39)");
    row(&screen, "simulator's truth");
    row(
        &screen,
        "recorded in groundwave-20250314T092653Z.mcap · raw in another terminal: cat /dev/pts/5",
    );
    assert!(row(&screen, "1 ▶ BUMPERS").contains("HOLDS"));
    assert!(row(&screen, "4 △ sonar").contains("12 %"), "by line C");
}

#[test]
fn a_flight_at_80_by_24() {
    let mut scene = flight(demo());
    let sensors = screen(&scene, 80, 24);
    insta::assert_snapshot!(sensors);
    row(&sensors, "BUMPERS hold the motors: right bumper");
    row(&sensors, "loss 4.3 %");
    row(
        &sensors,
        "groundwave-20250314T092653Z.mcap · raw: cat /dev/pts/5",
    );
    assert!(row(&sensors, "● sim").ends_with("◉ REC"));
    for (panel, words) in [
        ("F5 commands", "No commands sent"),
        ("F6 log", "right bumper hit at"),
    ] {
        while !screen(&scene, 80, 24).contains(&format!("── {panel}")) {
            scene.press(&[KeyCode::Tab]);
        }
        let screen = screen(&scene, 80, 24);
        row(&screen, &format!("── {panel}"));
        row(&screen, words);
    }
}

#[test]
fn commands_at_120_by_40_and_at_80_by_24() {
    let mut scene = flight(Config::default());
    commanded(&mut scene);
    let wide = screen(&scene, 120, 40);
    insta::assert_snapshot!("commands_wide", wide);
    row(&wide, "2 route of 2                  ✔ confirmed in ");
    row(&wide, "3 scan                        ✖ REFUSED: not fitted");
    assert!(row(&wide, "4 △ sonar").contains("disabling"));
    scene.press(&[KeyCode::F(5)]);
    let narrow = screen(&scene, 80, 24);
    insta::assert_snapshot!("commands_narrow", narrow);
    row(&narrow, "── F5 commands");
    scene.press(&[KeyCode::PageUp]);
    row(
        &screen(&scene, 80, 24),
        "2 route of 2           ✔ confirmed in",
    );
}

#[test]
fn a_plain_terminal_shows_the_same_facts() {
    let mut scene = flight(Config {
        colors: Colors::Mono,
        ascii: true,
        ..Config::default()
    });
    commanded(&mut scene);
    for keys in ["", "?", "?d"] {
        scene.type_text(keys);
        let screen = screen(&scene, 120, 40);
        assert!(screen.is_ascii(), "{screen}");
    }
    scene.type_text("n");
    insta::assert_snapshot!(screen(&scene, 120, 40));
    let buffer = buffer(&scene, 120, 40);
    let colored = buffer.content().iter().find(|cell| {
        (cell.fg, cell.bg) != (ratatui::style::Color::Reset, ratatui::style::Color::Reset)
    });
    assert_eq!(colored, None);
}

#[test]
fn dialogs_at_80_by_24() {
    let mut scene = flight(Config::default());
    scene.type_text("?");
    let help = screen(&scene, 80, 24);
    insta::assert_snapshot!("help", help);
    row(
        &help,
        "driving Space STOP  arrows hold to drive  + - speed  Esc let go",
    );
    row(&help, "typing  Ctrl-S STOP  Enter do it  Esc cancel");
    scene.type_text("?d");
    insta::assert_snapshot!("question", screen(&scene, 80, 24));
    scene.type_text("y");
    row(&screen(&scene, 80, 24), "HAND DRIVE: not in mode user yet");
    scene.state.mode = Mode::User;
    scene.hear();
    row(&screen(&scene, 80, 24), "HAND DRIVE 8 in/s");
    scene.press(&[KeyCode::Esc]);
    scene.type_text(":mode prawl");
    scene.press(&[KeyCode::Enter]);
    let typing = screen(&scene, 80, 24);
    row(&typing, ":mode prawl▏");
    row(&typing, "unknown mode `prawl`; did you mean `prowl`?");
}

#[test]
fn a_lost_link_shows_at_once_and_values_age() {
    let mut scene = flight(demo());
    scene.event(Event::Link(LinkEvent::Lost {
        reason: "the device is gone".to_owned(),
    }));
    let said_once = |screen: &str| {
        row(screen, "✖ sim  the device is gone");
        assert_eq!(screen.matches("LINK LOST").count(), 1, "{screen}");
    };
    said_once(&screen(&scene, 120, 40));
    scene.wait_ms(4500);
    let lost = screen(&scene, 120, 40);
    said_once(&lost);
    insta::assert_snapshot!(lost);
    assert!(row(&lost, "bumper   ✖").contains("◌ 4 s"));
    row(&lost, "who holds the motors ─────────────── ◌ 4 s");
}

/// The owner reads in the hint row that somebody else commands.
#[test]
fn the_command_of_a_client_is_told_with_its_client() {
    let mut scene = flight(demo());
    scene.event(Event::Asked {
        id: CommandId(9),
        request: Request::Stop,
        by: Some("pid 7".to_owned()),
    });
    scene.status_of(9, CommandStatus::Confirmed { digest: None });
    row(&screen(&scene, 80, 24), "stop from pid 7: confirmed");
}

/// Nor does a list of parameters, which brings news every second, hide the answer to a key.
#[test]
fn the_answer_to_a_key_is_readable() {
    let mut scene = flight(demo());
    scene.ask(9, Request::Parameter(Tuning::List));
    scene.type_text("T");
    for _ in 0..3 {
        row(&screen(&scene, 80, 24), "plots");
        scene.wait_ms(500);
        scene.status_of(9, CommandStatus::Sent { frames: 1 });
    }
    scene.wait_ms(600);
    scene.status_of(9, CommandStatus::Sent { frames: 2 });
    row(&screen(&scene, 80, 24), "param list: sent 2 frames");
}

/// The alarm row tells of a STOP that waits for the link, until it is given up.
#[test]
fn a_stop_on_a_lost_link_is_said_to_wait() {
    let mut scene = flight(demo());
    scene.event(Event::Link(LinkEvent::Lost {
        reason: "the device is gone".to_owned(),
    }));
    scene.ask(9, Request::Stop);
    for (width, height) in [(80, 24), (120, 40)] {
        row(
            &screen(&scene, width, height),
            "STOP NOT SENT: waits for the link; x gives up",
        );
    }
    let cancelled = CommandStatus::Failed(Failure::Cancelled);
    scene.status_of(9, cancelled);
    assert!(!screen(&scene, 120, 40).contains("STOP NOT SENT"));
}

/// Nor is a STOP that the robot does not confirm forgotten, whatever else is news.
#[test]
fn a_stop_without_a_confirmation_is_told_until_it_ends() {
    let mut scene = flight(demo());
    scene.ask(9, Request::Stop);
    scene.status_of(9, CommandStatus::Sent { frames: 1 });
    assert!(!screen(&scene, 80, 24).contains("STOP NOT CONFIRMED"));
    scene.wait_ms(12_000);
    for (width, height) in [(80, 24), (120, 40)] {
        row(
            &screen(&scene, width, height),
            "STOP NOT CONFIRMED 12 s: sent until it is; x gives up",
        );
    }
    scene.status_of(9, CommandStatus::Failed(Failure::TimedOut));
    row(
        &screen(&scene, 80, 24),
        "STOP FAILED: not confirmed; Space sends it again",
    );
    scene.command(10, Request::Stop, CommandStatus::Confirmed { digest: None });
    assert!(!screen(&scene, 80, 24).contains("STOP FAILED"));
}

/// The reason of a loss is shown whole or not at all.
#[test]
fn the_reason_of_a_loss_is_never_cut() {
    let mut scene = flight(demo());
    let reason = "the other end closed the connection";
    scene.event(Event::Link(LinkEvent::Lost {
        reason: reason.to_owned(),
    }));
    row(&screen(&scene, 120, 40), &format!("✖ sim  {reason}"));
    // Without the alarm strip, the status row says that the link is lost.
    scene.type_text("A");
    let narrow = screen(&scene, 80, 24);
    let status = narrow.lines().find(|line| line.contains("✖ sim")).unwrap();
    assert!(status.contains("LINK LOST <1 s "), "{status}");
    assert!(
        !status.contains('…') && !status.contains("the other"),
        "{status}"
    );
    row(
        &screen(&scene, 120, 40),
        &format!("LINK LOST <1 s: {reason}"),
    );
}

#[test]
fn a_silent_robot_differs_from_a_lost_link() {
    let mut scene = flight(demo());
    scene.wait_ms(3100);
    let silent = screen(&scene, 80, 24);
    row(&silent, "○ sim  SILENT for 3 s");
    assert!(!silent.contains("LOST"));
    scene.wait_ms(12_000);
    scene.event(Event::Tick);
    let silent = screen(&scene, 80, 24);
    row(&silent, "✖ ROBOT SILENT");
    assert_eq!(silent.matches("SILENT").count(), 1, "{silent}");
    // Without the alarm strip, the status row says it.
    scene.type_text("A");
    row(&screen(&scene, 80, 24), "○ sim  SILENT for 15 s");
}

#[test]
fn bytes_without_lines_are_described_for_hours() {
    let mut scene = flight(demo());
    let since = scene.now;
    scene.wait_ms(3 * 3600 * 1000);
    for (reception, words) in [
        (Reception::Nothing, "○ sim  no bytes "),
        (Reception::Noise, "○ sim  only noise "),
        (
            Reception::WrongRate(LineRate::Slower),
            "○ sim  wrong baud rate? ",
        ),
    ] {
        scene.event(Event::Reception { reception, since });
        row(&screen(&scene, 140, 40), words);
    }
    let reception = Reception::Lines;
    scene.event(Event::Reception { reception, since });
    assert!(!screen(&scene, 140, 40).contains("wrong baud rate"));
}

#[test]
fn a_failed_recording_is_an_alarm() {
    let mut scene = flight(Config::default());
    scene.event(Event::Recording(Recording {
        mcap: Some("session.mcap".to_owned()),
        problem: Some("the disk is full".to_owned()),
        ..Recording::default()
    }));
    row(
        &screen(&scene, 120, 40),
        "  RECORDING FAILED: the disk is full",
    );
    row(&screen(&scene, 120, 40), "Make room");
    scene.event(Event::Recording(Recording {
        problem: Some("the disk has written nothing for 30 s".to_owned()),
        is_disk_silent: true,
        ..Recording::default()
    }));
    row(&screen(&scene, 120, 40), "The disk does not answer");
}

#[test]
fn the_simulators_truth_can_be_hidden() {
    let mut scene = flight(Config::default());
    scene.type_text("t");
    let without = screen(&scene, 120, 40);
    assert!(!without.contains("simulator's truth"));
    scene.type_text("t");
    assert_ne!(screen(&scene, 120, 40), without);
}

#[test]
fn a_map_is_as_wide_as_it_is_high() {
    // Walls of a square 160 inches a side.
    let mut scene = Scene::new(Config::default());
    let (low, high) = (-80.0, 80.0);
    let corners = [
        (low, low),
        (low, high),
        (high, high),
        (high, low),
        (low, low),
    ];
    scene.event(Event::Truth(Truth {
        walls: corners.windows(2).map(|pair| [pair[0], pair[1]]).collect(),
        ..Truth::default()
    }));
    let buffer = buffer(&scene, 120, 40);
    let braille = |column, row| {
        let symbol = buffer[(column, row)].symbol().chars().next();
        symbol.is_some_and(|c| ('\u{2801}'..='\u{28ff}').contains(&c))
    };
    let columns = (0..120)
        .filter(|&column| (0..40).any(|row| braille(column, row)))
        .count();
    let rows = (0..40)
        .filter(|&row| (0..120).any(|column| braille(column, row)))
        .count();
    assert!(
        rows > 10 && columns.abs_diff(2 * rows) <= 2,
        "{columns}x{rows}"
    );
}

#[test]
fn driven_waypoints_show_only_for_the_confirmed_digest() {
    let mut scene = flight(Config::default());
    let digest = commanded(&mut scene);
    scene.status.list = ListPlace {
        driven: 1,
        count: 2,
    };
    scene.status.digest = digest;
    scene.hear_status();
    let same = screen(&scene, 120, 40);
    row(&same, "✔ driving 1/2");
    scene.state.mode = Mode::Stop;
    scene.hear();
    let stopped = screen(&scene, 120, 40);
    row(&stopped, "✔ driven 1/2. Press m p to");
    scene.state.mode = Mode::Prowl;
    scene.hear();
    scene.status.digest ^= 1;
    scene.hear_status();
    let other = screen(&scene, 120, 40);
    assert!(!other.contains("driving "), "{other}");
    row(
        &other,
        "2 route of 2                  ✔ replaced, driven 1/2",
    );
    row(&other, "robot's route, not of this session: driven 1/2");
}

#[test]
fn the_raw_line_is_under_its_ruler() {
    let scene = flight(Config::default());
    let screen = screen(&scene, 120, 40);
    let rows: Vec<&str> = screen.lines().collect();
    let at = rows
        .iter()
        .position(|row| row.starts_with("1...5...10"))
        .unwrap();
    assert_eq!(rows[at].len(), LINE_BYTES);
    assert_eq!(&rows[at + 1][60..61], "P", "the mode is in column 61");
}

#[test]
fn a_distant_waypoint_is_visible() {
    let mut scene = flight(Config::default());
    let far = Waypoint {
        x_in: 9999,
        y_in: -9999,
    };
    scene.event(Event::RouteLoaded {
        path: "far.txt".to_owned(),
        route: Ok(vec![far]),
    });
    row(&screen(&scene, 120, 40), "◇");
}

/// A robot and a drafted square in the route editor.
fn drafting(config: Config) -> Scene {
    let mut scene = flight(config);
    scene.type_text("e");
    for (x_in, y_in) in [(0, 0), (48, 0), (48, 48), (0, 48)] {
        let at = crate::model::draft::Edit::AppendAt(f64::from(x_in), f64::from(y_in));
        scene.model.ui.map.draft.edit(at, None).unwrap();
    }
    scene
}

#[test]
fn the_draft_is_a_list_beside_the_map() {
    for (name, width, height) in [("route_narrow", 80, 24), ("route_wide", 120, 40)] {
        let mut scene = drafting(Config::default());
        scene.type_text("b>");
        let shown = screen(&scene, width, height);
        for fact in ["route: 4, ", "about ", "robot", "arrows move", "S send"] {
            assert!(shown.contains(fact), "{fact} is not on\n{shown}");
        }
        insta::assert_snapshot!(name, shown);
        scene.model.ui.enlarged = Some(Large::Panel);
        assert!(
            screen(&scene, width, height).contains("route: 4, "),
            "what is edited is seen"
        );
        scene.type_text("?");
        assert!(screen(&scene, width, height).contains("insert one before it"));
    }
}
