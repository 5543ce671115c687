//! Text captures of other stations and editors: all commands read the same lines with the same timestamps.

use std::fs;
use std::path::Path;

use crate::programs::{expect, scratch};
use serde_json::Value;

/// Two minutes in the house with a pause of an hour in the middle and a timestamp before each line.
fn stamped(end: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures/house-clean.txt");
    let plain = fs::read(path).unwrap();
    let mut lines: Vec<&[u8]> = plain.split_inclusive(|&byte| byte == b'\n').collect();
    // Partial lines have no line end to change.
    lines.retain(|line| line.ends_with(b"\r\n"));
    let mut stored = Vec::new();
    for (n, line) in lines.iter().enumerate() {
        let second = n / 3 + if n >= 150 { 3600 } else { 0 };
        let (h, m, s) = (20 + second / 3600, second / 60 % 60, second % 60);
        stored.extend(format!("2025-03-14T{h:02}:{m:02}:{s:02}.{:03}Z ", n % 3 * 333).as_bytes());
        stored.extend(line.strip_suffix(b"\r\n").unwrap());
        stored.extend(end);
    }
    (stored, lines.concat())
}

fn json(args: &[&str]) -> Vec<Value> {
    let (out, _) = expect(0, args);
    out.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn all_commands_read_timestamps_and_lines_without_cr() {
    for (name, end) in [("crlf", &b"\r\n"[..]), ("lf", b"\n"), ("crcrlf", b"\r\r\n")] {
        let folder = scratch(&format!("text-{name}"));
        let file = |name: &str| folder.join(name).display().to_string();
        let (stored, radio) = stamped(end);
        let lines = radio.len() / 80;
        fs::write(folder.join("a.txt"), &stored).unwrap();
        let last_s = (lines - 1) / 3 + 3600;

        let of_raw = &json(&["info", "--json", &file("a.txt")])[0];
        assert_eq!(of_raw["bytes"], radio.len());
        assert_eq!(of_raw["noise_bytes"], 0);
        assert_eq!(of_raw["resync"], Value::Null);
        assert_eq!(of_raw["duration_s"].as_f64().unwrap() as usize, last_s);
        let (text, _) = expect(0, &["info", &file("a.txt")]);
        assert!(
            text.contains("stored     with a time before each line"),
            "{text}"
        );

        let exported = json(&["export", "-o", "-", "--to", "jsonl", &file("a.txt")]);
        // The hour without lines is an outage.
        let mut decoded = exported.clone();
        decoded.retain(|row| row.get("line_type").is_some());
        assert_eq!(decoded.len(), lines);
        assert_eq!(exported.len(), lines + 1);
        let at_s: Vec<f64> = decoded
            .iter()
            .map(|line| line["at_s"].as_f64().unwrap())
            .collect();
        assert!(
            at_s.is_sorted() && at_s[151] > 3650.0,
            "{:?}",
            &at_s[148..152]
        );
        let (table, _) = expect(0, &["export", "--to", "csv", &file("a.txt"), "-o", "-"]);
        // The names of the columns, the lines, and the outage.
        assert_eq!(table.lines().count(), lines + 2);
        assert!(
            table
                .lines()
                .last()
                .unwrap()
                .starts_with(&last_s.to_string())
        );

        expect(
            0,
            &[
                "export",
                "--to",
                "mcap",
                &file("a.txt"),
                "-o",
                &file("a.mcap"),
                "-q",
            ],
        );
        expect(0, &["verify", "-q", &file("a.mcap"), &file("a.txt")]);
        let converted = json(&["export", "-o", "-", "--to", "jsonl", &file("a.mcap")]);
        assert!(
            converted == exported,
            "the recording has the times of the text"
        );
        let of_mcap = &json(&["info", "--json", &file("a.mcap")])[0];
        for what in ["duration_s", "bytes", "lines", "distance_in", "bumps"] {
            assert_eq!(of_mcap[what], of_raw[what], "{what}");
        }
        expect(
            0,
            &[
                "export",
                "--to",
                "raw",
                &file("a.mcap"),
                "-o",
                &file("b.txt"),
                "-q",
            ],
        );
        assert!(
            fs::read(folder.join("b.txt")).unwrap() == radio,
            "what the radio delivered"
        );

        // The hour in the middle counts, in capture time and in time of day.
        for (from, to) in [
            ("1m", "1:00:00"),
            ("2025-03-14T20:01:00Z", "2025-03-14T21:00:00Z"),
        ] {
            expect(
                2,
                &["cut", &file("a.txt"), "--from", from, "--to", to, "-o", "-"],
            );
        }
        let (part, _) = expect(0, &["cut", &file("a.txt"), "--from", "1:00:00", "-o", "-"]);
        assert!(stored.ends_with(part.as_bytes()) && part.starts_with("2025-03-14T21:00:50"));

        let (runs, _) = expect(0, &["runs", &file("a.txt")]);
        assert!(runs.contains("61:"), "{runs}");
        fs::remove_dir_all(folder).unwrap();
    }
}

/// Text without timestamps and the recording made of it have the same times.
#[test]
fn converted_capture_keeps_the_timestamps_of_the_text() {
    let folder = scratch("text-times");
    let raw = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-noisy.txt");
    let mcap = folder.join("a.mcap").display().to_string();
    expect(0, &["export", "--to", "mcap", raw, "-o", &mcap, "-q"]);
    assert_eq!(
        json(&["export", "-o", "-", "--to", "jsonl", raw]),
        json(&["export", "-o", "-", "--to", "jsonl", &mcap])
    );
    let (of_raw, of_mcap) = (
        json(&["info", "--json", raw]),
        json(&["info", "--json", &mcap]),
    );
    assert_eq!(of_raw[0]["duration_s"], of_mcap[0]["duration_s"]);
    fs::remove_dir_all(folder).unwrap();
}

/// All commands report the same figures for a capture.
#[test]
fn all_commands_have_the_same_figures() {
    for name in ["house-clean.txt", "house-noisy.txt", "demo-commands.mcap"] {
        let file = format!("{}/captures/{name}", env!("CARGO_MANIFEST_DIR"));
        let info = &json(&["info", "--json", &file])[0];
        let run = &json(&["runs", "--json", &file])[0];
        let compared = &json(&["compare", "--json", &file, &file])[0]["runs"][1];
        for figure in ["duration_s", "distance_in", "bumps", "restarts"] {
            assert_eq!(run[figure], info[figure], "{name}: {figure}");
            assert_eq!(compared[figure], info[figure], "{name}: {figure}");
        }
        let of_info = info["bumps"].clone();
        assert!(of_info.as_u64().unwrap() > 0, "{name}");
        let (svg, _) = expect(0, &["export", "--to", "svg", &file, "-o", "-"]);
        assert!(
            [")", ", "]
                .iter()
                .any(|end| svg.contains(&format!("bump ({of_info}{end}"))),
            "{name}: {of_info}"
        );
    }
}
