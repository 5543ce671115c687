//! Parameters that telemetry still has to report.

use crate::parameters::Parameter;

const BYTES: usize = Parameter::ALL.len().div_ceil(8);

/// A set of parameters, one bit each.
#[derive(Clone, Debug)]
pub struct Due([u8; BYTES]);

impl Due {
    /// No parameters.
    pub const NONE: Self = Self([0; BYTES]);

    /// Adds a parameter.
    pub fn add(&mut self, parameter: Parameter) {
        let place = parameter as usize;
        if let Some(bits) = self.0.get_mut(place / 8) {
            *bits |= 1 << (place % 8);
        }
    }

    /// Removes and returns the first parameter of the set.
    pub fn take(&mut self) -> Option<Parameter> {
        let byte = self.0.iter().position(|&bits| bits != 0)?;
        let bits = self.0.get_mut(byte)?;
        let place = 8 * byte + bits.trailing_zeros() as usize;
        *bits &= *bits - 1;
        Parameter::ALL.get(place).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn added_parameters_are_taken_once_in_table_order() {
        let mut due = Due::NONE;
        assert_eq!(due.take(), None);
        for &parameter in Parameter::ALL.iter().rev() {
            due.add(parameter);
            due.add(parameter);
        }
        for &parameter in Parameter::ALL {
            assert_eq!(due.take(), Some(parameter));
        }
        assert_eq!(due.take(), None);
    }
}
