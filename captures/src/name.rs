//! Names of recordings.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Default name, `groundwave-20250314T092653Z.mcap`: sorts by time and is valid on every system.
#[must_use]
pub fn automatic(start: SystemTime) -> String {
    format!("groundwave-{}.mcap", utc(start).replace(['-', ':'], ""))
}

/// Variant of a taken name: `run.mcap` becomes `run.2.mcap` for number 2.
#[must_use]
pub fn another(path: &Path, number: u32) -> PathBuf {
    if number == 1 {
        return path.to_owned();
    }
    let number = number.to_string();
    match path.extension() {
        Some(extension) => path.with_extension(number).with_added_extension(extension),
        None => path.with_added_extension(number),
    }
}

/// Time in UTC, `2025-03-14T09:26:53Z`; a time before 1970 counts as 1970.
#[must_use]
pub fn utc(time: SystemTime) -> String {
    let seconds = time
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default()
        .as_secs();
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    let (year, month, day) = civil(days);
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

/// Year, month and day of a number of days since 1970. Counts from 1 March of year 0, so that the leap day comes last.
const fn civil(days: u64) -> (u64, u64, u64) {
    const DAYS_TO_1970: u64 = 719_468;
    const DAYS_IN_400_YEARS: u64 = 146_097;
    let days = days + DAYS_TO_1970;
    let (era, day) = (days / DAYS_IN_400_YEARS, days % DAYS_IN_400_YEARS);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (year, month) = if month < 10 {
        (year, month + 3)
    } else {
        (year + 1, month - 9)
    };
    (year + era * 400, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn at(seconds: u64) -> SystemTime {
        UNIX_EPOCH + Duration::from_secs(seconds)
    }

    #[test]
    fn known_moments() {
        assert_eq!(utc(at(0)), "1970-01-01T00:00:00Z");
        assert_eq!(utc(at(951_827_696)), "2000-02-29T12:34:56Z");
        assert_eq!(utc(at(1_741_944_413)), "2025-03-14T09:26:53Z");
        assert_eq!(utc(at(4_102_444_799)), "2099-12-31T23:59:59Z");
        assert_eq!(
            utc(UNIX_EPOCH - Duration::from_secs(1)),
            "1970-01-01T00:00:00Z"
        );
        assert_eq!(
            automatic(at(1_741_944_413)),
            "groundwave-20250314T092653Z.mcap"
        );
    }

    #[test]
    fn another_name_is_no_part() {
        let name = |path: &str, number| another(Path::new(path), number);
        assert_eq!(name("a/run.mcap", 1), Path::new("a/run.mcap"));
        assert_eq!(name("a/run.mcap", 2), Path::new("a/run.2.mcap"));
        assert_eq!(name("v1.2/run", 3), Path::new("v1.2/run.3"));
    }

    #[test]
    fn every_day_of_five_centuries_follows_the_one_before() {
        let (mut year, mut month, mut day) = (1970, 1, 1);
        for days in 0..182_622 {
            assert_eq!(civil(days), (year, month, day));
            let leap = year % 4 == 0 && year % 100 != 0 || year % 400 == 0;
            let length = match month {
                2 => 28 + u64::from(leap),
                4 | 6 | 9 | 11 => 30,
                _ => 31,
            };
            day += 1;
            if day > length {
                (month, day) = (month + 1, 1);
            }
            if month > 12 {
                (year, month) = (year + 1, 1);
            }
        }
    }
}
