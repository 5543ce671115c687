//! `runs`, `label` and `compare`.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, SystemTime};

use groundwave::capture::convert::convert_raw;
use groundwave::capture::{Existing, Recorder, Session};
use groundwave_protocol::telemetry::{Ack, Body, Line, Note, SongLine};
use serde_json::Value;

#[cfg(unix)]
use crate::pty::OnTerminal;

fn groundwave(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_groundwave"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn told(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// A folder with two captures and a file that is not a capture.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let captures = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    fs::copy(
        captures.join("demo-commands.mcap"),
        folder.path().join("b.mcap"),
    )
    .unwrap();
    fs::copy(
        captures.join("house-clean.txt"),
        folder.path().join("a.txt"),
    )
    .unwrap();
    fs::write(folder.path().join("shopping.txt"), "milk\n").unwrap();
    folder
}

#[test]
fn runs_lists_all_captures_and_nothing_else() {
    let folder = folder();
    let list = told(&groundwave(folder.path(), &["runs"]));
    let captures: Vec<&str> = list
        .lines()
        .skip(1)
        .map(|row| row.split_whitespace().last().unwrap())
        .collect();
    assert_eq!(captures, ["a.txt", "b.mcap"], "{list}");
}

#[test]
fn runs_have_a_date_and_are_found_by_it() {
    let folder = folder();
    let raw = fs::read(folder.path().join("a.txt")).unwrap();
    // 2025-03-14T09:26:53Z and 2026-11-20T14:30:40Z, in the wrong order of names.
    for (name, start_s) in [("z.mcap", 1_741_944_413_u64), ("y.mcap", 1_795_185_040)] {
        let file = fs::File::create(folder.path().join(name)).unwrap();
        convert_raw(&raw[..], Some(start_s * 1_000_000_000), file).unwrap();
    }
    fs::remove_file(folder.path().join("b.mcap")).unwrap();
    let listed = |words: &[&str]| -> Vec<String> {
        let list = told(&groundwave(folder.path(), &[&["runs"], words].concat()));
        let rows = list.lines().filter(|row| row.contains('%'));
        let names = rows.filter_map(|row| row.rsplit("  ").next());
        names.map(str::to_owned).collect()
    };
    assert_eq!(listed(&[]), ["a.txt", "z.mcap", "y.mcap"]);
    for (words, expected) in [
        (&["--since", "2026-11-20"][..], &["y.mcap"][..]),
        (&["--since", "2026-11-21"], &[]),
        (&["--until", "2025-03-14"], &["z.mcap"]),
        (&["--until", "2025-03-14 09:26"], &["z.mcap"]),
        (&["--until", "2025-03-14 09:25"], &[]),
        (
            &["--since", "2025-03-14 09:26:53", "--until", "2026-11-20"],
            &["z.mcap", "y.mcap"],
        ),
        (&["--since", "yesterday"], &[]),
    ] {
        assert_eq!(listed(words), expected, "{words:?}");
    }
    let output = groundwave(folder.path(), &["runs", "--since", "2026-11-20"]);
    let [out, err] = [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap());
    assert!(out.contains("2026-11-20 14:30 "), "{out}");
    assert!(err.contains("left out 1 capture without a date"), "{err}");
    let json = told(&groundwave(folder.path(), &["runs", "y.mcap", "--json"]));
    let run: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(run["start"], "2026-11-20T14:30:40Z");
    let wrong = groundwave(folder.path(), &["runs", "--since", "20.11."]);
    assert_eq!(wrong.status.code(), Some(2));
    let told = String::from_utf8_lossy(&wrong.stderr).into_owned();
    assert!(told.contains("try 2026-11-20, yesterday"), "{told}");
}

#[cfg(unix)]
#[test]
fn enter_on_a_run_replays_it_in_the_same_program() {
    let folder = folder();
    let path = folder.path().join("a.txt");
    let arguments = ["replay", path.to_str().unwrap()];
    let mut replay = OnTerminal::start(env!("CARGO_BIN_EXE_groundwave"), &arguments, 160, 40);
    replay.wait_for("the first capture", |screen| screen.contains("a.txt"));
    replay.type_keys(":runs\r");
    replay.wait_for("the runs", |screen| screen.contains("runs in"));
    // The replayed run is selected; the other one is below it.
    replay.type_keys("j\r");
    replay.wait_for("the other capture", |screen| {
        screen.contains("b.mcap") && !screen.contains("runs in")
    });
    // The first key reaches the new dashboard.
    replay.type_keys("q");
    assert_eq!(replay.wait(), 0);
}

