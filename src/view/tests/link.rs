//! The link's figures and the failsafe.

use crossterm::event::KeyCode;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{Link, Mode};

use super::{flight, row, screen};
use crate::event::{Event, LinkEvent};
use crate::model::Config;
use crate::model::testing::Scene;
use crate::statistics::{Confirmation, Loss, Resync, Statistics};

fn statistics() -> Statistics {
    Statistics {
        lines: 940,
        loss: Loss {
            lines_lost: 60,
            lines_lost_max: Some(60),
            loss_pct: 6.0,
            loss_max_pct: 6.0,
        },
        resync: Some(Resync {
            count: 52,
            last_bytes: 80,
            mean_bytes: 96.4,
            worst_bytes: 412,
        }),
        frames: 37,
        frames_again: 5,
        confirmation: Some(Confirmation {
            count: 4,
            last_s: 0.42,
            mean_s: 0.61,
            worst_s: 1.27,
        }),
        airtime_down_pct: Some(98.6),
        airtime_up_pct: Some(2.4),
        ..Statistics::default()
    }
}

pub(super) fn measured(config: Config) -> Scene {
    let mut scene = flight(config);
    scene.failsafe = Some(Failsafe {
        silence_s: 30,
        mode: Mode::GoHome,
    });
    scene.hear_ticks(61, [0, 20, 0, 160, 120, 0, 0, 0, 850]);
    scene.state.link = Link::Armed;
    scene.hear();
    scene.event(Event::Statistics(Box::new(statistics())));
    scene
}

#[test]
fn figures_are_beside_the_log() {
    let scene = measured(Config::default());
    let wide = screen(&scene, 120, 40);
    insta::assert_snapshot!("link_wide", wide);
    row(&wide, "── F7 link");
    row(&wide, "── F6 log");
    row(&wide, "received  loss 6.0 %, none damaged; airtime 99 %");
    row(&wide, "regained  in 80 B, mean 96, worst 412");
    row(&wide, "sent      37 frames, 5 repeated; airtime 2 %");
    row(&wide, "confirmed in 0.4 s, mean 0.6, worst 1.3");
    let status = wide.lines().next().unwrap();
    assert!(status.contains("  failsafe  "), "{status}");
}

#[test]
fn figures_are_reachable_on_the_smallest_screen() {
    let mut scene = measured(Config::default());
    scene.press(&[KeyCode::F(7)]);
    let narrow = screen(&scene, 80, 24);
    insta::assert_snapshot!("link_narrow", narrow);
    row(&narrow, "── F7 link");
    row(&narrow, "received  loss 6.0 %, none damaged");
    row(&narrow, "airtime   99 % down, 2 % up");
    row(&narrow, "confirmed in 0.4 s, mean 0.6, worst 1.3");
    row(&narrow, "failsafe  home after 30 s of silence");
    // On a low screen the figures replace the log.
    assert!(screen(&scene, 110, 34).contains("── F7 link"));
    scene.press(&[KeyCode::Tab]);
    assert!(!screen(&scene, 110, 34).contains("── F7 link"));
}

#[test]
fn an_active_failsafe_shows_on_every_screen() {
    let mut scene = measured(Config::default());
    scene.state.link = Link::Failsafe;
    scene.hear();
    for (width, height) in [(80, 24), (100, 30), (120, 40), (200, 60)] {
        let screen = screen(&scene, width, height);
        let status = screen.lines().next().unwrap().to_lowercase();
        assert!(status.contains("failsafe"), "{screen}");
        row(&screen, "FAILSAFE acts: home after 30 s of silence");
    }
}

#[test]
fn meaningless_figures_are_left_out() {
    let mut scene = measured(Config::default());
    scene.event(Event::Statistics(Box::new(Statistics {
        not_taken_bytes: 12,
        ..statistics()
    })));
    let told = screen(&scene, 120, 40);
    row(&told, "sent      12 B NOT TAKEN, 37 frames, 5 repeated");
    scene.event(Event::Link(LinkEvent::Opened {
        name: "-".to_owned(),
        can_send: false,
    }));
    assert!(!screen(&scene, 120, 40).contains("confirmed in"));
}
