//! Status codes: states sent as one ASCII character each, most of them in line A.

/// Declares an enum whose variants are single ASCII characters on the wire, from one list.
macro_rules! status_codes {
    ($(#[$meta:meta])* $name:ident { $($(#[$vmeta:meta])* $variant:ident = $letter:literal),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum $name { $($(#[$vmeta])* $variant = $letter),+ }

        impl $name {
            /// Every variant, in the order of SPEC.md.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The letter on the wire.
            #[must_use]
            pub const fn letter(self) -> u8 { self as u8 }

            /// The variant with a letter; `None` for an unknown letter.
            #[must_use]
            pub const fn from_letter(letter: u8) -> Option<Self> {
                match letter { $($letter => Some(Self::$variant),)+ _ => None }
            }
        }
    };
}
pub(crate) use status_codes;

status_codes! {
    /// Front bumper switches pressed at any tick since the previous line A.
    Bump {
        /// No switch pressed.
        None = b'.',
        /// Left switch.
        Left = b'L',
        /// Centre switch.
        Center = b'C',
        /// Right switch.
        Right = b'R',
        /// Left and centre switches.
        LeftCenter = b'l',
        /// Centre and right switches.
        RightCenter = b'r',
        /// Left and right switches, but not the centre one.
        Sides = b'S',
        /// All three switches.
        All = b'A',
        /// Pressed for so long that the robot ignores the bumper.
        Jammed = b'J',
        /// No bumper is fitted.
        NotFitted = b'-',
    }
}

status_codes! {
    /// Infrared detections at any tick since the previous line A.
    Infrared {
        /// Nothing detected.
        None = b'.',
        /// Left detector.
        Left = b'L',
        /// Right detector.
        Right = b'R',
        /// Both detectors.
        Both = b'B',
        /// Switched off after 30 s of continuous detection.
        Jammed = b'J',
        /// No detectors are fitted.
        NotFitted = b'-',
    }
}

status_codes! {
    /// Floor edge sensors since the previous line A.
    Cliff {
        /// Floor under every sensor.
        None = b'.',
        /// No floor under the left sensor.
        Left = b'L',
        /// No floor under the centre sensor.
        Center = b'C',
        /// No floor under the right sensor.
        Right = b'R',
        /// No floor under more than one sensor.
        Several = b'A',
        /// No edge sensors are fitted.
        NotFitted = b'-',
    }
}

status_codes! {
    /// The servo arm and its passive infrared motion detectors since the previous line A.
    Arm {
        /// Stowed behind the bumper.
        Stowed = b'.',
        /// Up, detectors settling.
        Up = b'u',
        /// Armed, waiting for motion.
        Armed = b'a',
        /// Motion on the left.
        MotionLeft = b'L',
        /// Motion on the right.
        MotionRight = b'R',
        /// Motion on both sides.
        MotionBoth = b'B',
        /// The top-hat switch touched an obstacle above.
        TopHat = b'T',
        /// No arm is fitted.
        NotFitted = b'-',
    }
}

status_codes! {
    /// The drive train and its odometer.
    Drive {
        /// Wheels follow the requested speed.
        Ok = b'.',
        /// Full power, but slower than requested.
        Saturated = b's',
        /// Full power, but no movement.
        Stalled = b'X',
        /// The odometer was reset since the previous line A.
        OdometerReset = b'0',
        /// X or Y is too large for its field.
        OutOfRange = b'o',
    }
}

status_codes! {
    /// Battery and charger.
    Power {
        /// Above the low threshold.
        Ok = b'.',
        /// Below the low threshold.
        Low = b'l',
        /// Below the critical threshold.
        Critical = b'!',
        /// On the dock, but not charging.
        Docked = b'd',
        /// Charging.
        Charging = b'+',
    }
}

status_codes! {
    /// State of the failsafe against a silent ground.
    Link {
        /// No failsafe set.
        Ok = b'.',
        /// Armed: the robot acts if the ground becomes silent, so it needs keepalives.
        Armed = b'f',
        /// Acting, because the ground is silent.
        Failsafe = b'F',
    }
}

status_codes! {
    /// Commanded mode.
    Mode {
        /// Move about at top speed, or to the next waypoint.
        Prowl = b'P',
        /// Sensor layers without prowl: the robot does not move until a layer drives.
        Reactive = b'R',
        /// Hide and wait for motion.
        Passive = b'H',
        /// Motors off until the next command.
        Stop = b'X',
        /// Driven by hand.
        User = b'U',
        /// Wander for three minutes, then go home.
        Wander = b'W',
        /// Go home: drive to the origin by dead reckoning.
        GoHome = b'G',
        /// Look for the dock.
        Forage = b'F',
        /// Drive a square path.
        Calibrate = b'C',
    }
}

status_codes! {
    /// State of one subsumption layer, without the layer's own letter.
    ///
    /// On the wire, a raised layer shows its letter in lower case, and the layer that controls the
    /// motors shows its letter in upper case; see [`Layer::letter`].
    LayerState {
        /// Not fitted, not allowed, or switched off by the behaviour layer.
        Off = b'.',
        /// Running, with its flag not raised.
        Quiet = b'-',
        /// Raised its flag at some tick since the previous line A, but was suppressed.
        Raised = b'r',
        /// Controls the motors.
        Holds = b'H',
    }
}

/// The eight layers in order of priority, 0 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Layer {
    /// 0: hand drive.
    User = 0,
    /// 1: bumper switches.
    Bumpers = 1,
    /// 2: rotation and scanning.
    Rotation = 2,
    /// 3: infrared collision avoidance.
    Infrared = 3,
    /// 4: stereo sonar ranging.
    Sonar = 4,
    /// 5: photo approach or avoid.
    Photo = 5,
    /// 6: motion detector.
    Motion = 6,
    /// 7: dead reckoning.
    DeadReckoning = 7,
}

