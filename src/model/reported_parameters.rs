//! The robot's parameters, as reported in lines P.

use groundwave_protocol::telemetry::ParameterLine;

/// The reported parameters, at most one for each number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parameters(Vec<ParameterLine>);

impl Parameters {
    /// Takes a line P.
    pub(super) fn take(&mut self, line: ParameterLine) {
        match self
            .0
            .binary_search_by_key(&line.place, |known| known.place)
        {
            Ok(at) => self.0[at] = line,
            Err(at) => self.0.insert(at, line),
        }
    }

    /// Takes the saving of all parameters: the current values survive a reset.
    pub(super) fn take_saved(&mut self) {
        self.0.iter_mut().for_each(|line| line.kept = line.value);
    }

    /// Takes a restart of the robot: the values are the saved ones.
    pub(super) fn take_restart(&mut self) {
        self.0.iter_mut().for_each(|line| line.value = line.kept);
    }

    /// The reported parameters, in the robot's order.
    pub(crate) fn heard(&self) -> &[ParameterLine] {
        &self.0
    }

    /// The present value of a parameter; `None` before its report.
    pub(super) fn value(&self, name: &str) -> Option<i32> {
        let line = self.0.iter().find(|line| line.name.as_str() == name)?;
        Some(line.value)
    }

    /// Whether the robot has further parameters.
    pub(crate) fn is_partial(&self) -> bool {
        self.0
            .first()
            .is_none_or(|line| usize::from(line.count) > self.0.len())
    }
}
