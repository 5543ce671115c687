//! Trials of level 2: STOP, sessions and commands.

use groundwave_protocol::command::{Key, Message, Open, Order};
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::{Layer, LayerMask, LayerState, Mode};
use groundwave_protocol::telemetry::{AbilitiesLine, Outcome, StateLine};

use super::probe::{LIMIT, Seen};
use super::rule;
use super::session::{Ended, Session};

/// Modes, beginning with those in which a robot on a stand does not move.
const MODES: [Mode; 8] = [
    Mode::User,
    Mode::Stop,
    Mode::Reactive,
    Mode::Passive,
    Mode::Prowl,
    Mode::Wander,
    Mode::Forage,
    Mode::GoHome,
];

/// Wait for line I after the session has been opened, milliseconds.
const ABILITIES_MS: u64 = 4000;

/// A letter that is not an order.
const NO_ORDER: &[u8] = b"Z";

/// An order M with a letter that is not a mode.
const NO_MODE: &[u8] = b"Mz";

pub(super) async fn run(session: &mut Session) -> Result<(), Ended> {
    stops(session).await?;
    opens(session).await?;
    session.pause(ABILITIES_MS).await;
    let modes = modes(session);
    if let [first, second, ..] = modes[..] {
        commands(session, first, second).await?;
    } else {
        session.not_tried(rule::COMMAND, "the robot has one mode only");
    }
    refusals(session).await;
    layers(session).await;
    ends(session).await?;
    wraps(session).await?;
    let is_kept = !session.probe.see(|seen| seen.has_late_receipt);
    session.judge(rule::RECEIPT_ENDS, is_kept, || {
        "a line of the open session shows a receipt".to_owned()
    });
    Ok(())
}

/// The abilities in line I; defaults if the robot sent none.
fn abilities(session: &Session) -> AbilitiesLine {
    let abilities = session.probe.see(|seen| seen.abilities);
    abilities.unwrap_or(AbilitiesLine::FULL)
}

fn modes(session: &Session) -> Vec<Mode> {
    let abilities = abilities(session);
    let fitted = MODES.into_iter().filter(|mode| abilities.has_mode(*mode));
    fitted.collect()
}

fn mode(seen: &Seen) -> Option<Mode> {
    seen.state.map(|(_, state)| state.mode)
}

async fn stops(session: &mut Session) -> Result<(), Ended> {
    let rejected = session.rejected();
    if !session.stop().await {
        let is_stopped = session.probe.see(mode) == Some(Mode::Stop);
        let sequence = |seen: &Seen| seen.ack.map(|ack| ack.sequence);
        let before = session.probe.see(sequence);
        let stop = Message::Stop(None);
        let by_zero = session
            .probe
            .effect(&stop, Key::EVERY_ROBOT, |seen| sequence(seen) != before);
        if is_stopped {
            session.broken(rule::STOP_RECEIPT, "the receipt does not show");
        } else if by_zero.await {
            session.broken(rule::STOP, "STOP has an effect under key 0 alone");
        } else {
            session.broken(rule::STOP, session.unheard(rejected));
        }
        return Err(Ended);
    }
    session.kept(rule::STOP_RECEIPT);
    let is_stopped = |seen: &Seen| mode(seen) == Some(Mode::Stop);
    session.probe.lines_after(is_stopped).await;
    let found = session.probe.see(mode);
    session.judge(rule::STOP_MODE, found == Some(Mode::Stop), || {
        format!(
            "mode {}",
            found.map_or('-', |mode| char::from(mode.letter()))
        )
    });
    let sequence = |seen: &Seen| seen.ack.map(|ack| ack.sequence);
    let before = session.probe.see(sequence);
    let again = session.stop().await;
    let counted = session.probe.see(sequence) != before;
    session.judge(rule::STOP_AGAIN, again && counted, || {
        if again {
            "the sequence does not change".to_owned()
        } else {
            session.unheard(None)
        }
    });
    let before = session.probe.see(sequence);
    let stop = Message::Stop(None);
    let heard = session
        .probe
        .effect(&stop, Key::EVERY_ROBOT, |seen| sequence(seen) != before)
        .await;
    session.judge(rule::STOP_ANY, heard, || session.unheard(rejected));
    Ok(())
}

