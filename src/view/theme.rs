//! Colours and glyphs. Each colour is combined with a shape or a word, so no meaning depends on colour alone.

use ratatui::style::{Color, Modifier, Style};

use crate::model::{Colors, Config, Marker};

/// Styles by meaning.
#[derive(Clone, Copy, Debug)]
pub(super) struct Theme {
    pub(super) plain: Style,
    pub(super) dim: Style,
    pub(super) strong: Style,
    pub(super) title: Style,
    pub(super) rule: Style,
    pub(super) key: Style,
    pub(super) holder: Style,
    pub(super) raised: Style,
    pub(super) good: Style,
    pub(super) warning: Style,
    pub(super) alarm: Style,
    pub(super) wall: Style,
    pub(super) furniture: Style,
    pub(super) old_trail: Style,
    pub(super) trail: Style,
    pub(super) sonar: Style,
    pub(super) robot: Style,
    pub(super) route: Style,
    pub(super) draft: Style,
    /// The selected item.
    pub(super) lit: Style,
    pub(super) glyphs: &'static Glyphs,
    /// Characters of maps and plots, unless only ASCII is drawn.
    pub(super) marker: Marker,
}

/// Shapes by meaning.
#[derive(Debug)]
pub(super) struct Glyphs {
    pub(super) ascii: bool,
    pub(super) rule: &'static str,
    pub(super) good: &'static str,
    pub(super) weak: &'static str,
    pub(super) silent: &'static str,
    pub(super) bad: &'static str,
    pub(super) ended: &'static str,
    pub(super) paused: &'static str,
    /// Time before the shown moment.
    pub(super) played: &'static str,
    /// The past.
    pub(super) back: &'static str,
    pub(super) recording: &'static str,
    pub(super) stale: &'static str,
    pub(super) holds: &'static str,
    pub(super) raised: &'static str,
    pub(super) quiet: &'static str,
    pub(super) off: &'static str,
    pub(super) forbidden: &'static str,
    pub(super) missing: &'static str,
    pub(super) done: &'static str,
    pub(super) waiting: &'static str,
    pub(super) times: &'static str,
    /// Before half of an interval.
    pub(super) within: &'static str,
    pub(super) dot: &'static str,
    pub(super) bump: &'static str,
    pub(super) infrared: &'static str,
    pub(super) target: &'static str,
    pub(super) waypoint: &'static str,
    pub(super) reached: &'static str,
    pub(super) draft: &'static str,
    pub(super) cursor: &'static str,
    pub(super) origin: &'static str,
    pub(super) text_cursor: &'static str,
    /// Mark at the end of a cut text.
    pub(super) cut: &'static str,
    /// Arrows clockwise from straight up, 45 degrees apart.
    pub(super) arrows: [&'static str; 8],
    /// A cell filled from the left by eighths.
    pub(super) bar: [&'static str; 8],
    /// A cell filled from the bottom by eighths.
    pub(super) column: [&'static str; 8],
    pub(super) scale: [&'static str; 3],
}

const UNICODE: Glyphs = Glyphs {
    ascii: false,
    rule: "─",
    good: "●",
    weak: "◐",
    silent: "○",
    bad: "✖",
    ended: "■",
    paused: "‖",
    played: "━",
    back: "◀◀",
    recording: "◉",
    stale: "◌",
    holds: "▶",
    raised: "△",
    quiet: "·",
    off: "○",
    forbidden: "✕",
    missing: " ",
    done: "✔",
    waiting: "…",
    times: "×",
    within: "±",
    dot: "·",
    bump: "✖",
    infrared: "∘",
    target: "◎",
    waypoint: "◆",
    reached: "✓",
    draft: "◇",
    cursor: "╋",
    origin: "⌂",
    text_cursor: "▏",
    cut: "…",
    arrows: ["▲", "◥", "▶", "◢", "▼", "◣", "◀", "◤"],
    bar: ["▏", "▎", "▍", "▌", "▋", "▊", "▉", "█"],
    column: ["▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"],
    scale: ["├", "─", "┤"],
};

const ASCII: Glyphs = Glyphs {
    ascii: true,
    rule: "-",
    good: "*",
    weak: "%",
    silent: "o",
    bad: "X",
    ended: "#",
    paused: "=",
    played: "=",
    back: "<<",
    recording: "@",
    stale: "~",
    holds: ">",
    raised: "^",
    quiet: ".",
    off: "o",
    forbidden: "x",
    missing: " ",
    done: "+",
    waiting: "?",
    times: "x",
    within: "+-",
    dot: "-",
    bump: "X",
    infrared: "i",
    target: "@",
    waypoint: "W",
    reached: "w",
    draft: "D",
    cursor: "+",
    origin: "H",
    text_cursor: "_",
    cut: "..",
    arrows: ["^", "^", ">", ">", "v", "v", "<", "<"],
    bar: ["-", "-", "-", "-", "=", "=", "=", "#"],
    column: ["_", "_", ".", ".", "-", "-", "=", "#"],
    scale: ["|", "-", "|"],
};

impl Theme {
    pub(super) fn of(config: &Config) -> Self {
        let mut theme = match config.colors {
            Colors::Dark => colored(Color::Indexed(245), Color::Indexed(240), Color::Yellow),
            Colors::Light => colored(Color::Indexed(242), Color::Indexed(249), Color::Magenta),
            Colors::HighContrast => high_contrast(),
            Colors::Mono => mono(),
        };
        if config.ascii {
            theme.glyphs = &ASCII;
        }
        theme.marker = config.marker;
        theme
    }
}

fn colored(dim: Color, faint: Color, accent: Color) -> Theme {
    let plain = Style::new();
    let bold = plain.add_modifier(Modifier::BOLD);
    Theme {
        plain,
        dim: plain.fg(dim),
        strong: bold,
        title: bold.fg(Color::Cyan),
        rule: plain.fg(faint),
        key: bold.fg(Color::Cyan),
        holder: bold.fg(accent),
        raised: plain.fg(Color::Cyan),
        good: plain.fg(Color::Cyan),
        warning: bold.fg(accent),
        alarm: bold.fg(Color::White).bg(Color::Red),
        wall: plain.fg(dim),
        furniture: plain.fg(faint),
        old_trail: plain.fg(Color::Blue),
        trail: plain.fg(Color::Cyan),
        sonar: plain.fg(dim),
        robot: bold.fg(accent),
        route: bold.fg(Color::Blue),
        draft: plain.fg(Color::Magenta),
        lit: bold.add_modifier(Modifier::REVERSED),
        glyphs: &UNICODE,
        marker: Marker::Braille,
    }
}

/// High contrast: white and yellow on black, independent of the terminal's colours.
fn high_contrast() -> Theme {
    let plain = Style::new().fg(Color::Indexed(231)).bg(Color::Indexed(16));
    let bold = plain.add_modifier(Modifier::BOLD);
    let yellow = Color::Indexed(226);
    Theme {
        plain,
        dim: plain,
        strong: bold,
        title: bold.fg(yellow),
        rule: plain,
        key: bold.fg(yellow),
        holder: bold.add_modifier(Modifier::REVERSED),
        raised: bold.add_modifier(Modifier::UNDERLINED),
        good: plain,
        warning: bold.fg(yellow),
        alarm: bold.fg(Color::Indexed(16)).bg(yellow),
        wall: plain,
        furniture: plain,
        old_trail: plain,
        trail: bold,
        sonar: plain,
        robot: bold.fg(yellow),
        route: bold.fg(yellow),
        draft: bold.fg(Color::Indexed(51)),
        lit: bold.add_modifier(Modifier::REVERSED),
        glyphs: &UNICODE,
        marker: Marker::Braille,
    }
}

fn mono() -> Theme {
    let plain = Style::new();
    let bold = plain.add_modifier(Modifier::BOLD);
    let dim = plain.add_modifier(Modifier::DIM);
    Theme {
        plain,
        dim,
        strong: bold,
        title: bold,
        rule: dim,
        key: bold,
        holder: bold.add_modifier(Modifier::REVERSED),
        raised: plain.add_modifier(Modifier::UNDERLINED),
        good: plain,
        warning: bold,
        alarm: bold.add_modifier(Modifier::REVERSED),
        wall: plain,
        furniture: dim,
        old_trail: plain,
        trail: plain,
        sonar: dim,
        robot: bold,
        route: bold,
        draft: plain,
        lit: bold.add_modifier(Modifier::REVERSED),
        glyphs: &UNICODE,
        marker: Marker::Braille,
    }
}
