use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use super::*;
use crate::index::{self, Piece, SeekableReader};

/// A reader that returns a few bytes at a time.
struct Trickle<'a>(&'a [u8], usize);

impl Read for Trickle<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        self.0
            .take(self.1 as u64)
            .read(to)
            .inspect(|&n| self.0 = &self.0[n..])
    }
}

/// Times, bytes of the radio and bytes of the file, piece by piece.
fn pieces(source: impl Read) -> Vec<(Moment, Vec<u8>, Vec<u8>)> {
    let mut reader = TextReader::new(source);
    let mut pieces = Vec::new();
    while let Some(piece) = reader.next_piece().unwrap() {
        pieces.push((piece.at, piece.radio.to_vec(), piece.stored.to_vec()));
    }
    pieces
}

/// The pieces that a seekable reader returns.
fn played(tape: &mut dyn SeekableReader) -> Vec<(Moment, Vec<u8>)> {
    let mut pieces = Vec::new();
    while let Some(at) = tape.next_at() {
        match tape.next_piece() {
            Some(Piece::Received(bytes)) => pieces.push((at, bytes.to_vec())),
            other => panic!("{other:?}"),
        }
    }
    pieces
}

fn tape(bytes: &[u8]) -> Box<dyn SeekableReader + Send> {
    index::read(Arc::new(bytes.to_vec()), Path::new("text")).unwrap()
}

fn capture(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::read(folder.join(name)).unwrap()
}

/// A capture in the style of another program.
fn stored(plain: &[u8], stamp: impl Fn(usize) -> String, end: &[u8]) -> Vec<u8> {
    let mut stored = Vec::new();
    for (n, line) in plain.split_inclusive(|&byte| byte == b'\n').enumerate() {
        stored.extend(stamp(n).as_bytes());
        match line.strip_suffix(b"\r\n") {
            Some(line) => stored.extend([line, end].concat()),
            None => stored.extend(line),
        }
    }
    stored
}

/// A time of day without a date.
fn day_stamp(n: usize) -> String {
    let s = 86_395 + n / 3;
    format!("{:02}:{:02}:{:02} ", s / 3600 % 24, s / 60 % 60, s % 60)
}

fn every_way_to_store(plain: &[u8]) -> Vec<Vec<u8>> {
    let none = |_: usize| String::new();
    let unix = |n: usize| format!("[{}.{:03}] ", 1_763_758_008 + n / 3, n % 3 * 333);
    let mut ways = Vec::new();
    for end in [&b"\r\n"[..], b"\n", b"\r\r\n"] {
        ways.push(stored(plain, none, end));
        ways.push(stored(plain, unix, end));
        ways.push(stored(plain, day_stamp, end));
    }
    ways
}

#[test]
fn pieces_do_not_depend_on_how_the_bytes_arrive() {
    let mut stream = b"noise\n\n".to_vec();
    stream.extend([b'x'; 200]);
    stream.extend(b"\r\nrest");
    let whole = pieces(&stream[..]);
    assert_eq!(
        whole
            .iter()
            .flat_map(|piece| piece.1.clone())
            .collect::<Vec<_>>(),
        stream
    );
    assert_eq!(whole[0].1, b"noise\n\n");
    assert_eq!(whole.last().unwrap().1, b"rest");
    for step in [1, 2, 3, 7, 79, 80, 81] {
        assert_eq!(
            pieces(Trickle(&stream, step)),
            whole,
            "{step} bytes at a time"
        );
    }
}

#[test]
fn three_lines_take_a_second() {
    let stream = [b'.'; 481];
    let at: Vec<_> = pieces(&stream[..])
        .into_iter()
        .map(|piece| piece.0)
        .collect();
    assert_eq!(at[2], Moment::from_secs(1));
    assert_eq!(at[5], Moment::from_secs(2));
    assert!(at.is_sorted());
}

/// Sequential and seekable readers return the same lines, times and radio bytes for every style.
#[test]
fn everybody_gets_what_the_radio_delivered() {
    for name in ["house-clean.txt", "house-noisy.txt"] {
        let plain = capture(name);
        for (way, stored) in every_way_to_store(&plain).into_iter().enumerate() {
            let whole = pieces(&stored[..]);
            for step in [1, 97, 4096] {
                assert!(pieces(Trickle(&stored, step)) == whole, "{name}, way {way}");
            }
            let file: Vec<u8> = whole.iter().flat_map(|piece| piece.2.clone()).collect();
            assert!(file == stored, "{name}, way {way}");
            let radio: Vec<u8> = whole.iter().flat_map(|piece| piece.1.clone()).collect();
            let long_lines = |bytes| {
                let mut decoder = Decoder::default();
                decoder.lines(bytes).for_each(drop);
                decoder.counters().lines
            };
            assert_eq!(long_lines(&radio), long_lines(&plain), "{name}, way {way}");
            if name == "house-clean.txt" {
                assert!(radio == plain, "way {way}");
            }
            let from_anywhere = played(&mut *tape(&stored));
            let from_front: Vec<_> = whole.into_iter().map(|piece| (piece.0, piece.1)).collect();
            assert!(from_anywhere == from_front, "{name}, way {way}");
        }
    }
}

