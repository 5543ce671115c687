//! The queue of the terminal's events, in which STOP and Ctrl-C overtake.

use std::collections::VecDeque;

use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use tokio::sync::mpsc::Receiver;

/// Number of events that wait for the dashboard, at most, in the channel and again behind it; STOP, Ctrl-C and sizes find room.
pub(super) const EVENTS_MAX: usize = 16 << 10;

const CTRL_C: KeyEvent = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);

/// Keys, clicks, pastes and sizes.
pub struct Events {
    receiver: Receiver<Event>,
    /// Events that were received while looking for urgent keys.
    waiting: VecDeque<Event>,
}

impl Events {
    pub(super) const fn new(receiver: Receiver<Event>) -> Self {
        Self {
            receiver,
            waiting: VecDeque::new(),
        }
    }

    /// The next event; `None` when the terminal is closed. Cancel-safe.
    pub async fn next(&mut self) -> Option<Event> {
        match self.waiting.pop_front() {
            Some(event) => Some(event),
            None => self.receiver.recv().await,
        }
    }

    /// The next event, if one waits.
    pub fn poll(&mut self) -> Option<Event> {
        let waiting = self.waiting.pop_front();
        waiting.or_else(|| self.receiver.try_recv().ok())
    }

    /// Drops what waits before STOP or Ctrl-C, apart from sizes, if one of them waits and no text can be meant: a character that is STOP, such as
    /// Space, only overtakes the key `slow`, repeated or released, because another key may open a prompt.
    pub fn hurry(&mut self, slow: Option<&Event>, is_stop: impl Fn(&KeyEvent) -> bool) {
        let is_urgent = |event: &Event| match event {
            Event::Key(key) if key.kind == KeyEventKind::Press => *key == CTRL_C || is_stop(key),
            _ => false,
        };
        while let Ok(event) = self.receiver.try_recv() {
            let has_room = self.waiting.len() < EVENTS_MAX;
            let is_another = self.waiting.back() != Some(&event);
            if has_room || is_another && (is_size(&event) || is_urgent(&event)) {
                self.waiting.push_back(event);
            }
        }
        let is_repeated = |event: &&Event| {
            let is_same = slow.is_some_and(|slow| is_same_key(event, slow));
            is_same || is_size(event)
        };
        let repeats = self.waiting.iter().take_while(is_repeated).count();
        let urgent = self.waiting.iter().enumerate().position(|(at, event)| {
            is_urgent(event) && (at <= repeats || !matches!(event, Event::Key(key) if is_text(key)))
        });
        if let Some(urgent) = urgent {
            let later = self.waiting.split_off(urgent);
            self.waiting.retain(is_size);
            self.waiting.extend(later);
        }
    }
}

const fn is_size(event: &Event) -> bool {
    matches!(event, Event::Resize(..))
}

/// Whether both are the same key, pressed, repeated or released.
fn is_same_key(one: &Event, other: &Event) -> bool {
    let (Event::Key(one), Event::Key(other)) = (one, other) else {
        return false;
    };
    (one.code, one.modifiers) == (other.code, other.modifiers)
}

/// Whether the key is a character of a text.
fn is_text(key: &KeyEvent) -> bool {
    let commands = KeyModifiers::CONTROL | KeyModifiers::ALT;
    matches!(key.code, KeyCode::Char(_)) && !key.modifiers.intersects(commands)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::sync::mpsc::{Sender, channel};

    fn queue() -> (Sender<Event>, Events) {
        let (sender, receiver) = channel(EVENTS_MAX);
        (sender, Events::new(receiver))
    }

    fn plain(c: char) -> Event {
        Event::Key(KeyCode::Char(c).into())
    }

    fn ctrl(c: char) -> Event {
        Event::Key(KeyEvent::new(KeyCode::Char(c), KeyModifiers::CONTROL))
    }

    fn of_kind(c: char, kind: KeyEventKind) -> Event {
        let key = KeyEvent::from(KeyCode::Char(c));
        Event::Key(KeyEvent { kind, ..key })
    }

    /// The events that are left of others that wait behind a slow `N`.
    fn hurried(waiting: &[Event]) -> Vec<Event> {
        let (sender, mut events) = queue();
        for event in waiting {
            sender.try_send(event.clone()).expect("there is room");
        }
        let stops = [plain(' '), ctrl('s'), Event::Key(KeyCode::F(12).into())];
        events.hurry(Some(&plain('N')), |key| stops.contains(&Event::Key(*key)));
        std::iter::from_fn(|| events.poll()).collect()
    }

    #[test]
    fn stop_overtakes_a_held_key() {
        let held = vec![plain('N'); 100];
        let kitty = [
            vec![of_kind('N', KeyEventKind::Repeat); 100],
            vec![of_kind('N', KeyEventKind::Release)],
        ]
        .concat();
        assert_eq!(hurried(&held), held, "nothing is urgent");
        let size = Event::Resize(80, 24);
        let f12 = Event::Key(KeyCode::F(12).into());
        for stop in [plain(' '), ctrl('s'), ctrl('c'), f12] {
            for held in [&held, &kitty] {
                let waiting = [&held[..], &[size.clone(), stop.clone(), plain('x')]].concat();
                assert_eq!(hurried(&waiting), [size.clone(), stop.clone(), plain('x')]);
            }
        }
    }

    #[test]
    fn a_space_behind_other_keys_may_be_text() {
        let typed: Vec<Event> = "NN:note kitchen door".chars().map(plain).collect();
        assert_eq!(hurried(&typed), typed);
        let stopped = [&typed[..], &[ctrl('s')]].concat();
        assert_eq!(hurried(&stopped), [ctrl('s')]);
    }

    #[test]
    fn a_flood_of_keys_is_bounded_and_hides_no_stop() {
        let (sender, mut events) = queue();
        let is_stop = |key: &KeyEvent| Event::Key(*key) == ctrl('s');
        for _ in 0..3 {
            while sender.try_send(plain('v')).is_ok() {}
            events.hurry(None, is_stop);
        }
        assert_eq!(events.waiting.len(), EVENTS_MAX);
        sender.try_send(ctrl('s')).expect("there is room");
        events.hurry(None, is_stop);
        assert_eq!(events.poll(), Some(ctrl('s')));
        assert_eq!(events.poll(), None);
    }
}
