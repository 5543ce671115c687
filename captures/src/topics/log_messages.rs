//! Derives log messages from the robot's lines.

use foxglove::messages::log::Level;
use groundwave_protocol::life::Life;
use groundwave_protocol::status_codes::{Bump, Drive, Layer, Link, Mode, Power};
use groundwave_protocol::telemetry::{Body, Line, StateLine};

use crate::words::{layer_word, mode_word};

/// The layer that controls the motors; `None` for prowl and User.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Holder(Option<Layer>);

/// Detects changes from line to line.
#[derive(Debug, Default)]
pub(crate) struct LogMessages {
    mode: Option<Mode>,
    holder: Option<Holder>,
    bump: Option<Bump>,
    drive: Option<Drive>,
    power: Option<Power>,
    link: Option<Link>,
    life: Life,
}

impl LogMessages {
    /// Takes a line; calls `tell` with the level and text of each change.
    pub(crate) fn handle_line<E>(
        &mut self,
        line: &Line,
        mut tell: impl FnMut(Level, &str) -> Result<(), E>,
    ) -> Result<(), E> {
        if self.life.take_line(line) {
            tell(Level::Warning, "the robot restarted")?;
        }
        match &line.body {
            Body::State(state) => self.handle_state(state, tell),
            Body::Text(text) if !text.as_str().is_empty() => tell(Level::Info, text.as_str()),
            _ => Ok(()),
        }
    }

    fn handle_state<E>(
        &mut self,
        state: &StateLine,
        mut tell: impl FnMut(Level, &str) -> Result<(), E>,
    ) -> Result<(), E> {
        if self.mode.replace(state.mode) != Some(state.mode) {
            tell(Level::Info, &format!("mode {}", mode_word(state.mode)))?;
        }
        let holder = Holder(state.layers.holder());
        if self.holder.replace(holder) != Some(holder) {
            let who = match (holder.0, state.mode) {
                (Some(layer), _) => layer_word(layer),
                (None, Mode::Prowl) => "prowl",
                (None, Mode::User) => "user",
                (None, _) => "no layer",
            };
            tell(Level::Info, &format!("{who} has the motors"))?;
        }
        if self.bump.replace(state.bump) != Some(state.bump)
            && let Some(text) = bump_words(state.bump)
        {
            tell(Level::Info, text)?;
        }
        if self.drive.replace(state.drive) != Some(state.drive)
            && let Some((level, text)) = drive_words(state.drive)
        {
            tell(level, text)?;
        }
        if let Some(before) = self.power.replace(state.power)
            && before != state.power
        {
            let (level, text) = power_words(state.power);
            tell(level, text)?;
        }
        if let Some(before) = self.link.replace(state.link)
            && before != state.link
            && state.link == Link::Failsafe
        {
            tell(Level::Error, "failsafe: the robot hears no ground")?;
        }
        Ok(())
    }
}

/// Whether a bumper is pressed.
pub(crate) const fn is_contact(bump: Bump) -> bool {
    !matches!(bump, Bump::None | Bump::NotFitted)
}

const fn bump_words(bump: Bump) -> Option<&'static str> {
    match bump {
        Bump::None | Bump::NotFitted => None,
        Bump::Left | Bump::LeftCenter => Some("bump left"),
        Bump::Center | Bump::Sides | Bump::All => Some("bump ahead"),
        Bump::Right | Bump::RightCenter => Some("bump right"),
        Bump::Jammed => Some("the bumper is jammed"),
    }
}

const fn drive_words(drive: Drive) -> Option<(Level, &'static str)> {
    match drive {
        Drive::Ok | Drive::Saturated => None,
        Drive::Stalled => Some((Level::Warning, "the motors are stalled")),
        Drive::OdometerReset => Some((Level::Info, "the odometer was reset")),
        Drive::OutOfRange => Some((Level::Warning, "the position is out of range")),
    }
}

const fn power_words(power: Power) -> (Level, &'static str) {
    match power {
        Power::Ok => (Level::Info, "the battery is well"),
        Power::Low => (Level::Warning, "the battery is low"),
        Power::Critical => (Level::Error, "the battery is critical"),
        Power::Docked => (Level::Info, "docked"),
        Power::Charging => (Level::Info, "charging"),
    }
}
