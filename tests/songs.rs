//! Songs as sound files: from captures by `songs`, from the simulator by `sim --wav`.
#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, scratch};
use groundwave::capture::{Existing, Recorder, Session};
use groundwave_protocol::telemetry::{Ack, Body, Line, Note, SONG_NOTES, SongLine, TextLine};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

fn line(sequence: u8, body: Body) -> [u8; 80] {
    let ack = Ack::default();
    Line {
        sequence,
        body,
        ack,
    }
    .encode()
}

fn stream(songs: &[Vec<Note>]) -> Vec<u8> {
    let text = Body::Text(TextLine::new("la"));
    let songs = songs
        .iter()
        .map(|notes| Body::Song(SongLine::new(notes.iter().copied())));
    (0..)
        .zip([text].into_iter().chain(songs))
        .flat_map(|(sequence, body)| line(sequence, body))
        .collect()
}

fn capture(folder: &Path, songs: &[Vec<Note>]) -> PathBuf {
    let path = folder.join("evening.txt");
    fs::write(&path, stream(songs)).unwrap();
    path
}

/// Checks that a WAV file holds exactly these notes (hertz, ticks), by counting rising zero crossings. One or two ticks
/// are too few to measure a frequency.
fn hears(path: &Path, notes: &[(u16, u32)]) {
    let mut reader = hound::WavReader::open(path).unwrap();
    let rate = reader.spec().sample_rate;
    let samples: Vec<i16> = reader.samples().map(Result::unwrap).collect();
    let sample_at = |ticks: u32| (ticks * rate / 20) as usize;
    let fade = rate as usize / 200;
    let mut begun = 0;
    for &(hz, ticks) in notes {
        let held = &samples[sample_at(begun) + fade..sample_at(begun + ticks)];
        begun += ticks;
        let rises: Vec<usize> = (1..held.len())
            .filter(|&n| held[n - 1] < 0 && held[n] >= 0)
            .collect();
        if hz == 0 {
            assert!(held.iter().all(|&sample| sample == 0), "no rest at {begun}");
        } else if ticks > 2 {
            let time_s = (rises[rises.len() - 1] - rises[0]) as f64 / f64::from(rate);
            let heard_hz = (rises.len() - 1) as f64 / time_s;
            let off = heard_hz / f64::from(hz) - 1.0;
            assert!(off.abs() < 0.01, "{heard_hz} for {hz} Hz");
        }
    }
    let more = samples.len() - sample_at(begun);
    assert!(more <= fade, "{more} samples too many");
}

/// The notes for [`hears`].
fn sung(notes: &[Note]) -> Vec<(u16, u32)> {
    notes
        .iter()
        .map(|note| (note.hz, u32::from(note.ticks)))
        .collect()
}

fn note(hz: u16, ticks: u8) -> Note {
    Note { hz, ticks }
}

#[test]
fn songs_of_a_capture_are_listed_and_saved() {
    let folder = scratch("songs");
    let songs = [
        vec![note(523, 4), note(0, 2), note(659, 8)],
        vec![note(440, 20)],
    ];
    let file = capture(&folder, &songs);
    let (file, wav) = (file.to_str().unwrap(), folder.join("made/here"));
    let arguments = ["songs", file, "--wav", wav.to_str().unwrap()];
    let (out, err) = expect(0, &arguments);
    assert_eq!(
        out,
        "01  at 0.7 s, 0.70 s long:  C5 0.20  - 0.10  E5 0.40\n02  at 1.0 s, 1.00 s long:  A4 1.00\n"
    );
    assert_eq!(err, "");
    for (number, notes) in (1..).zip(&songs) {
        hears(&wav.join(format!("song-{number:02}.wav")), &sung(notes));
    }
    let (_, err) = expect(2, &arguments);
    assert!(
        err.contains("song-01.wav exists") && err.contains("--force"),
        "{err}"
    );
    expect(0, &[&arguments[..], &["--force"]].concat());
    let (_, err) = expect(1, &["songs", file, "--wav", file]);
    assert!(err.contains("cannot write"), "{err}");
}

