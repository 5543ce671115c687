//! Lets time pass in a reel and obeys the operator. The host's time is a parameter.

use super::quest::Quest;
use super::reel::{Cursor, Found, Reel, STEPS_MAX};
use crate::event::Moment;
use crate::model::Facts;
use crate::travel::{
    Landmark, MARKER_REACH, MARKERS_MAX, Playback, SPEED_MAX, SPEED_MIN, Target, Travel,
    clock_words,
};

/// The screen is brought up to date no more often than this, and no less often than [`SLOWEST`] while time
/// passes.
const FASTEST: Moment = Moment::from_millis(40);

const SLOWEST: Moment = Moment::from_secs(1);

const DAY: Moment = Moment::from_hours(24);

/// Plays a reel.
pub struct Player<C: Cursor> {
    reel: Reel<C>,
    is_live: bool,
    paused: bool,
    speed: f64,
    /// The moment shown, and the host's time then.
    at: Moment,
    set_at: Moment,
    from: Moment,
    until: Moment,
    unix: Option<Moment>,
    /// While the reel is not complete: how far it goes.
    read_until: Option<Moment>,
    markers: Vec<Moment>,
    /// Those of them that came with the capture.
    recorded: Vec<Moment>,
    /// A moment that was marked just now, or is not any more.
    marked: Option<(Moment, bool)>,
    repeat: Option<(Moment, Option<Moment>)>,
    note: Option<String>,
    sought: Landmark,
    /// What was asked for and may lie where nobody has read yet.
    quest: Option<Quest>,
}

impl<C: Cursor> Player<C> {
    /// Plays a capture from its beginning.
    #[must_use]
    pub const fn of_capture(
        reel: Reel<C>,
        host: Moment,
        speed: f64,
        length: Moment,
        unix: Option<Moment>,
    ) -> Self {
        Self {
            reel,
            is_live: false,
            paused: false,
            speed,
            at: Moment::ZERO,
            set_at: host,
            from: Moment::ZERO,
            until: length,
            unix,
            read_until: Some(Moment::ZERO),
            markers: Vec::new(),
            recorded: Vec::new(),
            marked: None,
            repeat: None,
            note: None,
            sought: Landmark::Alarm,
            quest: None,
        }
    }

    /// Shows what was in a live session, of which the beginning was at a time of day; it stands at its
    /// newest moment until told otherwise.
    #[must_use]
    pub fn of_session(mut reel: Reel<C>, unix: Option<Moment>) -> Self {
        reel.complete();
        Self {
            is_live: true,
            paused: true,
            read_until: None,
            ..Self::of_capture(reel, Moment::ZERO, 1.0, Moment::ZERO, unix)
        }
    }

    /// What is known at the moment shown.
    #[must_use]
    pub fn facts(&self) -> &Facts {
        self.reel.facts()
    }

    /// What is played.
    #[must_use]
    pub const fn reel(&self) -> &Reel<C> {
        &self.reel
    }

    /// What is played.
    pub const fn reel_mut(&mut self) -> &mut Reel<C> {
        &mut self.reel
    }

    /// The moment shown.
    #[must_use]
    pub const fn at(&self) -> Moment {
        self.at
    }

    /// Whether it stands at the newest moment.
    #[must_use]
    pub fn is_at_end(&self) -> bool {
        self.at >= self.until
    }

    /// Whether time stands still.
    #[must_use]
    pub const fn is_paused(&self) -> bool {
        self.paused
    }

    /// Goes to the newest moment and stands still there.
    pub fn rest(&mut self) {
        self.paused = true;
        self.speed = 1.0;
        self.repeat = None;
        self.at = self.until;
    }

    /// What can be shown begins and ends then.
    pub fn set_span(&mut self, from: Moment, until: Moment) {
        (self.from, self.until) = (from, until);
        self.markers.retain(|marker| *marker >= from);
    }

