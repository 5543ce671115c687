//! Names of recordings.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use jiff::Timestamp;

/// Default file name of a recording, `groundwave-20250314T092653Z.mcap`; sorts by time and is valid on every system.
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
    let since_1970 = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    let seconds = i64::try_from(since_1970.as_secs()).unwrap_or(i64::MAX);
    Timestamp::from_second(seconds)
        .unwrap_or(Timestamp::MAX)
        .strftime("%Y-%m-%dT%H:%M:%SZ")
        .to_string()
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
    fn another_name_is_not_a_part() {
        let name = |path: &str, number| another(Path::new(path), number);
        assert_eq!(name("a/run.mcap", 1), Path::new("a/run.mcap"));
        assert_eq!(name("a/run.mcap", 2), Path::new("a/run.2.mcap"));
        assert_eq!(name("v1.2/run", 3), Path::new("v1.2/run.3"));
    }
}
