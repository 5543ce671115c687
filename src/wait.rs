//! Waits for a time or a condition of the robot, in scripts and in the dashboard: `wait 30s`, `wait until driven within 2m`, `expect battery > 12`.
//!
//! A condition compares fields of the robot's lines, which have the names of `export --to jsonl`.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use groundwave_captures::messages::{Field, Telemetry, Value};
use groundwave_captures::when::span;
use groundwave_protocol::decoder::Received;

use crate::suggest;

/// Units at the end of field names, which a script may omit.
const UNITS: [&str; 6] = ["v", "in", "deg", "in_s", "s", "pct"];

const FORMS: &str = "a condition is `driven`, `stopped`, `mode home` or a field of the robot's lines, such as `battery < 12` or `bump none`";

/// A pause or a check between two commands.
#[derive(Clone, Debug, PartialEq)]
pub struct Wait {
    words: String,
    kind: Kind,
}

/// Kind of a wait.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// Wait for a time.
    For(Duration),
    /// Wait until a condition holds, or until the time limit.
    Until(Condition, Option<Duration>),
    /// Check a condition once; it must hold.
    Expect(Condition),
}

/// A condition on the robot's lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition(Vec<Term>);

#[derive(Clone, Debug, PartialEq)]
struct Term {
    field: &'static str,
    accepted: &'static [Ordering],
    than: Than,
}

