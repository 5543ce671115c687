//! Time of each line by the robot's clock.

use groundwave_protocol::decoder::Received;
use groundwave_protocol::telemetry::{ACK_LINE_BYTES, Body, SEQUENCE_MODULUS};
use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};

const S_NS: u64 = 1_000_000_000;

/// Transmission time of a number of bytes, nanoseconds.
const fn wire_ns(bytes: usize) -> u64 {
    bytes as u64 * S_NS / BYTES_PER_S as u64
}

/// Maximum pause in which the sequence cannot wrap around, nanoseconds.
const SEQUENCE_ROUND_NS: u64 = (SEQUENCE_MODULUS as u64 - 1) * wire_ns(LINE_BYTES);

/// Maximum difference between two clocks of the same boot, nanoseconds. A larger one means another boot, or seconds that wrapped around.
const SAME_CLOCK_NS: u64 = 60 * S_NS;

/// Timestamps lines by the uptime in line C and, in between, by the sequence. Lines are evenly spaced, even if the link delivers
/// several at once. The first line C after a boot sets the zero of the robot's clock.
#[derive(Debug, Default)]
pub(super) struct RobotClock(Option<State>);

#[derive(Clone, Copy, Debug)]
struct State {
    /// Host time at the zero of the robot's clock.
    zero_ns: u64,
    boots: u16,
    uptime_ns: u64,
    sequence: u8,
    host_ns: u64,
}

impl RobotClock {
    /// Robot time of a line, nanoseconds since 1970; `None` before the first line C. `host_ns` is the time of reception.
    pub(super) fn handle_line(&mut self, host_ns: u64, received: &Received) -> Option<u64> {
        let carried = self.0.map(|state| state.carry_on(host_ns, received));
        self.0 = match received {
            Received::Line(line, _) => match &line.body {
                Body::Counters(counters) => {
                    let said_ns = u64::from(counters.uptime_s) * S_NS;
                    let same_clock = carried.filter(|state| {
                        state.boots == counters.boots
                            && state.uptime_ns.abs_diff(said_ns) < SAME_CLOCK_NS
                    });
                    Some(match same_clock {
                        // Line C has whole seconds; the lines between two lines C give the fraction.
                        Some(state) => State {
                            uptime_ns: state.uptime_ns.clamp(said_ns, said_ns + S_NS - 1),
                            ..state
                        },
                        None => State {
                            zero_ns: host_ns.saturating_sub(said_ns),
                            boots: counters.boots,
                            uptime_ns: said_ns,
                            sequence: line.sequence,
                            host_ns,
                        },
                    })
                }
                _ => carried,
            },
            Received::Ack(_) => carried,
        };
        // Times of a damaged capture may be any.
        self.0
            .map(|state| state.zero_ns.saturating_add(state.uptime_ns))
    }
}

impl State {
    fn carry_on(self, host_ns: u64, received: &Received) -> Self {
        let sequence = received.sequence();
        let bytes = match received {
            Received::Line(..) => LINE_BYTES,
            Received::Ack(_) => ACK_LINE_BYTES,
        };
        let step = (sequence + SEQUENCE_MODULUS - self.sequence) % SEQUENCE_MODULUS;
        let pause_ns = host_ns.saturating_sub(self.host_ns);
        let passed_ns = match step {
            _ if pause_ns >= SEQUENCE_ROUND_NS => pause_ns,
            0 => 0,
            _ => u64::from(step - 1) * wire_ns(LINE_BYTES) + wire_ns(bytes),
        };
        Self {
            uptime_ns: self.uptime_ns.saturating_add(passed_ns),
            sequence,
            host_ns,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::telemetry::{Ack, AckLine, CountersLine, Line, TextLine};

    const START_NS: u64 = 1_741_944_413 * S_NS;

    fn line(sequence: u8, body: Body) -> Received {
        let line = Line {
            sequence,
            body,
            ack: Ack::default(),
        };
        Received::Line(line, line.encode())
    }

    fn text(sequence: u8) -> Received {
        line(sequence, Body::Text(TextLine::new("")))
    }

    fn counters(sequence: u8, boots: u16, uptime_s: u32) -> Received {
        line(
            sequence,
            Body::Counters(CountersLine {
                robot_id: 7,
                uptime_s,
                boots,
                ..CountersLine::default()
            }),
        )
    }

    #[test]
    fn lines_are_evenly_spaced_whenever_they_arrive() {
        let mut clock = RobotClock::default();
        assert_eq!(clock.handle_line(START_NS, &text(98)), None);
        assert_eq!(
            clock.handle_line(START_NS, &counters(99, 4, 100)),
            Some(START_NS)
        );
        let clump_ns = START_NS + 3 * S_NS;
        assert_eq!(
            clock.handle_line(clump_ns, &text(0)),
            Some(START_NS + S_NS / 3)
        );
        let k = Received::Ack(AckLine {
            sequence: 1,
            ack: Ack::default(),
            listens: false,
        });
        let k_ns = START_NS + S_NS / 3 + 14 * S_NS / 240;
        assert_eq!(clock.handle_line(clump_ns, &k), Some(k_ns));
        // Three lines were lost on the way to number 5.
        let after_ns = k_ns + 3 * (S_NS / 3) + S_NS / 3;
        assert_eq!(clock.handle_line(clump_ns, &text(5)), Some(after_ns));
        // Line C agrees to the second and the fraction stays.
        let c_ns = after_ns + S_NS / 3;
        assert_eq!(
            clock.handle_line(clump_ns, &counters(6, 4, 102)),
            Some(c_ns)
        );
        // The robot's clock is ahead of the lines.
        assert_eq!(
            clock.handle_line(clump_ns, &counters(7, 4, 110)),
            Some(START_NS + 10 * S_NS)
        );
    }

    #[test]
    fn a_boot_resets_the_zero_and_a_long_silence_does_not() {
        let mut clock = RobotClock::default();
        clock.handle_line(START_NS, &counters(0, 4, 100));
        let late_ns = START_NS + 600 * S_NS;
        assert_eq!(clock.handle_line(late_ns, &text(1)), Some(late_ns));
        let later_ns = late_ns + S_NS / 3;
        assert_eq!(
            clock.handle_line(later_ns, &counters(2, 4, 701)),
            Some(START_NS + 601 * S_NS)
        );
        assert_eq!(
            clock.handle_line(later_ns + 5, &counters(3, 5, 0)),
            Some(later_ns + 5)
        );
    }
}
