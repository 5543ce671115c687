//! Runs: captures with their operator's labels, and comparisons of two runs.
//!
//! A finished capture is never changed; a [`label`] file beside it contains the operator's remarks. A [`course`] is the path of a run;
//! a [`comparison`] measures the distance between two courses.

pub mod comparison;
pub mod course;
pub mod figures;
pub mod folder;
pub mod label;
pub mod sketch;

pub use comparison::Comparison;
pub use course::Course;
pub use label::Label;
