//! Plays a timeline under the operator's controls; the host's time is a parameter.

mod marks;

use super::control::{Control, Landmark, Playback, Position, SPEED_MAX, SPEED_MIN, clock_words};
use super::cursor::Cursor;
use super::search::Found;
use super::target::Target;
use super::timeline::{STEPS_MAX, Timeline};
use crate::event::{Level, Moment};
use crate::model::Facts;
use marks::Marks;

/// Minimum time between two updates of the screen.
const FASTEST: Moment = Moment::from_millis(40);

/// Maximum time between two updates of the screen during playback.
const SLOWEST: Moment = Moment::from_secs(1);

const DAY: Moment = Moment::from_hours(24);

/// Plays a capture or the past of a live session.
pub struct Player<C: Cursor> {
    timeline: Timeline<C>,
    is_live: bool,
    paused: bool,
    speed: f64,
    /// The displayed moment, and the host's time at which it was displayed.
    at: Moment,
    set_at: Moment,
    from: Moment,
    until: Moment,
    unix: Option<Moment>,
    /// Time up to which the timeline has been read; `None` if read completely.
    read_until: Option<Moment>,
    marks: Marks,
    repeat: Option<(Moment, Option<Moment>)>,
    note: Option<(Level, String)>,
    landmark: Landmark,
    /// A target that may lie in the unread part.
    target: Option<Target>,
    /// What led to the end of the capture, whose estimate may be corrected.
    ended_by: Option<EndedBy>,
}

/// What shows the end of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EndedBy {
    /// The operator wants the newest moment.
    Operator,
    /// The capture has been played to it.
    Playing,
}

impl<C: Cursor> Player<C> {
    /// Plays a capture from its beginning.
    #[must_use]
    pub fn of_capture(
        timeline: Timeline<C>,
        host: Moment,
        speed: f64,
        length: Moment,
        unix: Option<Moment>,
    ) -> Self {
        Self {
            timeline,
            is_live: false,
            paused: false,
            speed,
            at: Moment::ZERO,
            set_at: host,
            from: Moment::ZERO,
            until: length,
            unix,
            read_until: Some(Moment::ZERO),
            marks: Marks::default(),
            repeat: None,
            note: None,
            landmark: Landmark::Alarm,
            target: None,
            ended_by: None,
        }
    }

    /// Plays the past of a live session that began `unix` after 1970; begins at the newest moment.
    #[must_use]
    pub fn of_session(timeline: Timeline<C>, unix: Option<Moment>) -> Self {
        Self {
            is_live: true,
            paused: true,
            read_until: None,
            ..Self::of_capture(timeline, Moment::ZERO, 1.0, Moment::ZERO, unix)
        }
    }

    /// The facts at the displayed moment.
    #[must_use]
    pub fn facts(&self) -> &Facts {
        self.timeline.facts()
    }

    /// The timeline of the moments that can be shown.
    #[must_use]
    pub const fn timeline(&self) -> &Timeline<C> {
        &self.timeline
    }

    /// The timeline of the moments that can be shown.
    pub const fn timeline_mut(&mut self) -> &mut Timeline<C> {
        &mut self.timeline
    }

    /// The displayed moment.
    #[must_use]
    pub const fn at(&self) -> Moment {
        self.at
    }

    /// Whether the displayed moment is the newest.
    #[must_use]
    pub fn is_at_end(&self) -> bool {
        self.at >= self.until
    }

    /// Whether playback is paused.
    #[must_use]
    pub const fn is_paused(&self) -> bool {
        self.paused
    }

    /// Goes to the newest moment and pauses.
    pub fn rest(&mut self) {
        self.paused = true;
        self.speed = 1.0;
        self.repeat = None;
        self.at = self.until;
    }

    /// Sets the time span that can be shown.
    pub fn set_span(&mut self, from: Moment, until: Moment) {
        (self.from, self.until) = (from, until);
        self.marks.begin_at(from);
    }

    /// Sets the marks of the recording; the operator's marks are kept.
    pub fn set_recorded_marks(&mut self, marks: Vec<Moment>) {
        self.marks.set_recorded(marks);
    }

    /// Adds the text of a mark, and the mark if there is none yet.
    pub fn add_noted_mark(&mut self, at: Moment, text: String) {
        self.marks.add_text(at, text);
    }

    /// Whether the capture itself has a mark at a moment.
    #[must_use]
    pub fn is_recorded_mark(&self, at: Moment) -> bool {
        self.marks.is_recorded(at)
    }

    /// The mark set (`true`) or removed (`false`) since the last call.
    pub const fn take_marked(&mut self) -> Option<(Moment, bool)> {
        self.marks.take_changed()
    }

    /// Takes the progress of reading: the capture has been read up to a moment. Continues a search.
    pub fn set_read(&mut self, until: Moment) {
        self.read_until = Some(until);
        self.look_on();
    }

