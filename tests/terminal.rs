//! The dashboard on a terminal: keys, mouse, pastes, sizes, signals.
#![cfg(unix)]

use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, scratch};
use crate::pty::{OnTerminal, Picture};
use foxglove::messages::Log;
use prost::Message;
use serde_json::Value;

const ENTER: &str = "\r";
const ESC: &str = "\x1b";

/// A dashboard that receives lines.
fn watch(sim: &Sim, more: &[&str], columns: u16, rows: u16) -> OnTerminal {
    let arguments = [&["watch", sim.path.as_str()], more].concat();
    let mut watch = OnTerminal::start(GROUNDWAVE, &arguments, columns, rows);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    watch
}

fn signal(watch: &OnTerminal, name: &str) {
    let pid = watch.child.process_id().unwrap().to_string();
    let sent = Command::new("kill").args([name, &pid]).status().unwrap();
    assert!(sent.success());
}

/// Position of a text on the screen, counted from 1 as terminals do.
fn place(watch: &OnTerminal, words: &str) -> (usize, usize) {
    let text = watch.text();
    let found = (1..).zip(text.lines()).find_map(|(row, line)| {
        let before = line.split_once(words)?.0;
        Some((before.chars().count() + 1, row))
    });
    found.unwrap_or_else(|| panic!("no `{words}` in\n{text}"))
}

/// The sequence of a mouse button pressed at a position, or of the wheel.
fn mouse(button: u8, (column, row): (usize, usize)) -> String {
    format!("\x1b[<{button};{column};{row}M")
}

const LEFT_BUTTON: u8 = 0;
const WHEEL_UP: u8 = 64;

/// The sequence of a paste, with its lines ended as by the Enter key.
fn paste(text: &str) -> String {
    format!("\x1b[200~{}\x1b[201~", text.replace('\n', "\r"))
}

/// Presses a key with each line of the robot, as a keyboard repeats it, until the screen shows a text.
fn hold(watch: &mut OnTerminal, key: &str, shown: &str) {
    let newest = |text: &str| text.lines().rev().nth(2).map(str::to_owned);
    for _ in 0..30 {
        watch.type_keys(key);
        let before = newest(&watch.text());
        watch.wait_for("the next line", |text| newest(text) != before);
        if watch.text().contains(shown) {
            return;
        }
    }
    panic!(
        "held, and never saw: {shown}. The screen:\n{}",
        watch.text()
    );
}

fn leave(mut watch: OnTerminal) {
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
    assert!(!watch.is_alternate());
}

#[test]
fn a_click_chooses_a_panel_and_the_wheel_zooms() {
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &[], 120, 40);
    watch.type_keys(&mouse(LEFT_BUTTON, place(&watch, "F6 log")));
    watch.wait_for("the log's keys", |text| {
        let footer = text.lines().last().unwrap_or_default();
        footer.contains("n N next")
    });
    let scale = |text: &str| {
        let before = text.split(" ft").next().unwrap_or_default();
        before.rsplit(' ').next().unwrap_or_default().to_owned()
    };
    let wide = scale(&watch.text());
    watch.type_keys(&mouse(WHEEL_UP, (20, 12)).repeat(6));
    watch.wait_for("a closer look", |text| scale(text) != wide);
    watch.type_keys(&mouse(LEFT_BUTTON, (20, 12)));
    watch.wait_for("the cursor", |text| {
        let footer = text.lines().last().unwrap_or_default();
        footer.contains("arrows move  w add") && text.contains('╋')
    });
    leave(watch);
}