    /// Moments that were marked when the capture was made; the operator's own stay.
    pub fn set_recorded_marks(&mut self, marks: Vec<Moment>) {
        let before = std::mem::replace(&mut self.recorded, marks);
        let recorded = &self.recorded;
        self.markers
            .retain(|marker| !before.contains(marker) || recorded.contains(marker));
        let fresh = recorded.iter().filter(|mark| !before.contains(mark));
        self.markers.extend(fresh);
        self.markers.sort_unstable();
        self.markers.dedup();
    }

    /// The moment that was marked since this was asked last, and whether it is now, or is not any more.
    pub const fn take_marked(&mut self) -> Option<(Moment, bool)> {
        self.marked.take()
    }

    /// The capture has been read so far, and the reel has its states; what is looked for may be among them.
    pub fn set_read(&mut self, until: Moment) {
        self.read_until = Some(until);
        self.look_on();
    }

    /// The capture has been read to its end.
    pub fn set_read_through(&mut self, end: Moment) {
        self.read_until = None;
        self.until = end;
        self.reel.complete();
        if self.at > end {
            self.at = end;
        }
        self.look_on();
    }

    /// Lets time pass until the host's time; says whether anything on the screen changed.
    pub fn advance(&mut self, host: Moment) -> bool {
        if self.paused {
            return false;
        }
        let passed = host.saturating_sub(self.set_at).mul_f64(self.speed);
        let mut to = self.at.saturating_add(passed);
        self.set_at = host;
        if let Some((begin, Some(end))) = self.repeat
            && self.at <= end
            && to > end
        {
            let length = end.saturating_sub(begin).max(FASTEST);
            let over = to.saturating_sub(end).as_nanos() % length.as_nanos();
            self.go(begin + Moment::from_nanos(over as u64));
            return true;
        }
        if to >= self.until {
            to = self.until;
            self.paused = true;
        }
        self.reel.run_to(to);
        self.at = to;
        true
    }

    /// When, in the host's time, to let time pass again: when something happens, or the clock on the
    /// screen goes on.
    pub fn wake_at(&mut self) -> Option<Moment> {
        if self.paused {
            return None;
        }
        let next = self.reel.next_at().unwrap_or(Moment::MAX);
        let tick = Moment::from_secs(self.at.as_secs() + 1);
        let mut next = next.min(tick).min(self.until);
        if let Some((_, Some(end))) = self.repeat {
            next = next.min(end.max(self.at));
        }
        let wait = next.saturating_sub(self.at).div_f64(self.speed);
        Some(self.set_at + wait.clamp(FASTEST, SLOWEST))
    }

    /// Does what the operator asks for.
    pub fn handle(&mut self, host: Moment, travel: Travel) {
        self.advance(host);
        self.set_at = host;
        self.note = None;
        self.quest = None;
        self.reel.give_up();
        match travel {
            Travel::TogglePause => {
                self.paused = !self.paused;
                if !self.paused && !self.is_live && self.is_at_end() {
                    self.go(self.from);
                }
            }
            Travel::Speed(speed) if speed.is_finite() => {
                self.speed = speed.clamp(SPEED_MIN, SPEED_MAX);
            }
            Travel::Step { forward } => self.step(forward),
            Travel::Seek(target) => self.seek(target),
            Travel::Jump { to, forward } => {
                self.sought = to.unwrap_or(self.sought);
                self.jump(forward);
            }
            Travel::Mark => self.mark(),
            Travel::Loop => self.set_loop(),
            // No such speed; and a quest is given up by whatever is done.
            Travel::Speed(_) | Travel::GiveUp => {}
            Travel::Newest => self.go(self.until),
            Travel::Oldest => self.go(self.from),
        }
    }

    /// As [`Self::handle`], at the newest moment of a live session; says whether another moment is shown for it.
    /// Where nothing is found the note tells, and the session goes on.
    pub fn leave_newest(&mut self, host: Moment, travel: Travel) -> bool {
        self.rest();
        self.handle(host, Travel::Newest);
        self.handle(host, travel);
        let is_there = match travel {
            Travel::Jump { .. } | Travel::Step { .. } => self.note.is_none(),
            Travel::Seek(_) if self.is_at_end() => {
                self.note
                    .get_or_insert_with(|| "it goes no further than now".to_owned());
                false
            }
            _ => true,
        };
        if !is_there {
            self.rest();
        }
        is_there
    }

