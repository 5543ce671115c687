//! Selection of the next line.
//!
//! Five of six lines are line A; the sixth alternates between line B and line C. After boot come C and B. A change of
//! line B's contents adds a line B, and a text adds a line T; both are limited in rate. A song adds a line S, and a
//! request of the ground station adds lines P, and a new session a line I. Every other line is followed by a line A.

use super::due::Due;
use crate::parameters::Parameter;
use crate::song::Song;

/// Kinds of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Line A.
    State,
    /// Line B.
    Status,
    /// Line C.
    Counters,
    /// Line T.
    Text(&'static str),
    /// Line T with the result of a scan.
    Findings,
    /// Line P.
    Parameter(Parameter),
    /// Line S.
    Song(Song),
    /// Line I.
    Abilities,
}

/// Number of lines A between two regular lines of another kind.
const STATES_PER_OTHER: u8 = 5;

/// Minimum distance between two lines B or two lines T: three lines, one second.
const RATION: u8 = 3;

/// Capacity of the text queue; further texts are dropped.
const TEXTS: usize = 4;

/// Selects the next line.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is an independent flag")]
pub struct Schedule {
    /// Number of lines sent since boot, counted up to the two initial ones.
    begun: u8,
    states: u8,
    previous_was_state: bool,
    counters_turn: bool,
    status_due: bool,
    since_status: u8,
    since_text: u8,
    texts: [Option<&'static str>; TEXTS],
    findings_due: bool,
    song: Option<Song>,
    abilities_due: bool,
    parameters: Due,
}

impl Default for Schedule {
    fn default() -> Self {
        Self::new(None)
    }
}

impl Schedule {
    /// A schedule at boot, perhaps with a text.
    #[must_use]
    pub const fn new(text: Option<&'static str>) -> Self {
        Self {
            begun: 0,
            states: 0,
            previous_was_state: true,
            counters_turn: true,
            status_due: false,
            since_status: RATION,
            since_text: RATION,
            texts: [text, None, None, None],
            findings_due: false,
            song: None,
            abilities_due: false,
            parameters: Due::NONE,
        }
    }

    /// Requests a line B because its contents have changed.
    pub const fn queue_status(&mut self) {
        self.status_due = true;
    }

    /// Requests a line T with the result of the latest scan.
    pub const fn queue_findings(&mut self) {
        self.findings_due = true;
    }

    /// Queues a text; it is lost if the queue is full.
    pub fn queue_text(&mut self, text: &'static str) {
        if let Some(slot) = self.texts.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(text);
        }
    }

    /// Requests a line S; it replaces a pending one.
    pub const fn queue_song(&mut self, song: Song) {
        self.song = Some(song);
    }

    /// Requests a line I.
    pub const fn queue_abilities(&mut self) {
        self.abilities_due = true;
    }

    /// Requests a line P for a parameter.
    pub fn queue_parameter(&mut self, parameter: Parameter) {
        self.parameters.add(parameter);
    }

    /// Kind of the next line.
    pub fn next_kind(&mut self) -> Kind {
        self.since_status = self.since_status.saturating_add(1);
        self.since_text = self.since_text.saturating_add(1);
        let kind = self.choose();
        self.previous_was_state = kind == Kind::State;
        match kind {
            Kind::State => self.states += 1,
            Kind::Status => {
                self.status_due = false;
                self.since_status = 0;
            }
            Kind::Text(_) | Kind::Findings => self.since_text = 0,
            Kind::Counters | Kind::Parameter(_) | Kind::Song(_) | Kind::Abilities => {}
        }
        kind
    }