#[test]
fn label_is_kept_beside_the_capture_and_listed() {
    let folder = folder();
    let capture = folder.path().join("b.mcap");
    let before = fs::read(&capture).unwrap();
    for words in [
        &["--name", "new wheels"][..],
        &["--note", "the glass door", "--at", "0:30"],
        &["--void", "the cat"],
    ] {
        told(&groundwave(
            folder.path(),
            &[&["label", "b.mcap"], words].concat(),
        ));
    }
    let said = told(&groundwave(folder.path(), &["label", "b.mcap"]));
    for fact in ["new wheels", "VOID   the cat", "at 30.0 s: the glass door"] {
        assert!(said.contains(fact), "{fact} is not in\n{said}");
    }
    let list = told(&groundwave(folder.path(), &["runs"]));
    assert!(
        list.contains("0  b.mcap  new wheels  (1 mark)  (void: the cat)"),
        "{list}"
    );
    let info = told(&groundwave(folder.path(), &["info", "b.mcap"]));
    assert!(info.contains("mark       00:30  the glass door"), "{info}");
    told(&groundwave(folder.path(), &["label", "b.mcap", "--counts"]));
    let list = told(&groundwave(folder.path(), &["runs"]));
    assert!(
        !list.contains("VOID") && list.contains("new wheels"),
        "{list}"
    );
    assert_eq!(
        fs::read(&capture).unwrap(),
        before,
        "the capture was touched"
    );
}

/// The note of a mark goes with it, in the session that wrote both too.
#[cfg(unix)]
#[test]
fn a_mark_removed_while_recording_leaves_no_note() {
    let folder = folder();
    let path = folder.path().join("live.mcap");
    let arguments = ["demo", "--record", path.to_str().unwrap()];
    let mut demo = OnTerminal::start(env!("CARGO_BIN_EXE_groundwave"), &arguments, 120, 40);
    demo.wait_for("lines", |screen| screen.contains("newest <1 s"));
    demo.type_keys("asofa\r");
    demo.wait_for("the note", |screen| screen.contains("note: sofa"));
    demo.type_keys("Nm");
    demo.wait_for("the mark and its text", |screen| {
        screen.contains("PAST") && screen.contains("mark: sofa")
    });
    demo.type_keys("a\rG");
    demo.wait_for("that it is removed", |screen| {
        screen.contains("note removed: sofa")
    });
    demo.type_keys("q");
    assert_eq!(demo.wait(), 0);
    let output = groundwave(folder.path(), &["info", "live.mcap"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("lines") && !said.contains("sofa"), "{said}");
}

#[cfg(unix)]
#[test]
fn marks_of_a_label_are_in_the_picture_and_in_the_replay() {
    let folder = folder();
    for words in [
        &["--name", "new wheels"][..],
        &["--note", "the glass door", "--at", "0:30"],
    ] {
        let label = [&["label", "b.mcap"], words].concat();
        told(&groundwave(folder.path(), &label));
    }
    let export = ["export", "b.mcap", "--to", "svg", "-o", "b.svg"];
    told(&groundwave(folder.path(), &export));
    let picture = fs::read_to_string(folder.path().join("b.svg")).unwrap();
    for words in ["new wheels", "the glass door"] {
        let words = format!("aria-label=\"{words}\"");
        assert!(picture.contains(&words), "{words} is not in\n{picture}");
    }
    let path = folder.path().join("b.mcap");
    let arguments = ["replay", path.to_str().unwrap()];
    let mut replay = OnTerminal::start(env!("CARGO_BIN_EXE_groundwave"), &arguments, 120, 40);
    replay.wait_for("the capture", |screen| screen.contains("REPLAY"));
    replay.type_keys("nm");
    replay.wait_for("the mark", |screen| screen.contains("mark: the glass door"));
    replay.type_keys("a\r");
    replay.wait_for("that it is removed", |screen| {
        screen.contains("note removed: the glass door")
    });
    let label = folder.path().join("b.mcap.run.toml");
    assert!(
        !fs::read_to_string(&label)
            .unwrap()
            .contains("the glass door")
    );
    replay.type_keys("q");
    assert_eq!(replay.wait(), 0);
    // A broken label leaves out the marks alone.
    fs::write(&label, "nam = 1\n").unwrap();
    let export = ["export", "b.mcap", "--to", "png", "-o", "b.png"];
    let output = groundwave(folder.path(), &export);
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("b.mcap.run.toml is not a valid label"),
        "{said}"
    );
}