    fn go(&mut self, at: Moment) {
        let at = at.clamp(self.from, self.until.max(self.from));
        self.reel.seek(at);
        self.at = at;
    }

    fn step(&mut self, forward: bool) {
        self.paused = true;
        let is_there = if forward {
            self.reel.step_forward()
        } else {
            self.reel.step_back()
        };
        if is_there {
            self.at = self.reel.at().min(self.until);
        } else {
            let end = if forward { "last" } else { "first" };
            self.note = Some(format!("this is the {end} line"));
        }
    }

    fn seek(&mut self, target: Target) {
        match target {
            Target::At(at) => self.go(at),
            Target::Ahead(span) => self.go(self.at.saturating_add(span)),
            Target::Back(span) => self.go(self.at.saturating_sub(span)),
            Target::Percent(percent) => {
                let span = self.until.saturating_sub(self.from);
                self.go(self.from + span.mul_f64(percent / 100.0));
            }
            Target::Packet(number) => self.look_for(Quest::Packet(number), STEPS_MAX),
            Target::Utc(since_midnight) => match self.moment_of_utc(since_midnight) {
                Some(at) => self.go(at),
                None => self.note = Some("it does not reach to that time of day".to_owned()),
            },
        }
    }

    /// The time of day on the day shown, else on the first day that has it.
    fn moment_of_utc(&mut self, since_midnight: Moment) -> Option<Moment> {
        let unix = self.unix?;
        let midnight = |at: Moment| Moment::from_secs(at.as_secs() / DAY.as_secs() * DAY.as_secs());
        let today = midnight(unix + self.at) + since_midnight;
        let first = midnight(unix + self.from) + since_midnight;
        [today, first, first + DAY]
            .into_iter()
            .filter_map(|at| at.checked_sub(unix))
            .find(|at| (self.from..=self.until).contains(at))
    }

    fn jump(&mut self, forward: bool) {
        let quest = Quest::Landmark {
            sought: self.sought,
            from: self.at,
            forward,
        };
        self.look_for(quest, STEPS_MAX);
    }

    /// More has been read: looks there.
    fn look_on(&mut self) {
        if let Some(quest) = self.quest.take() {
            self.look_for(quest, 0);
        }
    }

    /// Goes to what is looked for and stands still there; what may lie where nobody has read yet is waited for.
    fn look_for(&mut self, quest: Quest, beyond: usize) {
        let found = self.find(quest, beyond);
        self.arrive(quest, found);
        if let (Quest::Packet(number), Found::NotYet, 1..) = (quest, found, beyond)
            && let Some(at) = self.reel.seek_about_line(number)
        {
            self.at = at.min(self.until);
        }
    }

    fn arrive(&mut self, quest: Quest, found: Found) {
        self.quest = None;
        match found {
            Found::At(at) => {
                self.paused = true;
                match quest {
                    // The reel is there, which may be one of several lines of that moment.
                    Quest::Packet(_) => self.at = at.min(self.until),
                    Quest::Landmark { .. } => self.go(at),
                }
            }
            Found::Nowhere => self.note = Some(quest.nowhere()),
            Found::NotYet => {
                self.paused = true;
                self.quest = Some(quest);
            }
        }
    }

    /// Whether there is something to do for [`Self::work`].
    #[must_use]
    pub const fn has_work(&self) -> bool {
        self.reel.is_partial() || self.reel.is_hunting()
    }

    /// Works on what is looked for, or on what is missing from the moment shown, for so many things; says whether anything
    /// on the screen changed.
    pub fn work(&mut self, steps: usize) -> bool {
        if self.reel.is_hunting() {
            let found = self.reel.hunt(steps);
            let quest = self.quest.filter(|_| found != Found::NotYet);
            if let Some(quest) = quest {
                self.arrive(quest, found);
            }
            return quest.is_some();
        }
        let is_whole = self.reel.work(steps);
        if let Some(quest @ Quest::Packet(_)) = self.quest.filter(|_| is_whole) {
            // Which line is shown is known; it may be another one than was asked for.
            let found = self.find(quest, STEPS_MAX);
            self.arrive(quest, found);
        }
        is_whole
    }

