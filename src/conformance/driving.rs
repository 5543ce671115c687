//! Trials of level 4: pose, hand drive, failsafe, lines K and C.

use std::time::Duration;

use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Drive, Frame, Keepalive, Message, Order};
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{Layer, LayerMask, Link, Mode};
use groundwave_protocol::telemetry::Outcome;

use super::probe::{ANSWER_BYTES, LIMIT, RARE, Seen};
use super::rule;
use super::session::{Session, in_words};

/// Speed of hand drive, in/s: slow, but greater than any rounding.
const SPEED_IN_S: i8 = 4;

/// Time between drive frames that must have no effect.
const DRIVE_PERIOD: Duration = Duration::from_millis(250);

/// Number of lines K after a long line.
const QUICK_ACKS: u8 = 3;

/// Maximum time from a frame to its acknowledgement, apart from the radio's losses.
const ANSWER_MAX: Duration = Duration::from_secs(1);

/// Byte times from a frame to its acknowledgement that leave time for one in a long line.
const PROMPT_BYTES: u32 = 35;

/// Maximum number of tries, and number of stale acknowledgements among them that are the robot's.
const FRESHNESS_TRIES: usize = 10;
const STALE_ALIKE: usize = 3;

/// Number of drive frames after which the robot must drive.
const DRIVE_FRAMES: usize = 8;

/// Maximum time after the last drive frame for lines A to show the speed: a second, a line's composition and transmission, the latency.
const DRIVE_END: Duration = Duration::from_secs(2);

/// Time after which the ground is no longer live, milliseconds: 2 s and the latency.
const NOT_LIVE_MS: u64 = 3000;

/// Number of lines between the newest line and an old line.
const OLD_LINES: u8 = 40;

/// Silence of the tried failsafe, and its maximum deviation (lines, and lost frames), seconds.
const SILENCE_S: u16 = 10;
const FAILSAFE_EARLY: Duration = Duration::from_secs(1);
const FAILSAFE_LATE: Duration = Duration::from_secs(20);

pub(super) async fn run(session: &mut Session) {
    let heard_before = session
        .probe
        .see(|seen| seen.counters.map(|(_, line)| line.frames_heard));
    knock(session).await;
    freshness(session).await;
    let outcome = session.order(Order::Mode(Mode::User)).await;
    pose(session).await;
    if outcome == Some(Outcome::Done) {
        hand_drive(session).await;
        failsafe(session).await;
    } else {
        session.not_tried(rule::DRIVE, "the robot has no mode U");
        session.not_tried(rule::FAILSAFE, "the robot has no mode U");
    }
    let heard = |seen: &Seen| {
        let now = seen.counters.map(|(_, line)| line.frames_heard);
        now.is_some() && now != heard_before
    };
    session.probe.until(RARE, heard).await;
    session.judge(rule::HEARD, session.probe.see(heard), || {
        "frames heard stand still in line C".to_owned()
    });
}

async fn knock(session: &Session) {
    if session.probe.see(|seen| seen.is_half_duplex) {
        session.not_tried(rule::KNOCK, "the radio is half duplex");
        return;
    }
    // After four long lines, the lines K for earlier frames have passed.
    session.pause(6000).await;
    let before = session.probe.see(|seen| seen.quick_acks);
    let is_answered = |seen: &Seen| seen.quick_acks >= before + 3;
    let answered = session
        .probe
        .effect_of(Frame::knock().as_bytes(), is_answered)
        .await;
    session.judge(rule::KNOCK, answered, || {
        "no lines K after a line feed".to_owned()
    });
}

/// Tries whether a long line shows a frame that arrived while it was sent. Lines K show first that the link's latency is short enough.
async fn freshness(session: &mut Session) {
    if session.probe.see(|seen| seen.is_half_duplex) {
        session.not_tried(rule::ACK_FRESH, "the radio is half duplex");
        return;
    }
    let mut stale = 0;
    for _ in 0..FRESHNESS_TRIES {
        session.probe.send(Frame::knock().as_bytes());
        session.probe.sent().await;
        let is_last = |seen: &Seen| seen.quick_run == QUICK_ACKS;
        session.probe.until(LIMIT, is_last).await;
        let quick = answer_after(session, 0).await;
        let long = answer_after(session, QUICK_ACKS).await;
        match (quick, long) {
            (_, Some(answer)) if answer.lines == 1 => return session.kept(rule::ACK_FRESH),
            (Some(quick), Some(long)) if quick.is_prompt && long.is_complete => stale += 1,
            _ => {}
        }
        if stale == STALE_ALIKE {
            let did = "a frame that arrives early in a line shows in the next line only";
            return session.broken(rule::ACK_FRESH, did);
        }
    }
    session.not_tried(rule::ACK_FRESH, "the link's latency is too long");
}

/// The acknowledgement of a command that was sent once.
struct Answer {
    /// Lines up to the acknowledgement.
    lines: u8,
    /// Whether all these lines arrived.
    is_complete: bool,
    /// Whether the acknowledgement was taken soon after the frame had left.
    is_prompt: bool,
}

