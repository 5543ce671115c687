//! A 12-volt sealed lead-acid battery of 2.2 ampere-hours.

const CAPACITY_AS: f64 = 2.2 * 3600.0;
const INTERNAL_OHM: f64 = 0.15;
/// What the controller, the sonars and the radio draw.
const ELECTRONICS_A: f64 = 0.3;
/// Open-circuit voltage by charge, from flat to full.
const OPEN_CIRCUIT_V: [(f64, f64); 6] = [
    (0.0, 10.5),
    (0.1, 11.5),
    (0.25, 11.9),
    (0.5, 12.25),
    (0.75, 12.55),
    (1.0, 12.85),
];

/// The battery's state.
#[derive(Clone, Debug)]
pub(crate) struct Battery {
    /// 0 flat to 1 full.
    charge: f64,
    /// A laboratory supply in the battery's place.
    fixed_v: Option<f64>,
    terminal_v: f64,
}

impl Battery {
    pub(crate) fn new(charge: f64, fixed_v: Option<f64>) -> Self {
        let mut battery = Self {
            charge: charge.clamp(0.0, 1.0),
            fixed_v,
            terminal_v: 0.0,
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

    /// Tenths of a volt, as the analogue input reads it.
    pub(crate) fn decivolts(&self) -> u8 {
        (self.terminal_v * 10.0).round().clamp(0.0, 255.0) as u8
    }

    /// Draws a current beside what the electronics take.
    pub(crate) fn draw(&mut self, motors_a: f64, step_s: f64) {
        let current_a = ELECTRONICS_A + motors_a.max(0.0);
        self.charge = (self.charge - current_a * step_s / CAPACITY_AS).max(0.0);
        self.terminal_v = (self.open_circuit_v() - current_a * INTERNAL_OHM).max(0.0);
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
    fn sags_by_its_resistance() {
        let mut battery = Battery::new(1.0, None);
        battery.draw(2.0, 0.0);
        assert!((battery.terminal_v() - (12.85 - 2.3 * 0.15)).abs() < 1e-9);
        assert_eq!(battery.decivolts(), 125);
    }

    #[test]
    fn an_ampere_and_the_electronics_empty_it_in_its_time() {
        let mut battery = Battery::new(1.0, None);
        let seconds = (CAPACITY_AS / 1.3) as u32;
        for _ in 0..seconds {
            battery.draw(1.0, 1.0);
        }
        assert!(battery.charge() < 0.001, "{}", battery.charge());
        assert!((battery.terminal_v() - (10.5 - 1.3 * 0.15)).abs() < 0.02);
    }
}
