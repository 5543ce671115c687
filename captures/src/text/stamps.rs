//! Timestamps before lines, as written by `ts`, loggers and other stations.

use crate::event::Moment;

const DAY: Moment = Moment::from_hours(24);

/// Maximum step by which a clock is set back; a larger backward step means a new day.
const BACK_MAX: Moment = Moment::from_hours(1);

/// Maximum length of a timestamp, bytes.
pub(super) const STAMP_BYTES_MAX: usize = 48;

/// Kind of timestamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Time since 1970 in seconds, or a date with its year.
    Unix,
    /// Month, day and time of day.
    Year,
    /// Time of day, or since the beginning.
    Day,
    /// Time since the beginning, seconds.
    Seconds,
}

impl Kind {
    /// Period after which timestamps wrap around; `None` if they do not.
    const fn round(self) -> Option<Moment> {
        match self {
            Self::Unix | Self::Seconds => None,
            Self::Year => Some(Moment::from_hours(24 * 366)),
            Self::Day => Some(DAY),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Stamp {
    kind: Kind,
    at: Moment,
    /// Unit of the last digit.
    resolution: Moment,
    /// Length of the timestamp in the line, bytes.
    length: usize,
}

/// The timestamps of a raw text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamps {
    kind: Kind,
    base: Moment,
}

/// Timestamp of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamped {
    /// Time since the capture began.
    pub(super) at: Moment,
    /// Unit of its last digit.
    pub(super) resolution: Moment,
    /// Length of the timestamp in the line, bytes.
    pub(super) length: usize,
}

impl Stamps {
    /// Timestamps of the same kind as a first line's; times count from that line.
    pub(super) fn like(first: &[u8]) -> Option<Self> {
        let Stamp { kind, at, .. } = parse(first)?;
        Some(Self { kind, base: at })
    }

    /// The timestamp before a line of a robot's own. A number is one only in brackets, with an arrow, or before a name or the first character of a form: the first column of numbers is none.
    pub(super) fn before_own_line(stamped: &[u8]) -> Option<Self> {
        let stamp = parse(stamped)?;
        let (before, line) = stamped.split_at_checked(stamp.length)?;
        let is_marked = before.iter().any(|byte| b"[(>".contains(byte));
        let is_name = |next: &u8| next.is_ascii_alphabetic() || b"{>$".contains(next);
        let is_sure = stamp.kind != Kind::Seconds || is_marked || line.first().is_some_and(is_name);
        is_sure.then_some(Self {
            kind: stamp.kind,
            base: stamp.at,
        })
    }

    /// Timestamp of a line; the previous line has time `last`. A clock without a date has wrapped around if it runs back.
    pub(super) fn read(&self, line: &[u8], last: Moment) -> Option<Stamped> {
        let stamp = parse(line).filter(|stamp| stamp.kind == self.kind)?;
        let at = match self.kind.round() {
            None => stamp.at.saturating_sub(self.base),
            Some(round) => {
                let phase = match stamp.at.checked_sub(self.base) {
                    Some(phase) => phase,
                    None => (stamp.at + round).saturating_sub(self.base),
                };
                if phase + BACK_MAX >= round + last {
                    // A moment before the first line.
                    Moment::ZERO
                } else {
                    let behind = last.saturating_sub(phase + BACK_MAX);
                    phase + round * behind.as_nanos().div_ceil(round.as_nanos()) as u32
                }
            }
        };
        Some(Stamped {
            at,
            resolution: stamp.resolution,
            length: stamp.length,
        })
    }

    /// Whether both are of the same kind.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.kind == other.kind
    }

    /// Whether a later line may have this timestamp; only a clock without a date runs back.
    pub(super) fn is_after(&self, first: &Self) -> bool {
        self.is_like(first) && (self.go_round() || self.base >= first.base)
    }

    /// Whether the timestamps wrap around.
    pub(super) const fn go_round(&self) -> bool {
        self.kind.round().is_some()
    }

