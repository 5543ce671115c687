//! Trials of level 5: parameters.

use std::time::Duration;

use groundwave_protocol::command::Order;
use groundwave_protocol::parameter::key;
use groundwave_protocol::telemetry::{Outcome, ParameterLine};

use super::probe::{LIMIT, Seen};
use super::rule;
use super::session::{Session, in_words};

/// Time for each line P, including other lines in between.
const EACH: Duration = Duration::from_secs(1);
const ROUND: Duration = Duration::from_secs(5);

/// Maximum number of requests for the lines P while the radio loses lines.
const ROUNDS: usize = 20;

/// A name that no robot should have.
const NO_NAME: &str = "no-such-parameter";

/// Maximum value in an order V.
const ORDER_MAX: i32 = 131_071;

pub(super) async fn run(session: &mut Session) {
    let outcome = session.order(Order::ReadParameters { place: 0 }).await;
    if outcome != Some(Outcome::Done) {
        let did = outcome.map_or_else(|| session.unheard(None), in_words);
        session.broken(rule::PARAMETERS, did);
        return;
    }
    if !session
        .probe
        .until(LIMIT, |seen| !seen.parameters.is_empty())
        .await
    {
        session.not_tried(rule::PARAMETERS, "the robot has no parameters");
        return;
    }
    let Some(line) = first(session) else { return };
    let count = usize::from(line.count);
    let is_complete = |seen: &Seen| seen.parameters.len() >= count;
    for _ in 0..ROUNDS {
        let missing = session.probe.see(|seen| seen.missing);
        let wait = ROUND + EACH * u32::from(line.count);
        let is_clean = |seen: &Seen| seen.missing == missing;
        if session.probe.until(wait, is_complete).await || session.probe.see(is_clean) {
            break;
        }
        // The radio has lost lines.
        session.order(Order::ReadParameters { place: 0 }).await;
    }
    let found = session.probe.see(|seen| seen.parameters.len());
    session.judge(rule::PARAMETERS, found == count, || {
        format!("{found} of {count} lines P")
    });
    if set(session, &line, line.value).await {
        keep(session, &line).await;
    }
    let beyond = [line.most + 1, line.least - 1];
    let beyond = beyond.into_iter().find(|value| value.abs() <= ORDER_MAX);
    if let Some(value) = beyond {
        let key = key(line.name.as_str());
        let order = Order::SetParameter { key, value };
        session
            .expect(rule::PARAMETER_LIMITS, order, Outcome::BadValue)
            .await;
    }
    let unknown = Order::ReadParameter { key: key(NO_NAME) };
    session
        .expect(rule::PARAMETER_UNKNOWN, unknown, Outcome::Unknown)
        .await;
    let beyond = Order::ReadParameters {
        place: u16::from(line.count) + 1,
    };
    session
        .expect(rule::PARAMETER_PLACE, beyond, Outcome::BadValue)
        .await;
}

fn first(session: &Session) -> Option<ParameterLine> {
    session
        .probe
        .see(|seen| seen.parameters.values().next().map(|(_, line)| *line))
}

/// Sets a parameter; returns whether a line P shows the value.
async fn set(session: &mut Session, line: &ParameterLine, value: i32) -> bool {
    let key = key(line.name.as_str());
    let rejected = session.rejected();
    let outcome = session.order(Order::SetParameter { key, value }).await;
    if outcome != Some(Outcome::Done) {
        return session.compare(rule::PARAMETER_SET, Outcome::Done, outcome, rejected);
    }
    let is_kept = shows(session, line, |it| it.value == value).await;
    session.judge(rule::PARAMETER_SET, is_kept, || {
        "no line P with the value follows".to_owned()
    });
    is_kept
}

/// Whether a line P that follows the latest order shows a state of the parameter.
async fn shows(
    session: &mut Session,
    line: &ParameterLine,
    holds: impl Fn(&ParameterLine) -> bool,
) -> bool {
    let from = session.probe.left_at();
    let is_shown = |seen: &Seen| {
        seen.parameters
            .get(&line.place)
            .is_some_and(|(at, line_now)| *at > from && holds(line_now))
    };
    for _ in 0..ROUNDS {
        let missing = session.probe.see(|seen| seen.missing);
        let is_clean = |seen: &Seen| seen.missing == missing;
        if session.probe.until(LIMIT, is_shown).await || session.probe.see(is_clean) {
            break;
        }
        let key = key(line.name.as_str());
        session.order(Order::ReadParameter { key }).await;
    }
    session.probe.see(is_shown)
}

/// Stores another value of the parameter, then the one before.
async fn keep(session: &mut Session, line: &ParameterLine) {
    let is_unsaved = |seen: &Seen| seen.parameters.values().any(|(_, it)| it.value != it.kept);
    let other = [line.value + 1, line.value - 1];
    let other = other
        .into_iter()
        .find(|it| (line.least..=line.most).contains(it) && it.abs() <= ORDER_MAX);
    let Some(other) = other.filter(|_| !session.probe.see(is_unsaved)) else {
        session.not_tried(
            rule::PARAMETERS_KEPT,
            "a value is not stored, or can have no other",
        );
        return;
    };
    let rejected = session.rejected();
    let outcome = store(session, line, other).await;
    if outcome == Some(Outcome::NotFitted) {
        session.not_tried(rule::PARAMETERS_KEPT, "the robot cannot store values");
    } else if outcome == Some(Outcome::Done) {
        let is_kept = shows(session, line, |it| it.kept == other).await;
        session.judge(rule::PARAMETERS_KEPT, is_kept, || {
            format!("no line P shows {other} as the stored value")
        });
    } else {
        session.compare(rule::PARAMETERS_KEPT, Outcome::Done, outcome, rejected);
    }
    store(session, line, line.value).await;
}

/// Sets a parameter and stores it; returns the outcome of order K.
async fn store(session: &mut Session, line: &ParameterLine, value: i32) -> Option<Outcome> {
    let key = key(line.name.as_str());
    session.order(Order::SetParameter { key, value }).await;
    session.order(Order::KeepParameters).await
}