/// A route that takes seconds to transfer is pasted and sent while the window is resized.
#[test]
fn a_pasted_route_is_sent_while_the_size_changes() {
    let mut route = String::new();
    for n in 0..100 {
        writeln!(route, "{},{}", n, -n).unwrap();
    }
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &[], 120, 40);
    watch.type_keys(&paste(&route));
    watch.wait_for("the draft", |text| {
        text.contains("pasted: 100 waypoints drafted")
    });
    watch.type_keys("S");
    // A terminal of one cell takes no key but STOP.
    watch.wait_for("that it is sent", |text| {
        !text.contains("draft: 100 waypoints, not sent")
    });
    for (columns, rows) in [(80, 24), (40, 10), (200, 60), (1, 1), (120, 40)] {
        watch.resize(columns, rows);
    }
    watch.wait_for("all of it, at the new size", |text| {
        text.contains("confirmed ") && text.lines().any(|line| line.contains("── F6 log"))
    });
    // STOP works on a terminal that is too small for the dashboard.
    watch.resize(40, 10);
    watch.wait_for("what it needs", |text| text.contains("needs 80x24"));
    watch.type_keys(" ");
    watch.resize(120, 40);
    watch.wait_for("STOP", |text| text.contains("stop: confirmed"));
    leave(watch);
}

#[test]
fn a_paste_that_is_no_route_shows_its_error() {
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &[], 80, 24);
    watch.type_keys(&paste("12,4\nhello\n"));
    watch.wait_for("what is wrong", |text| text.contains("pasted:2:1: "));
    // A prompt takes the first line and runs nothing.
    watch.type_keys(":");
    watch.wait_for("the prompt", |text| text.contains("Esc cancel"));
    watch.type_keys(&paste("mode prowl\nstop\n"));
    watch.wait_for("one line", |text| text.contains(":mode prowl▏"));
    watch.type_keys(ESC);
    watch.wait_for("no prompt", |text| !text.contains("Esc cancel"));
    leave(watch);
}

/// Over a slow connection, the letters of an arrow key's sequence are not keys; `D` would dock the robot.
#[test]
fn esc_and_an_arrow_in_one_burst_send_nothing() {
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &[], 120, 40);
    for keys in ["\x1b\x1b[D", "\x1b\x1b[1;2D", "\x1b\x1b[5~", "\x1b\x1bOC"] {
        watch.type_keys(":mode wander");
        watch.wait_for("the prompt", |text| text.contains("Esc cancel"));
        watch.type_keys(keys);
        watch.wait_for("no prompt", |text| !text.contains("Esc cancel"));
    }
    watch.type_keys("mp");
    watch.wait_for("confirmation", |text| {
        text.contains("mode prowl: confirmed")
    });
    let text = watch.text();
    for word in ["dock", "wander", "photo", "clear"] {
        let asked = format!("{word}: ");
        assert!(!text.contains(&asked), "`{asked}` in\n{text}");
    }
    leave(watch);
}

/// A broken program or line leaves a sequence without its end; the keys after it count.
#[test]
fn stop_and_ctrl_c_work_after_an_unfinished_sequence() {
    for begun in ["\x1b[200~", "\x1b[1;1;", "\x1b["] {
        let sim = Sim::start(&[]);
        let mut watch = watch(&sim, &[], 120, 40);
        watch.type_keys(begun);
        watch.wait_for("the next line", |text| text.contains("newest <1 s"));
        while !watch.text().contains("stop: confirmed") {
            watch.type_keys(" ");
            let before = watch.text();
            watch.wait_for("the next line", |text| text != before);
        }
        watch.type_keys(begun);
        watch.type_keys("\x03");
        assert_eq!(watch.wait(), 0, "{begun:?}");
    }
}

#[test]
fn a_wrong_file_name_is_corrected_in_the_prompt() {
    let folder = scratch("mended");
    let route = folder.join("tour.txt");
    fs::write(&route, "48,0\n48,48\n").unwrap();
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &[], 120, 40);
    watch.type_keys(&format!("r{}x{ENTER}", route.display()));
    watch.wait_for("that there is no such file", |text| {
        text.contains("tour.txtx▏") && text.contains("file not found")
    });
    watch.type_keys(&format!("\x7f{ENTER}"));
    watch.wait_for("the draft", |text| text.contains("2 waypoints drafted"));
    leave(watch);
}

