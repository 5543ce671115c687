//! The time at the beginning of a line of text, as `ts`, loggers and other stations write it.

use crate::event::Moment;

const DAY: Moment = Moment::from_hours(24);

/// Bytes of a line in which its stamp must end.
pub(super) const STAMP_BYTES_MAX: usize = 48;

/// How the lines of a capture are stamped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Seconds since 1970, or a date with its year.
    Unix,
    /// Month, day and time.
    Year,
    /// Time of day, or since the beginning.
    Day,
    /// Seconds since the beginning.
    Seconds,
}

impl Kind {
    /// After so long the stamps begin anew.
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
    /// What the last digit stands for.
    resolution: Moment,
}

/// The stamps of a capture that has them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamps {
    kind: Kind,
    base: Moment,
}

impl Stamps {
    /// How the lines are stamped, if most of these are. Time of day alone says nothing of a capture longer
    /// than a day.
    pub(super) fn of(head: &[u8], is_longer_than_a_day: bool) -> Option<Self> {
        let lines: Vec<&[u8]> = head
            .split_inclusive(|&byte| byte == b'\n')
            .filter(|line| line.len() > 2)
            .collect();
        let first = lines.iter().find_map(|line| parse(line))?;
        let is_like_first = |line: &&&[u8]| parse(line).is_some_and(|s| s.kind == first.kind);
        let stamped = lines.iter().filter(is_like_first).count();
        let is_told_apart = first.kind != Kind::Day || !is_longer_than_a_day;
        (is_told_apart && stamped * 3 >= lines.len() * 2).then_some(Self {
            kind: first.kind,
            base: first.at,
        })
    }

    /// The time at the beginning of a line, since the capture began, and how exact it is.
    pub(super) fn read(&self, line: &[u8]) -> Option<(Moment, Moment)> {
        let stamp = parse(line).filter(|stamp| stamp.kind == self.kind)?;
        let at = match (stamp.at.checked_sub(self.base), self.kind.round()) {
            (Some(at), _) => at,
            (None, Some(round)) => (stamp.at + round).saturating_sub(self.base),
            (None, None) => Moment::ZERO,
        };
        Some((at, stamp.resolution))
    }

    /// Time of day at the beginning of the capture, since 1970.
    pub(super) fn unix(&self) -> Option<Moment> {
        (self.kind == Kind::Unix).then_some(self.base)
    }
}

fn parse(line: &[u8]) -> Option<Stamp> {
    let head = &line[..line.len().min(STAMP_BYTES_MAX)];
    let ascii = head.iter().take_while(|b| matches!(b, b' '..=b'~' | b'\t'));
    let head = std::str::from_utf8(&head[..ascii.count()]).ok()?;
    let head = head.trim_start();
    let head = head.strip_prefix(['[', '(']).unwrap_or(head).trim_start();
    let mut words = head.split([' ', '\t', ']', ')', ';']);
    let end = [':', ','];
    let first = words.next()?.trim_end_matches(end);
    if let Some(stamp) = number(first).or_else(|| date_and_time(first)) {
        return Some(stamp);
    }
    if let Some((at, resolution)) = time(first) {
        return Some(Stamp {
            kind: Kind::Day,
            at,
            resolution,
        });
    }
    let mut rest = words.filter(|word| !word.is_empty());
    let second = rest.next()?;
    if let Some(days) = date(first) {
        let (at, resolution) = clock(second.trim_end_matches(end))?;
        return unix(days, at, resolution);
    }
    let month = MONTHS.iter().position(|month| *month == first)?;
    let day = digits(second)?;
    let (at, resolution) = time(rest.next()?.trim_end_matches(end))?;
    let is_day = (1..=31).contains(&day);
    is_day.then(|| Stamp {
        kind: Kind::Year,
        at: DAY * (DAYS_BEFORE[month] + day as u32) + at,
        resolution,
    })
}

const MONTHS: [&str; 12] = [
    "Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec",
];

/// Days of a leap year before each month.
const DAYS_BEFORE: [u32; 12] = [0, 31, 60, 91, 121, 152, 182, 213, 244, 274, 305, 335];

/// Digits of a number of seconds since 1970; fewer are since the beginning.
const UNIX_DIGITS: usize = 9;

fn number(word: &str) -> Option<Stamp> {
    let whole = word.split('.').next()?.len();
    // A bare whole number may be anything; with so many digits it is a time.
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
    })
}

/// Digits, and up to nine more after a dot or a comma.
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

/// `2026-11-21T20:46:48.123Z`, or with a zone like `+01:00`; without one it counts as Greenwich.
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
    })
}

/// Nanoseconds from midnight at Greenwich, and what the last digit stands for.
fn clock(word: &str) -> Option<(i64, Moment)> {
    let zone_at = word.find(['Z', '+', '-']).unwrap_or(word.len());
    let (local, zone) = word.split_at(zone_at);
    let (at, resolution) = time(local)?;
    let east_min = match zone.split_at_checked(1) {
        None | Some(("Z", _)) => 0,
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

/// `20:46:48`, with a fraction or without.
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

/// Days since 1970 of `2026-11-21`, by counting from 1 March of year 0 so that the leap day comes last.
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

    fn read(first: &str, second: &str) -> Option<(u64, u64)> {
        let head = format!("{first} A00 line\r\n{second} A01 line\r\n");
        let stamps = Stamps::of(head.as_bytes(), false)?;
        let lines: Vec<&str> = head.split_inclusive('\n').collect();
        let at = |line: &str| {
            stamps
                .read(line.as_bytes())
                .map(|(at, _)| at.as_millis() as u64)
        };
        Some((at(lines[0])?, at(lines[1])?))
    }

    #[test]
    fn the_stamps_of_others_are_read() {
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
            ("2026-11-21T20:46:48.123Z", "2026-11-21T20:46:49.000Z", 877),
            (
                "2026-11-21T20:46:48+0000",
                "2026-11-21T21:46:49+01:00",
                1000,
            ),
            ("2026-11-21 20:46:48,5", "2026-11-22 00:00:00,0", 11_591_500),
            ("[2026-02-28 23:59:59]", "[2026-03-01 00:00:00]", 1000),
        ] {
            assert_eq!(read(first, second), Some((0, passed_ms)), "{first}");
        }
    }

    #[test]
    fn a_date_with_its_year_tells_the_time_of_day() {
        let stamps = Stamps::of(b"2026-11-21T20:46:48Z A00\r\n", false).unwrap();
        assert_eq!(stamps.unix(), Some(Moment::from_secs(1_795_294_008)));
    }

    #[test]
    fn what_is_no_stamp_is_none() {
        for head in [
            "A00 line",
            "12 line",
            "99:99:99 line",
            "12:30 line",
            "Nov x 20:46:48 line",
            "2026-13-01T00:00:00Z line",
            "",
            "\u{fc}",
        ] {
            assert!(Stamps::of(head.as_bytes(), false).is_none(), "{head}");
        }
        assert!(Stamps::of(b"20:46:48 A00 line\n", true).is_none(), "days");
    }
}
