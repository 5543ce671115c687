//! Facts that must show on a small screen.

use super::*;
use crate::request::dashboard_commands;

#[test]
fn a_cut_text_ends_with_a_mark() {
    let mut scene = flight(demo());
    scene.state.bump = Bump::None;
    scene.hear();
    scene.wait_ms(930_000);
    let narrow = screen(&scene, 80, 24);
    let bumper = row(&narrow, "bumper ");
    assert!(bumper.contains("… ◌ 15 m"), "{bumper}");
    scene.event(Event::RouteLoaded {
        path: "r.txt".to_owned(),
        route: Err("a reason of so many words ".repeat(5)),
    });
    assert!(row(&screen(&scene, 80, 24), "! a reason").ends_with('…'));
}

#[test]
fn the_summary_is_never_cut() {
    let long = format!("/tmp/{}.txt", "a-very-long-name-".repeat(12));
    for (tee, named) in [
        (None, "R: record"),
        (
            Some("groundwave-20250314T092653Z.mcap".to_owned()),
            "092653Z.mcap",
        ),
        (Some(long), "name-.txt"),
    ] {
        let mut scene = flight(Config {
            raw_copy: Some("cat /dev/pts/123".to_owned()),
            ..Config::default()
        });
        scene.event(Event::Recording(Recording {
            tee,
            ..Recording::default()
        }));
        for (width, height) in [(80, 24), (90, 30), (100, 30), (120, 40), (200, 60)] {
            let screen = screen(&scene, width, height);
            let line = row(&screen, "cat /dev/pts/123");
            assert!(
                line.contains(named) && line.contains("cat /dev/pts/123"),
                "{line}"
            );
            let status = row(&screen, "● sim");
            let told = ["◉ REC", "no rec"];
            assert!(told.iter().any(|words| status.ends_with(words)), "{status}");
        }
    }
}

#[test]
fn the_result_of_a_command_shows_on_the_smallest_screen() {
    let mut scene = flight(demo());
    let hint = |scene: &Scene| {
        let screen = screen(scene, 80, 24);
        screen.lines().rev().nth(1).unwrap().to_owned()
    };
    scene.type_text("S");
    assert_eq!(hint(&scene), "! no draft yet: move the cursor, press w");
    scene.wait_ms(4000);
    scene.hear();
    assert!(hint(&scene).contains("no draft yet"));
    let until = scene.redraw_at().unwrap();
    assert!(until <= scene.now + std::time::Duration::from_secs(1));
    scene.wait_ms(1000);
    assert!(hint(&scene).contains("recorded") || hint(&scene).contains("mcap"));

    scene.ask(1, Request::Scan);
    scene.status_of(1, CommandStatus::Sent { frames: 1 });
    assert_eq!(hint(&scene), "… scan: sent 1 frame");
    scene.wait_ms(700);
    scene.status_of(1, CommandStatus::Refused(Outcome::NotFitted));
    assert_eq!(hint(&scene), "✖ scan: REFUSED: not fitted");
    scene.event(Event::RouteLoaded {
        path: "r.txt".to_owned(),
        route: Err("cannot read r.txt: no such file".to_owned()),
    });
    assert_eq!(hint(&scene), "! cannot read r.txt: no such file");
    scene.type_text("5");
    assert!(hint(&scene).ends_with("is not fitted on this robot"));
}

