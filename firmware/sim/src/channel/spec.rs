//! Faults of the radio as one line of text.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Faults of the radio, the same in both directions. The default has none.
///
/// The text form lists options separated by commas:
/// `ber=1e-3,burst=50,drop=0.01,dup=0.01,delay=0.5s,half-duplex,squelch,modem=hc-12,out=10s..12s`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelSpec {
    /// Share of bits that flip, including start bits, stop bits and the idle line.
    pub ber: f64,
    /// Mean length in bits of error bursts (a Gilbert-Elliott channel whose bad state flips every other bit); `None`
    /// spreads the errors evenly.
    pub burst_bits: Option<f64>,
    /// Share of received bytes that are lost.
    pub drop: f64,
    /// Share of received bytes that are duplicated.
    pub dup: f64,
    /// Delay of every byte.
    pub delay_ms: u64,
    /// Whether a side cannot receive while it sends.
    pub half_duplex: bool,
    /// Output of a receiver without a carrier.
    pub squelch: Squelch,
    /// Radio modules that send bytes in packets, instead of a radio that transmits single bits. Modules are half duplex
    /// and output no noise; a bit error loses a whole packet.
    pub modem: Option<Modem>,
    /// Times of complete outages, in milliseconds since the start.
    pub outages_ms: Vec<Range<u64>>,
}

/// Output of a receiver that hears no carrier: none, or random bits as from an FM radio with open squelch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Squelch {
    /// No output.
    #[default]
    Closed,
    /// Noise while the other side is silent, but not in an outage, which is a disconnected cable.
    Open,
    /// Noise while the other side is silent, and in outages.
    OpenInOutages,
}

/// A radio module with a serial port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Modem {
    /// HC-12 in mode FU3 at 2400 baud.
    Hc12,
    /// XBee 802.15.4 in transparent mode.
    Xbee,
}

impl Modem {
    const ALL: [Self; 2] = [Self::Hc12, Self::Xbee];

    /// Name of the modem in the `modem=` option.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hc12 => "hc-12",
            Self::Xbee => "xbee",
        }
    }
}

/// Reason why a channel specification is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("channel option `{option}`: {problem}")]
pub struct ChannelSpecError {
    option: String,
    problem: String,
}

/// Probability that a bit of a burst flips.
pub(super) const BURST_FLIPS: f64 = 0.5;

/// Maximum bit error rate: above it hardly a line arrives.
const BER_MAX: f64 = 0.25;

impl ChannelSpec {
    /// Whether there is an outage at this time.
    #[must_use]
    pub fn is_out(&self, now_ms: u64) -> bool {
        self.outages_ms
            .iter()
            .any(|outage| outage.contains(&now_ms))
    }
}

impl FromStr for ChannelSpec {
    type Err = ChannelSpecError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut spec = Self::default();
        for option in text
            .split(',')
            .map(str::trim)
            .filter(|option| !option.is_empty())
        {
            spec.set(option).map_err(|problem| ChannelSpecError {
                option: option.to_owned(),
                problem,
            })?;
        }
        if spec.burst_bits.is_some() && spec.ber == 0.0 {
            return Err(ChannelSpecError {
                option: "burst".to_owned(),
                problem: "needs an error rate as well: add one, like ber=1e-3".to_owned(),
            });
        }
        if spec.modem.is_some() && (spec.half_duplex || spec.squelch != Squelch::Closed) {
            return Err(ChannelSpecError {
                option: "modem".to_owned(),
                problem: "is always half duplex and without noise: remove half-duplex and squelch"
                    .to_owned(),
            });
        }
        Ok(spec)
    }
}

impl ChannelSpec {
    fn set(&mut self, option: &str) -> Result<(), String> {
        let (name, value) = option.split_once('=').unwrap_or((option, ""));
        match name {
            "ber" => self.ber = share(value, BER_MAX, "ber=1e-3")?,
            "drop" => self.drop = share(value, 1.0, "drop=0.01")?,
            "dup" => self.dup = share(value, 1.0, "dup=0.01")?,
            "burst" => {
                let bits = value.parse().ok().filter(|bits| (1.0..=1e6).contains(bits));
                self.burst_bits = Some(bits.ok_or("give a number of bits from 1, like burst=50")?);
            }
            "delay" => {
                let delay_ms = time_ms(value);
                self.delay_ms = delay_ms.ok_or("give a time, like delay=0.5s or delay=80ms")?;
            }
            "half-duplex" if value.is_empty() => self.half_duplex = true,
            "half-duplex" => return Err("takes no value: use half-duplex".to_owned()),
            "squelch" => {
                self.squelch = match value {
                    "" => Squelch::Open,
                    "out" => Squelch::OpenInOutages,
                    _ => {
                        return Err(
                            "use squelch, or squelch=out for noise in outages too".to_owned()
                        );
                    }
                }
            }
            "modem" => {
                let known = Modem::ALL.into_iter().find(|modem| modem.name() == value);
                self.modem = Some(known.ok_or("use modem=hc-12 or modem=xbee")?);
            }
            "out" => {
                let times = value
                    .split_once("..")
                    .and_then(|(from, to)| Some(time_ms(from)?..time_ms(to)?))
                    .filter(|outage| !outage.is_empty());
                self.outages_ms
                    .push(times.ok_or("give a start and a later end, like out=10s..12s")?);
            }
            _ => {
                return Err(
                    "unknown option: use ber, burst, drop, dup, delay, half-duplex, squelch, modem, out"
                        .to_owned(),
                );
            }
        }
        Ok(())
    }
}

