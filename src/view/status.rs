//! The status row: link and health, recording, clock, mode, battery.

use std::borrow::Cow;
use std::path::Path;

use groundwave_protocol::status_codes::{Link as Letter, Mode, Power};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::layout::WIDTH_FULL;
use super::{Screen, columns, put, put_right, width_of};
use crate::model::age;
use crate::model::alarms::{LINK_LOST, ROBOT_SILENT};
use crate::model::link::{Connection, Health, Shares};
use crate::model::robot::{STATE_STALE, STATUS_STALE};
use crate::model::words;

impl Screen<'_> {
    pub(super) fn status(&self, buffer: &mut Buffer, area: Rect) {
        let lights = Line::from(self.lights().to_vec());
        let lights_width = width_of(&lights.spans) as u16;
        put_right(buffer, area, 0, &lights);
        let area = Rect {
            width: area.width.saturating_sub(lights_width),
            ..area
        };
        let right = Line::from(self.robot_at_a_glance(area.width + lights_width));
        let right_width = width_of(&right.spans) as u16;
        let left = Rect {
            width: area.width.saturating_sub(right_width + 2),
            ..area
        };
        let mut spans = self.link_at_a_glance(usize::from(left.width));
        let taken = width_of(&spans);
        spans.push(Span::raw("  "));
        let room = usize::from(left.width).saturating_sub(taken + 2);
        spans.extend(self.recording(room));
        let line = self.cut(Line::from(spans), usize::from(left.width));
        put(buffer, left, 0, &line);
        put_right(buffer, area, 0, &right);
    }

    /// Commands by the station itself, read-only, failsafe and recording, each at its place at the right end.
    fn lights(&self) -> [Span<'_>; 4] {
        let theme = &self.theme;
        let link = &self.facts.link;
        let has_robot = !self.ui.is_replay() && link.connection != Connection::Ended;
        let is_read_only = has_robot && link.is_receive_only();
        let read_only = if is_read_only { "  READ ONLY" } else { "" };
        let (automatic, automatic_style) = match self.ui.is_automatic(self.present_at) {
            Some(false) => ("  AUTO       ", theme.warning),
            Some(true) => ("  AUTO paused", theme.dim),
            None => ("", theme.plain),
        };
        let (failsafe, style) = match self.facts.robot.state.map(|state| state.value.link) {
            Some(Letter::Armed) => ("  failsafe", theme.plain),
            Some(Letter::Failsafe) => ("  FAILSAFE", theme.alarm),
            Some(Letter::Ok) | None if self.ui.is_replay() => ("", theme.plain),
            // A place of its own, so that it moves nothing.
            Some(Letter::Ok) | None => ("          ", theme.plain),
        };
        let recording = &self.present.recording;
        let (words, recording_style) = match (&recording.problem, &recording.tee, &recording.mcap) {
            (Some(_), ..) => (format!("  {} REC", theme.glyphs.bad), theme.alarm),
            (None, None, None) if self.ui.is_replay() => (String::new(), theme.dim),
            (None, None, None) => (" no rec".to_owned(), theme.dim),
            _ => (format!("  {} REC", theme.glyphs.recording), theme.strong),
        };
        [
            Span::styled(automatic, automatic_style),
            Span::styled(read_only, theme.warning),
            Span::styled(failsafe, style),
            Span::styled(words, recording_style),
        ]
    }

    /// Whether a protection of the robot is off.
    pub(super) fn is_unprotected(&self) -> bool {
        let mut all = self.facts.robot.protections().into_iter();
        all.any(|(_, is_off)| is_off)
    }

    /// Draws the protections that are off, each at its own place.
    pub(super) fn protections(&self, buffer: &mut Buffer, area: Rect) {
        let glyph = self.theme.glyphs.forbidden;
        let all = self.facts.robot.protections().into_iter();
        let spans = all.flat_map(|(name, is_off)| {
            let words = format!(" {glyph} {name} ");
            let gap = Span::raw("  ");
            if is_off {
                [Span::styled(words, self.theme.alarm), gap]
            } else {
                [Span::raw(" ".repeat(columns(&words))), gap]
            }
        });
        put(buffer, area, 0, &Line::from(spans.collect::<Vec<_>>()));
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
        // The name of a file matters more than the words beside it.
        let (least, beside) = if self.ui.is_replay() {
            (FILE_COLUMNS, FILE_WORDS_COLUMNS)
        } else {
            (NAME_COLUMNS, WORDS_COLUMNS)
        };
        let width = least.max(room.saturating_sub(beside));
        // The banner says that it is a replay; a file is known without its folder.
        let name = name.strip_prefix("replay of ").unwrap_or(name);
        // The robot is named before the station that shares its link.
        let shared = name.rsplit_once(" via ").filter(|_| !self.ui.is_replay());
        let name = match shared {
            _ if columns(name) <= width => Cow::Borrowed(name),
            Some((link, via)) => {
                let link = file_name(link);
                let both = format!("{link} via {}", file_name(via));
                let fits = columns(&both) <= width;
                if fits { both.into() } else { link.into() }
            }
            None => file_name(name).into(),
        };
        let shortened_name = shortened(&name, width);
        let newest = link.newest_age(self.now).map(age::words);
        // Parts that do not fit are omitted completely.
        let flow = |words: &str| {
            let mut room = room.saturating_sub(2 + columns(&shortened_name) + columns(words));
            let rate = format!("  {:.1}/s", link.lines_per_s(self.now));
            let shares = link.shares(self.now).map(Shares::words).unwrap_or_default();
            let shares = shares.into_iter().map(|share| format!("  {share}"));
            let newest = newest.as_ref().map(|newest| format!("  newest {newest}"));
            let parts = [rate].into_iter().chain(shares).chain(newest);
            let fit = parts.take_while(|part| {
                let fits = columns(part) <= room;
                room = room.saturating_sub(columns(part));
                fits
            });
            words.to_owned() + &fit.collect::<String>()
        };
        let with_reason = |words: String, reason: Option<&str>| {
            let gap = if words.is_empty() { "  " } else { ": " };
            let reason = reason.map(|reason| format!("{gap}{reason}"));
            let room = room.saturating_sub(2 + columns(&shortened_name) + columns(&words));
            let reason = reason.filter(|reason| columns(reason) <= room);
            words + &reason.unwrap_or_default()
        };
        let (glyph, style, words): (_, Style, String) = match link.health(self.now) {
            Health::Waiting => match self.instead_of_lines() {
                Some(words) => (glyphs.silent, theme.warning, format!("  {words}")),
                None => (glyphs.silent, theme.dim, "  no line yet".to_owned()),
            },
            Health::Good => (glyphs.good, theme.good, flow("")),
            Health::Weak => (glyphs.weak, theme.warning, flow("  WEAK")),
            Health::Silent => (
                glyphs.silent,
                theme.alarm,
                with_reason(
                    if self.strip_says(ROBOT_SILENT) {
                        String::new()
                    } else {
                        format!("  SILENT for {}", newest.unwrap_or_default())
                    },
                    self.facts
                        .link
                        .instead_of_lines(self.now)
                        .map(|(reception, _)| words::reception_alone(reception)),
                ),
            ),
            Health::Lost => {
                let (words, reason) = self.lost();
                (glyphs.bad, theme.alarm, with_reason(words, reason))
            }
            Health::Ended => (
                glyphs.ended,
                theme.strong,
                ended(room.saturating_sub(columns(&shortened_name) + MARKS_COLUMNS)),
            ),
        };
        let calm = matches!(
            link.health(self.now),
            Health::Good | Health::Waiting | Health::Weak
        );
        vec![
            Span::styled(format!("{glyph} "), style),
            Span::styled(shortened_name, theme.strong),
            Span::styled(words, if calm { theme.plain } else { style }),
        ]
    }

    /// The kind of bytes received if no line is intact.
    pub(super) fn instead_of_lines(&self) -> Option<String> {
        let (reception, age) = self.facts.link.instead_of_lines(self.now)?;
        Some(words::reception(reception, &age::words(age)))
    }

    /// Whether the alarm strip shows this alarm, of the present.
    fn strip_says(&self, code: &str) -> bool {
        let calling = self.calling();
        let first = calling.first();
        let is_first = first.is_some_and(|(rule, _)| rule.code == code);
        self.ui.playback.is_none() && is_first && self.stop_words().is_none()
    }

    /// That the link is lost, unless the alarm strip says it, and why.
    fn lost(&self) -> (String, Option<&str>) {
        let Connection::Lost { reason, since } = &self.facts.link.connection else {
            return (String::new(), None);
        };
        if self.strip_says(LINK_LOST) {
            return (String::new(), Some(reason.as_str()));
        }
        let since = age::words(self.now.saturating_sub(*since));
        (format!("  LINK LOST {since}"), Some(reason.as_str()))
    }

    /// The recording's failure or files, as the longest text that fits; `None` if no text fits.
    fn recording(&self, room: usize) -> Option<Span<'_>> {
        let recording = &self.present.recording;
        let (words, style) = if let Some(problem) = &recording.problem {
            let long = format!("RECORDING FAILED: {problem}");
            (vec![long, "RECORDING FAILED".to_owned()], self.theme.alarm)
        } else {
            let files = [&recording.tee, &recording.mcap].into_iter().flatten();
            let names: Vec<&str> = files.map(|path| file_name(path)).collect();
            (vec![names.join(", ")], self.theme.plain)
        };
        let mut fitting = words.into_iter().filter(|words| columns(words) <= room);
        fitting.next().map(|words| Span::styled(words, style))
    }

    fn robot_at_a_glance(&self, width: u16) -> Vec<Span<'_>> {
        let theme = &self.theme;
        let robot = &self.facts.robot;
        let mut spans = Vec::new();
        let is_wide = width >= WIDTH_FULL;
        if let Some(clock) = self.ui.clock(self.now).filter(|_| is_wide) {
            spans.push(Span::styled(clock + "  ", theme.dim));
        }
        if let Some(state) = robot.state {
            let reported = self.facts.robot.mode().unwrap_or(state.value.mode);
            let style = match reported {
                _ if state.age(self.now) >= STATE_STALE => theme.dim,
                Mode::Stop => theme.warning,
                _ => theme.strong,
            };
            let mode = words::mode(reported).to_uppercase();
            let old = self.old_mark(state.age(self.now), STATE_STALE);
            spans.push(Span::styled(format!("{old}{mode}"), style));
        }
        if let Some(status) = robot.battery() {
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
        if robot.state.is_none() {
            spans.extend(self.roles_at_a_glance());
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

/// Width that is always available for the link's name, columns.
const NAME_COLUMNS: usize = 24;

/// Width that a replayed file may always have: that of a recording named by its time, columns.
const FILE_COLUMNS: usize = 32;

/// Width kept free for the words after a longer name, columns.
const WORDS_COLUMNS: usize = 47;

/// The same after the name of a replayed file.
const FILE_WORDS_COLUMNS: usize = 22;

/// The last part of a path.
pub(super) fn file_name(path: &str) -> &str {
    Path::new(path)
        .file_name()
        .and_then(|name| name.to_str())
        .unwrap_or(path)
}

/// Shortens a name at its start, because the end is more informative.
pub(super) fn shortened(name: &str, width: usize) -> String {
    let length = name.chars().count();
    if length <= width {
        return name.to_owned();
    }
    let end: String = name.chars().skip(length - (width - 2)).collect();
    format!("..{end}")
}
