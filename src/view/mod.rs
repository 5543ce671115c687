//! The screen. It sees the model and cannot change it.
//!
//! From 110x34 up every panel is on it:
//!
//! ```text
//! +------------------------------ status ------------------------------+
//! | map                                    | ladder                    |
//! |                                        |                           |
//! |                                        +---------------------------+
//! |                                        | sensors                   |
//! +----------------------------------------+---------------------------+
//! | commands                               | log                       |
//! |                                        | link                      |
//! +----------------------------------------+---------------------------+
//! | raw                                                                |
//! | hint                                                               |
//! | keys                                                               |
//! +--------------------------------------------------------------------+
//! ```
//!
//! Where the band of commands and log is low, the link's figures stand in the log's place when Tab has chosen
//! them. Below, down to 80x24, what stands under the ladder is what Tab has chosen, and the others as far as
//! there is room:
//!
//! ```text
//! +----------------------- status -----------------------+
//! | map                       | ladder                   |
//! |                           +--------------------------+
//! |                           | sensors, commands, log,  |
//! |                           | link                     |
//! +---------------------------+--------------------------+
//! | raw                                                  |
//! | hint                                                 |
//! | keys                                                 |
//! +------------------------------------------------------+
//! ```

mod commands;
mod footer;
mod hint;
mod ladder;
mod link;
mod log;
mod map;
mod overlay;
mod palette;
mod raster;
mod raw;
mod sensors;
mod status;
#[cfg(test)]
mod tests;
mod theme;

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use crate::event::Moment;
use crate::model::{Colors, Model, Panel};
use theme::Theme;

const WIDTH_MIN: u16 = 80;
const HEIGHT_MIN: u16 = 24;

/// From this size up every panel is visible.
const WIDTH_FULL: u16 = 110;
const HEIGHT_FULL: u16 = 34;

/// Rows that the log keeps beside the link's figures.
const LOG_ROWS_MIN: u16 = 5;

/// Draws the whole dashboard.
pub fn draw(model: &Model, now: Moment, frame: &mut Frame<'_>) {
    let area = frame.area();
    let buffer = frame.buffer_mut();
    let screen = Screen {
        model,
        now: model.link.clock(now),
        told_at: now,
        theme: Theme::of(&model.config),
    };
    if model.config.colors == Colors::HighContrast {
        // It counts on no colour of the terminal's own.
        buffer.set_style(area, screen.theme.plain);
    }
    if area.width < WIDTH_MIN || area.height < HEIGHT_MIN {
        screen.too_small(buffer, area);
    } else {
        screen.draw(buffer, area);
    }
}

/// What every panel draws from.
struct Screen<'a> {
    model: &'a Model,
    /// Stands still when the session does.
    now: Moment,
    /// Never stands still: for what is told in passing.
    told_at: Moment,
    theme: Theme,
}