    /// Takes the end of reading: the capture has been read completely.
    pub fn set_read_through(&mut self, end: Moment) {
        self.read_until = None;
        self.until = end;
        self.timeline.complete();
        match self.ended_by {
            Some(EndedBy::Operator) if self.at < end => self.go(end),
            Some(EndedBy::Playing) if self.at < end => self.paused = false,
            _ => {}
        }
        self.at = self.at.min(end);
        self.look_on();
    }

    /// Advances to the host's time; returns whether the screen has changed.
    pub fn advance(&mut self, host: Moment) -> bool {
        if self.paused {
            return false;
        }
        if self
            .ended_by
            .take_if(|by| *by == EndedBy::Playing)
            .is_some()
        {
            // The wait at the estimated end is no time of the capture.
            self.set_at = host;
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
            self.ended_by.get_or_insert(EndedBy::Playing);
        }
        self.timeline.run_to(to);
        self.at = to;
        true
    }

    /// Time of the next call of [`Self::advance`], in the host's time: the next step, or the next second of the clock on the
    /// screen.
    pub fn wake_at(&mut self) -> Option<Moment> {
        if self.paused {
            return None;
        }
        let next = self.timeline.next_at().unwrap_or(Moment::MAX);
        let tick = Moment::from_secs(self.at.as_secs() + 1);
        let mut next = next.min(tick).min(self.until);
        if let Some((_, Some(end))) = self.repeat {
            next = next.min(end.max(self.at));
        }
        let wait = next.saturating_sub(self.at).div_f64(self.speed);
        Some(self.set_at + wait.clamp(FASTEST, SLOWEST))
    }

    /// Carries out a control.
    pub fn handle(&mut self, host: Moment, control: Control) {
        self.advance(host);
        self.set_at = host;
        self.note = None;
        self.target = None;
        self.ended_by = (control == Control::Newest).then_some(EndedBy::Operator);
        self.timeline.stop_search();
        match control {
            Control::TogglePause => {
                self.paused = !self.paused;
                if !self.paused && !self.is_live && self.is_at_end() {
                    self.go(self.from);
                }
            }
            Control::Speed(speed) if speed.is_finite() => {
                self.speed = speed.clamp(SPEED_MIN, SPEED_MAX);
            }
            Control::Step { forward } => self.step(forward),
            Control::Seek(target) => self.seek(target),
            Control::Jump { to, forward } => {
                self.landmark = to.unwrap_or(self.landmark);
                self.jump(forward);
            }
            Control::Mark(at) => self.note = Some(self.marks.toggle(at)),
            Control::Loop => self.set_loop(),
            // A speed that is not finite is ignored; any other control also ends the search.
            Control::Speed(_) | Control::StopSearch => {}
            Control::Newest => self.go(self.until),
            Control::Oldest => self.go(self.from),
        }
    }