/// Hand driving starts and stops on terminals with and without key-up reports.
#[test]
fn hand_driving_survives_a_terminal_without_key_up() {
    let (up, up_released) = ("\x1b[A", "\x1b[1;1:3A");
    let stands = |text: &str| text.contains("L  +0 of  +0  R  +0 of  +0");
    let sim = Sim::start(&["--world", "open-room"]);
    let mut watch = watch(&sim, &[], 120, 40);
    watch.type_keys("d");
    watch.wait_for("the question", |text| text.contains("Drive by hand?"));
    watch.type_keys("y");
    watch.wait_for("mode user", |text| text.contains("HAND DRIVE 8 in/s"));
    watch.wait_for("that it stands", stands);
    for after in ["", up_released] {
        hold(&mut watch, up, "of  +8");
        watch.type_keys(after);
        watch.wait_for("that it stands again", stands);
    }
    watch.type_keys(ESC);
    watch.wait_for("what follows", |text| {
        text.contains("it stands in mode user: m p prowls")
    });
    leave(watch);
}

#[test]
fn a_suspended_dashboard_restores_the_terminal_and_resumes() {
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &[], 100, 30);
    // At the same size, where only resuming causes a frame, and at another.
    for size in [(100, 30), (80, 24)] {
        signal(&watch, "-TSTP");
        watch.wait_for_terminal("the terminal given back", |screen| {
            !screen.alternate_screen()
        });
        watch.wait_until_stopped();
        if size != (100, 30) {
            watch.resize(size.0, size.1);
        }
        signal(&watch, "-CONT");
        watch.wait_for_terminal("the dashboard again, whole", |screen| {
            screen.alternate_screen() && screen.contents().contains("F2 sensors")
        });
    }
    assert!(watch.text().lines().count() <= 24);
    leave(watch);
}

#[test]
fn a_signal_finishes_the_recording_and_restores_the_terminal() {
    for name in ["-HUP", "-TERM", "-INT", "-QUIT"] {
        let folder = scratch(&format!("ended{name}"));
        let capture = folder.join("run.mcap");
        let capture = capture.to_str().unwrap();
        let sim = Sim::start(&[]);
        let mut watch = watch(&sim, &["--record", capture], 80, 24);
        watch.wait_for("its mode", |text| text.contains("PROWL"));
        signal(&watch, name);
        assert_eq!(watch.wait(), 0, "{name}");
        assert!(!watch.is_alternate(), "{name}");
        let told = format!("recorded {capture}; `groundwave replay {capture}` plays it");
        let text = watch.text().replace('\n', "");
        assert!(text.contains(&told), "{text}");
        assert!(text.contains("the robot is still in mode prowl"), "{text}");
        let (info, _) = expect(0, &["info", capture]);
        assert!(info.contains("lines"), "{info}");
    }
}

#[test]
fn a_mark_of_a_live_session_comes_back_in_the_replay_of_its_recording() {
    let folder = scratch("marked");
    let capture = folder.join("run.mcap");
    let capture = capture.to_str().unwrap();
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &["--record", capture], 120, 40);
    watch.type_keys("alamp fell\r");
    watch.wait_for("its text", |text| text.contains("note: lamp fell"));
    leave(watch);
    let (label, _) = expect(0, &["label", capture]);
    assert!(label.contains("lamp fell"), "{label}");
    let bytes = fs::read(capture).unwrap();
    let marks = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap);
    let marks = marks.filter(|message| message.channel.topic == "/log");
    let marks = marks.filter_map(|message| Log::decode(&*message.data).ok());
    assert_eq!(marks.filter(|log| log.name == "mark").count(), 1);
    let mut replay = OnTerminal::start(GROUNDWAVE, &["replay", capture], 120, 40);
    let has_mark = |text: &str| text.lines().nth(1).is_some_and(|time| time.contains('◇'));
    replay.wait_for("the mark in the bar of time", has_mark);
    replay.type_keys("Nm");
    replay.type_keys("nm");
    replay.type_keys("a\r");
    replay.wait_for("that it stood at the mark", |text| {
        text.contains("note removed: lamp fell") && !has_mark(text)
    });
    leave(replay);
}

