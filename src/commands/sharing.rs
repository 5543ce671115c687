//! The options that say who else may use the link.

use super::cli::Sharing;
use super::{Exit, Fault};
use crate::io::foxglove::{Foxglove, FoxgloveError};
use crate::io::link::Sink;
use crate::io::share::{Share, ShareError};

/// Shares the link if the options say so; must be called within the runtime.
pub(super) fn listen(options: &Sharing) -> Result<Option<Share>, Fault> {
    options
        .share
        .as_ref()
        .map(|address| Share::listen(address, options.share_open_to_network))
        .transpose()
        .map_err(|error| {
            let exit = match error {
                ShareError::Exposed(_) => Exit::Usage,
                ShareError::Taken(..) | ShareError::Listen(..) => Exit::Failed,
            };
            Fault::new(exit, error)
        })
}

/// Lets tools watch live if the options say so; must be called within the runtime. `name` is what they
/// show the station as.
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

/// The recorder first, then those who share.
pub(super) fn sink(share: Option<&Share>, mut recorder: Sink) -> Sink {
    match share.map(Share::tap) {
        None => recorder,
        Some(tap) => Box::new(move |at, bytes| {
            recorder(at, bytes);
            tap.take(bytes);
        }),
    }
}