#[test]
fn a_receive_only_link_offers_no_commands() {
    let mut scene = flight(demo());
    scene.event(Event::Link(LinkEvent::Opened {
        name: "radio".to_owned(),
        can_send: false,
    }));
    for keys in ["", ":", "r"] {
        scene.type_text(keys);
        let screen = screen(&scene, 80, 24);
        let footer = screen.lines().last().unwrap();
        for word in ["STOP", "modes", "drive", "layers", " send", "home"] {
            assert!(!footer.contains(word), "{footer}");
        }
        scene.press(&[KeyCode::Esc]);
    }
    scene.type_text("?");
    let help = screen(&scene, 80, 24);
    for word in ["STOP", "modes", "driving", "drive by hand", "origin"] {
        assert!(!help.contains(word), "{word} in\n{help}");
    }
    row(&help, "type a command");
    row(&help, "typing");
    scene.press(&[KeyCode::Esc]);
    scene.ctrl('p');
    for (typed, is_offered) in [
        ("drive by hand", false),
        ("failsafe", false),
        ("runs", true),
    ] {
        scene.type_text(typed);
        let found = screen(&scene, 80, 24);
        let is_best = !found.contains("No match") && !found.contains("no match");
        assert_eq!(is_best, is_offered, "{typed} in\n{found}");
        scene.ctrl('u');
    }
    scene.press(&[KeyCode::Esc]);
    scene.command(
        1,
        Request::Stop,
        CommandStatus::Failed(Failure::ReceiveOnly),
    );
    row(&screen(&scene, 80, 24), "✖ stop: the link is receive-only");
}

#[test]
fn a_prompt_names_the_keys_to_stop_and_to_leave() {
    let mut scene = flight(demo());
    for keys in [
        ":mode prowl",
        "r/home/user/routes/a-route-with-a-long-name-to-the-lamp.txt",
    ] {
        scene.type_text(keys);
        for (width, height) in [(80, 24), (120, 40)] {
            let screen = screen(&scene, width, height);
            let footer = screen.lines().last().unwrap();
            assert!(
                footer.contains("Ctrl-S STOP  Enter do it  Esc cancel"),
                "{footer}"
            );
            assert!(
                footer.contains("prowl▏") || footer.contains("lamp.txt▏"),
                "{footer}"
            );
        }
        scene.press(&[KeyCode::Esc]);
    }
}

#[test]
fn the_footer_names_the_keys_of_the_chosen_panel() {
    let footer = |scene: &Scene| screen(scene, 80, 24).lines().last().unwrap().to_owned();
    let mut scene = flight(demo());
    for (key, named) in [
        (4, "Space STOP  T longer  m modes"),
        (5, "Space STOP  : command  m modes"),
        (8, "Space STOP  A ack  E ack one  Z shelve  b bell  m modes"),
    ] {
        scene.press(&[KeyCode::F(key)]);
        assert!(footer(&scene).starts_with(named), "{}", footer(&scene));
        let tabs = "F2 sensors  F3 above  F4 plots  F5 commands  F6 log  F7 link  F8 alarms";
        row(&screen(&scene, 80, 24), tabs);
        assert!(footer(&scene).contains("e edit"), "{}", footer(&scene));
    }
    scene.press(&[KeyCode::F(6)]);
    assert!(!footer(&scene).contains("give up"), "nothing is under way");
    scene.ask(1, Request::Scan);
    assert!(footer(&scene).starts_with("Space STOP  x give up  "));
    // Sending comes before undoing.
    scene.press(&[KeyCode::F(5), KeyCode::Left]);
    scene.type_text("w");
    assert!(footer(&scene).contains("S send"), "{}", footer(&scene));
    scene.press(&[KeyCode::Backspace, KeyCode::Esc, KeyCode::F(6)]);
    scene.status_of(1, CommandStatus::Confirmed { digest: None });
    scene.press(&[KeyCode::Left]);
    for named in ["arrows move", "w add", "u undo", "S send", "e edit"] {
        assert!(footer(&scene).contains(named), "{}", footer(&scene));
    }
}

#[test]
fn only_a_list_of_runs_offers_a_choice() {
    let mut scene = flight(demo());
    scene.type_text(":runs");
    scene.press(&[KeyCode::Enter]);
    let chooses = |scene: &Scene| screen(scene, 80, 24).contains("arrows choose  Enter replay");
    assert!(!chooses(&scene), "it is being read");
    scene.event(Event::Runs(Ok(listed())));
    assert!(chooses(&scene));
    scene.press(&[KeyCode::Char('c'), KeyCode::Up, KeyCode::Char('c')]);
    scene.event(Event::Overlaid(Ok(overlaid())));
    assert!(!chooses(&scene));
}

