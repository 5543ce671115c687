//! Which line is next.
//!
//! Five slots of six are line A; the sixth is line B and line C in turn. After boot come C and B. A
//! change of what line B says brings an extra B, and text an extra T; both are rationed, and after
//! any other line there is always a line A.

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
}

/// Lines A between two regular lines of another kind.
const STATES_PER_OTHER: u8 = 5;

/// Least distance of two lines of the same kind, in lines: a second.
const RATION: u8 = 3;

/// Texts that wait; more are dropped, oldest first to go out.
const TEXTS: usize = 4;

/// The order of lines.
#[derive(Clone, Debug)]
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
        }
    }
}

impl Schedule {
    /// Line B would say something new.
    pub const fn status_changed(&mut self) {
        self.status_due = true;
    }

    /// Queues a text; it is lost when too many wait.
    pub fn say(&mut self, text: &'static str) {
        if let Some(slot) = self.texts.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(text);
        }
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
            Kind::Text(_) => self.since_text = 0,
            Kind::Counters => {}
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
        if self.states >= STATES_PER_OTHER {
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
        if self.since_text >= RATION
            && let Some(text) = self.texts.first_mut().and_then(Option::take)
        {
            self.texts.rotate_left(1);
            return Kind::Text(text);
        }
        Kind::State
    }
}
