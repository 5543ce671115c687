//! The panels of the dashboard.

/// A panel; a small screen shows one at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Panel {
    #[default]
    Sensors,
    /// The robot seen from above.
    Above,
    Plots,
    Commands,
    Log,
    Link,
    Alarms,
    /// Values of the robot's own lines.
    Fields,
}

impl Panel {
    /// Name in the list of panels; the names and keys of all panels must fit into a row of 80 columns.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Sensors => "sensors",
            Self::Above => "above",
            Self::Plots => "plots",
            Self::Commands => "commands",
            Self::Log => "log",
            Self::Link => "link",
            Self::Alarms => "alarms",
            Self::Fields => "fields",
        }
    }

    /// Every panel, in the order of the Tab key.
    pub(crate) const ALL: [Self; 8] = [
        Self::Sensors,
        Self::Above,
        Self::Plots,
        Self::Commands,
        Self::Log,
        Self::Link,
        Self::Alarms,
        Self::Fields,
    ];
}
