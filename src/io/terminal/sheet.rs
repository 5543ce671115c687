//! What the terminal shows, and the fewest bytes that make it show something else.

use std::mem;

use ratatui::buffer::{Buffer, Cell, CellWidth};
use ratatui::layout::{Position, Rect};
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

    const fn is_plain(&self) -> bool {
        matches!(self.fg, Color::Reset)
            && matches!(self.bg, Color::Reset)
            && self.modifier.is_empty()
    }

    /// Whether a character looks right when it is written like this; of a blank less is seen.
    fn suits(self, wanted: Self, is_blank: bool) -> bool {
        let is_blank = is_blank && self.bg == wanted.bg;
        self == wanted || is_blank && !(self.modifier | wanted.modifier).intersects(ON_BLANKS)
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

/// What a cell of the terminal shows.
#[derive(Clone, Copy)]
struct Glyph {
    symbol: Symbol,
    columns: u8,
    pen: Pen,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Symbol {
    Character(char),
    /// Several characters that are joined to one, as some names have them: a place among those that were drawn so far.
    Joined(u16),
    /// Only the terminal knows: what is there when a wide character goes, or when it joins otherwise than we do.
    Unknown,
}

impl Glyph {
    const BLANK: Self = Self {
        symbol: Symbol::Character(' '),
        columns: 1,
        pen: PLAIN,
    };

    const UNKNOWN: Self = Self {
        symbol: Symbol::Unknown,
        ..Self::BLANK
    };
}

/// A frame in memory, on its way to the terminal. Nothing is asked of the terminal.
pub(super) struct Sheet {
    /// What the next frame is drawn on: blank between two of them.
    page: Buffer,
    /// Row by row.
    shown: Vec<Glyph>,
    /// What [`Symbol::Joined`] stands for.
    joined: Vec<Box<str>>,
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
        let page = Buffer::empty(Rect::new(0, 0, width, height));
        Self {
            shown: vec![Glyph::BLANK; page.content.len()],
            page,
            joined: Vec::new(),
            bytes: b"\x1b[m\x1b[2J".to_vec(),
            pen: PLAIN,
            at: None,
            is_sure: false,
        }
    }

    /// Columns and rows.
    pub(super) const fn size(&self) -> (u16, u16) {
        (self.page.area.width, self.page.area.height)
    }

    /// Takes a frame; returns what the terminal has to be sent.
    pub(super) fn draw(&mut self, draw: impl FnOnce(&mut Buffer)) -> Vec<u8> {
        draw(&mut self.page);
        let width = self.page.area.width.max(1).into();
        let (mut page, mut shown) = (mem::take(&mut self.page), mem::take(&mut self.shown));
        let rows = page.content.chunks_exact_mut(width);
        for (y, (row, shown)) in (0..).zip(rows.zip(shown.chunks_exact_mut(width))) {
            self.draw_row(y, row, shown);
        }
        (self.page, self.shown) = (page, shown);
        mem::take(&mut self.bytes)
    }

    /// Writes what is new in a row, and leaves the row blank.
    fn draw_row(&mut self, y: u16, row: &mut [Cell], shown: &mut [Glyph]) {
        // Up to here a wide character reaches.
        let mut covered = 0;
        for (x, cell) in row.iter_mut().enumerate() {
            if x < covered {
                shown[x] = Glyph::UNKNOWN;
            } else {
                if !self.is_shown(&shown[x], cell) {
                    self.replace(x, y, cell, shown);
                }
                covered = x + usize::from(shown[x].columns);
            }
            cell.reset();
        }
    }

    /// Whether a cell would look the same. Asked of every cell in every frame.
    fn is_shown(&self, glyph: &Glyph, cell: &Cell) -> bool {
        let symbol = cell.symbol();
        let is_same = match (glyph.symbol, symbol.as_bytes()) {
            (Symbol::Character(character), &[byte]) => character == char::from(byte),
            (Symbol::Character(character), _) => symbol.chars().eq([character]),
            (Symbol::Joined(place), _) => *self.joined[usize::from(place)] == *symbol,
            (Symbol::Unknown, _) => false,
        };
        // Most are plain, which is seen at a glance.
        let are_plain = || glyph.pen.is_plain() && Pen::of(cell).is_plain();
        is_same && (are_plain() || glyph.pen.suits(Pen::of(cell), symbol == " "))
    }

    /// Writes one cell of a row: few do, so that the way past it is kept short.
    #[inline(never)]
    fn replace(&mut self, x: usize, y: u16, cell: &Cell, row: &mut [Glyph]) {
        let text = cell.symbol();
        let symbol = self.symbol(text);
        // Nobody draws a character that is wider than the widest terminal.
        let columns = u8::try_from(text.cell_width()).unwrap_or(u8::MAX);
        let pen = Pen::of(cell);
        let is_joined = !matches!(symbol, Symbol::Character(_));
        if is_joined {
            // Terminals do not agree on how these join: what one leaves free is to be blank, and what another draws over,
            // each character for itself, is to be written again.
            self.go_to(x as u16, y, row);
            self.write(&" ".repeat(columns.into()), pen);
            self.at = None;
            let widths = text.chars().map(|c| c.to_string().cell_width());
            let end = x + usize::from(widths.sum::<u16>().max(columns.into()));
            let end = end.min(row.len());
            row[x..end].fill(Glyph::UNKNOWN);
        }
        self.go_to(x as u16, y, row);
        self.write(text, pen);
        row[x] = Glyph {
            symbol,
            columns,
            pen,
        };
        let x = x + 1;
        self.at = (x < row.len() && !is_joined).then_some(Position { x: x as u16, y });
    }

    /// What stands for a text of one cell.
    fn symbol(&mut self, text: &str) -> Symbol {
        let mut characters = text.chars();
        if let (Some(character), None) = (characters.next(), characters.next()) {
            return Symbol::Character(character);
        }
        let known = self.joined.iter().position(|known| **known == *text);
        let place = known.unwrap_or_else(|| {
            self.joined.push(text.into());
            self.joined.len() - 1
        });
        // With more than there are in any script, they are written with every frame.
        u16::try_from(place).map_or(Symbol::Unknown, Symbol::Joined)
    }

    /// The shortest way for the cursor, to a place in a row that shows this.
    fn go_to(&mut self, x: u16, y: u16, row: &[Glyph]) {
        if self.at == Some(Position { x, y }) {
            return;
        }
        let mut way = if x == 0 {
            format!("\x1b[{}H", y + 1)
        } else {
            format!("\x1b[{};{}H", y + 1, x + 1)
        };
        if let Some(at) = self.at.filter(|_| self.is_sure) {
            let others = [self.over(at, x, y, row), beside(at, x, y)];
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
    fn over(&self, at: Position, x: u16, y: u16, row: &[Glyph]) -> Option<String> {
        if at.y != y || x < at.x {
            return None;
        }
        let between = &row[usize::from(at.x)..usize::from(x)];
        let easy = |glyph: &Glyph| match glyph.symbol {
            Symbol::Character(c @ ' '..='~') => self.pen.suits(glyph.pen, c == ' ').then_some(c),
            _ => None,
        };
        between.iter().map(easy).collect()
    }

    fn write(&mut self, symbol: &str, pen: Pen) {
        if !self.pen.suits(pen, symbol == " ") {
            let codes = self.pen.change(pen);
            self.bytes
                .extend_from_slice(format!("\x1b[{codes}m").as_bytes());
            self.pen = pen;
        }
        self.bytes.extend_from_slice(symbol.as_bytes());
        self.is_sure &= symbol.is_ascii();
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

#[cfg(test)]
mod tests;
