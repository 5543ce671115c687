//! Constructed streams, with statistics computed by hand.

use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Command, Drive, Frame, Key, Message, Open, Order, Slots};
use groundwave_protocol::decoder::Decoder;
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::{Ack, Body, Line, TextLine};

use super::*;

const KEY: Key = Key::session(7, 1, 1, 677);

fn at_ms(ms: u64) -> Moment {
    Moment::from_millis(ms)
}

fn line(sequence: u8) -> [u8; 80] {
    let line = Line {
        sequence,
        body: Body::Text(TextLine::new("a line")),
        ack: Ack::default(),
    };
    line.encode()
}

fn command(sequence: u8) -> Frame {
    let order = Order::Mode(Mode::Prowl);
    Message::Command(Command { sequence, order }).encode(KEY)
}

fn waypoints(tag: u8, first_block: u8, count: usize) -> Frame {
    let waypoints = vec![Waypoint::default(); count];
    Message::Waypoints(Slots::new(tag, first_block, &waypoints)).encode(KEY)
}

fn hear(meter: &mut LinkMeter, decoder: &mut Decoder, now: Moment, mut bytes: &[u8]) {
    meter.take_received(now, bytes.len());
    while decoder.next_own_line(&mut bytes).is_some() {
        meter.take_line(decoder.counters());
    }
}

#[test]
fn a_damaged_stream_has_the_figures_computed_by_hand() {
    let (mut meter, mut decoder) = (LinkMeter::default(), Decoder::default());
    let mut stream = Vec::new();
    // Half a line before the first is not an error, but its line feed counts as rejected.
    stream.extend_from_slice(&line(9)[40..]);
    stream.extend_from_slice(&line(10));
    // 1: a wrong letter costs the line, 80 bytes.
    let mut wrong = line(11);
    wrong[10] ^= 1;
    stream.extend_from_slice(&wrong);
    stream.extend_from_slice(&line(12));
    // 2: a line cut in the middle, and 20 bytes of noise with a line feed: 30 + 20.
    stream.extend_from_slice(&line(13)[..30]);
    stream.extend_from_slice(&[b'~'; 19]);
    stream.push(b'\n');
    stream.extend_from_slice(&line(14));
    // 3: two missing lines cost no bytes; three bytes of noise do.
    stream.extend_from_slice(b"~~~");
    stream.extend_from_slice(&line(17));
    hear(&mut meter, &mut decoder, at_ms(3000), &stream);
    let seen = meter.statistics(at_ms(3000), decoder.counters());
    // Lines 11 and 13 are damaged, not lost, as 15 and 16 are.
    assert_eq!((seen.lines, seen.loss.lines_lost), (4, 2));
    assert!((seen.loss.loss_pct - 25.0).abs() < 1e-9);
    assert_eq!(seen.damaged.kinds(), [1, 2, 0]);
    assert_eq!(seen.damaged.types_words(), "T 1, ? 2");
    let resync = Resync {
        count: 3,
        last_bytes: 3,
        mean_bytes: (80 + 50 + 3) as f64 / 3.0,
        worst_bytes: 80,
    };
    assert_eq!(seen.resync, Some(resync));
}

#[test]
fn bytes_during_the_search_for_a_link_are_not_errors() {
    let (mut meter, mut decoder) = (LinkMeter::default(), Decoder::default());
    hear(&mut meter, &mut decoder, at_ms(0), &line(1));
    hear(&mut meter, &mut decoder, at_ms(10), &line(2)[..50]);
    decoder.interrupt();
    meter.interrupt();
    hear(&mut meter, &mut decoder, at_ms(5000), &line(20)[30..]);
    hear(&mut meter, &mut decoder, at_ms(5300), &line(21));
    let seen = meter.statistics(at_ms(5300), decoder.counters());
    assert_eq!((seen.lines, seen.resync), (2, None));
}