/// Old terminals and C locales get only ASCII and no colours.
#[test]
fn a_plain_terminal_gets_ascii_without_colors() {
    let sim = Sim::start(&[]);
    let arguments = [
        "NO_COLOR=1",
        "LC_ALL=C",
        "TERM=vt100",
        GROUNDWAVE,
        "watch",
        &sim.path,
    ];
    let mut watch = OnTerminal::start("env", &arguments, 80, 24);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    for keys in ["", "?", "\x1b", "\x1bOS"] {
        watch.type_keys(keys);
        let shown = match keys {
            "?" => "STOP (Ctrl-S while typing)",
            "\x1bOS" => "-- F4 plots",
            _ => "-- who holds the motors",
        };
        watch.wait_for_terminal(shown, |screen| screen.contents().contains(shown));
        watch.wait_for_terminal("ASCII without colours", |screen| {
            let cells = (0..24).flat_map(|row| (0..80).map(move |column| (row, column)));
            let mut cells = cells.filter_map(|(row, column)| screen.cell(row, column));
            cells.all(|cell| {
                cell.contents().is_ascii()
                    && cell.fgcolor() == vt100::Color::Default
                    && cell.bgcolor() == vt100::Color::Default
            })
        });
    }
    leave(watch);
}

/// `map = "pixels"`: the lines of the map are a picture on terminals that report their name, and braille characters on others.
#[test]
fn the_map_is_a_picture_for_terminals_that_show_pictures() {
    let folder = scratch("pixels");
    fs::create_dir(folder.join("groundwave")).unwrap();
    let config = "[dashboard]\nmap = \"pixels\"\n";
    fs::write(folder.join("groundwave/config.toml"), config).unwrap();
    let home = format!("XDG_CONFIG_HOME={}", folder.display());
    let has_braille = |text: &str| text.contains(|c: char| ('\u{2801}'..='\u{28FF}').contains(&c));
    for (term, shows_pictures) in [("TERM=xterm-kitty", true), ("TERM=xterm-256color", false)] {
        let arguments = [term, &home, "TERM_PROGRAM=", GROUNDWAVE, "demo"];
        let mut demo = OnTerminal::start("env", &arguments, 80, 24);
        demo.wait_for("the robot", |text| {
            text.contains("walls: simulator's truth")
        });
        let text = demo.text();
        assert_eq!(has_braille(&text), !shows_pictures, "{text}");
        assert!(text.contains("── map") && text.contains('⌂'), "{text}");
        // The picture follows its characters.
        demo.wait_for_raw("the picture", |demo| {
            demo.picture().is_some() == shows_pictures
        });
        let picture = demo.picture();
        if let Some(picture) = &picture {
            show_the_walls(&demo, picture);
        }
        // A window covers the picture, which comes back behind the map.
        demo.type_keys("?");
        demo.wait_for("the help", |text| {
            text.contains("STOP (Ctrl-S while typing)")
        });
        demo.wait_for_raw("no picture", |demo| demo.picture().is_none());
        demo.type_keys(ESC);
        demo.wait_for("the map", |text| {
            let is_covered = text.contains("STOP (Ctrl-S while typing)");
            !is_covered && text.contains("── map") && has_braille(text) != shows_pictures
        });
        // The picture has the colours of the theme.
        demo.wait_for_raw("the picture", |demo| {
            demo.picture().is_some() == shows_pictures
        });
        demo.type_keys("\x14");
        demo.wait_for("the theme", |text| text.contains("theme light"));
        let palette = |picture: &Option<Picture>| picture.as_ref().map(|it| it.palette.clone());
        demo.wait_for_raw("its colours", |demo| {
            !shows_pictures || palette(&demo.picture()) != palette(&picture)
        });
        leave(demo);
    }
}

/// Checks that a picture lies within the map's panel, and that it has walls.
fn show_the_walls(demo: &OnTerminal, picture: &Picture) {
    let (column, row) = place(demo, "── map");
    let (top, left) = picture.place;
    assert!(
        usize::from(top) > row && usize::from(left) >= column,
        "{:?}",
        picture.place
    );
    let (columns, rows) = picture.cells;
    assert_eq!(picture.size, (columns * 8, rows * 16));
    assert!(u32::from(left) + columns <= 81 && u32::from(top) + rows <= 25);
    let lit = picture.pixels.iter().filter(|pixel| **pixel > 0).count() as u32;
    // The walls of a house are many lines, and most of the floor is free.
    assert!(
        (columns * 8..columns * rows * 64).contains(&lit),
        "{lit} pixels"
    );
}

