//! Materials and their effect on sensors.

use serde::Deserialize;

/// Material of a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Material {
    /// A painted wall.
    Wall,
    /// A window or mirror: it transmits light and mirrors sound and infrared.
    Glass,
    /// Tall smooth furniture: a bookcase, a cupboard, a door.
    Wood,
    /// Cloth: a sofa, a bed, a curtain. Casts no shadow.
    Soft,
    /// Black and matt: nearly invisible to infrared.
    Dark,
    /// Too low for every sensor but the bumper: shoes, books, a door stop.
    Low,
    /// A thin round leg of wood.
    Leg,
    /// A thin black leg or caster of an office chair.
    DarkLeg,
    /// Legs of a person or an animal.
    Alive,
    /// The dock: a plate on the floor that reaches below the bumper.
    Dock,
}

/// Response of a material to the sensors.
#[expect(clippy::struct_excessive_bools, reason = "one per sensor")]
pub(crate) struct Surface {
    /// Whether the material reflects sound.
    pub(crate) sound: bool,
    /// Maximum angle from the normal at which sound returns to its source, degrees.
    pub(crate) echo_cone_deg: f64,
    /// Whether sound at a larger angle is mirrored.
    pub(crate) mirrors: bool,
    /// Maximum distance at which the sonar receives its echo, inches.
    pub(crate) echo_reach_in: f64,
    /// Share of infrared that the material reflects; 0 is invisible.
    pub(crate) reflectivity: f64,
    /// Whether the material casts a shadow at the height of the photocells.
    pub(crate) shades: bool,
    /// Whether the material hides a warm body from a motion detector on the raised arm.
    pub(crate) hides_warmth: bool,
    /// Whether the material stops the dock's infrared beam.
    pub(crate) stops_beam: bool,
}

impl Material {
    /// Material of a character of the floor plan.
    pub(super) const fn from_char(character: char) -> Option<Self> {
        match character {
            '#' => Some(Self::Wall),
            '=' => Some(Self::Glass),
            'w' => Some(Self::Wood),
            's' => Some(Self::Soft),
            'k' => Some(Self::Dark),
            'o' => Some(Self::Low),
            _ => None,
        }
    }

    pub(crate) const fn surface(self) -> Surface {
        match self {
            Self::Wall => surface(true, 20.0, true, HEARD_FAR_IN, 0.8, true, EVERYTHING),
            Self::Glass => surface(true, 14.0, true, HEARD_FAR_IN, 0.1, false, WARMTH),
            Self::Wood => surface(true, 30.0, true, HEARD_FAR_IN, 0.5, true, EVERYTHING),
            Self::Soft => surface(true, 65.0, false, 180.0, 0.6, false, EVERYTHING),
            Self::Dark => surface(true, 55.0, false, 300.0, 0.04, false, EVERYTHING),
            Self::Low | Self::Dock => surface(false, 0.0, false, 0.0, 0.0, false, NOTHING),
            Self::Leg => surface(true, 80.0, false, 96.0, 0.4, false, BEAM),
            Self::DarkLeg => surface(true, 80.0, false, 60.0, 0.03, false, BEAM),
            Self::Alive => surface(true, 70.0, false, 200.0, 0.4, true, BEAM),
        }
    }
}

/// The sensors from which a material hides an object.
#[derive(Clone, Copy)]
struct Hides {
    warmth: bool,
    beam: bool,
}

const EVERYTHING: Hides = Hides {
    warmth: true,
    beam: true,
};
/// Glass is opaque to body heat and transparent to the light of an LED.
const WARMTH: Hides = Hides {
    warmth: true,
    beam: false,
};
const BEAM: Hides = Hides {
    warmth: false,
    beam: true,
};
const NOTHING: Hides = Hides {
    warmth: false,
    beam: false,
};

/// A reach beyond the longest echo that the sonar can time, inches.
const HEARD_FAR_IN: f64 = 1000.0;

const fn surface(
    sound: bool,
    echo_cone_deg: f64,
    mirrors: bool,
    echo_reach_in: f64,
    reflectivity: f64,
    shades: bool,
    hides: Hides,
) -> Surface {
    Surface {
        sound,
        echo_cone_deg,
        mirrors,
        echo_reach_in,
        reflectivity,
        shades,
        hides_warmth: hides.warmth,
        stops_beam: hides.beam,
    }
}
