//! The one event loop: it owns the terminal, reads the clock and joins ports, station, model and view.

mod dashboard;
mod driver;

pub use dashboard::{Dashboard, run};
pub use driver::Driver;
