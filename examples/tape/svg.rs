//! Screens as SVG: one, or an animation of several.

use std::fmt::Write as _;

use ratatui::buffer::{Buffer, Cell};
use ratatui::style::{Color, Modifier};

const CELL_WIDTH: f64 = 8.4;
const CELL_HEIGHT: f64 = 17.0;
const DOT_WIDTH: f64 = CELL_WIDTH / 2.0;
const MARGIN: f64 = 12.0;
const BACKGROUND: &str = "#14171c";
const FOREGROUND: &str = "#c8ccd4";

/// One screen.
pub fn still(screen: &Buffer) -> String {
    let mut svg = head(screen);
    for row in 0..screen.area.height {
        svg += &row_text(screen, row);
    }
    svg + "</svg>\n"
}

/// An endless animation of screens of one size, each shown for `each_s` seconds. A row that stays the same is drawn
/// once.
pub fn moving(screens: &[Buffer], each_s: f64) -> String {
    let Some(first) = screens.first() else {
        return String::new();
    };
    let total_s = each_s * screens.len() as f64;
    let mut spans: Vec<(usize, usize)> = Vec::new();
    let mut rows = String::new();
    for row in 0..first.area.height {
        let texts: Vec<String> = screens.iter().map(|screen| row_text(screen, row)).collect();
        let mut begin = 0;
        while let Some(text) = texts.get(begin) {
            let same = texts[begin..]
                .iter()
                .take_while(|other| *other == text)
                .count();
            let span = (begin, begin + same);
            // Writing to a string cannot fail.
            let _ = match span {
                (0, end) if end == texts.len() => write!(rows, "{text}"),
                (from, to) => {
                    spans.push(span);
                    write!(rows, "<g class=\"f{from}-{to}\">\n{text}</g>\n")
                }
            };
            begin += same;
        }
    }
    spans.sort_unstable();
    spans.dedup();
    let mut style = String::from("<style>\n");
    for (from, to) in spans {
        let percent = |frame: usize| 100.0 * frame as f64 / screens.len() as f64;
        let mut steps = String::new();
        if from > 0 {
            steps += "0%{visibility:hidden}";
        }
        let _ = write!(steps, "{:.2}%{{visibility:visible}}", percent(from));
        if to < screens.len() {
            let _ = write!(steps, "{:.2}%{{visibility:hidden}}", percent(to));
        }
        let _ = writeln!(
            style,
            ".f{from}-{to}{{visibility:{};animation:k{from}-{to} {total_s}s step-end infinite}}\n@keyframes k{from}-{to}{{{steps}}}",
            if from == 0 { "visible" } else { "hidden" }
        );
    }
    head(first) + &style + "</style>\n" + &rows + "</svg>\n"
}

/// Browsers keep rows of spaces by the style, other programs by the attribute.
fn head(screen: &Buffer) -> String {
    let width = f64::from(screen.area.width) * CELL_WIDTH + 2.0 * MARGIN;
    let height = f64::from(screen.area.height) * CELL_HEIGHT + 2.0 * MARGIN;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-{MARGIN} -{MARGIN} {width:.0} {height:.0}\" \
         font-family=\"'DejaVu Sans Mono', Menlo, Consolas, monospace\" font-size=\"14\" xml:space=\"preserve\">\n\
         <style>text{{white-space:pre}}.dots{{fill:none;stroke-width:2.4;stroke-linecap:round;stroke-dasharray:0 {DOT_WIDTH}}}</style>\n\
         <rect x=\"-{MARGIN}\" y=\"-{MARGIN}\" width=\"{width:.0}\" height=\"{height:.0}\" rx=\"8\" fill=\"{BACKGROUND}\"/>\n"
    )
}

/// Appearance of a cell without its text.
#[derive(Clone, Copy, PartialEq)]
struct Look {
    ink: &'static str,
    paper: &'static str,
    bold: bool,
    dim: bool,
    underlined: bool,
}

impl Look {
    fn of(cell: &Cell) -> Self {
        let (mut ink, mut paper) = (color(cell.fg, FOREGROUND), color(cell.bg, BACKGROUND));
        if cell.modifier.contains(Modifier::REVERSED) {
            std::mem::swap(&mut ink, &mut paper);
        }
        Self {
            ink,
            paper,
            bold: cell.modifier.contains(Modifier::BOLD),
            dim: cell.modifier.contains(Modifier::DIM),
            underlined: cell.modifier.contains(Modifier::UNDERLINED),
        }
    }
}

/// Draws a row; adjacent cells of equal appearance become one text, stretched to their columns.
fn row_text(screen: &Buffer, row: u16) -> String {
    let cell = |column: u16| &screen[(column, row)];
    let width = screen.area.width;
    let mut svg = String::new();
    let mut begin = 0;
    while begin < width {
        let look = Look::of(cell(begin));
        let alike = (begin..width).take_while(|&column| Look::of(cell(column)) == look);
        let end = begin + alike.count() as u16;
        let text: String = (begin..end).map(|column| cell(column).symbol()).collect();
        draw(&mut svg, look, &text, begin, row);
        begin = end;
    }
    svg
}

