//! Finds the object under the mouse by drawing the screen once more with marks.

use ratatui::buffer::Buffer;
use ratatui::layout::{Position, Rect};

use super::Screen;
use super::projection::Projection;
use crate::event::{Moment, Spot};
use crate::model::{Panel, Shown};

/// The object that a part of the screen shows.
pub(super) enum Mark {
    Map(Projection),
    Panel(Panel),
    Waypoint(usize),
}

/// The object in a cell of the screen, if it can be clicked.
#[must_use]
pub fn spot<'a>(
    shown: impl Into<Shown<'a>>,
    now: Moment,
    size: (u16, u16),
    column: u16,
    row: u16,
) -> Option<Spot> {
    let area = Rect::new(0, 0, size.0, size.1);
    let screen = Screen::of(shown.into(), now);
    screen.draw_all(&mut Buffer::empty(area), area);
    let at = Position { x: column, y: row };
    let marks = screen.marks.into_inner();
    let (_, mark) = marks.into_iter().rfind(|(part, _)| part.contains(at))?;
    match mark {
        Mark::Map(projection) => projection.floor(column, row),
        Mark::Waypoint(n) => Some(Spot::Waypoint(n)),
        Mark::Panel(panel) => Panel::ALL
            .iter()
            .position(|known| *known == panel)
            .map(Spot::Panel),
    }
}

impl Screen<'_> {
    /// Marks an area as showing an object.
    pub(super) fn claim(&self, area: Rect, mark: Mark) {
        self.marks.borrow_mut().push((area, mark));
    }
}