    /// Executes a control as [`Self::handle`] does, from the newest moment of a live session; returns whether another moment is displayed. If not, the
    /// message gives the reason.
    pub fn leave_newest(&mut self, host: Moment, control: Control) -> bool {
        self.rest();
        self.handle(host, Control::Newest);
        self.handle(host, control);
        let is_there = match control {
            Control::Jump { .. } | Control::Step { .. } => {
                !matches!(self.note, Some((Level::Warning, _)))
            }
            Control::Seek(_) if self.is_at_end() => {
                if self.note.is_none() {
                    self.warn("the present is the newest moment".to_owned());
                }
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
        self.timeline.seek(at);
        self.at = at;
    }

    fn step(&mut self, forward: bool) {
        self.paused = true;
        let found = if forward {
            self.timeline.step_forward()
        } else {
            self.timeline.step_back()
        };
        match found {
            Found::At(_) => self.at = self.timeline.at().min(self.until),
            Found::Nowhere => {
                let end = if forward { "last" } else { "first" };
                self.warn(format!("this is the {end} line"));
            }
            Found::NotYet => {
                let target = Target::Landmark {
                    landmark: Landmark::Line,
                    from: self.at,
                    forward,
                };
                self.look_for(target, STEPS_MAX);
            }
        }
    }

    fn seek(&mut self, target: Position) {
        match target {
            Position::At(at) => self.go(at),
            Position::Ahead(span) => self.go(self.at.saturating_add(span)),
            Position::Back(span) => self.go(self.at.saturating_sub(span)),
            Position::Percent(percent) => {
                let span = self.until.saturating_sub(self.from);
                self.go(self.from + span.mul_f64(percent / 100.0));
            }
            Position::Line(number) => self.look_for(Target::Line(number), STEPS_MAX),
            Position::Utc(since_midnight) => match self.moment_of_utc(since_midnight) {
                Some(at) => self.go(at),
                None => self.warn("that time of day is not in the capture".to_owned()),
            },
        }
    }

    /// The moment with a time of day: on the displayed day, else on the first day that contains it.
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
        let target = Target::Landmark {
            landmark: self.landmark,
            from: self.at,
            forward,
        };
        self.look_for(target, STEPS_MAX);
    }

    /// Continues a search in the part read since.
    fn look_on(&mut self) {
        if let Some(target) = self.target.take() {
            self.look_for(target, 0);
        }
    }

    /// Goes to a target and pauses there; waits if the target may be in the unread part.
    fn look_for(&mut self, target: Target, beyond: usize) {
        let found = self.find(target, beyond);
        self.arrive(target, found);
        if let (Target::Line(number), Found::NotYet, 1..) = (target, found, beyond)
            && let Some(at) = self.timeline.seek_about_line(number)
        {
            self.at = at.min(self.until);
        }
    }

    fn arrive(&mut self, target: Target, found: Found) {
        self.target = None;
        match found {
            Found::At(at) => {
                self.paused = true;
                match target {
                    // The timeline is at this line, which may be one of several at the same moment.
                    Target::Line(_) => self.at = at.min(self.until),
                    Target::Landmark { .. } => self.go(at),
                }
                if let Target::Landmark {
                    landmark: Landmark::Marker,
                    ..
                } = target
                {
                    let text = self.marks.text_at(at);
                    self.note = (!text.is_empty()).then(|| (Level::Info, format!("mark: {text}")));
                }
            }
            Found::Nowhere => self.warn(target.not_found()),
            Found::NotYet => {
                self.paused = true;
                self.target = Some(target);
            }
        }
    }

    /// Whether [`Self::work`] must be called.
    #[must_use]
    pub const fn has_work(&self) -> bool {
        self.timeline.has_work()
    }

    /// Continues a search, or completes the displayed state, in at most `steps` steps; returns whether the screen changes.
    pub fn work(&mut self, steps: usize) -> bool {
        if self.timeline.is_searching() {
            let found = self.timeline.search(steps);
            let target = self.target.filter(|_| found != Found::NotYet);
            if let Some(target) = target {
                self.arrive(target, found);
            }
            return target.is_some();
        }
        let is_whole = self.timeline.work(steps);
        if let Some(target @ Target::Line(_)) = self.target.filter(|_| is_whole) {
            // The number of the displayed line is now known, and may differ from the estimate.
            let found = self.find(target, STEPS_MAX);
            self.arrive(target, found);
        }
        is_whole
    }

    fn find(&mut self, target: Target, beyond: usize) -> Found {
        let (landmark, from, forward) = match target {
            Target::Line(number) => return self.timeline.seek_line(number, beyond),
            Target::Landmark {
                landmark,
                from,
                forward,
            } => (landmark, from, forward),
        };
        match (landmark, forward) {
            (Landmark::Marker, _) => {
                let mark = self.marks.beside(from, forward);
                mark.map_or(Found::Nowhere, Found::At)
            }
            (landmark, true) => self.timeline.find_next(landmark, from, beyond),
            (landmark, false) => self.timeline.find_last(landmark, from, beyond),
        }
    }

    /// The progress of the search as text.
    fn progress(&self) -> Option<String> {
        let target = self.target?;
        let read = clock_words(self.read_until.unwrap_or(self.until));
        let until = clock_words(self.until);
        Some(match target {
            Target::Line(_) if self.timeline.is_partial() => {
                format!("about {target}: it is not read up to here yet; <close> stays here")
            }
            _ => format!("looking for {target}: read up to {read} of {until}; <close> gives up"),
        })
    }

    fn set_loop(&mut self) {
        let at = clock_words(self.at);
        match self.repeat {
            None => {
                self.repeat = Some((self.at, None));
                self.tell(format!(
                    "the loop begins at {at}; <playback-loop> where it ends"
                ));
            }
            Some((begin, None)) if self.at > begin => {
                self.repeat = Some((begin, Some(self.at)));
                let begins = clock_words(begin);
                self.tell(format!(
                    "loops from {begins} to {at}; <playback-loop> ends that"
                ));
            }
            Some((_, None)) => self.warn("a loop ends later than it begins".to_owned()),
            Some((_, Some(_))) => {
                self.repeat = None;
                self.tell("no loop any more".to_owned());
            }
        }
    }

    fn tell(&mut self, text: String) {
        self.note = Some((Level::Info, text));
    }

    fn warn(&mut self, text: String) {
        self.note = Some((Level::Warning, text));
    }

    /// State of playback.
    #[must_use]
    pub fn playback(&self) -> Playback {
        let progress = self.progress().map(|text| (Level::Info, text));
        let note = progress.or_else(|| self.note.clone());
        Playback {
            is_live: self.is_live,
            paused: self.paused,
            speed: self.speed,
            at: self.at,
            from: self.from,
            until: self.until,
            unix: self.unix,
            line: self.timeline.line(),
            read_until: self.read_until,
            is_partial: self.timeline.is_partial(),
            markers: self.marks.shown().to_vec(),
            repeat: self.repeat,
            is_looking: self.target.is_some(),
            note: note.map(|(level, text)| (level, self.facts().config().keys.with_keys(&text))),
        }
    }
}