    fn choose(&mut self) -> Kind {
        if self.begun < 2 {
            self.begun += 1;
            return if self.begun == 1 {
                Kind::Counters
            } else {
                Kind::Status
            };
        }
        if !self.previous_was_state {
            return Kind::State;
        }
        // Lines B and C alternate; a line B that was just sent for a change is not repeated.
        let is_status_turn = self.counters_turn;
        if self.states >= STATES_PER_OTHER && (!is_status_turn || self.since_status >= RATION) {
            self.states = 0;
            self.counters_turn = !self.counters_turn;
            return if self.counters_turn {
                Kind::Counters
            } else {
                Kind::Status
            };
        }
        if self.status_due && self.since_status >= RATION {
            return Kind::Status;
        }
        if self.since_text >= RATION && core::mem::take(&mut self.findings_due) {
            return Kind::Findings;
        }
        if self.since_text >= RATION
            && let Some(text) = self.texts.first_mut().and_then(Option::take)
        {
            self.texts.rotate_left(1);
            return Kind::Text(text);
        }
        if core::mem::take(&mut self.abilities_due) {
            return Kind::Abilities;
        }
        if let Some(song) = self.song.take() {
            return Kind::Song(song);
        }
        self.parameters.take().map_or(Kind::State, Kind::Parameter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::String;

    fn letters(lines: usize, mut before_each: impl FnMut(&mut Schedule, usize)) -> String {
        let mut schedule = Schedule::default();
        (0..lines)
            .map(|line| {
                before_each(&mut schedule, line);
                match schedule.next_kind() {
                    Kind::State => 'A',
                    Kind::Status => 'B',
                    Kind::Counters => 'C',
                    Kind::Text(_) | Kind::Findings => 'T',
                    Kind::Parameter(_) => 'P',
                    Kind::Song(_) => 'S',
                    Kind::Abilities => 'I',
                }
            })
            .collect()
    }

    #[test]
    fn five_of_six_lines_are_line_a_and_the_sixth_alternates() {
        let order = letters(27, |_, _| {});
        assert_eq!(order, "CBAAAAABAAAAACAAAAABAAAAACA");
    }

    #[test]
    fn change_adds_a_line_b_at_most_once_a_second() {
        let once = letters(14, |schedule, line| {
            if line == 4 {
                schedule.queue_status();
            }
        });
        assert_eq!(once, "CBAABAAABAAAAA");
        let always = letters(400, |schedule, _| schedule.queue_status());
        assert!(
            !always.contains("BAB") && always.contains("BAAB"),
            "{always}"
        );
    }

    #[test]
    fn line_a_follows_every_other_line() {
        let order = letters(400, |schedule, line| {
            schedule.queue_status();
            if line % 2 == 0 {
                schedule.queue_text("x");
            }
            if line % 3 == 0 {
                schedule.queue_findings();
            }
        });
        let after_boot = order.get(1..).unwrap_or_default();
        for pair in ["BB", "BC", "BT", "CB", "CT", "TB", "TC", "TT"] {
            assert!(!after_boot.contains(pair), "{pair} in {after_boot}");
        }
        assert!(["T", "B", "C"].iter().all(|kind| after_boot.contains(kind)));
    }

    #[test]
    fn every_parameter_is_reported_and_line_a_keeps_every_second_slot() {
        let order = letters(70, |schedule, line| {
            if line == 3 {
                for &parameter in Parameter::ALL {
                    schedule.queue_parameter(parameter);
                }
                schedule.queue_song(Song::Finished);
            }
        });
        let count = |kind| order.chars().filter(|&letter| letter == kind).count();
        assert_eq!(count('P'), Parameter::ALL.len(), "{order}");
        assert_eq!(count('S'), 1, "{order}");
        assert!(order.starts_with("CBASAPAPA"), "{order}");
        assert!(
            count('A') >= 34 && count('B') >= 3 && count('C') >= 3,
            "{order}"
        );
        let after_boot = order.get(2..).unwrap_or_default();
        assert!(
            !after_boot.contains("PP") && !after_boot.contains("BP"),
            "{order}"
        );
    }

    #[test]
    fn texts_are_sent_in_order_and_excess_ones_are_dropped() {
        let mut schedule = Schedule::default();
        for text in ["1", "2", "3", "4", "5"] {
            schedule.queue_text(text);
        }
        let mut said = String::new();
        for _ in 0..100 {
            if let Kind::Text(text) = schedule.next_kind() {
                said.push_str(text);
            }
        }
        assert_eq!(said, "1234");
    }
}