/// Terminals that draw octants themselves get them, others braille characters.
#[test]
fn the_map_has_octants_on_terminals_that_draw_them() {
    for (program, version, octants) in [
        ("ghostty", "1.1.0", true),
        ("WezTerm", "20250608-074531-abcdef", true),
        ("WezTerm", "20240203-110809-5046fc22", false),
    ] {
        let program = format!("TERM_PROGRAM={program}");
        let version = format!("TERM_PROGRAM_VERSION={version}");
        let arguments = [&*program, &*version, GROUNDWAVE, "demo"];
        let mut demo = OnTerminal::start("env", &arguments, 80, 24);
        demo.wait_for("the robot", |text| {
            text.contains("walls: simulator's truth")
        });
        let text = demo.text();
        let has = |first, last| text.contains(|c: char| (first..=last).contains(&c));
        assert_eq!(has('\u{1CD00}', '\u{1CDE5}'), octants, "{program}: {text}");
        assert_eq!(has('\u{2801}', '\u{28FF}'), !octants, "{program}: {text}");
        leave(demo);
    }
}

/// The tour of the demo explains one key at a time. After the operator has ended the tour, it is not shown again.
#[test]
fn the_demo_gives_its_tour_until_it_is_ended() {
    let state = scratch("tour");
    let home = format!("XDG_STATE_HOME={}", state.display());
    let demo = || {
        let mut demo = OnTerminal::start("env", &[&home, GROUNDWAVE, "demo"], 80, 24);
        demo.wait_for("the robot", |text| text.contains("PROWL"));
        demo
    };
    let mut first = demo();
    assert!(
        first
            .text()
            .contains("tour 1/8  Press Space: the robot stops")
    );
    first.type_keys(" ");
    first.wait_for("the second step and the news", |text| {
        text.contains("tour 2/8  Press m h: it drives home") && text.contains("stop: ")
    });
    first.type_keys(":");
    first.wait_for("the prompt", |text| text.contains("Esc cancel"));
    first.type_keys(ESC);
    first.wait_for("the tour", |text| text.contains("Esc: no tour"));
    first.type_keys("mh");
    first.wait_for("the third step", |text| text.contains("tour 3/8"));
    first.type_keys("q");
    assert_eq!(first.wait(), 0);
    for words in [
        "nothing was recorded",
        "the simulated robot ended with the program",
    ] {
        assert!(first.text().contains(words), "{}", first.text());
    }
    // Leaving is not ending.
    let mut second = demo();
    assert!(second.text().contains("tour 1/8"));
    second.type_keys(ESC);
    second.wait_for("that it is gone", |text| !text.contains("tour"));
    leave(second);
    let third = demo();
    assert!(!third.text().contains("tour"), "{}", third.text());
    leave(third);
}

/// A state folder that cannot be written keeps the tour and is not an error.
#[test]
fn the_tour_needs_no_state_folder() {
    let state = scratch("tour-unwritable");
    fs::write(state.join("groundwave"), "a file").unwrap();
    let home = format!("XDG_STATE_HOME={}", state.display());
    for _ in 0..2 {
        let mut demo = OnTerminal::start("env", &[&home, GROUNDWAVE, "demo"], 80, 24);
        demo.wait_for("the tour", |text| text.contains("tour 1/8"));
        demo.type_keys(ESC);
        demo.wait_for("that it is gone", |text| !text.contains("tour"));
        leave(demo);
    }
}

#[test]
fn a_theme_is_chosen_by_option_and_key() {
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &["--theme", "mono"], 80, 24);
    let has_colour = |screen: &vt100::Screen| {
        (0..24).any(|row| {
            (0..80).any(|column| {
                let cell = screen.cell(row, column).expect("a cell");
                cell.fgcolor() != vt100::Color::Default
            })
        })
    };
    watch.wait_for_terminal("no colours", |screen| !has_colour(screen));
    watch.type_keys("\x14");
    watch.wait_for_terminal("colours", |screen| {
        has_colour(screen) && screen.contents().contains("theme dark")
    });
    leave(watch);
}

