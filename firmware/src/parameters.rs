//! Parameters that the operator can tune: one table of names, limits and defaults.

/// Definition of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Name: at most 18 lower-case characters and hyphens.
    pub name: &'static str,
    /// Unit: at most 11 characters.
    pub unit: &'static str,
    /// Minimum value.
    pub least: i16,
    /// Maximum value.
    pub most: i16,
    /// Default value.
    pub default: i16,
}

/// Declares the parameters: description, variant, name, unit, limits, default.
macro_rules! parameters {
    ($(#[doc = $about:literal] $variant:ident: $name:literal, $unit:literal, $least:literal..=$most:literal, $default:literal;)+) => {
        /// A tunable parameter.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Parameter { $(#[doc = $about] $variant),+ }

        impl Parameter {
            /// All parameters in the table's order.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// Definition of the parameter.
            #[must_use]
            pub const fn definition(self) -> Definition {
                match self {
                    $(Self::$variant => Definition {
                        name: $name,
                        unit: $unit,
                        least: $least,
                        most: $most,
                        default: $default,
                    }),+
                }
            }

            /// Description of the parameter; separate from the definition, so that a robot does not store it.
            #[must_use]
            pub const fn about(self) -> &'static str {
                match self {
                    $(Self::$variant => $about.trim_ascii_start()),+
                }
            }
        }

        /// A value for each parameter.
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub struct Parameters([i16; Parameter::ALL.len()]);

        impl Parameters {
            /// The default values.
            pub const DEFAULT: Self = Self([$($default),+]);
        }
    };
}

parameters! {
    /// Maximum prowling speed.
    TopSpeed: "top-speed", "in/s", 2..=12, 12;
    /// Maximum change of the wheel speed per second.
    Slew: "slew", "in/s2", 6..=48, 24;
    /// Pulse width per count a second of commanded speed.
    PidFeed: "pid-feed", "1/256", 0..=400, 204;
    /// Pulse width per count a second of speed error.
    PidP: "pid-p", "1/256", 0..=400, 102;
    /// Pulse width per count of accumulated error.
    PidI: "pid-i", "1", 0..=12, 3;
    /// Pulse width per count a second by which the commanded speed changes in a tick.
    PidD: "pid-d", "1/256", 0..=2000, 680;
    /// Diameter of the left wheel.
    WheelLeft: "wheel-left", "in/1000", 2500..=7500, 5000;
    /// Diameter of the right wheel.
    WheelRight: "wheel-right", "in/1000", 2500..=7500, 5000;
    /// Distance between the wheels.
    Track: "track", "in/1000", 4000..=14000, 10000;
    /// Whether repeated bumps make the robot spin to escape.
    Escapes: "escapes", "0 or 1", 0..=1, 1;
    /// Minimum number of infrared samples in a row that make a detection.
    InfraredLeast: "ir-count-least", "looks", 1..=60, 3;
    /// Maximum number of infrared samples in a row that make a detection, after many detections.
    InfraredMost: "ir-count-most", "looks", 1..=60, 40;
    /// Difference of the sonar ranges, as a share of their sum, below which they count as equal.
    SonarDeadzone: "sonar-deadzone", "%", 0..=100, 15;
    /// Sonar range below which, on both sides, the robot does not drive ahead.
    SonarClose: "sonar-close", "in", 6..=120, 30;
    /// Range of the farthest echo that the sonar hears: 157 for an HC-SR04.
    SonarReach: "sonar-reach", "in", 60..=420, 420;
    /// Whether the robot turns away from light instead of toward it.
    PhotoAvoid: "photo-avoid", "0 or 1", 0..=1, 0;
    /// Difference of the photocells below which they count as equal.
    PhotoDeadzone: "photo-deadzone", "1/256", 0..=255, 8;
    /// Settling time of the motion detectors before they are armed.
    Settle: "motion-settle", "s", 1..=120, 15;
    /// Time for which the robot charges at a detected motion.
    Charge: "motion-charge", "s/10", 0..=50, 15;
    /// Distance from a target at which it counts as reached.
    Arrive: "arrive", "in", 2..=24, 6;
    /// Time of wandering before the robot goes home.
    Wander: "wander", "s", 10..=3600, 180;
    /// Side of the calibration square: clockwise, or counterclockwise if negative.
    Square: "square", "in", -400..=400, 157;
    /// Whether the cliff guard keeps the robot from driving over an edge of the floor.
    CliffGuard: "cliff-guard", "0 or 1", 0..=1, 1;
    /// Whether the robot may switch its own sensors off and on.
    Behaviour: "behaviour", "0 or 1", 0..=1, 1;
    /// Whether the robot goes to its dock when the battery is low.
    Forage: "forage", "0 or 1", 0..=1, 0;
    /// Voltage below which the battery is low.
    LowBattery: "battery-low", "V/10", 40..=130, 116;
    /// Voltage below which the battery is damaged: the robot stops and calls, except on the way to its dock. 0 disables.
    CriticalBattery: "battery-critical", "V/10", 0..=130, 112;
}

