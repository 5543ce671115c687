//! The screen as text.

use groundwave_protocol::letters::{Bump, Infrared, Layer, LayerState};
use ratatui::Terminal;
use ratatui::backend::TestBackend;

use super::draw;
use crate::event::{Event, Recording, Truth};
use crate::model::Config;
use crate::model::testing::Scene;

/// The screen, row by row, without the spaces at the ends of rows.
fn screen(scene: &Scene, width: u16, height: u16) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal
        .draw(|frame| draw(&scene.model, scene.now, frame))
        .unwrap();
    let buffer = terminal.backend().buffer();
    let mut text = String::new();
    for row in 0..height {
        let cells = (0..width).map(|column| buffer[(column, row)].symbol());
        let line: String = cells.collect();
        text += line.trim_end();
        text.push('\n');
    }
    text
}

fn house() -> Truth {
    let (w, e, s, n) = (-120.0, 300.0, -150.0, 180.0);
    Truth {
        walls: vec![
            [(w, s), (e, s)],
            [(e, s), (e, n)],
            [(e, n), (w, n)],
            [(w, n), (w, s)],
            [(90.0, s), (90.0, -20.0)],
            [(90.0, 30.0), (90.0, n)],
            [(-60.0, 100.0), (0.0, 100.0)],
            [(0.0, 100.0), (0.0, n)],
        ],
        circles: vec![((40.0, -60.0), 9.0), ((200.0, 60.0), 14.0)],
    }
}

/// A robot that has prowled through a house for a while and has just hit something.
fn flight(config: Config) -> Scene {
    let mut scene = Scene::new(config);
    scene.event(Event::Truth(house()));
    scene.event(Event::Recording(Recording {
        mcap: Some("/tmp/flights/session.mcap".to_owned()),
        ..Recording::default()
    }));
    scene.hear_status();
    scene.hear_text("SR04 1.00 ready");
    scene.drive(12, 3.3, 0);
    scene.state.infrared = Infrared::Left;
    scene.layers(&[
        (Layer::Infrared, LayerState::Holds),
        (Layer::Sonar, LayerState::Raised),
    ]);
    scene.state.rotation_in_s = 8;
    scene.drive(6, 2.5, 14);
    scene.state.infrared = Infrared::None;
    scene.layers(&[
        (Layer::Infrared, LayerState::Quiet),
        (Layer::Sonar, LayerState::Holds),
    ]);
    scene.hear_ticks(30, [0, 0, 0, 100, 50, 0, 0, 0, 400]);
    scene.drive(20, 3.3, 1);
    scene.lose(2);
    scene.hear_ticks(60, [0, 20, 0, 160, 120, 0, 0, 0, 850]);
    scene.hear_status();
    scene.state.bump = Bump::Right;
    scene.state.velocity_in_s = -6;
    scene.state.wheel_left_in_s = -5;
    scene.state.wheel_right_in_s = -6;
    scene.layers(&[
        (Layer::Bumpers, LayerState::Holds),
        (Layer::Sonar, LayerState::Raised),
    ]);
    scene.state.rotation_in_s = 0;
    scene.state.sonar_left_in = None;
    scene.state.sonar_right_in = Some(31);
    scene.drive(2, 0.0, 0);
    scene
}

#[test]
fn look() {
    let config = Config {
        hint: Some("raw: cat /dev/pts/5".to_owned()),
        ..Config::default()
    };
    let scene = flight(config);
    println!("{}", screen(&scene, 120, 40));
    println!("{}", screen(&scene, 80, 24));
}

#[test]
fn look_at_the_rest() {
    use crate::event::*;
    use crate::request::Request;
    use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
    let mut scene = flight(Config {
        colors: crate::model::Colors::Mono,
        ascii: true,
        hint: None,
    });
    let key = |c| Event::Key(KeyEvent::new(KeyCode::Char(c), KeyModifiers::NONE));
    let arrow = |c| Event::Key(KeyEvent::new(c, KeyModifiers::NONE));
    for _ in 0..8 {
        scene.event(arrow(KeyCode::Left));
    }
    scene.event(key('w'));
    for _ in 0..8 {
        scene.event(arrow(KeyCode::Down));
    }
    scene.event(key('w'));
    println!("{}", screen(&scene, 120, 40));
    let effects = scene.event(key('S'));
    println!("{effects:?}");
    let Effect::Send(Request::Route(list)) = &effects[0] else {
        panic!()
    };
    let digest = groundwave_protocol::digest::digest(list.iter());
    scene.event(Event::Command {
        id: CommandId(1),
        step: CommandStep::Queued(Request::Mode(groundwave_protocol::letters::Mode::Prowl)),
    });
    scene.event(Event::Command {
        id: CommandId(1),
        step: CommandStep::Sent { attempt: 1 },
    });
    scene.event(Event::Command {
        id: CommandId(1),
        step: CommandStep::Proven { digest: None },
    });
    scene.event(Event::Command {
        id: CommandId(2),
        step: CommandStep::Queued(Request::Route(list.clone())),
    });
    scene.event(Event::Command {
        id: CommandId(2),
        step: CommandStep::Sent { attempt: 2 },
    });
    scene.event(Event::Command {
        id: CommandId(2),
        step: CommandStep::Proven {
            digest: Some(digest),
        },
    });
    scene.event(Event::Command {
        id: CommandId(3),
        step: CommandStep::Queued(Request::Route(list.clone())),
    });
    scene.event(Event::Command {
        id: CommandId(3),
        step: CommandStep::Sent { attempt: 2 },
    });
    scene.event(Event::Command {
        id: CommandId(3),
        step: CommandStep::Failed(Failure::TimedOut),
    });
    scene.status.list.count = 2;
    scene.status.list.driven = 1;
    scene.status.target_in = Some((40, 0));
    scene.status.digest = digest;
    scene.hear_status();
    scene.event(key('4'));
    scene.event(Event::Command {
        id: CommandId(4),
        step: CommandStep::Queued(Request::Disable(
            groundwave_protocol::letters::LayerMask::NONE.with(Layer::Sonar),
        )),
    });
    scene.hear();
    println!("{}", screen(&scene, 120, 40));
    scene.event(arrow(KeyCode::Tab));
    scene.event(key('d'));
    println!("{}", screen(&scene, 80, 24));
    scene.event(key('y'));
    println!("{}", screen(&scene, 80, 24));
    scene.event(arrow(KeyCode::Esc));
    scene.event(key('?'));
    println!("{}", screen(&scene, 80, 24));
    println!("{}", screen(&scene, 120, 40));
    scene.event(key('?'));
    scene.event(key(':'));
    scene.event(Event::Paste("mode prawl".into()));
    scene.event(arrow(KeyCode::Enter));
    scene.event(Event::Link(LinkEvent::Lost {
        reason: "the device is gone".into(),
    }));
    scene.wait_ms(4500);
    scene.event(key('+'));
    println!("{}", screen(&scene, 80, 24));
    println!("{}", screen(&scene, 200, 60));
    println!("{}", screen(&scene, 40, 10));
}
