//! The one event loop: it owns the terminal, reads the clock and joins ports, station, model and view.

mod advice;
mod dashboard;
mod driver;
mod keeper;
mod live;
mod pace;
mod reports;
mod runs;
mod share_server;
mod source;

pub use dashboard::{Dashboard, Left, run};
pub use driver::Driver;
pub use keeper::{FinishOnDrop, KeepOptions, Keeper, REMEMBERED};
pub use reports::Reports;
pub use source::{CaptureSource, LiveSource, Source};
