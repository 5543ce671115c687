//! The command line: hints for beginners, suggestions for typing errors, configuration and completion.
#![cfg(unix)]

use std::fs;
use std::process::Command;

use clap::CommandFactory as _;
use groundwave::commands::cli::Cli;

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, groundwave, scratch};

#[test]
fn missing_link_is_reported() {
    for arguments in [
        &["send", "mode", "prowl"][..],
        &["send", "stop"],
        &["param", "list"],
        &["param", "set", "top-speed", "8"],
    ] {
        let (_, err) = expect(2, arguments);
        assert!(
            err.contains("is in the place of LINK"),
            "{arguments:?}: {err}"
        );
        assert!(err.contains("groundwave ports"), "{arguments:?}: {err}");
    }
}

#[test]
fn missing_link_argument_explains_links() {
    for verb in ["watch", "record", "send", "param", "calibrate"] {
        let (_, err) = expect(2, &[verb]);
        assert!(err.contains("groundwave ports"), "{verb}: {err}");
    }
    let (out, _) = expect(0, &["--help"]);
    assert!(out.contains("groundwave demo"), "{out}");
}

#[test]
fn wrong_words_are_reported_before_the_link_is_opened() {
    let link = "/dev/no-such-port";
    for (words, told) in [
        (&["send", link][..], "no command given; try `mode prowl`"),
        (
            &["send", link, "prowl", "extra"],
            "`prowl` takes nothing; got `extra`",
        ),
        (
            &["send", link, "mode"],
            "`mode` takes one mode; got nothing",
        ),
        (&["send", link, "porwl"], "did you mean `prowl`?"),
        (
            &["watch", link, "--headless", "--advise=auto"],
            "--advise=auto needs the dashboard",
        ),
        (&["world", "hous"], "did you mean `house`?"),
        (&["sim", "--world", "offce"], "did you mean `office`?"),
        (
            &["send", link, "disable", "bumpers"],
            "`disable bumpers` turns its bumpers off; add --yes",
        ),
        (
            &["param", link, "set", "cliff-guard", "0"],
            "turns its cliff guard off; add --yes",
        ),
        (
            &["param", link],
            "`list`, `get NAME`, `set NAME VALUE`, `NAME VALUE` or `save`",
        ),
        (
            &["param", link, "set", "top-speed"],
            "needs a value; `param get top-speed`",
        ),
    ] {
        let (_, err) = expect(2, words);
        assert!(err.contains(told), "{words:?}: {err}");
    }
}

