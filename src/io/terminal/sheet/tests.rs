use std::num::NonZero;

use proptest::prelude::*;
use ratatui::backend::{Backend, CrosstermBackend};
use ratatui::style::Style;

use super::*;

const WIDTH: u16 = 14;
const HEIGHT: u16 = 4;

/// A stroke: where, how it looks, what it says.
type Stroke = (u16, u16, Style, String);

fn looks() -> impl Strategy<Value = Style> {
    let colors = [
        Color::Reset,
        Color::Red,
        Color::Gray,
        Color::DarkGray,
        Color::White,
        Color::Indexed(245),
        Color::Rgb(1, 2, 3),
    ];
    // What the emulator tells apart.
    let modifiers = prop::bits::u16::masked(
        (Modifier::BOLD
            | Modifier::DIM
            | Modifier::ITALIC
            | Modifier::UNDERLINED
            | Modifier::REVERSED)
            .bits(),
    );
    let color = prop::sample::select(colors.to_vec());
    (color.clone(), color, modifiers).prop_map(|(fg, bg, bits)| {
        let style = Style::new().fg(fg).bg(bg);
        let mut modifier = Modifier::from_bits_truncate(bits);
        // The emulator knows one brightness at a time.
        if modifier.contains(Modifier::BOLD) {
            modifier.remove(Modifier::DIM);
        }
        style.add_modifier(modifier).remove_modifier(!modifier)
    })
}

fn frames() -> impl Strategy<Value = Vec<Vec<Stroke>>> {
    let style = prop_oneof![2 => Just(Style::new()), 2 => looks()];
    let text = prop_oneof![
        "[ a-c]{1,6}",
        "[ -~]{1,14}",
        "[⠁-⣿ ab│]{1,6}",
        "[漢字 ab]{1,4}",
        "(e\u{301}|漢|👍|o\u{308}| |b){1,5}"
    ];
    let stroke = (0..WIDTH, 0..HEIGHT, style, text);
    prop::collection::vec(prop::collection::vec(stroke, 0..8), 1..6)
}

/// The terminal after each frame, and a new one that the backend of the library writes the whole of it to.
fn shown(frames: &[Vec<Stroke>]) -> Vec<[vt100::Screen; 2]> {
    let emulator = || vt100::Parser::new(nonzero(HEIGHT), nonzero(WIDTH), 0);
    let mut terminal = emulator();
    let mut sheet = Sheet::new(WIDTH, HEIGHT);
    let mut screens = Vec::new();
    for strokes in frames {
        let blank = Buffer::empty(sheet.page.area);
        let mut new = blank.clone();
        for (x, y, style, text) in strokes {
            new.set_stringn(*x, *y, text, (WIDTH - x).into(), *style);
        }
        terminal.process(&sheet.draw(|page| page.clone_from(&new)));
        let mut whole = Vec::new();
        let mut other = CrosstermBackend::new(&mut whole);
        other.draw(blank.diff(&new).into_iter()).unwrap();
        let mut fresh = emulator();
        fresh.process(&whole);
        screens.push([terminal.screen().clone(), fresh.screen().clone()]);
    }
    screens
}

fn nonzero(cells: u16) -> NonZero<u16> {
    NonZero::new(cells).unwrap()
}

/// What is seen of a cell.
fn seen(screen: &vt100::Screen, row: u16, column: u16) -> impl PartialEq + std::fmt::Debug {
    let cell = screen.cell(row, column).unwrap();
    let text = match cell.contents() {
        "" => " ",
        text => text,
    };
    let ink = (text != " ").then(|| (cell.fgcolor(), cell.bold(), cell.dim(), cell.italic()));
    let inverse = cell.inverse().then(|| cell.fgcolor());
    (
        text.to_owned(),
        ink,
        cell.bgcolor(),
        cell.underline(),
        inverse,
    )
}

proptest! {
    #[test]
    fn short_cuts_lead_to_the_same_screen(frames in frames()) {
        for [short, plain] in shown(&frames) {
            for row in 0..HEIGHT {
                for column in 0..WIDTH {
                    prop_assert_eq!(seen(&short, row, column), seen(&plain, row, column), "row {}, column {}", row, column);
                }
            }
        }
    }
}

