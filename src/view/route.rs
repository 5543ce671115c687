//! The route editor: the draft as a list beside the map.

use groundwave_protocol::digest::digest;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::pointer::Mark;
use super::text::wrap;
use super::{Screen, put, split_bottom};
use crate::model::editor::Editor;

/// Average speed on a leg (in/s) and time for each turn (s). Measured in `sim --world open-room`: a square of 8 legs of 96 in takes 85 s,
/// a ring of 40 legs of 19 in, driven twice, 149 s.
const SPEED_IN_S: f64 = 11.0;
const TURN_S: f64 = 2.0;

/// Number of rows below the list: comparison with the robot's route, arrow keys, reason of a refused key.
const NOTES: u16 = 3;

impl Screen<'_> {
    pub(super) fn route(&self, buffer: &mut Buffer, area: Rect, editor: &Editor) {
        let theme = &self.theme;
        let draft = &self.ui.map.draft;
        let legs_in = draft.legs_in(self.facts.chart.pose());
        let count = draft.waypoints().len();
        let total_in: f64 = legs_in.iter().sum();
        let title = match count {
            0 => "route: empty".to_owned(),
            _ => format!(
                "route: {count}, {:.0} ft, about {}",
                total_in / 12.0,
                time(total_in, count)
            ),
        };
        let below = self.panel(
            buffer,
            area,
            &title,
            Some(Span::styled("draft", theme.draft)),
        );
        let (list, notes) = split_bottom(below, NOTES);
        let heading = Line::styled("    n      x      y    leg", theme.dim);
        put(buffer, list, 0, &heading);
        let rows = usize::from(list.height.saturating_sub(1));
        let selected = draft.selected().unwrap_or(0);
        let first = selected
            .saturating_sub(rows / 2)
            .min(count.saturating_sub(rows));
        let shown = draft.waypoints().iter().zip(&legs_in).enumerate();
        for (row, (n, (waypoint, leg_in))) in (1..).zip(shown.skip(first).take(rows)) {
            let (mark, style) = if n == selected {
                (theme.glyphs.cursor, theme.strong)
            } else {
                (" ", theme.plain)
            };
            let text = format!(
                "{mark} {:>3} {:>6} {:>6} {leg_in:>6.0}",
                n + 1,
                waypoint.x_in,
                waypoint.y_in
            );
            put(buffer, list, row, &Line::styled(text, style));
            self.claim(
                list.rows().nth(row.into()).unwrap_or_default(),
                Mark::Waypoint(n),
            );
        }
        if count == 0 {
            let text = match self.ui.map.cursor {
                Some(_) => {
                    "<route/route-append> adds one at the cursor, <route/route-ask-to-load> loads a file"
                }
                None => {
                    "<route/route-append> adds one where the robot is, <route/route-ask-to-load> loads a file"
                }
            };
            let room = usize::from(list.width);
            for (row, text) in (1..).zip(wrap(&self.with_keys(text), room, room)) {
                put(buffer, list, row, &Line::styled(text, theme.dim));
            }
        }
        let width = usize::from(notes.width);
        let against = Line::styled(self.against_robot(), theme.dim);
        put(buffer, notes, 0, &self.cut(against, width));
        let arrows = if editor.whole {
            ("all of it (<route/route-whole>: only one)", theme.strong)
        } else {
            ("the marked one (<route/route-whole>: all)", theme.dim)
        };
        let (what, style) = arrows;
        let arrows = self.with_keys(&format!("<route/route-step-left..> move {what}"));
        put(
            buffer,
            notes,
            1,
            &self.cut(Line::styled(arrows, style), width),
        );
        if let Some(problem) = &editor.problem {
            let problem = Line::styled(problem.clone(), theme.warning);
            put(buffer, notes, 2, &self.cut(problem, width));
        }
    }

    /// The draft compared with the robot's route.
    fn against_robot(&self) -> String {
        let draft = self.ui.map.draft.waypoints();
        let Some(status) = self.facts.robot.status else {
            return "robot's route unknown".to_owned();
        };
        let status = status.value;
        let (driven, count) = (status.list.driven, status.list.count);
        if !draft.is_empty() && status.digest == digest(draft.iter()) {
            return format!("same as the robot's route, {driven} of {count} driven");
        }
        self.with_keys(&match count {
            0 => "the robot has no route; <route/route-send> sends this".to_owned(),
            _ => format!(
                "the robot has another route of {count}, {driven} driven; <route/route-send> replaces it"
            ),
        })
    }
}

/// Estimated time of a route as minutes and seconds: `0:45` or `12:05`.
fn time(distance_in: f64, waypoints: usize) -> String {
    let seconds = (distance_in / SPEED_IN_S + TURN_S * waypoints as f64).round() as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}
