//! Runs: captures with what their operator has to say of them, and how two of them differ.
//!
//! A capture is evidence and is never written to again; what people think of it stands beside it, in a
//! [`label`]. A [`course`] is the way a run took, and a [`comparison`] lays two of them over each other.

pub mod comparison;
pub mod course;
pub mod figures;
pub mod folder;
pub mod label;
pub mod overlay;
pub mod sketch;

pub use comparison::Comparison;
pub use course::Course;
pub use label::Label;
