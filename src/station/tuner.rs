//! Delivers parameter commands, which end with a line P, not with an acknowledgement.

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use groundwave_protocol::command::Order;
use groundwave_protocol::parameter::{VALUE_MAX, key};
use groundwave_protocol::telemetry::{Outcome, ParameterLine};

use crate::event::Moment;
use crate::request::{Amount, Tuning};

/// Time after an order at which the line P counts as lost. The robot sends it as its next line or the one after, at most 1.5
/// s after the order.
const PATIENCE: Duration = Duration::from_millis(2500);

/// Maximum number of consecutive rounds without an answer. If every second line is lost, one command in a thousand fails.
const VAIN_ROUNDS_MAX: u8 = 12;

/// State of a parameter command.
#[derive(Clone, Debug)]
pub(super) struct Tuner {
    tuning: Tuning,
    /// The value to set as an integer; `None` for a decimal until the robot has reported its unit.
    counts: Option<i32>,
    /// Numbers of the parameters received.
    heard: BTreeSet<u8>,
    /// Number of parameters of the robot.
    count: Option<u8>,
    state: State,
    /// Numbers of the parameters still to be requested in this round, without waiting for the answers.
    round: VecDeque<u8>,
    /// Number of consecutive rounds without an answer.
    vain_rounds: u8,
}

#[derive(Clone, Copy, Debug)]
enum State {
    /// An order is being sent.
    Ordered,
    /// The robot has executed the order; its line P is due.
    Listening { again_at: Moment },
    /// The robot has refused the order; the line P with its limits is due.
    Refused { outcome: Outcome, until: Moment },
}

/// The next step of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Wait for the robot.
    Wait,
    /// Send another order.
    Ask(Order),
    /// The robot has executed and confirmed the command.
    Confirmed,
    /// The robot has refused the command.
    Refused(Outcome),
    /// The robot has not answered.
    TimedOut,
}

impl Tuner {
    /// Starts a command; returns its state and its first order.
    pub(super) fn begin(tuning: Tuning) -> (Self, Order) {
        let tuner = Self {
            tuning,
            counts: match tuning {
                Tuning::Set(_, Amount::Counts(counts)) => Some(counts),
                _ => None,
            },
            heard: BTreeSet::new(),
            count: None,
            state: State::Ordered,
            round: VecDeque::new(),
            vain_rounds: 0,
        };
        (tuner, order(&tuning))
    }

    /// Whether the robot is sending a list of parameters.
    pub(super) const fn is_listening_to_list(&self) -> bool {
        matches!(
            (self.tuning, self.state),
            (Tuning::List, State::Listening { .. })
        )
    }

    /// Continues a list of parameters; returns its state and its next order.
    pub(super) fn resume(mut self) -> (Self, Order) {
        self.begin_round();
        let place = self.round.pop_front().unwrap_or_default().into();
        self.state = State::Ordered;
        (self, Order::ReadParameters { place })
    }

    /// Plans to request the parameters of a list that are missing.
    fn begin_round(&mut self) {
        if let (Tuning::List, Some(count)) = (self.tuning, self.count) {
            let missing = (1..=count).filter(|place| !self.heard.contains(place));
            self.round = missing.collect();
        }
    }

    /// Takes the outcome of an order.
    pub(super) fn take_outcome(&mut self, now: Moment, outcome: Outcome) -> Verdict {
        match (outcome, self.tuning) {
            (Outcome::Done, Tuning::Save) => Verdict::Confirmed,
            (Outcome::Done, _) if self.is_complete() => Verdict::Confirmed,
            (Outcome::Done, _) if !self.round.is_empty() => self.ask_next(),
            (Outcome::Done, _) => {
                self.state = State::Listening {
                    again_at: now + PATIENCE,
                };
                Verdict::Wait
            }
            // The next line P contains the limits.
            (Outcome::BadValue, Tuning::Set(..)) => {
                self.state = State::Refused {
                    outcome,
                    until: now + PATIENCE,
                };
                Verdict::Wait
            }
            (outcome, _) => Verdict::Refused(outcome),
        }
    }