/// A damaged first line does not change the style.
#[test]
fn one_line_that_is_stored_otherwise_decides_nothing() {
    let plain = capture("house-clean.txt");
    for spoilt in [
        [&plain[..78], b"\n", &plain[80..]].concat(),
        [&plain[..78], b"\r\r\n", &plain[80..]].concat(),
        [b"12.5 ", &plain[..]].concat(),
        [&plain[..78], b"\n"].concat(),
    ] {
        let radio: Vec<u8> = pieces(&spoilt[..])
            .into_iter()
            .flat_map(|piece| piece.1)
            .collect();
        assert!(radio == spoilt);
    }
}

#[test]
fn file_without_an_intact_line_is_left_as_it_is() {
    for noise in [
        &b"12:00:00 x\n12:00:01 y\n"[..],
        b"12.5 A00 x\n",
        b"x\r\r\n",
        b"\n",
        b"",
    ] {
        assert_eq!(Style::of(noise), None);
        let radio: Vec<u8> = pieces(noise)
            .into_iter()
            .flat_map(|piece| piece.1)
            .collect();
        assert_eq!(radio, noise);
    }
}

/// Without a date, days are counted, even after a seek past the unread part.
#[test]
fn a_clock_without_a_date_is_followed_over_days() {
    let plain = capture("house-clean.txt").repeat(30);
    // A line every minute: a week.
    let stamp = |n: usize| {
        let min = 600 + n;
        format!("{:02}:{:02}:00 ", min / 60 % 24, min % 60)
    };
    let stored = stored(&plain, stamp, b"\r\n");
    let whole = pieces(&stored[..]);
    let last = whole.last().unwrap().0;
    let lines = stored.split_inclusive(|&byte| byte == b'\n').count() as u64;
    assert_eq!(last, Moment::from_mins(lines - 1));
    let mut tape = tape(&stored);
    assert_eq!(tape.length(), last + Moment::from_secs(1));
    for part in 1..40 {
        let at = last / 40 * part;
        let place = tape.find(at);
        tape.seek(place);
        let next = tape.next_at().unwrap();
        assert!(
            next < at && at <= next + Moment::from_mins(2),
            "{at:?}: {next:?}"
        );
        let rest = played(&mut *tape);
        assert!(
            rest[..]
                == whole
                    .iter()
                    .map(|it| (it.0, it.1.clone()))
                    .collect::<Vec<_>>()[whole.len() - rest.len()..]
        );
    }
}

/// Robots of various rates, such as twenty lines per second: playback follows the clock in lines C, not the transmission time
/// at 2400 baud.
#[test]
fn text_without_times_plays_as_fast_as_the_robot_spoke() {
    let plain = capture("house-clean.txt");
    let at_rate = |tenths: u32| -> Vec<u8> {
        Decoder::default()
            .lines(&plain)
            .filter_map(|received| match received {
                Received::Line(mut line, _) => {
                    if let Body::Counters(counters) = &mut line.body {
                        counters.uptime_s = counters.uptime_s * 10 / tenths;
                    }
                    Some(line.encode())
                }
                Received::Ack(_) => None,
            })
            .flatten()
            .collect()
    };
    let end = |stored: &[u8]| pieces(stored).last().unwrap().0.as_secs_f64();
    let fast = at_rate(60);
    // Also for a small difference, if it exceeds the error of the clock.
    for tenths in [60, 40, 13, 12, 10, 8, 5] {
        let ratio = end(&plain) / end(&at_rate(tenths));
        let expected = f64::from(tenths) / 10.0;
        assert!((ratio / expected - 1.0).abs() < 0.05, "{tenths}: {ratio}");
        // Lost lines take no time in such a text, and do not change its rate.
        let lossy = |stored: &[u8]| -> Vec<u8> {
            let lines = stored.chunks_exact(LINE_BYTES).enumerate();
            let heard = lines.filter(|(n, _)| n * n % 7 != 2 && n % 5 != 1);
            heard.flat_map(|(_, line)| line).copied().collect()
        };
        let ratio = end(&lossy(&at_rate(10))) / end(&lossy(&at_rate(tenths)));
        assert!(
            (ratio / expected - 1.0).abs() < 0.05,
            "lossy, {tenths}: {ratio}"
        );
    }
    let played = played(&mut *tape(&fast)).last().unwrap().0.as_secs_f64();
    assert!((played - end(&fast)).abs() < 0.001);
}

