//! Lines are equal after writing and reading; invalid ones get an error.

use groundwave_protocol::telemetry::{Outcome, ParameterLine, ParameterName, Printable};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::*;
use crate::event::{CommandStatus, Failure};
use crate::request::testing::samples;
use crate::share::LINE_MAX;

#[test]
fn every_request_comes_back_as_it_was() {
    for request in samples() {
        let ask = ClientLine::Ask(Ask {
            tag: 7,
            request,
            timeout: Duration::from_millis(1500),
        });
        let line = ask.to_line();
        assert!(line.len() <= LINE_MAX / 2, "{} bytes", line.len());
        assert_eq!(ClientLine::parse(&line), Ok(ask));
    }
    let hello = |raw| ClientLine::Hello {
        pid: Some(1234),
        raw,
    };
    let drive = ClientLine::Drive {
        velocity_in_s: 12,
        rotation_in_s: -31,
    };
    let answer = |answer| ClientLine::Answer {
        alarm: "battery_low".to_owned(),
        answer,
    };
    for line in [
        hello(false),
        hello(true),
        ClientLine::Cancel(7),
        drive,
        answer(Answer::Acknowledged),
        answer(Answer::Shelved(600)),
        answer(Answer::Unshelved),
    ] {
        assert_eq!(ClientLine::parse(&line.to_line()), Ok(line));
    }
    for (line, problem) in [
        (r#"{"alarm":"battery_low"}"#, CodecError::Shape),
        (
            r#"{"alarm":"battery_low","answer":"acknowledged","cancel":7}"#,
            CodecError::Shape,
        ),
        (
            r#"{"alarm":"battery_low","answer":{"shelved_s":86401}}"#,
            CodecError::Shelf,
        ),
    ] {
        assert_eq!(ClientLine::parse(line.as_bytes()), Err(problem), "{line}");
    }
}

#[test]
fn every_status_comes_back_as_it_was() {
    let mut statuses = vec![
        CommandStatus::Queued,
        CommandStatus::Sent { frames: 3 },
        CommandStatus::Progress {
            acknowledged: 8,
            total: 100,
        },
        CommandStatus::Reported(ParameterLine {
            place: 3,
            count: 20,
            name: ParameterName::new("track"),
            value: 10_125,
            kept: -1,
            least: -2_000_000,
            most: 2_000_000,
            unit: Printable::new("in/1000"),
        }),
        CommandStatus::Confirmed { digest: None },
        CommandStatus::Confirmed {
            digest: Some(0xBEEF),
        },
    ];
    statuses.extend(Outcome::ALL.map(CommandStatus::Refused));
    statuses.extend(Failure::ALL.map(CommandStatus::Failed));
    for expected in statuses {
        let line = StationLine::Status {
            id: 9,
            status: StatusJson::from(&expected),
            heard: Heard { bytes: 5, lines: 1 },
        };
        assert_eq!(StationLine::parse(&line.to_line()), Some(line.clone()));
        let StationLine::Status { status, .. } = line else {
            unreachable!("it was made above")
        };
        assert_eq!(status.status(), Some(expected));
        let line = StationLine::Command { command: 9, status };
        assert_eq!(StationLine::parse(&line.to_line()), Some(line));
    }
    for line in [
        StationLine::Welcome(Welcome::new("/dev/ttyUSB0".to_owned(), true)),
        StationLine::Lost {
            lost: "unplugged".to_owned(),
        },
        StationLine::error("busy", "no"),
    ] {
        assert_eq!(StationLine::parse(&line.to_line()), Some(line));
    }
    let at = Waypoint::new(48, -48).expect("near");
    for request in [
        Request::Stop,
        Request::Own("goto 48 0".to_owned()),
        Request::route(vec![at]).expect("a route"),
    ] {
        let line = StationLine::Asked {
            command: 9,
            by: "pid 5".to_owned(),
            request: RequestJson::from(&request),
        };
        assert_eq!(StationLine::parse(&line.to_line()), Some(line));
        assert_eq!(RequestJson::from(&request).read(), Ok(request));
    }
}

#[test]
fn wrong_lines_are_named() {
    for (line, words) in [
        ("", "not understood"),
        ("GET / HTTP/1.1", "begin with {\"groundwave\":1}"),
        ("{\"groundwave\":2}", "version 2"),
        ("{\"groundwave\":1,\"id\":1}", "a line needs"),
        ("{\"id\":1}", "a line needs"),
        ("{\"id\":1,\"do\":\"fly\"}", "unknown command `fly`"),
        ("{\"id\":1,\"do\":\"scan\",\"route\":[]}", "a line needs"),
        ("{\"id\":1,\"do\":\"scan\",\"timeout_ms\":0}", "timeout_ms"),
        ("{\"id\":1,\"do\":\"scan\",\"colour\":1}", "colour"),
        ("{\"id\":1,\"route\":[[30000,0]]}", "(30000, 0) is too far"),
        ("{\"id\":1,\"route\":[[1]]}", "not understood"),
    ] {
        let error = ClientLine::parse(line.as_bytes()).expect_err(line);
        assert!(error.to_string().contains(words), "{line}: {error}");
    }
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_a_panic(bytes: Vec<u8>) {
        let _ = ClientLine::parse(&bytes);
        prop_assert_eq!(StationLine::parse(&[b"\xFF", &bytes[..]].concat()), None);
    }

    #[test]
    fn any_words_give_a_request_or_an_error(
        command in select(Request::commands().collect::<Vec<_>>()),
        rest in vec(prop_oneof![select(WORDS).prop_map(str::to_owned), "[a-z0-9=,-]{0,8}"], 0..4),
        id: u32,
    ) {
        let words = [vec![command.to_owned()], rest].concat().join(" ");
        let line = json!({ "id": id, "do": words }).to_string();
        if let Ok(ClientLine::Ask(ask)) = ClientLine::parse(line.as_bytes()) {
            prop_assert_eq!(
                ClientLine::parse(&ClientLine::Ask(ask.clone()).to_line()),
                Ok(ClientLine::Ask(ask))
            );
        }
    }
}

/// Words that occur in commands.
const WORDS: &[&str] = &[
    "prowl",
    "home",
    "sonar",
    "sonar,user",
    "none",
    "get",
    "set",
    "list",
    "=trak",
    "track",
    "8",
    "-48",
    "30s",
    "off",
];
