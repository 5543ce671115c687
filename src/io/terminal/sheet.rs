//! What the terminal shows, and the fewest bytes that make it show something else.

use std::io;
use std::mem;

use ratatui::backend::{Backend, ClearType, WindowSize};
use ratatui::buffer::{Buffer, Cell};
use ratatui::layout::{Position, Rect, Size};
use ratatui::style::{Color, Modifier};

/// Everything that shows on a blank too.
const ON_BLANKS: Modifier = Modifier::all()
    .difference(Modifier::BOLD)
    .difference(Modifier::DIM)
    .difference(Modifier::ITALIC);

/// The codes of a modifier: on and off.
const MODIFIERS: [(Modifier, &str, &str); 9] = [
    (Modifier::BOLD, "1", "22"),
    (Modifier::DIM, "2", "22"),
    (Modifier::ITALIC, "3", "23"),
    (Modifier::UNDERLINED, "4", "24"),
    (Modifier::SLOW_BLINK, "5", "25"),
    (Modifier::RAPID_BLINK, "6", "25"),
    (Modifier::REVERSED, "7", "27"),
    (Modifier::HIDDEN, "8", "28"),
    (Modifier::CROSSED_OUT, "9", "29"),
];

/// How the next character will look.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Pen {
    fg: Color,
    bg: Color,
    modifier: Modifier,
}

const PLAIN: Pen = Pen {
    fg: Color::Reset,
    bg: Color::Reset,
    modifier: Modifier::empty(),
};

impl Pen {
    const fn of(cell: &Cell) -> Self {
        Self {
            fg: cell.fg,
            bg: cell.bg,
            modifier: cell.modifier,
        }
    }

    /// Whether a cell looks right when it is written like this; of a blank less is seen.
    fn suits(self, cell: &Cell) -> bool {
        let wanted = Self::of(cell);
        let is_blank = cell.symbol() == " " && self.bg == cell.bg;
        self == wanted || is_blank && !(self.modifier | cell.modifier).intersects(ON_BLANKS)
    }

    /// The shorter of two ways to another look: from here, or from nothing.
    fn change(self, to: Self) -> String {
        let anew = PLAIN.codes(to, "");
        let anew = if anew.is_empty() {
            anew
        } else {
            format!("0;{anew}")
        };
        let mut off = "";
        let mut kept = self;
        for (modifier, _, code) in MODIFIERS {
            if (self.modifier - to.modifier).contains(modifier) && off.is_empty() {
                off = code;
            }
        }
        // One code takes away what it takes away; when several would be needed, beginning anew is shorter.
        for (modifier, _, code) in MODIFIERS {
            if code == off {
                kept.modifier.remove(modifier);
            }
        }
        let on_from_here = kept.codes(to, off);
        if to.modifier.contains(kept.modifier) && on_from_here.len() < anew.len() {
            on_from_here
        } else {
            anew
        }
    }

    /// What has to be added for another look, behind what is said already.
    fn codes(self, to: Self, said: &str) -> String {
        let mut codes: Vec<String> = Vec::new();
        if !said.is_empty() {
            codes.push(said.to_owned());
        }
        let mut new = to.modifier - self.modifier;
        // Some terminals know one brightness at a time, the last that was said: it must not depend on what was before.
        if new.contains(Modifier::BOLD) {
            new |= to.modifier & Modifier::DIM;
        }
        let on = MODIFIERS
            .iter()
            .filter(|(modifier, ..)| new.contains(*modifier));
        codes.extend(on.map(|(_, code, _)| (*code).to_owned()));
        if self.fg != to.fg {
            codes.push(color(to.fg, 30));
        }
        if self.bg != to.bg {
            codes.push(color(to.bg, 40));
        }
        codes.join(";")
    }
}

/// The code of a colour; `base` is 30 for letters and 40 for what is behind them.
fn color(color: Color, base: u8) -> String {
    let basic = |n: u8| (base + n).to_string();
    let bright = |n: u8| (base + 60 + n).to_string();
    match color {
        Color::Reset => basic(9),
        Color::Black => basic(0),
        Color::Red => basic(1),
        Color::Green => basic(2),
        Color::Yellow => basic(3),
        Color::Blue => basic(4),
        Color::Magenta => basic(5),
        Color::Cyan => basic(6),
        Color::Gray => basic(7),
        Color::DarkGray => bright(0),
        Color::LightRed => bright(1),
        Color::LightGreen => bright(2),
        Color::LightYellow => bright(3),
        Color::LightBlue => bright(4),
        Color::LightMagenta => bright(5),
        Color::LightCyan => bright(6),
        Color::White => bright(7),
        Color::Indexed(n) => format!("{};5;{n}", base + 8),
        Color::Rgb(r, g, b) => format!("{};2;{r};{g};{b}", base + 8),
    }
}

