//! Links made of channels: deliveries, ends, and stuck devices.

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::sync::mpsc::{Receiver, Sender as Feed, channel};

use tokio::sync::mpsc;

use super::*;
use crate::io::link::Link;
use crate::io::share_client::ShareClientError;
use crate::share::{ANNOUNCEMENT, Address, Welcome};

/// Timeout after which a test counts as hanging.
const PATIENCE: Duration = Duration::from_secs(20);

/// Delivers the bytes from a channel; ends when the channel is closed.
struct Fed(Receiver<io::Result<Vec<u8>>>);

impl Read for Fed {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.0.recv() {
            Ok(Ok(bytes)) => {
                buffer[..bytes.len()].copy_from_slice(&bytes);
                Ok(bytes.len())
            }
            Ok(Err(error)) => Err(error),
            Err(_) => Ok(0),
        }
    }
}

/// Accepts no bytes until its other end is dropped, and reports each write.
struct Stuck {
    asked: Feed<()>,
    until: Receiver<()>,
}

impl Write for Stuck {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        let _ = self.asked.send(());
        let _ = self.until.recv();
        Err(io::ErrorKind::TimedOut.into())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

struct Planned {
    openings: VecDeque<Result<Connection, OpenError>>,
    is_final: bool,
    /// Pauses between the openings, reported without waiting.
    pauses: Feed<Duration>,
}

impl Reopen for Planned {
    fn open(&mut self) -> Result<Connection, OpenError> {
        self.openings
            .pop_front()
            .unwrap_or_else(|| Err(OpenError::Missing("it".to_owned())))
    }

    fn is_final(&self) -> bool {
        self.is_final
    }

    fn end_of_file(&self) -> &'static str {
        "unplugged"
    }

    fn rest(&mut self, pause: Duration) {
        let _ = self.pauses.send(pause);
        thread::yield_now();
    }
}

fn fed() -> (Feed<io::Result<Vec<u8>>>, Connection) {
    let (feed, from_feed) = channel();
    let connection = Connection {
        reading: Box::new(Fed(from_feed)),
        writing: None,
        renamed: None,
        share: None,
    };
    (feed, connection)
}

/// Sends a read timeout: the link is open and silent.
fn pass(feed: &Feed<io::Result<Vec<u8>>>) {
    feed.send(Err(io::ErrorKind::TimedOut.into()))
        .expect("a reader");
}

struct Bench {
    link: Link,
    inputs: mpsc::Receiver<LinkInput>,
    pauses: Receiver<Duration>,
}

impl Bench {
    fn new(connection: Connection, openings: Vec<Result<Connection, OpenError>>) -> Self {
        let (to_pauses, pauses) = channel();
        let planned = Planned {
            is_final: openings.is_empty(),
            openings: openings.into(),
            pauses: to_pauses,
        };
        let (to_station, inputs) = mpsc::channel(64);
        let link = Link::start_with(planned, connection, Box::new(|_, _| ()), to_station);
        Self {
            link,
            inputs,
            pauses,
        }
    }

    fn next(&mut self) -> String {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .build()
            .expect("a runtime");
        let next = runtime.block_on(async {
            tokio::time::timeout(PATIENCE, self.inputs.recv())
                .await
                .expect("nothing came: the link hangs")
        });
        match next.expect("the reader has ended") {
            LinkInput::Opened {
                renamed,
                empty: 0 | 1,
                ..
            } => {
                format!("opened {}", renamed.unwrap_or_default())
            }
            LinkInput::Opened { empty, .. } => format!("opened after {empty}"),
            LinkInput::Bytes(_, bytes) => format!("bytes {}", String::from_utf8_lossy(&bytes)),
            LinkInput::Said(line) => format!("said {}", String::from_utf8_lossy(&line.to_line())),
            LinkInput::Lost(reason) => format!("lost {reason}"),
            LinkInput::Ended => "ended".to_owned(),
        }
    }
}

