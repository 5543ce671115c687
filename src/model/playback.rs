//! Keys that change the displayed moment, and commands given while the screen shows the past.

use groundwave_protocol::status_codes::Mode;

use super::drive::Stick;
use super::keys::Action;
use super::keys::RouteAction;
use super::ui::{Overlay, Question, Then};
use super::{Facts, Purpose, TextEntry, Ui, age};
use crate::event::{Effect, Level, Moment, Remark};
use crate::playback::{Control, MARK_REACH, Position, SPEED_MAX, SPEED_MIN};
use crate::request::Request;

/// Speeds that the keys select.
const SPEEDS: [f64; 14] = [
    SPEED_MIN, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 250.0, 500.0, SPEED_MAX,
];

/// Answer to a command in a capture.
pub(super) const NO_ROBOT: &str = "a capture has no robot: nothing is sent";

impl Ui {
    /// Whether the screen shows the past of a live session.
    pub(crate) fn shows_past(&self) -> bool {
        self.playback.as_ref().is_some_and(|p| p.is_live)
    }

    /// Whether the screen shows a capture.
    pub(crate) fn is_replay(&self) -> bool {
        self.playback.as_ref().is_some_and(|p| !p.is_live)
    }

    /// Whether a key's action works here: commands only on a link that can send, and only those that the robot understands; recording only
    /// where a robot is heard.
    pub(crate) fn offers(&self, facts: &Facts, action: Action) -> bool {
        let asks = action.asks_the_robot() && action != Action::AskCommand;
        let is_lacking = facts.link.is_receive_only() && asks
            || facts.link.has_only_own_lines() && action.needs_protocol()
            || self.is_replay() && action == Action::ToggleRecording;
        !is_lacking
    }

    /// Whether the unread part is being searched.
    pub(super) fn is_looking(&self) -> bool {
        self.playback.as_ref().is_some_and(|p| p.is_looking)
    }

    pub(super) fn act_on_time(&mut self, action: Action) -> Vec<Effect> {
        let travel = match (action, &self.overlay) {
            (Action::Playback(travel), _) => travel,
            (Action::Speed(steps), _) => return self.speed(steps),
            (Action::JumpTo(landmark), &Overlay::Jump { forward }) => {
                self.overlay = Overlay::None;
                Control::Jump {
                    to: Some(landmark),
                    forward,
                }
            }
            (Action::JumpAgain { forward }, _) => {
                self.overlay = Overlay::None;
                Control::Jump { to: None, forward }
            }
            _ => return Vec::new(),
        };
        vec![Effect::Playback(travel)]
    }

    fn speed(&self, steps: i8) -> Vec<Effect> {
        let Some(playback) = &self.playback else {
            return Vec::new();
        };
        let at = SPEEDS
            .iter()
            .position(|&speed| speed >= playback.speed)
            .unwrap_or(SPEEDS.len() - 1);
        SPEEDS
            .get(at.saturating_add_signed(isize::from(steps)))
            .map(|&speed| Effect::Playback(Control::Speed(speed)))
            .into_iter()
            .collect()
    }

    /// Asks for the text of a mark at this moment, which is set when the text is submitted.
    pub(super) fn mark(&mut self, now: Moment) -> Vec<Effect> {
        let playback = self.playback.as_ref();
        self.marked_at = playback.map_or(now, |playback| playback.at);
        self.overlay = Overlay::Text(TextEntry::new(Purpose::Mark));
        Vec::new()
    }

    /// Whether the moment to mark has a mark already.
    pub(crate) fn is_at_mark(&self) -> bool {
        self.playback.as_ref().is_some_and(|playback| {
            let mut marks = playback.markers.iter();
            marks.any(|mark| mark.abs_diff(self.marked_at) < MARK_REACH)
        })
    }

    /// Sets the mark and saves its text, if any: as a note to the capture, or only in the log without a capture. Without a text, a mark that is
    /// already there is removed.
    pub(super) fn set_mark(&mut self, facts: &Facts, now: Moment, text: &str) -> Vec<Effect> {
        let toggle = Effect::Playback(Control::Mark(self.marked_at));
        if text.is_empty() {
            return vec![toggle];
        }
        let mut effects = Vec::new();
        if !self.is_at_mark() {
            effects.push(toggle);
        }
        let remark = Remark::Note(text.to_owned());
        if let Some(capture) = self.capture_at_hand(facts) {
            effects.push(Effect::Label {
                capture: capture.clone(),
                remark,
                ago: now.saturating_sub(self.marked_at),
            });
        } else {
            self.note(Level::Info, remark.to_string());
        }
        effects
    }

