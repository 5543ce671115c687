//! Fields: name, unit, scale, role and limits.

use serde::{Deserialize, Serialize};

/// A named value of a robot's own lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Field {
    /// Name of the field in the line, or of its column.
    pub name: String,
    /// Unit of the scaled value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Factor of the value in the line.
    #[serde(default = "one")]
    pub scale: f64,
    /// Summand after scaling.
    #[serde(default)]
    pub offset: f64,
    /// Meaning of the field for map, alarms and link.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
    /// Limits of an alarm, in the field's unit.
    #[serde(default)]
    pub limits: Limits,
}

const fn one() -> f64 {
    1.0
}

/// Limits of a field's alarm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// The alarm is raised below this value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// The alarm is raised above this value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
}

/// The meaning of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Position, positive right of the start.
    X,
    /// Position, positive ahead of the start.
    Y,
    /// Heading, clockwise from the y axis.
    Heading,
    /// Speed over ground.
    Speed,
    /// Battery voltage.
    Battery,
    /// Mode, as text or number.
    Mode,
    /// Bumper: pressed unless 0, `false` or empty.
    Bump,
    /// Distance ahead.
    Sonar,
    /// Text for the log.
    Text,
    /// Line number; a jump means lost lines.
    Sequence,
}

impl Role {
    /// Units that a field with this role may have, with their factors; the first is the standard unit.
    #[must_use]
    pub fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::X | Self::Y | Self::Sonar => &[
                ("in", 1.0),
                ("ft", 12.0),
                ("mm", 1.0 / 25.4),
                ("cm", 1.0 / 2.54),
                ("m", 1.0 / 0.0254),
            ],
            Self::Speed => &[
                ("in/s", 1.0),
                ("ft/s", 12.0),
                ("mm/s", 1.0 / 25.4),
                ("cm/s", 1.0 / 2.54),
                ("m/s", 1.0 / 0.0254),
                ("km/h", 1.0 / 0.091_44),
                ("kn", 0.514_444_444 / 0.0254),
            ],
            Self::Heading => &[
                ("deg", 1.0),
                ("°", 1.0),
                ("rad", 180.0 / std::f64::consts::PI),
            ],
            Self::Battery => &[("V", 1.0), ("dV", 0.1), ("mV", 0.001)],
            Self::Mode | Self::Bump | Self::Text | Self::Sequence => &[],
        }
    }

    /// Whether the role needs a unit; a distance or speed without a unit would be drawn at a wrong scale.
    const fn needs_unit(self) -> bool {
        matches!(self, Self::X | Self::Y | Self::Sonar | Self::Speed)
    }
}

impl Field {
    /// A field without a unit or role.
    pub(crate) fn named(name: &str, unit: Option<&str>) -> Self {
        Self {
            name: name.to_owned(),
            unit: unit.map(str::to_owned),
            scale: 1.0,
            offset: 0.0,
            role: None,
            limits: Limits::default(),
        }
    }

    /// Converts a scaled value to the standard unit of the field's role: inches, degrees, in/s, volts. Without a role, returns the value
    /// unchanged.
    #[must_use]
    pub fn standard(&self, value: f64) -> f64 {
        value * self.role_factor().unwrap_or(1.0)
    }

    fn role_factor(&self) -> Option<f64> {
        let unit = self.unit.as_deref()?;
        let units = self.role?.units().iter();
        units
            .copied()
            .find(|(name, _)| *name == unit)
            .map(|(_, factor)| factor)
    }

    /// The reason why the field cannot be used; `None` if it can.
    pub(crate) fn mistake(&self) -> Option<String> {
        let name = &self.name;
        if !is_name(name) {
            return Some(format!(
                "field name {name:?} needs 1 to {} printable characters",
                crate::NAME_CHARS_MAX
            ));
        }
        if !(self.scale.is_finite() && self.offset.is_finite()) || self.scale == 0.0 {
            return Some(format!(
                "field {name:?}: scale must be a number other than 0, offset a number"
            ));
        }
        if let (Some(low), Some(high)) = (self.limits.low, self.limits.high)
            && low >= high
        {
            return Some(format!(
                "field {name:?}: limit low = {low} is not below high = {high}"
            ));
        }
        let role = self.role?;
        let units: Vec<&str> = role.units().iter().map(|(name, _)| *name).collect();
        let word = format!("{role:?}").to_lowercase();
        match &self.unit {
            None if role.needs_unit() => Some(format!(
                "field {name:?}: role {word} needs a unit: {}",
                units.join(", ")
            )),
            Some(unit) if !units.is_empty() && !units.contains(&unit.as_str()) => Some(format!(
                "field {name:?}: unknown unit {unit:?} for role {word}; one of {}",
                units.join(", ")
            )),
            _ => None,
        }
    }
}

/// Whether a text is a valid name of a field.
pub(crate) fn is_name(text: &str) -> bool {
    !text.is_empty()
        && text.chars().count() <= crate::NAME_CHARS_MAX
        && !text.chars().any(char::is_control)
}
