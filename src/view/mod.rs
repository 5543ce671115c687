//! The screen, drawn from the model without changing it.
//!
//! Below the status row there is a row for protections that are off, one for the shown moment in the past, and one for
//! unacknowledged alarms. No window covers the first two. From 110x34 up:
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
//! The robot from above, the plots, the alarms and the fields replace the sensors when chosen (F2 to F9, Tab). From 170x44 up all of them
//! but the fields have a column of their own, and if there is room the link is under the sensors, with plots. On a low screen the link's figures
//! replace the log when chosen. Each panel can be enlarged, and then shows more. Down to
//! 80x24 the chosen panel is under the ladder, and others follow as far as there is room:
//!
//! ```text
//! +----------------------- status -----------------------+
//! | map                       | ladder                   |
//! |                           +--------------------------+
//! |                           | the chosen panel         |
//! |                           |                          |
//! +---------------------------+--------------------------+
//! | raw                                                  |
//! | hint                                                 |
//! | keys                                                 |
//! +------------------------------------------------------+
//! ```

mod above;
mod alarms;
mod commands;
mod estimate;
mod fields;
mod footer;
mod hint;
mod ladder;
mod layout;
mod lines;
mod link;
mod log;
mod map;
mod overlay;
mod palette;
mod parameters;
mod pixels;
mod plots;
mod pointer;
mod projection;
mod raster;
mod raw;
mod reasons;
mod route;
mod runs;
mod sensors;
mod status;
#[cfg(test)]
mod tests;
mod text;
mod theme;
mod time;
mod tour;
mod why;

use std::cell::RefCell;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use crate::event::Moment;
use crate::model::SIZE_MIN;
use crate::model::keys::{Action, Context};
use crate::model::{Colors, Facts, Panel, Shown, Ui};
use crate::safe_text::is_control;
use layout::{HEIGHT_FULL, WIDTH_FULL};
#[cfg(test)]
use lines::CLIPPED;
use lines::{columns, fill, put, put_right, width_of};
pub use pixels::Picture;
use pointer::Mark;
pub use pointer::spot;
pub(crate) use text::wrap;
use theme::Theme;

/// Draws the whole dashboard on a blank buffer.
pub fn draw<'a>(shown: impl Into<Shown<'a>>, now: Moment, page: &mut Buffer) {
    draw_with_picture(shown, now, page);
}

/// Draws the whole dashboard on a blank buffer; returns the picture behind the map, if the configuration wants pixels.
pub fn draw_with_picture<'a>(
    shown: impl Into<Shown<'a>>,
    now: Moment,
    page: &mut Buffer,
) -> Option<Picture> {
    let area = page.area;
    let screen = Screen::of(shown.into(), now);
    screen.draw_all(page, area);
    // Ratatui drops C0 and C1 characters, and most other controls because of their width.
    for cell in &mut page.content {
        if cell.symbol().len() > 1 && cell.symbol().contains(is_control) {
            let symbol = cell.symbol().replace(is_control, "");
            cell.set_symbol(if symbol.is_empty() { " " } else { &symbol });
        }
    }
    screen.picture.into_inner()
}

/// The model and the clock that panels draw from.
struct Screen<'a> {
    facts: &'a Facts,
    /// The facts as of now; `facts` may be of an earlier moment.
    present: &'a Facts,
    ui: &'a Ui,
    /// Time of the robot's values; does not advance after the end of the session.
    now: Moment,
    /// Current time, for news.
    present_at: Moment,
    theme: Theme,
    /// Areas of the screen and the objects shown in them.
    marks: RefCell<Vec<(Rect, Mark)>>,
    /// The picture behind the map.
    picture: RefCell<Option<Picture>>,
}

impl<'m> Screen<'m> {
    fn of(shown: Shown<'m>, now: Moment) -> Self {
        Self {
            facts: shown.facts,
            present: shown.present,
            ui: shown.ui,
            now: shown.facts.link.clock(now),
            present_at: now,
            theme: Theme::of(&shown.ui.config),
            marks: RefCell::default(),
            picture: RefCell::default(),
        }
    }
}

