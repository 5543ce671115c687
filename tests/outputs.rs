//! What verbs make: never instead of what it is made of, and whole or not there at all.
#![expect(clippy::unwrap_used, reason = "a test stops where something is wrong")]

#[path = "common/programs.rs"]
mod programs;

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use programs::{GROUNDWAVE, expect, scratch};

const CLEAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");

#[test]
fn a_capture_is_not_replaced_by_what_is_made_of_it() {
    let folder = scratch("own-input");
    let file = |name: &str| folder.join(name).display().to_string();
    fs::copy(CLEAN, folder.join("a.txt")).unwrap();
    fs::create_dir(folder.join("in")).unwrap();
    let roundabout = file("in/../a.txt");
    let source = file("a.txt");
    for target in [&source, &roundabout] {
        for verb in [
            &["convert"][..],
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

#[cfg(unix)]
#[test]
fn whoever_is_interrupted_leaves_nothing_behind() {
    let folder = scratch("interrupted-output");
    for signal in ["-INT", "-TERM"] {
        let mut program = Command::new(GROUNDWAVE)
            .args(["convert", "-", "-o", "made.mcap"])
            .current_dir(&folder)
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::io::Write::write_all(program.stdin.as_mut().unwrap(), &fs::read(CLEAN).unwrap())
            .unwrap();
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
fn a_remark_is_about_a_moment_that_there_was() {
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