/// The bytes of the second of two frames of one line each.
fn change(before: (&str, Style), after: (&str, Style)) -> String {
    let mut sheet = Sheet::new(20, 2);
    sheet.draw(|page| page.set_string(0, 0, before.0, before.1));
    let bytes = sheet.draw(|page| page.set_string(0, 0, after.0, after.1));
    String::from_utf8(bytes).unwrap()
}

#[test]
fn little_is_said_for_little_change() {
    let plain = Style::new();
    let dim = plain.dim();
    let at_second = |to| change(("10:00:00", plain), (to, plain));
    assert_eq!(at_second("10:00:01"), "\x081");
    // Two digits with one between: that is written once more.
    assert_eq!(at_second("10:01:01"), "\x1b[4D1:01");
    // A look is begun and left where it is needed.
    assert_eq!(
        change(("10:00:00", plain), ("10:00:01", dim)),
        "\r\x1b[2m10:00:01"
    );
    let after = ("10:00:01", plain.fg(Color::Indexed(245)));
    assert_eq!(
        change(("10:00:00", dim), after),
        "\r\x1b[0;38;5;245m10:00:01"
    );
    assert_eq!(
        change(("10:00:00", dim), ("10:00:00", plain)),
        "\r\x1b[m10:00:00"
    );
}

/// How wide it is only the terminal knows: behind it the way is told whole.
#[test]
fn behind_what_is_not_ascii_no_short_cut_is_taken() {
    let plain = Style::new();
    let far = change(("日 10:00:00", plain), ("本 10:00:01", plain));
    assert_eq!(far, "\r本\x1b[1;11H1");
}

fn blank() -> vt100::Parser {
    vt100::Parser::new(nonzero(HEIGHT), nonzero(WIDTH), 0)
}

fn rows(terminal: &vt100::Parser) -> Vec<String> {
    terminal.screen().rows(0, WIDTH).collect()
}

fn draw(sheet: &mut Sheet, texts: &[(u16, u16, &str)]) -> String {
    let bytes = sheet.draw(|page| {
        for (x, y, text) in texts {
            page.set_string(*x, *y, text, Style::new());
        }
    });
    String::from_utf8(bytes).unwrap()
}

/// The emulator draws a hand and its colour each for itself, in four columns of which we know two.
#[test]
fn what_a_terminal_does_not_join_spoils_nothing_beside_it() {
    for frame in [
        &[(0, 0, "👍🏽 run")][..],
        &[(12, 0, "👍🏽"), (0, 1, "next row")],
        &[(0, 0, "Ze\u{301}le\u{301}")],
    ] {
        let (mut sheet, mut terminal) = (Sheet::new(WIDTH, HEIGHT), blank());
        terminal.process(draw(&mut sheet, frame).as_bytes());
        let once = rows(&terminal);
        for (_, row, text) in frame {
            if let Some(word) = text.split(' ').nth(1) {
                assert!(once[usize::from(*row)].contains(word), "{once:?}");
            }
        }
        assert_eq!(draw(&mut sheet, frame), "", "nothing changed");
    }
}

/// A heart that a variation makes wide, on a terminal that knows no variations.
#[test]
fn a_wide_character_leaves_nothing_of_the_old_frame() {
    let (mut sheet, mut terminal) = (Sheet::new(WIDTH, HEIGHT), blank());
    for text in ["abcd", "❤\u{fe0f}cd"] {
        let narrow = draw(&mut sheet, &[(0, 0, text)]).replace('\u{fe0f}', "");
        terminal.process(narrow.as_bytes());
    }
    assert_eq!(rows(&terminal)[0], "❤ cd");
}

#[test]
fn a_terminal_without_columns_or_rows_gets_nothing() {
    for (width, height) in [(0, 0), (0, 5), (5, 0)] {
        let mut sheet = Sheet::new(width, height);
        draw(&mut sheet, &[]);
        assert_eq!(draw(&mut sheet, &[]), "");
    }
}