#[test]
fn trace_and_sound_are_not_overwritten() {
    let folder = scratch("sim-files");
    for option in ["--trace", "--wav"] {
        let path = folder.join("evening");
        fs::write(&path, "yesterday").unwrap();
        let name = path.to_str().unwrap();
        let arguments = [
            "sim",
            "--listen",
            "127.0.0.1:0",
            "--duration",
            "1s",
            "--time-factor",
            "50",
            option,
            name,
        ];
        let (_, err) = expect(2, &arguments);
        assert!(err.contains("exists") && err.contains("--force"), "{err}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "yesterday");
        expect(0, &[&arguments[..], &["--force"]].concat());
        assert_ne!(fs::read(&path).unwrap(), b"yesterday");
    }
}

const SHUT_ROOM: &str = "name = \"shut\"\ncell_in = 12\nplan = '''\n\
##############\n#.....#......#\n#..^..#......#\n#.....#......#\n#.....#......#\n#.....#......#\n##############\n'''\n";

#[test]
fn unreachable_room_is_reported_by_all_commands_that_open_the_world() {
    let folder = scratch("shut-room");
    let path = folder.join("shut.toml");
    fs::write(&path, SHUT_ROOM).unwrap();
    let name = path.to_str().unwrap();
    let told = "the robot cannot reach the";
    let (out, err) = expect(0, &["world", name]);
    assert!(
        err.contains(told) && out.contains("12 inches per character"),
        "{err}{out}"
    );
    let (out, err) = expect(1, &["world", name, "--check"]);
    assert!(err.contains(told) && out.is_empty(), "{err}{out}");
    expect(0, &["world", "house", "--check"]);
    let sim = [
        "sim",
        "--world",
        name,
        "--listen",
        "127.0.0.1:0",
        "--duration",
        "1s",
        "--time-factor",
        "50",
    ];
    let (_, err) = expect(0, &sim);
    assert!(err.contains(told), "{err}");
}

#[test]
fn scan_prints_its_result_or_the_reason_for_a_refusal() {
    let folder = scratch("scan");
    let socket = folder.join("s");
    let socket = socket.to_str().unwrap();
    let sim = Sim::start(&[
        "--listen",
        "127.0.0.1:0",
        "--time-factor",
        "10",
        "--world",
        "open-room",
    ]);
    let link = sim.path.as_str();
    expect(0, &["send", link, "mode", "reactive"]);
    let (out, _) = expect(0, &["send", link, "scan"]);
    assert!(
        out.contains("scan: confirmed") && out.contains("scan: longest view "),
        "{out}"
    );
    expect(0, &["send", link, "disable", "rotate"]);
    let (_, err) = expect(5, &["send", link, "scan"]);
    let why = "layer rotation is forbidden; `enable rotation` first";
    assert!(err.contains(why), "{err}");

    // The station that shares its link is receive-only and tells its clients.
    let mut station = Telling::start(&["watch", link, "--headless", "--share", socket]);
    station.wait_for("line B", |value| value["line_type"] == "B");
    let (_, err) = expect(5, &["send", "--via", socket, "scan"]);
    assert!(err.contains(why), "{err}");
    expect(0, &["send", "--via", socket, "enable", "rotation"]);
    let found = groundwave(&["send", "--via", socket, "scan", "--json"]);
    let found = String::from_utf8(found.stdout).unwrap();
    let last: serde_json::Value = serde_json::from_str(found.lines().last().unwrap()).unwrap();
    assert_eq!(last["status"], "said", "{found}");
    assert!(
        last["text"].as_str().unwrap().starts_with("scan: longest"),
        "{found}"
    );
}

#[test]
fn parameter_is_shown_and_set_in_the_whole_unit() {
    let sim = Sim::start(&["--listen", "127.0.0.1:0", "--time-factor", "10"]);
    let (out, _) = expect(0, &["param", &sim.path, "get", "battery-low"]);
    assert!(out.contains("V/10") && out.contains("= 11.6 V"), "{out}");
    expect(0, &["param", &sim.path, "set", "battery-low", "11.9"]);
    let (out, _) = expect(0, &["param", &sim.path, "get", "battery-low"]);
    assert!(out.contains(" 119 ") && out.contains("= 11.9 V"), "{out}");
    let (_, err) = expect(5, &["param", &sim.path, "set", "battery-low", "20.5"]);
    assert!(err.contains("40 to 130 (V/10), or 4.0 to 13.0 V"), "{err}");
}

#[test]
fn program_without_a_command_suggests_commands() {
    let (out, err) = expect(0, &[]);
    assert!(
        out.contains("groundwave demo") && out.contains("--help"),
        "{out}"
    );
    assert_eq!(err, "");
}

#[test]
fn completions_and_manual_cover_all_commands() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let (out, _) = expect(0, &["completions", shell]);
        assert!(
            out.contains("COMPLETE") && out.contains("groundwave"),
            "{shell}: {out}"
        );
    }
    let (page, _) = expect(0, &["man"]);
    for section in ["EXAMPLES", "KEYS", "EXIT STATUS", "FILES"] {
        assert!(page.contains(section), "{section}: {page}");
    }
    assert!(page.contains("look around once [scan]"), "{page}");
    let folder = scratch("man");
    let pages = folder.join("man1");
    expect(0, &["man", pages.to_str().unwrap()]);
    for verb in Cli::command().get_subcommands() {
        let name = format!("groundwave-{}.1", verb.get_name());
        let own = fs::read_to_string(pages.join(&name)).unwrap_or_default();
        let about = verb.get_about().unwrap().to_string();
        let [page, own] = [&page, &own].map(|page| page.replace(r"\*(Aq", "'").replace('\\', ""));
        assert!(own.contains(&about) && page.contains(&about), "{name}");
    }
    // The script asks the program for words.
    let found = Command::new(GROUNDWAVE)
        .env("COMPLETE", "fish")
        .args(["--", "groundwave", ""])
        .output()
        .unwrap();
    let found = String::from_utf8(found.stdout).unwrap();
    let words: Vec<&str> = found
        .lines()
        .filter_map(|row| row.split('\t').next())
        .collect();
    for verb in Cli::command().get_subcommands() {
        assert!(words.contains(&verb.get_name()), "{found}");
    }
    let send = fs::read_to_string(pages.join("groundwave-send.1")).unwrap();
    assert!(send.contains("\\fBgroundwave send\\fR"), "{send}");
    // Each page that another page refers to exists.
    for page in fs::read_dir(&pages).unwrap() {
        let text = fs::read_to_string(page.unwrap().path()).unwrap();
        let named = text.split_whitespace().filter_map(|word| {
            let (name, _) = word.split_once("(1)")?;
            name.starts_with("groundwave")
                .then(|| name.replace("\\-", "-"))
        });
        for name in named {
            assert!(pages.join(format!("{name}.1")).exists(), "{name}");
        }
    }
}

