//! The whole dashboard, drawn from sample captures.

use std::path::Path;
use std::time::Duration;

use groundwave::capture::{Capture, CaptureError};
use groundwave::event::{Event, LinkEvent};
use groundwave::model::{Config, Model};
use groundwave::station::Station;
use groundwave::view;
use groundwave_protocol::arq;
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::status_codes::{Layer, LayerState};
use groundwave_protocol::telemetry::Body;
use ratatui::Terminal;
use ratatui::backend::TestBackend;

/// The screen at a time of a capture.
fn screen(capture: &str, until: Duration, width: u16, height: u16) -> String {
    screen_of(capture, until, (width, height), |_| true)
}

/// The screen of a model that receives only some events.
fn screen_of(
    capture: &str,
    until: Duration,
    (width, height): (u16, u16),
    hears: fn(&Event) -> bool,
) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("captures")
        .join(capture);
    let mut capture = Capture::open(path).expect("a capture of ours");
    let mut station = Station::new(arq::Config::new(1), false);
    let mut model = Model::new(Config::default());
    model.update(Duration::ZERO, Event::Resize { width, height });
    station.handle_link(
        Duration::ZERO,
        LinkEvent::Opened {
            name: "radio".to_owned(),
            can_send: false,
        },
    );
    while let Some(chunk) = capture.next_chunk().expect("an undamaged capture") {
        if chunk.at > until {
            break;
        }
        station.handle_bytes(chunk.at, chunk.bytes);
        while let Some(event) = station.poll_event() {
            if hears(&event) {
                model.update(chunk.at, event);
            }
        }
    }
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a buffer");
    terminal
        .draw(|frame| view::draw(&model, until, frame.buffer_mut()))
        .expect("a buffer takes it");
    terminal.backend().to_string()
}

/// Time at which the robot first drives a partly driven route.
fn under_way(capture: &str) -> Duration {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("captures")
        .join(capture);
    let mut capture = Capture::open(path).expect("a capture of ours");
    let (mut is_partly_driven, mut moment) = (false, None);
    let seen = capture.for_each_line(&mut Decoder::default(), |at, received| {
        if let Received::Line(line, _) = received {
            match &line.body {
                Body::Status(status) => is_partly_driven |= status.list.driven > 0,
                Body::State(state)
                    if state.layers.get(Layer::DeadReckoning) == LayerState::Holds =>
                {
                    moment = moment.or(is_partly_driven.then_some(at));
                }
                _ => {}
            }
        }
        Ok::<_, CaptureError>(())
    });
    seen.expect("an undamaged capture");
    moment.expect("a capture in which a route is driven")
}

#[test]
fn a_route_under_way_at_120x40() {
    let moment = under_way("demo-commands.mcap");
    let screen = screen("demo-commands.mcap", moment, 120, 40);
    insta::assert_snapshot!(screen);
    assert!(screen.contains("DEAD RECKONING holds the motors"));
    assert!(screen.contains("newest <1 s"));
    assert!(screen.contains("robot's route, not of this session: driven 1/4"));
    // A station does not claim another station's route.
    assert!(!screen.contains("✔ confirmed"));
}

#[test]
fn a_route_under_way_at_80x24() {
    let moment = under_way("demo-commands.mcap");
    let screen = screen("demo-commands.mcap", moment, 80, 24);
    insta::assert_snapshot!(screen);
    assert!(screen.contains("DEAD RECKONING holds the motors"));
    assert!(screen.contains("loss 0.0 %") && screen.contains("READ ONLY"));
}

#[test]
fn a_noisy_radio_at_120x40() {
    let screen = screen("house-noisy.txt", Duration::from_mins(1), 120, 40);
    insta::assert_snapshot!(screen);
    let share = |name: &str| {
        let figure = screen.split(name).nth(1)?.split(' ').next()?;
        figure.parse::<f64>().ok()
    };
    assert!(share("damaged ").is_some_and(|damaged_pct| damaged_pct > 30.0));
    assert!(share("loss ").is_some_and(|loss_pct| loss_pct < 20.0));
}

/// The screen a quarter of an hour after the last line.
#[test]
fn a_silent_radio_at_120x40() {
    let screen = screen("living-room-bursts.txt", Duration::from_secs(1000), 120, 40);
    insta::assert_snapshot!(screen);
    assert!(screen.contains("○ radio  SILENT for 14 m"));
    for row in ["who holds", "bumper ", "sonar ", "battery ", "drive "] {
        let aged = |line: &str| line.contains(row) && line.contains("◌ 14 m");
        assert!(screen.lines().any(aged), "{row}");
    }
}

/// Shares counted from line C (ticks) and from line A (received lines) agree.
#[test]
fn shares_by_line_c_are_those_by_line_a() {
    let shares = |hears| {
        let at = Duration::from_secs(100);
        let screen = screen_of("living-room-bursts.txt", at, (120, 40), hears);
        let share = |name: &str| {
            let rung = |row: &&str| row.to_lowercase().contains(&format!(" {name} "));
            let row = screen
                .lines()
                .filter(rung)
                .find(|row| row.contains(" %\""))?;
            let words: Vec<&str> = row.trim_end_matches(" %\"").split(' ').collect();
            words.last()?.parse::<i32>().ok()
        };
        ["bumpers", "infrared", "sonar", "prowl"].map(|name| share(name).unwrap_or(0))
    };
    let by_c = shares(|_| true);
    let by_a = shares(
        |event| !matches!(event, Event::Line { line, .. } if matches!(line.body, Body::Counters(_))),
    );
    assert!(by_c.iter().sum::<i32>() >= 95, "{by_c:?}");
    assert_ne!(by_c, by_a, "two counts");
    for (c, a) in by_c.into_iter().zip(by_a) {
        assert!(c.abs_diff(a) <= 8, "{by_c:?} {by_a:?}");
    }
}