#[derive(Clone, Debug, PartialEq)]
enum Than {
    Number(f64),
    Word(String),
    Field(&'static str),
}

/// The latest values of the fields that the robot has sent.
#[derive(Clone, Debug, Default)]
pub struct Readings(BTreeMap<&'static str, Reading>);

#[derive(Clone, Debug, PartialEq)]
enum Reading {
    Number(f64),
    Word(String),
}

/// A wait in progress.
#[derive(Clone, Debug)]
pub struct Waiting {
    wait: Wait,
    /// Readings since the wait began. Earlier lines do not count: a list driven before does not end a wait.
    readings: Readings,
    /// Maximum time for `expect` to receive the fields.
    patience: Duration,
}

const EQUAL: &[Ordering] = &[Ordering::Equal];
const UNEQUAL: &[Ordering] = &[Ordering::Less, Ordering::Greater];
const LESS: &[Ordering] = &[Ordering::Less];
const GREATER: &[Ordering] = &[Ordering::Greater];
const AT_MOST: &[Ordering] = &[Ordering::Less, Ordering::Equal];
const AT_LEAST: &[Ordering] = &[Ordering::Greater, Ordering::Equal];

impl Wait {
    /// Parses a line of a script; `None` for a command to the robot.
    ///
    /// # Errors
    /// If the words after `wait` or `expect` are wrong.
    pub fn from_words(words: &[&str]) -> Option<Result<Self, String>> {
        let kind = match words {
            ["wait", "until", condition @ .., "within", limit] => {
                parse_time(limit).and_then(|limit| {
                    Condition::from_words(condition).map(|it| Kind::Until(it, Some(limit)))
                })
            }
            ["wait", "until", .., "within"] => {
                Err("`within` takes a time, like `within 2m`".to_owned())
            }
            ["wait", "until", condition @ ..] => {
                Condition::from_words(condition).map(|it| Kind::Until(it, None))
            }
            ["wait", time] => parse_time(time).map(Kind::For),
            ["wait", ..] => Err(
                "`wait` takes a time, like `wait 30s`, or `wait until CONDITION [within 2m]`"
                    .to_owned(),
            ),
            ["expect", condition @ ..] => Condition::from_words(condition).map(Kind::Expect),
            _ => return None,
        };
        Some(kind.map(|kind| Self {
            words: words.join(" "),
            kind,
        }))
    }

    /// Kind of the wait.
    #[must_use]
    pub const fn kind(&self) -> &Kind {
        &self.kind
    }

    /// Condition of the wait, if any.
    #[must_use]
    pub const fn condition(&self) -> Option<&Condition> {
        match &self.kind {
            Kind::For(_) => None,
            Kind::Until(condition, _) | Kind::Expect(condition) => Some(condition),
        }
    }
}

impl fmt::Display for Wait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

impl Waiting {
    /// Begins to wait; `expect` waits at most `patience` for its fields.
    #[must_use]
    pub fn new(wait: Wait, patience: Duration) -> Self {
        Self {
            wait,
            readings: Readings::default(),
            patience,
        }
    }

    /// The wait.
    #[must_use]
    pub const fn wait(&self) -> &Wait {
        &self.wait
    }

    /// Takes a line of the robot.
    pub fn take(&mut self, line: &Received) {
        self.readings.take(line);
    }

    /// Maximum duration; `None` without a limit.
    #[must_use]
    pub const fn limit(&self) -> Option<Duration> {
        match self.wait.kind() {
            Kind::For(time) => Some(*time),
            Kind::Until(_, limit) => *limit,
            Kind::Expect(_) => Some(self.patience),
        }
    }

    /// Result of the wait: the values seen, or the reason for failure; `None` while it lasts.
    #[must_use]
    pub fn ended(&self, after: Duration) -> Option<Result<String, String>> {
        let is_over = self.limit().is_some_and(|limit| after >= limit);
        let Some(condition) = self.wait.condition() else {
            return is_over.then(|| Ok(String::new()));
        };
        let seen = || condition.seen(&self.readings);
        match condition.holds(&self.readings) {
            Some(true) => Some(Ok(seen())),
            Some(false) if matches!(self.wait.kind(), Kind::Expect(_)) => {
                Some(Err(format!("`{}`: {}", self.wait, seen())))
            }
            _ if is_over => Some(Err(format!("`{}`: not met in time; {}", self.wait, seen()))),
            _ => None,
        }
    }
}

fn parse_time(text: &str) -> Result<Duration, String> {
    span(text).ok_or_else(|| format!("`{text}` is not a time; write 30s, 2m or 1.5h"))
}

impl Condition {
    fn from_words(words: &[&str]) -> Result<Self, String> {
        let term = |field, accepted, than| Term {
            field,
            accepted,
            than,
        };
        let all = match words {
            ["driven"] => vec![
                term("waypoints_count", GREATER, Than::Number(0.0)),
                term("waypoints_driven", EQUAL, Than::Field("waypoints_count")),
            ],
            ["stopped"] => vec![
                term("velocity_in_s", EQUAL, Than::Number(0.0)),
                term("rotation_in_s", EQUAL, Than::Number(0.0)),
                term("wheel_left_in_s", EQUAL, Than::Number(0.0)),
                term("wheel_right_in_s", EQUAL, Than::Number(0.0)),
            ],
            [word] if let Some([name, relation, value]) = parts(word) => {
                vec![compare(name, relation, value)?]
            }
            [name, value] => vec![compare(name, "=", value)?],
            [name, relation, value] => vec![compare(name, relation, value)?],
            _ => return Err(FORMS.to_owned()),
        };
        Ok(Self(all))
    }

    /// Whether the condition holds; `None` while a field has not been received.
    #[must_use]
    pub fn holds(&self, readings: &Readings) -> Option<bool> {
        let mut holds = true;
        for Term {
            field,
            accepted,
            than,
        } in &self.0
        {
            let order = match (readings.0.get(field)?, than) {
                (Reading::Number(number), Than::Number(than)) => number.partial_cmp(than)?,
                (Reading::Word(word), Than::Word(than)) => word.cmp(than),
                (reading, Than::Field(other)) => match (reading, readings.0.get(other)?) {
                    (Reading::Number(number), Reading::Number(than)) => number.partial_cmp(than)?,
                    _ => return None,
                },
                _ => return None,
            };
            holds &= accepted.contains(&order);
        }
        Some(holds)
    }

    /// The fields of the condition with their values as text: `mode prowl, battery_v 12.8`.
    #[must_use]
    pub fn seen(&self, readings: &Readings) -> String {
        let of = |term: &Term| match readings.0.get(term.field) {
            Some(Reading::Number(number)) => format!("{} {number}", term.field),
            Some(Reading::Word(word)) => format!("{} {word}", term.field),
            None => format!("no {} heard", term.field),
        };
        self.0.iter().map(of).collect::<Vec<_>>().join(", ")
    }
}

/// The field of the robot's lines with a name; the name may omit the unit.
pub(crate) fn field_named(name: &str) -> Option<&'static Field> {
    Telemetry::FIELDS.iter().find(|field| {
        let unit = field.name.strip_prefix(name);
        let unit = unit.and_then(|end| end.strip_prefix('_'));
        field.name == name || unit.is_some_and(|unit| UNITS.contains(&unit))
    })
}

/// Converts a field's value to the word used in recordings; commands name two modes differently.
pub(crate) fn recorded_word<'a>(field: &str, value: &'a str) -> &'a str {
    match (field, value) {
        ("mode", "home") => "go_home",
        ("mode", "dock") => "forage",
        _ => value,
    }
}