#[test]
fn repeated_frames_are_distinguished_from_new_ones() {
    let open = |replaces| {
        let (boot, owner) = (1, 677);
        let open = Open {
            boot,
            replaces,
            owner,
            era: None,
        };
        Message::Open(open).encode(Key::robot(7))
    };
    let stop = Message::Stop(None).encode(Key::robot(7));
    let drive = Message::Drive(Drive {
        velocity_in_s: 5,
        rotation_in_s: 0,
        heard: 3,
        count: 1,
    });
    let story: [(u64, Frame, bool); 15] = [
        (0, open(0), false),
        (2000, open(0), true),
        (2100, command(1), false),
        (2500, command(1), true),
        (2600, command(2), false),
        (3000, waypoints(1, 0, 16), false),
        (3400, waypoints(1, 4, 16), false),
        (3800, waypoints(1, 2, 8), true),
        (4000, waypoints(1, 8, 3), false),
        (4200, waypoints(2, 0, 8), false),
        (5000, stop, false),
        (5300, stop, true),
        (9000, stop, false),
        (9500, open(2), false),
        (9600, waypoints(2, 0, 8), false),
    ];
    let mut uplink = Uplink::default();
    let mut bytes = 0;
    for (ms, frame, is_again) in story {
        let before = (uplink.frames(), uplink.frames_again());
        // Byte by byte, as a pacer delivers them.
        for byte in frame.as_bytes() {
            uplink.take(at_ms(ms), &[*byte]);
        }
        let after = (before.0 + 1, before.1 + u64::from(is_again));
        assert_eq!((uplink.frames(), uplink.frames_again()), after, "{frame:?}");
        bytes += frame.as_bytes().len() as u64;
    }
    // Hand drive, a knock and half a frame do not count.
    let drive = drive.encode(KEY);
    for others in [
        drive.as_bytes(),
        drive.as_bytes(),
        b"\n",
        b"\nC!M\n",
        &[b'W'; 500],
    ] {
        uplink.take(at_ms(10_000), others);
        bytes += others.len() as u64;
    }
    assert_eq!((uplink.frames(), uplink.frames_again()), (15, 4));
    assert_eq!(uplink.bytes(), bytes);
}

#[test]
fn time_to_confirmation_counts_from_the_queueing() {
    let mut meter = LinkMeter::default();
    for (id, at) in [(1, 0), (2, 100), (3, 200)] {
        meter.take_asked(at_ms(at), CommandId(id));
    }
    meter.take_end(at_ms(500), CommandId(1), true);
    meter.take_end(at_ms(900), CommandId(2), false);
    meter.take_end(at_ms(1200), CommandId(3), true);
    meter.take_end(at_ms(1300), CommandId(3), true);
    let Some(confirmation) = meter
        .statistics(at_ms(2000), &Counters::default())
        .confirmation
    else {
        panic!("two are confirmed");
    };
    assert_eq!(confirmation.count, 2);
    for (found, by_pencil) in [
        (confirmation.last_s, 1.0),
        (confirmation.mean_s, 0.75),
        (confirmation.worst_s, 1.0),
    ] {
        assert!((found - by_pencil).abs() < 1e-9, "{confirmation:?}");
    }
}

#[test]
fn airtime_is_of_the_latest_twenty_seconds() {
    let mut meter = LinkMeter::default();
    let counters = Counters::default();
    let share = |meter: &LinkMeter, s| {
        let seen = meter.statistics(Moment::from_secs(s), &counters);
        (
            seen.airtime_down_pct.unwrap().round() as u32,
            seen.airtime_up_pct.unwrap().round() as u32,
        )
    };
    assert_eq!(share(&meter, 5), (0, 0));
    for second in 10..20 {
        meter.take_received(Moment::from_secs(second), 240);
    }
    meter.take_sent(Moment::from_secs(18), &[b'\n'; 24]);
    // 2400 bytes in the 11 s since the first began to pass; 24 in 2.1 s.
    assert_eq!(share(&meter, 20), (91, 5));
    // The window begins at 15; the bytes reported from 16 to 19 were in the air in it.
    assert_eq!(share(&meter, 35), (20, 1));
    assert_eq!(share(&meter, 60), (0, 0));
}

