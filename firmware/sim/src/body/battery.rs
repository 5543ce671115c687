//! A 12-volt sealed lead-acid battery of 2.2 ampere-hours, and its charger.
//!
//! The charge is the sum of the current. The terminal voltage is the open-circuit voltage at this charge, less the
//! drop across the internal resistance. The table of open-circuit voltages is the usual one for six lead cells: about
//! 2.14 volts a cell full and rested, 1.75 volts at the end of discharge. It leaves the steep start and end out, so it
//! is accurate to about a tenth of a volt. Capacity does not depend on the current; a real battery of this size gives
//! a quarter less at one ampere, so real driving times are shorter.

/// Capacity in ampere-seconds.
const CAPACITY_AS: f64 = 2.2 * 3600.0;
const INTERNAL_OHM: f64 = 0.15;
/// Current of the controller, the sonars and the radio.
pub(super) const ELECTRONICS_A: f64 = 0.3;
/// Open-circuit voltage by charge, from empty to full.
const OPEN_CIRCUIT_V: [(f64, f64); 6] = [
    (0.0, 10.5),
    (0.1, 11.5),
    (0.25, 11.9),
    (0.5, 12.25),
    (0.75, 12.55),
    (1.0, 12.85),
];

/// Current of the charger, beside the electronics: three tenths of the capacity per hour.
const CHARGE_A: f64 = 0.66;
/// Charge above which the charging current tapers.
const TAPER_FROM: f64 = 0.8;
/// Share of the charging current that still flows into a full battery.
const TRICKLE: f64 = 0.02;
/// Maximum voltage of the charger.
const CHARGER_V: f64 = 14.4;
/// Rise of the voltage per ampere of charging current.
const CHARGING_OHM: f64 = 2.7;

/// The battery's state.
#[derive(Clone, Debug)]
pub(crate) struct Battery {
    /// Charge, 0 empty to 1 full.
    charge: f64,
    /// Voltage of a laboratory supply that replaces the battery.
    fixed_v: Option<f64>,
    terminal_v: f64,
    pub(super) is_charging: bool,
}

impl Battery {
    pub(crate) fn new(charge: f64, fixed_v: Option<f64>) -> Self {
        let mut battery = Self {
            charge: charge.clamp(0.0, 1.0),
            fixed_v,
            terminal_v: 0.0,
            is_charging: false,
        };
        battery.terminal_v = battery.open_circuit_v();
        battery
    }

    pub(crate) const fn terminal_v(&self) -> f64 {
        self.terminal_v
    }

    pub(crate) const fn charge(&self) -> f64 {
        self.charge
    }

    /// Terminal voltage in tenths of a volt, as the analogue input reads it.
    pub(crate) fn decivolts(&self) -> u8 {
        (self.terminal_v * 10.0).round().clamp(0.0, 255.0) as u8
    }

    /// Draws `motors_a` and the electronics' current for `step_s`.
    pub(crate) fn draw(&mut self, motors_a: f64, step_s: f64) {
        let motors_a = motors_a.max(0.0);
        let drawn_a = if self.is_charging {
            motors_a - self.taken_a()
        } else {
            ELECTRONICS_A + motors_a
        };
        self.charge = (self.charge - drawn_a * step_s / CAPACITY_AS).clamp(0.0, 1.0);
        self.terminal_v = if self.charge <= 0.0 && self.fixed_v.is_none() {
            // The voltage of an empty cell collapses under any load.
            0.0
        } else if self.is_charging && drawn_a < 0.0 {
            (self.open_circuit_v() + CHARGE_A * CHARGING_OHM).min(CHARGER_V)
        } else {
            (self.open_circuit_v() - drawn_a * INTERNAL_OHM).max(0.0)
        };
    }

    /// Current that the battery takes from the charger.
    fn taken_a(&self) -> f64 {
        CHARGE_A * ((1.0 - self.charge) / (1.0 - TAPER_FROM)).clamp(TRICKLE, 1.0)
    }

    fn open_circuit_v(&self) -> f64 {
        if let Some(volts) = self.fixed_v {
            return volts;
        }
        for pair in OPEN_CIRCUIT_V.windows(2) {
            let ((low, low_v), (high, high_v)) = (pair[0], pair[1]);
            if self.charge <= high {
                return low_v + (high_v - low_v) * (self.charge - low) / (high - low);
            }
        }
        OPEN_CIRCUIT_V[OPEN_CIRCUIT_V.len() - 1].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_voltage_sags_by_the_internal_resistance() {
        let mut battery = Battery::new(1.0, None);
        battery.draw(2.0, 0.0);
        assert!((battery.terminal_v() - (12.85 - 2.3 * 0.15)).abs() < 1e-9);
        assert_eq!(battery.decivolts(), 125);
    }

    #[test]
    fn capacity_lasts_for_the_drawn_current() {
        let mut battery = Battery::new(1.0, None);
        let seconds = (CAPACITY_AS / 1.3) as u32;
        for _ in 0..seconds {
            battery.draw(1.0, 1.0);
        }
        assert!(battery.charge() < 0.001, "{}", battery.charge());
        assert!((battery.terminal_v() - (10.5 - 1.3 * 0.15)).abs() < 0.02);
    }

    #[test]
    fn empty_battery_has_no_voltage_until_it_is_charged() {
        let mut battery = Battery::new(0.0, None);
        battery.draw(0.0, 0.001);
        assert_eq!(battery.decivolts(), 0);
        battery.is_charging = true;
        battery.draw(0.0, 0.001);
        assert!(battery.terminal_v() > 12.0, "{}", battery.terminal_v());
    }

    #[test]
    fn charging_current_tapers_near_full() {
        let mut battery = Battery::new(0.1, None);
        battery.is_charging = true;
        let mut hours_to = |charge| {
            let mut seconds = 0;
            while battery.charge() < charge {
                battery.draw(0.0, 1.0);
                seconds += 1;
            }
            f64::from(seconds) / 3600.0
        };
        // 0.7 of 2.2 ampere-hours at 0.66 amperes; after that the rest falls by 1/e in 0.2 of 3.33 hours.
        let steady = hours_to(0.8);
        assert!((steady - 0.7 * 2.2 / 0.66).abs() < 0.01, "{steady}");
        let tapering = hours_to(0.96);
        let expected = 0.2 * 2.2 / 0.66 * libm::log(0.2 / 0.04);
        assert!((tapering - expected).abs() < 0.01, "{tapering}");
        assert_eq!(battery.decivolts(), 144);
    }
}