/// The command's word for a field's value; the reverse of [`recorded_word`].
fn command_word<'a>(field: &str, value: &'a str) -> &'a str {
    match (field, value) {
        ("mode", "go_home") => "home",
        ("mode", "forage") => "dock",
        _ => value,
    }
}

/// Checks that a field can be compared with a value.
pub(crate) fn check_comparison(name: &str, relation: &str, value: &str) -> Result<(), String> {
    compare(name, relation, value).map(|_| ())
}

/// The parts of a comparison without spaces, such as `battery<12`.
fn parts(word: &str) -> Option<[&str; 3]> {
    const RELATION: [char; 4] = ['<', '>', '=', '!'];
    let (name, rest) = word.split_at(word.find(RELATION)?);
    let value = rest.trim_start_matches(RELATION);
    let (relation, value) = rest.split_at(rest.len() - value.len());
    Some([name, relation, value])
}

fn compare(name: &str, relation: &str, value: &str) -> Result<Term, String> {
    let accepted = match relation {
        "=" | "==" => EQUAL,
        "!=" => UNEQUAL,
        "<" => LESS,
        "<=" => AT_MOST,
        ">" => GREATER,
        ">=" => AT_LEAST,
        _ => {
            return Err(format!(
                "`{relation}` compares nothing; write <, <=, =, !=, >= or >"
            ));
        }
    };
    let Some(field) = field_named(name) else {
        let known = Telemetry::FIELDS.iter().map(|field| field.name);
        let question = suggest::question_or(name, known, FORMS);
        return Err(format!(
            "the robot's lines have no field `{name}`{question}"
        ));
    };
    let value = recorded_word(field.name, value);
    let is_number = field.words.is_empty() && field.kind != "string";
    let than = match value.parse::<f64>() {
        Ok(number) if is_number && number.is_finite() => Than::Number(number),
        _ if is_number => {
            return Err(format!("{} is a number, and `{value}` is none", field.name));
        }
        _ if !field.words.is_empty() && !field.words.contains(&value) => {
            let words = field.words.iter();
            let words = words.map(|word| command_word(field.name, word));
            let all = words.clone().collect::<Vec<_>>().join(", ");
            let question = suggest::question_or(value, words, format!("it can be {all}"));
            return Err(format!("{} is never `{value}`{question}", field.name));
        }
        _ => Than::Word(value.to_owned()),
    };
    if matches!(than, Than::Word(_)) && ![EQUAL, UNEQUAL].contains(&accepted) {
        return Err(format!("{} is a word; compare it with = or !=", field.name));
    }
    Ok(Term {
        field: field.name,
        accepted,
        than,
    })
}

impl Readings {
    /// Takes the fields of a line.
    pub fn take(&mut self, received: &Received) {
        let mut keep = |name, value: Option<Value<'_>>| -> Result<(), std::convert::Infallible> {
            let reading = match value {
                Some(Value::Integer(number)) => Reading::Number(number as f64),
                Some(Value::Decimal(number)) => Reading::Number(number),
                Some(Value::Word(word)) => Reading::Word(word.to_owned()),
                Some(Value::Text(text)) => Reading::Word(text.to_owned()),
                None => return Ok(()),
            };
            self.0.insert(name, reading);
            Ok(())
        };
        let Ok(()) = Telemetry::from(received).for_each(&mut keep);
    }
}

#[cfg(test)]
mod tests {
    use groundwave_protocol::decoder::Decoder;

    use super::*;

    fn condition(words: &str) -> Result<Condition, String> {
        Condition::from_words(&words.split(' ').collect::<Vec<_>>())
    }