/// The robot sends 240 bytes per second: the full rate of 2400 baud, a quarter of 9600 baud, and more than 1200 and 2000 baud carry.
#[test]
fn airtime_is_of_the_radios_rate() {
    for (baud, bytes_per_s, expected_pct) in [
        (1200, 240, None),
        (2000, 240, None),
        (1200, 120, Some(100.0)),
        (1200, 60, Some(50.0)),
        (2400, 240, Some(100.0)),
        (9600, 240, Some(25.0)),
        (115_200, 240, Some(100.0 * 2400.0 / 115_200.0)),
    ] {
        let mut meter = LinkMeter::default();
        meter.set_baud(baud);
        for tenth in 0..600 {
            meter.take_received(at_ms(tenth * 100), bytes_per_s / 10);
        }
        let seen = meter.statistics(Moment::from_mins(1), &Counters::default());
        let pct = seen.airtime_down_pct;
        assert_eq!(pct.is_some(), expected_pct.is_some(), "{baud}: {pct:?}");
        let error_pct = pct.zip(expected_pct).map_or(0.0, |(a, b)| a - b);
        assert!(error_pct.abs() < 1.5, "{baud}: {pct:?}");
        assert_eq!(seen.airtime_up_pct.is_some(), pct.is_some());
    }
}

/// After a quiet hour, ten times as many bytes come as the rate carries.
#[test]
fn airtime_is_unknown_while_more_bytes_come_than_the_rate_carries() {
    let mut meter = LinkMeter::default();
    let mut take = |seconds: std::ops::Range<u64>, bytes| {
        let mut pct = None;
        for second in seconds {
            meter.take_received(Moment::from_secs(second), bytes);
            let seen = meter.statistics(Moment::from_secs(second), &Counters::default());
            pct = seen.airtime_down_pct;
        }
        pct
    };
    assert_eq!(take(0..3600, 24).map(f64::round), Some(10.0));
    assert_eq!(take(3600..3620, 2400), None);
    assert_eq!(take(3620..3660, 24).map(f64::round), Some(10.0));
}

/// A reader delivers whole lines: the first one was in the air for a third of a second before.
#[test]
fn a_full_radio_is_in_use_all_the_time_and_no_more() {
    let mut meter = LinkMeter::default();
    let counters = Counters::default();
    let airtime = |meter: &LinkMeter, ms| {
        let seen = meter.statistics(at_ms(ms), &counters);
        seen.airtime_down_pct.unwrap()
    };
    for line in 1..200_u64 {
        // Sometimes delayed, and never faster than the radio.
        let at = line * 1000 / 3 + [0, 0, 150, 0][line as usize % 4];
        meter.take_received(at_ms(at), 80);
        let share_pct = airtime(&meter, at);
        assert!((0.0..=100.0).contains(&share_pct), "{share_pct} at {at} ms");
        assert!(line < 6 || share_pct > 90.0, "{share_pct} at {at} ms");
    }
    // They waited somewhere for a minute.
    meter.take_received(at_ms(130_000), 240 * 63);
    assert!((airtime(&meter, 130_000) - 100.0).abs() < 1e-9);
}

#[test]
fn memory_does_not_grow() {
    let mut meter = LinkMeter::default();
    for second in 0..100_000_u32 {
        let now = Moment::from_secs(second.into());
        meter.take_received(now, 200);
        meter.take_sent(now, &[b'W'; 100]);
        meter.take_asked(now, CommandId(second));
    }
    let size = format!("{meter:?}").len();
    assert!(size < 8000, "{size} characters to print");
}