/// `/` finds a line of the log; `c` copies it to the terminal's clipboard.
#[test]
fn a_line_of_the_log_is_found_and_copied() {
    let sim = Sim::start(&[]);
    let mut watch = watch(&sim, &[], 80, 24);
    watch.type_keys("/LISTENING\r");
    watch.wait_for("the line", |text| {
        text.contains("── F6 log") && text.contains("`LISTENING`: 1 of 1")
    });
    watch.type_keys("c");
    watch.wait_for("the answer", |text| {
        text.contains("copied, if the terminal allows it: listening to")
    });
    let copied = watch.copied();
    assert!(copied.starts_with("listening to /dev/"), "{copied}");
    watch.type_keys(ESC);
    watch.wait_for("the end of the search", |text| !text.contains("N newer"));
    leave(watch);
}

const REDRAW: &str = "\x0c";

/// A stalled ssh with more frames than a terminal can buffer: shared links continue, STOP reaches the robot, the recording is
/// complete, and the terminal gets the newest state afterwards.
#[test]
fn a_stalled_terminal_delays_only_drawing() {
    let folder = scratch("stalled");
    let (capture, socket) = (folder.join("run.mcap"), folder.join("s"));
    let (capture, socket) = (capture.to_str().unwrap(), socket.to_str().unwrap());
    let sim = Sim::start(&[]);
    let more = ["--record", capture, "--share", socket];
    let mut watch = watch(&sim, &more, 80, 24);
    let mut other = Telling::start(&["watch", &format!("unix:{socket}"), "--headless"]);
    other.wait_for("a line", |told| told["event"] == "line");
    watch.stall();
    for _ in 0..40 {
        watch.type_keys(REDRAW);
        other.wait_for_new("the next line", |told| told["event"] == "line");
    }
    watch.type_keys(" ");
    other.wait_for_new("STOP", |told| told["mode"] == "stop");
    let before = watch.raw.len();
    watch.go_on();
    watch.wait_for("what is so by now", |text| {
        text.contains("NO LAYER holds the motors: stopped")
    });
    // The current frame and the newest one, without the forty between.
    assert!(
        watch.raw.len() - before < 40_000,
        "{}",
        watch.raw.len() - before
    );
    leave(watch);
    let (recorded, _) = expect(0, &["export", "-o", "-", capture, "--to", "jsonl"]);
    let recorded: Vec<Value> = recorded
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let sequences = |told: &[Value]| -> Vec<u64> {
        let sequences = told.iter().filter(|it| it["line_type"] != "K");
        sequences.filter_map(|it| it["sequence"].as_u64()).collect()
    };
    let (heard, kept) = (sequences(&other.said), sequences(&recorded));
    assert!(heard.len() > 40);
    assert!(
        kept.windows(heard.len()).any(|part| part == heard),
        "{heard:?} of {kept:?}"
    );
}

#[test]
fn a_signal_ends_a_dashboard_on_a_stalled_terminal() {
    let folder = scratch("ended-stalled");
    let capture = folder.join("run.mcap");
    let capture = capture.to_str().unwrap();
    let sim = Sim::start(&["--time-factor", "5"]);
    let mut watch = watch(&sim, &["--record", capture], 80, 24);
    watch.stall();
    for _ in 0..40 {
        watch.type_keys(REDRAW);
        // After some lines there is another frame.
        let size = || fs::metadata(capture).map_or(0, |it| it.len());
        let before = size();
        while size() < before + 500 {
            std::thread::yield_now();
        }
    }
    signal(&watch, "-TERM");
    assert_eq!(watch.wait_stalled(), 0);
    let (info, _) = expect(0, &["info", capture]);
    assert!(info.contains("lines"), "{info}");
}

#[test]
fn a_route_is_not_replayed_as_a_capture() {
    let folder = scratch("not-a-capture");
    let route = folder.join("tour.txt");
    fs::write(&route, "# round the table\n48,0\n48,48\n").unwrap();
    let mut replay = OnTerminal::start(GROUNDWAVE, &["replay", route.to_str().unwrap()], 200, 24);
    assert_eq!(replay.wait(), 2);
    let told = replay.text();
    assert!(told.contains("is a route, not a capture"), "{told}");
    assert!(told.contains("groundwave send LINK route"), "{told}");
}