/// Bytes from the radio reach sink and station without the lines around them, in order, beginning with the next whole line.
#[test]
fn a_shared_link_brings_bytes_and_answers_in_lines() {
    let (feed, mut connection) = fed();
    connection.share = Some(Welcome::new("radio".to_owned(), true));
    let mut bench = Bench::new(connection, vec![]);
    for part in [
        "{\"rx\":\"half\"}\n{\"rx\":\" a line\\nA1\"}\n{\"rx\":\"23\\u00ff\"}\n{\"sa",
        "id\":\"hello\"}\nnoise\n",
    ] {
        feed.send(Ok(part.into())).expect("a reader");
    }
    drop(feed);
    let all: Vec<String> = (0..4).map(|_| bench.next()).collect();
    let said = "said {\"said\":\"hello\"}\n";
    assert_eq!(all, ["opened ", "bytes A123\u{FFFD}", said, "ended"]);
}

#[test]
fn a_radio_that_announces_itself_late_is_opened_again() {
    let (first, connection) = fed();
    let (second, again) = fed();
    let mut bench = Bench::new(connection, vec![Ok(again)]);
    first.send(Ok(ANNOUNCEMENT.to_vec())).expect("a reader");
    second.send(Ok(b"A\n".to_vec())).expect("a reader");
    let all: Vec<String> = (0..4).map(|_| bench.next()).collect();
    assert_eq!(
        all,
        [
            "opened ",
            "lost it is a shared link",
            "opened ",
            "bytes A\n"
        ]
    );
}

#[test]
fn the_last_half_line_arrives_before_the_end() {
    let (feed, connection) = fed();
    let mut bench = Bench::new(connection, vec![]);
    feed.send(Ok(b"half a line".to_vec())).expect("a reader");
    drop(feed);
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "bytes half a line");
    assert_eq!(bench.next(), "ended");
}

#[test]
fn the_last_half_line_arrives_before_the_loss() {
    let (feed, connection) = fed();
    let (_second, again) = fed();
    let mut bench = Bench::new(connection, vec![Ok(again)]);
    feed.send(Ok(b"half".to_vec())).expect("a reader");
    feed.send(Err(io::ErrorKind::BrokenPipe.into()))
        .expect("a reader");
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "bytes half");
    assert_eq!(bench.next(), "lost unplugged");
    assert_eq!(bench.next(), "opened ");
}

/// Otherwise, noise without a line feed and the last part of a line would arrive late or never.
#[test]
fn a_pause_hands_over_the_bytes_so_far() {
    let (feed, connection) = fed();
    let mut bench = Bench::new(connection, vec![]);
    feed.send(Ok(b"half".to_vec())).expect("a reader");
    feed.send(Err(io::ErrorKind::TimedOut.into()))
        .expect("a reader");
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "bytes half");
}

#[test]
fn a_stuck_device_does_not_delay_the_loss() {
    let (feed, mut connection) = fed();
    let (asked, was_asked) = channel();
    let (_held, until) = channel();
    connection.writing = Some(Box::new(Stuck { asked, until }));
    let (second, again) = fed();
    pass(&second);
    let mut bench = Bench::new(connection, vec![Ok(again)]);
    bench.link.send(b"\n");
    was_asked.recv_timeout(PATIENCE).expect("a write");
    drop(feed);
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "lost unplugged");
    assert_eq!(bench.next(), "opened ");
}

#[test]
fn bytes_that_a_stuck_device_does_not_take_are_counted() {
    let (_feed, mut connection) = fed();
    let (asked, was_asked) = channel();
    let (held, until) = channel();
    connection.writing = Some(Box::new(Stuck { asked, until }));
    let bench = Bench::new(connection, vec![]);
    bench.link.send(b"12345");
    was_asked.recv_timeout(PATIENCE).expect("a write");
    for _ in 0..9 {
        bench.link.send(b"12345");
    }
    assert_eq!(
        bench.link.not_taken_bytes(),
        5,
        "eight wait, the ninth has no room"
    );
    drop(held);
    let deadline = Instant::now() + PATIENCE;
    while bench.link.not_taken_bytes() < 50 {
        assert!(
            Instant::now() < deadline,
            "{}",
            bench.link.not_taken_bytes()
        );
        thread::yield_now();
    }
}

