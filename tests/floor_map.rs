//! `export --to map`: the floor that was seen, for ROS.
#![cfg(unix)]

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::BufReader;
use std::ops::Range;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use crate::programs::{GROUNDWAVE, expect, scratch};

const CLEAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");

/// A side of a cell, metres.
const RESOLUTION_M: f64 = 0.0762;

/// A map as a reader of both files sees it.
struct Map {
    origin_m: [f64; 2],
    columns: usize,
    rows: usize,
    pixels: Vec<u8>,
}

impl Map {
    fn read(yaml: &Path) -> Self {
        let text = fs::read_to_string(yaml).unwrap();
        let value = |key: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(key));
            line.unwrap_or_else(|| panic!("{key} in {text}")).trim()
        };
        assert_eq!(value("mode:"), "trinary");
        assert_eq!(value("negate:"), "0");
        assert_eq!(value("occupied_thresh:").parse::<f64>(), Ok(0.65));
        assert_eq!(value("free_thresh:").parse::<f64>(), Ok(0.196));
        assert_eq!(value("resolution:").parse::<f64>(), Ok(RESOLUTION_M));
        let origin: [f64; 3] = serde_json::from_str(value("origin:")).unwrap();
        let image: String = serde_json::from_str(value("image:")).unwrap();
        let pgm = fs::read(yaml.with_file_name(image)).unwrap();
        let end = pgm.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
        let (head, pixels) = pgm.split_at(end.map(|(at, _)| at + 1).nth(2).unwrap());
        let head = String::from_utf8(head.to_vec()).unwrap();
        let words: Vec<&str> = head.split_whitespace().collect();
        let [magic, columns, rows, depth] = words[..] else {
            panic!("{head}");
        };
        assert_eq!([magic, depth], ["P5", "255"]);
        let (columns, rows) = (columns.parse().unwrap(), rows.parse().unwrap());
        assert_eq!(pixels.len(), columns * rows);
        Self {
            origin_m: [origin[0], origin[1]],
            columns,
            rows,
            pixels: pixels.to_vec(),
        }
    }

    /// The pixel of a place, inches: the first row of an image is its upper one.
    fn at(&self, (x_in, y_in): (f64, f64)) -> u8 {
        // A place on the border of two cells is in the upper one, whatever the rounding.
        let cell = |m: f64, origin_m: f64| ((m - origin_m) / RESOLUTION_M + 1e-6) as usize;
        let column = cell(x_in * 0.0254, self.origin_m[0]);
        let row = cell(y_in * 0.0254, self.origin_m[1]);
        self.pixels[(self.rows - 1 - row) * self.columns + column]
    }

    fn count(&self, level: u8) -> usize {
        let equal = self.pixels.iter().map(|pixel| usize::from(*pixel == level));
        equal.sum()
    }
}

/// Share of the odometer's path in a time of a capture, seconds, that is free on the map: the odometer is still nearly right.
fn driven_share(map: &Map, capture: &str, time_s: Range<f64>) -> f64 {
    let (table, _) = expect(0, &["export", capture, "--to", "csv", "-o", "-"]);
    let mut rows = table.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let [t, x, y] =
        ["at_s", "x_in", "y_in"].map(|name| head.iter().position(|it| *it == name).expect(name));
    let number = |row: &[&str], at: usize| row[at].parse::<f64>().ok();
    let path: Vec<(f64, f64)> = rows
        .filter(|row| number(row, t).is_some_and(|t| time_s.contains(&t)))
        .filter_map(|row| Some((number(&row, x)?, number(&row, y)?)))
        .collect();
    assert!(path.len() > 30, "{}", path.len());
    let driven = path.iter().filter(|place| map.at(**place) == 254);
    driven.count() as f64 / path.len() as f64
}