impl Screen<'_> {
    fn draw(&self, buffer: &mut Buffer, area: Rect) {
        let full = area.width >= WIDTH_FULL && area.height >= HEIGHT_FULL;
        let raw_rows = if full { 3 } else { 1 };
        let (status, rest) = split_top(area, 1);
        let (rest, keys) = split_bottom(rest, 1);
        let (rest, hint) = split_bottom(rest, 1);
        let (rest, raw) = split_bottom(rest, raw_rows);
        self.status(buffer, status);
        if full {
            self.raw_with_ruler(buffer, raw);
        } else {
            self.raw(buffer, raw);
        }
        self.hint(buffer, hint);
        self.keys(buffer, keys);
        if full {
            self.all_panels(buffer, rest);
        } else {
            self.some_panels(buffer, rest);
        }
        self.overlay(buffer, area);
    }

    fn all_panels(&self, buffer: &mut Buffer, area: Rect) {
        let band_rows = (area.height.saturating_sub(ladder::ROWS + sensors::ROWS)).clamp(7, 18);
        let (upper, lower) = split_bottom(area, band_rows);
        let right_columns = (area.width * 2 / 5).clamp(46, 72);
        let (map, right) = split_right(upper, right_columns);
        self.map(buffer, map);
        let (ladder, sensors) = split_top(right, ladder::ROWS);
        self.ladder(buffer, ladder);
        self.sensors(buffer, sensors);
        let (commands, log) = split_right(lower, area.width / 2);
        self.commands(buffer, commands);
        let link_rows = self.link_height(log.width);
        if log.height >= link_rows.min(link::ROWS_MIN) + LOG_ROWS_MIN {
            let (log, link) = split_bottom(log, link_rows.min(log.height - LOG_ROWS_MIN));
            self.log(buffer, log);
            self.link(buffer, link);
        } else if self.model.panel == Panel::Link {
            self.link(buffer, log);
        } else {
            self.log(buffer, log);
        }
    }

    fn some_panels(&self, buffer: &mut Buffer, area: Rect) {
        let right_columns = (area.width * 2 / 5).clamp(40, 60);
        let (map, right) = split_right(area, right_columns);
        self.map(buffer, map);
        let (ladder, mut rest) = split_top(right, ladder::ROWS);
        self.ladder(buffer, ladder);
        let first = Panel::ALL
            .iter()
            .position(|panel| *panel == self.model.panel)
            .unwrap_or(0);
        let order = Panel::ALL.iter().cycle().skip(first).take(Panel::ALL.len());
        for (place, panel) in order.enumerate() {
            if place > 0 && rest.height < 5 {
                break;
            }
            let last = place + 1 == Panel::ALL.len();
            let rows = if last || rest.height < sensors::ROWS + 5 {
                rest.height
            } else {
                sensors::ROWS
            };
            let (here, below) = split_top(rest, rows);
            match panel {
                Panel::Sensors => self.sensors(buffer, here),
                Panel::Commands => self.commands(buffer, here),
                Panel::Log => self.log(buffer, here),
                Panel::Link => self.link(buffer, here),
            }
            rest = below;
        }
    }

    fn too_small(&self, buffer: &mut Buffer, area: Rect) {
        let text = [
            "groundwave".to_owned(),
            format!("needs {WIDTH_MIN}x{HEIGHT_MIN}"),
            format!("this is {}x{}", area.width, area.height),
            "Space: STOP".to_owned(),
        ];
        let top = area.height.saturating_sub(text.len() as u16) / 2;
        for (row, text) in (top..).zip(text) {
            let indent = usize::from(area.width).saturating_sub(text.len()) / 2;
            let line = Line::styled(format!("{:indent$}{text}", ""), self.theme.plain);
            put(buffer, area, row, &line);
        }
    }

    /// A rule with a title at its left and something short at its right; returns what is below.
    fn panel(&self, buffer: &mut Buffer, area: Rect, title: &str, right: Option<Span<'_>>) -> Rect {
        let (top, below) = split_top(area, 1);
        let rule = self.theme.glyphs.rule.repeat(usize::from(top.width));
        put(buffer, top, 0, &Line::styled(rule, self.theme.rule));
        let titled = Rect {
            x: top.x.saturating_add(2),
            width: top.width.saturating_sub(2),
            ..top
        };
        let title = Line::styled(format!(" {title} "), self.theme.title);
        put(buffer, titled, 0, &title);
        if let Some(mut right) = right.filter(|right| !right.content.is_empty()) {
            right.content = format!(" {} ", right.content).into();
            let free = titled.width.saturating_sub(title.width() as u16 + 2);
            if right.width() as u16 <= free {
                let area = Rect {
                    width: top.width - 2,
                    ..top
                };
                put_right(buffer, area, 0, &Line::from(right));
            }
        }
        below
    }

    /// A line that is too wide ends with a mark of that.
    fn cut<'l>(&self, line: Line<'l>, width: usize) -> Line<'l> {
        let blanks = line
            .spans
            .iter()
            .rev()
            .flat_map(|span| span.content.chars().rev());
        let blanks = blanks.take_while(|c| *c == ' ').count();
        if line.width() - blanks <= width {
            return line;
        }
        let more = self.theme.glyphs.cut;
        let mut room = width.saturating_sub(Span::raw(more).width());
        let mut spans: Vec<Span<'l>> = Vec::new();
        for mut span in line.spans {
            let wide = span.width();
            if wide > room {
                let fits: String = span.content.chars().take(room).collect();
                span.content = (fits.trim_end().to_owned() + more).into();
                spans.push(span);
                break;
            }
            room -= wide;
            spans.push(span);
        }
        Line::from(spans).style(line.style)
    }

    /// The mark and age of a value that has become stale; nothing while it is fresh.
    fn staleness(&self, age: Option<Moment>, stale_after: Moment) -> Option<String> {
        let age = age.filter(|age| *age >= stale_after)?;
        let words = crate::model::age::words(age);
        Some(format!("{} {words}", self.theme.glyphs.stale))
    }
}

/// Writes a line into a row of an area, clipped to it.
fn put(buffer: &mut Buffer, area: Rect, row: u16, line: &Line<'_>) {
    let area = area.intersection(buffer.area);
    if row < area.height {
        buffer.set_line(area.x, area.y + row, line, area.width);
    }
}

/// Writes a line flush right.
fn put_right(buffer: &mut Buffer, area: Rect, row: u16, line: &Line<'_>) {
    let width = (line.width() as u16).min(area.width);
    let x = area.right() - width;
    put(buffer, Rect { x, width, ..area }, row, line);
}

fn split_top(area: Rect, rows: u16) -> (Rect, Rect) {
    let rows = rows.min(area.height);
    (
        Rect {
            height: rows,
            ..area
        },
        Rect {
            y: area.y + rows,
            height: area.height - rows,
            ..area
        },
    )
}

fn split_bottom(area: Rect, rows: u16) -> (Rect, Rect) {
    split_top(area, area.height - rows.min(area.height))
}

/// Two areas side by side with a free column between them.
fn split_right(area: Rect, columns: u16) -> (Rect, Rect) {
    let columns = columns.min(area.width);
    let left = area.width - columns;
    (
        Rect {
            width: left.saturating_sub(1),
            ..area
        },
        Rect {
            x: area.x + left,
            width: columns,
            ..area
        },
    )
}
