//! Configurations, and the mistakes reported in them.

use std::fmt::Write as _;
use std::time::Duration;

use super::super::cli::LinkArgs;
use super::{Config, DEFAULT, Theme, parse};
use crate::model::Limits;
use crate::model::keys::Keymap;
use crate::radio::RadioKind;

#[test]
fn every_section_is_optional_and_read() {
    assert_eq!(parse(""), Ok(Config::default()));
    let text = "[link]\nradio = \"hc-12\"\nlatency_ms = 350\nbaud = 9600\n\
                [link.shed]\nport = \"usb:0403:6001\"\nshare = \"4001\"\n\
                [robot.marvin]\nlink = \"shed\"\ntheme = \"high-contrast\"\n\
                [dashboard]\nbell = false\n[keys]\nscan = \"F12\"\nquit = []\n[keys.drive]\nleave-drive = [\"x\"]\n";
    let config = parse(text).expect("it is right");
    assert_eq!(config.link.radio, Some(RadioKind::Hc12));
    assert_eq!(config.link.latency(), Some(Duration::from_millis(350)));
    assert_eq!(config.links["shed"].share, "4001".parse().ok());
    assert_eq!(config.robots["marvin"].theme, Some(Theme::HighContrast));
    assert_eq!(config.dashboard.bell, Some(false));
    assert_ne!(config.keys, Keymap::default());
}

/// Asserts that each text has one mistake, with the given words.
fn assert_mistakes(cases: &[(&str, &str)]) {
    for (text, named) in cases {
        let mistakes = parse(text).expect_err(text);
        let [error] = &mistakes[..] else {
            panic!("{text}: {mistakes:?}");
        };
        let error = error.to_string();
        assert!(error.contains(named), "{text}: {error}");
    }
}

#[test]
fn mistakes_have_line_and_column() {
    assert_mistakes(&[
        (
            "[link]\nradoi = \"half\"\n",
            "2:1: unknown key `radoi` in [link]; did you mean `radio`?",
        ),
        (
            "[link]\nradio = \"hc12\"\n",
            "2:9: `radio`: unknown variant `hc12`, expected one of `auto`, `full`, `half`, `hc-12`, `xbee`, `receive-only`; did you mean `hc-12`?",
        ),
        (
            "[link]\nbaud = -1\n",
            "2:8: `baud`: invalid value: integer `-1`, expected a whole number, 0 or more",
        ),
        (
            "\n[lnik]\n",
            "2:2: unknown key `lnik` at the top of the file; did you mean `link`?",
        ),
        ("link", "1:5: "),
        (
            "link = 3\n",
            "1:8: `link`: invalid type: integer `3`, expected a section",
        ),
        (
            "[link]\nport = \"x\"\n",
            "2:1: unknown key `port` in [link]",
        ),
        ("[link.shed]\nbaud = 9600\n", "[link.shed] needs a port"),
        (
            "[link.shed]\nprot = \"x\"\n",
            "2:1: unknown key `prot` in [link.shed]; did you mean `port`?",
        ),
        (
            "[link]\nshare = \"nowhere\"\n",
            "2:9: `share`: `nowhere` is neither a port",
        ),
        (
            "[limits]\nsilent = 3\n",
            "2:1: unknown key `silent` in [limits]; did you mean `silent_s`?",
        ),
        (
            "[robot.r]\nlink = \"sim\"\n[robot.r.limits]\nloss_pct = 300\n",
            "4:12: `loss_pct`: invalid value: integer `300`, expected a whole number from 0 to 255",
        ),
        ("[limits]\nloss_pct = 101\n", "loss_pct = 101 is above 100"),
        ("[recording]\nrotate = \"3 weeks\"\n", "2:10: `rotate`: "),
        (
            "[robot]\nlink = \"x\"\n",
            "2:8: `link`: invalid type: string \"x\", expected a section",
        ),
        ("[robot.r]\n", "[robot.r] needs a link"),
        (
            "[link.shed]\nport = \"sim\"\n[robot.r]\nlink = \"shd\"\n",
            "there is no [link.shd]; did you mean `shed`?",
        ),
        ("[link]\nbaud = 0\n", "baud must be above 0"),
        (
            "[limits]\nbattery_low_dv = 100\nbattery_critical_dv = 120\n",
            "battery_low_dv = 100 is below",
        ),
        (
            "[dashboard]\nthema = 1\n",
            "2:1: unknown key `thema` in [dashboard]; did you mean `theme`?",
        ),
        (
            "[dashboard]\ntheme = \"pink\"\n",
            "2:9: `theme`: unknown variant `pink`, expected one of `auto`, `dark`, `light`, `high-contrast`, `mono`",
        ),
        (
            "[keys]\nscna = \"F12\"\n",
            "2:1: no key does `scna`; did you mean `scan`?",
        ),
        (
            "[keys]\nscan = \"x\"\n",
            "2:1: `x` cannot be the key for `scan`: it is the key for `cancel-commands`",
        ),
        (
            "[keys]\nleave-drive = \"x\"\n",
            "2:1: no key does `leave-drive` here; did you mean `leave-drive` in [keys.drive]?",
        ),
        (
            "[keys]\nscan = 9\n",
            "2:8: `scan`: expected a key such as \"F12\"",
        ),
        (
            "[keys.dirve]\nstop = \"x\"\n",
            "2:1: there are no keys called `dirve`; did you mean `drive`?",
        ),
    ]);
}

