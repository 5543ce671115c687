//! `map`: several captures on one map of the floor.

use std::fs;
use std::path::Path;

use sr04_sim::{Pose, Simulation, SimulationConfig, World};

use crate::programs::{expect, path_in, scratch};

/// A house whose second run has a place on the map of the first, and another house.
const HOUSE: u64 = 53_003;
const OTHER: u64 = 53_005;

/// Writes what a robot sends in 20 min, as raw text; it starts turned.
fn record(folder: &Path, name: &str, house: u64, seed: u64, turn_deg: f64) -> String {
    let world = World::generated(house);
    let start = world.start();
    let start = Pose {
        theta_deg: start.theta_deg + turn_deg,
        ..start
    };
    let world = world.started_at(start).expect("a place");
    let mut simulation = Simulation::new(&SimulationConfig::new(world, seed));
    let mut bytes = Vec::new();
    for _ in 0..20 * 60 {
        simulation.run_for_ms(1000);
        bytes.extend(std::iter::from_fn(|| simulation.poll_downlink()));
    }
    let path = path_in(folder, name);
    fs::write(&path, bytes).unwrap();
    path
}

/// X and Y of a size in feet, from the words for a map.
fn size_ft(words: &str) -> [f64; 2] {
    let (_, size) = words.split_once("map of ").expect(words);
    let (size, _) = size.split_once(" ft").expect(words);
    let (x, y) = size.split_once(" x ").expect(words);
    [x, y].map(|feet| feet.parse().unwrap())
}

#[test]
fn runs_in_one_house_make_one_map_and_another_house_is_left_out() {
    let folder = scratch("map-of-runs");
    let first = record(&folder, "first.txt", HOUSE, 1, 0.0);
    let text = record(&folder, "second.txt", HOUSE, 2, 90.0);
    let other = record(&folder, "other.txt", OTHER, 1, 0.0);
    let second = path_in(&folder, "second.mcap");
    expect(0, &["export", &text, "--to", "mcap", "-o", &second]);

    let map = path_in(&folder, "house.yaml");
    let (_, err) = expect(0, &["map", &first, &second, "-o", &map]);
    let rows: Vec<&str> = err.lines().collect();
    assert_eq!(rows.len(), 3, "{err}");
    assert!(
        rows[0].contains("first.txt: added, its home is the map's origin"),
        "{err}"
    );
    let (_, words) = rows[1]
        .split_once("second.mcap: added, turned ")
        .expect(&err);
    let numbers: Vec<f64> = words
        .split(|c: char| !c.is_ascii_digit() && c != '-')
        .filter_map(|number| number.parse().ok())
        .collect();
    assert!((numbers[0] - 90.0).abs() < 20.0, "{err}");
    assert!(numbers[1].hypot(numbers[2]) < 36.0, "{err}");
    assert!(
        rows[2].contains("house.yaml: map of ") && rows[2].contains("; image house.pgm"),
        "{err}"
    );
    let image = fs::read(path_in(&folder, "house.pgm")).unwrap();
    let again = path_in(&folder, "again.yaml");
    expect(0, &["map", "-q", &first, &text, "-o", &again]);
    assert_eq!(fs::read(path_in(&folder, "again.pgm")).unwrap(), image);

    // The map of one run is that of `export`.
    let alone = path_in(&folder, "alone.png");
    expect(0, &["map", &first, "-o", &alone]);
    let exported = path_in(&folder, "exported.png");
    let (_, words) = expect(0, &["export", &first, "--to", "map", "-o", &exported]);
    let alone = fs::read(&alone).unwrap();
    assert_eq!(fs::read(&exported).unwrap(), alone);
    let (one, both) = (size_ft(&words), size_ft(rows[2]));
    assert!(both[0] >= one[0] && both[1] >= one[1], "{one:?} {both:?}");

    // A run of another house is named; the others are on the map.
    let (_, err) = expect(1, &["map", &first, &other, &text, "--force", "-o", &map]);
    assert!(err.contains("other.txt: left out: "), "{err}");
    assert!(err.contains("second.txt: added, turned "), "{err}");
    assert_eq!(fs::read(path_in(&folder, "house.pgm")).unwrap(), image);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn map_without_poses_is_not_written_and_nothing_is_overwritten() {
    let folder = scratch("map-files");
    let clean = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");
    let capture = path_in(&folder, "c.txt");
    fs::copy(clean, &capture).unwrap();
    let short = path_in(&folder, "short.txt");
    fs::write(&short, &fs::read(clean).unwrap()[..2400]).unwrap();
    let noise = path_in(&folder, "noise.txt");
    fs::write(&noise, "noise\n").unwrap();
    let (_, err) = expect(2, &["map", &short, &noise]);
    assert!(
        err.contains("short.txt: no map: the robot has not passed enough walls"),
        "{err}"
    );
    assert!(err.contains("noise.txt: no line found"), "{err}");
    assert!(!folder.join("short.yaml").exists() && !folder.join("short.pgm").exists());

    // A capture without a map does not keep the others from theirs, which is named after the first capture.
    let (_, err) = expect(2, &["map", &noise, &capture]);
    assert!(
        err.contains("c.txt: added, its home is the map's origin, up to 01:50, because"),
        "{err}"
    );
    assert!(folder.join("noise.yaml").exists() && folder.join("noise.pgm").exists());

    let (_, err) = expect(2, &["map", &noise, &capture]);
    assert!(
        err.contains("noise.yaml exists") && err.contains("--force"),
        "{err}"
    );
    for (output, hint) in [
        ("-", "-o NAME.yaml"),
        (&*path_in(&folder, "m.pgm"), "such as floor.yaml"),
    ] {
        let (_, err) = expect(2, &["map", &capture, "-o", output]);
        assert!(err.contains(hint), "{err}");
    }
    // No capture is overwritten by its map, whichever it is.
    let named = path_in(&folder, "named.yaml");
    fs::copy(clean, &named).unwrap();
    let (_, err) = expect(2, &["map", &capture, &named, "--force", "-o", &named]);
    assert!(err.contains("choose another name"), "{err}");
    assert_eq!(fs::read(&named).unwrap(), fs::read(clean).unwrap());
    fs::remove_dir_all(folder).unwrap();
}