async fn opens(session: &mut Session) -> Result<(), Ended> {
    session
        .probe
        .until(LIMIT, |seen| seen.present_era().is_some())
        .await;
    let open = session.opening(true, session.owner).ok_or(Ended)?;
    let robot = Key::robot(session.robot_id);
    let stale = [
        Open {
            boot: open.boot.wrapping_add(3) & 7,
            ..open
        },
        Open {
            replaces: (open.replaces + 3) & 7,
            ..open
        },
        Open {
            era: open.era.map(|era| era ^ 1),
            ..open
        },
    ];
    let is_open = |seen: &Seen| seen.ack.is_some_and(|ack| ack.session != open.replaces);
    let mut opened = None;
    for (frame, name) in stale.iter().zip(["boot", "session", "era"]) {
        let frame = Message::Open(*frame).encode(robot);
        if session.probe.has_effect(frame.as_bytes(), is_open).await {
            opened = Some(name);
            break;
        }
    }
    session.judge(rule::OPEN_STALE, opened.is_none(), || {
        format!(
            "an open with another {} was obeyed",
            opened.unwrap_or_default()
        )
    });
    let rejected = session.rejected();
    if session.open(true).await? {
        session.kept(rule::OPEN);
        return Ok(());
    }
    if session.open(false).await? {
        session.broken(
            rule::OPEN_ERA,
            "an open with the era has no effect, one without it has",
        );
        return Ok(());
    }
    let seen = session.probe.see(|seen| seen.ack.map(|ack| ack.session));
    let did = match seen {
        Some(number) if number != open.replaces => {
            format!(
                "session {number} after {}, owner {}",
                open.replaces,
                owner(session)
            )
        }
        _ => session.unheard(rejected),
    };
    session.broken(rule::OPEN, did);
    Err(Ended)
}

fn owner(session: &Session) -> u16 {
    session.probe.see(|seen| seen.owner).unwrap_or_default()
}

async fn commands(session: &mut Session, first: Mode, second: Mode) -> Result<(), Ended> {
    let rejected = session.rejected();
    let mut outcome = session.order(Order::Mode(first)).await;
    if outcome.is_none() {
        outcome = under_usual_mistakes(session, first).await;
    }
    if outcome.is_none() {
        session.broken(rule::COMMAND, session.unheard(rejected));
        return Err(Ended);
    }
    if !session.compare(rule::COMMAND, Outcome::Done, outcome, rejected) {
        return Err(Ended);
    }
    let older = session.latest.clone();
    let is_first = |seen: &Seen| mode(seen) == Some(first);
    session.probe.until(LIMIT, is_first).await;
    let entered = session.probe.see(is_first);
    let outcome = session.order(Order::Mode(second)).await;
    let is_second = |seen: &Seen| mode(seen) == Some(second);
    session.probe.until(LIMIT, is_second).await;
    let is_kept = entered && outcome == Some(Outcome::Done) && session.probe.see(is_second);
    session.judge(rule::MODE, is_kept, || {
        let found = session.probe.see(mode).map_or(b'-', Mode::letter);
        format!(
            "ordered {} and {}, mode {}",
            char::from(first.letter()),
            char::from(second.letter()),
            char::from(found)
        )
    });
    if !is_kept {
        return Ok(());
    }
    if !session.ignored(rule::REPEATED, &older).await {
        session.reopen().await?;
    }
    let gap = Session::command(
        (session.sequence + 2) & 0x3F,
        Order::Mode(first),
        session.key,
    );
    if !session.ignored(rule::GAP, &gap).await {
        session.reopen().await?;
    }
    wrong_keys(session, first).await
}

