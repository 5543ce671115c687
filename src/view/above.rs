//! The robot from above: its sensors in their places, highlighted when they trigger, and its wheels.

use groundwave_protocol::status_codes::{Arm, Bump, Cliff, Drive, Infrared};
use groundwave_protocol::telemetry::StateLine;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::{Screen, put};
use crate::model::robot::{STATE_STALE, ordered_wheels_in_s};
use crate::model::{Panel, why, words};

/// Width of the picture, columns.
const COLUMNS: u16 = 38;

/// Height of the panel with long cones, rows.
pub(super) const ROWS: u16 = 1 + 3 + BODY_ROWS;
const BODY_ROWS: u16 = 5;

/// Ranges below which a cone is one row shorter, inches.
const CONE_STEPS_IN: [u16; 2] = [60, 30];

/// Range below which an echo is highlighted, inches.
const NEAR_IN: u16 = 30;

/// An area for placing texts.
struct Canvas<'b> {
    buffer: &'b mut Buffer,
    area: Rect,
}

impl Canvas<'_> {
    fn at(&mut self, column: u16, row: u16, text: impl Into<String>, style: Style) {
        let place = Rect {
            x: self.area.x.saturating_add(column),
            width: self.area.width.saturating_sub(column),
            ..self.area
        };
        if place.width > 0 {
            put(self.buffer, place, row, &Line::styled(text.into(), style));
        }
    }
}

