//! Trials of a reboot by the person at the robot.

use std::time::Duration;

use groundwave_protocol::command::{ERA_MAX, Key, Message};

use super::probe::{LIMIT, Seen};
use super::rule;
use super::session::Session;

/// Maximum wait for the reset.
const RESET: Duration = Duration::from_mins(1);

/// Rounds of session numbers that a robot has hardly gone through since its boot.
const ROUNDS_MAX: u16 = 64;

pub(super) async fn run(session: &mut Session) {
    if session.reopen().await.is_err() {
        return;
    }
    // As a station would send the command in the session before the reset.
    session
        .probe
        .until(LIMIT, |seen| seen.present_era().is_some())
        .await;
    let Some(open) = session.opening(true, session.owner) else {
        return;
    };
    let uptime = |seen: &Seen| seen.counters.map(|(_, line)| line.uptime_s);
    let before = session.probe.see(uptime);
    let number = session.number;
    session
        .probe
        .ask_for_reset("Reset the robot now; 60 s remain. Ctrl-C ends.");
    let has_restarted = |seen: &Seen| {
        let ack = seen.ack;
        ack.is_some_and(|ack| ack.boot != open.boot || ack.session != number)
            || before.is_some() && uptime(seen) < before
    };
    if !session.probe.until(RESET, has_restarted).await {
        for rule in [rule::BOOT, rule::BOOT_SESSION, rule::BOOT_OPEN] {
            session.not_tried(rule, "the robot was not reset");
        }
        return;
    }
    session
        .probe
        .until(LIMIT, |seen| seen.present_era().is_some())
        .await;
    let Some(ack) = session.probe.see(|seen| seen.ack) else {
        return;
    };
    let era = session.probe.see(Seen::present_era);
    // Sessions of this boot have counted the era up since it began.
    let is_same_era = era
        .zip(open.era)
        .is_some_and(|(after, before)| (before.wrapping_sub(after) & ERA_MAX) < ROUNDS_MAX);
    session.judge(rule::BOOT, ack.boot != open.boot || !is_same_era, || {
        format!("boot {} and its first era as before", ack.boot)
    });
    let is_closed = ack.session == 0 && ack.sequence == 0;
    session.judge(rule::BOOT_SESSION, is_closed, || {
        format!("session {}, command {}", ack.session, ack.sequence)
    });
    let frame = Message::Open(open).encode(Key::robot(session.robot_id));
    let is_open = |seen: &Seen| seen.ack.is_some_and(|it| it.session != ack.session);
    let has_effect = session.probe.has_effect(frame.as_bytes(), is_open).await;
    session.judge(rule::BOOT_OPEN, !has_effect, || {
        "an open from before the reboot was obeyed".to_owned()
    });
}
