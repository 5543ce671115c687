//! Clients connect, send commands, make mistakes and disconnect.

use super::*;
use crate::event::{AlarmEvent, AlarmStatus, Answer, Level};
use crate::request::Request;
use groundwave_protocol::status_codes::Mode;

const FIRST: ClientId = ClientId(1);
const SECOND: ClientId = ClientId(2);
const HELLO: &[u8] = b"{\"groundwave\":1,\"pid\":77}";

struct Table {
    broker: Broker,
    answers: Answers,
    now: Moment,
    next: u32,
}

impl Table {
    fn new() -> Self {
        let mut broker = Broker::new("/dev/ttyUSB0".to_owned(), true);
        broker.handle_connected(FIRST, "pid 5".to_owned());
        broker.handle_connected(SECOND, "127.0.0.1:9".to_owned());
        Self {
            broker,
            answers: Answers::default(),
            now: Moment::ZERO,
            next: 1,
        }
    }

    fn hear(&mut self, client: ClientId, line: &[u8]) -> Option<CommandId> {
        let asked = self
            .broker
            .handle_line(self.now, client, Ok(line), &self.answers)?;
        let id = CommandId(self.next);
        self.next += 1;
        self.broker
            .handle_started(self.now, id, &asked, Heard::default());
        Some(id)
    }

    fn outputs(&mut self) -> Vec<String> {
        std::iter::from_fn(|| self.broker.poll_output())
            .map(|output| match output {
                Output::Client(ClientId(n), output) => match output {
                    ToClient::Line(line) => {
                        format!("{n} < {}", String::from_utf8_lossy(&line).trim_end())
                    }
                    ToClient::Converse { raw } => format!("{n} converses, raw {raw}"),
                    ToClient::Close => format!("{n} closed"),
                    ToClient::Busy(true) => format!("{n} is busy"),
                    ToClient::Busy(false) => format!("{n} is idle"),
                    ToClient::Stopping => format!("{n} waits for a stop"),
                },
                Output::Station(output) => match output {
                    ToStation::GiveUp(CommandId(n), why) => {
                        format!("command {n} given up: {why}")
                    }
                    ToStation::Drive {
                        velocity_in_s,
                        rotation_in_s,
                    } => format!("drive {velocity_in_s} {rotation_in_s}"),
                    ToStation::Answered(answered) => format!("{answered:?}"),
                    ToStation::Warning(text) => text,
                },
            })
            .collect()
    }
}

const CONFIRMED: CommandStatus = CommandStatus::Confirmed { digest: None };

