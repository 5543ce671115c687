//! Statistics of the times, and their output.

use std::fmt;

use sr04_sim::ChannelSpec;

/// Times of all seeds.
pub struct Times {
    /// The times in seconds, shortest first.
    sorted_s: Vec<f64>,
    /// Number of seeds that ended without confirmation.
    failed: usize,
}

impl Times {
    /// The times of all seeds; `None` means without confirmation.
    pub fn of(results: Vec<(u64, Option<f64>)>) -> Self {
        let all = results.len();
        let mut sorted_s: Vec<f64> = results.into_iter().filter_map(|(_, time)| time).collect();
        sorted_s.sort_by(f64::total_cmp);
        Self {
            failed: all - sorted_s.len(),
            sorted_s,
        }
    }

    fn mean_s(&self) -> f64 {
        self.sorted_s.iter().sum::<f64>() / self.sorted_s.len() as f64
    }

    /// The time within which this share of the seeds was confirmed, seconds.
    fn within_s(&self, share: f64) -> f64 {
        let rank = (self.sorted_s.len() as f64 * share).ceil() as usize;
        let time = self.sorted_s.get(rank.saturating_sub(1));
        time.copied().unwrap_or(f64::NAN)
    }

    fn failures(&self) -> String {
        match self.failed {
            0 => String::new(),
            failed => format!(", {failed} without confirmation"),
        }
    }

    /// A row with a column for each figure.
    pub fn columns(&self, name: &str, channel: &str) -> [String; 5] {
        let ber = channel.trim_start_matches("ber=");
        [
            name.to_owned(),
            if ber.is_empty() { "0" } else { ber }.to_owned(),
            format!("{:.2}", self.mean_s()),
            format!("{:.2}", self.within_s(0.95)),
            format!("{:.2}{}", self.within_s(1.0), self.failures()),
        ]
    }
}

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.sorted_s.is_empty() {
            return f.write_str("never");
        }
        let digits = usize::from(self.mean_s() < 20.0);
        write!(
            f,
            "{:.digits$} ({:.digits$}{})",
            self.mean_s(),
            self.within_s(0.95),
            self.failures()
        )
    }
}

pub fn header(columns: &[&str]) {
    println!("| {} |", columns.join(" | "));
    println!("|{}", "---|".repeat(columns.len()));
}

pub fn row(cells: impl IntoIterator<Item = String>) {
    let cells: Vec<String> = cells.into_iter().collect();
    println!("| {} |", cells.join(" | "));
}

/// Number of data bits per second: eight of the ten bits of a byte.
const DATA_BITS_PER_S: f64 = 1920.0;

/// Information of a waypoint: two whole numbers from -9999 to 9999, bits.
fn bits_per_waypoint() -> f64 {
    2.0 * 19_999_f64.log2()
}

/// Lower bound of the time for `count` arbitrary waypoints, seconds: their information over the capacity of the
/// channel, without framing and acknowledgement. For bursts it assumes that both ends know when one lasts, and that
/// nothing passes then.
pub fn bound_s(channel: &str, count: usize) -> f64 {
    let spec: ChannelSpec = channel.parse().expect("the bench's own words");
    let capacity = match spec.burst_bits {
        Some(_) => 1.0 - 2.0 * spec.ber,
        None => 1.0 - entropy(spec.ber),
    };
    bits_per_waypoint() * count as f64 / (DATA_BITS_PER_S * capacity)
}

/// Entropy of a bit that is one with probability `p`, bits.
fn entropy(p: f64) -> f64 {
    if p == 0.0 {
        return 0.0;
    }
    -p * p.log2() - (1.0 - p) * (1.0 - p).log2()
}
