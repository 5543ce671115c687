//! Trail, marks and what the map follows.

use super::*;

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

#[test]
fn a_gap_in_the_telemetry_is_a_gap_in_the_trail() {
    let mut scene = scene();
    scene.drive(5, 4.0, 0);
    scene.wait_ms(5000);
    scene.drive(5, 4.0, 0);
    let gaps = scene.model.facts.chart.trail.recent().filter(|p| !p.joined);
    assert_eq!(gaps.count(), 2, "where it starts and after the silence");
}

#[test]
fn the_map_follows_in_jumps() {
    let mut scene = scene();
    scene.type_text("f");
    assert_eq!(scene.model.ui.map.focus, Focus::Robot);
    let mut jumps = 0;
    let mut middle = scene.model.ui.map.middle(&scene.model.facts.chart);
    for _ in 0..60 {
        scene.drive(1, 3.0, 0);
        if scene.model.ui.map.middle(&scene.model.facts.chart) != middle {
            middle = scene.model.ui.map.middle(&scene.model.facts.chart);
            jumps += 1;
        }
    }
    assert!((4..=8).contains(&jumps), "{jumps}");
}
