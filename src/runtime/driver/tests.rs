use std::os::unix::net::UnixListener;

use super::*;
use crate::io::link::{BAUD, Connection, LinkSpec};

/// Other tasks and timers get a turn after every few kilobytes.
#[tokio::test]
async fn a_flood_leaves_turns_to_the_rest_of_the_runtime() {
    const STEPS: u64 = 20;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("link");
    let _listener = UnixListener::bind(&path).unwrap();
    let spec: LinkSpec = format!("unix:{}", path.display()).parse().unwrap();
    let connection = Connection::open(&spec, BAUD).unwrap();
    let (reports, _reports) = tokio::sync::mpsc::channel(4);
    let link = Link::start(spec, BAUD, connection, Box::new(|_, _| ()), reports);
    let (flood, inputs) = tokio::sync::mpsc::channel(256);
    let now = Instant::now();
    for _ in 0..256 {
        let bytes = LinkInput::Bytes(now, vec![b'\n'; 4096]);
        flood.try_send(bytes).unwrap();
    }
    let radio = Radio::RECEIVE_ONLY;
    let mut driver = Driver::new(
        "flood".into(),
        link,
        inputs,
        radio,
        now,
        Box::new(|_, _| {}),
    );
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