    /// Start of the capture, as time since 1970, if timestamps have a date.
    pub(super) fn unix(&self) -> Option<Moment> {
        matches!(self.kind, Kind::Unix).then_some(self.base)
    }
}

/// Iterates over the words of a text, and counts the bytes taken.
struct Words<'a> {
    text: &'a str,
    taken: usize,
}

impl<'a> Words<'a> {
    /// The next word, after separators.
    fn next(&mut self) -> Option<&'a str> {
        const BETWEEN: [char; 5] = [' ', '\t', ']', ')', ';'];
        let rest = &self.text[self.taken..];
        let rest = rest.trim_start_matches(BETWEEN);
        let begin = self.text.len() - rest.len();
        let end = rest.find(BETWEEN).unwrap_or(rest.len());
        let length = end_of_first_column(&rest[..end]);
        self.taken = begin + length;
        (length > 0).then(|| rest[..length].trim_end_matches([':', ',']))
    }

    /// Number of bytes taken, including closing brackets, one space or tab, and the arrow of the Arduino IDE or `PlatformIO`.
    fn length(&self) -> usize {
        let rest = &self.text[self.taken..];
        let line = rest.trim_start_matches([']', ')', ';']);
        let line = line.strip_prefix(',').unwrap_or(line);
        let line = line.strip_prefix([' ', '\t']).unwrap_or(line);
        let arrow = ["-> ", "> "].iter().find_map(|it| line.strip_prefix(it));
        let line = arrow.unwrap_or(line);
        self.text.len() - line.len()
    }
}

/// Length of a word up to a comma that separates columns. A comma after whole seconds may also begin their decimals.
fn end_of_first_column(word: &str) -> usize {
    let Some((first, rest)) = word.split_once(',') else {
        return word.len();
    };
    let (_, of_day) = first.rsplit_once('T').unwrap_or(("", first));
    let is_whole = time(of_day).is_some() && !of_day.contains('.');
    let decimals = rest.trim_end_matches([':', ',']);
    let decimals = decimals.split(['Z', '+', '-']).next().unwrap_or_default();
    if is_whole && digits(decimals).is_some() {
        word.len()
    } else {
        first.len()
    }
}

fn parse(line: &[u8]) -> Option<Stamp> {
    let head = &line[..line.len().min(STAMP_BYTES_MAX)];
    let ascii = head.iter().take_while(|b| matches!(b, b' '..=b'~' | b'\t'));
    let head = std::str::from_utf8(&head[..ascii.count()]).ok()?;
    let text = head.trim_start();
    let text = text.strip_prefix(['[', '(']).unwrap_or(text).trim_start();
    let before = head.len() - text.len();
    let mut words = Words { text, taken: 0 };
    let stamp = read(&mut words)?;
    Some(Stamp {
        length: before + words.length(),
        ..stamp
    })
}

/// A timestamp without its length.
fn read(words: &mut Words<'_>) -> Option<Stamp> {
    let first = words.next()?;
    if let Some(stamp) = number(first).or_else(|| date_and_time(first)) {
        return Some(stamp);
    }
    if let Some((at, resolution)) = time(first) {
        return Some(Stamp {
            kind: Kind::Day,
            at,
            resolution,
            length: 0,
        });
    }
    let second = words.next()?;
    if let Some(days) = date(first) {
        let (at, resolution) = clock(second)?;
        return unix(days, at, resolution);
    }
    let month = MONTHS.iter().position(|month| *month == first)?;
    let day = digits(second)?;
    let (at, resolution) = time(words.next()?)?;
    let is_day = (1..=31).contains(&day);
    is_day.then(|| Stamp {
        kind: Kind::Year,
        at: DAY * (DAYS_BEFORE[month] + day as u32) + at,
        resolution,
        length: 0,
    })
}

