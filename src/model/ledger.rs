//! The command ledger: commands and their confirmed progress.

use std::collections::VecDeque;

use groundwave_protocol::Waypoint;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{Layer, LayerMask};
use groundwave_protocol::telemetry::{ListPlace, StatusLine};

use crate::event::{CommandId, CommandStatus, Failure, Moment};
use crate::request::{Request, Tuning};

const ENTRIES_MAX: usize = 64;

/// A command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) id: CommandId,
    pub(crate) request: Request,
    /// Name of the client that sent the command over the shared link; `None` for this station's operator.
    pub(crate) by: Option<String>,
    /// Latest status.
    pub(crate) status: CommandStatus,
    /// Number of frames sent for the command; a route takes several, and every repetition counts.
    pub(crate) frames: u32,
    /// Number of acknowledged waypoints, and of all waypoints.
    pub(crate) progress: Option<(u16, u16)>,
    /// Time at which the status changed.
    pub(crate) at: Moment,
    /// Time at which the command was queued.
    pub(crate) asked_at: Moment,
    /// Time from the queueing to the confirmation.
    pub(crate) confirmed_after: Option<Moment>,
    /// Reason for a refusal and what to do, if more than the outcome is known.
    pub(crate) reason: Option<String>,
    /// The robot's progress in the command's list, from the latest line B.
    pub(crate) driven: Option<ListPlace>,
}

impl Entry {
    fn is_over(&self) -> bool {
        self.status.is_end()
    }

    fn confirmed_at(&self) -> Option<Moment> {
        Some(self.asked_at + self.confirmed_after?)
    }
}

/// The list that the robot confirmed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ActiveList {
    pub(crate) id: CommandId,
    pub(crate) digest: u32,
    pub(crate) waypoints: Vec<Waypoint>,
    /// The robot's progress in the list, from a line B with the same digest; `None` before such a line.
    pub(crate) driven: Option<ListPlace>,
}

impl ActiveList {
    /// Whether the robot has driven to every waypoint.
    pub(super) fn is_driven(&self) -> bool {
        self.driven
            .is_some_and(|place| usize::from(place.driven) >= self.waypoints.len())
    }
}

/// The latest commands.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ledger {
    entries: VecDeque<Entry>,
    active: Option<ActiveList>,
}

impl Ledger {
    /// Whether a command waits for its confirmation.
    pub(crate) fn is_busy(&self) -> bool {
        self.open().next().is_some()
    }

    /// The commands that wait for their confirmation, oldest first.
    pub(crate) fn open(&self) -> impl Iterator<Item = &Request> {
        let open = self.entries.iter().filter(|entry| !entry.is_over());
        open.map(|entry| &entry.request)
    }

    /// The newest STOP, if it waits for its confirmation, or failed and nothing was ordered since.
    pub(crate) fn unconfirmed_stop(&self) -> Option<&Entry> {
        let mut entries = self.entries.iter().rev();
        let stop = entries.find(|entry| entry.request == Request::Stop)?;
        let has_failed = matches!(
            stop.status,
            CommandStatus::Failed(Failure::TimedOut | Failure::NotSent)
        );
        let is_newest = self.entries.back().is_some_and(|entry| entry.id == stop.id);
        (!stop.is_over() || has_failed && is_newest).then_some(stop)
    }

    /// Takes a new status of a command; returns the command's entry, if known.
    pub(super) fn take_command_status(
        &mut self,
        now: Moment,
        id: CommandId,
        status: &CommandStatus,
    ) -> Option<&Entry> {
        let entry = self.entries.iter_mut().rev().find(|entry| entry.id == id)?;
        entry.at = now;
        match status {
            CommandStatus::Progress {
                acknowledged,
                total,
            } => entry.progress = Some((*acknowledged, *total)),
            CommandStatus::Queued | CommandStatus::Reported(_) => {}
            CommandStatus::Sent { frames } => {
                entry.status = *status;
                entry.frames = *frames;
            }
            CommandStatus::Echoed | CommandStatus::Refused(_) | CommandStatus::Failed(_) => {
                entry.status = *status;
            }
            CommandStatus::Confirmed { digest } => {
                entry.status = *status;
                entry.confirmed_after = Some(now.saturating_sub(entry.asked_at));
                if let (Some(digest), Request::Route(waypoints)) = (*digest, &entry.request) {
                    self.active = Some(ActiveList {
                        id,
                        digest,
                        waypoints: waypoints.clone(),
                        driven: None,
                    });
                }
            }
        }
        Some(entry)
    }

