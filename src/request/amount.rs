//! Values of parameters, as counts of the robot's unit or as decimals of the whole unit.

use std::fmt;

/// A value for a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amount {
    /// Whole number of the robot's unit: `116` of `V/10`.
    Counts(i32),
    /// A decimal of the whole unit: `11.6` volts. Converted to counts once the robot has reported its unit.
    Decimal {
        /// The digits without the decimal point, as a number.
        digits: i32,
        /// Number of digits after the decimal point.
        places: u8,
    },
}

impl Amount {
    /// Parses a whole or decimal number; trailing zeros of a decimal are ignored.
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

    /// Whether the value is zero in any unit.
    pub(super) const fn is_zero(self) -> bool {
        matches!(self, Self::Counts(0) | Self::Decimal { digits: 0, .. })
    }

    /// The value in counts of `unit`; `None` if it is finer than the unit.
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
            // A decimal point means a value of the whole unit.
            Self::Decimal { digits, places: 0 } => write!(f, "{digits}.0"),
            Self::Decimal { digits, places } => f.write_str(&decimal(digits, places)),
        }
    }
}

/// The whole unit of a tenth, hundredth or thousandth, and its decimals: `V` and 1 for `V/10`.
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

/// A count in the whole unit: `11.6` and `V` for 116 of `V/10`. `None` if `unit` is already a whole unit.
#[must_use]
pub fn in_whole_unit(value: i32, unit: &str) -> Option<(String, &str)> {
    let (whole, decimals) = whole_unit(unit)?;
    Some((decimal(value, decimals), whole))
}

/// A unit of the wire in words: none for a switch or a plain number; `256ths` for a fraction, of which the number is the numerator.
#[must_use]
pub fn unit_words(unit: &str) -> String {
    match (unit, unit.strip_prefix("1/")) {
        ("1" | "0 or 1", _) => String::new(),
        (_, Some(parts)) => format!("{parts}ths"),
        _ => unit.to_owned(),
    }
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
    fn units_have_words() {
        for (unit, words) in [
            ("in/s", "in/s"),
            ("1/256", "256ths"),
            ("0 or 1", ""),
            ("1", ""),
        ] {
            assert_eq!(unit_words(unit), words);
        }
    }

    #[test]
    fn decimals_are_of_the_whole_unit() {
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
    fn formatted_amount_parses_to_the_same() {
        for word in ["116", "-3", "11.6", "12.0", "-0.05", "0.007"] {
            let amount = Amount::read(word).unwrap_or_else(|| panic!("{word}"));
            assert_eq!(amount.to_string(), word);
        }
    }

    #[test]
    fn counts_convert_to_the_whole_unit() {
        let volts = Some(("11.6".to_owned(), "V"));
        assert_eq!(in_whole_unit(116, "V/10"), volts);
        let inches = Some(("-0.005".to_owned(), "in"));
        assert_eq!(in_whole_unit(-5, "in/1000"), inches);
        assert_eq!(in_whole_unit(15, "in/s"), None);
        assert_eq!(in_whole_unit(15, "1/256"), None);
    }
}
