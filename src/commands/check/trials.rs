//! `check --send`: asks before sending, and prints the verdicts.

use std::io::{self, BufRead as _, IsTerminal as _, Write};

use serde_json::{Value, json};

use super::super::{Exit, Fault, out};
use crate::conformance::{Trials, Verdict};
use crate::safe_text;

const WARNING: &str = "\
The robot will be sent commands: modes, layers, a route, a pose, hand drive at 4 in/s, a failsafe, parameters.
It ends stopped, without a route, with another pose and layer 0 allowed. Lift its wheels off the floor.";

/// Asks whether to send; fails without an answer.
pub(super) fn confirm(is_agreed: bool) -> Result<(), Fault> {
    if is_agreed {
        return Ok(());
    }
    let stdin = io::stdin();
    if !stdin.is_terminal() {
        return Err(Fault::new(
            Exit::Usage,
            "--send asks before sending, and standard input is not a terminal; add --yes",
        ));
    }
    let mut errors = io::stderr();
    let asked = write!(errors, "{WARNING}\nGo on? [y/N] ").and_then(|()| errors.flush());
    let mut answer = String::new();
    let answered = asked.and_then(|()| stdin.lock().read_line(&mut answer));
    let is_yes = ["y", "yes"].contains(&answer.trim().to_lowercase().as_str());
    if answered.is_ok() && is_yes {
        return Ok(());
    }
    Err(Fault::new(Exit::Failed, "not confirmed; nothing was sent"))
}

/// Prints a verdict.
pub(super) fn print(verdict: &Verdict) -> io::Result<()> {
    let mut out = out();
    match verdict {
        Verdict::Kept(rule) => writeln!(out, "kept       {}", rule.rule)?,
        Verdict::NotTried(rule, why) => writeln!(out, "not tried  {}: {why}", rule.rule)?,
        Verdict::Broken(rule, did) => {
            writeln!(out, "BROKEN     {}: {}", rule.rule, safe_text::line(did))?;
            writeln!(out, "           likely cause: {}", rule.cause)?;
            writeln!(
                out,
                "           {} (SPEC.md section {}, {})",
                rule.remedy, rule.section, rule.code
            )?;
        }
    }
    out.flush()
}

pub(super) fn to_json(verdict: &Verdict) -> Value {
    let (rule, name, text) = match verdict {
        Verdict::Kept(rule) => (rule, "kept", None),
        Verdict::Broken(rule, did) => (rule, "broken", Some(did.as_str())),
        Verdict::NotTried(rule, why) => (rule, "not-tried", Some(*why)),
    };
    json!({
        "code": rule.code,
        "level": rule.level,
        "section": rule.section,
        "rule": rule.rule,
        "verdict": name,
        "text": text,
        "cause": rule.cause,
        "remedy": rule.remedy,
    })
}

/// Number of rules broken.
pub(super) fn broken(trials: &Trials) -> usize {
    let verdicts = trials.verdicts().iter();
    verdicts
        .filter(|it| matches!(it, Verdict::Broken(..)))
        .count()
}

/// Describes the level reached, and the rules broken at the next level; `None` if no rule is broken.
pub(super) fn lacking(trials: &Trials) -> Option<String> {
    let reached = trials.level()?;
    let rules: Vec<&str> = trials
        .verdicts()
        .iter()
        .filter_map(|verdict| match verdict {
            Verdict::Broken(rule, _) if rule.level == reached + 1 => Some(rule.rule),
            _ => None,
        })
        .collect();
    (!rules.is_empty()).then(|| {
        let next = reached + 1;
        format!(
            "Level {reached} is reached. Level {next} needs: {}.",
            rules.join("; ")
        )
    })
}
