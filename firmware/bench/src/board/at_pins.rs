//! What is at the board's pins, compared with what the board's program gave the robot's program and got from it.

use std::collections::VecDeque;

use sr04_firmware::board::{Echo, Inputs, Outputs, Side};
use sr04_replay::{Port, read_inputs, read_outputs};
use sr04_sim::TICK_MS;

/// Time by which a tick may begin later than 50 ms after the one before: a byte or a look comes first.
const LATE_MS: u64 = 2;

/// Pulses of a servo.
const SERVO_LEAST_US: u16 = 500;
const SERVO_UP_US: u16 = 1500;
const SERVO_MOST_US: u16 = 2500;

/// Counts by which a reading may lag behind the edges, and counts to which the wheel's size may add one.
const COUNTS_LAG: i64 = 3;
const COUNTS_ROUNDING: i64 = 500;

/// The world at the pins in a millisecond, and what the chip makes of its own.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AtPins {
    pub(crate) now_ms: u64,
    /// What the sensors show, the latest first: some readings of the chip are older than the latest.
    pub(crate) sensors: [Inputs; 2],
    /// Edges of both encoders since the start.
    pub(crate) edges: [u64; 2],
    /// The latest pings, the newest first: when, and the echo that follows.
    pub(crate) pings: [Option<(u64, Echo)>; 2],
    /// Whether the chip was reset in this millisecond: the outputs are those after the reset.
    pub(crate) is_reset: bool,
    pub(crate) widths: [i16; 2],
    pub(crate) tone_hz: u16,
    pub(crate) servo_us: u16,
}

/// Follows the ticks of a boot.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    ticked_ms: Option<u64>,
    /// Counts that the program was given, and the edges at its first tick.
    counts: [u64; 2],
    first_edges: Option<[u64; 2]>,
}

impl Watch {
    /// Whether a tick begins too late after the one before.
    pub(crate) fn is_late(&mut self, now_ms: u64) -> bool {
        let ticked_ms = self.ticked_ms.replace(now_ms);
        ticked_ms.is_some_and(|ticked_ms| now_ms - ticked_ms > TICK_MS + LATE_MS)
    }

    /// Compares a tick's bytes with the pins when it began and ended.
    ///
    /// # Errors
    /// The first difference.
    pub(crate) fn compare(
        &mut self,
        begins: &AtPins,
        call: &[u8],
        ends: &AtPins,
        results: &[u8],
    ) -> Result<(), String> {
        let mut bytes: Bytes = call.iter().skip(1).copied().collect();
        let inputs = read_inputs(&mut bytes);
        // A board without sensors reads none of the pins.
        if inputs.cliff.is_some() {
            compare_inputs(&inputs, begins)?;
        }
        self.count(&inputs, begins)?;
        compare_outputs(
            &read_outputs(&mut results.iter().copied().collect::<Bytes>()),
            ends,
        )
    }

    fn count(&mut self, inputs: &Inputs, at_pins: &AtPins) -> Result<(), String> {
        let Some(first) = self.first_edges else {
            self.first_edges = Some(at_pins.edges);
            return Ok(());
        };
        let given = [inputs.counts_left, inputs.counts_right];
        for (side, given) in given.into_iter().enumerate() {
            self.counts[side] += u64::from(given);
            let (counts, edges) = (
                self.counts[side] as i64,
                (at_pins.edges[side] - first[side]) as i64,
            );
            if (counts - edges).abs() > COUNTS_LAG + edges / COUNTS_ROUNDING {
                return Err(format!("encoder {side}: {counts} counts of {edges} edges"));
            }
        }
        Ok(())
    }
}

fn compare_inputs(inputs: &Inputs, at_pins: &AtPins) -> Result<(), String> {
    let is_close = |reading: u8, of: fn(&Inputs) -> Option<u8>| {
        let shown = at_pins.sensors.iter().filter_map(of);
        shown.into_iter().any(|shown| shown.abs_diff(reading) <= 1)
    };
    let switches = |inputs: &Inputs| {
        (
            inputs.bumper,
            inputs.top_hat,
            inputs.cliff,
            inputs.motion,
            inputs.beacon,
            inputs.is_docked,
        )
    };
    let are_equal = at_pins
        .sensors
        .iter()
        .any(|shown| switches(shown) == switches(inputs))
        && is_close(inputs.photo_left.unwrap_or_default(), |shown| {
            shown.photo_left
        })
        && is_close(inputs.photo_right.unwrap_or_default(), |shown| {
            shown.photo_right
        })
        && is_close(inputs.battery_dv, |shown| Some(shown.battery_dv));
    if !are_equal {
        return Err(format!(
            "the board reads {inputs:?}, the sensors show {:?}",
            at_pins.sensors
        ));
    }
    let Some(heard) = inputs.sonar else {
        return Ok(());
    };
    // A tick that hears an echo may have pinged again.
    let mut pings = at_pins.pings.into_iter().flatten();
    let is_echo = pings.any(|(at_ms, echo)| {
        at_pins.now_ms - at_ms >= TICK_MS
            && echo.side == heard.side
            && match (echo.range_in, heard.range_in) {
                (Some(range_in), Some(heard_in)) => range_in.abs_diff(heard_in) <= 1,
                (range_in, heard_in) => range_in == heard_in,
            }
    });
    if is_echo {
        Ok(())
    } else {
        Err(format!(
            "the board hears {heard:?}, the pings {:?}",
            at_pins.pings
        ))
    }
}

fn compare_outputs(outputs: &Outputs, at_pins: &AtPins) -> Result<(), String> {
    if at_pins.is_reset {
        return Ok(());
    }
    let pulse_us = if outputs.arm_up {
        SERVO_UP_US..SERVO_MOST_US
    } else {
        SERVO_LEAST_US..SERVO_UP_US
    };
    let [newest, _] = at_pins.pings;
    let is_pinged = |side: Side| {
        newest.is_some_and(|(at_ms, echo)| at_pins.now_ms - at_ms <= 1 && echo.side == side)
    };
    let are_equal = at_pins.widths == [outputs.pwm_left, outputs.pwm_right]
        // The timer divides its clock by a whole number.
        && at_pins.tone_hz.abs_diff(outputs.note_hz) <= outputs.note_hz / 32
        && pulse_us.contains(&at_pins.servo_us)
        && outputs.ping.is_none_or(is_pinged);
    if are_equal {
        Ok(())
    } else {
        Err(format!(
            "the robot's program orders {outputs:?}, the pins show {at_pins:?}"
        ))
    }
}

/// The bytes of a call or of its results.
struct Bytes(VecDeque<u8>);

impl FromIterator<u8> for Bytes {
    fn from_iter<T: IntoIterator<Item = u8>>(bytes: T) -> Self {
        Self(bytes.into_iter().collect())
    }
}

impl Port for Bytes {
    fn read(&mut self) -> u8 {
        self.0.pop_front().unwrap_or_default()
    }

    fn write(&mut self, byte: u8) {
        self.0.push_back(byte);
    }
}
