//! The row of the tour: the current step, and the key that dismisses the tour.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Screen, put, put_right, width_of};
use crate::model::TourStep;

impl Screen<'_> {
    pub(super) fn tour(&self, buffer: &mut Buffer, area: Rect, step: TourStep) {
        let TourStep { number, of, text } = step;
        let theme = &self.theme;
        let line = Line::from(vec![
            Span::styled(format!(" tour {number}/{of} "), theme.lit),
            Span::styled(format!(" {}", self.with_keys(text)), theme.strong),
        ]);
        let dismissal = if self.ui.closing_ends_tour() {
            self.with_keys("<close>: no tour")
        } else {
            String::new()
        };
        let dismissal = Line::styled(dismissal, theme.dim);
        let room = usize::from(area.width).saturating_sub(width_of(&dismissal.spans) + 2);
        put(buffer, area, 0, &self.cut(line, room));
        put_right(buffer, area, 0, &dismissal);
    }
}