fn share(value: &str, most: f64, example: &str) -> Result<f64, String> {
    value
        .parse()
        .ok()
        .filter(|share| (0.0..=most).contains(share))
        .ok_or_else(|| format!("give a share from 0 to {most}, like {example}"))
}

/// Parses a time such as `0.5s` or `80ms`, at most a year; returns milliseconds.
fn time_ms(text: &str) -> Option<u64> {
    let (number, unit_ms) = match text.strip_suffix("ms") {
        Some(number) => (number, 1.0),
        None => (text.strip_suffix('s')?, 1000.0),
    };
    let time_ms: f64 = number.parse::<f64>().ok()? * unit_ms;
    (0.0..=3.2e10)
        .contains(&time_ms)
        .then(|| time_ms.round() as u64)
}

impl fmt::Display for ChannelSpec {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut options = Vec::new();
        if self.ber != 0.0 {
            options.push(format!("ber={:e}", self.ber));
        }
        if let Some(bits) = self.burst_bits {
            options.push(format!("burst={bits}"));
        }
        if self.drop != 0.0 {
            options.push(format!("drop={}", self.drop));
        }
        if self.dup != 0.0 {
            options.push(format!("dup={}", self.dup));
        }
        if self.delay_ms != 0 {
            options.push(format!("delay={}", Time(self.delay_ms)));
        }
        if self.half_duplex {
            options.push("half-duplex".to_owned());
        }
        match self.squelch {
            Squelch::Closed => {}
            Squelch::Open => options.push("squelch".to_owned()),
            Squelch::OpenInOutages => options.push("squelch=out".to_owned()),
        }
        if let Some(modem) = self.modem {
            options.push(format!("modem={}", modem.name()));
        }
        for outage in &self.outages_ms {
            options.push(format!("out={}..{}", Time(outage.start), Time(outage.end)));
        }
        formatter.write_str(&options.join(","))
    }
}

struct Time(u64);

impl fmt::Display for Time {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_multiple_of(100) {
            write!(formatter, "{}s", self.0 as f64 / 1000.0)
        } else {
            write!(formatter, "{}ms", self.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_option_is_read() {
        let text =
            "ber=1e-3,burst=50,drop=0.01,dup=0.02,delay=0.5s,half-duplex,squelch,out=10s..12s";
        let spec: ChannelSpec = text.parse().expect("it is well formed");
        let expected = ChannelSpec {
            ber: 1e-3,
            burst_bits: Some(50.0),
            drop: 0.01,
            dup: 0.02,
            delay_ms: 500,
            half_duplex: true,
            squelch: Squelch::Open,
            modem: None,
            outages_ms: std::iter::once(10_000..12_000).collect(),
        };
        assert_eq!(spec, expected);
        assert_eq!(spec.to_string(), text);
        assert_eq!("".parse(), Ok(ChannelSpec::default()));
    }

    #[test]
    fn errors_name_the_option_and_a_remedy() {
        for (text, names, hint) in [
            ("ber=2", "`ber=2`", "like ber=1e-3"),
            ("ber", "`ber`", "like ber=1e-3"),
            ("noise=1", "`noise=1`", "use ber"),
            ("delay=5", "`delay=5`", "delay=80ms"),
            ("ber=1e-3,burst=0", "`burst=0`", "burst=50"),
            ("burst=50", "`burst`", "ber=1e-3"),
            ("out=12s..10s", "`out=12s..10s`", "out=10s..12s"),
            ("half-duplex=yes", "`half-duplex=yes`", "no value"),
            ("squelch=yes", "`squelch=yes`", "squelch=out"),
            ("modem=sik", "`modem=sik`", "modem=hc-12"),
            ("modem=xbee,squelch", "`modem`", "remove half-duplex"),
            ("modem=hc-12,half-duplex", "`modem`", "remove half-duplex"),
            ("drop=NaN", "`drop=NaN`", "drop=0.01"),
        ] {
            let error = text.parse::<ChannelSpec>().unwrap_err().to_string();
            assert!(
                error.contains(names) && error.contains(hint),
                "{text}: {error}"
            );
        }
    }

    proptest! {
        #[test]
        fn text_form_parses_to_the_same_spec(
            ber in prop_oneof![Just(0.0), 1e-9..0.2],
            burst in prop::option::of(1.0..1e5),
            drop in 0.0..1.0,
            dup in 0.0..1.0,
            delay_ms in 0_u64..100_000,
            half_duplex: bool,
            squelch in prop::sample::select(vec![
                Squelch::Closed, Squelch::Open, Squelch::OpenInOutages,
            ]),
            modem in prop::option::of(prop::sample::select(Modem::ALL.to_vec())),
            outages in prop::collection::vec((0_u64..100_000, 1_u64..100_000), 0..3),
        ) {
            let spec = ChannelSpec {
                ber,
                burst_bits: burst.filter(|_| ber > 0.0),
                drop,
                dup,
                delay_ms,
                half_duplex: half_duplex && modem.is_none(),
                squelch: if modem.is_none() { squelch } else { Squelch::Closed },
                modem,
                outages_ms: outages.into_iter().map(|(from, long)| from..from + long).collect(),
            };
            prop_assert_eq!(spec.to_string().parse::<ChannelSpec>(), Ok(spec));
        }

        #[test]
        fn parsing_never_panics(text in ".{0,40}") {
            let _ = text.parse::<ChannelSpec>();
        }
    }
}