/// Sends a command without effect when a line has arrived that is preceded by `quick_run` lines K, itself included; `None` if the
/// frame was lost.
async fn answer_after(session: &mut Session, quick_run: u8) -> Option<Answer> {
    let order = Order::Layers {
        which: LayerMask::NONE,
        allowed: LayerMask::NONE,
    };
    let lines = session.probe.see(|seen| seen.lines);
    let begins = |seen: &Seen| seen.lines != lines && seen.quick_run == quick_run;
    if !session.probe.until(LIMIT, begins).await {
        return None;
    }
    let (sequence, missing) = session.probe.see(|seen| (seen.sequence, seen.missing));
    let next = (session.sequence + 1) & 0x3F;
    session
        .probe
        .send(&Session::command(next, order, session.key));
    session.probe.sent().await;
    let number = session.number;
    let is_shown = |seen: &Seen| {
        seen.ack
            .is_some_and(|ack| ack.session == number && ack.sequence == next & 7)
    };
    let left_at = session.probe.left_at();
    let is_known = session.probe.until(ANSWER_MAX, is_shown).await;
    let taken_after = session.probe.byte_times(ANSWER_BYTES + PROMPT_BYTES);
    let answer = session.probe.see(|seen| Answer {
        lines: (seen.sequence + 100 - sequence) % 100,
        is_complete: seen.missing == missing,
        is_prompt: seen.at <= left_at + taken_after,
    });
    session.order(order).await;
    is_known.then_some(answer)
}

async fn pose(session: &mut Session) {
    let position = Waypoint {
        x_in: 30,
        y_in: -20,
    };
    let order = Order::Pose {
        position,
        theta_deg: 90,
    };
    let outcome = session.order(order).await;
    match outcome {
        Some(Outcome::Done) => {}
        Some(Outcome::NotFitted | Outcome::NotNow) => {
            session.not_tried(rule::POSE, "the robot has no pose to set");
            return;
        }
        Some(outcome) => return session.broken(rule::POSE, in_words(outcome)),
        None => return session.broken(rule::POSE, session.unheard(None)),
    }
    let is_there = |seen: &Seen| {
        seen.state.is_some_and(|(_, state)| {
            (state.x_tenths_in - 300).abs() < 50 && (state.y_tenths_in + 200).abs() < 50
        })
    };
    session.probe.until(LIMIT, is_there).await;
    session.judge(rule::POSE, session.probe.see(is_there), || {
        match session.probe.see(|seen| seen.state) {
            Some((_, state)) => format!(
                "line A shows {}, {} tenths of an inch, not 300, -200",
                state.x_tenths_in, state.y_tenths_in
            ),
            None => String::new(),
        }
    });
    let Some(before) = session.probe.status().await else {
        return;
    };
    let frame = session.latest.clone();
    session.probe.has_effect(&frame, |_| false).await;
    let Some(after) = session.probe.status().await else {
        return;
    };
    let resets = (after.odometer_resets + 100 - before.odometer_resets) % 100;
    session.judge(rule::REPEATED_POSE, resets == 0, || {
        format!("line B counts {resets} more odometer resets")
    });
}

fn velocity(seen: &Seen) -> i8 {
    seen.state.map_or(0, |(_, state)| state.velocity_in_s)
}

fn is_driven(seen: &Seen) -> bool {
    velocity(seen) != 0
}

/// A drive frame that names the line `behind` lines before the newest.
fn frame(session: &Session, count: u8, behind: u8) -> Vec<u8> {
    let newest = session.probe.see(|seen| seen.sequence);
    let drive = Message::Drive(Drive {
        velocity_in_s: SPEED_IN_S,
        rotation_in_s: 0,
        heard: (newest + 100 - behind) % 100,
        count: count & 0xF,
    });
    drive.encode(session.key).as_bytes().to_vec()
}

fn keepalive(session: &Session) -> Vec<u8> {
    let heard = session.probe.see(|seen| seen.sequence);
    let message = Message::Keepalive(Keepalive { heard });
    message.encode(session.key).as_bytes().to_vec()
}

