//! Trials of level 3: lists of waypoints.

use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{BLOCK_WAYPOINTS, Message, Order, Slots};
use groundwave_protocol::digest::digest;
use groundwave_protocol::telemetry::{AbilitiesLine, Outcome};

use super::probe::{RARE, Seen};
use super::rule;
use super::session::{Session, in_words};

/// Number of waypoints in the list: a whole block and a short one.
const WAYPOINTS: usize = 6;

/// Waypoints of the longest frame.
const LONGEST: u16 = 16;

pub(super) async fn run(session: &mut Session) {
    let abilities = session.probe.see(|seen| seen.abilities);
    let capacity = abilities.unwrap_or(AbilitiesLine::FULL).capacity;
    if capacity == 0 {
        session.not_tried(rule::LIST, "the robot has no lists");
        return;
    }
    let count = WAYPOINTS.min(usize::from(capacity));
    let list: Vec<Waypoint> = (0_i16..).take(count).map(|n| point(n, 100)).collect();
    let right = digest(list.iter());
    missing(session, &list, capacity).await;
    if !stage(session, &list).await {
        session.broken(rule::LIST, "no acknowledgement shows the staged list");
        return;
    }
    let wrong = activate(session.tag, count, right ^ 1);
    let is_whole = session
        .expect(rule::LIST_DIGEST, wrong, Outcome::DigestMismatch)
        .await;
    if !is_whole && !stage(session, &list).await {
        return;
    }
    let rejected = session.rejected();
    let outcome = session.order(activate(session.tag, count, right)).await;
    if !session.compare(rule::LIST, Outcome::Done, outcome, rejected) {
        return;
    }
    shown(session, count, right).await;
    old_tag(session).await;
    refused(session, count, right, capacity).await;
    long_frame(session, capacity).await;
    clear(session).await;
}

const fn point(n: i16, y_in: i16) -> Waypoint {
    Waypoint {
        x_in: 10 * n - 20,
        y_in: y_in + n,
    }
}

fn activate(tag: u8, count: usize, digest: u32) -> Order {
    Order::Activate {
        tag,
        count: u16::try_from(count).unwrap_or(u16::MAX),
        digest,
    }
}

/// Sends the waypoints under the next tag, the first block in a frame of its own, until the robot has all; returns whether it has.
async fn stage(session: &mut Session, list: &[Waypoint]) -> bool {
    session.tag += 1;
    let (first, others) = list.split_at(list.len().min(BLOCK_WAYPOINTS));
    send(session, 0, first).await && (others.is_empty() || send(session, 1, others).await)
}

/// Sends waypoints of the list under way from a block on, which completes it up to them; returns whether the robot has them.
async fn send(session: &Session, first_block: u8, list: &[Waypoint]) -> bool {
    let tag = session.tag;
    let blocks = u8::try_from(list.len().div_ceil(BLOCK_WAYPOINTS)).unwrap_or(u8::MAX);
    let frame = Message::Waypoints(Slots::new(tag, first_block, list));
    let is_staged = |seen: &Seen| seen.staged == Some((first_block + blocks, tag & 3));
    session.probe.effect(&frame, session.key, is_staged).await
}

/// Tries to activate a list without its second block, or without its only block.
async fn missing(session: &mut Session, list: &[Waypoint], capacity: u16) {
    if list.len() > BLOCK_WAYPOINTS {
        let is_staged = stage(session, &list[..BLOCK_WAYPOINTS]).await;
        if is_staged && usize::from(capacity) >= 4 * BLOCK_WAYPOINTS {
            window(session).await;
        }
    } else {
        session.tag += 1;
    }
    let order = activate(session.tag, list.len(), digest(list.iter()));
    session
        .expect(rule::LIST_MISSING, order, Outcome::ListIncomplete)
        .await;
}

/// Sends the fourth block of a list whose first has arrived.
async fn window(session: &Session) {
    let tag = session.tag;
    let block = [0, 1, 2, 3].map(|n| point(n, 400));
    let frame = Message::Waypoints(Slots::new(tag, 3, &block));
    let is_shown = |seen: &Seen| seen.staged == Some((1, tag & 3)) && seen.window == 0b10;
    let is_kept = session.probe.effect(&frame, session.key, is_shown).await;
    session.judge(rule::LIST_WINDOW, is_kept, || {
        let (staged, window) = session.probe.see(|seen| (seen.staged, seen.window));
        format!(
            "with blocks 0 and 3 the first missing is {}, the window {window:08b}",
            staged.map_or(0, |(first, _)| first)
        )
    });
}