    pub(super) fn submit_moment(&mut self, entry: TextEntry) -> Vec<Effect> {
        match entry.text.parse::<Position>() {
            Ok(target) => {
                self.overlay = Overlay::None;
                vec![Effect::Playback(Control::Seek(target))]
            }
            Err(error) => {
                self.overlay = Overlay::Text(TextEntry {
                    error: Some(error.to_string()),
                    ..entry
                });
                Vec::new()
            }
        }
    }

    /// Asks before a command that was given while the screen shows the past, because the command reaches the robot as it is
    /// now. STOP never asks.
    pub(super) fn ask_from_the_past(
        &mut self,
        action: Action,
        effects: Vec<Effect>,
    ) -> Vec<Effect> {
        if self.playback.is_none() {
            return effects;
        }
        let is_replay = self.is_replay();
        let (mut asked, mut rest) = (Vec::new(), Vec::new());
        let mut is_dropped = false;
        for effect in effects {
            match effect {
                Effect::Send(_) | Effect::CancelCommands if is_replay => {
                    self.aside = Some((Level::Warning, NO_ROBOT.to_owned()));
                    is_dropped = true;
                }
                Effect::Send(request) if request != Request::Stop => asked.push(request),
                other => {
                    if other == Effect::Send(Request::Stop) {
                        let aside =
                            "STOP is sent to the robot now; <playback-newest> shows its status";
                        self.aside = Some((Level::Warning, self.with_keys(aside)));
                    }
                    rest.push(other);
                }
            }
        }
        let sends_draft = matches!(action, Action::SendDraft | Action::Route(RouteAction::Send));
        if sends_draft && (is_dropped || !asked.is_empty()) {
            // The answer "no" keeps the draft; the draft was just taken, so the undo succeeds.
            let _ = self.map.draft.undo();
        }
        if !asked.is_empty() {
            let words: Vec<String> = asked.iter().map(|request| format!("`{request}`")).collect();
            let text = format!("Send {} to the robot as it is now?", words.join(", "));
            let text = self.said_of_the_past(text);
            let then = Then::Send(asked);
            self.overlay = Overlay::Question(Question { text, then });
        }
        rest
    }

    /// A question, preceded by the age of the displayed moment.
    pub(super) fn said_of_the_past(&self, question: String) -> String {
        match &self.playback {
            Some(playback) if playback.is_live => {
                let behind = age::words(playback.behind());
                format!("What you see is PAST, {behind} ago. {question}")
            }
            _ => question,
        }
    }