/// A flood of line feeds does not make a piece of each byte. The robot's lines keep their pieces, however the bytes arrive.
#[test]
fn short_lines_are_joined() {
    let sample = include_str!("../../house-clean.txt");
    let line = sample.split_inclusive('\n').next().unwrap();
    let bare = line.replace("\r\n", "\n");
    let stamped = format!("12:00:01 {line}");
    let flood = "\n".repeat(140);
    let feeds = [14; 10];
    let cases = [
        (
            format!("{line}{flood}{line}a\r\nb\r\n{line}\r\n"),
            [&[80], &feeds[..], &[80, 6, 80, 2]].concat(),
            format!("{line}{flood}{line}a\r\nb\r\n{line}\r\n"),
        ),
        (
            format!("{bare}{bare}{bare}{flood}{bare}a\nb\n{bare}"),
            [&[79, 79, 79], &feeds[..], &[79, 4, 79]].concat(),
            format!(
                "{line}{line}{line}{}{line}a\r\nb\r\n{line}",
                "\r\n".repeat(140)
            ),
        ),
        (
            format!("{stamped}{stamped}{stamped}{flood}{stamped}"),
            [&[89, 89, 89], &feeds[..], &[89]].concat(),
            format!("{line}{line}{line}{flood}{line}"),
        ),
    ];
    for (text, lengths, radio) in cases {
        for at_once in [1, 7, 80, text.len()] {
            let pieces = pieces(Trickle(text.as_bytes(), at_once));
            let stored: Vec<usize> = pieces.iter().map(|(_, _, stored)| stored.len()).collect();
            assert_eq!(stored, lengths, "{at_once} bytes at once");
            let received: Vec<u8> = pieces.into_iter().flat_map(|(_, radio, _)| radio).collect();
            assert_eq!(received, radio.as_bytes());
        }
    }
}

/// The sequence does not show two hundred lost lines; only the robot's clock does.
#[test]
fn an_outage_does_not_slow_text_without_times() {
    let plain = capture("house-clean.txt");
    let lines = plain.chunks_exact(LINE_BYTES).enumerate();
    let received = lines.filter(|(n, _)| !(100..300).contains(n));
    let received: Vec<u8> = received.flat_map(|(_, line)| line.to_vec()).collect();
    let (end, ..) = pieces(&received[..]).pop().unwrap();
    assert_eq!(end, on_the_wire(received.len() as u64));
}

/// Noise after the last line with a timestamp does not hide the length.
#[test]
fn length_is_found_before_noise() {
    let plain = capture("house-clean.txt");
    let stored = stored(
        &plain,
        |n| format!("20:{:02}:{:02} ", n / 60, n % 60),
        b"\r\n",
    );
    let length = tape(&stored).length();
    // With some lengths, a part that is searched begins within the last timestamp.
    for noise in (4050..4110).chain([5000, 2 << 20]) {
        let bytes = [&stored[..], &vec![b'x'; noise]].concat();
        assert_eq!(tape(&bytes).length(), length, "{noise}");
    }
}

/// A robot's own lines, which no checksum shows, may have timestamps, too; a row of numbers has none.
#[test]
fn timestamps_before_a_robots_own_lines_are_read() {
    let dated = [
        "2026-03-14T09:00:00Z",
        "2026-03-14T09:00:01Z",
        "2026-03-14T09:00:02Z",
    ];
    let of_day = ["20:46:48.100", "20:46:49.100", "20:46:50.100"];
    let seconds = ["1.50", "2.50", "3.50"];
    for (stamps, between, line, has_time) in [
        (dated, " ", "temp: 1", true),
        (dated, ",", "temp:1,volt:11.5", true),
        (dated, ",", "20.5,3", true),
        (dated, ", ", "205,3", true),
        (dated, ",", "21", true),
        (dated.map(|it| it.trim_end_matches('Z')), ",", "21,3", true),
        (
            [
                "2026-03-14T09:00:00.5+01:00",
                "2026-03-14T09:00:01.5+01:00",
                "2026-03-14T09:00:02.5+01:00",
            ],
            ",",
            "21",
            true,
        ),
        (of_day, " -> ", "12,13", true),
        (of_day, " > ", "temp: 1", true),
        (of_day, ",", "123,4", true),
        (of_day, " ", ">temp:1", true),
        (seconds, " ", "temp: 1", true),
        (seconds, " ", "{\"temp\":1}", true),
        (["[1.50]", "[2.50]", "[3.50]"], " ", "20.5 3", true),
        (seconds, " -> ", "20.5 3", true),
        (seconds, " ", "20.5", false),
        (seconds, ",", "2.5", false),
        (["3.50", "2.50", "1.50"], " ", "temp: 1", false),
        (["1.50", "temp: 1", "3.50"], " ", "temp: 1", false),
        (["", "", ""], "", "temp: 1", false),
    ] {
        let text = stamps
            .map(|stamp| [stamp, between, line, "\n"].concat())
            .concat();
        let mut reader = TextReader::new(text.as_bytes());
        let mut latest = Moment::ZERO;
        let mut radio = Vec::new();
        while let Some(piece) = reader.next_piece().unwrap() {
            radio.extend_from_slice(piece.radio);
            latest = piece.at;
        }
        assert_eq!(reader.style().unwrap().is_stamped(), has_time, "{text}");
        if has_time {
            assert_eq!(latest, Moment::from_secs(2), "{text}");
            let lines = format!("{line}\n").repeat(3);
            assert_eq!(String::from_utf8(radio).unwrap(), lines);
        } else {
            assert_eq!(String::from_utf8(radio).unwrap(), text);
        }
    }
}
