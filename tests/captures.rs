//! The recordings in `captures/` still say what they said when they were made.
#![expect(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use std::fs;
use std::path::{Path, PathBuf};

use groundwave::capture::Capture;
use groundwave::capture::info::Info;

fn captures() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "txt" || e == "mcap"))
        .collect();
    files.sort();
    files
}

#[test]
fn each_decodes_to_what_stands_beside_it() {
    let captures = captures();
    assert!(captures.len() >= 3, "{captures:?}");
    for path in captures {
        let info = Info::read(&mut Capture::open(&path).unwrap());
        let found = serde_json::to_string(&info).unwrap();
        let expected = fs::read_to_string(path.with_extension("info.json")).unwrap();
        assert_eq!(found, expected.trim_end(), "{}", path.display());
    }
}

#[test]
fn each_has_its_provenance() {
    let readme =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("captures/README.md"))
            .unwrap();
    for path in captures() {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(
            readme.contains(name),
            "captures/README.md says nothing of {name}"
        );
    }
}
