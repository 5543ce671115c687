//! The status row: link and health, recording, clock, mode, battery.

use std::path::Path;

use groundwave_protocol::status_codes::{Mode, Power};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::layout::WIDTH_FULL;
use super::{Screen, put, put_right, width_of};
use crate::model::age;
use crate::model::link::{Connection, Health};
use crate::model::robot::{STATE_STALE, STATUS_STALE};
use crate::model::words;

impl Screen<'_> {
    pub(super) fn status(&self, buffer: &mut Buffer, area: Rect) {
        let right = Line::from(self.robot_at_a_glance(area.width));
        let right_width = width_of(&right.spans) as u16;
        let left = Rect {
            width: area.width.saturating_sub(right_width + 2),
            ..area
        };
        let mut spans = self.link_at_a_glance(usize::from(left.width));
        let taken = width_of(&spans);
        spans.push(Span::raw("  "));
        let room = usize::from(left.width).saturating_sub(taken + 2);
        spans.push(self.recording(room));
        let line = self.cut(Line::from(spans), usize::from(left.width));
        put(buffer, left, 0, &line);
        put_right(buffer, area, 0, &right);
    }

    /// Name, health, rate, loss and age of the link.
    fn link_at_a_glance(&self, room: usize) -> Vec<Span<'_>> {
        let link = &self.facts.link;
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        let name = if link.name.is_empty() {
            "no link"
        } else {
            &link.name
        };
        let newest = link.newest_age(self.now).map(age::words);
        let flow = || {
            let rate = format!("  {:.1}/s", link.lines_per_s(self.now));
            let loss = link
                .loss(self.now)
                .map(|loss| format!("  loss {:.1} %", loss * 100.0));
            let newest = newest.as_ref().map(|newest| format!("  newest {newest}"));
            [Some(rate), loss, newest].into_iter().flatten().collect()
        };
        let (glyph, style, words): (_, Style, String) =
            match link.health(self.now) {
                Health::Waiting => match self.instead_of_lines() {
                    Some(words) => (glyphs.silent, theme.warning, format!("  {words}")),
                    None => (glyphs.silent, theme.dim, "  no line yet".to_owned()),
                },
                Health::Good => (glyphs.good, theme.good, flow()),
                Health::Weak => (glyphs.weak, theme.warning, format!("  WEAK{}", flow())),
                Health::Silent => (
                    glyphs.silent,
                    theme.alarm,
                    format!(
                        "  SILENT for {}{}",
                        newest.unwrap_or_default(),
                        self.instead_of_lines()
                            .map_or(String::new(), |words| format!(": {words}"))
                    ),
                ),
                Health::Lost => (glyphs.bad, theme.alarm, self.lost()),
                Health::Ended => (
                    glyphs.ended,
                    theme.strong,
                    ended(room.saturating_sub(
                        shortened(name, NAME_COLUMNS).chars().count() + MARKS_COLUMNS,
                    )),
                ),
            };
        let calm = matches!(
            link.health(self.now),
            Health::Good | Health::Waiting | Health::Weak
        );
        vec![
            Span::styled(format!("{glyph} "), style),
            Span::styled(shortened(name, NAME_COLUMNS), theme.strong),
            Span::styled(words, if calm { theme.plain } else { style }),
        ]
    }

    /// The kind of bytes received if no line is intact.
    pub(super) fn instead_of_lines(&self) -> Option<String> {
        let (reception, age) = self.facts.link.instead_of_lines(self.now)?;
        Some(words::reception(reception, &age::words(age)))
    }

    fn lost(&self) -> String {
        let Connection::Lost { reason, since } = &self.facts.link.connection else {
            return String::new();
        };
        let since = age::words(self.now.saturating_sub(*since));
        format!("  LINK LOST {since}: {reason}; reconnecting")
    }

    /// The state of the recording in the longest words that fit.
    fn recording(&self, room: usize) -> Span<'_> {
        let recording = &self.present.recording;
        let theme = &self.theme;
        // The shortest variant always shows.
        let longest = |words: [String; 3]| {
            let [.., least] = words.clone();
            let mut fitting = words.into_iter().filter(|w| w.chars().count() <= room);
            fitting.next().unwrap_or(least)
        };
        if let Some(problem) = &recording.problem {
            let bad = theme.glyphs.bad;
            let long = format!("{bad} RECORDING FAILED: {problem}");
            return Span::styled(
                longest([
                    long,
                    format!("{bad} RECORDING FAILED"),
                    format!("{bad} REC"),
                ]),
                theme.alarm,
            );
        }
        let names: Vec<&str> = [&recording.tee, &recording.mcap]
            .into_iter()
            .flatten()
            .map(|path| file_name(path))
            .collect();
        if names.is_empty() {
            let words = if self.ui.is_replay() {
                String::new()
            } else {
                longest(["unrecorded", "no rec", ""].map(str::to_owned))
            };
            return Span::styled(words, theme.dim);
        }
        let glyph = theme.glyphs.recording;
        let long = format!("{glyph} {}", names.join(", "));
        Span::raw(longest([
            long,
            format!("{glyph} recording"),
            glyph.to_owned(),
        ]))
    }

    fn robot_at_a_glance(&self, width: u16) -> Vec<Span<'_>> {
        let theme = &self.theme;
        let robot = &self.facts.robot;
        let mut spans = Vec::new();
        let is_wide = width >= WIDTH_FULL;
        if let Some(failsafe) = self.failsafe_at_a_glance(is_wide) {
            spans.extend([failsafe, Span::raw("  ")]);
        }
        if let Some(time) = self.ui.time_of_day(self.now).filter(|_| is_wide) {
            let minutes = time.as_secs() / 60;
            let clock = format!("{:02}:{:02}Z  ", minutes / 60, minutes % 60);
            spans.push(Span::styled(clock, theme.dim));
        }
        if let Some(state) = robot.state {
            let style = match state.value.mode {
                _ if state.age(self.now) >= STATE_STALE => theme.dim,
                Mode::Stop => theme.warning,
                _ => theme.strong,
            };
            let mode = words::mode(state.value.mode).to_uppercase();
            let old = self.old_mark(state.age(self.now), STATE_STALE);
            spans.push(Span::styled(format!("{old}{mode}"), style));
        }
        if let Some(status) = robot.status {
            let power = robot.state.map_or(Power::Ok, |state| state.value.power);
            let style = match power {
                _ if status.age(self.now) >= STATUS_STALE => theme.dim,
                Power::Low | Power::Critical => theme.alarm,
                Power::Ok | Power::Docked | Power::Charging => theme.plain,
            };
            let volts = status.value.battery_dv;
            let words = words::power(power);
            let gap = if words.is_empty() { "" } else { " " };
            spans.push(Span::raw("  "));
            let old = self.old_mark(status.age(self.now), STATUS_STALE);
            spans.push(Span::styled(
                format!("{old}{}.{} V{gap}{words}", volts / 10, volts % 10),
                style,
            ));
        }
        spans
    }
}

/// Width of the marks for link and recording with their spaces, columns.
const MARKS_COLUMNS: usize = 5;

/// The longest text for an ended session that fits into `room` columns.
fn ended(room: usize) -> String {
    let words = [
        "  session ended; what you see is its last moment",
        "  session ended; its last moment",
        "  session ended",
    ];
    let fits = words.into_iter().find(|words| words.len() <= room);
    fits.unwrap_or("  ended").to_owned()
}

/// Maximum width of the link's name, columns.
const NAME_COLUMNS: usize = 24;

/// The last part of a path.
pub(super) fn file_name(path: &str) -> &str {
    Path::new(path)
        .file_name()
        .and_then(|name| name.to_str())
        .unwrap_or(path)
}

/// Shortens a name at its start: the end tells more.
pub(super) fn shortened(name: &str, width: usize) -> String {
    let length = name.chars().count();
    if length <= width {
        return name.to_owned();
    }
    let end: String = name.chars().skip(length - (width - 2)).collect();
    format!("..{end}")
}