#[test]
fn the_reason_for_a_missing_link_is_reported_once() {
    let (feed, connection) = fed();
    let (second, mut again) = fed();
    pass(&second);
    again.renamed = Some("/dev/ttyUSB1".to_owned());
    let busy = || Err(OpenError::Another("it".to_owned()));
    let missing = Err(OpenError::Missing("it".to_owned()));
    // A device that has just come back has the wrong permissions for a moment.
    let denied = Err(OpenError::Permission("it".to_owned()));
    let openings = vec![missing, denied, busy(), busy(), busy(), Ok(again)];
    let mut bench = Bench::new(connection, openings);
    drop(feed);
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "lost unplugged");
    assert!(bench.next().starts_with("lost it is another USB device"));
    assert_eq!(bench.next(), "opened /dev/ttyUSB1");
}

/// Accepts all bytes, and reports that it was closed.
struct LetGo(Feed<()>);

impl Write for LetGo {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for LetGo {
    fn drop(&mut self) {
        let _ = self.0.send(());
    }
}

/// While a device is open, its name is in use: the adapter would return under another name.
#[test]
fn a_lost_device_is_closed_before_it_is_back() {
    let (feed, mut connection) = fed();
    let (let_go, was_let_go) = channel();
    connection.writing = Some(Box::new(LetGo(let_go)));
    let missing = Err(OpenError::Missing("it".to_owned()));
    let mut bench = Bench::new(connection, vec![missing]);
    drop(feed);
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "lost unplugged");
    was_let_go.recv_timeout(PATIENCE).expect("it is still held");
}

/// A peer that accepts and closes at once must not cause thousands of connections per second.
#[test]
fn a_peer_without_bytes_is_reported_once_and_dialled_more_and_more_rarely() {
    let closed = || fed().1;
    let (feed, last) = fed();
    let mut openings: Vec<_> = (0..9).map(|_| Ok(closed())).collect();
    openings.push(Ok(last));
    let mut bench = Bench::new(closed(), openings);
    feed.send(Ok(b"line\n".to_vec())).expect("a reader");
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "lost unplugged");
    assert_eq!(bench.next(), "opened after 10");
    assert_eq!(bench.next(), "bytes line\n");
    let pauses: Vec<Duration> = bench.pauses.try_iter().collect();
    assert_eq!(pauses.len(), 10, "{pauses:?}");
    assert!(pauses[0] <= Duration::from_millis(50), "{pauses:?}");
    assert!(pauses[9] >= Duration::from_millis(1500), "{pauses:?}");
    drop(feed);
    assert_eq!(bench.next(), "lost unplugged");
}

/// A shared link that announces itself and closes has brought no line of a robot.
#[test]
fn a_station_without_a_welcome_is_reported_once_and_dialled_more_and_more_rarely() {
    let closed = || {
        let address = Address::Tcp("robot:4000".to_owned());
        Err(ShareClientError::NoStation(address).into())
    };
    let (feed, last) = fed();
    let mut openings: Vec<_> = (0..9).map(|_| closed()).collect();
    openings.push(Ok(last));
    let mut bench = Bench::new(fed().1, openings);
    feed.send(Ok(b"line\n".to_vec())).expect("a reader");
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "lost unplugged");
    assert!(bench.next().starts_with("lost the server at robot:4000"));
    assert_eq!(bench.next(), "opened after 10");
    assert_eq!(bench.next(), "bytes line\n");
    let pauses: Vec<Duration> = bench.pauses.try_iter().collect();
    assert_eq!(pauses.len(), 10, "{pauses:?}");
    assert!(pauses[1] <= Duration::from_millis(100), "{pauses:?}");
    assert!(pauses[9] >= Duration::from_millis(1500), "{pauses:?}");
}

/// An open connection to a robot that is switched off also delivers no byte.
#[test]
fn a_silent_connection_is_open_when_it_lasts() {
    let (_feed, again) = {
        let (feed, connection) = fed();
        pass(&feed);
        (feed, connection)
    };
    let mut bench = Bench::new(fed().1, vec![Ok(fed().1), Ok(again)]);
    assert_eq!(bench.next(), "opened ");
    assert_eq!(bench.next(), "lost unplugged");
    assert_eq!(bench.next(), "opened after 2");
}