#[test]
fn label_needs_a_capture_and_a_broken_label_is_not_replaced() {
    let folder = folder();
    for empty in ["", " "] {
        let note = groundwave(folder.path(), &["label", "b.mcap", "--note", empty]);
        assert_eq!(note.status.code(), Some(2));
        let told = String::from_utf8_lossy(&note.stderr);
        assert!(told.contains("give a text"), "{told}");
    }
    assert!(!folder.path().join("b.mcap.run.toml").exists());
    let missing = groundwave(folder.path(), &["label", "none.mcap", "--name", "x"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(!folder.path().join("none.mcap.run.toml").exists());
    let label = folder.path().join("b.mcap.run.toml");
    fs::write(&label, "nam = 1\n").unwrap();
    let broken = groundwave(folder.path(), &["label", "b.mcap", "--name", "x"]);
    assert_eq!(broken.status.code(), Some(2));
    let told = String::from_utf8(broken.stderr).unwrap();
    assert!(
        told.contains("b.mcap.run.toml") && told.contains("nam"),
        "{told}"
    );
    assert_eq!(fs::read_to_string(&label).unwrap(), "nam = 1\n");
}

#[test]
fn compare_draws_two_runs() {
    let folder = folder();
    told(&groundwave(
        folder.path(),
        &["label", "a.txt", "--name", "before"],
    ));
    let compare = ["compare", "a.txt", "b.mcap", "--svg", "both.svg"];
    let text = told(&groundwave(folder.path(), &compare));
    for fact in ["before", "closing error", "apart", "#"] {
        assert!(text.contains(fact), "{fact} is not in\n{text}");
    }
    let svg = fs::read_to_string(folder.path().join("both.svg")).unwrap();
    for fact in [
        "before and b",
        "1  before",
        "2  b",
        "start (",
        "end (",
        "closing error ",
        "x, feet",
    ] {
        assert!(svg.contains(&format!("aria-label=\"{fact}")), "{fact}");
    }
    let again = groundwave(folder.path(), &compare);
    assert_eq!(again.status.code(), Some(2), "a drawing was overwritten");

    let own = told(&groundwave(
        folder.path(),
        &["compare", "a.txt", "a.txt", "--json"],
    ));
    let own: Value = serde_json::from_str(&own).unwrap();
    assert_eq!(own["apart"]["worst_in"], 0.0);
    assert_eq!(own["runs"][0]["distance_in"], own["runs"][1]["distance_in"]);
    assert_eq!(own["runs"][0]["name"], "before");
}

/// A capture with a damaged chunk in the middle.
fn spoilt() -> Vec<u8> {
    let captures = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    let raw = fs::read(captures.join("house-clean.txt")).unwrap();
    let song = Line {
        sequence: 0,
        body: Body::Song(SongLine::new([Note { hz: 440, ticks: 4 }])),
        ack: Ack::default(),
    };
    let stream = [&song.encode()[..], &raw.repeat(40), &song.encode()].concat();
    let mut mcap = Vec::new();
    convert_raw(&stream[..], Some(1_741_944_413_000_000_000), &mut mcap).unwrap();
    let summary = mcap::Summary::read(&mcap).unwrap().unwrap();
    let chunks = &summary.chunk_indexes;
    assert!(chunks.len() >= 3, "{}", chunks.len());
    let chunk = &chunks[chunks.len() / 2];
    mcap[(chunk.chunk_start_offset + chunk.chunk_length / 2) as usize] ^= 0x10;
    mcap
}

#[test]
fn damaged_capture_is_listed_with_its_fault() {
    let folder = folder();
    fs::write(folder.path().join("c.mcap"), spoilt()).unwrap();
    let check = |arguments: &[&str], facts: &[&str]| {
        let output = groundwave(folder.path(), arguments);
        let [out, err] =
            [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap());
        assert_eq!(output.status.code(), Some(1), "{arguments:?}\n{out}\n{err}");
        for fact in facts {
            assert!(out.contains(fact), "{fact} is not in\n{out}");
        }
        assert!(err.contains("c.mcap cannot be read completely"), "{err}");
    };
    check(&["runs"], &["a.txt", "b.mcap", "c.mcap"]);
    check(&["compare", "a.txt", "c.mcap"], &["closing error", "apart"]);
    check(&["songs", "c.mcap"], &["01  at", "02  at"]);
}

#[test]
fn picture_of_a_capture_without_readable_parts_is_an_error() {
    let folder = folder();
    let mut mcap = spoilt();
    let summary = mcap::Summary::read(&mcap).unwrap().unwrap();
    for chunk in &summary.chunk_indexes {
        let middle = chunk.chunk_start_offset + chunk.chunk_length / 2;
        mcap[middle as usize + 1] ^= 0x10;
    }
    fs::write(folder.path().join("c.mcap"), mcap).unwrap();
    for form in ["csv", "svg", "png"] {
        let output = groundwave(folder.path(), &["export", "c.mcap", "--to", form]);
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{form}: {err}");
    }
}

#[test]
fn program_without_a_command_suggests_the_newest_capture() {
    let folder = tempfile::tempdir().unwrap();
    let offered = || {
        let output = groundwave(folder.path(), &[]);
        String::from_utf8(output.stdout).unwrap()
    };
    let raw = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");
    fs::copy(raw, folder.path().join("evening.txt")).unwrap();
    // A file of another program.
    fs::write(folder.path().join("film.mcap.finishing"), "half").unwrap();
    let said = offered();
    assert!(said.contains("groundwave replay evening.txt"), "{said}");
    assert!(!said.contains("recover"), "{said}");
    let late = folder.path().join("late.mcap");
    let session = Session {
        link: "radio".to_owned(),
        start: SystemTime::UNIX_EPOCH,
        notes: [].into(),
        configuration: String::new(),
    };
    let mut killed = Recorder::start(&late, Existing::Refuse, &session).unwrap();
    killed.handle_rx(Duration::ZERO, session.start, b"noise\n");
    killed.abandon();
    let said = offered();
    assert!(said.contains("groundwave recover late.mcap "), "{said}");
    // A capture that is being written.
    let writing = fs::File::open(&late).unwrap();
    writing.lock().unwrap();
    let said = offered();
    assert!(!said.contains("recover"), "{said}");
}