/// Both squares have all four sides.
#[test]
fn compared_paths_are_whole() {
    let mut scene = flight(demo());
    scene.type_text(":runs");
    scene.press(&[KeyCode::Enter]);
    scene.event(Event::Runs(Ok(listed())));
    scene.press(&[KeyCode::Char('c'), KeyCode::Up, KeyCode::Char('c')]);
    scene.event(Event::Overlaid(Ok(overlaid())));
    let screen = screen(&scene, 80, 24);
    let rows: Vec<&str> = screen.lines().collect();
    let end = rows.iter().position(|row| row.starts_with('╰')).unwrap();
    let is_dotted = |c: &char| ('\u{2801}'..='\u{28ff}').contains(c);
    let base = rows[end - 1].chars().filter(is_dotted).count();
    assert!(base >= 10, "{screen}");
}

/// A wide character takes two columns.
#[test]
fn a_wide_name_is_cut_with_a_mark() {
    let mut scene = flight(demo());
    scene.type_text(":runs");
    scene.press(&[KeyCode::Enter]);
    let mut list = (*listed()).clone();
    list.runs[0].capture = "漢字".repeat(60);
    scene.event(Event::Runs(Ok(list.into())));
    let shown = screen(&scene, 100, 30);
    let run = row(&shown, "漢");
    assert!(run.contains('…'), "{run}");
    scene.press(&[KeyCode::Esc]);
    scene.type_text(":runs");
    scene.press(&[KeyCode::Enter]);
    let error = format!("{}end", "漢字".repeat(30));
    scene.event(Event::Runs(Err(error)));
    row(&screen(&scene, 80, 24), "end");
}

#[test]
fn an_impossible_command_is_refused_with_a_remedy() {
    let mut scene = flight(demo());
    let dock = Request::Mode(Mode::Forage);
    scene.command(1, dock, CommandStatus::Refused(Outcome::NotFitted));
    let words = "REFUSED: it has no dock sensor: try `home`, or demo --world flat";
    for (width, height) in [(80, 24), (120, 40)] {
        row(&screen(&scene, width, height), words);
    }
}

#[test]
fn hand_driving_names_its_keys_and_its_end() {
    let mut scene = flight(demo());
    scene.type_text("dy");
    scene.state.mode = Mode::User;
    scene.hear();
    assert_eq!(scene.type_text("p"), [], "the keys drive");
    row(
        &screen(&scene, 80, 24),
        "hand drive: arrows drive, Space stops, Esc lets go; other keys do nothing",
    );
    scene.press(&[KeyCode::Esc]);
    row(
        &screen(&scene, 80, 24),
        "it stands in mode user: m p prowls, m h goes home, d drives on",
    );
    scene.press(&[KeyCode::F(6)]);
    row(&screen(&scene, 80, 24), "it stands in mode user");
}

/// An alarm and the PAST banner take one row each.
#[test]
fn the_links_figures_stay_during_an_alarm() {
    let mut scene = time::flight_at(demo(), |scene| time::playback(scene, true));
    scene.event(Event::Link(LinkEvent::Lost {
        reason: "gone".to_owned(),
    }));
    let screen = screen(&scene, 120, 40);
    row(&screen, "PAST");
    row(&screen, "LINK LOST <1 s: gone");
    row(&screen, "── F7 link");
    row(&screen, "── F6 log");
}

#[test]
fn a_stale_share_is_marked() {
    let mut scene = flight(demo());
    let share = |scene: &Scene| row(&screen(scene, 120, 40), "4 △ sonar").to_owned();
    assert!(share(&scene).ends_with("  12 %"));
    for _ in 0..60 {
        scene.hear();
    }
    assert!(share(&scene).ends_with("◌ 12 %"), "{}", share(&scene));
    scene.hear_ticks(90, [0, 20, 0, 160, 120, 0, 0, 0, 850]);
    assert!(!share(&scene).contains('◌'), "{}", share(&scene));
    scene.wait_ms(20_000);
    let robot = row(&screen(&scene, 120, 40), "robot    id 7, up").to_owned();
    assert!(robot.contains("◌ 20 s"), "{robot}");
}

