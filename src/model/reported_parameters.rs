//! The robot's parameters, as it reported them.

use groundwave_protocol::telemetry::ParameterLine;

/// The reports of lines P, at most one for each place.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parameters(Vec<ParameterLine>);

impl Parameters {
    /// Takes the report of one.
    pub(super) fn take(&mut self, line: ParameterLine) {
        match self
            .0
            .binary_search_by_key(&line.place, |known| known.place)
        {
            Ok(at) => self.0[at] = line,
            Err(at) => self.0.insert(at, line),
        }
    }

    /// The robot keeps all values over a reset from now on.
    pub(super) fn take_saved(&mut self) {
        self.0.iter_mut().for_each(|line| line.kept = line.value);
    }

    /// The robot restarted: its values are those it keeps.
    pub(super) fn take_restart(&mut self) {
        self.0.iter_mut().for_each(|line| line.value = line.kept);
    }

    /// Those heard, in the robot's order.
    pub(crate) fn heard(&self) -> &[ParameterLine] {
        &self.0
    }

    /// Whether the robot has others.
    pub(crate) fn is_partial(&self) -> bool {
        self.0
            .first()
            .is_none_or(|line| usize::from(line.count) > self.0.len())
    }
}
