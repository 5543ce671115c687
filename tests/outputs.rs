//! Output files never replace the input, and are either whole or absent.

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::programs::{GROUNDWAVE, expect, scratch};

const CLEAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");

#[test]
fn capture_is_not_overwritten_by_its_own_result() {
    let folder = scratch("own-input");
    let file = |name: &str| folder.join(name).display().to_string();
    fs::copy(CLEAN, folder.join("a.txt")).unwrap();
    fs::create_dir(folder.join("in")).unwrap();
    let roundabout = file("in/../a.txt");
    let source = file("a.txt");
    for target in [&source, &roundabout] {
        for verb in [
            &["export", "--to", "mcap"][..],
            &["cut", "--from", "1s"],
            &["export", "--to", "csv"],
        ] {
            let arguments = [verb, &[&source, "-o", target, "--force"]].concat();
            let (_, err) = expect(2, &arguments);
            assert!(err.contains("choose another name"), "{err}");
        }
    }
    assert!(fs::read(folder.join("a.txt")).unwrap() == fs::read(CLEAN).unwrap());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn configuration_is_not_overwritten_by_an_output() {
    let folder = scratch("own-configuration");
    let file = |name: &str| folder.join(name).display().to_string();
    let config = file("c.toml");
    let text = "[dashboard]\nbell = true\n";
    fs::write(&config, text).unwrap();
    fs::create_dir(folder.join("in")).unwrap();
    let roundabout = file("in/../c.toml");
    for target in [&config, &roundabout] {
        for verb in [
            &["export", "--to", "csv", "--force", CLEAN, "-o"][..],
            &["cut", "--from", "1s", "--force", CLEAN, "-o"],
            &["compare", CLEAN, CLEAN, "--force", "--svg"],
            &["world", "flat", "--force", "--svg"],
            &["record", "-", "--force", "-o"],
            &["record", "-", "--append", "-o"],
            &["sim", "--force", "--trace"],
            &["sim", "--force", "--wav"],
            &["sim", "--eeprom"],
            &["watch", "-", "--headless", "--force", "--tee"],
        ] {
            let (_, err) = expect(2, &[verb, &[target, "--config", &config]].concat());
            assert!(err.contains("choose another name"), "{verb:?}: {err}");
        }
    }
    assert_eq!(fs::read_to_string(&config).unwrap(), text);
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(unix)]
#[test]
fn configuration_in_a_named_pipe_gets_advice_that_holds_for_it() {
    let folder = scratch("piped-configuration");
    let pipe = folder.join("c.pipe").display().to_string();
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let (_, err) = expect(2, &["info", CLEAN, "--config", &pipe]);
    assert!(err.contains(&format!("cat {pipe} > FILE")), "{err}");
    assert!(!err.contains("- <"), "{err}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn raw_bytes_are_not_appended_to_a_recording() {
    let folder = scratch("append-to-mcap");
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/demo-commands.mcap");
    // Its name does not tell.
    let path = folder.join("a.txt").display().to_string();
    fs::copy(sample, &path).unwrap();
    for arguments in [
        &["watch", "-", "--headless", "--append", "--tee", &path][..],
        &["record", "-", "--append", "-o", &path],
    ] {
        let (_, err) = expect(2, arguments);
        assert!(err.contains("only raw text can be appended to"), "{err}");
    }
    assert!(fs::read(&path).unwrap() == fs::read(sample).unwrap());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn nothing_gets_a_name_of_the_recorders() {
    let folder = scratch("own-names");
    for name in ["foo.mcap.finishing", "a.damaged"] {
        let path = folder.join(name).display().to_string();
        for verb in [
            &["export", "--to", "mcap", CLEAN, "-o"][..],
            &["cut", "--from", "1s", CLEAN, "-o"],
            &["export", "--to", "csv", CLEAN, "-o"],
            &["compare", CLEAN, CLEAN, "--svg"],
        ] {
            let (_, err) = expect(2, &[verb, &[&path, "--force"]].concat());
            assert!(err.contains("choose another name"), "{err}");
        }
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(unix)]
#[test]
fn interrupted_command_leaves_no_file() {
    let folder = scratch("interrupted-output");
    for signal in ["-INT", "-TERM"] {
        let mut program = Command::new(GROUNDWAVE)
            .args(["export", "--to", "mcap", "-", "-o", "made.mcap"])
            .current_dir(&folder)
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Held open, because the program would exit at its end.
        let mut stdin = program.stdin.take().unwrap();
        std::io::Write::write_all(&mut stdin, &fs::read(CLEAN).unwrap()).unwrap();
        let names = || -> Vec<String> {
            let entries = fs::read_dir(&folder).unwrap();
            entries
                .map(|entry| entry.unwrap().file_name().into_string().unwrap())
                .collect()
        };
        let deadline = Instant::now() + Duration::from_mins(1);
        while !names()
            .iter()
            .any(|name| name.starts_with("made.mcap.unfinished"))
        {
            assert!(Instant::now() < deadline, "it never began");
            std::thread::yield_now();
        }
        let pid = program.id().to_string();
        Command::new("kill").args([signal, &pid]).status().unwrap();
        let output = program.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130));
        assert_eq!(String::from_utf8(output.stderr).unwrap(), "", "quietly");
        assert_eq!(names(), Vec::<String>::new());
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn note_after_the_end_of_the_capture_is_refused() {
    let folder = scratch("label-at");
    let file = folder.join("a.txt").display().to_string();
    fs::copy(CLEAN, &file).unwrap();
    expect(0, &["label", &file, "--note", "here", "--at", "1:59"]);
    let (_, err) = expect(2, &["label", &file, "--note", "where", "--at", "5:00"]);
    assert!(err.contains("is 01:59 long"), "{err}");
    let (said, _) = expect(0, &["label", &file]);
    assert!(said.contains("here") && !said.contains("where"), "{said}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn file_extension_must_match_the_format() {
    let folder = scratch("names");
    let file = |name: &str| folder.join(name).display().to_string();
    expect(0, &["export", "--to", "mcap", CLEAN, "-o", &file("a.mcap")]);
    let mcap = file("a.mcap");
    let cases = [
        (
            vec!["export", "--to", "raw", &mcap],
            "t.mcap",
            "name it .txt",
        ),
        (
            vec!["export", "--to", "mcap", CLEAN],
            "h.txt",
            "name it .mcap",
        ),
        (
            vec!["cut", CLEAN, "--from", "10s"],
            "c.mcap",
            "`groundwave export --to mcap` makes MCAP of it",
        ),
        (
            vec!["cut", &mcap, "--from", "10s"],
            "c.txt",
            "`groundwave export --to raw` makes raw text of it",
        ),
    ];
    for (verb, name, told) in cases {
        let (_, err) = expect(2, &[&verb[..], &["-o", &file(name)]].concat());
        assert!(err.contains(told), "{verb:?}: {err}");
        assert!(!folder.join(name).exists(), "{verb:?}");
    }
    expect(0, &["export", "--to", "raw", &mcap, "-o", &file("t.raw")]);
    expect(0, &["cut", &mcap, "--from", "10s", "-o", &file("part")]);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn file_without_a_line_is_not_converted() {
    let folder = scratch("noise");
    let file = |name: &str| folder.join(name).display().to_string();
    let prose = "There is a text without a line of a robot.\n".repeat(20)
        + "The robot's lines are plain text: 7\n";
    fs::write(folder.join("prose.txt"), prose).unwrap();
    for arguments in [
        ["info", "--json"],
        ["verify", "--json"],
        ["export", "--to=jsonl"],
    ] {
        let (_, err) = expect(2, &[&arguments[..], &[&file("prose.txt")]].concat());
        assert!(err.contains("no line found"), "{arguments:?}: {err}");
    }
    for (name, content) in [("notes.txt", "milk\n"), ("empty.txt", "")] {
        fs::write(folder.join(name), content).unwrap();
        for output in [&file("made.mcap"), "-"] {
            let (out, err) = expect(2, &["export", "--to", "mcap", &file(name), "-o", output]);
            assert!(err.contains("no line found"), "{err}");
            assert_eq!(out, "");
        }
    }
    let (_, err) = expect(
        2,
        &["export", "--to", "mcap", "-", "-o", &file("made.mcap")],
    );
    assert!(err.contains("standard input: no line found"), "{err}");
    assert!(!folder.join("made.mcap").exists());
    expect(
        0,
        &["export", "--to", "mcap", "--anyway", &file("notes.txt")],
    );
    assert!(folder.join("notes.mcap").exists());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn pattern_without_a_match_does_not_hide_other_captures() {
    let folder = scratch("patterns");
    fs::copy(CLEAN, folder.join("a.txt")).unwrap();
    let file = |name: &str| folder.join(name).display().to_string();
    for verb in [&["info"][..], &["verify"]] {
        let (out, err) = expect(2, &[verb, &[&file("q*.mcap"), &file("*.txt")]].concat());
        assert!(out.contains("a.txt"), "{out}");
        assert!(err.contains("q*.mcap: no file matches"), "{err}");
    }
    let made = file("made");
    let files = [&*file("q*.mcap"), &file("*.txt"), "--output-dir", &made];
    for verb in [
        &["export", "--to", "mcap"][..],
        &["cut", "--from", "10s"],
        &["export", "--to", "csv"],
    ] {
        let (_, err) = expect(2, &[verb, &files].concat());
        assert!(err.contains("q*.mcap: no file matches"), "{err}");
    }
    for name in ["a.mcap", "a.cut.txt", "a.csv"] {
        assert!(folder.join("made").join(name).exists(), "{name}");
    }
    fs::remove_dir_all(folder).unwrap();
}