#[test]
fn each_client_gets_the_steps_of_its_own_commands() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    table.hear(SECOND, HELLO);
    assert_eq!(
        table.outputs(),
        [
            "1 converses, raw false",
            r#"1 < {"groundwave":1,"link":"/dev/ttyUSB0","can_send":true}"#,
            "2 converses, raw false",
            r#"2 < {"groundwave":1,"link":"/dev/ttyUSB0","can_send":true}"#,
        ]
    );
    let first = table
        .hear(FIRST, br#"{"id":4,"do":"scan"}"#)
        .expect("a wish");
    assert_eq!(table.outputs(), ["1 is busy"]);
    let second = table
        .hear(SECOND, br#"{"id":4,"do":"stop"}"#)
        .expect("a wish");
    assert_eq!(table.outputs(), ["2 waits for a stop"]);
    let heard = Heard {
        bytes: 80,
        lines: 1,
    };
    table.broker.handle_status(second, &CONFIRMED, heard);
    table.broker.handle_status(first, &CONFIRMED, heard);
    table.broker.handle_status(first, &CONFIRMED, heard);
    let lines = table.outputs();
    assert_eq!(lines.len(), 3, "each ends once: {lines:?}");
    assert_eq!(lines[2], "1 is idle", "a STOP goes on without its client");
    assert!(lines[0].starts_with("2 < ") && lines[1].starts_with("1 < "));
    assert!(
        lines[0].contains(r#""heard":{"bytes":80,"lines":1}"#),
        "{lines:?}"
    );
}

#[test]
fn clients_are_named_by_the_system_before_their_own_word() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    table.hear(SECOND, HELLO);
    let by = |table: &mut Table, client| {
        let asked = table.broker.handle_line(
            Moment::ZERO,
            client,
            Ok(br#"{"id":1,"do":"mode prowl"}"#),
            &table.answers,
        );
        let asked = asked.expect("a wish");
        assert_eq!(asked.ask.request, Request::Mode(Mode::Prowl));
        asked.by
    };
    assert_eq!(by(&mut table, FIRST), "pid 5");
    assert_eq!(by(&mut table, SECOND), "pid 77 from 127.0.0.1:9");
}

#[test]
fn garbage_closes_only_its_client_with_a_reason() {
    for garbage in [
        &b"GET / HTTP/1.1"[..],
        b"{\"id\":1,\"do\":\"scan\"}",
        b"\xFF\x00",
    ] {
        let mut table = Table::new();
        assert_eq!(table.hear(FIRST, garbage), None);
        let outputs = table.outputs();
        assert!(
            outputs[0].starts_with("1 < {\"code\":\"not-understood\""),
            "{outputs:?}"
        );
        assert_eq!(outputs[1], "1 closed");
        assert!(outputs[2].contains("pid 5 was closed"), "{outputs:?}");
        assert_eq!(table.hear(FIRST, HELLO), None);
        assert!(table.outputs().is_empty(), "nothing more is heard from it");
        table.hear(SECOND, HELLO);
        assert_eq!(table.outputs().len(), 2);
    }
    let mut table = Table::new();
    assert_eq!(
        table
            .broker
            .handle_line(Moment::ZERO, FIRST, Err(TooLong), &table.answers),
        None
    );
    assert!(table.outputs()[0].contains("a line is longer"));
}

#[test]
fn a_flood_of_commands_is_refused() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    for _ in 0..ASKS_MAX {
        assert!(table.hear(FIRST, br#"{"id":1,"do":"scan"}"#).is_some());
    }
    assert!(table.hear(FIRST, br#"{"id":1,"do":"stop"}"#).is_some());
    assert_eq!(table.hear(FIRST, br#"{"id":1,"do":"scan"}"#), None);
    assert!(
        table
            .outputs()
            .iter()
            .any(|line| line.contains("already waiting"))
    );
}

#[test]
fn a_client_that_vanishes_leaves_its_command_until_its_time_is_over() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    table
        .hear(FIRST, br#"{"id":1,"do":"scan","timeout_ms":5000}"#)
        .expect("a wish");
    table.outputs();
    table.broker.handle_gone(FIRST);
    assert_eq!(table.broker.poll_timeout(), Some(Moment::from_secs(5)));
    table
        .broker
        .handle_timeout(Moment::from_secs(4), Heard::default());
    assert!(table.outputs().is_empty());
    table
        .broker
        .handle_timeout(Moment::from_secs(5), Heard::default());
    assert_eq!(
        table.outputs(),
        ["command 1 given up: not confirmed: the robot may or may not have heard it"]
    );
    assert_eq!(table.broker.poll_timeout(), None);
}

#[test]
fn a_timeout_is_reported_with_the_lines_received() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    table
        .hear(FIRST, br#"{"id":3,"do":"scan","timeout_ms":1}"#)
        .expect("a wish");
    table.outputs();
    table
        .broker
        .handle_timeout(Moment::from_millis(1), Heard { bytes: 9, lines: 0 });
    let outputs = table.outputs();
    assert!(
        outputs[0].contains(r#""code":"timed-out""#) && outputs[0].contains(r#""bytes":9"#),
        "{outputs:?}"
    );
    assert_eq!(
        outputs[1..],
        [
            "1 is idle",
            "command 1 given up: not confirmed: the robot may or may not have heard it"
        ]
    );
}

#[test]
fn a_stop_is_taken_when_every_place_waits_for_a_command() {
    let mut table = Table::new();
    let scan = br#"{"id":1,"do":"scan"}"#;
    for n in 11..11 + CLIENTS_MAX as u64 {
        table
            .broker
            .handle_connected(ClientId(n), format!("127.0.0.1:{n}"));
        table.hear(ClientId(n), HELLO);
        assert!(table.hear(ClientId(n), scan).is_some(), "{n}");
    }
    table.hear(FIRST, HELLO);
    assert!(table.hear(FIRST, br#"{"id":1,"do":"stop"}"#).is_some());
    table.outputs();
    assert!(table.hear(ClientId(11), scan).is_some(), "it has its place");
    assert_eq!(table.hear(FIRST, scan), None);
    let outputs = table.outputs();
    assert!(
        outputs[0].starts_with(r#"1 < {"code":"full","error":"16 programs wait"#),
        "{outputs:?}"
    );
}

#[test]
fn a_reader_that_is_cut_off_is_logged() {
    let mut table = Table::new();
    table.broker.handle_too_slow(SECOND, 65_536);
    assert_eq!(
        table.outputs(),
        ["127.0.0.1:9 stopped reading and was cut off, 65536 bytes unread"]
    );
}

#[test]
fn a_client_cancels_its_own_commands_and_drives_after_its_hello() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    table.hear(SECOND, b"{\"drive\":[6,0]}");
    let outputs = table.outputs();
    assert!(
        outputs.iter().any(|output| output == "2 closed"),
        "{outputs:?}"
    );
    assert!(
        !outputs.iter().any(|output| output.starts_with("drive")),
        "{outputs:?}"
    );
    table
        .broker
        .handle_connected(SECOND, "127.0.0.1:9".to_owned());
    table.hear(SECOND, HELLO);
    table
        .hear(FIRST, br#"{"id":4,"do":"scan"}"#)
        .expect("a command");
    table
        .hear(SECOND, br#"{"id":5,"do":"scan"}"#)
        .expect("a command");
    table.outputs();
    table.hear(SECOND, b"{\"cancel\":4}");
    assert!(table.outputs().is_empty(), "the command is Anne's");
    table.hear(SECOND, b"{\"cancel\":5}");
    table.hear(SECOND, b"{\"drive\":[6,-3]}");
    assert_eq!(
        table.outputs(),
        ["command 2 given up: cancelled", "drive 6 -3"]
    );
}

#[test]
fn others_are_told_of_a_command_and_its_steps() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    table.hear(SECOND, HELLO);
    let stop = table
        .hear(FIRST, br#"{"id":4,"do":"stop"}"#)
        .expect("a wish");
    table.outputs();
    let heard = Heard::default();
    let broker = &mut table.broker;
    broker.handle_asked(stop, &Request::Stop, Some("pid 5"), heard);
    broker.handle_status(stop, &CONFIRMED, heard);
    assert_eq!(
        table.outputs(),
        [
            r#"2 < {"by":"pid 5","command":1,"do":"stop"}"#,
            r#"1 < {"heard":{"bytes":0,"lines":0},"id":4,"status":"queued"}"#,
            r#"2 < {"command":1,"status":"confirmed"}"#,
            r#"1 < {"heard":{"bytes":0,"lines":0},"id":4,"status":"confirmed"}"#,
        ]
    );
    let broker = &mut table.broker;
    broker.handle_asked(CommandId(9), &Request::Scan, None, heard);
    broker.handle_status(CommandId(9), &CONFIRMED, heard);
    let told = [
        r#"{"by":"the station's operator","command":9,"do":"scan"}"#,
        r#"{"command":9,"status":"confirmed"}"#,
    ];
    let told = told
        .iter()
        .flat_map(|told| [1, 2].map(|n| format!("{n} < {told}")));
    assert_eq!(table.outputs(), told.collect::<Vec<_>>());
}

#[test]
fn an_answer_to_an_alarm_goes_to_the_station_and_to_all_others() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    table.hear(SECOND, HELLO);
    table.outputs();
    let line = br#"{"alarm":"battery_low","answer":{"shelved_s":600}}"#;
    assert_eq!(table.hear(FIRST, line), None, "it is no command");
    assert_eq!(
        table.outputs(),
        [
            r#"2 < {"alarm":"battery_low","answer":{"shelved_s":600},"by":"pid 5"}"#,
            r#"AlarmAnswer { alarm: "battery_low", answer: Shelved(600), by: "pid 5" }"#,
        ]
    );
    table.broker.handle_answer(
        None,
        &AlarmAnswer {
            alarm: "stalled".to_owned(),
            answer: Answer::Acknowledged,
            by: OPERATOR.to_owned(),
        },
    );
    let told = r#"{"alarm":"stalled","answer":"acknowledged","by":"the station's operator"}"#;
    assert_eq!(table.outputs(), [1, 2].map(|n| format!("{n} < {told}")));
}

#[test]
fn a_later_client_learns_the_answers_that_apply_and_repeated_ones_are_dropped() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    let alarm = |code: &str, status, shelved_s: Option<u64>| AlarmEvent {
        code: code.to_owned(),
        name: code.to_owned(),
        level: Level::Alarm,
        status,
        began_at: None,
        value: None,
        limit: None,
        unit: String::new(),
        shelved_for: shelved_s.map(Moment::from_secs),
        by: None,
    };
    for event in [
        alarm("stalled", AlarmStatus::Acknowledged, None),
        alarm("fallen_or_lifted", AlarmStatus::Acknowledged, None),
        alarm("fallen_or_lifted", AlarmStatus::Ended, None),
        alarm("battery_low", AlarmStatus::Shelved, Some(600)),
        alarm("robot_silent", AlarmStatus::Shelved, Some(600)),
        alarm("robot_silent", AlarmStatus::Unshelved, None),
        alarm("bumper_jammed", AlarmStatus::Shelved, Some(30)),
    ] {
        table.answers.take(table.now, &event);
    }
    assert_eq!(table.answers.next_expiry(), Some(Moment::from_secs(30)));
    table.now = Moment::from_mins(1);
    let expired = table.answers.expired(table.now);
    assert_eq!(
        expired,
        [alarm("bumper_jammed", AlarmStatus::Unshelved, None)]
    );
    assert_eq!(table.answers.expired(table.now), []);
    table.outputs();
    table.hear(SECOND, HELLO);
    let told = table.outputs().concat();
    let answers = concat!(
        r#""answers":[{"alarm":"stalled","answer":"acknowledged","by":"the station's operator"},"#,
        r#"{"alarm":"battery_low","answer":{"shelved_s":540},"by":"the station's operator"}]"#
    );
    assert!(told.contains(answers), "{told}");
    for (line, is_new) in [
        (
            &br#"{"alarm":"stalled","answer":"acknowledged"}"#[..],
            false,
        ),
        (
            br#"{"alarm":"fallen_or_lifted","answer":"acknowledged"}"#,
            true,
        ),
        (
            br#"{"alarm":"battery_low","answer":{"shelved_s":540}}"#,
            false,
        ),
        (
            br#"{"alarm":"battery_low","answer":{"shelved_s":600}}"#,
            true,
        ),
    ] {
        table.hear(FIRST, line);
        assert_eq!(!table.outputs().is_empty(), is_new);
    }
}

#[test]
fn clients_are_told_whether_the_hook_of_the_alarms_is_run() {
    let mut table = Table::new();
    for (client, runs) in [(FIRST, true), (SECOND, false)] {
        table.broker.set_runs_alarm_hook(runs);
        table.hear(client, HELLO);
        let told = table.outputs().concat();
        assert_eq!(told.contains(r#""runs_alarm_hook":true"#), runs, "{told}");
    }
}

#[test]
fn what_the_station_before_tells_is_passed_on() {
    let mut table = Table::new();
    table.hear(FIRST, HELLO);
    table.outputs();
    for told in [
        r#"{"lost":"unplugged"}"#,
        r#"{"alarm":"stalled","answer":"unshelved","by":"pid 5"}"#,
    ] {
        let line = StationLine::parse(told.as_bytes()).expect("a line");
        table.broker.pass_on(&line);
        assert_eq!(table.outputs(), [format!("1 < {told}")]);
    }
    let said = StationLine::Said {
        said: "hello".to_owned(),
    };
    table.broker.pass_on(&said);
    assert!(table.outputs().is_empty(), "it comes with the line T");
}
