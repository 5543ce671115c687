//! The table: one row per claim.

use crate::claim::{Claim, Figure, Reading, Required, Verdict};
use crate::statistics::Estimate;

/// A claim and its result.
pub(crate) struct Row {
    claim: &'static Claim,
    trials: usize,
    estimate: Option<Estimate>,
}

const HEAD: &str = "| part | claim | trials | result | 95 % interval | required | |\n\
                    |---|---|--:|--:|--:|--:|---|\n";

impl Row {
    /// A row from the readings of the trials.
    pub(crate) fn new(claim: &'static Claim, readings: &[Reading]) -> Self {
        Self {
            claim,
            trials: readings.len(),
            estimate: claim.figure.of(readings),
        }
    }

    /// Comparison of the figure with the requirement; `None` without a figure.
    pub(crate) fn verdict(&self) -> Option<Verdict> {
        self.estimate
            .as_ref()
            .map(|estimate| self.claim.required.judge(estimate))
    }

    /// Whether the row fails the command: clearly missed, and not or clearly worse than a known shortfall.
    pub(crate) fn is_alarming(&self) -> bool {
        let Claim {
            required,
            shortfall,
            ..
        } = self.claim;
        let required = shortfall
            .as_ref()
            .map_or(*required, |known| required.or(known.reached));
        self.estimate
            .as_ref()
            .is_some_and(|estimate| required.judge(estimate) == Verdict::ClearFail)
    }

    /// Text of the claim.
    pub(crate) const fn says(&self) -> &'static str {
        self.claim.says
    }

    fn text(&self) -> String {
        let figure = self.claim.figure;
        let (result, interval) = self.estimate.as_ref().map_or_else(
            || ("no trial".to_owned(), String::new()),
            |estimate| {
                let interval = match (estimate.low.is_finite(), estimate.high.is_finite()) {
                    (true, true) => format!(
                        "{} to {}",
                        number(figure, estimate.low),
                        number(figure, estimate.high)
                    ),
                    (true, false) => format!("above {}", number(figure, estimate.low)),
                    _ => String::new(),
                };
                (with_unit(figure, estimate.figure), interval)
            },
        );
        let required = match self.claim.required {
            Required::AtLeast(least) => format!("≥ {}", plain(least)),
            Required::AtMost(most) => format!("≤ {}", plain(most)),
            Required::Between(least, most) => format!("{} to {}", plain(least), plain(most)),
            Required::MoreThan(least) => format!("> {}", plain(least)),
            Required::Nothing => String::new(),
        };
        let verdict = match self.verdict() {
            _ if self.claim.required == Required::Nothing => "",
            None => "no result",
            Some(Verdict::Pass) => "pass",
            Some(Verdict::Fail) => "**fail**, within its interval",
            Some(Verdict::ClearFail) => "**fail**",
        };
        let note = match (self.verdict(), &self.claim.shortfall) {
            (Some(Verdict::Fail | Verdict::ClearFail), Some(known)) => format!(": {}", known.why),
            _ => String::new(),
        };
        format!(
            "| {} | {} | {} | {result} | {interval} | {required} | {verdict}{note} |\n",
            self.claim.part, self.claim.says, self.trials
        )
    }
}

/// All rows as a Markdown table.
pub(crate) fn markdown(rows: &[Row]) -> String {
    let rows: String = rows.iter().map(Row::text).collect();
    format!("{HEAD}{rows}")
}

fn number(figure: Figure, value: f64) -> String {
    if value.is_infinite() {
        return "never".to_owned();
    }
    match figure {
        Figure::Mean { digits, .. }
        | Figure::Median { digits, .. }
        | Figure::Least { digits, .. }
        | Figure::Greatest { digits, .. }
        | Figure::MeanRatio { digits, .. } => format!("{value:.digits$}"),
        Figure::PerHour => format!("{value:.3}"),
        Figure::Share | Figure::HoursTo => format!("{value:.1}"),
    }
}

fn with_unit(figure: Figure, value: f64) -> String {
    let unit = match figure {
        Figure::Share => "%",
        Figure::Mean { unit, .. }
        | Figure::Median { unit, .. }
        | Figure::Least { unit, .. }
        | Figure::Greatest { unit, .. }
        | Figure::MeanRatio { unit, .. } => unit,
        Figure::PerHour => "an hour",
        Figure::HoursTo if value.is_infinite() => "",
        Figure::HoursTo => "h",
    };
    format!("{} {unit}", number(figure, value))
        .trim_end()
        .to_owned()
}

/// The value without trailing zeros.
fn plain(value: f64) -> String {
    format!("{value}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claim::Shortfall;

    const CLAIM: Claim = Claim {
        part: "part",
        says: "something",
        figure: Figure::Share,
        required: Required::AtLeast(95.0),
        shortfall: Some(Shortfall {
            reached: 60.0,
            why: "the seed is silent",
        }),
    };

    fn row(successes: usize, trials: usize) -> Row {
        let readings: Vec<Reading> = (0..trials)
            .map(|trial| Reading::Success(trial < successes))
            .collect();
        Row::new(&CLAIM, &readings)
    }

    #[test]
    fn row_has_every_column() {
        assert_eq!(
            row(20, 20).text(),
            "| part | something | 20 | 100.0 % | 83.9 to 100.0 | ≥ 95 | pass |\n"
        );
        assert_eq!(
            row(10, 20).text(),
            "| part | something | 20 | 50.0 % | 29.9 to 70.1 | ≥ 95 | **fail**: the seed is silent |\n"
        );
        assert!(row(0, 0).text().contains("no trial") && row(0, 0).verdict().is_none());
    }

    #[test]
    fn known_shortfall_alarms_only_when_clearly_worse() {
        assert!(!row(20, 20).is_alarming());
        assert!(!row(10, 20).is_alarming(), "60 is within 29.9 to 70.1");
        assert!(row(5, 20).is_alarming(), "11.2 to 46.9 is below 60");
        assert!(!row(0, 0).is_alarming(), "there were no trials");
    }
}
