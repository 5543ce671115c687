//! What a parameter is to be: so many of what the robot counts, or the same in the whole unit.

use std::fmt;

/// What an operator wants a parameter to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amount {
    /// So many of what the robot counts: `116` of `V/10`.
    Counts(i32),
    /// Of the whole unit, with a decimal point: `11.6` volts. What the robot counts is known once it has said so.
    Decimal {
        /// The number without its point.
        digits: i32,
        /// Digits after the point.
        places: u8,
    },
}

impl Amount {
    /// Reads a whole or a decimal number; the zeros at a decimal's end count for nothing.
    pub(super) fn read(word: &str) -> Option<Self> {
        let Some((whole, fraction)) = word.split_once('.') else {
            return word.parse().ok().map(Self::Counts);
        };
        let fraction = fraction.trim_end_matches('0');
        let is_number = !whole.is_empty() && fraction.bytes().all(|byte| byte.is_ascii_digit());
        let digits = is_number.then(|| format!("{whole}{fraction}").parse().ok());
        Some(Self::Decimal {
            digits: digits??,
            places: u8::try_from(fraction.len()).ok()?,
        })
    }

    /// So many of what the robot counts; `None` for a number that is finer than its unit.
    #[must_use]
    pub fn counts(self, unit: &str) -> Option<i32> {
        match self {
            Self::Counts(counts) => Some(counts),
            Self::Decimal { digits, places } => {
                let (_, decimals) = whole_unit(unit).unwrap_or((unit, 0));
                let shift = 10_i32.checked_pow(decimals.checked_sub(places)?.into())?;
                digits.checked_mul(shift)
            }
        }
    }
}

impl fmt::Display for Amount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Counts(counts) => counts.fmt(f),
            // A point is what makes it one of the whole unit.
            Self::Decimal { digits, places: 0 } => write!(f, "{digits}.0"),
            Self::Decimal { digits, places } => f.write_str(&decimal(digits, places)),
        }
    }
}

/// What a unit that is a tenth, a hundredth or a thousandth is of, and the decimals of that: `V/10` is of `V`, with one.
fn whole_unit(unit: &str) -> Option<(&str, u8)> {
    let (whole, divisor) = unit.rsplit_once('/')?;
    let decimals = match divisor {
        "10" => 1,
        "100" => 2,
        "1000" => 3,
        _ => return None,
    };
    Some((whole, decimals))
}

/// A value that the robot counts, in the whole unit: 116 of `V/10` are `11.6` and `V`. `None` where the robot's own unit is
/// a whole one.
#[must_use]
pub fn in_whole_unit(value: i32, unit: &str) -> Option<(String, &str)> {
    let (whole, decimals) = whole_unit(unit)?;
    Some((decimal(value, decimals), whole))
}

fn decimal(digits: i32, places: u8) -> String {
    let width = usize::from(places) + 1;
    let sign = if digits < 0 { "-" } else { "" };
    let mut text = format!("{:0width$}", digits.unsigned_abs());
    text.insert(text.len() - usize::from(places), '.');
    format!("{sign}{text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decimal_counts_in_the_whole_unit() {
        for (word, unit, counts) in [
            ("116", "V/10", Some(116)),
            ("11.6", "V/10", Some(116)),
            ("12.0", "V/10", Some(120)),
            ("12.", "V/10", Some(120)),
            ("-0.5", "V/10", Some(-5)),
            ("4.99", "in/1000", Some(4990)),
            ("8.0", "in/s", Some(8)),
            ("11.65", "V/10", None),
            ("8.5", "in/s", None),
            ("0.5", "1/256", None),
            ("2000000000.0", "V/10", None),
        ] {
            let amount = Amount::read(word).unwrap_or_else(|| panic!("{word}"));
            assert_eq!(amount.counts(unit), counts, "{word} {unit}");
        }
        for wrong in ["", ".", ".5", "1.5.2", "1e3", "x", "1.-5", "11,6"] {
            assert_eq!(Amount::read(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn what_is_written_reads_back() {
        for word in ["116", "-3", "11.6", "12.0", "-0.05", "0.007"] {
            let amount = Amount::read(word).unwrap_or_else(|| panic!("{word}"));
            assert_eq!(amount.to_string(), word);
        }
    }

    #[test]
    fn a_count_is_told_in_the_whole_unit() {
        let told = |value, unit| in_whole_unit(value, unit);
        assert_eq!(told(116, "V/10"), Some(("11.6".to_owned(), "V")));
        assert_eq!(told(-5, "in/1000"), Some(("-0.005".to_owned(), "in")));
        assert_eq!(told(15, "in/s"), None);
        assert_eq!(told(15, "1/256"), None);
    }
}