async fn long_frame(session: &mut Session, capacity: u16) {
    if capacity < LONGEST {
        session.not_tried(rule::LONG_FRAME, "the capacity is below 16");
        return;
    }
    let rejected = session.rejected();
    let list: Vec<Waypoint> = (0..LONGEST as i16).map(|n| point(n, 500)).collect();
    session.tag += 1;
    let is_staged = send(session, 0, &list).await;
    session.judge(rule::LONG_FRAME, is_staged, || session.unheard(rejected));
}

async fn shown(session: &Session, count: usize, digest: u32) {
    let is_shown = |seen: &Seen| {
        seen.status
            .is_some_and(|(_, line)| usize::from(line.list.count) == count && line.digest == digest)
    };
    session.probe.until(RARE, is_shown).await;
    let found = session.probe.see(|seen| seen.status);
    session.judge(
        rule::LIST_STATUS,
        session.probe.see(is_shown),
        || match found {
            Some((_, line)) => format!(
                "line B shows {} waypoints with the digest {:08X}, not {count} with {digest:08X}",
                line.list.count, line.digest
            ),
            None => "no line B arrived".to_owned(),
        },
    );
}

/// Tries the tag of the list that has just become active.
async fn old_tag(session: &Session) {
    let list = [point(0, 300)];
    let frame = Message::Waypoints(Slots::new(session.tag, 0, &list)).encode(session.key);
    // The latest acknowledgement may still be for the list being staged.
    session.probe.lines_after(|_| false).await;
    let is_staged = |seen: &Seen| seen.staged.is_some();
    let has_effect = session.probe.has_effect(frame.as_bytes(), is_staged).await;
    session.judge(rule::LIST_TAG, !has_effect, || {
        format!("a list with the tag {} is staged again", session.tag)
    });
}

async fn refused(session: &mut Session, count: usize, right: u32, capacity: u16) {
    if usize::from(capacity) < BLOCK_WAYPOINTS {
        session.not_tried(rule::SHORT_BLOCK, "the capacity is below one block");
    } else {
        let block = [0, 1, 2, 3].map(|n| point(n, 200));
        stage(session, &block[..3]).await;
        let order = activate(session.tag, block.len(), digest(block.iter()));
        session
            .expect(rule::SHORT_BLOCK, order, Outcome::DigestMismatch)
            .await;
    }
    let long = activate(session.tag, usize::from(capacity) + 1, right);
    session
        .expect(rule::LIST_CAPACITY, long, Outcome::BadValue)
        .await;
    let status = session.probe.status().await;
    let is_kept =
        status.is_some_and(|it| usize::from(it.list.count) == count && it.digest == right);
    session.judge(rule::LIST_KEPT, is_kept, || match status {
        Some(line) => format!(
            "line B shows {} waypoints with the digest {:08X}",
            line.list.count, line.digest
        ),
        None => "no line B arrived".to_owned(),
    });
}

async fn clear(session: &mut Session) {
    let empty = digest([].iter());
    let wrong = session.order(activate(0, 0, empty ^ 1)).await;
    if wrong != Some(Outcome::DigestMismatch) {
        let did = wrong.map_or_else(|| session.unheard(None), in_words);
        session.broken(rule::LIST_CLEAR, format!("with a wrong digest: {did}"));
        return;
    }
    let outcome = session.order(activate(0, 0, empty)).await;
    let status = session.probe.status().await;
    let is_empty = status.is_some_and(|it| it.list.count == 0 && it.digest == empty);
    let is_kept = outcome == Some(Outcome::Done) && is_empty;
    session.judge(rule::LIST_CLEAR, is_kept, || match (outcome, status) {
        (Some(Outcome::Done), Some(line)) => format!(
            "line B shows {} waypoints with the digest {:08X}",
            line.list.count, line.digest
        ),
        (Some(Outcome::Done), None) => "no line B arrived".to_owned(),
        (Some(outcome), _) => in_words(outcome),
        (None, _) => session.unheard(None),
    });
}