fn draw(svg: &mut String, look: Look, text: &str, column: u16, row: u16) {
    let columns = text.chars().count();
    let (x, y) = (f64::from(column) * CELL_WIDTH, f64::from(row) * CELL_HEIGHT);
    if look.paper != BACKGROUND {
        let width = columns as f64 * CELL_WIDTH;
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{CELL_HEIGHT:.1}\" fill=\"{}\"/>",
            look.paper
        );
    }
    let dim = if look.dim { " opacity=\"0.6\"" } else { "" };
    let dots = dots(text, x, y);
    if !dots.is_empty() {
        let _ = writeln!(
            svg,
            "<path class=\"dots\" d=\"{dots}\" stroke=\"{}\"{dim}/>",
            look.ink
        );
    }
    let text: String = text
        .chars()
        .map(|c| braille(c).map_or(c, |_| ' '))
        .collect();
    // Blank columns at the ends need no text.
    let blank = text.chars().take_while(|c| *c == ' ').count();
    let text = text.trim_matches(' ');
    if text.is_empty() {
        return;
    }
    let x = x + blank as f64 * CELL_WIDTH;
    let width = text.chars().count() as f64 * CELL_WIDTH;
    let bold = if look.bold {
        " font-weight=\"bold\""
    } else {
        ""
    };
    let line = if look.underlined {
        " text-decoration=\"underline\""
    } else {
        ""
    };
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    let baseline = y + CELL_HEIGHT * 0.78;
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{baseline:.1}\" textLength=\"{width:.1}\" fill=\"{}\"{bold}{dim}{line}>{text}</text>",
        look.ink
    );
}

/// The dots of a braille character, as the bits of Unicode; `None` for another character.
fn braille(c: char) -> Option<u8> {
    u8::try_from(u32::from(c).checked_sub(0x2800)?).ok()
}

/// The braille characters of a text as strokes of dots, because few fonts have them in the width of the other characters.
fn dots(text: &str, x: f64, y: f64) -> String {
    /// Bits of a character by row and column.
    const BITS: [[u8; 2]; 4] = [[0, 3], [1, 4], [2, 5], [6, 7]];
    let characters: Vec<u8> = text.chars().map(|c| braille(c).unwrap_or(0)).collect();
    let mut path = String::new();
    for (row, bits) in BITS.iter().enumerate() {
        let has_dot = |at: usize| {
            let character = characters.get(at / 2).copied().unwrap_or(0);
            character >> bits[at % 2] & 1 == 1
        };
        let mut at = 0;
        while at < 2 * characters.len() {
            let run = (at..2 * characters.len())
                .take_while(|at| has_dot(*at))
                .count();
            if run > 0 {
                let from_x = x + (at as f64 + 0.5) * DOT_WIDTH;
                let from_y = y + (row as f64 + 0.5) * CELL_HEIGHT / 4.0;
                // Each dash has no length and round ends. The stroke ends just behind its last one.
                let length = (run as f64 - 1.0) * DOT_WIDTH + 0.1;
                let _ = write!(path, "M{from_x:.1} {from_y:.1}h{length:.1}");
            }
            at += run.max(1);
        }
    }
    path
}

fn color(color: Color, default: &'static str) -> &'static str {
    match color {
        Color::Black => BACKGROUND,
        Color::Red => "#e06c75",
        Color::Green => "#8fbf7f",
        Color::Yellow => "#e5c07b",
        Color::Blue => "#61a0e8",
        Color::Magenta => "#c98bdb",
        Color::Cyan => "#5fc0c8",
        Color::Gray | Color::White => "#e6e8ec",
        Color::DarkGray | Color::Indexed(240..=245) => "#7d8590",
        Color::LightRed => "#ff8a93",
        Color::LightGreen => "#b2e39b",
        Color::LightYellow => "#ffd98f",
        Color::LightBlue => "#8fc1ff",
        Color::LightMagenta => "#e2aef0",
        Color::LightCyan => "#8be4ea",
        _ => default,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;
    use ratatui::style::Style;

    #[test]
    fn columns_stay_apart_in_a_browser() {
        let mut screen = Buffer::empty(Rect::new(0, 0, 20, 1));
        screen.set_string(0, 0, "0  user      idle", Style::new());
        let svg = still(&screen);
        assert!(svg.contains("<style>text{white-space:pre}"), "{svg}");
        assert!(svg.contains(">0  user      idle</text>"), "{svg}");
    }

    #[test]
    fn braille_is_drawn_as_dots_of_any_font() {
        let mut screen = Buffer::empty(Rect::new(0, 0, 20, 1));
        screen.set_string(0, 0, "a⠉⠉⠁b", Style::new());
        let svg = still(&screen);
        assert!(svg.contains("d=\"M10.5 2.1h16.9\""), "{svg}");
        assert!(svg.contains(">a   b</text>"), "{svg}");
    }
}
