//! Opens the link of a verb.

use super::cli::LinkArgs;
use super::{Exit, Fault, say};
use crate::io::link::{Connection, LinkSpec};

/// Opens a link; with `--wait`, waits until the link appears.
pub(super) fn connect(spec: &LinkSpec, baud: u32, options: &LinkArgs) -> Result<Connection, Fault> {
    let opened = match options.wait {
        None => Connection::open(spec, baud),
        Some(limit) => Connection::open_once_there(spec, baud, limit, || {
            say(format_args!(
                "groundwave: waiting for {spec}, which is not there yet; Ctrl-C gives up"
            ));
        }),
    };
    opened.map_err(|error| Fault::new(Exit::NoLink, error))
}
