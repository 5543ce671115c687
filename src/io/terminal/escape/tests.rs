use crossterm::event::{KeyEventKind, MouseButton, MouseEvent, MouseEventKind};

use super::keys::pressed;
use super::*;

const MS: Duration = Duration::from_millis(1);

/// A reader with its own clock.
struct Terminal {
    reader: Reader,
    now: Instant,
}

impl Terminal {
    fn new() -> Self {
        let now = Instant::now();
        let reader = Reader::new(now);
        Self { reader, now }
    }

    fn silent(&mut self, silence: Duration) -> Vec<Event> {
        self.now += silence;
        self.reader.end(self.now)
    }

    /// Sends bytes after a silence.
    fn after(&mut self, silence: Duration, bytes: &str) -> Vec<Event> {
        let mut events = self.silent(silence);
        events.extend(self.reader.handle_bytes(self.now, bytes.as_bytes()));
        events
    }
}

fn read_all(bytes: &str) -> Vec<Event> {
    let mut terminal = Terminal::new();
    let mut events = terminal.after(MS, bytes);
    events.extend(terminal.silent(PASTE_GAP));
    events
}

fn keys_of(bytes: &str) -> Vec<KeyCode> {
    let code = |event| match event {
        Event::Key(key) => key.code,
        other => panic!("{other:?}"),
    };
    read_all(bytes).into_iter().map(code).collect()
}

fn key(c: char) -> Vec<Event> {
    vec![Event::Key(KeyCode::Char(c).into())]
}

fn ctrl(c: char) -> Vec<Event> {
    pressed(c, KeyModifiers::CONTROL).into_iter().collect()
}

#[test]
fn stop_and_ctrl_c_count_after_an_unfinished_sequence() {
    for begun in [
        "\x1b[200~",
        "\x1b[200~1,2\r",
        "\x1b[200~\x1b[201",
        "\x1b[1;1;",
        "\x1b[",
        "\x1bO",
        "\x1b[<0;1",
        "\x1b[?",
        "\x1b[M",
        "\x1b]0;title",
        "\x1bP",
        "\x1b_G\x1b",
        "\u{e9}\u{1b}[",
    ] {
        for (pressed, event) in [(" ", key(' ')), ("\x03", ctrl('c')), ("\x13", ctrl('s'))] {
            let mut terminal = Terminal::new();
            terminal.after(MS, begun);
            let events = terminal.after(SEQUENCE_GAP, pressed);
            assert!(
                events.ends_with(&event),
                "{begun:?} {pressed:?}: {events:?}"
            );
        }
    }
}

#[test]
fn stop_and_ctrl_c_break_a_sequence_off_at_once() {
    for begun in ["\x1b[1;1;", "\x1b[", "\x1b[[", "\x1bO", "\x1b[<0;1"] {
        for (pressed, event) in [(" ", key(' ')), ("\x03", ctrl('c'))] {
            let events = read_all(&format!("{begun}{pressed}"));
            assert!(
                events.ends_with(&event),
                "{begun:?} {pressed:?}: {events:?}"
            );
        }
    }
}

/// Esc and the next key may arrive together; Alt and Ctrl-C would be no key.
#[test]
fn ctrl_c_counts_in_one_read_with_esc() {
    for (pressed, c) in [("\x03", 'c'), ("\x13", 's')] {
        for begun in ["\x1b", "\x1b\x1b", "p\x1b"] {
            let events = read_all(&format!("{begun}{pressed}"));
            let wanted = [vec![Event::Key(KeyCode::Esc.into())], ctrl(c)].concat();
            assert!(events.ends_with(&wanted), "{begun:?} {c}: {events:?}");
        }
    }
}

#[test]
fn strings_of_the_terminal_are_no_keys() {
    let body = "11;rgb:1e1e/1e1e/1e1e >|tmux 3.4 \r\n\t w".repeat(9);
    for begin in ["\x1b]", "\x1bP", "\x1b_", "\x1b^", "\x1bX"] {
        for end in ["\x07", "\x1b\\"] {
            let keys = keys_of(&format!("{begin}{body}{end}p"));
            assert_eq!(keys, [KeyCode::Char('p')], "{begin:?} {end:?}");
        }
        let next = keys_of(&format!("{begin}{body}\x1b[Dp"));
        assert_eq!(next, [KeyCode::Left, KeyCode::Char('p')], "{begin:?}");

        let mut terminal = Terminal::new();
        assert_eq!(terminal.after(MS, &format!("{begin}{body}")), []);
        assert_eq!(terminal.after(MS, "w"), []);
        assert_eq!(terminal.after(MS, " "), key(' '));
        assert_eq!(terminal.after(MS, "\x03"), ctrl('c'));
        assert_eq!(terminal.after(MS, "\x13"), ctrl('s'));
        assert_eq!(terminal.after(MS, "w"), []);
        assert!(terminal.reader.held.len() <= 4, "the body is not held");
        assert_eq!(terminal.silent(SEQUENCE_GAP), []);
        assert_eq!(terminal.after(MS, "p"), key('p'));
    }
    let alt = pressed('P', KeyModifiers::ALT)
        .into_iter()
        .collect::<Vec<_>>();
    assert_eq!(read_all("\x1bP"), alt);
}