impl Layer {
    /// All layers, in order of priority.
    pub const ALL: [Self; 8] = [
        Self::User,
        Self::Bumpers,
        Self::Rotation,
        Self::Infrared,
        Self::Sonar,
        Self::Photo,
        Self::Motion,
        Self::DeadReckoning,
    ];

    /// The layer's letter, one of `UBTISLMD`. Only `U` is a letter of [`Mode`], too.
    #[must_use]
    pub const fn letter(self) -> u8 {
        b"UBTISLMD"[self as usize]
    }
}

/// A set of layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct LayerMask(u8);

impl LayerMask {
    /// No layer.
    pub const NONE: Self = Self(0);
    /// All eight layers.
    pub const ALL: Self = Self(0xFF);

    /// The mask whose bit `n` is layer `n`.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// The mask as bits; bit `n` is layer `n`.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether the layer is in the set.
    #[must_use]
    pub const fn contains(self, layer: Layer) -> bool {
        self.0 & (1 << layer as u8) != 0
    }

    /// The set with the layer added.
    #[must_use]
    pub const fn with(self, layer: Layer) -> Self {
        Self(self.0 | 1 << layer as u8)
    }

    /// The set without the layer.
    #[must_use]
    pub const fn without(self, layer: Layer) -> Self {
        Self(self.0 & !(1 << layer as u8))
    }

    /// The layers in both sets.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    macro_rules! each_letter_is_its_own {
        ($($name:ident: $letters:literal),+ $(,)?) => {$(
            let codes: std::string::String =
                $name::ALL.iter().map(|state| char::from(state.letter())).collect();
            assert_eq!(codes, $letters, stringify!($name));
            for letter in 0..=255 {
                let read = $name::from_letter(letter);
                assert_eq!(read.is_some(), $letters.as_bytes().contains(&letter));
                assert!(read.is_none_or(|state| state.letter() == letter));
            }
        )+};
    }

    /// A changed letter would change the protocol.
    #[test]
    fn status_codes_are_those_of_version_1() {
        each_letter_is_its_own! {
            Bump: ".LCRlrSAJ-",
            Infrared: ".LRBJ-",
            Cliff: ".LCRA-",
            Arm: ".uaLRBT-",
            Drive: ".sX0o",
            Power: ".l!d+",
            Link: ".fF",
            Mode: "PRHXUWGFC",
            LayerState: ".-rH",
        }
    }

    #[test]
    fn layer_letters_are_not_mode_letters() {
        let layers = Layer::ALL.map(|layer| char::from(layer.letter()));
        assert_eq!(layers, ['U', 'B', 'T', 'I', 'S', 'L', 'M', 'D']);
        for layer in Layer::ALL.into_iter().skip(1) {
            assert_eq!(Mode::from_letter(layer.letter()), None);
        }
    }

    #[test]
    fn masks_hold_sets_of_layers() {
        let mask = LayerMask::NONE.with(Layer::Sonar).with(Layer::User);
        assert_eq!(mask.bits(), 0b1_0001);
        assert!(mask.contains(Layer::Sonar) && !mask.contains(Layer::Bumpers));
        assert_eq!(mask.without(Layer::User).bits(), 0b1_0000);
        assert_eq!(
            mask.and(LayerMask::from_bits(0b11)),
            LayerMask::NONE.with(Layer::User)
        );
    }
}
