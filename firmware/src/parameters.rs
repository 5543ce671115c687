//! What the operator may tune: one table of names, limits and starting values.

/// One line of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Definition {
    /// What people call it: at most 18 characters, lower case and hyphens.
    pub name: &'static str,
    /// What it counts: at most 11 characters.
    pub unit: &'static str,
    /// Least value.
    pub least: i16,
    /// Most.
    pub most: i16,
    /// Value of a robot that has never been tuned.
    pub default: i16,
}

/// Declares the parameters: what it is, variant, name, unit, limits, default.
macro_rules! parameters {
    ($(#[doc = $about:literal] $variant:ident: $name:literal, $unit:literal, $least:literal..=$most:literal, $default:literal;)+) => {
        /// What may be tuned.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Parameter { $(#[doc = $about] $variant),+ }

        impl Parameter {
            /// All of them, in the table's order.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// Its line of the table.
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

            /// What it is, for people. Apart from the table: no robot needs it in its memory.
            #[must_use]
            pub const fn about(self) -> &'static str {
                match self {
                    $(Self::$variant => $about.trim_ascii_start()),+
                }
            }
        }

        /// A value for each.
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub struct Parameters([i16; Parameter::ALL.len()]);

        impl Parameters {
            /// Those of a robot that has never been tuned.
            pub const DEFAULT: Self = Self([$($default),+]);
        }
    };
}

parameters! {
    /// Fastest that it prowls.
    TopSpeed: "top-speed", "in/s", 2..=12, 12;
    /// How fast an ordered speed may change.
    Slew: "slew", "in/s2", 6..=48, 24;
    /// Pulse width for each count a second ordered, in 256ths.
    PidFeed: "pid-feed", "1/256", 0..=400, 204;
    /// Pulse width for each count a second too slow, in 256ths.
    PidP: "pid-p", "1/256", 0..=400, 102;
    /// Pulse width for each count behind.
    PidI: "pid-i", "1", 0..=12, 3;
    /// Pulse width for each count a second by which the order changes in a tick, in 256ths.
    PidD: "pid-d", "1/256", 0..=2000, 680;
    /// Diameter of the left wheel.
    WheelLeft: "wheel-left", "in/1000", 4500..=5500, 5000;
    /// Diameter of the right wheel.
    WheelRight: "wheel-right", "in/1000", 4500..=5500, 5000;
    /// From wheel to wheel.
    Track: "track", "in/1000", 9000..=11000, 10000;
    /// Whether the bumper layer spins around when it keeps being caught.
    Escapes: "escapes", "0 or 1", 0..=1, 1;
    /// Infrared looks in a row that make a detection when little has been detected.
    InfraredLeast: "ir-count-least", "looks", 1..=60, 3;
    /// The same in the thick of things.
    InfraredMost: "ir-count-most", "looks", 1..=60, 40;
    /// Views that differ by less of their sum are equal.
    SonarDeadzone: "sonar-deadzone", "%", 0..=100, 15;
    /// Both views shorter than this: no further ahead.
    SonarClose: "sonar-close", "in", 6..=120, 30;
    /// Whether it turns from the brighter side instead of to it.
    PhotoAvoid: "photo-avoid", "0 or 1", 0..=1, 0;
    /// Photocells that differ by less are equal.
    PhotoDeadzone: "photo-deadzone", "1/256", 0..=255, 8;
    /// How long the motion detectors settle before they are armed.
    Settle: "motion-settle", "s", 1..=120, 15;
    /// How long it charges at what moved.
    Charge: "motion-charge", "s/10", 0..=50, 15;
    /// Nearer to a target than this it has arrived.
    Arrive: "arrive", "in", 2..=24, 6;
    /// How long it wanders before it goes home.
    Wander: "wander", "s", 10..=3600, 180;
    /// Side of the square of the calibration: clockwise, or to the left when negative.
    Square: "square", "in", -400..=400, 157;
    /// Whether nothing drives it over an edge of the floor.
    CliffGuard: "cliff-guard", "0 or 1", 0..=1, 1;
    /// Whether it may switch its own sensors off and on.
    Behaviour: "behaviour", "0 or 1", 0..=1, 1;
    /// Whether it goes to its dock when the battery is low.
    Forage: "forage", "0 or 1", 0..=1, 0;
    /// Below this the battery is low.
    LowBattery: "battery-low", "V/10", 100..=130, 116;
    /// Below this it is harmed: the robot stops, unless it is on the way to its dock, and calls. 0: it never stops.
    CriticalBattery: "battery-critical", "V/10", 0..=130, 112;
}

impl Parameter {
    /// The one whose name has this key.
    #[must_use]
    pub fn with_key(key: u32) -> Option<Self> {
        let has_key =
            |one: &&Self| groundwave_protocol::parameter::key(one.definition().name) == key;
        Self::ALL.iter().find(has_key).copied()
    }

    /// The one of this name.
    #[must_use]
    pub fn with_name(name: &str) -> Option<Self> {
        let has_name = |one: &&Self| one.definition().name == name;
        Self::ALL.iter().find(has_name).copied()
    }
}

impl Parameters {
    /// The value of one.
    #[must_use]
    pub fn get(&self, parameter: Parameter) -> i16 {
        self.0
            .get(parameter as usize)
            .copied()
            .unwrap_or(parameter.definition().default)
    }

    /// Whether one of 0 and 1 is 1.
    #[must_use]
    pub fn is_on(&self, parameter: Parameter) -> bool {
        self.get(parameter) != 0
    }

    /// Changes one; returns whether the value lies within its limits. Otherwise nothing changes.
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
    fn the_table_is_sound() {
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
                "no other has its key"
            );
            assert_eq!(Parameter::with_name(definition.name), Some(parameter));
            assert_eq!(parameters.get(parameter), definition.default);
            assert!(parameters.set(parameter, definition.most));
            assert!(!parameters.set(parameter, definition.most + 1));
            assert!(!parameters.set(parameter, definition.least - 1));
            assert_eq!(parameters.get(parameter), definition.most);
            assert!(
                parameters.set(parameter, definition.default),
                "the default fits"
            );
            let same = |other: &&Parameter| other.definition().name == definition.name;
            assert_eq!(Parameter::ALL.iter().filter(same).count(), 1);
        }
        assert_eq!(parameters, Parameters::DEFAULT);
        assert!(Parameter::ALL.len() <= usize::from(protocol::PARAMETERS_MAX));
        assert_eq!(Parameter::with_key(0), None);
    }
}
