//! Runs: captures with their operator's labels, and comparisons of two.
//!
//! A finished capture is never changed; the operator's remarks are in a [`label`] beside it. A [`course`] is the path of a run, and
//! a [`comparison`] lays two of them over each other.

pub mod comparison;
pub mod course;
pub mod figures;
pub mod folder;
pub mod label;
pub mod sketch;

pub use comparison::Comparison;
pub use course::Course;
pub use label::Label;