/// Tries a command with keys computed with the usual mistakes; keeps the key that the robot accepts.
async fn under_usual_mistakes(session: &mut Session, mode: Mode) -> Option<Outcome> {
    let Session {
        robot_id,
        boot,
        number,
        owner,
        era,
        ..
    } = *session;
    let key = |robot_id, boot, number, owner| Key::session(robot_id, boot, number, owner);
    for (key, name) in [
        (key(robot_id, boot, number, owner), "without the era"),
        (
            key(robot_id, 0, number, owner).in_era(era),
            "without the boot",
        ),
        (
            key(robot_id, boot, 0, owner).in_era(era),
            "without the session",
        ),
        (
            key(robot_id, boot, number, 0).in_era(era),
            "without the owner",
        ),
        (
            key(0, boot, number, owner).in_era(era),
            "without the robot's id",
        ),
        (Key::robot(robot_id), "of the robot's id alone"),
        (Key::EVERY_ROBOT, "0"),
    ] {
        let outcome = session.order_under(key, Order::Mode(mode)).await;
        if outcome.is_some() {
            session.key = key;
            session.broken(
                rule::KEY,
                format!("a command is taken under the key {name}"),
            );
            return outcome;
        }
    }
    None
}

/// Tries commands under keys that differ from the session's in one part.
async fn wrong_keys(session: &mut Session, mode: Mode) -> Result<(), Ended> {
    type Part = fn(&Session) -> (u8, u8, u8, u16);
    let parts: [(_, Part); 4] = [
        (rule::WRONG_SESSION, |it| {
            (it.robot_id, it.boot, (it.number + 5) % 7 + 1, it.owner)
        }),
        (rule::WRONG_OWNER, |it| {
            (it.robot_id, it.boot, it.number, it.owner ^ 1)
        }),
        (rule::WRONG_BOOT, |it| {
            (it.robot_id, it.boot ^ 1, it.number, it.owner)
        }),
        (rule::WRONG_ROBOT, |it| {
            (it.robot_id ^ 1, it.boot, it.number, it.owner)
        }),
    ];
    for (rule, part) in parts {
        let (robot_id, boot, number, owner) = part(session);
        let right = Key::session(
            session.robot_id,
            session.boot,
            session.number,
            session.owner,
        );
        // With the session's era, and without an era.
        let era = if session.key == right { 0 } else { session.era };
        let key = Key::session(robot_id, boot, number, owner).in_era(era);
        let frame = Session::command((session.sequence + 1) & 0x3F, Order::Mode(mode), key);
        if !session.ignored(rule, &frame).await {
            session.reopen().await?;
        }
    }
    let sequence = (session.sequence + 1) & 0x3F;
    let mut damaged = Session::command(sequence, Order::Mode(mode), session.key);
    // The last character of the checksum, before the line feed.
    if let [.., last, _] = &mut damaged[..] {
        *last = if *last == b'!' { b'"' } else { b'!' };
    }
    if !session.ignored(rule::DAMAGED, &damaged).await {
        session.reopen().await?;
    }
    Ok(())
}

async fn refusals(session: &mut Session) {
    let rejected = session.rejected();
    let outcome = session.raw_order(NO_ORDER).await;
    session.compare(rule::UNKNOWN_ORDER, Outcome::Unknown, outcome, rejected);
    let outcome = session.raw_order(NO_MODE).await;
    session.compare(rule::UNREADABLE_ORDER, Outcome::Unknown, outcome, rejected);
    let abilities = abilities(session);
    let beyond = match abilities.level {
        ..3 => Some(Order::Activate {
            tag: 0,
            count: 0,
            digest: digest([].iter()),
        }),
        3 => Some(Order::Scan),
        4 => Some(Order::ReadParameters { place: 0 }),
        _ => None,
    };
    match beyond {
        Some(order) => {
            session
                .expect(rule::BEYOND_LEVEL, order, Outcome::Unknown)
                .await;
        }
        None => session.not_tried(rule::BEYOND_LEVEL, "the robot has every level"),
    }
    let lacking = Mode::ALL.iter().find(|mode| !abilities.has_mode(**mode));
    match lacking {
        Some(mode) => {
            let order = Order::Mode(*mode);
            session
                .expect(rule::NOT_FITTED, order, Outcome::NotFitted)
                .await;
        }
        None => session.not_tried(rule::NOT_FITTED, "the robot has every mode"),
    }
}

