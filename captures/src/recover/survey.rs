//! What there is in a journal.

use std::path::Path;

use super::Missing;
use crate::CaptureError;
use crate::composer::Session;
use crate::journal::{Entry, JournalReader, Kind, Waste};

/// What there is in a journal.
pub(super) struct Survey {
    pub(super) session: Option<Session>,
    pub(super) rx_end: u64,
    pub(super) tx_end: u64,
    pub(super) waste: Waste,
    /// Received bytes that its entries do not have.
    pub(super) missing: Vec<Missing>,
    pub(super) missing_tx: u64,
}

impl Survey {
    pub(super) fn of(path: &Path) -> Result<Self, CaptureError> {
        let mut survey = Self {
            session: None,
            rx_end: 0,
            tx_end: 0,
            waste: Waste::default(),
            missing: Vec::new(),
            missing_tx: 0,
        };
        survey.waste = for_each_entry(path, |entry| {
            let end = entry.end();
            match entry.kind {
                Kind::Session => survey.session = serde_json::from_slice(&entry.data).ok(),
                Kind::Rx => {
                    if entry.offset > survey.rx_end {
                        survey.missing.push(Missing {
                            offset: survey.rx_end,
                            bytes: entry.offset - survey.rx_end,
                        });
                    }
                    survey.rx_end = survey.rx_end.max(end);
                }
                Kind::Tx => {
                    survey.missing_tx += entry.offset.saturating_sub(survey.tx_end);
                    survey.tx_end = survey.tx_end.max(end);
                }
                Kind::Event => {}
            }
            Ok(())
        })?;
        Ok(survey)
    }

    /// Something between its first entry and its end is missing or damaged.
    pub(super) const fn has_gaps(&self) -> bool {
        !self.missing.is_empty() || self.missing_tx > 0 || self.waste.has_damage()
    }

    /// It has everything from the beginning up to its end.
    pub(super) const fn is_complete(&self) -> bool {
        self.session.is_some() && !self.has_gaps()
    }
}

/// Returns what is of no use.
pub(super) fn for_each_entry(
    path: &Path,
    mut take: impl FnMut(&Entry) -> Result<(), CaptureError>,
) -> Result<Waste, CaptureError> {
    let read_error = |error| CaptureError::Read {
        path: path.to_owned(),
        error,
    };
    let mut reader = JournalReader::open(path).map_err(|error| CaptureError::Open {
        path: path.to_owned(),
        error,
    })?;
    while let Some(entry) = reader.next_entry().map_err(read_error)? {
        take(&entry)?;
    }
    Ok(reader.waste())
}
