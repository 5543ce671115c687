//! Captures of all kinds: with timestamps of other programs, damaged, empty.

use super::*;

/// Text with timestamps shows the same robot at the times of its timestamps.
#[test]
fn stamped_text_is_played_at_its_own_times() {
    let plain = std::fs::read(groundwave_captures::samples().join("house-clean.txt"));
    let plain = plain.unwrap();
    let mut stamped = Vec::new();
    for (n, line) in plain.split_inclusive(|&byte| byte == b'\n').enumerate() {
        // A robot switched off for an hour in the middle.
        let second = n / 3 + if n > 150 { 3600 } else { 0 };
        let (h, m, s) = (22 + second / 3600, second / 60 % 60, second % 60);
        let stamp = format!("2026-11-21T{h:02}:{m:02}:{s:02}Z ");
        stamped.extend(stamp.as_bytes());
        stamped.extend(line);
    }
    let reader = text(&stamped);
    assert_eq!(reader.unix(), Some(Moment::from_hours(498_694)));
    let length = reader.length();
    let (mut timeline, end) = read_whole(reader);
    assert!(
        end <= length && end > Moment::from_hours(1),
        "{end:?} of {length:?}"
    );
    let (mut untimed, plain_end) = read_whole(text(&plain));
    timeline.seek(end);
    untimed.seek(plain_end);
    assert_eq!(
        timeline.facts().tally().lines,
        untimed.facts().tally().lines
    );
    // During the pause the link is silent.
    timeline.seek(Moment::from_mins(30));
    let silent = timeline.facts().tally().lines;
    assert_eq!(
        timeline.at().as_secs(),
        55,
        "five seconds after the last line it is told"
    );
    timeline.seek(Moment::from_mins(50));
    assert_eq!(timeline.facts().tally().lines, silent);
    // Lines with the same timestamp are spaced by their transmission time.
    assert!(matches!(timeline.seek_line(20, STEPS_MAX), Found::At(_)));
    let times: Vec<Moment> = (0..6)
        .map(|_| {
            assert!(timeline.step_forward().is_there());
            timeline.at()
        })
        .collect();
    assert!(times.is_sorted_by(|a, b| a < b), "{times:?}");
    // Seeks by time without reading the whole file.
    for s in [0, 1, 30, 49, 50, 51, 2000, 3650, 3700] {
        let at = Moment::from_secs(s);
        let place = text(&stamped).find(at);
        let mut reader = text(&stamped);
        reader.seek(place);
        let next = reader.next_at().unwrap();
        assert!(next < at || s == 0, "{s}: {next:?}");
        while reader.next_at().is_some_and(|next| next < at) {
            let from = reader.next_at().unwrap();
            reader.next_piece();
            let next = reader.next_at().unwrap_or(Moment::MAX);
            assert!(
                from + Moment::from_secs(1) >= next.min(at) || s >= 2000,
                "{s}"
            );
        }
    }
}

#[test]
fn damaged_capture_is_shown_up_to_the_damage_with_the_reason() {
    let path = groundwave_captures::samples().join("demo-commands.mcap");
    let whole = std::fs::read(path).unwrap();
    let lines = |bytes: &[u8]| {
        let reader = index::read(Arc::new(bytes.to_vec()), Path::new("x.mcap"));
        let reader = reader.map_err(|error| error.to_string())?;
        let (mut timeline, end) = read_whole(reader);
        timeline.seek(end);
        let tally = timeline.facts().tally();
        let log: Vec<String> = timeline
            .facts()
            .log
            .newest_first()
            .map(|e| e.text.clone())
            .collect();
        assert!(
            log.iter().any(|text| text.contains("session is over")),
            "{log:?}"
        );
        Ok::<_, String>((tally.lines, tally.alarms, log))
    };
    let (all, alarms, _) = lines(&whole).unwrap();
    let mut rng = 7_usize;
    let (mut opened, mut before) = (0, 0);
    for n in 0..120 {
        rng = rng
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let at = (rng >> 33) % whole.len();
        match lines(&whole[..at]) {
            Ok((some, _, log)) => {
                opened += 1;
                before += some;
                assert!(some <= all);
                let says = log.iter().any(|text| text.contains("interrupted"));
                assert!(says || some == all, "cut at {at}: {some} of {all} lines");
            }
            Err(error) => assert!(error.contains("x.mcap"), "{error}"),
        }
        let mut flipped = whole.clone();
        flipped[at] ^= 1 << (n % 8);
        if let Ok((some, told, log)) = lines(&flipped) {
            assert!(some <= all, "flipped at {at}");
            assert!(
                some == all || told > alarms,
                "flipped at {at}: {some} of {all}: {log:?}"
            );
        }
    }
    assert!(opened > 60 && before > 0, "{opened} opened, {before} lines");
}

#[test]
fn an_empty_capture_ends_at_once() {
    let (mut timeline, end) = read_whole(text(b""));
    timeline.seek(end);
    assert_eq!(end, Moment::ZERO);
    assert!(!timeline.step_forward().is_there() && !timeline.step_back().is_there());
}
