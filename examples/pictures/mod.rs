//! Tools for the pictures of the documents: a run of the demo in virtual time, and its screen as SVG.

pub mod flight;
pub mod svg;
