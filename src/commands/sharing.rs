//! Shares links according to the options.

use super::cli::Sharing;
use super::{Exit, Fault, check_open_files};
use crate::io::foxglove::{Foxglove, FoxgloveError};
use crate::io::link::Sink;
use crate::io::open_files;
use crate::io::share::{CONNECTIONS_MAX, Share, ShareError, find_station, usual_address};
use crate::share::Address;

/// Parses the address to share on; an empty text means the default address.
pub(super) fn parse_address(text: &str) -> Result<Address, String> {
    if text.is_empty() {
        return usual_address().ok_or_else(no_home);
    }
    text.parse()
}

/// Parses the address of a station; an empty text means the station on this machine.
pub(super) fn parse_station(text: &str) -> Result<Address, String> {
    if text.is_empty() {
        let found = find_station().map_err(|error| error.to_string())?;
        return found.ok_or_else(no_home);
    }
    text.parse().map_err(|error| {
        format!("{error}; alone after the command (`send stop --via`), it finds the station on this machine")
    })
}

fn no_home() -> String {
    "no home folder is known; give an address".to_owned()
}

/// Opens the share server if the options ask for it; must be called within the runtime.
pub(super) fn listen(options: &Sharing) -> Result<Option<Share>, Fault> {
    let Some(address) = &options.share else {
        return Ok(None);
    };
    // Clients must not use up the files of the station.
    check_open_files(open_files::ANY_COMMAND + CONNECTIONS_MAX)?;
    let share = Share::listen(address, options.share_open_to_network);
    share.map(Some).map_err(|error| {
        let exit = match error {
            ShareError::Exposed(_) => Exit::Usage,
            ShareError::Taken(..) | ShareError::Token(..) | ShareError::Listen(..) => Exit::Failed,
        };
        Fault::new(exit, error)
    })
}

/// Opens the Foxglove server if the options ask for it; must be called within the runtime. Clients display `name`.
pub(super) async fn foxglove(options: &Sharing, name: &str) -> Result<Option<Foxglove>, Fault> {
    let Some(address) = &options.foxglove else {
        return Ok(None);
    };
    let server = Foxglove::listen(address, options.share_open_to_network, name).await;
    server.map(Some).map_err(|error| {
        let exit = match error {
            FoxgloveError::Exposed(_) | FoxgloveError::Path(_) | FoxgloveError::Absent => {
                Exit::Usage
            }
            FoxgloveError::Listen(..) => Exit::Failed,
        };
        Fault::new(exit, error)
    })
}

/// A sink that passes bytes to the recorder first, then to the share server.
pub(super) fn sink(share: Option<&Share>, mut recorder: Sink) -> Sink {
    match share.map(Share::tap) {
        None => recorder,
        Some(tap) => Box::new(move |at, bytes| {
            recorder(at, bytes);
            tap.take(bytes);
        }),
    }
}
