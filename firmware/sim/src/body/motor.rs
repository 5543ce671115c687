//! A gear motor with its wheel and encoder. Distances and speeds are those of the wheel's rim.

/// Unloaded speed per volt across the motor.
const IN_S_PER_V: f64 = 2.0;
/// Resistance of winding and bridge.
const RESISTANCE_OHM: f64 = 8.0;
/// Voltage drop of the H-bridge.
pub(crate) const BRIDGE_DROP_V: f64 = 1.8;
/// Share of the torque that the gears transmit.
const GEAR_EFFICIENCY: f64 = 0.65;
/// Number of inches per metre; also kg in/s^2 per newton.
pub(crate) const IN_PER_M: f64 = 39.370_078_740_157_48;
/// Rim force per ampere: the motor constant, which back EMF also fixes, less the gear losses.
const FORCE_PER_A: f64 = IN_PER_M * IN_PER_M / IN_S_PER_V * GEAR_EFFICIENCY;
/// Inertia of rotor and gears as a mass at the rim.
pub(crate) const ROTOR_KG: f64 = 3.0;
/// Encoder edges per turn of the wheel.
const EDGES_PER_TURN: f64 = 251.0;
/// Nominal wheel diameter, inches.
const WHEEL_IN: f64 = 5.0;

/// The motor, wheel and encoder of one side.
#[derive(Clone, Debug)]
pub(crate) struct Motor {
    /// Rim speed, in/s.
    pub(crate) speed_in_s: f64,
    /// Current through the winding.
    pub(crate) current_a: f64,
    edges_per_in: f64,
    position_edges: f64,
    edges: u32,
}

impl Motor {
    /// A motor at rest; `oversize` is how much larger than nominal its wheel is, as a share.
    pub(crate) fn new(oversize: f64) -> Self {
        Self {
            speed_in_s: 0.0,
            current_a: 0.0,
            edges_per_in: EDGES_PER_TURN / (core::f64::consts::PI * WHEEL_IN * (1.0 + oversize)),
            position_edges: 0.5,
            edges: 0,
        }
    }

    /// Accelerates the rotor by `duty` of the supply against back EMF and dry friction.
    pub(crate) fn drive(&mut self, duty: f64, supply_v: f64, friction: f64, step_s: f64) {
        let applied_v = duty * (supply_v - BRIDGE_DROP_V).max(0.0);
        self.current_a = (applied_v - self.speed_in_s / IN_S_PER_V) / RESISTANCE_OHM;
        self.speed_in_s += FORCE_PER_A * self.current_a / ROTOR_KG * step_s;
        let braking = friction / ROTOR_KG * step_s;
        self.speed_in_s -= self.speed_in_s.clamp(-braking, braking);
    }

    /// Advances the encoder with the wheel.
    pub(crate) fn turn(&mut self, step_s: f64) {
        let before = self.position_edges.floor();
        self.position_edges += self.speed_in_s * step_s * self.edges_per_in;
        self.edges += (self.position_edges.floor() - before).abs() as u32;
    }

    /// Encoder edges since the last call.
    pub(crate) fn take_edges(&mut self) -> u16 {
        u16::try_from(core::mem::take(&mut self.edges)).unwrap_or(u16::MAX)
    }
}

/// Dry friction as a share of a stalled motor's force at 12 volts.
pub(crate) fn load_friction(share: f64) -> f64 {
    share * (12.0 - BRIDGE_DROP_V) / RESISTANCE_OHM * FORCE_PER_A
}

/// Force of back EMF per inch a second, in kg/s.
#[cfg(test)]
pub(crate) fn damping() -> f64 {
    FORCE_PER_A / (IN_S_PER_V * RESISTANCE_OHM)
}

/// Current that balances a dry friction.
#[cfg(test)]
pub(crate) fn current_for(friction: f64) -> f64 {
    friction / FORCE_PER_A
}

/// Steady rim speed at which the motor's force equals the friction.
#[cfg(test)]
pub(crate) fn steady_speed_in_s(duty: f64, supply_v: f64, friction: f64) -> f64 {
    let current_a = current_for(friction);
    (duty * (supply_v - BRIDGE_DROP_V) - current_a * RESISTANCE_OHM) * IN_S_PER_V
}