#[test]
fn configuration_is_printed_and_checked() {
    let folder = scratch("config");
    let path = folder.join("config.toml");
    let name = path.to_str().unwrap();
    let (printed, told) = expect(0, &["--config", name, "config"]);
    assert!(told.contains("does not exist yet"), "{told}");
    fs::write(&path, &printed).unwrap();
    let (out, _) = expect(0, &["config", "check", name]);
    assert!(
        out.contains("good: no links, no robots, default keys"),
        "{out}"
    );
    fs::write(&path, "[link]\nradoi = \"half\"\n").unwrap();
    for arguments in [
        &["config", "check", name][..],
        &["--config", name, "send", "/dev/no-such-port", "dock"],
        &["--config", name],
    ] {
        let (_, err) = expect(2, arguments);
        let told = format!("{name}:2:1: unknown key `radoi` in [link]; did you mean `radio`?");
        assert!(err.contains(&told), "{err}");
    }
    fs::write(&path, "[link]\nbaud = \"x\"\n[keys]\nstop = \"y\"\n").unwrap();
    let (_, err) = expect(2, &["config", "check", name]);
    assert!(
        err.contains("2 mistakes") && err.contains("every setting"),
        "{err}"
    );
    for told in [":2:8: `baud`: ", ":4:1: `y` cannot be the key for `stop`"] {
        assert!(err.contains(&format!("{name}{told}")), "{err}");
    }
    let (out, _) = expect(0, &["--config", name, "config", "path"]);
    assert_eq!(out.trim(), name);
}

#[test]
fn configured_robot_name_is_a_link() {
    let folder = scratch("profile");
    let sim = Sim::start(&["--listen", "127.0.0.1:0"]);
    let path = folder.join("config.toml");
    let text = format!(
        "[link.shed]\nport = \"{}\"\n[robot.marvin]\nlink = \"shed\"\n",
        sim.path
    );
    fs::write(&path, text).unwrap();
    let config = ["--config", path.to_str().unwrap()];
    for name in ["marvin", "shed"] {
        let (out, _) = expect(
            0,
            &[&config[..], &["send", name, "mode", "reactive"]].concat(),
        );
        assert!(out.contains("confirmed"), "{out}");
    }
    let (_, err) = expect(2, &[&config[..], &["send", "marvn", "stop"]].concat());
    assert!(err.contains("did you mean `marvin`?"), "{err}");
    let (out, _) = expect(0, &config);
    assert!(out.contains("groundwave watch marvin "), "{out}");
}