const MONTHS: [&str; 12] = [
    "Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec",
];

/// Days of a leap year before each month.
const DAYS_BEFORE: [u32; 12] = [0, 31, 60, 91, 121, 152, 182, 213, 244, 274, 305, 335];

/// Minimum number of digits of a number of seconds since 1970; shorter numbers count from the beginning of the capture.
const UNIX_DIGITS: usize = 9;

fn number(word: &str) -> Option<Stamp> {
    let whole = word.split('.').next()?.len();
    // A whole number without decimals is a time only with this many digits.
    let kind = match whole {
        UNIX_DIGITS..=11 => Kind::Unix,
        1..UNIX_DIGITS if word.contains('.') => Kind::Seconds,
        _ => return None,
    };
    let (at, resolution) = seconds(word)?;
    Some(Stamp {
        kind,
        at,
        resolution,
        length: 0,
    })
}

/// Parses seconds with up to nine decimals; returns the time and the unit of the last digit.
fn seconds(word: &str) -> Option<(Moment, Moment)> {
    let (whole, part) = word.split_once('.').unwrap_or((word, ""));
    let whole = Moment::from_secs(digits(whole)?);
    if part.is_empty() {
        return Some((whole, Moment::from_secs(1)));
    }
    let part = &part[..part.len().min(9)];
    let unit_ns = 10_u64.pow(9 - part.len() as u32);
    let part = Moment::from_nanos(digits(part)? * unit_ns);
    Some((whole + part, Moment::from_nanos(unit_ns)))
}

/// Parses `2026-11-21T20:46:48.123Z`, also with a zone such as `+01:00`. A time without a zone counts as UTC.
fn date_and_time(word: &str) -> Option<Stamp> {
    let (day, rest) = word.split_once('T')?;
    let (at, resolution) = clock(rest)?;
    unix(date(day)?, at, resolution)
}

fn unix(days: i64, at: i64, resolution: Moment) -> Option<Stamp> {
    let at_ns = days.checked_mul(86_400_000_000_000)?.checked_add(at)?;
    Some(Stamp {
        kind: Kind::Unix,
        at: Moment::from_nanos(u64::try_from(at_ns).ok()?),
        resolution,
        length: 0,
    })
}

/// Parses a time of day; returns nanoseconds since midnight in UTC, and the unit of the last digit.
fn clock(word: &str) -> Option<(i64, Moment)> {
    let zone_at = word.find(['Z', '+', '-']).unwrap_or(word.len());
    let (local, zone) = word.split_at(zone_at);
    let (at, resolution) = time(local)?;
    let east_min = match zone.split_at_checked(1) {
        None | Some(("Z", "")) => 0,
        Some((sign, offset)) => {
            let offset = offset.replace(':', "");
            let (hours, minutes) = offset.split_at_checked(2)?;
            let minutes = if minutes.is_empty() {
                0
            } else {
                digits(minutes)?
            };
            let east = (digits(hours)? * 60 + minutes) as i64;
            if sign == "-" { -east } else { east }
        }
    };
    Some((at.as_nanos() as i64 - east_min * 60_000_000_000, resolution))
}

/// Parses `20:46:48`, with or without a fraction; returns the time and the unit of the last digit.
fn time(word: &str) -> Option<(Moment, Moment)> {
    let mut parts = word.splitn(3, ':');
    let (hours, minutes) = (digits(parts.next()?)?, digits(parts.next()?)?);
    let (part, resolution) = seconds(&parts.next()?.replace(',', "."))?;
    let is_time = minutes < 60 && part < Moment::from_secs(61);
    is_time.then(|| {
        let at = Moment::from_secs(hours * 3600 + minutes * 60) + part;
        (at, resolution)
    })
}