    fn find(&mut self, quest: Quest, beyond: usize) -> Found {
        let (landmark, from, forward) = match quest {
            Quest::Packet(number) => return self.reel.seek_line(number, beyond),
            Quest::Landmark {
                sought,
                from,
                forward,
            } => (sought, from, forward),
        };
        match (landmark, forward) {
            (Landmark::Marker, true) => {
                let next = self.markers.iter().find(|marker| **marker > from);
                next.map_or(Found::Nowhere, |at| Found::At(*at))
            }
            (Landmark::Marker, false) => {
                let last = self.markers.iter().rev().find(|marker| **marker < from);
                last.map_or(Found::Nowhere, |at| Found::At(*at))
            }
            (landmark, true) => self.reel.find_next(landmark, from, beyond),
            (landmark, false) => self.reel.find_last(landmark, from, beyond),
        }
    }

    /// How far the search is, if there is one.
    fn progress(&self) -> Option<String> {
        let quest = self.quest?;
        let read = clock_words(self.read_until.unwrap_or(self.until));
        let until = clock_words(self.until);
        Some(match quest {
            Quest::Packet(_) if self.reel.is_partial() => {
                format!("about {quest}: it is not read up to here yet; <close> stays here")
            }
            _ => format!("looking for {quest}: read up to {read} of {until}; <close> gives up"),
        })
    }

    fn mark(&mut self) {
        let near = |marker: &Moment| marker.abs_diff(self.at) < MARKER_REACH;
        let marked = clock_words(self.at);
        if let Some(place) = self.markers.iter().position(near) {
            self.marked = Some((self.markers.remove(place), false));
            self.note = Some(format!("the mark at {marked} is gone"));
        } else if self.markers.len() == MARKERS_MAX {
            self.note = Some(format!(
                "there are {MARKERS_MAX} marks already: <travel-mark> on one takes it away"
            ));
        } else {
            let place = self.markers.partition_point(|marker| *marker < self.at);
            self.markers.insert(place, self.at);
            self.marked = Some((self.at, true));
            let (next, last) = ("<ask-jump-forward>", "<ask-jump-back>");
            let mark = "<jump/jump-to-marker>";
            self.note = Some(format!(
                "marked {marked}; {next} {mark} and {last} {mark} go to marks"
            ));
        }
    }

    fn set_loop(&mut self) {
        let at = clock_words(self.at);
        (self.repeat, self.note) = match self.repeat {
            None => (
                Some((self.at, None)),
                Some(format!(
                    "the loop begins at {at}; <travel-loop> where it ends"
                )),
            ),
            Some((begin, None)) if self.at > begin => {
                let begins = clock_words(begin);
                let note = format!("loops from {begins} to {at}; <travel-loop> ends that");
                (Some((begin, Some(self.at))), Some(note))
            }
            Some((begin, None)) => (
                Some((begin, None)),
                Some("a loop ends later than it begins".to_owned()),
            ),
            Some((_, Some(_))) => (None, Some("no loop any more".to_owned())),
        };
    }

    /// Where the screen stands.
    #[must_use]
    pub fn playback(&self) -> Playback {
        let note = self.progress().or_else(|| self.note.clone());
        Playback {
            is_live: self.is_live,
            paused: self.paused,
            speed: self.speed,
            at: self.at,
            from: self.from,
            until: self.until,
            unix: self.unix,
            packet: self.reel.packet(),
            read_until: self.read_until,
            is_partial: self.reel.is_partial(),
            markers: self.markers.clone(),
            repeat: self.repeat,
            is_looking: self.quest.is_some(),
            note: note.map(|note| self.facts().config().keys.told(&note)),
        }
    }
}
