//! Trail, marks and what the map follows.

use super::*;
use crate::model::bounds::Bounds;

#[test]
fn after_a_restart_the_map_starts_afresh() {
    let mut scene = scene();
    scene.drive(10, 3.0, 0);
    scene.state.bump = Bump::Left;
    scene.hear();
    assert_eq!(scene.model.facts.chart.bumps.len(), 1);
    scene.ack.boot = (scene.ack.boot + 1) % 8;
    scene.state.bump = Bump::None;
    (scene.state.x_tenths_in, scene.state.y_tenths_in) = (0, 0);
    scene.hear();
    assert_eq!(
        scene.model.facts.chart.bumps.len(),
        0,
        "a mark in another frame"
    );
    assert_eq!(scene.model.facts.chart.trail.recent().count(), 1);
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
        .facts
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
    assert!(scene.model.facts.chart.trail.recent().count() > 10);
    scene.state.drive = Drive::OdometerReset;
    (scene.state.x_tenths_in, scene.state.y_tenths_in) = (0, 0);
    scene.hear();
    assert_eq!(scene.model.facts.chart.trail.recent().count(), 1);
}

/// Late lines make no gap, as in the exports; the sequence does not show whole hundreds of lines.
#[test]
fn lost_lines_are_a_gap_in_the_trail() {
    type Change = fn(&mut Scene);
    let lost = LinkEvent::Lost {
        reason: "unplugged".to_owned(),
    };
    let changes: [(usize, Change); 4] = [
        (0, |scene| scene.wait_ms(3000)),
        (1, |scene| scene.lose(1)),
        (1, |scene| scene.wait_ms(33_000)),
        (1, |_| {}),
    ];
    for (n, (gaps, change)) in changes.into_iter().enumerate() {
        let mut scene = scene();
        scene.drive(5, 4.0, 0);
        change(&mut scene);
        if n == 3 {
            scene.event(Event::Link(lost.clone()));
        }
        scene.drive(5, 4.0, 0);
        let trail = &scene.model.facts.chart.trail;
        let broken = trail.recent().skip(1).filter(|point| !point.joined);
        assert_eq!(broken.count(), gaps, "change {n}");
    }
}

/// The part of the floor on the map.
fn shown(scene: &Scene) -> Bounds {
    scene.model.ui.map.shown(&scene.model.facts.chart)
}

fn is_shown(scene: &Scene, (x_in, y_in): (f64, f64)) -> bool {
    let shown = shown(scene);
    shown.union(Bounds::at((x_in, y_in))) == shown
}

#[test]
fn the_map_follows_in_jumps() {
    for (keys, least, most) in [("", 1, 3), ("+", 4, 8)] {
        let mut scene = scene();
        scene.hear();
        scene.type_text(keys);
        let mut jumps = 0;
        let mut last = shown(&scene);
        for _ in 0..60 {
            scene.drive(1, 3.0, 0);
            jumps += usize::from(shown(&scene) != last);
            last = shown(&scene);
            let pose = scene.model.facts.chart.pose().unwrap();
            assert!(is_shown(&scene, (pose.x_in, pose.y_in)));
        }
        assert!((least..=most).contains(&jumps), "{keys} {jumps}");
    }
}

#[test]
fn the_map_shows_the_route_until_it_is_driven_and_the_target() {
    let mut scene = scene();
    scene.hear();
    let far = (600.0, -300.0);
    assert!(!is_shown(&scene, far));
    let digest = 0x1234;
    let request = Request::Route(route(&[(600, -300)]));
    let confirmed = CommandStatus::Confirmed {
        digest: Some(digest),
    };
    scene.command(1, request, confirmed);
    scene.hear();
    assert!(is_shown(&scene, far), "to be driven");
    scene.status.digest = digest;
    scene.status.list = ListPlace {
        driven: 1,
        count: 1,
    };
    scene.hear_status();
    scene.hear();
    assert!(!is_shown(&scene, far), "driven");
    scene.status.target_in = Some((600, -300));
    scene.hear_status();
    scene.hear();
    assert!(is_shown(&scene, far), "the target");
}

#[test]
fn one_key_follows_and_shows_everything_and_ends_a_look_elsewhere() {
    let mut scene = scene();
    scene.drive(300, 3.0, 0);
    let focus = |scene: &Scene| scene.model.ui.map.focus;
    assert_eq!(focus(&scene), Focus::Follow);
    assert!(!is_shown(&scene, (0.0, 0.0)));
    scene.type_text("f");
    assert_eq!(focus(&scene), Focus::Everything);
    assert!(is_shown(&scene, (0.0, 0.0)));
    scene.type_text("H");
    let chosen = shown(&scene);
    scene.drive(100, 3.0, 0);
    assert_eq!(shown(&scene), chosen, "the operator looks elsewhere");
    scene.type_text("f");
    assert_eq!(focus(&scene), Focus::Follow);
    scene.type_text("+");
    assert!(matches!(focus(&scene), Focus::Robot(_)));
    scene.type_text("f");
    assert_eq!(focus(&scene), Focus::Follow);
}

#[test]
fn obstacles_stand_at_the_echoes_until_the_robot_has_driven_on() {
    let mut scene = scene();
    scene.state.sonar_left_in = Some(40);
    scene.state.sonar_right_in = None;
    for step in 0..4 {
        scene.state.y_tenths_in = step * 20;
        scene.state.sonar_left_in = Some(40 - step as u16 * 2);
        scene.hear();
    }
    let obstacles = |scene: &Scene| -> Vec<[(f64, f64); 2]> {
        scene.model.facts.chart.obstacles.obstacles().collect()
    };
    // The left sonar is at (-1.5, 5) and looks 7.5 degrees to the left of north.
    let (x_in, y_in) = (-6.7, 44.7);
    let found = obstacles(&scene);
    let is_there = found.iter().any(|[from, to]| {
        (from.0..=to.0).contains(&x_in) && (from.1 - 3.0..=to.1 + 3.0).contains(&y_in)
    });
    assert!(is_there, "{found:?}");
    scene.state.sonar_left_in = None;
    for step in 0..300 {
        scene.state.y_tenths_in = 60 - step * 20;
        scene.hear();
    }
    let left = obstacles(&scene);
    assert!(left.is_empty(), "{left:?}");
}
