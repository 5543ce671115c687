//! Who may know whom. ARCHITECTURE.md says it, this reads the `use` lines and keeps it so.
#![expect(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use std::fs;
use std::path::{Path, PathBuf};

/// A folder or file, and what must not stand in its code.
const RULES: &[(&str, &[&str])] = &[
    ("protocol/src", &["sr04_", "groundwave::", "std::"]),
    ("firmware/src", &["sr04_sim", "groundwave::", "std::"]),
    ("firmware/sim/src", &["groundwave::"]),
    (
        "src/station",
        &[
            "crate::io",
            "crate::runtime",
            "crate::model",
            "crate::view",
            "crate::capture",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "src/model",
        &[
            "crate::io",
            "crate::runtime",
            "crate::view",
            "crate::capture",
            "crate::station",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "src/view",
        &[
            "crate::io",
            "crate::runtime",
            "crate::capture",
            "crate::station",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "src/capture",
        &[
            "crate::io",
            "crate::runtime",
            "crate::view",
            "crate::model",
            "Instant::now",
            "SystemTime::now",
        ],
    ),
    (
        "src/share",
        &[
            "crate::io",
            "crate::runtime",
            "crate::model",
            "crate::view",
            "crate::capture",
            "crate::station",
            "sr04_sim",
            "Instant",
            "SystemTime",
        ],
    ),
    ("src/io", &["crate::model", "crate::view", "crate::runtime"]),
    ("src/runtime", &["sr04_sim"]),
    ("src/station", &["sr04_sim"]),
    ("src/model", &["sr04_sim"]),
    ("src/view", &["sr04_sim"]),
    ("src/io", &["sr04_sim"]),
    ("src/capture", &["sr04_sim"]),
];

/// Clocks may be read here and nowhere else in the station.
const CLOCK_READERS: &[&str] = &["src/io", "src/runtime", "src/commands"];

#[test]
fn nobody_reaches_above_their_rank() {
    let mut broken = Vec::new();
    for (place, forbidden) in RULES {
        for file in rust_files(&root().join(place)) {
            for (number, line) in code_lines(&file) {
                for word in *forbidden {
                    if line.contains(word) {
                        broken.push(format!("{}:{number}: {word}", file.display()));
                    }
                }
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn clocks_are_read_at_the_edges_only() {
    let mut broken = Vec::new();
    for file in rust_files(&root().join("src")) {
        if CLOCK_READERS
            .iter()
            .any(|reader| file.starts_with(root().join(reader)))
        {
            continue;
        }
        for (number, line) in code_lines(&file) {
            if line.contains("::now()") || line.contains("thread::sleep") {
                broken.push(format!("{}:{number}: {line}", file.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn no_test_sleeps() {
    let tests = [
        "tests",
        "protocol/tests",
        "firmware/tests",
        "firmware/sim/tests",
    ];
    let sleep = ["thread::", "sleep"].concat();
    let offenders: Vec<PathBuf> = tests
        .iter()
        .flat_map(|folder| rust_files(&root().join(folder)))
        .filter(|file| fs::read_to_string(file).unwrap().contains(&sleep))
        // This file names what it looks for.
        .filter(|file| !file.ends_with("tests/ranks.rs"))
        .collect();
    assert_eq!(offenders, [] as [PathBuf; 0]);
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs")
            && !is_test_module(&path)
        {
            files.push(path);
        }
    }
    files
}

/// Modules that exist under `cfg(test)` only.
fn is_test_module(path: &Path) -> bool {
    path.file_name()
        .is_some_and(|name| name == "tests.rs" || name == "testing.rs")
}

/// Lines of code with their numbers: no comments, and nothing from the first `mod tests` on.
fn code_lines(file: &Path) -> Vec<(usize, String)> {
    let text = fs::read_to_string(file).unwrap();
    (1..)
        .zip(text.lines())
        .take_while(|(_, line)| !line.starts_with("mod tests"))
        .filter(|(_, line)| !line.trim_start().starts_with("//"))
        .map(|(number, line)| (number, line.to_owned()))
        .collect()
}
