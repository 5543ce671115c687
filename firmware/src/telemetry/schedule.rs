//! Which line is next.
//!
//! Five slots of six are line A; the sixth is line B and line C in turn. After boot come C and B. A
//! change of what line B says brings an extra B, and text an extra T; both are rationed. A song brings
//! a line S, and what the ground asked for lines P. After any other line there is always a line A.

use super::due::Due;
use crate::parameters::Parameter;
use crate::song::Song;

/// What kind of line.
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
    /// Line T with what a look around has found.
    Findings,
    /// Line P.
    Parameter(Parameter),
    /// Line S.
    Song(Song),
}

/// Lines A between two regular lines of another kind.
const STATES_PER_OTHER: u8 = 5;

/// Least distance of two lines of the same kind, in lines: a second.
const RATION: u8 = 3;

/// Texts that wait; more are dropped, oldest first to go out.
const TEXTS: usize = 4;

/// The order of lines.
#[derive(Clone, Debug)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is due or not by itself"
)]
pub struct Schedule {
    /// Lines sent since boot, up to the two that are special.
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
    parameters: Due,
}

impl Default for Schedule {
    fn default() -> Self {
        Self {
            begun: 0,
            states: 0,
            previous_was_state: true,
            counters_turn: true,
            status_due: false,
            since_status: RATION,
            since_text: RATION,
            texts: [None; TEXTS],
            findings_due: false,
            song: None,
            parameters: Due::default(),
        }
    }
}

impl Schedule {
    /// Line B would say something new.
    pub const fn status_changed(&mut self) {
        self.status_due = true;
    }

    /// A look around has found something to tell; the latest one is told.
    pub const fn say_findings(&mut self) {
        self.findings_due = true;
    }

    /// Queues a text; it is lost when too many wait.
    pub fn say(&mut self, text: &'static str) {
        if let Some(slot) = self.texts.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(text);
        }
    }

    /// A song has begun; one that has not been told of yet is over.
    pub const fn sing(&mut self, song: Song) {
        self.song = Some(song);
    }

    /// The ground shall hear of this parameter.
    pub fn tell(&mut self, parameter: Parameter) {
        self.parameters.add(parameter);
    }

    /// What is next.
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
            Kind::Counters | Kind::Parameter(_) | Kind::Song(_) => {}
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
        // Line B and line C in turn; a line B that has just been sent for a change is not sent again.
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
                }
            })
            .collect()
    }

    #[test]
    fn five_of_six_are_line_a_and_the_sixth_alternates() {
        let order = letters(27, |_, _| {});
        assert_eq!(order, "CBAAAAABAAAAACAAAAABAAAAACA");
    }

    #[test]
    fn a_change_brings_a_line_b_at_once_but_not_twice_a_second() {
        let once = letters(14, |schedule, line| {
            if line == 4 {
                schedule.status_changed();
            }
        });
        assert_eq!(once, "CBAABAAABAAAAA");
        let always = letters(400, |schedule, _| schedule.status_changed());
        assert!(
            !always.contains("BAB") && always.contains("BAAB"),
            "{always}"
        );
    }

    #[test]
    fn whatever_happens_a_line_a_follows_every_other_line() {
        let order = letters(400, |schedule, line| {
            schedule.status_changed();
            if line % 2 == 0 {
                schedule.say("x");
            }
            if line % 3 == 0 {
                schedule.say_findings();
            }
        });
        let after_boot = order.get(1..).unwrap_or_default();
        for pair in ["BB", "BC", "BT", "CB", "CT", "TB", "TC", "TT"] {
            assert!(!after_boot.contains(pair), "{pair} in {after_boot}");
        }
        assert!(["T", "B", "C"].iter().all(|kind| after_boot.contains(kind)));
    }

    #[test]
    fn every_parameter_is_told_and_line_a_keeps_every_second_slot() {
        let order = letters(70, |schedule, line| {
            if line == 3 {
                for &parameter in Parameter::ALL {
                    schedule.tell(parameter);
                }
                schedule.sing(Song::Finished);
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
    fn texts_go_out_in_order_and_too_many_are_dropped() {
        let mut schedule = Schedule::default();
        for text in ["1", "2", "3", "4", "5"] {
            schedule.say(text);
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