/// Parses `2026-11-21`; returns days since 1970. Counts from 1 March of year 0, where the leap day is the last day of a year.
fn date(word: &str) -> Option<i64> {
    let mut parts = word.splitn(3, '-');
    let (year, month, day) = (
        digits(parts.next().filter(|year| year.len() == 4)?)? as i64,
        digits(parts.next()?)? as i64,
        digits(parts.next()?)? as i64,
    );
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let leaps = year / 4 - year / 100 + year / 400;
    Some(365 * year + leaps + (153 * month + 2) / 5 + day - 1 - 719_468)
}

fn digits(text: &str) -> Option<u64> {
    let is_number = (1..=11).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    is_number.then(|| text.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time between the timestamps of two lines, milliseconds, and the second line without its timestamp.
    fn read(first: &str, second: &str) -> Option<(u64, String)> {
        let line = format!("{second} A01 line\r\n");
        let stamps = Stamps::like(format!("{first} A00 line\r\n").as_bytes())?;
        let stamped = stamps.read(line.as_bytes(), Moment::ZERO)?;
        Some((
            stamped.at.as_millis() as u64,
            line[stamped.length..].to_owned(),
        ))
    }

    #[test]
    fn timestamps_of_other_programs_are_read() {
        for (first, second, passed_ms) in [
            ("Nov 21 20:46:48", "Nov 21 20:46:49", 1000),
            ("Dec 31 23:59:59", "Jan 01 00:00:01", 2000),
            ("Nov  1 20:46:48.25", "Nov  1 20:46:48.50", 250),
            ("20:46:48", "20:47:00", 12_000),
            ("23:59:59.9", "00:00:00.2", 300),
            ("00:00:00", "00:00:07", 7000),
            ("1763758008", "1763758010", 2000),
            ("1763758008.125000", "1763758008.500000", 375),
            ("[ 12.500]", "[ 13.000]", 500),
            ("(12.500):", "(13.000):", 500),
            ("2026-11-21T20:46:48.123Z", "2026-11-21T20:46:49.000Z", 877),
            (
                "2026-11-21T20:46:48+0000",
                "2026-11-21T21:46:49+01:00",
                1000,
            ),
            ("2026-11-21 20:46:48,5", "2026-11-22 00:00:00,0", 11_591_500),
            ("[2026-02-28 23:59:59]", "[2026-03-01 00:00:00]", 1000),
        ] {
            let line = if first.starts_with('(') {
                ": A01 line\r\n"
            } else {
                "A01 line\r\n"
            };
            assert_eq!(
                read(first, second),
                Some((passed_ms, line.to_owned())),
                "{first}"
            );
        }
    }

    #[test]
    fn a_clock_without_a_date_wraps_around_each_day() {
        let stamps = Stamps::like(b"23:00:00 A00\r\n").unwrap();
        let mut last = Moment::ZERO;
        for hour in 1..100_u64 {
            let line = format!("{:02}:00:00 A00\r\n", (23 + hour) % 24);
            last = stamps.read(line.as_bytes(), last).unwrap().at;
            assert_eq!(last, Moment::from_hours(hour));
        }
        // A clock set back by a second at the beginning is not a new day.
        let back = stamps
            .read(b"22:59:59 A00\r\n", Moment::from_millis(333))
            .unwrap();
        assert_eq!(back.at, Moment::ZERO);
    }

    #[test]
    fn a_date_with_a_year_gives_the_time_since_1970() {
        let stamps = Stamps::like(b"2026-11-21T20:46:48Z A00\r\n").unwrap();
        assert_eq!(stamps.unix(), Some(Moment::from_secs(1_795_294_008)));
    }

    #[test]
    fn text_without_timestamps_has_none() {
        for head in [
            "A00 line",
            "12 line",
            "99:99:99 line",
            "12:30 line",
            "Nov x 20:46:48 line",
            "2026-13-01T00:00:00Z line",
            "",
            "]",
            "[",
            "\u{fc}",
        ] {
            assert!(Stamps::like(head.as_bytes()).is_none(), "{head}");
        }
    }
}
