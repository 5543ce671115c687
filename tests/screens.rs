//! The whole dashboard, drawn from captures that do not change.

use std::path::Path;
use std::time::Duration;

use groundwave::capture::Capture;
use groundwave::event::{Event, LinkEvent};
use groundwave::model::{Config, Model};
use groundwave::station::Station;
use groundwave::view;
use groundwave_protocol::arq;
use ratatui::Terminal;
use ratatui::backend::TestBackend;

/// Plays a capture until a time and draws the screen then.
fn screen(capture: &str, until: Duration, width: u16, height: u16) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("captures")
        .join(capture);
    let mut capture = Capture::open(path).expect("a capture of ours");
    let mut station = Station::new(arq::Config::new(1), false);
    let mut model = Model::new(Config::default());
    model.update(Duration::ZERO, Event::Resize { width, height });
    station.handle_link(LinkEvent::Opened {
        name: "radio".to_owned(),
        can_send: false,
    });
    while let Some(chunk) = capture.next_chunk().expect("an undamaged capture") {
        if chunk.at > until {
            break;
        }
        station.handle_bytes(chunk.at, chunk.bytes);
        while let Some(event) = station.poll_event() {
            model.update(chunk.at, event);
        }
    }
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a buffer");
    terminal
        .draw(|frame| view::draw(&model, until, frame))
        .expect("a buffer takes it");
    terminal.backend().to_string()
}

#[test]
fn a_route_under_way_at_120x40() {
    let screen = screen("demo-commands.mcap", Duration::from_secs(30), 120, 40);
    insta::assert_snapshot!(screen);
    assert!(screen.contains("hold the motors") || screen.contains("holds the motors"));
    assert!(screen.contains("newest <1 s"));
    // What this station has not sent, it does not claim.
    assert!(!screen.contains("ACTIVE"));
}

#[test]
fn a_route_under_way_at_80x24() {
    let screen = screen("demo-commands.mcap", Duration::from_secs(30), 80, 24);
    insta::assert_snapshot!(screen);
    assert!(screen.contains("hold the motors") || screen.contains("holds the motors"));
}

#[test]
fn a_noisy_radio_at_120x40() {
    let screen = screen("house-noisy.txt", Duration::from_mins(1), 120, 40);
    insta::assert_snapshot!(screen);
    let loss = screen
        .split("loss ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .expect("the loss");
    assert!(loss.parse::<f64>().is_ok_and(|loss| loss > 30.0), "{loss}");
}

/// Fifteen seconds of silence: what is old says so.
#[test]
fn a_silent_radio_at_120x40() {
    let screen = screen("living-room-bursts.txt", Duration::from_secs(1000), 120, 40);
    insta::assert_snapshot!(screen);
    assert!(!screen.contains("newest <1 s"));
    assert!(screen.contains("newest"));
}
