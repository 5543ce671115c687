//! The time row: the displayed moment of a replay or of a live session's past.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

use super::{Screen, put};
use crate::event::Moment;
use crate::model::age;
use crate::playback::{Playback, clock_words};

/// Minimum width of the time line, columns.
const LINE_COLUMNS_MIN: usize = 8;

impl Screen<'_> {
    /// Draws the distance to now, the moment, a time line with marks and loop, length, line number, speed and time of day.
    pub(super) fn time(&self, buffer: &mut Buffer, area: Rect, playback: &Playback) {
        let style = self.time_style(playback);
        let width = usize::from(area.width);
        let left = self.moment_words(playback);
        let mut right = self.end_words(playback);
        // If there is no room, the last words are omitted first.
        while right.len() > 1
            && left.chars().count() + words_width(&right) + LINE_COLUMNS_MIN > width
        {
            right.pop();
        }
        let room = width.saturating_sub(left.chars().count() + words_width(&right));
        let mut spans = vec![Span::raw(left)];
        if room >= LINE_COLUMNS_MIN {
            spans.push(Span::raw(self.time_line(playback, room)));
        }
        spans.push(Span::raw(right.concat()));
        let text: String = spans.iter().map(|span| span.content.as_ref()).collect();
        put(
            buffer,
            area,
            0,
            &Line::styled(format!("{text:<width$}"), style),
        );
    }

    /// Style of the first words of the row. The past is reversed and has arrows, so it can be recognized without colour.
    fn time_style(&self, playback: &Playback) -> Style {
        if playback.is_live {
            let style = self.theme.warning;
            style.add_modifier(Modifier::REVERSED | Modifier::BOLD)
        } else {
            self.theme.strong
        }
    }

    fn moment_words(&self, playback: &Playback) -> String {
        let glyphs = self.theme.glyphs;
        let plays = if playback.paused {
            glyphs.paused
        } else {
            glyphs.holds
        };
        let at = playback.at;
        let tenths = if playback.paused {
            format!(".{}", at.subsec_millis() / 100)
        } else {
            String::new()
        };
        let at = clock_words(at);
        if playback.is_live {
            let behind = age::words(playback.behind());
            format!(" {} PAST {behind} ago {plays} {at}{tenths} ", glyphs.back)
        } else {
            format!("{plays} REPLAY {at}{tenths} ")
        }
    }

    /// The words at the right end, from most to least important.
    fn end_words(&self, playback: &Playback) -> Vec<String> {
        let glyphs = self.theme.glyphs;
        let mut words = vec![format!(" {}", clock_words(playback.until))];
        if !playback.paused || (playback.speed - 1.0).abs() > f64::EPSILON {
            words.push(format!(" {}{}", glyphs.times, playback.speed));
        }
        if let Some(line) = playback.line {
            words.push(format!(" #{line}"));
        }
        if let Some(read) = playback.read_until {
            let percent = 100.0 * share(playback, read);
            words.push(format!(" reading {percent:.0} %"));
        }
        if let Some(unix) = playback.unix {
            let time = |h, m, s| format!("{h:02}:{m:02}:{s:02}");
            words.push(format!(
                " {}",
                self.ui.times_of_day(unix + playback.at, time)
            ));
        }
        if playback.is_live {
            words.push(format!(" {} ", glyphs.back));
        }
        words
    }

    /// The time line: played and unplayed parts, marks, and the ends of a loop.
    fn time_line(&self, playback: &Playback, columns: usize) -> String {
        let glyphs = self.theme.glyphs;
        let place = |at: Moment| {
            let last = columns.saturating_sub(1);
            ((share(playback, at) * last as f64).round() as usize).min(last)
        };
        let here = place(playback.at);
        let mut cells: Vec<&str> = (0..columns)
            .map(|column| {
                if column < here {
                    glyphs.played
                } else {
                    glyphs.rule
                }
            })
            .collect();
        for marker in &playback.markers {
            cells[place(*marker)] = glyphs.draft;
        }
        if let Some((begin, end)) = playback.repeat {
            cells[place(begin)] = "[";
            if let Some(end) = end {
                cells[place(end)] = "]";
            }
        }
        cells[here] = glyphs.cursor;
        cells.concat()
    }
}

fn words_width(words: &[String]) -> usize {
    words.iter().map(|word| word.chars().count()).sum()
}

/// Position of a moment in the whole span, 0 to 1.
fn share(playback: &Playback, at: Moment) -> f64 {
    let all = playback.until.saturating_sub(playback.from).as_secs_f64();
    let part = at.saturating_sub(playback.from).as_secs_f64();
    if all > 0.0 {
        (part / all).min(1.0)
    } else {
        1.0
    }
}
