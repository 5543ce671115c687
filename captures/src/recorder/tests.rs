use std::io::{self, PipeReader, Read};
use std::os::fd::OwnedFd;
use std::time::UNIX_EPOCH;

use super::*;

fn session() -> Session {
    Session {
        link: "sim".to_owned(),
        start: UNIX_EPOCH,
        notes: [].into(),
        configuration: String::new(),
    }
}

/// A recorder whose disk hangs as soon as the pipe is full.
fn stalled() -> (Recorder, PipeReader) {
    let (reader, pipe) = io::pipe().expect("a pipe");
    let file = File::from(OwnedFd::from(pipe));
    let recorder = Recorder::on(
        file,
        Path::new("pipe.mcap"),
        Existing::Refuse,
        &session(),
        Rotation::default(),
    );
    (recorder.expect("a pipe takes the beginning"), reader)
}

fn at(second: u64) -> (Moment, SystemTime) {
    let now = Duration::from_secs(second);
    (now, UNIX_EPOCH + now)
}

/// No call waits; the stall is reported after 30 s, and `finish` reports how many bytes are missing.
#[test]
fn a_disk_that_hangs_stalls_nothing_and_is_reported() {
    let (mut recorder, mut reader) = stalled();
    let line = [b'x'; 4096];
    for second in 0..100 {
        let (now, wall) = at(second);
        recorder.handle_rx(now, wall, &line);
        recorder.handle_tx(now, wall, b"\nstop\n");
    }
    assert!(recorder.unwritten_bytes() > 100 * 4096 - 65536);
    // The pipe takes some bytes first.
    let problem = (100..)
        .find_map(|second| {
            recorder.handle_timeout(at(second).0);
            recorder.problem()
        })
        .unwrap();
    assert!(problem.contains("nothing for 30 s"), "{problem}");
    let missing = recorder.unwritten_bytes();
    let error = recorder
        .finish_within(Duration::ZERO)
        .unwrap_err()
        .to_string();
    let told = error.split(" bytes are not in it").next().unwrap();
    let told: u64 = told.rsplit(' ').next().unwrap().parse().unwrap();
    // The pipe may have taken more meanwhile, up to its capacity.
    assert!(told <= missing && told + 65_536 >= missing, "{error}");
    // Recording continues when the disk does; no byte is lost.
    drop(recorder);
    let mut read = Vec::new();
    reader.read_to_end(&mut read).unwrap();
    assert!(read.len() > 100 * 4096, "{}", read.len());
}

/// The queue holds at most 16 MiB; further bytes are counted.
#[test]
fn overflow_is_bounded_and_reported() {
    let (mut recorder, reader) = stalled();
    let (now, wall) = at(0);
    let line = vec![b'x'; 1 << 20];
    while !recorder.has_failed() {
        recorder.handle_rx(now, wall, &line);
    }
    let bytes = recorder.unwritten_bytes();
    assert!(bytes < 64 << 20, "{bytes}");
    recorder.handle_rx(now, wall, &line);
    assert_eq!(recorder.unwritten_bytes(), bytes + (1 << 20));
    let problem = recorder.problem().unwrap();
    assert!(problem.contains("the file accepts no bytes"), "{problem}");
    drop(reader);
    assert!(recorder.finish().is_err());
}