    /// Carries out a confirmed question.
    pub(super) fn go_ahead(&mut self, then: Then) -> Vec<Effect> {
        self.overlay = Overlay::None;
        match then {
            Then::Send(requests) => {
                let draft = self.map.draft.waypoints();
                let sends_draft = |request: &Request| matches!(request, Request::Route(list) if !list.is_empty() && list == draft);
                if requests.iter().any(sends_draft) {
                    self.map.draft.take();
                }
                if self.shows_past() {
                    let aside = "it is sent to the robot now; <playback-newest> shows its status";
                    self.aside = Some((Level::Warning, self.with_keys(aside)));
                }
                requests.into_iter().map(Effect::Send).collect()
            }
            Then::Replay(capture) => vec![Effect::Replay(capture)],
            Then::Save(effect) => vec![effect],
            Then::Drive => {
                self.overlay = Overlay::Drive(Stick::default());
                // Driving by hand needs the current moment on the screen.
                let back = self
                    .shows_past()
                    .then_some(Effect::Playback(Control::Newest));
                back.into_iter()
                    .chain([Effect::Send(Request::Mode(Mode::User))])
                    .collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crossterm::event::KeyCode;

    use super::super::map::Focus;
    use super::*;
    use crate::event::{Event, Notice, NoticeCode, Recording};
    use crate::model::testing::{Scene, playback};
    use crate::model::{Change, Config, Panel};
    use crate::playback::{Landmark, Playback};

    fn scene(is_live: bool) -> Scene {
        let mut scene = Scene::new(Config::default());
        scene.hear_status();
        scene.hear();
        scene.show_moment(Some(playback(is_live)));
        scene
    }

    fn question(scene: &Scene) -> String {
        match &scene.model.ui.overlay {
            Overlay::Question(question) => question.text.clone(),
            other => format!("{other:?}"),
        }
    }

    #[test]
    fn in_the_past_commands_ask_first_and_stop_does_not() {
        let prowl = Effect::Send(Request::Mode(Mode::Prowl));
        let wanted =
            "What you see is PAST, 2 m 00 s ago. Send `mode prowl` to the robot as it is now?";
        for keys in ["mp", ":mode prowl\n"] {
            let mut scene = scene(true);
            let mut typed = || {
                let mut effects = scene.type_text(keys.trim_end());
                if keys.ends_with('\n') {
                    effects.extend(scene.press(&[KeyCode::Enter]));
                }
                effects
            };
            assert_eq!(typed(), []);
            assert_eq!(question(&scene), wanted);
            assert_eq!(scene.type_text("n"), []);
            scene.type_text("mp");
            assert_eq!(scene.type_text("y"), std::slice::from_ref(&prowl));
        }
        for keys in [" ", "mp ", "m ", "n ", "? "] {
            let stop = Effect::Send(Request::Stop);
            assert_eq!(scene(true).type_text(keys), [stop], "{keys}");
        }
    }

    #[test]
    fn commands_by_key_ask_in_the_past() {
        for key in ["mp", "mr", "mh", "mw", "v", "4", "C", "O"] {
            let mut scene = scene(true);
            assert_eq!(scene.type_text(key), [], "{key}");
            let asked = question(&scene);
            assert!(asked.contains("PAST, 2 m 00 s ago"), "{key}: {asked}");
            let effects = scene.type_text("y");
            assert!(matches!(effects[..], [Effect::Send(_)]), "{key}");
        }
    }

    #[test]
    fn a_draft_is_not_lost_by_saying_no() {
        let mut scene = scene(true);
        scene.press(&[KeyCode::Up]);
        scene.type_text("wS");
        let draft = scene.model.ui.map.draft.waypoints().to_vec();
        assert_eq!(draft.len(), 1);
        scene.type_text("n");
        assert_eq!(scene.model.ui.map.draft.waypoints(), draft);
        let sent = [Effect::Send(Request::Route(draft))];
        assert_eq!(scene.type_text("Sy"), sent);
        assert_eq!(scene.model.ui.map.draft.waypoints(), []);
    }

    #[test]
    fn hand_driving_returns_to_the_present() {
        let mut scene = scene(true);
        scene.type_text("d");
        assert!(question(&scene).contains("PAST"));
        let effects = [
            Effect::Playback(Control::Newest),
            Effect::Send(Request::Mode(Mode::User)),
        ];
        assert_eq!(scene.type_text("y"), effects);
    }

    #[test]
    fn a_capture_has_no_robot() {
        for keys in ["mp", " ", "4", ":stop\n", "x", "C"] {
            let mut scene = scene(false);
            let mut effects = scene.type_text(keys.trim_end_matches('\n'));
            if keys.ends_with('\n') {
                effects.extend(scene.press(&[KeyCode::Enter]));
            }
            effects.extend(scene.type_text("y"));
            effects.retain(|effect| matches!(effect, Effect::Send(_) | Effect::CancelCommands));
            assert_eq!(effects, [], "{keys}");
        }
    }

    #[test]
    fn keys_ask_for_moments() {
        let travel = |travel| vec![Effect::Playback(travel)];
        let jump = |to, forward| travel(Control::Jump { to, forward });
        for (keys, wanted) in [
            ("p", travel(Control::TogglePause)),
            (",", travel(Control::Step { forward: false })),
            (".", travel(Control::Step { forward: true })),
            ("<", travel(Control::Speed(0.5))),
            (">", travel(Control::Speed(2.0))),
            ("o", travel(Control::Loop)),
            ("G", travel(Control::Newest)),
            ("na", jump(Some(Landmark::Alarm), true)),
            ("Nb", jump(Some(Landmark::Bump), false)),
            ("nv", jump(Some(Landmark::Behaviour), true)),
            ("Nc", jump(Some(Landmark::Command), false)),
            ("nm", jump(Some(Landmark::Marker), true)),
            ("nn", jump(None, true)),
            ("NN", jump(None, false)),
        ] {
            for is_live in [false, true] {
                assert_eq!(scene(is_live).type_text(keys), wanted, "{keys}");
            }
        }
        let pause = travel(Control::TogglePause);
        assert_eq!(
            scene(false).type_text(" "),
            pause,
            "a replay has nothing to stop"
        );
        let mut scene = scene(true);
        scene.type_text("g+30s");
        let ahead = Position::Ahead(Moment::from_secs(30));
        assert_eq!(scene.press(&[KeyCode::Enter]), travel(Control::Seek(ahead)));
        scene.type_text("gsoon");
        assert_eq!(scene.press(&[KeyCode::Enter]), []);
        let Overlay::Text(entry) = &scene.model.ui.overlay else {
            panic!("the text stays to be mended");
        };
        assert!(entry.error.as_ref().is_some_and(|e| e.contains("`soon`")));
    }

    #[test]
    fn a_mark_asks_for_its_text() {
        let mark = |at| Effect::Playback(Control::Mark(at));
        let mut scene = scene(false);
        let shown = playback(false).at;
        assert_eq!(scene.type_text("a"), []);
        scene.type_text("lamp fell");
        assert_eq!(scene.press(&[KeyCode::Enter]), [mark(shown)]);
        let aside = scene.model.ui.aside.as_ref();
        let said = (Level::Info, "note: lamp fell".to_owned());
        assert_eq!(aside, Some(&said), "nothing is recorded");
        scene.event(Event::Recording(Recording {
            mcap: Some("evening.mcap".to_owned()),
            ..Recording::default()
        }));
        scene.show_moment(None);
        scene.type_text("a");
        let pressed_at = scene.now;
        scene.wait_ms(7000);
        scene.type_text("lamp fell");
        let label = Effect::Label {
            capture: "evening.mcap".to_owned(),
            remark: Remark::Note("lamp fell".to_owned()),
            ago: Moment::from_secs(7),
        };
        assert_eq!(scene.press(&[KeyCode::Enter]), [mark(pressed_at), label]);
        scene.type_text("a");
        let enter = scene.press(&[KeyCode::Enter]);
        assert_eq!(enter, [mark(scene.now)], "a mark without a text");
        scene.type_text("alamp");
        assert_eq!(scene.press(&[KeyCode::Esc]), [], "no mark");
        assert_eq!(scene.model.ui.overlay, Overlay::None);
        scene.type_text("a");
        let again = scene.press(&[KeyCode::Up, KeyCode::Enter]);
        let [set, Effect::Label { remark, .. }] = &again[..] else {
            panic!("{again:?}");
        };
        assert_eq!(*set, mark(scene.now));
        assert_eq!(*remark, Remark::Note("lamp fell".to_owned()), "recalled");
        // A mark at this moment gets a text, or is removed.
        let mut marked = playback(true);
        marked.markers = vec![marked.at];
        scene.show_moment(Some(marked));
        scene.type_text("a");
        assert_eq!(scene.press(&[KeyCode::Enter]), [mark(shown)]);
        scene.type_text("alamp");
        let named = scene.press(&[KeyCode::Enter]);
        assert!(matches!(named[..], [Effect::Label { .. }]), "{named:?}");
    }

    #[test]
    fn esc_gives_up_a_search_before_anything_else() {
        let mut scene = scene(false);
        scene.press(&[KeyCode::Up]);
        let looking = Playback {
            is_looking: true,
            ..playback(false)
        };
        scene.show_moment(Some(looking));
        let give_up = [Effect::Playback(Control::StopSearch)];
        assert_eq!(scene.press(&[KeyCode::Esc]), give_up);
        assert!(scene.model.ui.map.cursor.is_some());
    }

    #[test]
    fn keys_of_the_present_work_on_the_past() {
        let mut now = Scene::new(Config::default());
        now.hear();
        let then = now.model.facts.clone();
        now.state.x_tenths_in = 500;
        now.hear();
        now.type_text(":goto 48 0");
        now.press(&[KeyCode::Enter, KeyCode::Tab, KeyCode::Up]);
        now.type_text("w+?");
        assert_eq!(then.robot.state.map(|s| s.value.x_tenths_in), Some(0));
        let ui = &mut now.model.ui;
        let draft = ui.map.draft.waypoints().to_vec();
        for key in [KeyCode::Esc, KeyCode::Char(':'), KeyCode::Up] {
            ui.update(now.now, Event::Key(key.into()), &then, Change::default());
        }
        assert_eq!(ui.map.draft.waypoints(), draft);
        assert!(
            matches!(ui.map.focus, Focus::Robot(_)),
            "{:?}",
            ui.map.focus
        );
        assert_eq!(ui.panel, Panel::Above);
        let Overlay::Text(entry) = &ui.overlay else {
            panic!("{:?}", ui.overlay);
        };
        assert_eq!(entry.text, "goto 48 0", "typed before");
    }

    #[test]
    fn landmarks_are_counted() {
        use groundwave_protocol::status_codes::{Bump, Layer, LayerState};
        let mut scene = Scene::new(Config::default());
        scene.hear();
        let before = scene.model.facts.tally();
        scene.state.bump = Bump::Left;
        scene.layers(&[(Layer::Bumpers, LayerState::Holds)]);
        scene.hear();
        scene.hear();
        let hit = scene.model.facts.tally();
        assert_eq!(
            (hit.lines - before.lines, hit.bumps, hit.behaviours),
            (2, 1, 1)
        );
        scene.ack.sequence += 1;
        scene.hear();
        assert_eq!(
            scene.model.facts.tally().commands,
            1,
            "a command of another station"
        );
        scene.ask(1, Request::Scan);
        scene.ack.sequence += 1;
        scene.hear();
        assert_eq!(
            scene.model.facts.tally().commands,
            2,
            "one's own is shown once"
        );
        scene.event(Event::Notice(Notice::new(
            NoticeCode::Other,
            Level::Alarm,
            "x",
        )));
        assert_eq!(scene.model.facts.tally().alarms, 1);
    }
}
