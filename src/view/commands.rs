//! The command ledger: the command on the left, the robot's report on the right.

use groundwave_captures::words::counted;
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::ListPlace;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::text::{First, wrap};
use super::{Screen, columns};
use crate::event::{CommandStatus, GROUND, Moment};
use crate::model::Panel;
use crate::model::ledger::Entry;
use crate::model::robot::STATUS_STALE;
use crate::model::words;
use crate::request::Request;

const TITLE: &str = "commands: commanded | reported";

/// Minimum height where the map takes the other rows.
const ROWS_MIN: u16 = 7;

const ASKED_COLUMNS_MIN: usize = 22;

impl Screen<'_> {
    /// Height of the panel at a width: its title, and its lines, but at least [`ROWS_MIN`].
    pub(super) fn commands_height(&self, width: u16) -> u16 {
        let lines = self.lines_of_commands(usize::from(width)).len();
        u16::try_from(1 + lines).unwrap_or(u16::MAX).max(ROWS_MIN)
    }

    fn lines_of_commands(&self, width: usize) -> Vec<Line<'static>> {
        let mut lines = self.command_lines(width);
        if lines.is_empty() {
            lines.push(Line::styled("No commands sent yet", self.theme.dim));
        }
        lines.extend(self.list_lines(width));
        lines
    }

    pub(super) fn commands(&self, buffer: &mut Buffer, area: Rect) {
        let lines = self.lines_of_commands(usize::from(area.width));
        self.pages(
            buffer,
            area,
            (Panel::Commands, TITLE),
            None,
            &lines,
            First::Bottom,
        );
    }

    fn command_lines(&self, width: usize) -> Vec<Line<'static>> {
        let asked_columns = (width / 2).clamp(ASKED_COLUMNS_MIN, 32);
        let mut lines = Vec::new();
        for entry in self.facts.ledger.entries() {
            let (glyph, says, style) = self.fate(entry);
            let asked = format!("{} {}", entry.id.0, entry.request);
            let begin = if columns(&asked) <= asked_columns {
                let gap = " ".repeat(asked_columns - columns(&asked) + 1);
                asked + &gap
            } else {
                // A long command has rows of its own.
                let rows = wrap(&asked, width, width.saturating_sub(4)).into_iter();
                lines.extend((0..).zip(rows).map(|(row, asked)| {
                    let indent = if row == 0 { 0 } else { 4 };
                    Line::raw(format!("{:indent$}{asked}", ""))
                }));
                " ".repeat(4)
            };
            let room = width.saturating_sub(columns(&begin) + 2);
            let mut says = wrap(&says, room, width.saturating_sub(4)).into_iter();
            let first = format!("{glyph} {}", says.next().unwrap_or_default());
            lines.push(Line::from(vec![
                Span::raw(begin),
                Span::styled(first, style),
            ]));
            lines.extend(says.map(|more| Line::styled(format!("    {more}"), style)));
            if let Some(by) = &entry.by {
                let room = width.saturating_sub(4);
                let by = match by.as_str() {
                    GROUND => "sent by --advise=auto".to_owned(),
                    client => format!("shared: {client}"),
                };
                let rows = wrap(&by, room, room).into_iter();
                lines.extend(rows.map(|row| Line::styled(format!("    {row}"), self.theme.dim)));
            }
        }
        lines
    }

    /// The state of a command, from acknowledgements and the robot's own lines only.
    pub(super) fn fate(&self, entry: &Entry) -> (&'static str, String, Style) {
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        let sent = || match entry.request {
            // A STOP is sent all the time until it is confirmed.
            Request::Stop => "sent".to_owned(),
            _ => format!("sent {}", counted(entry.frames.into(), "frame")),
        };
        match (entry.status, entry.progress) {
            (CommandStatus::Queued, _) => (glyphs.waiting, "queued".to_owned(), theme.dim),
            (CommandStatus::Confirmed { digest: None }, _) => {
                let says = format!("confirmed{}", delay(entry));
                (glyphs.done, says, theme.good)
            }
            (
                CommandStatus::Confirmed {
                    digest: Some(digest),
                },
                _,
            ) => self.list_fate(entry, digest),
            (CommandStatus::Echoed, _) => {
                let says = format!(
                    "echoed{}",
                    in_seconds(entry.at.saturating_sub(entry.asked_at))
                );
                (glyphs.dot, says, theme.plain)
            }
            (CommandStatus::Refused(outcome), _) => (
                glyphs.bad,
                format!(
                    "REFUSED: {}",
                    entry.reason.as_deref().unwrap_or(words::outcome(outcome))
                ),
                theme.warning,
            ),
            (CommandStatus::Failed(failure), _) => (glyphs.bad, failure.to_string(), theme.warning),
            (_, Some((held, total))) => (
                glyphs.waiting,
                format!("holds {held}/{total}, {}", sent()),
                theme.plain,
            ),
            (_, None) => (glyphs.waiting, sent(), theme.plain),
        }
    }

    fn list_fate(&self, entry: &Entry, digest: u32) -> (&'static str, String, Style) {
        let theme = &self.theme;
        let active = self
            .facts
            .ledger
            .active()
            .filter(|active| active.id == entry.id && active.digest == digest);
        let driven = entry.driven.filter(|place| place.driven > 0);
        let glyph = theme.glyphs.done;
        let drives = self.facts.robot.mode() == Some(Mode::Prowl);
        let says = match (active, driven) {
            (None, None) => return (glyph, "replaced".to_owned(), theme.dim),
            (None, Some(ListPlace { driven, count })) => {
                let says = format!("replaced, driven {driven}/{count}");
                return (glyph, says, theme.dim);
            }
            (Some(active), None) => {
                let after = entry.confirmed_after.map(in_seconds).unwrap_or_default();
                let next = if drives || active.waypoints.is_empty() {
                    String::new()
                } else {
                    self.with_keys(". Press <modes/mode-prowl> to drive it")
                };
                format!("confirmed{after}{next}")
            }
            (Some(_), Some(ListPlace { driven, count })) => {
                if driven == count {
                    format!("done {driven}/{count}")
                } else if drives {
                    format!("driving {driven}/{count}")
                } else {
                    let key = self.with_keys("<modes/mode-prowl>");
                    format!("driven {driven}/{count}. Press {key} to drive on")
                }
            }
        };
        (glyph, says, theme.good)
    }

    /// The draft, and a route of another station that the robot holds.
    fn list_lines(&self, width: usize) -> Vec<Line<'static>> {
        let mut lines = Vec::new();
        let mut tell = |words: &str, style: Style| {
            let rows = wrap(words, width, width.saturating_sub(4)).into_iter();
            lines.extend(rows.enumerate().map(|(row, words)| {
                let indent = if row == 0 { 0 } else { 4 };
                Line::styled(format!("{:indent$}{words}", ""), style)
            }));
        };
        let facts = self.facts;
        if let Some(status) = facts
            .robot
            .status
            .filter(|_| facts.ledger.active().is_none())
            && status.value.list.count > 0
        {
            let list = status.value.list;
            let words = format!(
                "{}robot's route, not of this session: driven {}/{}",
                self.old_mark(status.age(self.now), STATUS_STALE),
                list.driven,
                list.count
            );
            tell(&words, self.theme.dim);
        }
        let drafted = self.ui.map.draft.waypoints().len();
        if drafted > 0 {
            let waypoints = if drafted == 1 {
                "waypoint"
            } else {
                "waypoints"
            };
            let draft = self.ui.map.draft.waypoints();
            let active = facts.ledger.active();
            let [send, undo, discard] = match self.ui.editor {
                Some(_) => [
                    "<route/route-send>",
                    "<route/route-undo>",
                    "<route/route-clear>",
                ],
                None => ["<send-draft>", "<undo-draft>", "<discard-draft>"],
            };
            let fate = if active.is_some_and(|active| active.waypoints == draft) {
                format!("same as the robot's route; {discard} discards")
            } else {
                format!("not sent; {send} sends, {undo} undoes")
            };
            let fate = self.with_keys(&fate);
            let words = format!(
                "{} draft: {drafted} {waypoints}, {fate}",
                self.theme.glyphs.draft,
            );
            tell(&words, self.theme.draft);
        }
        lines
    }
}

/// The time until a confirmation as text.
fn in_seconds(delay: Moment) -> String {
    format!(" in {:.1} s", delay.as_secs_f64())
}

/// Time and frames until the confirmation.
fn delay(entry: &Entry) -> String {
    let Some(delay) = entry.confirmed_after else {
        return String::new();
    };
    let frames = match entry.frames {
        0 | 1 => String::new(),
        frames => format!(", {frames} frames"),
    };
    in_seconds(delay) + &frames
}
