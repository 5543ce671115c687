//! The hint row above the keys: the result of the operator's latest command while it is new, otherwise a summary.

use std::path::Path;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::status::{file_name, shortened};
use super::{Screen, columns, put, width_of};
use crate::event::Level;
use crate::hint::shell_word;
use crate::model::news::{News, Passing};
use crate::model::{Overlay, Panel, Purpose};
use crate::playback::POSITION_HELP;
use crate::request::completion::Candidate;

/// Variants of the summary from longest to shortest; the first one that fits is drawn.
const TERSENESS: [Terseness; 3] = [
    Terseness {
        short: false,
        name_columns: usize::MAX,
    },
    Terseness {
        short: true,
        name_columns: usize::MAX,
    },
    Terseness {
        short: true,
        name_columns: 16,
    },
];

/// Length of a variant of the summary.
#[derive(Clone, Copy)]
struct Terseness {
    /// Whether to use shorter words, and file names without folders.
    short: bool,
    /// Maximum width of a recording's name, columns.
    name_columns: usize,
}

impl Screen<'_> {
    /// Draws help for the text being typed, else news, else the summary: rate, loss, recording, raw command.
    pub(super) fn hint(&self, buffer: &mut Buffer, area: Rect) {
        let news = self.shown().news(self.present_at);
        let answer = news.filter(|news| matches!(news, News::Passing(_)));
        let answer = answer.filter(|_| self.ui.aside.is_none());
        let line = if let Some(help) = self.prompt_help(usize::from(area.width)) {
            help
        } else if let Some(answer) = answer {
            self.news(answer)
        } else if let Some(aside) = self.aside() {
            aside
        } else if let Some(found) = self.search_words() {
            found
        } else if let Some(traced) = self.trace_words() {
            traced
        } else if let Some(news) = news {
            self.news(news)
        } else {
            self.one_line(usize::from(area.width))
        };
        put(buffer, area, 0, &self.cut(line, usize::from(area.width)));
    }

    fn prompt_help(&self, width: usize) -> Option<Line<'_>> {
        if self.ui.overlay == Overlay::Modes {
            return Some(Line::styled("choose a mode", self.theme.plain));
        }
        let Overlay::Text(entry) = &self.ui.overlay else {
            return None;
        };
        Some(match (&entry.error, entry.purpose) {
            (None, _) if entry.waits => {
                let words = self.with_keys("reading that file; <text/close> cancel");
                Line::styled(words, self.theme.plain)
            }
            (Some(error), _) => Line::styled(error.clone(), self.theme.warning),
            (None, _) if !entry.candidates.is_empty() => self.candidates(&entry.candidates, width),
            (None, Purpose::Moment) => Line::styled(POSITION_HELP, self.theme.dim),
            (None, Purpose::Command) => Line::styled(COMMAND_HELP, self.theme.dim),
            (None, Purpose::Search) => Line::styled("a text in the log", self.theme.dim),
            (None, Purpose::Mark) => Line::styled(
                self.with_keys(if self.ui.is_at_mark() {
                    "a text for this mark; <text/submit> alone removes it; <text/close> cancel"
                } else if self.ui.is_replay() {
                    "a text, which keeps the mark after this replay, or <text/submit> alone; <text/close> cancel"
                } else {
                    "a text for the mark, or <text/submit> alone; <text/close> cancel"
                }),
                self.theme.dim,
            ),
            (None, Purpose::SaveRoute) => Line::styled(
                "a file for the draft; asks before overwriting",
                self.theme.dim,
            ),
            (None, Purpose::RouteFile) => Line::styled(
                "a route file: one X,Y in inches a line, # comments",
                self.theme.dim,
            ),
        })
    }

    /// The candidates of a completion, as far as whole words fit; for a single candidate, its meaning.
    fn candidates(&self, candidates: &[Candidate], width: usize) -> Line<'_> {
        let text = match candidates {
            [one] if !one.about.is_empty() => format!("{}: {}", one.text, one.about),
            all => {
                // Only the last part of a path is shown; the prompt shows the other parts.
                let words = all.iter().map(|candidate| {
                    let text = &*candidate.text;
                    let folder = text.trim_end_matches('/').rfind('/');
                    &text[folder.map_or(0, |slash| slash + 1)..]
                });
                let words: Vec<&str> = words.collect();
                let all = words.join("  ");
                if columns(&all) <= width {
                    all
                } else {
                    let mut room = width.saturating_sub(columns(self.theme.glyphs.cut));
                    let fit = words.into_iter().take_while(|word| {
                        let fits = columns(word) + 2 <= room;
                        room = room.saturating_sub(columns(word) + 2);
                        fits
                    });
                    let fit: Vec<&str> = fit.chain([self.theme.glyphs.cut]).collect();
                    fit.join("  ")
                }
            }
        };
        Line::styled(text, self.theme.plain)
    }

    /// The hint while the screen shows the past: news, or the target of commands.
    fn aside(&self) -> Option<Line<'_>> {
        let playback = self.ui.playback.as_ref()?;
        if let Some((level, said)) = self.ui.aside.as_ref().or(playback.note.as_ref()) {
            let (mark, style) = match level {
                Level::Info => (self.theme.glyphs.dot, self.theme.plain),
                _ => ("!", self.theme.warning),
            };
            return Some(Line::styled(format!("{mark} {said}"), style));
        }
        if playback.is_partial {
            let text = "still reading the recording: trail and totals are incomplete";
            return Some(Line::styled(text, self.theme.dim));
        }
        playback.is_live.then(|| {
            Line::from(vec![
                Span::styled(
                    "commands go to the robot now, after a question; ",
                    self.theme.plain,
                ),
                Span::styled(self.with_keys("<playback-newest>"), self.theme.key),
                Span::styled(" returns to now", self.theme.plain),
            ])
        })
    }

    fn news<'n>(&'n self, news: News<'n>) -> Line<'n> {
        // News of a recording must not be taken for news of this program.
        let prefix = if self.ui.is_replay() {
            "recorded: "
        } else {
            ""
        };
        match news {
            News::Command(entry) => {
                let (glyph, says, style) = self.fate(entry);
                let from = entry.by.as_ref();
                let from = from.map_or_else(String::new, |by| format!(" from {by}"));
                Line::styled(
                    format!("{glyph} {prefix}{}{from}: {says}", entry.request),
                    style,
                )
            }
            News::Logged(entry) => {
                let (glyph, style) = self.mark(entry);
                Line::styled(format!("{glyph} {prefix}{}", entry.text), style)
            }
            News::Passing(Passing::Words(words)) => Line::styled(words.as_str(), self.theme.plain),
            News::Passing(Passing::Panels) => self.panel_keys(),
        }
    }

    /// The keys of the panels.
    fn panel_keys(&self) -> Line<'_> {
        let theme = &self.theme;
        let chosen = self.ui.panel;
        let offered = Panel::ALL.into_iter();
        let offered = offered.filter(|panel| self.facts.offers(*panel));
        let panels = offered.flat_map(|panel| {
            let style = if panel == chosen {
                theme.lit
            } else {
                theme.plain
            };
            [
                Span::styled(self.panel_key(panel), theme.key),
                Span::raw(" "),
                Span::styled(panel.name(), style),
                Span::raw("  "),
            ]
        });
        Line::from(panels.collect::<Vec<_>>())
    }

    fn one_line(&self, room: usize) -> Line<'_> {
        let mut lines = TERSENESS.iter().map(|terseness| self.facts(*terseness));
        let fits = lines.find(|line| width_of(&line.spans) <= room);
        fits.unwrap_or_else(|| self.facts(TERSENESS[TERSENESS.len() - 1]))
    }

    fn facts(&self, terseness: Terseness) -> Line<'_> {
        let Terseness {
            short,
            name_columns,
        } = terseness;
        let theme = &self.theme;
        let separator = format!(" {} ", theme.glyphs.dot);
        let mut facts = Vec::new();
        let recording = &self.present.recording;
        let places: Vec<String> = [&recording.tee, &recording.mcap]
            .into_iter()
            .flatten()
            .map(|path| if short { file_name(path) } else { path })
            .map(|name| shortened(name, name_columns))
            .collect();
        if recording.problem.is_some() {
            facts.push("recording failed".to_owned());
            let file = recording.mcap.as_deref();
            let file = file.map(|path| if short { file_name(path) } else { path });
            let file = file.map(|name| shell_word(Path::new(name)));
            if let Some(name) = file.map(|name| shortened(&name, name_columns)) {
                facts.push(format!("after leaving: groundwave recover {name}"));
            }
        } else if self.ui.is_replay() {
            // A replay has no robot to record.
        } else if !places.is_empty() {
            let recorded = if short { "" } else { "recorded in " };
            facts.push(format!("{recorded}{}", places.join(", ")));
        } else {
            facts.push(self.with_keys("<toggle-recording>: record"));
        }
        if let Some(command) = &self.ui.config.raw_copy {
            let how = if short {
                "raw"
            } else {
                "raw in another terminal"
            };
            facts.push(format!("{how}: {command}"));
        }
        Line::styled(facts.join(&separator), theme.plain)
    }
}

const COMMAND_HELP: &str = "a command, such as `mode prowl` or `goto 48 0`; `help` lists all";