/// Forbids layers 1 to 7, and allows those again that were.
async fn layers(session: &mut Session) {
    let which = LayerMask::from_bits(0xFE);
    let rejected = session.rejected();
    let has_status = abilities(session).level >= 3;
    let before = if has_status {
        session.probe.status().await
    } else {
        None
    };
    let was_on = session.probe.see(|seen| seen.state.map(|(_, it)| on(&it)));
    let none = LayerMask::from_bits(0);
    let forbid = Order::Layers {
        which,
        allowed: none,
    };
    let outcome = session.order(forbid).await;
    if outcome != Some(Outcome::Done) {
        session.compare(rule::LAYERS, Outcome::Done, outcome, rejected);
        return;
    }
    let is_on = |seen: &Seen| seen.state.is_some_and(|(_, it)| on(&it) != none);
    session.probe.lines_after(|_| false).await;
    let mut wrong = session
        .probe
        .see(is_on)
        .then(|| "line A shows a layer that was forbidden as on".to_owned());
    let allowed = before.map_or(was_on.unwrap_or(none), |it| it.allowed.and(which));
    if let Some(before) = before {
        let user = LayerMask::from_bits(before.allowed.bits() & 1);
        wrong = wrong.or(shown(session, user).await);
    }
    let outcome = session.order(Order::Layers { which, allowed }).await;
    if wrong.is_none() && outcome != Some(Outcome::Done) {
        session.compare(rule::LAYERS, Outcome::Done, outcome, rejected);
        return;
    }
    if let Some(before) = before {
        wrong = wrong.or(shown(session, before.allowed).await);
    }
    session.judge(rule::LAYERS, wrong.is_none(), || wrong.unwrap_or_default());
    let Some(before) = before else { return };
    let mut layers = (1..8).map(|bit| LayerMask::from_bits(1 << bit));
    match layers.find(|it| before.fitted.and(*it) == none) {
        Some(layer) => {
            let order = Order::Layers {
                which: layer,
                allowed: layer,
            };
            session
                .expect(rule::LAYER_FITTED, order, Outcome::NotFitted)
                .await;
        }
        None => session.not_tried(rule::LAYER_FITTED, "the robot has every layer"),
    }
}

/// What line B shows instead of these allowed layers.
async fn shown(session: &Session, allowed: LayerMask) -> Option<String> {
    let found = session.probe.status().await.map(|it| it.allowed);
    (found != Some(allowed)).then(|| match found {
        Some(found) => format!(
            "line B shows the layers {:08b} as allowed, not {:08b}; bit n is layer n",
            found.bits(),
            allowed.bits()
        ),
        None => "no line B arrived".to_owned(),
    })
}

/// The layers of line A that are on.
fn on(state: &StateLine) -> LayerMask {
    let is_on = |layer: &&Layer| state.layers.get(**layer) != LayerState::Off;
    let on = Layer::ALL.iter().filter(is_on);
    on.fold(LayerMask::from_bits(0), |mask, layer| mask.with(*layer))
}

/// The sessions up to the first of the next era.
async fn wraps(session: &mut Session) -> Result<(), Ended> {
    while session.number != 7 {
        session.reopen().await?;
    }
    let era = session.era;
    let is_next = session.open(true).await?;
    let expected = (era + 1) & 0x3FFF;
    let shows_era = |seen: &Seen| seen.present_era() == Some(expected);
    let is_kept = is_next && session.probe.until(LIMIT, shows_era).await;
    session.judge(rule::SESSION_WRAP, is_kept, || {
        let number = session.probe.see(|seen| seen.ack.map(|ack| ack.session));
        let found = session.probe.see(Seen::present_era).unwrap_or_default();
        format!(
            "session {} in era {found} after session 7 in era {era}",
            number.unwrap_or_default()
        )
    });
    if is_kept { Ok(()) } else { Err(Ended) }
}

/// Tries STOP while a session is open, and opens the next session.
async fn ends(session: &mut Session) -> Result<(), Ended> {
    let before = session.number;
    session.stop().await;
    let closed = |seen: &Seen| {
        seen.owner == Some(0) && seen.ack.is_some_and(|ack| ack.session == before % 7 + 1)
    };
    session.probe.lines_after(closed).await;
    let is_closed = session.probe.see(closed);
    session.judge(rule::STOP_SESSION, is_closed, || {
        let number = session.probe.see(|seen| seen.ack.map(|ack| ack.session));
        format!(
            "session {} after {before}, owner {}",
            number.unwrap_or_default(),
            owner(session)
        )
    });
    session.reopen().await
}