/// A frame in memory, on its way to the terminal. Nothing is asked of the terminal.
pub(super) struct Sheet {
    shown: Buffer,
    bytes: Vec<u8>,
    pen: Pen,
    /// Where the next character goes, if the terminal is not at a margin.
    at: Option<Position>,
    /// Whether the terminal surely agrees on that. How wide it draws what is not ASCII only it knows.
    is_sure: bool,
}

impl Sheet {
    /// An empty one, whatever was there before.
    pub(super) fn new(width: u16, height: u16) -> Self {
        Self {
            shown: Buffer::empty(Rect::new(0, 0, width, height)),
            bytes: b"\x1b[m\x1b[2J".to_vec(),
            pen: PLAIN,
            at: None,
            is_sure: false,
        }
    }

    /// What the terminal has to be sent.
    pub(super) fn take(&mut self) -> Vec<u8> {
        mem::take(&mut self.bytes)
    }

    /// The shortest way for the cursor.
    fn go_to(&mut self, x: u16, y: u16) {
        if self.at == Some(Position { x, y }) {
            return;
        }
        let mut way = if x == 0 {
            format!("\x1b[{}H", y + 1)
        } else {
            format!("\x1b[{};{}H", y + 1, x + 1)
        };
        if let Some(at) = self.at.filter(|_| self.is_sure) {
            let others = [self.over(at, x, y), beside(at, x, y)];
            for other in others.into_iter().flatten() {
                if other.len() < way.len() {
                    way = other;
                }
            }
        } else {
            self.is_sure = true;
        }
        self.bytes.extend_from_slice(way.as_bytes());
    }

    /// What stands between, once more, if nothing but ASCII does and it looks as the pen writes.
    fn over(&self, at: Position, x: u16, y: u16) -> Option<String> {
        if at.y != y || x < at.x {
            return None;
        }
        let between = (at.x..x).map(|x| &self.shown[(x, y)]);
        let is_easy = |cell: &Cell| cell.symbol().is_ascii() && self.pen.suits(cell);
        between
            .map(|cell| is_easy(cell).then(|| cell.symbol()))
            .collect()
    }

    fn write(&mut self, cell: &Cell) {
        if !self.pen.suits(cell) {
            let to = Pen::of(cell);
            let codes = self.pen.change(to);
            self.bytes
                .extend_from_slice(format!("\x1b[{codes}m").as_bytes());
            self.pen = to;
        }
        self.bytes.extend_from_slice(cell.symbol().as_bytes());
        self.is_sure &= cell.symbol().is_ascii();
    }
}

/// From where the cursor is, to the right or one row down.
fn beside(at: Position, x: u16, y: u16) -> Option<String> {
    let down = match y.checked_sub(at.y)? {
        0 => "",
        1 => "\x1b[B",
        _ => return None,
    };
    if x == 0 {
        return Some(format!("{down}\r"));
    }
    let across = match (x.checked_sub(at.x), at.x.checked_sub(x)) {
        (Some(0), _) => String::new(),
        (Some(1), _) => "\x1b[C".to_owned(),
        (Some(right), _) => format!("\x1b[{right}C"),
        (None, Some(left @ ..4)) => "\x08".repeat(left.into()),
        (None, left) => format!("\x1b[{}D", left?),
    };
    Some(format!("{down}{across}"))
}

impl Backend for Sheet {
    type Error = io::Error;

    fn draw<'a, I>(&mut self, content: I) -> io::Result<()>
    where
        I: Iterator<Item = (u16, u16, &'a Cell)>,
    {
        for (x, y, cell) in content {
            self.go_to(x, y);
            self.write(cell);
            self.at = (x + 1 < self.shown.area.width).then_some(Position { x: x + 1, y });
            self.shown[(x, y)] = cell.clone();
        }
        Ok(())
    }

    fn hide_cursor(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn show_cursor(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn get_cursor_position(&mut self) -> io::Result<Position> {
        Ok(Position::ORIGIN)
    }

    fn set_cursor_position<P: Into<Position>>(&mut self, _: P) -> io::Result<()> {
        Ok(())
    }

    fn clear(&mut self) -> io::Result<()> {
        *self = Self::new(self.shown.area.width, self.shown.area.height);
        Ok(())
    }

    fn clear_region(&mut self, _: ClearType) -> io::Result<()> {
        self.clear()
    }

    fn size(&self) -> io::Result<Size> {
        Ok(self.shown.area.as_size())
    }

    fn window_size(&mut self) -> io::Result<WindowSize> {
        Ok(WindowSize {
            columns_rows: self.size()?,
            pixels: Size::ZERO,
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