#[test]
fn mistakes_in_alarms_are_named() {
    assert_mistakes(&[
        (
            "[alarm]\nrun = \"x\"\n",
            "1:1: alarms are a list: write [[alarm]]",
        ),
        (
            "[[alarm]]\nfield = \"x_in\"\n",
            "1:1: [[alarm]] needs a name",
        ),
        (
            "[[alarm]]\nname = \"a\"\nfield = \"x_in\"\nabov = 3\n",
            "4:1: unknown key `abov` in [alarm]; did you mean `above`?",
        ),
        (
            "[[alarm]]\nname = \"a\"\nfield = \"batery_v\"\nbelow = 3\n",
            "alarm `a`: unknown field `batery_v`; did you mean `battery_v`?",
        ),
        (
            "[[alarm]]\nname = \"a\"\nfield = \"mode\"\nequals = \"prowel\"\n",
            "alarm `a`: mode is never `prowel`; did you mean `prowl`?",
        ),
        (
            "[[alarm]]\nname = \"a\"\nfield = \"x_in\"\n",
            "alarm `a` needs one limit: above, below or equals",
        ),
        (
            "[[alarm]]\nname = \"batery low\"\nbelow = 12\n",
            "no built-in alarm is named `batery low`; did you mean `battery_low`?",
        ),
        (
            "[[alarm]]\nname = \"failsafe\"\nbelow = 12\n",
            "the built-in alarm `failsafe` has no such limit",
        ),
        (
            "[[alarm]]\nname = \"stalled\"\nenabled = false\n[[alarm]]\nname = \"stalled\"\n",
            "4:1: alarm `stalled` is there twice",
        ),
    ]);
}

/// Only a robot's own lines show which fields they have.
#[test]
fn an_alarm_on_an_unknown_field_is_noted() {
    let text = "[[alarm]]\nname = \"warm\"\nfield = \"motor_temp\"\nabove = 60\n\
                [[alarm]]\nname = \"far\"\nfield = \"x\"\nabove = 60\n";
    let config = parse(text).expect("it is right");
    let [note] = &config.notes[..] else {
        panic!("{:?}", config.notes);
    };
    let note = note.to_string();
    assert!(
        note.starts_with(
            "3:9: alarm `warm`: only a robot with its own lines can have the field `motor_temp`"
        ),
        "{note}"
    );
}

#[test]
fn all_mistakes_are_reported_in_the_order_of_the_text() {
    let text = "[keys]\nstop = \"y\"\nquit = 9\n[link]\nradoi = \"half\"\nbaud = \"x\"\n\
                [robot.r]\nlink = 3\n[robot.r.limits]\nsilent = 3\n[limits]\nloss_pct = -1\n";
    let mistakes = parse(text).expect_err("nearly all of it is wrong");
    let places: Vec<(usize, usize)> = mistakes
        .iter()
        .map(|mistake| (mistake.line, mistake.column))
        .collect();
    let expected = [(2, 1), (3, 8), (5, 1), (6, 8), (8, 8), (10, 1), (12, 12)];
    assert_eq!(places, expected, "{mistakes:?}");
    let notation = parse("[link\nbaud = 2400\n[dashboard]\nbell = tru\n").expect_err("no TOML");
    let lines: Vec<usize> = notation.iter().map(|mistake| mistake.line).collect();
    assert_eq!(lines, [1, 4], "{notation:?}");
}

