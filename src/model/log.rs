//! The log, in bounded memory.

use std::collections::VecDeque;

use crate::event::{Level, Moment};

const ENTRIES_MAX: usize = 256;

/// Maximum length of a text, bytes. A recording may contain longer texts, and the keyframes of a replay contain copies.
const TEXT_BYTES_MAX: usize = 512;

/// Minimum time between two log lines about the holder of the motors.
const HOLDER_REST: Moment = Moment::from_millis(1500);

/// Minimum time between two log lines about routine steering.
const ROUTINE_REST: Moment = Moment::from_secs(6);

/// The subject of an entry; determines its mark on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    /// The holder of the motors or the mode changed.
    Behaviour,
    /// A contact.
    Bump,
    /// The connection.
    Link,
    /// A command.
    Command,
    /// Text from the robot.
    Robot,
    /// An alarm.
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
    /// Number of consecutive repetitions.
    pub(crate) times: u32,
}

impl Entry {
    /// Whether the hint line shows the entry as news. Commands and the link
    /// are shown elsewhere.
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
    /// Number of entries ever added.
    added: u64,
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
        let mut text = text.into();
        text.truncate(text.floor_char_boundary(TEXT_BYTES_MAX));
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
        self.added += 1;
        self.entries.push_back(Entry {
            at,
            level,
            subject,
            text,
            times: 1,
        });
    }

    /// Adds a change of holder, with a minimum time between two entries; the ladder shows every change.
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

    /// Number of alarms so far.
    pub(super) const fn alarms(&self) -> u64 {
        self.alarms
    }

    /// The entries with their permanent numbers, newest first.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (u64, &Entry)> {
        (0..self.added).rev().zip(self.newest_first())
    }

    /// The entries, newest first.
    pub(crate) fn newest_first(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().rev()
    }
}
