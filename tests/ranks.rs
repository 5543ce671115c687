//! Checks the dependency rules of ARCHITECTURE.md by reading imports and paths.

use std::fs;
use std::path::{Path, PathBuf};

/// A folder or file, and paths that must not be used in it.
const RULES: &[(&str, &[&str])] = &[
    (
        "protocol/src",
        &["sr04_firmware", "sr04_sim", "groundwave", "std"],
    ),
    (
        "protocol/lines/src",
        &[
            "groundwave_protocol",
            "groundwave_captures",
            "std::fs",
            "std::io",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "mapping/src",
        &[
            "sr04_sim",
            "sr04_firmware",
            "groundwave_captures",
            "std::fs",
            "std::io",
            "Instant",
            "SystemTime",
        ],
    ),
    ("firmware/src", &["sr04_sim", "groundwave", "std"]),
    ("firmware/sim/src", &["groundwave"]),
    ("src/event.rs", VOCABULARY),
    ("src/request.rs", VOCABULARY),
    ("src/parameter_file.rs", VOCABULARY),
    ("src/route.rs", VOCABULARY),
    (
        "src/conformance",
        &[
            "crate::commands",
            "crate::io",
            "crate::runtime",
            "crate::model",
            "crate::view",
            "crate::station",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "src/station",
        &[
            "crate::commands",
            "crate::io",
            "crate::runtime",
            "crate::model",
            "crate::view",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "src/model",
        &[
            "crate::commands",
            "crate::io",
            "crate::runtime",
            "crate::view",
            "crate::station",
            "crate::playback::CaptureState",
            "crate::playback::LivePlayer",
            "crate::playback::Player",
            "crate::playback::Timeline",
            "crate::playback::capture",
            "crate::playback::live",
            "crate::playback::player",
            "crate::playback::timeline",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "src/view",
        &[
            "crate::commands",
            "crate::io",
            "crate::runtime",
            "crate::station",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "captures/src",
        &["sr04_sim", "Instant::now", "SystemTime::now"],
    ),
    (
        "src/share",
        &[
            "crate::io",
            "crate::runtime",
            "crate::model",
            "crate::view",
            "crate::station",
            "Instant",
            "SystemTime",
        ],
    ),
    (
        "src/io",
        &[
            "crate::commands",
            "crate::model",
            "crate::view",
            "crate::runtime",
        ],
    ),
    ("src/runtime", &["crate::commands"]),
    ("src/playback/control.rs", VOCABULARY),
    (
        "src/playback",
        &[
            "crate::commands",
            "crate::io",
            "crate::runtime",
            "crate::view",
            "std::fs",
            "Instant",
            "SystemTime",
        ],
    ),
];

/// What the modules shared by all parts must not use.
const VOCABULARY: &[&str] = &[
    "crate::commands",
    "crate::io",
    "crate::model",
    "crate::runtime",
    "crate::station",
    "crate::view",
    "Instant",
    "SystemTime",
];

/// The verbs that simulate the robot or its beeper; only these may use the simulator.
const SIMULATING: &[&str] = &[
    "src/commands/sim.rs",
    "src/commands/simulated.rs",
    "src/commands/songs.rs",
    "src/commands/watch.rs",
    "src/commands/world.rs",
];

/// Places that know nothing of recordings as files, and the parts of the captures crate that they may use: events, messages, words and
/// figures.
const WITHOUT_FILES: &[&str] = &[
    "src/conformance",
    "src/event.rs",
    "src/model",
    "src/parameter_file.rs",
    "src/playback/control.rs",
    "src/request.rs",
    "src/route.rs",
    "src/share",
    "src/station",
    "src/view",
    "src/wait.rs",
];
const CAPTURES_WITHOUT_FILES: &[&str] = &[
    "content",
    "diagnosis",
    "event",
    "hint",
    "marks",
    "messages",
    "outages",
    "own_lines",
    "song",
    "statistics",
    "when",
    "words",
];

#[test]
fn recordings_are_files_at_the_edges_only() {
    let is_forbidden = |path: &str| {
        let path = path.trim_start_matches("::");
        let parts = path
            .strip_prefix("groundwave_captures")
            .or(path.strip_prefix("crate::capture"));
        // The crate as a whole could be used under any name.
        parts.is_some_and(|parts| match parts.strip_prefix("::") {
            Some(parts) => {
                let part = parts.split("::").next().unwrap_or_default();
                !part.is_empty() && !CAPTURES_WITHOUT_FILES.contains(&part)
            }
            None => parts.is_empty(),
        })
    };
    for path in [
        "::groundwave_captures::Recorder",
        "crate::capture::raw",
        "crate::capture",
    ] {
        assert!(is_forbidden(path), "{path}");
    }
    for path in ["groundwave_captures::words", "crate::captured"] {
        assert!(!is_forbidden(path), "{path}");
    }
    let mut broken = Vec::new();
    for file in WITHOUT_FILES
        .iter()
        .flat_map(|place| rust_files(&root().join(place)))
    {
        for (number, paths) in paths(&file) {
            if paths.split(' ').any(is_forbidden) {
                broken.push(format!("{}:{number}: {paths}", file.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Modules that may read a clock.
const CLOCK_READERS: &[&str] = &["src/io", "src/runtime", "src/commands"];

/// Modules that write to standard output: they make text safe to show, and write bytes unchanged.
const WRITERS: &[&str] = &["src/commands/mod.rs", "src/commands/output.rs"];

#[test]
fn text_is_written_where_it_is_made_safe() {
    let mut broken = Vec::new();
    for file in rust_files(&root().join("src/commands")) {
        if !WRITERS.iter().any(|writer| file.ends_with(writer)) {
            broken.extend(found(&file, "stdout"));
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn no_module_imports_a_higher_rank() {
    let mut broken = Vec::new();
    for (place, forbidden) in RULES {
        for file in rust_files(&root().join(place)) {
            for word in *forbidden {
                broken.extend(found(&file, word));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn only_the_verbs_that_simulate_know_the_simulator() {
    let simulating: Vec<PathBuf> = SIMULATING.iter().map(|file| root().join(file)).collect();
    for file in &simulating {
        assert!(!found(file, "sr04_sim").is_empty(), "{}", file.display());
    }
    let broken: Vec<String> = rust_files(&root().join("src"))
        .iter()
        .filter(|file| !simulating.contains(file))
        .flat_map(|file| found(file, "sr04_sim"))
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// The station takes only the names of parameters from the robot's program.
#[test]
fn the_robots_program_is_known_for_its_names_only() {
    let names = root().join("src/request/parameters.rs");
    assert!(!found(&names, "sr04_firmware").is_empty());
    let broken: Vec<String> = rust_files(&root().join("src"))
        .iter()
        .filter(|file| **file != names)
        .flat_map(|file| found(file, "sr04_firmware"))
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Modules that may use files, sockets and the environment.
const SYSTEM: &[&str] = &["src/io", "src/commands"];

#[test]
fn the_system_is_touched_at_the_edges_only() {
    let broken: Vec<String> = rust_files(&root().join("src"))
        .iter()
        .filter(|file| {
            !SYSTEM
                .iter()
                .any(|edge| file.starts_with(root().join(edge)))
        })
        .flat_map(|file| {
            let words = [
                "std::fs",
                "std::env",
                "TcpStream",
                "TcpListener",
                "UdpSocket",
                "ToSocketAddrs",
                "UnixStream",
                "UnixListener",
            ];
            words.into_iter().flat_map(|word| found(file, word))
        })
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Places where a path or its last parts are imported or used.
fn found(file: &Path, word: &str) -> Vec<String> {
    paths(file)
        .into_iter()
        .filter(|(_, text)| text.split(' ').any(|path| names(path, word)))
        .map(|(number, _)| format!("{}:{number}: {word}", file.display()))
        .collect()
}

/// The paths that are imported or used, with their lines.
fn paths(file: &Path) -> Vec<(usize, String)> {
    let module = module_of(file);
    let code = code_lines(file);
    let imports = imports(&code)
        .into_iter()
        .map(|(number, path)| (number, absolute(&module, &path)));
    let named = code.into_iter().map(|(number, line)| {
        let spaced: String = line
            .chars()
            .map(|c| {
                if c == ':' || c == '_' || c.is_alphanumeric() {
                    c
                } else {
                    ' '
                }
            })
            .collect();
        (number, spaced)
    });
    imports.chain(named).collect()
}

/// Whether a path goes through another: `a::b::c` goes through `a::b`, `b` and `c`.
fn names(path: &str, word: &str) -> bool {
    format!("::{path}::").contains(&format!("::{word}::"))
}

#[test]
fn a_tree_of_imports_hides_nothing() {
    let code: Vec<(usize, String)> = (1..)
        .zip([
            "pub(crate) use crate::{io, view::{self, draw as paint}};",
            "use super::io::link;",
        ])
        .map(|(number, line)| (number, line.to_owned()))
        .collect();
    let paths: Vec<String> = imports(&code)
        .into_iter()
        .map(|(_, path)| absolute("crate::model", &path))
        .collect();
    let wanted = [
        "crate::io",
        "crate::view",
        "crate::view::draw",
        "crate::io::link",
    ];
    assert_eq!(paths, wanted);
    assert!(names("crate::io::link", "crate::io") && !names("crate::iota", "crate::io"));
}

/// All paths imported by `use` items, with the line of the item.
fn imports(code: &[(usize, String)]) -> Vec<(usize, String)> {
    let mut paths = Vec::new();
    let mut item: Option<(usize, String)> = None;
    for (number, line) in code {
        let text = line.trim();
        let begins = ["use ", "pub use ", "pub(crate) use ", "pub(super) use "]
            .iter()
            .find_map(|begin| text.strip_prefix(begin));
        match (&mut item, begins) {
            (Some((_, so_far)), _) => so_far.push_str(text),
            (None, Some(rest)) => item = Some((*number, rest.to_owned())),
            (None, None) => {}
        }
        if text.ends_with(';')
            && let Some((number, tree)) = item.take()
        {
            let tree: String = tree.trim_end_matches(';').to_owned();
            paths.extend(expand("", &tree).into_iter().map(|path| (number, path)));
        }
    }
    paths
}

/// The paths of an import tree: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn expand(before: &str, tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap_or(tree).trim();
        let path = format!("{before}{path}");
        return vec![path.trim_end_matches("::self").to_owned()];
    };
    let before = format!("{before}{}", &tree[..open]);
    let inside = &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())];
    let (mut depth, mut start, mut paths) = (0, 0, Vec::new());
    for (at, c) in inside.char_indices().chain([(inside.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !inside[start..at].trim().is_empty() {
                    paths.extend(expand(&before, &inside[start..at]));
                }
                start = at + 1;
            }
            _ => {}
        }
    }
    paths
}

/// `crate::model::link` for `src/model/link.rs`.
fn module_of(file: &Path) -> String {
    let file = file.with_extension("");
    let parts = file.iter().map(|part| part.to_string_lossy());
    let inside = parts.skip_while(|part| part != "src").skip(1);
    let named = inside.filter(|part| part != "mod" && part != "lib");
    ["crate".into()]
        .into_iter()
        .chain(named)
        .collect::<Vec<_>>()
        .join("::")
}

/// A path without `self` and `super`.
fn absolute(module: &str, path: &str) -> String {
    let (mut module, mut path) = (module.to_owned(), path);
    let mut is_relative = false;
    while let Some((head, rest)) = path.split_once("::") {
        match head {
            "super" => module.truncate(module.rfind("::").unwrap_or(module.len())),
            "self" => {}
            _ => break,
        }
        is_relative = true;
        path = rest;
    }
    if is_relative {
        format!("{module}::{path}")
    } else {
        path.to_owned()
    }
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
            if line.contains("::now()") || line.contains("::sleep(") {
                broken.push(format!("{}:{number}: {line}", file.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Tests with a device in real time, which pauses between its lines, so that nothing looks for a sleep of the test itself there.
const PACED: &[&str] = &["tests/kills.rs", "tests/own_lines.rs"];

#[test]
fn no_test_sleeps() {
    let tests = [
        "tests",
        "protocol/tests",
        "protocol/lines/tests",
        "firmware/tests",
        "firmware/sim/tests",
        "mapping/tests",
    ];
    let is_paced = |file: &Path| PACED.iter().any(|paced| file == root().join(paced));
    let [in_thread, in_task] = ["thread", "time"].map(|module| format!("{module}::sleep"));
    let offenders: Vec<String> = tests
        .iter()
        .flat_map(|folder| all_rust_files(&root().join(folder)))
        .filter(|file| !is_paced(file))
        .flat_map(|file| [found(&file, &in_thread), found(&file, &in_task)].concat())
        .collect();
    assert_eq!(offenders, [] as [String; 0]);
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The source files of a folder without modules of tests, or the single file.
fn rust_files(place: &Path) -> Vec<PathBuf> {
    let mut files = all_rust_files(place);
    files.retain(|path| !is_test_module(path));
    assert!(!files.is_empty(), "{}: no Rust", place.display());
    files
}

/// All source files of a folder, or the single file; a missing place fails, because its rule would check nothing.
fn all_rust_files(place: &Path) -> Vec<PathBuf> {
    if place.is_file() {
        return vec![place.to_owned()];
    }
    let mut files = Vec::new();
    let mut folders = vec![place.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder);
        for entry in entries.unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.unwrap().path();
            let is_rust = path.extension().is_some_and(|extension| extension == "rs");
            if path.is_dir() {
                folders.push(path);
            } else if is_rust {
                files.push(path);
            }
        }
    }
    assert!(!files.is_empty(), "{}: no Rust", place.display());
    files
}

/// Whether the module exists under `cfg(test)` only.
fn is_test_module(path: &Path) -> bool {
    path.file_name()
        .is_some_and(|name| name == "tests.rs" || name == "testing.rs")
        || path
            .parent()
            .is_some_and(|folder| folder.ends_with("tests"))
}

/// Lines of code with their numbers, without comments, up to the first `mod tests`.
fn code_lines(file: &Path) -> Vec<(usize, String)> {
    let text = fs::read_to_string(file).unwrap();
    (1..)
        .zip(text.lines())
        .take_while(|(_, line)| !line.starts_with("mod tests"))
        .filter(|(_, line)| !line.trim_start().starts_with("//"))
        // For tests on a host; linking for a microcontroller shows that nothing else uses it.
        .filter(|(_, line)| *line != "extern crate std;")
        .map(|(number, line)| (number, line.to_owned()))
        .collect()
}