#[test]
fn floor_is_exported_for_ros() {
    let folder = scratch("floor-map");
    let yaml = folder.join("a \"house\".yaml");
    let name = yaml.display().to_string();
    let (_, err) = expect(0, &["export", CLEAN, "--to", "map", "-o", &name]);
    assert!(
        err.contains("map of 12 x 19 ft, up to 01:50, because"),
        "{err}"
    );
    let map = Map::read(&yaml);
    let (occupied, free, unknown) = (map.count(0), map.count(254), map.count(205));
    assert_eq!(occupied + free + unknown, map.pixels.len());
    assert!(
        occupied > 100 && free > 1000 && unknown > 1000,
        "{occupied} {free} {unknown}"
    );
    // The robot began at the origin and headed along +Y.
    for y_in in [0.0, 3.0, 6.0, 9.0] {
        assert_eq!(map.at((0.0, y_in)), 254, "{y_in}");
    }
    assert!(driven_share(&map, CLEAN, 0.0..20.0) > 0.95);
    // A map that has everything says no more.
    let bursts = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/captures/living-room-bursts.txt"
    );
    let (_, err) = expect(
        0,
        &["export", bursts, "--to", "map", "--force", "-o", &name],
    );
    assert!(err.contains("map of 30 x 24 ft; image a "), "{err}");
    fs::remove_dir_all(folder).unwrap();
}