impl Screen<'_> {
    pub(super) fn above(&self, buffer: &mut Buffer, area: Rect) {
        let state = self.facts.robot.state;
        let note = self.staleness(state.map(|state| state.age(self.now)), STATE_STALE);
        let note = note.map(|note| Span::styled(note, self.theme.warning));
        let below = self.panel(buffer, area, &self.titled(Panel::Above, "from above"), note);
        let Some(state) = state else {
            put(
                buffer,
                below,
                0,
                &Line::styled("no data yet", self.theme.dim),
            );
            return;
        };
        let is_stale = state.age(self.now) >= STATE_STALE;
        let long = if area.height >= ROWS { 3 } else { 1 };
        let indent = below.width.saturating_sub(COLUMNS) / 2;
        let mut canvas = Canvas {
            buffer,
            area: Rect {
                x: below.x + indent,
                width: below.width - indent,
                ..below
            },
        };
        // Stale values are dim but keep their shapes.
        let lit = |style: Style| if is_stale { self.theme.dim } else { style };
        self.cones(&mut canvas, &state.value, long, lit);
        self.front(&mut canvas, &state.value, long, lit);
        self.inside(&mut canvas, &state.value, long, lit);
    }

    /// Draws the sonar beams; a nearer echo is a shorter cone.
    fn cones(
        &self,
        canvas: &mut Canvas<'_>,
        state: &StateLine,
        rows: u16,
        lit: impl Fn(Style) -> Style,
    ) {
        let theme = &self.theme;
        let strokes = if theme.glyphs.ascii {
            ["\\", "/"]
        } else {
            ["╲", "╱"]
        };
        let echoes = [state.sonar_left_in, state.sonar_right_in];
        for (side, (echo, stroke)) in echoes.into_iter().zip(strokes).enumerate() {
            let near = echo.is_some_and(|range_in| range_in < NEAR_IN);
            let style = lit(if near { theme.holder } else { theme.plain });
            let words = format!("{}{}", why::range(echo), if near { " !" } else { "" });
            let nearer = |range_in: u16| {
                CONE_STEPS_IN
                    .iter()
                    .filter(|step| range_in < **step)
                    .count()
            };
            let length = echo.map_or(0, |range_in| {
                rows.saturating_sub(nearer(range_in) as u16).max(1)
            });
            for n in 0..length {
                let row = rows - 1 - n;
                let column = if side == 0 { 15 - 2 * n } else { 22 + 2 * n };
                canvas.at(column, row, stroke, style);
            }
            let column = if side == 0 {
                10_u16.saturating_sub(words.chars().count() as u16)
            } else {
                28
            };
            canvas.at(column, 0, words, style);
        }
    }

    /// Draws the bumper's three parts and the infrared detectors beside it.
    fn front(
        &self,
        canvas: &mut Canvas<'_>,
        state: &StateLine,
        row: u16,
        lit: impl Fn(Style) -> Style,
    ) {
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        let pressed = match state.bump {
            Bump::None | Bump::NotFitted => [false; 3],
            Bump::Left => [true, false, false],
            Bump::Center => [false, true, false],
            Bump::Right => [false, false, true],
            Bump::LeftCenter => [true, true, false],
            Bump::RightCenter => [false, true, true],
            Bump::Sides => [true, false, true],
            Bump::All | Bump::Jammed => [true; 3],
        };
        let free = if state.bump == Bump::NotFitted {
            " "
        } else {
            glyphs.rule
        };
        let hit = if state.bump == Bump::Jammed {
            "J"
        } else {
            glyphs.bump
        };
        for (part, (column, width)) in pressed.into_iter().zip([(9, 6), (15, 8), (23, 6)]) {
            let (glyph, style) = if part {
                (hit, theme.holder)
            } else {
                (free, theme.dim)
            };
            canvas.at(column, row, glyph.repeat(width), lit(style));
        }
        let corner = if glyphs.ascii {
            ["+", "+"]
        } else {
            ["╭", "╮"]
        };
        canvas.at(8, row, corner[0], theme.dim);
        canvas.at(29, row, corner[1], theme.dim);
        let sees = match state.infrared {
            Infrared::Left => [true, false],
            Infrared::Right => [false, true],
            Infrared::Both => [true, true],
            Infrared::None | Infrared::Jammed | Infrared::NotFitted => [false; 2],
        };
        let quiet = match state.infrared {
            Infrared::Jammed => "off",
            Infrared::NotFitted => "-",
            _ => glyphs.quiet,
        };
        for (sees, column) in sees.into_iter().zip([2, 31]) {
            let (text, style) = if sees {
                (format!("IR {}", glyphs.infrared.repeat(2)), theme.raised)
            } else {
                (format!("IR {quiet}"), theme.dim)
            };
            canvas.at(column, row, text, lit(style));
        }
    }

    /// Draws edge sensors, photocells, motion and wheels.
    fn inside(
        &self,
        canvas: &mut Canvas<'_>,
        state: &StateLine,
        front: u16,
        lit: impl Fn(Style) -> Style,
    ) {
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        let side = if glyphs.ascii { "|" } else { "│" };
        for row in front + 1..front + 4 {
            canvas.at(8, row, side, theme.dim);
            canvas.at(29, row, side, theme.dim);
        }
        let edges = match state.cliff {
            Cliff::Left => [true, false, false],
            Cliff::Center => [false, true, false],
            Cliff::Right => [false, false, true],
            Cliff::Several => [true; 3],
            Cliff::None | Cliff::NotFitted => [false; 3],
        };
        if state.cliff == Cliff::NotFitted {
            canvas.at(12, front + 1, "no edge sensors", lit(theme.dim));
        } else {
            for (edge, column) in edges.into_iter().zip([10, 17, 24]) {
                let (text, style) = if edge {
                    ("EDGE", theme.alarm)
                } else {
                    (glyphs.quiet, theme.dim)
                };
                canvas.at(column, front + 1, text, lit(style));
            }
        }
        let cells = [state.photo_left_pct, state.photo_right_pct];
        for (dark_pct, column) in cells.into_iter().zip([10, 22]) {
            let words = dark_pct.map_or("no cell".to_owned(), |pct| format!("{pct:>2} %"));
            canvas.at(column, front + 2, words, lit(theme.plain));
        }
        canvas.at(16, front + 2, "dark", lit(theme.dim));
        let motion = match state.arm {
            Arm::MotionLeft => [true, false],
            Arm::MotionRight => [false, true],
            Arm::MotionBoth => [true, true],
            _ => [false; 2],
        };
        for (moves, column) in motion.into_iter().zip([10, 27]) {
            if moves {
                canvas.at(column, front + 3, glyphs.holds, lit(theme.holder));
            }
        }
        let arm = match state.arm {
            Arm::NotFitted => "no arm",
            Arm::Stowed => "arm stowed",
            Arm::Up => "arm up",
            Arm::Armed => "arm armed",
            Arm::MotionLeft => "motion left",
            Arm::MotionRight => "motion right",
            Arm::MotionBoth => "motion ahead",
            Arm::TopHat => "arm: top hat",
        };
        canvas.at(12, front + 3, arm, lit(theme.plain));
        self.wheels(canvas, state, front, &lit);
        let corner = if glyphs.ascii {
            ["+", "+"]
        } else {
            ["╰", "╯"]
        };
        let rule = format!("{}{}{}", corner[0], glyphs.rule.repeat(20), corner[1]);
        canvas.at(8, front + 4, rule, theme.dim);
        let drive = match state.drive {
            Drive::Ok => String::new(),
            drive => format!(" {} ", words::drive(drive)),
        };
        canvas.at(11, front + 4, drive, lit(theme.warning));
    }

    /// Draws each wheel's measured and ordered speed.
    fn wheels(
        &self,
        canvas: &mut Canvas<'_>,
        state: &StateLine,
        front: u16,
        lit: impl Fn(Style) -> Style,
    ) {
        let theme = &self.theme;
        let [ahead, _, _, _, back, ..] = theme.glyphs.arrows;
        let measured = [state.wheel_left_in_s, state.wheel_right_in_s];
        let ordered = ordered_wheels_in_s(state);
        for ((measured, ordered), column) in measured.into_iter().zip(ordered).zip([7, 30]) {
            let arrow = match measured.signum() {
                1 => ahead,
                -1 => back,
                _ => theme.glyphs.off,
            };
            for row in [front + 1, front + 3] {
                canvas.at(column, row, arrow, lit(theme.strong));
            }
            let beside = if column == 7 { 0 } else { 32 };
            canvas.at(column, front + 2, arrow, lit(theme.strong));
            canvas.at(
                beside,
                front + 1,
                format!("{measured:+3}"),
                lit(theme.strong),
            );
            canvas.at(beside, front + 2, format!("of {ordered:+}"), lit(theme.dim));
        }
    }
}