#[test]
fn every_row_of_the_sensors_is_reachable() {
    let mut scene = flight(Config::default());
    let first = screen(&scene, 80, 24);
    row(&first, "── F2 sensors ────────────── PgDn 1/2 ──");
    scene.press(&[KeyCode::PageDown]);
    let second = screen(&scene, 80, 24);
    insta::assert_snapshot!("sensors_second_page", second);
    row(&second, "drive    ok   no edge sensors");
    row(&second, "arm      not fitted");
    row(&second, "robot    id 7, up 1 m 00 s, bumps 2");
    scene.press(&[KeyCode::PageDown]);
    assert_eq!(screen(&scene, 80, 24), first, "round and round");
    scene.press(&[KeyCode::PageUp]);
    assert_eq!(screen(&scene, 80, 24), second);
    scene.press(&[KeyCode::F(2)]);
    let large = screen(&scene, 80, 24);
    row(&large, "wheels   L  -5 of  -6  R  -6 of  -6 in/s");
    row(&large, "robot    id 7, up 1 m 00 s");
    scene.press(&[KeyCode::Esc]);
    let panels = |screen: &str| {
        screen
            .lines()
            .take(22)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(panels(&screen(&scene, 80, 24)), panels(&first));
}

#[test]
fn the_log_wraps_and_shows_counts_first() {
    let mut scene = flight(Config::default());
    for _ in 0..3 {
        scene.hear_text("scan: longest view 172, brightest light 270, clearest 352 deg");
    }
    scene.press(&[KeyCode::F(6)]);
    let narrow = screen(&scene, 80, 24);
    row(&narrow, "\" ×3 scan: longest view 172,");
    row(&narrow, "352 deg");
    let wide = screen(&scene, 120, 40);
    row(&wide, "×3 scan: longest view 172, brightest light 270,");
    row(&wide, "        clearest 352 deg");
}

#[test]
fn every_key_is_in_the_help_however_small_the_screen() {
    let mut told = String::new();
    for keys in ["?", "e?"] {
        let mut scene = flight(Config::default());
        scene.type_text(keys);
        for _ in 0..4 {
            told += &screen(&scene, 80, 24);
            scene.press(&[KeyCode::PageDown]);
        }
    }
    let keymap = Config::default().keys;
    for binding in keymap.rows() {
        let help = keymap.with_keys(&binding.help);
        let is_told = told.contains(&format!("{:<8}{help}", binding.label));
        assert!(
            binding.help.is_empty() || is_told,
            "{}: {}",
            binding.label,
            binding.help
        );
    }
}

#[test]
fn a_long_error_is_shown_whole() {
    let mut scene = flight(demo());
    scene.type_text(":xyzzy");
    scene.press(&[KeyCode::Enter]);
    let screen = screen(&scene, 80, 24);
    row(&screen, "unknown command `xyzzy`");
    row(&screen, "failsafe, param");
}

#[test]
fn the_end_of_a_replay_is_never_cut() {
    let mut scene = flight(demo());
    scene.event(Event::Link(LinkEvent::Opened {
        name: "replay of captures/house-clean.txt".to_owned(),
        can_send: false,
    }));
    scene.event(Event::Link(LinkEvent::Ended));
    for width in [80, 90, 100] {
        let screen = screen(&scene, width, 24);
        let ended = row(&screen, "session ended");
        assert!(!ended.contains('…'), "{ended}");
    }
}

#[test]
fn a_failed_recording_is_not_shown_as_recorded() {
    let mut scene = flight(demo());
    scene.event(Event::Recording(Recording {
        mcap: Some("f.mcap".to_owned()),
        problem: Some("the disk is full".to_owned()),
        ..Recording::default()
    }));
    scene.wait_ms(6_000);
    let screen = screen(&scene, 120, 40);
    row(&screen, "press R; until then");
    row(&screen, "groundwave recover f.mcap");
    assert!(!screen.contains("recorded in"), "{screen}");
}

#[test]
fn an_alarm_shows_its_latest_and_its_worst_figure() {
    let mut scene = flight(demo());
    scene.state.bump = Bump::None;
    for _ in 0..40 {
        scene.lose(3);
        scene.hear();
    }
    for _ in 0..30 {
        scene.lose(1);
        scene.hear();
    }
    let lossy = screen(&scene, 120, 40);
    let strip = row(&lossy, "LINES NOT INTACT");
    assert!(strip.contains(" %, at worst 7"), "{strip}");
    scene.drive(120, 0.0, 0);
    let over = screen(&scene, 120, 40);
    let strip = row(&over, "LINES NOT INTACT");
    assert!(strip.contains("LINES NOT INTACT at worst 7"), "{strip}");
}

/// After an outage that is over, the radio is good; a radio that damages lines is bad during its gaps too.
#[test]
fn an_outage_is_no_weak_radio() {
    for (damaged, is_weak) in [(0, false), (20, true)] {
        let mut scene = flight(demo());
        scene.state.bump = Bump::None;
        scene.drive(60, 0.0, 0);
        scene.lose(25);
        scene.counters.crc_rejected += damaged;
        scene.event(Event::Counters(scene.counters));
        scene.drive(33, 0.0, 0);
        let screen = screen(&scene, 120, 40);
        assert_eq!(screen.contains("LINES NOT INTACT"), is_weak, "{screen}");
    }
}

/// A long name of a file is whole where there is room.
#[test]
fn a_replays_file_comes_before_the_words_beside_it() {
    let name = "2026-11-26-evening-run-with-new-wheels-and-lamp.mcap";
    let mut scene = time::flight_at(demo(), |scene| time::playback(scene, false));
    scene.event(Event::Link(LinkEvent::Opened {
        name: format!("replay of runs/{name}"),
        can_send: false,
    }));
    let screen = screen(&scene, 120, 40);
    assert!(row(&screen, name).contains("loss"), "{screen}");
}

#[test]
fn a_copy_of_the_robots_route_is_not_shown_as_unsent() {
    let mut scene = flight(demo());
    commanded(&mut scene);
    scene.type_text("eyq");
    let copied = screen(&scene, 120, 40);
    row(&copied, "draft: 2 waypoints, same as the robot");
}

#[test]
fn a_space_precedes_the_mark_of_a_stale_share() {
    let mut scene = flight(Config {
        ascii: true,
        ..demo()
    });
    scene.wait_ms(30_000);
    for width in 80..130 {
        let screen = screen(&scene, width, 40);
        for row in screen.lines().filter(|row| row.ends_with(" %")) {
            let stuck = row
                .split('~')
                .next_back()
                .map(|tail| row.len() - tail.len() - 1);
            let before = stuck
                .and_then(|at| at.checked_sub(1))
                .map(|at| &row[at..=at]);
            assert!(
                before.is_none_or(|before| before == " " || before == "-"),
                "{row}"
            );
        }
    }
}

#[test]
fn protections_and_lights_have_fixed_places_that_nothing_covers() {
    let mut scene = flight(demo());
    scene.status.allowed = scene.status.allowed.without(Layer::Bumpers);
    scene.state.link = Link::Armed;
    scene.hear();
    scene.hear_status();
    let place = |row: &str, words: &str| {
        let at = row
            .find(words)
            .unwrap_or_else(|| panic!("no `{words}` in {row}"));
        row[..at].chars().count()
    };
    let mut places = Vec::new();
    for (width, height) in [(80, 24), (100, 30), (120, 40), (200, 60)] {
        for (keys, has_guard) in [
            ("", true),
            (":", true),
            ("?", false),
            ("y", true),
            ("0", true),
        ] {
            scene.hear_parameter("cliff-guard", i32::from(has_guard));
            scene.hear_parameter("battery-critical", 0);
            scene.type_text(keys);
            let shown = screen(&scene, width, height);
            let rows: Vec<&str> = shown.lines().collect();
            assert!(
                rows[0].ends_with("  failsafe  ◉ REC"),
                "{keys}: {}",
                rows[0]
            );
            places.push((
                place(rows[1], "✕ BUMPERS OFF"),
                place(rows[1], "✕ CRITICAL BATTERY OFF"),
            ));
            assert_eq!(rows[1].contains("✕ CLIFF GUARD OFF"), !has_guard);
            scene.press(&[KeyCode::Esc]);
        }
    }
    places.dedup();
    assert_eq!(places.len(), 1, "{places:?}");
    scene.status.allowed = scene.status.fitted;
    scene.hear_status();
    scene.hear_parameter("battery-critical", 112);
    scene.hear_parameter("cliff-guard", 1);
    assert!(!screen(&scene, 80, 24).contains(" OFF "));
}

#[test]
fn the_name_of_a_capture_has_the_room_there_is() {
    let mut scene = flight(demo());
    let name = "captures/a-long-drive-through-the-house.mcap";
    scene.event(Event::Link(LinkEvent::Opened {
        name: format!("replay of {name}"),
        can_send: false,
    }));
    row(&screen(&scene, 200, 60), &format!("● {name}  "));
}

/// A recording named by its time is told from others by the whole name.
#[test]
fn the_name_of_a_replayed_recording_is_whole_at_80_columns() {
    let name = "groundwave-20261124T101050Z.mcap";
    let mut scene = flight(demo());
    scene.event(Event::Link(LinkEvent::Opened {
        name: format!("replay of evenings/{name}"),
        can_send: false,
    }));
    scene.hear();
    scene.show_moment(Some(time::playback(&scene, false)));
    let screen = screen(&scene, 80, 24);
    let status = row(&screen, name);
    assert!(status.starts_with(&format!("● {name}  ")), "{status}");
    assert!(!status.contains(".."), "{status}");
}

/// What is too long for a row is left out or wrapped, not cut.
#[test]
fn sensors_and_commands_are_not_cut() {
    let mut scene = flight(demo());
    scene.state.bump = Bump::LeftCenter;
    scene.hear();
    scene.state.bump = Bump::None;
    scene.hear();
    scene.wait_ms(500);
    let layers = [Layer::Infrared, Layer::Sonar, Layer::Photo];
    let layers = layers.into_iter().fold(LayerMask::NONE, LayerMask::with);
    scene.ask(9, Request::Disable(layers));
    for (width, height) in [(80, 24), (100, 30), (120, 40)] {
        scene.hear();
        let screen = screen(&scene, width, height);
        let bumper = row(&screen, "bumper   free");
        assert!(bumper.contains("left and centre"), "{bumper}");
        assert!(!bumper.contains('…'), "{bumper}");
        if height > 24 {
            let robot = row(&screen, "robot    id");
            assert!(!robot.contains('…'), "{robot}");
        }
        if height == 40 {
            row(&screen, "9 disable infrared,sonar,photo");
        }
    }
}

#[test]
fn a_silent_robot_has_no_fresh_uptime() {
    let mut scene = flight(demo());
    scene.wait_ms(3000);
    let stale = screen(&scene, 120, 60);
    assert!(row(&stale, "robot    id 7").contains("◌ "), "{stale}");
}

#[test]
fn the_status_row_leaves_out_whole_figures() {
    let mut scene = flight(demo());
    scene.event(Event::Link(LinkEvent::Opened {
        name: "demo, house seed 1".to_owned(),
        can_send: true,
    }));
    scene.hear();
    let wide = screen(&scene, 120, 40);
    row(&wide, "newest <1 s");
    for width in 80..120 {
        let screen = screen(&scene, width, 24);
        let status = screen.lines().next().unwrap();
        assert!(status.contains("demo, house seed 1"), "{status}");
        let newest = status.split("newest").nth(1);
        assert!(
            newest.is_none_or(|age| age.starts_with(" <1 s")),
            "{status}"
        );
    }
}

#[test]
fn the_menu_of_modes_names_every_mode_on_the_smallest_screen() {
    let mut scene = flight(demo());
    scene.type_text("m");
    let screen = screen(&scene, 80, 24);
    let footer = screen.lines().last().unwrap();
    for mode in [
        "STOP", "prowl", "home", "wander", "reactive", "passive", "dock", "Esc back",
    ] {
        assert!(footer.contains(mode), "{mode}: {footer}");
    }
    row(&screen, "choose a mode");
}

/// A replay has nothing to record, and its palette says what a command does.
#[test]
fn a_replay_offers_no_recording() {
    let mut scene = time::flight_at(demo(), |scene| time::playback(scene, false));
    scene.press(&[KeyCode::F(7)]);
    let link = screen(&scene, 120, 40);
    assert!(!link.lines().last().unwrap().contains("R record"), "{link}");
    scene.type_text("?");
    let help = screen(&scene, 120, 40);
    assert!(!help.contains("stop recording"), "{help}");
    scene.press(&[KeyCode::Esc]);
    scene.ctrl('p');
    scene.type_text("replay");
    row(
        &screen(&scene, 80, 24),
        "▶ :runs: list runs; Enter replays one",
    );
}

/// Every alarm tells at 80 columns what to do, beside another alarm.
#[test]
fn an_alarm_tells_what_to_do_at_80_columns() {
    let mut scene = flight(demo());
    scene.state.power = groundwave_protocol::status_codes::Power::Critical;
    for _ in 0..4 {
        scene.hear();
        scene.hear_status();
    }
    assert!(scene.calling() > 1);
    let screen = screen(&scene, 80, 24);
    let strip = row(
        &screen,
        "BATTERY CRITICAL 12.4 V. Switch it off, or charge it",
    );
    assert!(strip.contains("+1 more"), "{strip}");
    assert!(!screen.contains('…'), "{screen}");
}

/// Recordings have long names that differ at their ends.
#[test]
fn runs_are_told_apart_at_80_columns() {
    let mut list = listed().as_ref().clone();
    let names = [
        "groundwave-20261124T101050Z.mcap",
        "groundwave-20261124T103940Z.mcap",
    ];
    for (run, name) in list.runs.iter_mut().zip(names) {
        run.capture = format!("runs/{name}");
    }
    let mut scene = flight(demo());
    scene.type_text(":runs");
    scene.press(&[KeyCode::Enter]);
    scene.event(Event::Runs(Ok(std::sync::Arc::new(list))));
    let screen = screen(&scene, 80, 24);
    for name in names {
        let run = row(&screen, &format!("200.0 in  {name} "));
        assert!(!run.contains('…'), "{run}");
    }
    let chosen = format!("│ {}  (void: the cat): closing error 12.0 in,", names[1]);
    row(&screen, &chosen);
    row(&screen, "│ bumps 2, loss 0.0 %");
}

/// The list of runs uses the width of the screen; a long remark leaves no columns out.
#[test]
fn the_list_of_runs_uses_its_width() {
    let mut list = listed().as_ref().clone();
    for (run, name) in list.runs.iter_mut().zip(["a", "b"]) {
        run.capture = format!("runs/groundwave-20261124T10394{name}Z.mcap");
    }
    list.runs[1].void = Some("the cat sat on the mark until noon".to_owned());
    let mut scene = flight(demo());
    scene.type_text(":runs");
    scene.press(&[KeyCode::Enter]);
    scene.event(Event::Runs(Ok(std::sync::Arc::new(list))));
    let screen = screen(&scene, 120, 40);
    row(&screen, "closing error  bumps   loss  damaged  capture");
    row(&screen, "groundwave-20261124T10394aZ.mcap  new");
    row(
        &screen,
        "(void: the cat sat on the mark until noon): closing error 12.0 in",
    );
}

#[test]
fn completions_are_whole_words() {
    let mut scene = flight(demo());
    scene.type_text(":");
    scene.press(&[KeyCode::Tab]);
    let screen = screen(&scene, 80, 24);
    let words = row(&screen, "stop  mode  ").trim_end();
    let words = words.strip_suffix("  …").expect("there are more");
    let known: Vec<&str> = Request::commands().chain(dashboard_commands()).collect();
    for word in words.split("  ") {
        assert!(known.contains(&word), "{word} in {words}");
    }
}