async fn hand_drive(session: &mut Session) {
    let user = LayerMask::NONE.with(Layer::User);
    let order = Order::Layers {
        which: user,
        allowed: user,
    };
    if session.order(order).await != Some(Outcome::Done) {
        session.not_tried(rule::DRIVE, "layer 0 is not fitted");
        return;
    }
    let rejected = session.rejected();
    let mut is_obeyed = false;
    for _ in 0..DRIVE_FRAMES {
        session.count = (session.count + 1) & 0xF;
        session.probe.turn().await;
        let frames = [keepalive(session), frame(session, session.count, 0)].concat();
        session.probe.send(&frames);
        session.probe.sent().await;
        // The frame that the robot obeys is the latest one.
        if session.probe.until(DRIVE_END, is_driven).await {
            is_obeyed = true;
            break;
        }
    }
    session.judge(rule::DRIVE, is_obeyed, || session.unheard(rejected));
    if !is_obeyed {
        return;
    }
    let end = session.probe.left_at() + DRIVE_END;
    let is_late = |seen: &Seen| {
        seen.state
            .is_some_and(|(at, state)| at > end && state.velocity_in_s != 0)
    };
    let is_still = |seen: &Seen| seen.state.is_some_and(|(at, _)| at > end) || !is_driven(seen);
    session.probe.until(LIMIT, is_still).await;
    let is_kept = !session.probe.see(is_late);
    session.judge(rule::DRIVE_END, is_kept, || {
        format!(
            "the robot still drives at {} in/s after 2 s",
            session.probe.see(velocity)
        )
    });
    if !is_kept {
        return;
    }
    let next = (session.count + 1) & 0xF;
    for (rule, count, behind, is_live) in [
        (rule::DRIVE_STALE, next, OLD_LINES, true),
        (rule::DRIVE_REPEATED, session.count, 0, true),
        (rule::DRIVE_LIVE, next, 0, false),
    ] {
        undriven(session, rule, count, behind, is_live).await;
    }
    let stop = session.order(Order::Mode(Mode::Stop)).await;
    if stop == Some(Outcome::Done) {
        session.pause(NOT_LIVE_MS).await;
        undriven(session, rule::DRIVE_STOPPED, next, 0, true).await;
        session.order(Order::Mode(Mode::User)).await;
    }
}

/// Sends a drive frame that must have no effect.
async fn undriven(
    session: &Session,
    rule: &'static rule::Rule,
    count: u8,
    behind: u8,
    is_live: bool,
) {
    if !is_live {
        session.pause(NOT_LIVE_MS).await;
    }
    let mut has_effect = false;
    for _ in 0..3 {
        session.probe.turn().await;
        let drive = frame(session, count, behind);
        let frames = if is_live {
            [keepalive(session), drive].concat()
        } else {
            drive
        };
        session.probe.send(&frames);
        session.probe.sent().await;
        has_effect |= session.probe.until(DRIVE_PERIOD, is_driven).await;
    }
    has_effect |= session.probe.lines_after(is_driven).await;
    session.judge(rule, !has_effect, || {
        format!("the robot drives at {SPEED_IN_S} in/s")
    });
    if has_effect {
        session.pause(NOT_LIVE_MS).await;
    }
}

fn link(seen: &Seen) -> Option<Link> {
    seen.state.map(|(_, state)| state.link)
}

async fn failsafe(session: &mut Session) {
    let short = Failsafe {
        silence_s: SILENCE_S / 2,
        mode: Mode::Stop,
    };
    let order = |failsafe| Order::Failsafe(failsafe);
    session
        .expect(rule::FAILSAFE_RANGE, order(Some(short)), Outcome::BadValue)
        .await;
    let failsafe = Failsafe {
        silence_s: SILENCE_S,
        mode: Mode::Stop,
    };
    let outcome = session.order(order(Some(failsafe))).await;
    if outcome != Some(Outcome::Done) {
        let did = outcome.map_or_else(|| session.unheard(None), in_words);
        session.broken(rule::FAILSAFE, did);
        return;
    }
    let armed_at = session.probe.left_at();
    let is_armed = |seen: &Seen| link(seen) == Some(Link::Armed);
    session.probe.until(Duration::from_secs(8), is_armed).await;
    session.judge(rule::FAILSAFE_ARMED, session.probe.see(is_armed), || {
        let letter = session.probe.see(link).map_or(b'-', Link::letter);
        format!("column 59 shows {}", char::from(letter))
    });
    let acts = |seen: &Seen| {
        link(seen) == Some(Link::Failsafe)
            && seen.state.is_some_and(|(_, it)| it.mode == Mode::Stop)
    };
    session.probe.until(FAILSAFE_LATE, acts).await;
    let waited = session.probe.now().saturating_sub(armed_at);
    let is_early = waited + FAILSAFE_EARLY < Duration::from_secs(SILENCE_S.into());
    let has_acted = session.probe.see(acts);
    session.judge(rule::FAILSAFE, has_acted && !is_early, || {
        if has_acted {
            format!(
                "it acts after {:.1} s, not {SILENCE_S} s",
                waited.as_secs_f64()
            )
        } else {
            format!("it does not act within {} s", FAILSAFE_LATE.as_secs())
        }
    });
    if !has_acted {
        return;
    }
    let outcome = session.order(Order::Mode(Mode::User)).await;
    session.probe.until(Duration::from_secs(8), is_armed).await;
    let is_over = outcome == Some(Outcome::Done) && session.probe.see(is_armed);
    session.judge(rule::FAILSAFE_END, is_over, || {
        let letter = session.probe.see(link).map_or(b'-', Link::letter);
        format!("column 59 shows {}", char::from(letter))
    });
    session.order(order(None)).await;
}