    /// Takes a line P; returns whether it belongs to the command, and the next step.
    pub(super) fn take_line(&mut self, now: Moment, line: &ParameterLine) -> (bool, Verdict) {
        if let State::Refused { outcome, .. } = self.state {
            return match self.tuning {
                Tuning::Set(name, _) if name == line.name => (true, Verdict::Refused(outcome)),
                _ => (false, Verdict::Wait),
            };
        }
        if let Some(followed) = self.learn_unit(line) {
            return followed;
        }
        let is_meant = match self.tuning {
            Tuning::List => true,
            Tuning::Get(name) => name == line.name,
            Tuning::Set(name, _) => name == line.name && self.counts == Some(line.value),
            Tuning::Save => false,
        };
        if !is_meant || !self.heard.insert(line.place) {
            return (false, Verdict::Wait);
        }
        self.count = Some(line.count);
        self.vain_rounds = 0;
        let State::Listening { again_at } = &mut self.state else {
            return (true, Verdict::Wait);
        };
        *again_at = now + PATIENCE;
        let verdict = if self.is_complete() {
            Verdict::Confirmed
        } else {
            Verdict::Wait
        };
        (true, verdict)
    }

    /// Takes the unit of a parameter that is to be set to a decimal; sets the value as an integer.
    fn learn_unit(&mut self, line: &ParameterLine) -> Option<(bool, Verdict)> {
        let (Tuning::Set(name, amount), None, State::Listening { .. }) =
            (self.tuning, self.counts, self.state)
        else {
            return None;
        };
        if name != line.name {
            return None;
        }
        let counts = amount.counts(line.unit.as_str());
        let Some(value) = counts.filter(|counts| counts.abs() <= VALUE_MAX) else {
            return Some((true, Verdict::Refused(Outcome::BadValue)));
        };
        self.counts = Some(value);
        self.vain_rounds = 0;
        self.state = State::Ordered;
        let key = key(name.as_str());
        Some((false, Verdict::Ask(Order::SetParameter { key, value })))
    }

    /// Handles the passing of time.
    pub(super) fn handle_timeout(&mut self, now: Moment) -> Verdict {
        match self.state {
            State::Listening { again_at } if now >= again_at => {
                self.vain_rounds += 1;
                if self.vain_rounds > VAIN_ROUNDS_MAX {
                    return Verdict::TimedOut;
                }
                self.begin_round();
                self.ask_next()
            }
            State::Refused { outcome, until } if now >= until => Verdict::Refused(outcome),
            _ => Verdict::Wait,
        }
    }

    /// Latest time for the next call of [`Self::handle_timeout`].
    pub(super) const fn poll_timeout(&self) -> Option<Moment> {
        match self.state {
            State::Ordered => None,
            State::Listening { again_at } => Some(again_at),
            State::Refused { until, .. } => Some(until),
        }
    }

    /// Requests the missing parameters; never sets a value again.
    fn ask_next(&mut self) -> Verdict {
        self.state = State::Ordered;
        Verdict::Ask(match self.tuning {
            Tuning::Get(name) | Tuning::Set(name, _) => Order::ReadParameter {
                key: key(name.as_str()),
            },
            Tuning::List | Tuning::Save => Order::ReadParameters {
                place: self.round.pop_front().unwrap_or_default().into(),
            },
        })
    }

    fn is_complete(&self) -> bool {
        match self.tuning {
            Tuning::List => self.count.map(usize::from) == Some(self.heard.len()),
            Tuning::Get(_) | Tuning::Set(..) => !self.heard.is_empty(),
            Tuning::Save => true,
        }
    }
}

/// The first order of a command. Setting a decimal begins with a request for the unit.
pub(super) fn order(tuning: &Tuning) -> Order {
    match tuning {
        Tuning::List => Order::ReadParameters { place: 0 },
        Tuning::Get(name) | Tuning::Set(name, Amount::Decimal { .. }) => Order::ReadParameter {
            key: key(name.as_str()),
        },
        Tuning::Set(name, Amount::Counts(value)) => Order::SetParameter {
            key: key(name.as_str()),
            value: *value,
        },
        Tuning::Save => Order::KeepParameters,
    }
}
