//! What every section may say: its keys, and what each takes.

/// What a key takes, for a person.
pub(super) enum Takes {
    /// Described.
    Value(&'static str),
    /// One of these words.
    OneOf(&'static [&'static str]),
}

/// A key and what it takes.
pub(super) type Entry = (&'static str, Takes);

pub(super) const SECTIONS: &[&str] = &["link", "robot", "dashboard", "recording", "limits", "keys"];

const BAUD: Entry = ("baud", Takes::Value("a whole number such as 2400"));
const RADIO: Entry = (
    "radio",
    Takes::OneOf(&["auto", "full", "half", "hc-12", "xbee", "receive-only"]),
);
const LATENCY: Entry = ("latency_ms", Takes::Value("whole milliseconds such as 80"));
const SHARE: Entry = (
    "share",
    Takes::Value("a port such as \"4001\", an address or the path of a Unix socket"),
);
const THEME: Entry = (
    "theme",
    Takes::OneOf(&["auto", "dark", "light", "high-contrast", "mono"]),
);
const ASCII: Entry = ("ascii", Takes::Value("true or false"));
const BELL: Entry = ("bell", Takes::Value("true or false"));
const MOUSE: Entry = ("mouse", Takes::Value("true or false"));
const DECIVOLTS: Takes = Takes::Value("whole tenths of a volt such as 116");
const SECONDS: Takes = Takes::Value("whole seconds such as 5");

pub(super) const LINK: &[Entry] = &[BAUD, RADIO, LATENCY, SHARE];

pub(super) const LINK_PROFILE: &[Entry] = &[
    (
        "port",
        Takes::Value("a LINK as on the command line, such as \"/dev/ttyUSB0\""),
    ),
    BAUD,
    RADIO,
    LATENCY,
    SHARE,
];

pub(super) const DASHBOARD: &[Entry] = &[THEME, ASCII, BELL, MOUSE];

pub(super) const ROBOT: &[Entry] = &[
    (
        "link",
        Takes::Value("the name of a [link.NAME], or a LINK as on the command line"),
    ),
    THEME,
    ASCII,
    BELL,
    MOUSE,
];

pub(super) const RECORDING: &[Entry] = &[
    ("keep_minutes", Takes::Value("whole minutes such as 10")),
    (
        "rotate",
        Takes::Value("\"1h\", \"64MB\", both with a comma between, or \"never\""),
    ),
];

pub(super) const LIMITS: &[Entry] = &[
    ("battery_low_dv", DECIVOLTS),
    ("battery_critical_dv", DECIVOLTS),
    ("battery_hysteresis_dv", DECIVOLTS),
    ("battery_for_s", SECONDS),
    ("silent_s", SECONDS),
    ("loss_pct", Takes::Value("a whole number from 0 to 100")),
    ("loss_for_s", SECONDS),
    ("stalled_s", SECONDS),
    ("fallen_s", SECONDS),
    ("thrash_s", SECONDS),
];
