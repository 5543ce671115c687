//! Pauses between connections to a peer that closes them.

use std::time::Duration;

use rand_core::Rng as _;
use rand_pcg::Pcg32;

/// Pause after the first failed connection.
const FIRST: Duration = Duration::from_millis(50);

/// Maximum pause: a host is found within 2 s of its return.
const LONGEST: Duration = Duration::from_secs(2);

/// Minimum time for which a sound connection delivers bytes.
const SOUND: Duration = Duration::from_secs(1);

/// The pause before a link is opened again; it doubles until a connection is sound.
#[derive(Debug)]
pub(super) struct Backoff {
    /// Source of jitter: stations that lost the same peer do not all reconnect at once.
    rng: Pcg32,
    pause: Duration,
}

impl Backoff {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            rng: Pcg32::new(seed, 0),
            pause: FIRST,
        }
    }

    /// Takes the end of a connection and the time since its first byte, `None` without a byte; returns the pause
    /// before the next connection, up to a quarter shorter than the current step.
    pub(super) fn handle_end(&mut self, brought_for: Option<Duration>) -> Duration {
        if brought_for.is_some_and(|time| time >= SOUND) {
            self.pause = FIRST;
        }
        let pause = self.pause;
        self.pause = (2 * pause).min(LONGEST);
        let jitter = f64::from(self.rng.next_u32()) / f64::from(u32::MAX);
        pause.mul_f64(1.0 - jitter / 4.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEEDS: u64 = 100;

    #[test]
    fn pauses_double_up_to_the_longest() {
        for seed in 0..SEEDS {
            let mut backoff = Backoff::new(seed);
            for step_ms in [50, 100, 200, 400, 800, 1600, 2000, 2000] {
                let step = Duration::from_millis(step_ms);
                let pause = backoff.handle_end(None);
                assert!(
                    pause <= step && pause >= step * 3 / 4,
                    "seed {seed}: {pause:?} in the step of {step:?}"
                );
            }
        }
    }

    #[test]
    fn an_hour_has_few_connections_whatever_they_bring() {
        for seed in 0..SEEDS {
            for brought_for in [None, Some(Duration::ZERO), Some(Duration::from_millis(999))] {
                let mut backoff = Backoff::new(seed);
                let (mut now, mut count) = (Duration::ZERO, 0);
                while now < Duration::from_hours(1) {
                    now += brought_for.unwrap_or_default() + backoff.handle_end(brought_for);
                    count += 1;
                }
                assert!(count < 2500, "seed {seed}, {brought_for:?}: {count}");
            }
        }
    }

    #[test]
    fn a_good_connection_resets_the_pauses() {
        let mut backoff = Backoff::new(1);
        for _ in 0..9 {
            backoff.handle_end(None);
        }
        assert!(backoff.handle_end(None) > Duration::from_secs(1));
        assert!(backoff.handle_end(Some(SOUND)) <= FIRST);
    }

    #[test]
    fn stations_do_not_return_at_once() {
        let first = |seed| Backoff::new(seed).handle_end(None);
        let mut pauses: Vec<Duration> = (0..SEEDS).map(first).collect();
        pauses.sort_unstable();
        pauses.dedup();
        assert!(pauses.len() as u64 > SEEDS / 2, "{}", pauses.len());
    }
}