/// Each mistake takes another pass, so a long text of mistakes is not read to its end.
#[test]
fn a_long_text_of_mistakes_is_given_up() {
    let mut text = String::new();
    for n in 0..100_000 {
        writeln!(text, "[t{n}]").expect("strings take any text");
    }
    let mistakes = parse(&text).expect_err("no section has such a name");
    assert!((2..1000).contains(&mistakes.len()), "{}", mistakes.len());
    let places: Vec<_> = mistakes.iter().map(|it| (it.line, it.column)).collect();
    assert!(places.is_sorted() && places[0] == (1, 2), "{places:?}");
}

/// The keys of a section that the message about an unknown key lists.
fn known_keys(section: &str) -> Vec<String> {
    let text = format!("[{section}]\nqwertyuiop = 1\n");
    let mistakes = parse(&text).expect_err("no such key");
    let (_, list) = mistakes[0].message.split_once("; known: ").expect("a list");
    let keys = list.split(", ").filter(|key| *key != "limits");
    keys.map(str::to_owned).collect()
}

#[test]
fn default_file_parses_as_it_is_and_with_every_line_uncommented() {
    assert_eq!(parse(DEFAULT), Ok(Config::default()));
    let offered: Vec<&str> = DEFAULT
        .lines()
        .map(|line| {
            let rest = line.strip_prefix("# ").unwrap_or(line);
            let word = rest.split(" = ").next().unwrap_or_default();
            let is_setting = word.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
            if is_setting || rest.starts_with('[') {
                rest
            } else {
                line
            }
        })
        .collect();
    let offered = offered.join("\n");
    let config = parse(&offered).unwrap_or_else(|mistakes| panic!("{mistakes:?}\n{offered}"));
    assert_eq!(config.links.keys().collect::<Vec<_>>(), ["shed"]);
    assert_eq!(
        config.robots.keys().collect::<Vec<_>>(),
        ["marvin", "rover"]
    );
    assert_eq!(config.limits, Limits::default());
    for section in [
        "link.shed",
        "robot.marvin",
        "dashboard",
        "recording",
        "limits",
    ] {
        for key in known_keys(section) {
            let is_offered = |line: &str| {
                line.starts_with(&format!("{key} = ")) || line.ends_with(&format!(".{key}]"))
            };
            assert!(offered.lines().any(is_offered), "{key}");
        }
    }
}

#[test]
fn lines_and_commands_of_a_robot_are_read_and_checked() {
    let text = "[robot.rover]\nlink = \"sim\"\n[robot.rover.lines]\nform = \"csv\"\nchecksum = \"crc16-ccitt\"\nfields = [{ name = \"x\", unit = \"cm\", role = \"x\" }]\n\
                [robot.rover.commands]\nstop = { send = \"S\\n\", reply = \"OK\" }\n";
    let config = parse(text).expect("it is right");
    let (_, config) = config
        .at(&"rover".parse().expect("a link"), &LinkArgs::default())
        .expect("it is found");
    assert_eq!(config.own.commands["stop"].send, "S\n");
    assert_eq!(config.own.lines.expect("a profile").fields[0].name, "x");
    for (wrong, place, expected) in [
        (
            "unit = \"cm\", ",
            "6:10",
            "field \"x\": role x needs a unit",
        ),
        ("role = \"x\"", "6:", "unknown variant `z`"),
        ("form = \"csv\"", "5:11", "pattern: unclosed group"),
        (
            "\"OK\"",
            "8:8",
            "[robot.rover.commands] stop: reply needs 1",
        ),
    ] {
        let with = match wrong {
            "role = \"x\"" => "role = \"z\"",
            "form = \"csv\"" => "form = \"regex\"\npattern = '('",
            "\"OK\"" => "\"\"",
            _ => "",
        };
        let mistakes = parse(&text.replace(wrong, with)).expect_err(wrong);
        let told = mistakes[0].to_string();
        assert!(told.starts_with(place) && told.contains(expected), "{told}");
    }
}

#[test]
fn an_alarm_of_a_built_in_name_changes_its_limits_also_of_robots() {
    let text = "[[alarm]]\nname = \"battery low\"\nbelow = 12\nfor_s = 9\n[robot.a]\nlink = \"sim\"\n\
                [robot.b]\nlink = \"sim\"\nlimits = { battery_low_dv = 130 }\n";
    let config = parse(text).expect("it is right");
    let limits = |limits: &Limits| (limits.battery_low_dv, limits.battery_for_s);
    assert_eq!(limits(&config.limits), (120, 9));
    assert_eq!(limits(&config.robots["a"].limits), (120, 9));
    assert_eq!(limits(&config.robots["b"].limits), (130, 9));
}
