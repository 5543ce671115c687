//! The list of runs, and the comparison of two.

use std::path::Path;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::projection::Projection;
use super::raster::{Ink, Raster};
use super::text::wrap;
use super::{Screen, columns, put, split_bottom, split_top};
use crate::figures::{Figures, HEADING, Listed, Overlaid, Place, SHORT_HEADING};
use crate::model::runs::Runs;
use crate::safe_text::SafeWriter;

/// Width of the mark before a run, columns.
const MARK_COLUMNS: usize = 2;

/// Preferred size of the window, columns and rows.
const SIZE: (u16, u16) = (160, 44);

/// Ink and dot spacing of the two runs; the spacing distinguishes them without colours.
const INKS: [(Ink, usize); 2] = [(Ink::Left, 1), (Ink::Right, 3)];

impl Screen<'_> {
    pub(super) fn runs_window(&self, buffer: &mut Buffer, area: Rect, runs: &Runs) {
        // The hint and the keys stay visible.
        let (above, _) = split_bottom(area, 2);
        match runs {
            Runs::Waits(what) => {
                let inner = self.window(buffer, above, (SIZE.0, 4), " runs ");
                self.rows(
                    buffer,
                    inner,
                    &[format!("{what} {}", self.theme.glyphs.waiting)],
                );
            }
            Runs::Failed(error) => {
                let inner = self.window(buffer, above, (SIZE.0, 6), " runs ");
                self.rows(buffer, inner, std::slice::from_ref(error));
            }
            Runs::Listed {
                list,
                chosen,
                first,
            } => self.list_of_runs(buffer, above, (list, *chosen, *first)),
            Runs::Overlaid(overlaid) => self.two_runs(buffer, above, overlaid),
        }
    }

    fn list_of_runs(
        &self,
        buffer: &mut Buffer,
        area: Rect,
        (list, chosen, first): (&Listed, usize, Option<usize>),
    ) {
        let theme = &self.theme;
        let title = format!(
            " runs in {}: {} ",
            list.folder,
            self.with_keys(
                "<runs-window/submit> replays, <runs-window/compare-run> on two compares"
            )
        );
        let inner = self.window(buffer, area, SIZE, &title);
        let problems = list.problems.len().min(3) as u16;
        let (rest, below) = split_bottom(inner, problems);
        self.rows(buffer, below, &list.problems);
        if list.runs.is_empty() {
            self.rows(
                buffer,
                rest,
                &[self.with_keys(
                    "no finished capture here; <toggle-recording> records one, and ends it",
                )],
            );
            return;
        }
        let width = usize::from(rest.width);
        let runs: Vec<Figures> = list
            .runs
            .iter()
            .map(|run| {
                // The title names the folder.
                let file = Path::new(&run.capture).file_name();
                let capture =
                    file.map_or_else(|| run.capture.clone(), |file| file.display().to_string());
                Figures {
                    capture,
                    ..run.clone()
                }
            })
            .collect();
        // The heading ends with the column of the captures, in which remarks may be cut.
        let widest = runs.iter().map(|run| columns(&run.capture)).max();
        let before_capture = columns(HEADING) - columns("capture");
        let is_narrow = MARK_COLUMNS + before_capture + widest.unwrap_or_default() > width;
        // Below the list, the chosen run as a whole if its row is not.
        let is_cut = |run: &Figures| MARK_COLUMNS + columns(&run.to_string()) > width;
        let chosen_run = runs.get(chosen);
        let about = chosen_run
            .filter(|run| is_narrow || is_cut(run))
            .map(|run| {
                let names = run.names();
                wrap(&format!("{names}: {}", run.details()), width, width)
            });
        let about = about.unwrap_or_default();
        let (rest, under) = split_bottom(rest, about.len() as u16);
        self.rows(buffer, under, &about);
        let heading = if is_narrow { SHORT_HEADING } else { HEADING };
        let heading = Line::styled(format!("  {heading}"), theme.dim);
        put(buffer, rest, 0, &self.cut(heading, width));
        let rows = usize::from(rest.height.saturating_sub(1)).max(1);
        let skipped = chosen.saturating_sub(rows - 1);
        let shown = runs.iter().enumerate().skip(skipped).take(rows);
        for (row, (place, run)) in (1..).zip(shown) {
            let (mark, style) = match place {
                _ if place == chosen => (theme.glyphs.holds, theme.holder),
                _ if run.void.is_some() => (" ", theme.dim),
                _ => (" ", theme.plain),
            };
            let mark = if first == Some(place) { "1" } else { mark };
            let text = if is_narrow {
                run.short_row(width.saturating_sub(MARK_COLUMNS))
            } else {
                run.to_string()
            };
            let line = Line::styled(format!("{mark} {text}"), style);
            put(buffer, rest, row, &self.cut(line, width));
        }
    }

    fn two_runs(&self, buffer: &mut Buffer, area: Rect, overlaid: &Overlaid) {
        let inner = self.window(buffer, area, SIZE, " two runs over each other ");
        let mut text = SafeWriter(Vec::new());
        // Writing to a string cannot fail.
        let _ = overlaid.comparison.write_text(&mut text);
        let text = String::from_utf8_lossy(&text.0);
        let lines: Vec<String> = text
            .lines()
            .map(str::to_owned)
            .chain(overlaid.problems.iter().cloned())
            .collect();
        let least = inner.height / 3;
        let room = inner.height.saturating_sub(least + 1);
        let (words, rest) = split_top(inner, (lines.len() as u16).min(room));
        self.rows(buffer, words, &lines);
        let (legend, picture) = split_top(rest, 1);
        put(buffer, legend, 0, &self.legend_of_runs());
        self.paths(buffer, picture, &overlaid.paths);
    }

    fn legend_of_runs(&self) -> Line<'static> {
        let ascii = self.theme.glyphs.ascii;
        let spans = INKS.into_iter().zip(1..).map(|((ink, every), number)| {
            let line = match (ascii, every) {
                (true, _) => ink.ascii().to_string().repeat(4),
                (false, 1) => "\u{2812}".repeat(4),
                (false, _) => "\u{2802}".repeat(4),
            };
            Span::styled(format!("{line} {number}   "), ink.style(&self.theme))
        });
        Line::from(spans.collect::<Vec<_>>())
    }

    fn paths(&self, buffer: &mut Buffer, area: Rect, paths: &[Vec<Place>; 2]) {
        let mut places = paths.iter().flatten().copied();
        let Some(first) = places.next() else {
            return;
        };
        let (low, high) = places.fold((first, first), |(low, high), (x, y)| {
            ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)))
        });
        // A margin of a dot keeps the ends inside.
        let dot_in = Projection::over(low, high, area).scale_in();
        let (low, high) = (
            (low.0 - dot_in, low.1 - dot_in),
            (high.0 + dot_in, high.1 + dot_in),
        );
        let projection = Projection::over(low, high, area);
        let mut raster = Raster::new(area);
        for (path, (ink, every)) in paths.iter().zip(INKS) {
            let mut last = None;
            for (n, &place) in path.iter().enumerate() {
                let here = projection.dot(place);
                let from = last.replace(here).unwrap_or(here);
                if every == 1 {
                    raster.line(from, here, 1, ink);
                } else if n % every == 0 {
                    raster.dot(here.0, here.1, ink);
                }
            }
        }
        raster.draw(buffer, area, &self.theme);
    }

    /// Draws lines, wrapped to the window.
    fn rows(&self, buffer: &mut Buffer, area: Rect, lines: &[String]) {
        let width = usize::from(area.width);
        // Table rows are not wrapped.
        let rows = lines.iter().flat_map(|line| {
            if columns(line) <= width {
                vec![line.clone()]
            } else {
                wrap(line, width, width)
            }
        });
        for (row, text) in (0..area.height).zip(rows) {
            put(buffer, area, row, &Line::styled(text, self.theme.plain));
        }
    }
}
