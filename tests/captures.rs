//! The recordings in `captures/` still decode as they did when they were recorded.

use std::fs;
use std::path::{Path, PathBuf};

use groundwave::capture::Capture;
use groundwave::capture::info::Info;
use sr04_sim::{ChannelSpec, Simulation, SimulationConfig, World};

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

/// Runs the commands of the table: the same robot in the same world sends the same bytes.
#[test]
fn raw_captures_come_again_byte_for_byte() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    let readme = fs::read_to_string(folder.join("README.md")).unwrap();
    let mut made = 0;
    for row in readme.lines().filter(|row| row.starts_with("| `")) {
        let (name, rest) = row[3..].split_once('`').unwrap();
        let Some((_, command)) = rest.split_once("capture -- ") else {
            continue;
        };
        let words: Vec<&str> = command.split('`').next().unwrap().split(' ').collect();
        let (&[world, seed, seconds], channel) = words.split_first_chunk().unwrap();
        let mut config = SimulationConfig::new(World::open(world).unwrap(), seed.parse().unwrap());
        config.robot_id = 4;
        config.channel = channel.concat().parse::<ChannelSpec>().unwrap();
        let mut simulation = Simulation::new(&config);
        simulation.run_for_ms(seconds.parse::<u64>().unwrap() * 1000);
        let bytes: Vec<u8> = std::iter::from_fn(|| simulation.poll_downlink()).collect();
        let kept = fs::read(folder.join(name)).unwrap();
        assert!(
            bytes == kept,
            "{name} is not what `{command}` gives; make it anew"
        );
        made += 1;
    }
    assert_eq!(made, 3);
}

/// The README's commands for the tools of 1998, on a capture with arbitrary bytes of a bad radio.
#[cfg(unix)]
#[test]
fn the_recipes_work_on_a_noisy_capture() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let mut tried = 0;
    for recipe in readme
        .lines()
        .filter(|line| line.trim().starts_with("LC_ALL=C "))
    {
        let command = recipe.split("  # ").next().unwrap();
        let command = command.replace(" file", " captures/house-noisy.txt");
        let output = std::process::Command::new("sh")
            .args(["-c", &command])
            .current_dir(root)
            .output()
            .unwrap();
        let lines: Vec<&[u8]> = output.stdout.split(|byte| *byte == b'\n').collect();
        assert!(lines.len() > 20, "{command}");
        assert_eq!(output.stderr, b"", "{command}");
        let is_whole = |line: &&[u8]| line.is_empty() || line[0] != b'B';
        assert!(lines.iter().all(is_whole), "{command}");
        tried += 1;
    }
    assert_eq!(tried, 2);
}