#[test]
fn space_counts_however_it_is_sent() {
    for begun in ["\x1b[200~", "\x1b[200~1,2", "\x1b[M", "\x1bP1"] {
        for (pressed, count) in [
            (" ", 1),
            ("  ", 2),
            ("\x1b[32u", 1),
            ("\x1b[32;5u", 1),
            ("\x1b[32;1:1u\x1b[32;1:3u", 2),
        ] {
            let mut terminal = Terminal::new();
            terminal.after(MS, begun);
            let is_paste = terminal.reader.paste.is_some();
            let silence = if is_paste { SEQUENCE_GAP } else { MS };
            let events = terminal.after(silence, pressed);
            let is_space =
                |event: &Event| matches!(event, Event::Key(key) if key.code == KeyCode::Char(' '));
            let spaces = events.iter().filter(|event| is_space(event)).count();
            assert_eq!(spaces, count, "{begun:?} {pressed:?}: {events:?}");
        }
    }
    for text in [" 1", "1 ", "\x1b[32u1", " \x1b[3", "a\x1b[115;5u"] {
        let mut terminal = Terminal::new();
        terminal.after(MS, "\x1b[200~");
        assert_eq!(terminal.after(SEQUENCE_GAP, text), [], "{text:?}");
    }
}

/// Each press also prolongs the paste, so a paste that swallows it would never end.
#[test]
fn ctrl_s_and_ctrl_c_count_within_a_paste_however_they_are_sent() {
    for (c, pressed) in [
        ('s', "\x13"),
        ('s', "\x1b[115;5u"),
        ('s', "\x1b[115;69:1u\x1b[115;5:3u"),
        ('c', "\x03"),
        ('c', "\x1b[99;5u"),
        ('s', " \x13"),
    ] {
        let mut terminal = Terminal::new();
        terminal.after(MS, "\x1b[200~");
        for _ in 0..3 {
            let events = terminal.after(SEQUENCE_GAP, pressed);
            let is_pressed = |event: &&Event| matches!(event, Event::Key(key) if key.code == KeyCode::Char(c) && key.is_press());
            let count = events.iter().filter(is_pressed).count();
            assert_eq!(count, 1, "{pressed:?}: {events:?}");
        }
    }
}

#[test]
fn a_paste_without_an_end_ends_after_a_second_and_is_bounded() {
    let mut terminal = Terminal::new();
    assert_eq!(terminal.after(MS, "\x1b[200~1,2"), []);
    assert_eq!(terminal.silent(PASTE_GAP.saturating_sub(MS)), []);
    let text = "1,2".to_owned();
    assert_eq!(terminal.silent(MS), [Event::Paste(text)]);
    assert_eq!(terminal.after(MS, "p"), key('p'));

    terminal.after(MS, "\x1b[200~");
    for _ in 0..200 {
        assert_eq!(terminal.after(MS, &"7".repeat(1000)), []);
    }
    assert_eq!(terminal.after(SEQUENCE_GAP, " "), key(' '));
    let events = terminal.after(MS, "\x1b[201~p");
    let [Event::Paste(text), end @ ..] = events.as_slice() else {
        panic!("{events:?}");
    };
    assert_eq!(text.len(), PASTE_MAX);
    assert_eq!(end, key('p'));
}

#[test]
fn a_paste_is_one_text_however_it_is_cut() {
    let text = "1,2 \r\x1b[20~ü\x1b\x1b[201";
    let sent = format!("\x1b[200~{text}\x1b[201~");
    for size in 1..sent.len() {
        let mut terminal = Terminal::new();
        let mut events = Vec::new();
        for bytes in sent.as_bytes().chunks(size) {
            terminal.now += MS;
            events.extend(terminal.reader.handle_bytes(terminal.now, bytes));
        }
        assert_eq!(events, [Event::Paste(text.to_owned())], "by {size}");
    }
}

#[test]
fn a_lone_escape_is_a_key_after_a_silence() {
    let mut terminal = Terminal::new();
    assert_eq!(terminal.after(MS, "\x1b"), []);
    let escape = Event::Key(KeyCode::Esc.into());
    assert_eq!(terminal.silent(SEQUENCE_GAP), std::slice::from_ref(&escape));
    assert_eq!(terminal.reader.poll_timeout(), None);
    // A slow line splits the sequence of an arrow key.
    assert_eq!(terminal.after(MS, "\x1b"), []);
    assert_eq!(terminal.after(SEQUENCE_GAP.saturating_sub(MS), "["), []);
    let left = Event::Key(KeyCode::Left.into());
    assert_eq!(terminal.after(SEQUENCE_GAP.saturating_sub(MS), "D"), [left]);
    assert_eq!(keys_of("\x1b\x1b"), [KeyCode::Esc, KeyCode::Esc]);
}