    /// The request of a command, while the ledger has it.
    pub(super) fn own_request(&self, id: CommandId) -> Option<&Request> {
        let entry = self.entries.iter().rev().find(|entry| entry.id == id)?;
        entry.by.is_none().then_some(&entry.request)
    }

    /// Takes a queued command; `by` names the client of the shared link that gave it.
    pub(super) fn add(&mut self, now: Moment, id: CommandId, request: Request, by: Option<String>) {
        if self.entries.len() == ENTRIES_MAX {
            // A command in progress is kept longer than a command that has ended.
            let victim = self.entries.iter().position(Entry::is_over).unwrap_or(0);
            self.entries.remove(victim);
        }
        self.entries.push_back(Entry {
            id,
            request,
            by,
            status: CommandStatus::Queued,
            frames: 0,
            progress: None,
            at: now,
            asked_at: now,
            confirmed_after: None,
            reason: None,
            driven: None,
        });
    }

    /// Takes a line B, which confirms the active list or reports another list.
    pub(super) fn take_status(&mut self, status: &StatusLine) {
        if let Some(active) = &mut self.active {
            if active.digest == status.digest {
                active.driven = Some(status.list);
                let id = active.id;
                if let Some(entry) = self.entries.iter_mut().find(|entry| entry.id == id) {
                    entry.driven = Some(status.list);
                }
            } else {
                self.active = None;
            }
        }
    }

    /// Takes a restart of the robot: its list is lost.
    pub(super) fn take_restart(&mut self) {
        self.active = None;
    }

    /// The commands, oldest first.
    pub(crate) fn entries(&self) -> impl DoubleEndedIterator<Item = &Entry> {
        self.entries.iter()
    }

    /// The command whose status changed last. A list of parameters does not count while other commands overtake it.
    pub(crate) fn newest(&self) -> Option<&Entry> {
        let list = Request::Parameter(Tuning::List);
        let is_overtaken = self.open().any(|request| *request != list);
        self.entries
            .iter()
            .filter(|entry| entry.is_over() || !is_overtaken || entry.request != list)
            .max_by_key(|entry| entry.at)
    }

    /// Sets the reason why the robot refused a command.
    pub(super) fn take_reason(&mut self, id: CommandId, reason: Option<String>) {
        if let Some(entry) = self.entries.iter_mut().rev().find(|entry| entry.id == id) {
            entry.reason = reason;
        }
    }

    /// The failsafe setting of the newest command that did not fail, and the time of its confirmation, if confirmed.
    pub(crate) fn failsafe(&self) -> Option<(Option<Moment>, Option<Failsafe>)> {
        let entries = self.entries.iter().rev();
        let mut entries =
            entries.filter(|entry| !entry.is_over() || entry.confirmed_after.is_some());
        entries.find_map(|entry| match entry.request {
            Request::Failsafe(setting) => Some((entry.confirmed_at(), setting)),
            _ => None,
        })
    }

    /// The list of this session that the robot confirmed and still reports.
    pub(crate) const fn active(&self) -> Option<&ActiveList> {
        self.active.as_ref()
    }

    /// The newest list that is being sent.
    pub(crate) fn pending_route(&self) -> Option<&[Waypoint]> {
        self.entries
            .iter()
            .rev()
            .filter(|entry| !entry.is_over())
            .find_map(|entry| match &entry.request {
                Request::Route(waypoints) => Some(&waypoints[..]),
                _ => None,
            })
    }

    /// The newest command that allows or forbids a layer, and is pending or was confirmed after the robot's latest report of its layers.
    pub(crate) fn asked_of(&self, layer: Layer, reported_at: Option<Moment>) -> Option<bool> {
        let asks = |mask: &LayerMask| mask.contains(layer);
        let is_newer = |entry: &&Entry| match entry.confirmed_at() {
            Some(at) => reported_at.is_none_or(|reported_at| at >= reported_at),
            None => !entry.is_over(),
        };
        self.entries
            .iter()
            .rev()
            .filter(is_newer)
            .find_map(|entry| match &entry.request {
                Request::Enable(mask) if asks(mask) => Some(true),
                Request::Disable(mask) if asks(mask) => Some(false),
                Request::Only(mask) => Some(asks(mask)),
                _ => None,
            })
    }
}