impl Parameter {
    /// The parameter whose name has this key.
    #[must_use]
    pub fn with_key(key: u32) -> Option<Self> {
        let has_key =
            |one: &&Self| groundwave_protocol::parameter::key(one.definition().name) == key;
        Self::ALL.iter().find(has_key).copied()
    }

    /// The parameter of this name.
    #[must_use]
    pub fn with_name(name: &str) -> Option<Self> {
        let has_name = |one: &&Self| one.definition().name == name;
        Self::ALL.iter().find(has_name).copied()
    }
}

impl Parameters {
    /// Value of a parameter.
    #[must_use]
    pub fn get(&self, parameter: Parameter) -> i16 {
        self.0
            .get(parameter as usize)
            .copied()
            .unwrap_or(parameter.definition().default)
    }

    /// Whether a 0-or-1 parameter is 1.
    #[must_use]
    pub fn is_on(&self, parameter: Parameter) -> bool {
        self.get(parameter) != 0
    }

    /// Changes a value and returns true, or changes nothing and returns false if it is out of range.
    pub fn set(&mut self, parameter: Parameter, value: i16) -> bool {
        let definition = parameter.definition();
        let fits = (definition.least..=definition.most).contains(&value);
        if fits && let Some(place) = self.0.get_mut(parameter as usize) {
            *place = value;
        }
        fits
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::parameter as protocol;

    #[test]
    fn parameter_table_is_consistent() {
        let mut parameters = Parameters::default();
        for (place, &parameter) in Parameter::ALL.iter().enumerate() {
            let definition = parameter.definition();
            assert_eq!(parameter as usize, place);
            assert!(protocol::is_name(definition.name), "{}", definition.name);
            assert!(definition.unit.len() <= protocol::UNIT_BYTES);
            let key = protocol::key(definition.name);
            assert_eq!(
                Parameter::with_key(key),
                Some(parameter),
                "the key is unique"
            );
            assert_eq!(Parameter::with_name(definition.name), Some(parameter));
            assert_eq!(parameters.get(parameter), definition.default);
            assert!(parameters.set(parameter, definition.most));
            assert!(!parameters.set(parameter, definition.most + 1));
            assert!(!parameters.set(parameter, definition.least - 1));
            assert_eq!(parameters.get(parameter), definition.most);
            assert!(
                parameters.set(parameter, definition.default),
                "the default is in range"
            );
            let same = |other: &&Parameter| other.definition().name == definition.name;
            assert_eq!(Parameter::ALL.iter().filter(same).count(), 1);
        }
        assert_eq!(parameters, Parameters::DEFAULT);
        assert!(Parameter::ALL.len() <= usize::from(protocol::PARAMETERS_MAX));
        assert_eq!(Parameter::with_key(0), None);
    }
}
