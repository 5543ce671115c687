use std::os::unix::net::UnixListener;
use std::path::Path;

use tokio::sync::mpsc::Sender;

use super::*;
use crate::event::{AlarmEvent, AlarmStatus, Level};
use crate::io::alarm_hook::AlarmHook;
use crate::io::link::{BAUD, Connection, LinkSpec};

/// A driver of a link to a socket in a folder, and the queue of its inputs.
fn driver(folder: &Path, radio: Radio) -> (Driver, Sender<LinkInput>) {
    let path = folder.join("link");
    let _listener = UnixListener::bind(&path).expect("a socket");
    let spec: LinkSpec = format!("unix:{}", path.display()).parse().expect("a link");
    let connection = Connection::open(&spec, BAUD).expect("a connection");
    let (reports, _reports) = tokio::sync::mpsc::channel(4);
    let link = Link::start(spec, BAUD, connection, Box::new(|_, _| ()), reports);
    let (inputs, from_link) = tokio::sync::mpsc::channel(256);
    let sent = Box::new(|_: Instant, _: &[u8]| {});
    let driver = Driver::new("link".into(), link, from_link, radio, Instant::now(), sent);
    (driver, inputs)
}

#[tokio::test]
async fn a_command_that_the_operator_has_not_given_is_the_grounds() {
    let folder = tempfile::tempdir().unwrap();
    let (mut driver, _inputs) = driver(folder.path(), Radio::default());
    driver.request(Request::Scan);
    driver.request_unasked(Request::Scan);
    let asked = std::iter::from_fn(|| driver.poll_event()).filter_map(|event| match event {
        Event::Asked { by, .. } => Some(by),
        _ => None,
    });
    assert_eq!(asked.collect::<Vec<_>>(), [None, Some(GROUND.to_owned())]);
}

/// A recording has what was read, so the station counts it.
#[tokio::test]
async fn lines_read_before_the_end_count() {
    let folder = tempfile::tempdir().unwrap();
    let (mut driver, inputs) = driver(folder.path(), Radio::RECEIVE_ONLY);
    let sample = std::fs::read(crate::capture::samples().join("house-clean.txt")).unwrap();
    for line in sample.split_inclusive(|&byte| byte == b'\n').take(10) {
        let bytes = LinkInput::Bytes(Instant::now(), line.to_vec());
        inputs.try_send(bytes).unwrap();
    }
    driver.end();
    assert_eq!(driver.station().totals(driver.now()).intact(), 10);
    assert!(inputs.is_closed());
}

/// Other tasks and timers get a turn after every few kilobytes.
#[tokio::test]
async fn a_flood_leaves_turns_to_the_rest_of_the_runtime() {
    const STEPS: u64 = 20;
    let folder = tempfile::tempdir().unwrap();
    let (mut driver, flood) = driver(folder.path(), Radio::RECEIVE_ONLY);
    let now = Instant::now();
    for _ in 0..256 {
        let bytes = LinkInput::Bytes(now, vec![b'\n'; 4096]);
        flood.try_send(bytes).unwrap();
    }
    let (turn, mut turns) = tokio::sync::mpsc::unbounded_channel();
    tokio::spawn(async move {
        while turn.send(()).is_ok() {
            tokio::task::yield_now().await;
        }
    });
    for _ in 0..STEPS {
        driver.step().await;
        while driver.poll_event().is_some() {}
    }
    let bytes = driver.heard().bytes;
    assert!(
        bytes <= STEPS * 2 * BATCH_BYTES,
        "{bytes} bytes in {STEPS} steps"
    );
    let had = std::iter::from_fn(|| turns.try_recv().ok()).count();
    assert!(had + 1 >= STEPS as usize, "{had} turns in {STEPS} steps");
}

/// A shelved alarm that begins calls no one; when it is unshelved, the event has its begin.
#[tokio::test]
async fn an_alarm_that_begins_while_it_is_shelved_does_not_run_the_hook() {
    let folder = tempfile::tempdir().unwrap();
    let (mut driver, _inputs) = driver(folder.path(), Radio::default());
    let path = folder.path().join("told");
    // The last event fails, which shows that all events have been passed.
    let command =
        format!("read -r line; echo \"$line\" >> {path:?}; case $line in *last*) false; esac");
    driver.alarm_hook = Some(AlarmHook::start(&command).unwrap());
    let alarm = |code: &str, status, began_s: Option<u64>| AlarmEvent {
        code: code.to_owned(),
        name: code.to_owned(),
        level: Level::Warning,
        status,
        began_at: began_s.map(Moment::from_secs),
        value: None,
        limit: None,
        unit: String::new(),
        shelved_for: (status == AlarmStatus::Shelved).then_some(Moment::from_hours(1)),
        by: None,
    };
    for event in [
        alarm("low", AlarmStatus::Begun, Some(0)),
        alarm("low", AlarmStatus::Shelved, Some(0)),
        alarm("low", AlarmStatus::Ended, None),
        alarm("low", AlarmStatus::Begun, Some(0)),
        alarm("low", AlarmStatus::Ended, None),
        alarm("low", AlarmStatus::Begun, Some(0)),
        alarm("lost", AlarmStatus::Begun, Some(0)),
        alarm("low", AlarmStatus::Unshelved, Some(0)),
        alarm("low", AlarmStatus::Ended, None),
        alarm("low", AlarmStatus::Begun, Some(0)),
        alarm("last", AlarmStatus::Begun, Some(0)),
    ] {
        driver.tell(Event::Alarm(event));
    }
    driver.alarm_hook.as_mut().unwrap().next_problem().await;
    let told = std::fs::read_to_string(&path).unwrap();
    let told = told.lines().map(|line| {
        let value: serde_json::Value = serde_json::from_str(line).unwrap();
        format!("{} {}", value["code"], value["status"]).replace('"', "")
    });
    let expected = [
        "low begun",
        "low shelved",
        "low ended",
        "lost begun",
        "low unshelved",
        "low ended",
        "low begun",
        "last begun",
    ];
    assert_eq!(told.collect::<Vec<_>>(), expected);
}