    /// The first lines of a robot.
    const LINES: &str = r"C00 04 000000 001 00.01 `````````````````` 000 000 000 0000 ---- -   (```$Q$OF
B01 04 12.8 ----- ----- 000/000 !!V1+_ 03 090 116 UBTIS--D 001 00    (`T``\^GB
A02 +000.0 +000.0 000 +12 +00 +00 +00 082 082 35 46 ....... P---s..- (```$HP:P
A03 +000.0 +001.7 000 +12 +00 +05 +05 081 081 35 46 ....... P----..- (```$DL!L
";

    fn readings() -> Readings {
        let mut readings = Readings::default();
        let bytes = LINES.replace('\n', "\r\n");
        for received in Decoder::default().lines(bytes.as_bytes()) {
            readings.take(&received);
        }
        readings
    }

    #[test]
    fn a_condition_holds_by_the_latest_lines() {
        let readings = readings();
        for (words, holds) in [
            ("mode prowl", Some(true)),
            ("mode home", Some(false)),
            ("mode != home", Some(true)),
            ("battery < 12", Some(false)),
            ("battery_v >= 12.8", Some(true)),
            ("battery<12", Some(false)),
            ("battery_v>=12.8", Some(true)),
            ("mode!=home", Some(true)),
            ("wheel_left_in_s > 4", Some(true)),
            ("stopped", Some(false)),
            ("driven", Some(false)),
            // No line T was received.
            ("text hello", None),
        ] {
            assert_eq!(condition(words).unwrap().holds(&readings), holds, "{words}");
        }
        let seen = condition("battery < 12").unwrap().seen(&readings);
        assert_eq!(seen, "battery_v 12.8");
    }

    #[test]
    fn nothing_holds_before_the_first_line() {
        let none = Readings::default();
        let condition = condition("stopped").unwrap();
        assert_eq!(condition.holds(&none), None);
        assert!(condition.seen(&none).contains("no velocity_in_s heard"));
    }

    #[test]
    fn an_empty_list_is_not_driven() {
        let mut readings = readings();
        for (driven, count, holds) in [(0.0, 0.0, false), (2.0, 3.0, false), (3.0, 3.0, true)] {
            readings
                .0
                .insert("waypoints_driven", Reading::Number(driven));
            readings.0.insert("waypoints_count", Reading::Number(count));
            let condition = condition("driven").unwrap();
            assert_eq!(
                condition.holds(&readings),
                Some(holds),
                "{driven} of {count}"
            );
        }
    }

    #[test]
    fn a_missing_time_limit_is_named() {
        let words = ["wait", "until", "driven", "within"];
        let error = Wait::from_words(&words).unwrap().unwrap_err();
        assert!(error.contains("`within` takes a time"), "{error}");
    }

    #[test]
    fn mistakes_are_named_with_a_suggestion() {
        for (words, error) in [
            ("batery_v < 12", "did you mean `battery_v`"),
            ("mode prowel", "did you mean `prowl`"),
            ("mode xyzzy", "home, dock"),
            ("battery ~ 12", "compares nothing"),
            ("battery<<12", "compares nothing"),
            ("battery<", "is a number"),
            ("battery < low", "is a number"),
            ("battery < nan", "is a number"),
            ("battery > inf", "is a number"),
            ("mode < home", "compare it with ="),
            ("", "a condition is"),
            ("a b c d", "a condition is"),
        ] {
            let message = condition(words).unwrap_err();
            assert!(message.contains(error), "{words}: {message}");
        }
    }

    #[test]
    fn waits_have_times_and_limits() {
        let parse = |line: &str| Wait::from_words(&line.split(' ').collect::<Vec<_>>());
        assert_eq!(parse("stop"), None);
        let kind = |line: &str| parse(line).unwrap().unwrap().kind;
        assert_eq!(kind("wait 30s"), Kind::For(Duration::from_secs(30)));
        let Kind::Until(_, limit) = kind("wait until driven within 2m") else {
            panic!();
        };
        assert_eq!(limit, Some(Duration::from_mins(2)));
        for line in [
            "wait",
            "wait soon",
            "wait until",
            "wait until driven within soon",
            "expect",
        ] {
            assert!(parse(line).unwrap().is_err(), "{line}");
        }
    }
}