/// The shell completes words of the program, files and names in the configuration.
#[test]
fn shell_completes_existing_names() {
    let folder = scratch("completions");
    fs::write(folder.join("square.csv"), "1,2\n").unwrap();
    fs::create_dir(folder.join("inner")).unwrap();
    for name in [
        "flat.toml",
        "run.mcap",
        "run.txt",
        "run.svg",
        "run.mcap.run.toml",
    ] {
        fs::write(folder.join(name), "").unwrap();
    }
    let config = folder.join("config.txt");
    fs::write(&config, "[robot.marvin]\nlink = \"sim\"\n").unwrap();
    let config = config.to_str().unwrap();
    let offered = |words: &[&str]| {
        let output = Command::new(GROUNDWAVE)
            .args([&["--", "groundwave"], words].concat())
            .env("COMPLETE", "bash")
            .env("_CLAP_IFS", "\n")
            .env("_CLAP_COMPLETE_INDEX", words.len().to_string())
            .current_dir(&folder)
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    for (words, wanted) in [
        (&["wat"][..], &["watch"][..]),
        (&["demo", "--world", ""], &["house", "office", "flat.toml"]),
        (&["world", "dark"], &["dark-room"]),
        (&["demo", "--channel", "ber=1e-3,bu"], &["ber=1e-3,burst="]),
        (&["send", "sim", ""], &["goto", "preset", "failsafe"]),
        (&["send", "sim", "mode", ""], &["prowl", "home"]),
        (&["send", "sim", "enable", "ir,so"], &["ir,sonar"]),
        (&["send", "sim", "only", "n"], &["none"]),
        (&["send", "sim", "preset", "mo"], &["moth"]),
        (&["send", "sim", "route", "sq"], &["square.csv"]),
        (&["send", "--via", "4001", "pre"], &["preset"]),
        (&["param", "sim", ""], &["list", "get", "set", "save"]),
        (&["param", "sim", "get", "top"], &["top-speed"]),
        (&["param", "--via", "4001", ""], &["get", "track"]),
        (&["param", "sim", "so"], &["sonar-close", "sonar-deadzone"]),
        (
            &["param", "--via", "4001", "set", "wheel-l"],
            &["wheel-left"],
        ),
        (&["send", "sim", "param", ""], &["list", "set", "track"]),
        (&["send", "sim", "param", "get", "ir"], &["ir-count-least"]),
        (&["watch", "sim", "--radio", "h"], &["half", "hc-12"]),
        (&["--config", config, "watch", "mar"], &["marvin"]),
        (&["watch", "t"], &["tcp:"]),
        (&["replay", "run"], &["run.mcap"]),
    ] {
        let said = offered(words);
        for word in wanted {
            assert!(said.lines().any(|line| line == *word), "{words:?}: {said}");
        }
    }
    assert!(!offered(&["send", "sim", "mode", ""]).contains("goto"));
    for (verb, wanted) in [("replay", "run.mcap"), ("info", "run.txt")] {
        let offered = offered(&[verb, "run"]);
        let is_capture = |name: &str| name == "run.mcap" || name == "run.txt";
        assert!(offered.contains(wanted), "{offered}");
        assert!(offered.lines().all(is_capture), "{offered}");
    }
    assert!(!offered(&["demo", "--world", "run"]).contains("run."));
    for words in [&["replay", ""][..], &["demo", "--world", ""]] {
        let offered = offered(words);
        assert!(offered.lines().all(|line| line != "."), "{offered}");
        assert!(offered.lines().any(|line| line == "inner/"), "{offered}");
    }
    assert!(!offered(&["send", "sim", "param", "set", "track", ""]).contains("track"));
    assert!(!offered(&["param", "sim", "set", "track", ""]).contains("track"));
}
