//! Runs: captures with what their operator has to say of them, and how two of them differ.
//!
//! A capture is evidence and is never written to again; what people think of it stands beside it, in a
//! [`label`]. A [`track`] is the way a run took, and a [`comparison`] lays two of them over each other.

pub mod comparison;
pub mod label;
pub mod overlay;
pub mod sketch;
pub mod track;

pub use comparison::Comparison;
pub use label::Label;
pub use track::Track;
