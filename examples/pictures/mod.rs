//! What the pictures of the documents are made with: a flight of the demo in virtual time, and its screen as SVG.

pub mod flight;
pub mod svg;
