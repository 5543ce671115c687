//! `export --to map`: the floor that was seen, for ROS.

use std::fs;
use std::path::Path;

use crate::programs::{expect, scratch};

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
        let cell = |m: f64, origin_m: f64| ((m - origin_m) / RESOLUTION_M) as usize;
        let column = cell(x_in * 0.0254, self.origin_m[0]);
        let row = cell(y_in * 0.0254, self.origin_m[1]);
        self.pixels[(self.rows - 1 - row) * self.columns + column]
    }

    fn count(&self, level: u8) -> usize {
        let equal = self.pixels.iter().filter(|pixel| **pixel == level);
        equal.collect::<Vec<_>>().len()
    }
}

#[test]
fn floor_is_exported_for_ros() {
    let folder = scratch("floor-map");
    let yaml = folder.join("a \"house\".yaml");
    let name = yaml.display().to_string();
    let (_, err) = expect(0, &["export", CLEAN, "--to", "map", "-o", &name]);
    assert!(err.contains("map of 49 x 22 ft; image a "), "{err}");
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
    // The first path is still near the odometer's.
    let (table, _) = expect(0, &["export", CLEAN, "--to", "csv", "-o", "-"]);
    let mut rows = table.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let column = |name: &str| head.iter().position(|it| *it == name).unwrap();
    let (x, y) = (column("x_in"), column("y_in"));
    let path = rows.filter_map(|row| Some((row[x].parse().ok()?, row[y].parse().ok()?)));
    let path: Vec<(f64, f64)> = path.take(60).collect();
    let driven = path.iter().filter(|place| map.at(**place) == 254);
    assert!(driven.count() >= 57, "{path:?}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn both_files_of_a_map_are_named_protected_and_replaced_by_force_only() {
    let folder = scratch("floor-map-files");
    let file = |name: &str| folder.join(name).display().to_string();
    for (target, hint) in [("-", "-o NAME.yaml"), (&*file("m.pgm"), "name it .yaml")] {
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
    // The tour of the real board sets a pose.
    let tour = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/mega-tour.txt");
    let (_, err) = expect(0, &["export", tour, "--to", "map", "-o", &file("t.yaml")]);
    assert!(
        err.contains("from 00:40, when the robot was given a new pose"),
        "{err}"
    );
    Map::read(&folder.join("t.yaml"));
    fs::remove_dir_all(folder).unwrap();
}