/// The same map as a PNG image, which viewers, editors and `map_server` open.
#[test]
fn floor_is_exported_as_png() {
    let folder = scratch("floor-png");
    let [yaml, image] = ["m.yaml", "p.png"].map(|name| folder.join(name));
    for target in [&yaml, &image] {
        expect(
            0,
            &[
                "export",
                CLEAN,
                "--to",
                "map",
                "-o",
                &target.display().to_string(),
            ],
        );
    }
    let map = Map::read(&yaml);
    let description = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(
        description("p.yaml"),
        description("m.yaml").replace("m.pgm", "p.png")
    );
    let decoder = png::Decoder::new(BufReader::new(File::open(&image).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(
        (frame.width as usize, frame.height as usize),
        (map.columns, map.rows)
    );
    assert_eq!(pixels, map.pixels);
    // Neither file of the pair replaces another without --force.
    let (_, err) = expect(
        2,
        &[
            "export",
            CLEAN,
            "--to",
            "map",
            "-o",
            &folder.join("m.png").display().to_string(),
        ],
    );
    assert!(err.contains("m.yaml exists"), "{err}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn both_files_of_a_map_are_named_protected_and_replaced_by_force_only() {
    let folder = scratch("floor-map-files");
    let file = |name: &str| folder.join(name).display().to_string();
    for (target, hint) in [
        ("-", "-o NAME.yaml"),
        (&*file("m.pgm"), "such as floor.yaml"),
    ] {
        let (_, err) = expect(2, &["export", CLEAN, "--to", "map", "-o", target]);
        assert!(err.contains(hint), "{err}");
    }
    fs::write(file("m.pgm"), "mine").unwrap();
    let yaml = file("m.yaml");
    let (_, err) = expect(2, &["export", CLEAN, "--to", "map", "-o", &yaml]);
    assert!(
        err.contains("m.pgm exists") && err.contains("--force"),
        "{err}"
    );
    assert_eq!(fs::read_to_string(file("m.pgm")).unwrap(), "mine");
    assert!(!folder.join("m.yaml").exists());
    expect(0, &["export", CLEAN, "--to", "map", "--force", "-o", &yaml]);
    Map::read(Path::new(&yaml));
    // A capture that has the image's name is not replaced by it.
    fs::copy(CLEAN, file("c.pgm")).unwrap();
    let (_, err) = expect(2, &["export", &file("c.pgm"), "--to", "map", "--force"]);
    assert!(err.contains("choose another name"), "{err}");
    assert_eq!(fs::read(file("c.pgm")).unwrap(), fs::read(CLEAN).unwrap());
    fs::remove_dir_all(folder).unwrap();
}

/// Neither file is new if the other cannot be: a link that leads nowhere, a full disk, a name that YAML cannot hold, or the image of a
/// later capture.
#[test]
fn no_half_of_a_map_is_written() {
    let folder = scratch("floor-map-halves");
    let file = |name: &str| folder.join(name).display().to_string();
    symlink("nowhere", folder.join("dangling.yaml")).unwrap();
    symlink("/dev/full", folder.join("full.yaml")).unwrap();
    for (name, code) in [("dangling", 2), ("full", 1)] {
        let yaml = file(&format!("{name}.yaml"));
        expect(code, &["export", CLEAN, "--to", "map", "-o", &yaml]);
        assert!(!folder.join(name).with_extension("pgm").exists(), "{name}");
    }
    let output = Command::new(GROUNDWAVE)
        .args(["export", CLEAN, "--to", "map", "-o"])
        .arg(folder.join(OsStr::from_bytes(b"n\xff.yaml")))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("UTF-8"));
    fs::copy(CLEAN, file("p.txt")).unwrap();
    fs::copy(CLEAN, file("q.txt")).unwrap();
    fs::write(file("q.pgm"), "mine").unwrap();
    let (_, err) = expect(
        2,
        &["export", &file("p.txt"), &file("q.txt"), "--to", "map"],
    );
    assert!(err.contains("q.pgm exists"), "{err}");
    assert!(!folder.join("p.yaml").exists() && !folder.join("p.pgm").exists());
    fs::remove_dir_all(folder).unwrap();
}

/// A longer capture does not lose the map of a shorter one.
#[test]
fn map_is_not_lost_again() {
    let folder = scratch("floor-map-prefixes");
    let file = |name: &str| folder.join(name).display().to_string();
    let noisy = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-noisy.txt");
    let bytes = fs::read(noisy).unwrap();
    let mut had_map = false;
    for percent in (20..=100).step_by(5) {
        let part = file(&format!("{percent}.txt"));
        fs::write(&part, &bytes[..bytes.len() * percent / 100]).unwrap();
        let output = Command::new(GROUNDWAVE)
            .args(["export", &part, "--to", "map"])
            .output()
            .unwrap();
        assert!(output.status.success() || !had_map, "{percent}: {output:?}");
        had_map = output.status.success();
    }
    assert!(had_map);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn map_names_what_it_leaves_out() {
    let folder = scratch("floor-map-parts");
    let file = |name: &str| folder.join(name).display().to_string();
    let capture = fs::read(CLEAN).unwrap();
    fs::write(file("short.txt"), &capture[..2400]).unwrap();
    let (_, err) = expect(2, &["export", &file("short.txt"), "--to", "map"]);
    assert!(
        err.contains("no map: the robot has not passed enough walls"),
        "{err}"
    );
    assert!(!folder.join("short.yaml").exists() && !folder.join("short.pgm").exists());
    fs::write(file("noise.txt"), "noise\n").unwrap();
    let (_, err) = expect(2, &["export", &file("noise.txt"), "--to", "map"]);
    assert!(err.contains("no line found"), "{err}");
    // The tour of the real board has a new pose, which the odometer's path follows.
    let tour = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/mega-tour.txt");
    let (_, err) = expect(0, &["export", tour, "--to", "map", "-o", &file("t.yaml")]);
    assert!(
        err.contains(", from 00:40 on, after a new pose or a restart"),
        "{err}"
    );
    let map = Map::read(&folder.join("t.yaml"));
    assert!(driven_share(&map, tour, 41.0..60.0) > 0.95);
    // A pose that is new at the end leaves too little.
    let bytes = fs::read(tour).unwrap();
    fs::write(file("late.txt"), &bytes[..bytes.len() * 40 / 100]).unwrap();
    let (_, err) = expect(2, &["export", &file("late.txt"), "--to", "map"]);
    assert!(
        err.contains("no map since 00:40") && err.contains("cut --to 00:40"),
        "{err}"
    );
    fs::remove_dir_all(folder).unwrap();
}
