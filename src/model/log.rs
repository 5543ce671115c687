//! The log: the newest things worth a line, in bounded memory.

use std::collections::VecDeque;

use crate::event::{Level, Moment};

const ENTRIES_MAX: usize = 256;

/// Changes of holder closer together than this share a line.
const HOLDER_REST: Moment = Moment::from_millis(1500);

/// Steering changes hands all the time: it is told no more often than this.
const ROUTINE_REST: Moment = Moment::from_secs(6);

/// What an entry is about: its mark on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    /// Somebody else holds the motors, or the mode changed.
    Behaviour,
    /// The bumper touched something.
    Bump,
    /// The connection.
    Link,
    /// A command of the operator's.
    Command,
    /// The robot's own words.
    Robot,
    /// A limit that was passed; the alarms have a place of their own where everybody looks.
    Alarm,
    /// The station.
    Station,
}

/// One line of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) at: Moment,
    pub(crate) level: Level,
    pub(crate) subject: Subject,
    pub(crate) text: String,
    /// How often it happened in a row.
    pub(crate) times: u32,
}

impl Entry {
    /// Whether it is worth a place where everybody looks. Commands have their own
    /// way there, and the status line tells of the link.
    pub(crate) fn is_news(&self) -> bool {
        match self.subject {
            Subject::Station => true,
            Subject::Robot => self.level == Level::Alarm,
            Subject::Behaviour
            | Subject::Bump
            | Subject::Link
            | Subject::Command
            | Subject::Alarm => false,
        }
    }
}

/// The newest entries, oldest first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Log {
    entries: VecDeque<Entry>,
    held_at: Option<Moment>,
    alarms: u64,
}

impl Log {
    pub(super) fn add(
        &mut self,
        at: Moment,
        level: Level,
        subject: Subject,
        text: impl Into<String>,
    ) {
        let text = text.into();
        self.alarms += u64::from(level == Level::Alarm);
        if let Some(last) = self.entries.back_mut()
            && last.text == text
            && last.subject == subject
        {
            last.times = last.times.saturating_add(1);
            last.at = at;
            return;
        }
        if self.entries.len() == ENTRIES_MAX {
            self.entries.pop_front();
        }
        self.entries.push_back(Entry {
            at,
            level,
            subject,
            text,
            times: 1,
        });
    }

    /// A change of holder, unless the one before has only just been told: the ladder shows each.
    pub(super) fn add_holder(&mut self, at: Moment, routine: bool, text: impl FnOnce() -> String) {
        let rest = if routine { ROUTINE_REST } else { HOLDER_REST };
        if self
            .held_at
            .is_none_or(|last| at.saturating_sub(last) >= rest)
        {
            self.held_at = Some(at);
            self.add(at, Level::Info, Subject::Behaviour, text());
        }
    }

    /// How many alarms there were.
    pub(super) const fn alarms(&self) -> u64 {
        self.alarms
    }

    /// Newest first.
    pub(crate) fn newest_first(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().rev()
    }
}