impl Screen<'_> {
    fn draw_all(&self, buffer: &mut Buffer, area: Rect) {
        if self.ui.config.colors == Colors::HighContrast {
            // High contrast does not use the terminal's own colours.
            buffer.set_style(area, self.theme.plain);
        }
        if area.width < SIZE_MIN.0 || area.height < SIZE_MIN.1 {
            self.too_small(buffer, area);
        } else {
            self.draw(buffer, area);
        }
    }

    fn draw(&self, buffer: &mut Buffer, area: Rect) {
        let full = area.width >= WIDTH_FULL && area.height >= HEIGHT_FULL;
        let raw_rows = if full { 3 } else { 1 };
        let (status, rest) = split_top(area, 1);
        let (rest, keys) = split_bottom(rest, 1);
        let (rest, hint) = split_bottom(rest, 1);
        let step = self.ui.tour_step();
        let (rest, tour) = split_bottom(rest, u16::from(step.is_some()));
        let (rest, raw) = split_bottom(rest, raw_rows);
        self.status(buffer, status);
        let (protections, rest) = split_top(rest, u16::from(self.is_unprotected()));
        self.protections(buffer, protections);
        let windows = Rect {
            y: rest.y,
            height: area.bottom() - rest.y,
            ..area
        };
        let rest = match &self.ui.playback {
            Some(playback) => {
                let (time, rest) = split_top(rest, 1);
                self.time(buffer, time, playback);
                rest
            }
            None => rest,
        };
        let calls = !self.calling().is_empty() || self.stop_words().is_some();
        let (strip, rest) = split_top(rest, u16::from(calls));
        self.alarm_strip(buffer, strip);
        if full {
            self.raw_with_ruler(buffer, raw);
        } else {
            self.raw(buffer, raw);
        }
        if let Some(step) = step {
            self.tour(buffer, tour, step);
        }
        self.hint(buffer, hint);
        self.keys(buffer, keys);
        self.panels(buffer, rest, full);
        self.overlay(buffer, windows);
    }

    fn too_small(&self, buffer: &mut Buffer, area: Rect) {
        let text = [
            "groundwave".to_owned(),
            format!("needs {}x{}", SIZE_MIN.0, SIZE_MIN.1),
            format!("this is {}x{}", area.width, area.height),
            self.with_keys("<stop>: STOP"),
        ];
        let top = area.height.saturating_sub(text.len() as u16) / 2;
        for (row, text) in (top..).zip(text) {
            let indent = usize::from(area.width).saturating_sub(text.len()) / 2;
            let line = Line::styled(format!("{:indent$}{text}", ""), self.theme.plain);
            put(buffer, area, row, &line);
        }
    }

    /// The parts of the model that the screen is drawn from.
    const fn shown(&self) -> Shown<'_> {
        Shown {
            facts: self.facts,
            present: self.present,
            ui: self.ui,
        }
    }

    /// A text with the keys that it names.
    fn with_keys(&self, text: &str) -> String {
        self.ui.config.keys.with_keys(text)
    }

    /// Label of the key that shows a panel.
    fn panel_key(&self, panel: Panel) -> String {
        let keys = &self.ui.config.keys;
        keys.label(Context::Dashboard, Action::Show(panel))
    }

    /// The title of a panel, with its key.
    fn titled(&self, panel: Panel, title: &str) -> String {
        format!("{} {title}", self.panel_key(panel))
            .trim()
            .to_owned()
    }

    /// Draws a horizontal rule with a title at the left and a note at the right; returns the area below. The title's part after a colon
    /// is omitted if there is no room.
    fn panel(&self, buffer: &mut Buffer, area: Rect, title: &str, right: Option<Span<'_>>) -> Rect {
        let right = right.filter(|right| !right.content.is_empty());
        let needed = right
            .as_ref()
            .map_or(0, |right| columns(&right.content) + 4);
        let room = usize::from(area.width).saturating_sub(4 + needed);
        let title = match title.split_once(':') {
            Some((short, _)) if title.chars().count() > room => short,
            _ => title,
        };
        let (top, below) = split_top(area, 1);
        fill(buffer, top, self.theme.glyphs.rule, self.theme.rule);
        let titled = Rect {
            x: top.x.saturating_add(2),
            width: top.width.saturating_sub(2),
            ..top
        };
        let title = Line::styled(format!(" {title} "), self.theme.title);
        put(buffer, titled, 0, &title);
        if let Some(mut right) = right {
            right.content = format!(" {} ", right.content).into();
            let free = titled
                .width
                .saturating_sub(width_of(&title.spans) as u16 + 2);
            if columns(&right.content) as u16 <= free {
                let area = Rect {
                    width: top.width - 2,
                    ..top
                };
                put_right(buffer, area, 0, &Line::from(right));
            }
        }
        below
    }

    /// The mark before a stale value; empty while it is fresh.
    fn old_mark(&self, age: Moment, stale_after: Moment) -> String {
        if age >= stale_after {
            format!("{} ", self.theme.glyphs.stale)
        } else {
            String::new()
        }
    }

    /// The mark and age of a stale value; `None` while it is fresh.
    fn staleness(&self, age: Option<Moment>, stale_after: Moment) -> Option<String> {
        let age = age.filter(|age| *age >= stale_after)?;
        let words = crate::model::age::words(age);
        Some(format!("{} {words}", self.theme.glyphs.stale))
    }
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

/// Splits an area into two, with an empty column between them.
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