#[test]
fn esc_and_another_key_are_two_keys() {
    for (keys, code) in [
        ("\x1b[D", KeyCode::Left),
        ("\x1b[1;2D", KeyCode::Left),
        ("\x1bOA", KeyCode::Up),
        ("\x1b[5~", KeyCode::PageUp),
        ("\x1b[6~", KeyCode::PageDown),
        ("\x1b[3~", KeyCode::Delete),
        ("\x1bOP", KeyCode::F(1)),
        ("\x1b[15~", KeyCode::F(5)),
        ("\x1b[24~", KeyCode::F(12)),
        ("\x1b[[E", KeyCode::F(5)),
        ("\x1b[27u", KeyCode::Esc),
        ("\x1b[57400u", KeyCode::Char('1')),
    ] {
        let both = format!("\x1b{keys}");
        assert_eq!(keys_of(&both), [KeyCode::Esc, code], "{keys:?}");
    }
}

#[test]
fn unknown_sequences_are_dropped_and_the_next_key_is_not() {
    assert_eq!(keys_of("\x1b[99~ "), [KeyCode::Char(' ')]);
    assert_eq!(keys_of("\x1b[?62;4c "), [KeyCode::Char(' ')]);
    assert_eq!(keys_of("\x1b[1;2"), []);
    assert_eq!(
        keys_of(&format!("\x1b[{} ", "1;".repeat(99))).last(),
        Some(&KeyCode::Char(' '))
    );
    assert_eq!(keys_of("[D"), [KeyCode::Char('['), KeyCode::Char('D')]);
    let mut terminal = Terminal::new();
    assert_eq!(
        terminal.reader.handle_bytes(terminal.now, b"\xFF\xC3 "),
        key(' ')
    );
}

#[test]
fn modifiers_and_kinds_are_read() {
    for (keys, code, modifiers, kind) in [
        (
            "A",
            KeyCode::Char('A'),
            KeyModifiers::SHIFT,
            KeyEventKind::Press,
        ),
        (
            "\x1b ",
            KeyCode::Char(' '),
            KeyModifiers::ALT,
            KeyEventKind::Press,
        ),
        (
            "\x1b[1;1:3A",
            KeyCode::Up,
            KeyModifiers::NONE,
            KeyEventKind::Release,
        ),
        (
            "\x1b[1;2:2C",
            KeyCode::Right,
            KeyModifiers::SHIFT,
            KeyEventKind::Repeat,
        ),
        (
            "\x1b[99;5u",
            KeyCode::Char('c'),
            KeyModifiers::CONTROL,
            KeyEventKind::Press,
        ),
        (
            "\x1b[9;2u",
            KeyCode::BackTab,
            KeyModifiers::SHIFT,
            KeyEventKind::Press,
        ),
        (
            "\x1b[Z",
            KeyCode::BackTab,
            KeyModifiers::SHIFT,
            KeyEventKind::Press,
        ),
    ] {
        let key = KeyEvent::new_with_kind(code, modifiers, kind);
        assert_eq!(read_all(keys), [Event::Key(key)], "{keys:?}");
    }
}

#[test]
fn clicks_and_the_wheel_are_read() {
    let event = |kind| {
        let (column, row, modifiers) = (19, 11, KeyModifiers::NONE);
        vec![Event::Mouse(MouseEvent {
            kind,
            column,
            row,
            modifiers,
        })]
    };
    let click = event(MouseEventKind::Down(MouseButton::Left));
    assert_eq!(read_all("\x1b[<0;20;12M"), click);
    assert_eq!(read_all("\x1b[M 4,"), click);
    assert_eq!(read_all("\x1b[<64;20;12M"), event(MouseEventKind::ScrollUp));
    assert_eq!(
        read_all("\x1b[<65;20;12M"),
        event(MouseEventKind::ScrollDown)
    );
    assert_eq!(read_all("\x1b[<0;20;12m\x1b[<0;0;0M\x1b[<2;1;1M"), []);
}

/// Any bytes, together or one by one with silences, need bounded memory, and STOP works after them.
#[test]
fn fuzz_keys() {
    bolero::check!().for_each(|bytes: &[u8]| {
        let (silence_ms, bytes) = bytes
            .split_first()
            .map_or((0, bytes), |(ms, rest)| (*ms, rest));
        let bytes = [PASTE_BEGIN, b"\x1b]", b"\x1b[<0;"][usize::from(silence_ms) % 3]
            .iter()
            .chain(bytes);
        let mut whole = Terminal::new();
        let mut split = Terminal::new();
        let bytes: Vec<u8> = bytes.copied().collect();
        whole.reader.handle_bytes(whole.now, &bytes);
        for byte in &bytes {
            split.silent(MS * silence_ms.into());
            split.reader.handle_bytes(split.now, &[*byte]);
        }
        for mut terminal in [whole, split] {
            assert!(terminal.reader.held.len() <= SEQUENCE_MAX);
            let paste = terminal.reader.paste.as_ref();
            assert!(paste.is_none_or(|paste| paste.len() <= PASTE_MAX));
            let events = terminal.after(SEQUENCE_GAP, " ");
            assert!(events.ends_with(&key(' ')), "{events:?}");
        }
    });
}