#[test]
fn random_songs_survive_a_capture() {
    let folder = scratch("any-song");
    let notes = prop::collection::vec(
        (prop_oneof![Just(0), 150u16..=4095], 3u8..=63).prop_map(|(hz, ticks)| note(hz, ticks)),
        1..=SONG_NOTES,
    );
    let mut runner = TestRunner::new(Config {
        cases: 10,
        failure_persistence: None,
        ..Config::default()
    });
    let result = runner.run(&notes, |notes| {
        let file = capture(&folder, std::slice::from_ref(&notes));
        let wav = folder.join("wav");
        expect(
            0,
            &[
                "songs",
                file.to_str().unwrap(),
                "--force",
                "--wav",
                wav.to_str().unwrap(),
            ],
        );
        hears(&wav.join("song-01.wav"), &sung(&notes));
        Ok(())
    });
    result.unwrap();
}

#[test]
fn songs_are_read_from_a_recording_and_a_pipe() {
    let folder = scratch("songs-mcap");
    let songs = [vec![note(880, 4)]];
    let path = folder.join("evening.mcap");
    let session = Session {
        link: "/dev/ttyUSB0".into(),
        start: SystemTime::UNIX_EPOCH,
        notes: [].into(),
        configuration: String::new(),
    };
    let mut recorder = Recorder::start(path.clone(), Existing::Refuse, &session).unwrap();
    let received = stream(&songs);
    let (before, song) = received.split_at(80);
    for (after, bytes) in [(Duration::ZERO, before), (Duration::from_secs(7), song)] {
        recorder.handle_rx(after, SystemTime::UNIX_EPOCH + after, bytes);
    }
    recorder.finish().unwrap();
    let (out, _) = expect(0, &["songs", path.to_str().unwrap()]);
    assert_eq!(out, "01  at 7.0 s, 0.20 s long:  A5 0.20\n");

    let file = capture(&folder, &songs);
    let piped = Command::new(GROUNDWAVE)
        .args(["songs", "-"])
        .stdin(fs::File::open(file).unwrap())
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    let out = String::from_utf8(piped.stdout).unwrap();
    assert_eq!(out, "01  at 0.7 s, 0.20 s long:  A5 0.20\n");
}

#[test]
fn capture_without_a_song_is_reported() {
    let folder = scratch("no-songs");
    let file = capture(&folder, &[]);
    let wav = folder.join("wav");
    let arguments = [
        "songs",
        file.to_str().unwrap(),
        "--wav",
        wav.to_str().unwrap(),
    ];
    let (out, err) = expect(0, &arguments);
    assert_eq!(out, "");
    assert!(err.contains("evening.txt: no song in 1 line"), "{err}");
    assert!(!wav.exists(), "a folder for nothing");
    fs::write(&file, "").unwrap();
    let (_, err) = expect(2, &arguments);
    assert!(err.contains("no line found in 0 bytes"), "{err}");
}

/// The robot finishes its route of one waypoint at once and plays a song; a signal ends the program.
#[test]
fn terminated_simulator_leaves_a_whole_sound_file() {
    let folder = scratch("sim-wav");
    let (wav, trace) = (folder.join("sim.wav"), folder.join("sim.csv"));
    let sim = Sim::start(&[
        "--listen",
        "127.0.0.1:0",
        "--wav",
        wav.to_str().unwrap(),
        "--trace",
        trace.to_str().unwrap(),
    ]);
    let mut watch = Telling::start(&["watch", &sim.path, "--headless", "--no-uplink"]);
    watch.wait_for("a line", |said| said["event"] == "line");
    expect(0, &["send", &sim.path, "goto", "0", "0", "--go"]);
    watch.wait_for("a song", |said| said["song"].is_string());
    sim.end();

    let table = fs::read_to_string(&trace).unwrap();
    let mut rows = table.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let column = head.iter().position(|name| *name == "note_hz").unwrap();
    let ticks: Vec<u16> = rows.map(|row| row[column].parse().unwrap()).collect();
    let notes: Vec<(u16, u32)> = ticks
        .chunk_by(|a, b| a == b)
        .map(|run| (run[0], run.len() as u32))
        .collect();
    assert!(notes.iter().any(|(hz, ticks)| *hz > 0 && *ticks > 2));
    hears(&wav, &notes);
}
