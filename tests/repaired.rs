//! Repaired lines A: they reach the ground's estimate and nothing else.

use std::fs;
use std::path::Path;
use std::time::Duration;

use groundwave::event::{CommandStatus, Event};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::arq::Config;
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::Body;
use sr04_sim::{Simulation, SimulationConfig, World};

use crate::common::owner;
use crate::programs::{expect, path_in, scratch};

const CLEAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");

/// Flips bits in every other line A.
fn damaged(bytes: &[u8], flips: &[(usize, u8)]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let lines = bytes.split_mut(|byte| *byte == b'\n');
    let of_state = lines.filter(|line| line.first() == Some(&b'A'));
    for line in of_state.skip(1).step_by(2) {
        for (column, bit) in flips {
            line[column - 1] ^= 1 << bit;
        }
    }
    bytes
}

/// What the program makes of a capture: its map, and then figures and tables.
fn outputs(folder: &Path, bytes: &[u8]) -> (Vec<u8>, [String; 3]) {
    let (capture, map) = (path_in(folder, "run.txt"), path_in(folder, "run.yaml"));
    fs::write(&capture, bytes).unwrap();
    expect(
        0,
        &["export", &capture, "--to", "map", "--force", "-o", &map],
    );
    let to = |form| expect(0, &["export", &capture, "--to", form, "-o", "-"]).0;
    let figures = expect(0, &["info", "--json", &capture]).0;
    let pixels = fs::read(folder.join("run.pgm")).unwrap();
    (pixels, [figures, to("csv"), to("jsonl")])
}

/// Two flipped bits are not repaired, so their figures are those of damaged lines.
#[test]
fn repaired_lines_are_on_the_map_and_damaged_in_every_figure() {
    let folder = scratch("repaired");
    let sent = fs::read(CLEAN).unwrap();
    let (whole, _) = outputs(&folder, &sent);
    let (repaired, figures) = outputs(&folder, &damaged(&sent, &[(7, 0)]));
    let (without, same_figures) = outputs(&folder, &damaged(&sent, &[(7, 0), (8, 1)]));
    assert!(repaired == whole, "the map has every line");
    assert!(without != whole, "half of the lines are missing");
    assert_eq!(figures, same_figures);
    fs::remove_dir_all(folder).unwrap();
}

/// One bit of each line is flipped, and each line K and G lost, from STOP on until the robot stands in a repaired line.
#[test]
fn repaired_line_proves_no_command() {
    let seed = 60_100;
    let house = SimulationConfig::new(World::built_in("house").unwrap(), seed);
    let mut simulation = Simulation::new(&house);
    let mut station = Station::new(Config::new(owner(seed)), true);
    let (mut line, mut stands, mut confirmed_ms) = (Vec::new(), None, None);
    for now_ms in 0..60_000_u64 {
        simulation.step();
        let now = Duration::from_millis(now_ms);
        if now_ms == 30_000 {
            station.handle_request(now, Request::Stop, None);
        }
        while let Some(byte) = simulation.poll_downlink() {
            line.push(byte);
            if byte != b'\n' {
                continue;
            }
            let is_damaged = now_ms >= 30_000 && stands.is_none();
            if is_damaged {
                line[6] ^= 1;
            }
            if !is_damaged || line.len() == LINE_BYTES {
                station.handle_bytes(now, &line);
            }
            line.clear();
        }
        station.handle_timeout(now);
        while let Some(bytes) = station.poll_transmit(now) {
            simulation.handle_uplink(&bytes);
        }
        while let Some(event) = station.poll_event() {
            match event {
                Event::Repaired(line) => {
                    assert_eq!(confirmed_ms, None, "before {now_ms} ms");
                    let Body::State(state) = line.body else {
                        panic!("{line:?}");
                    };
                    if state.mode == Mode::Stop {
                        stands.get_or_insert(now_ms);
                    }
                }
                Event::Command {
                    status: CommandStatus::Confirmed { .. },
                    ..
                } => confirmed_ms = Some(now_ms),
                _ => {}
            }
        }
    }
    let stands = stands.expect("a repaired line that shows STOP");
    let confirmed_ms = confirmed_ms.expect("an intact line that proves STOP");
    assert!(confirmed_ms > stands, "{confirmed_ms} and {stands} ms");
}
