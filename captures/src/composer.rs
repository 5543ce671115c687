//! Writes what the [`Deriver`] says to MCAP, with what a capture says about itself.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::io::{self, Write};
use std::time::{SystemTime, UNIX_EPOCH};

use groundwave_protocol::telemetry::FirmwareVersion;
use serde::{Deserialize, Serialize};

use super::event::{Level, NoticeCode};
use super::journal::{Entry, Kind};
use super::topics::{Deriver, StationEvent, TopicMessage};
use super::writer::{Attachment, McapWriter};
use super::{layout, name};

/// What a recording says about itself from the start.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Session {
    /// The link as the operator named it.
    pub link: String,
    /// When recording began.
    pub start: SystemTime,
    /// Anything else worth keeping: world, seed, command line.
    pub notes: BTreeMap<String, String>,
    /// The configuration in force, as text; empty when there is none.
    #[serde(default)]
    pub configuration: String,
}

impl Session {
    /// The table of a recording that says all this.
    pub(super) const TABLE: &str = "session";

    /// The note that has the simulator's truth, as JSON.
    pub const TRUTH: &str = "truth";

    pub(super) fn metadata(&self) -> BTreeMap<String, String> {
        let mut metadata = self.notes.clone();
        metadata.insert("link".into(), self.link.clone());
        metadata.insert("start".into(), name::utc(self.start));
        metadata.insert("software".into(), "groundwave".into());
        metadata.insert("software_version".into(), env!("CARGO_PKG_VERSION").into());
        metadata
    }
}

/// A capture under way: bytes and events in, MCAP out.
///
/// `convert` begins one with [`Self::new`], hands it every read with its time and calls
/// [`Self::finish`].
pub struct Composer<W> {
    deriver: Deriver,
    writer: McapWriter<W>,
}

impl<W: Write> Composer<W> {
    /// Begins a capture: every topic, the session, a layout, the configuration; then a flush.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(output: W, session: &Session) -> io::Result<Self> {
        Self::go_on(output, session, Deriver::new())
    }

    /// Begins the next part of a capture: what the deriver knows of the robot goes on.
    ///
    /// # Errors
    /// When writing fails.
    pub(super) fn go_on(output: W, session: &Session, mut deriver: Deriver) -> io::Result<Self> {
        deriver.begin_part();
        let mut composer = Self::around(McapWriter::new(output)?, deriver);
        let time_ns = since_1970_ns(session.start);
        // Every chunk has a message, the first too.
        let text = format!("recording of {} begins", session.link);
        let begun = StationEvent::notice(NoticeCode::RecordingBegun, Level::Info, text);
        composer.handle_event(time_ns, &begun)?;
        composer
            .writer
            .write_metadata(Session::TABLE, &session.metadata())?;
        composer.writer.attach(&Attachment {
            name: layout::NAME,
            media_type: "application/json",
            time_ns,
            data: layout::JSON.as_bytes(),
        })?;
        if !session.configuration.is_empty() {
            composer.writer.attach(&Attachment {
                name: "groundwave.toml",
                media_type: "application/toml",
                time_ns,
                data: session.configuration.as_bytes(),
            })?;
        }
        composer.writer.flush()?;
        Ok(composer)
    }

    /// Goes on with a recording that has been begun.
    pub(super) fn around(writer: McapWriter<W>, deriver: Deriver) -> Self {
        Self { deriver, writer }
    }

    /// Takes bytes received, read at `at_ns` since 1970.
    ///
    /// # Errors
    /// When writing fails.
    pub fn handle_rx(&mut self, at_ns: u64, bytes: &[u8]) -> io::Result<()> {
        let writer = &mut self.writer;
        self.deriver
            .handle_rx(at_ns, bytes, |message| writer.write(&message))?;
        match self.deriver.take_robot() {
            Some(robot) => self.writer.write_metadata("robot", &about(robot)),
            None => Ok(()),
        }
    }

    /// Takes bytes sent.
    ///
    /// # Errors
    /// When writing fails.
    pub fn handle_tx(&mut self, at_ns: u64, bytes: &[u8]) -> io::Result<()> {
        let writer = &mut self.writer;
        self.deriver
            .handle_tx(at_ns, bytes, |message| writer.write(&message))
    }

    /// Takes an event of the station's.
    ///
    /// # Errors
    /// When writing fails.
    pub fn handle_event(&mut self, at_ns: u64, event: &StationEvent) -> io::Result<()> {
        let writer = &mut self.writer;
        self.deriver
            .handle_event(at_ns, event, |message| writer.write(&message))
    }

    /// Takes an entry of a journal; a step in its offsets becomes a step in the capture. What the
    /// capture holds already is passed over.
    ///
    /// # Errors
    /// When writing fails.
    pub fn handle_entry<D: AsRef<[u8]>>(&mut self, entry: &Entry<D>) -> io::Result<()> {
        match entry.kind {
            Kind::Session => Ok(()),
            Kind::Rx => {
                let Some((step, bytes)) = fresh(entry, self.deriver.rx_bytes()) else {
                    return Ok(());
                };
                if step > 0 {
                    let writer = &mut self.writer;
                    self.deriver
                        .skip_rx(step, |message| writer.write(&message))?;
                }
                self.handle_rx(entry.at_ns, bytes)
            }
            Kind::Tx => {
                let Some((step, bytes)) = fresh(entry, self.deriver.tx_bytes()) else {
                    return Ok(());
                };
                self.deriver.skip_tx(step);
                self.handle_tx(entry.at_ns, bytes)
            }
            Kind::Event => match entry.event() {
                Some(event) => self.handle_event(entry.at_ns, &event),
                None => Ok(()),
            },
        }
    }

    /// Lets the deriver see what the capture holds already, so that it knows what comes next.
    pub(super) fn recall(&mut self, entry: &Entry) {
        let nowhere = |_: TopicMessage<'_>| Ok::<(), Infallible>(());
        let deriver = &mut self.deriver;
        let Ok(()) = match entry.kind {
            Kind::Session => Ok(()),
            Kind::Rx => {
                let Some((step, bytes)) = fresh(entry, deriver.rx_bytes()) else {
                    return;
                };
                if step > 0 {
                    let Ok(()) = deriver.skip_rx(step, nowhere);
                }
                let Ok(()) = deriver.handle_rx(entry.at_ns, bytes, nowhere);
                deriver.finish(nowhere)
            }
            Kind::Tx => {
                let Some((step, bytes)) = fresh(entry, deriver.tx_bytes()) else {
                    return;
                };
                deriver.skip_tx(step);
                deriver.handle_tx(entry.at_ns, bytes, nowhere)
            }
            Kind::Event => entry.event().map_or(Ok(()), |event| {
                deriver.handle_event(entry.at_ns, &event, nowhere)
            }),
        };
        // It has been told of all that.
        deriver.take_robot();
        deriver.take_urgent();
    }

    /// Gives out bytes that belong to no whole line yet.
    pub(super) fn end_line(&mut self) -> io::Result<()> {
        let writer = &mut self.writer;
        self.deriver.finish(|message| writer.write(&message))
    }

    /// Whether something has happened since this was asked last that shall be on the disk at once: a bump,
    /// an alarm, the beginning or the end of a command.
    pub fn take_urgent(&mut self) -> bool {
        self.deriver.take_urgent()
    }

    /// Hands everything to the output.
    ///
    /// # Errors
    /// When writing fails.
    pub fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    /// The writer, for what is written besides.
    pub const fn writer(&mut self) -> &mut McapWriter<W> {
        &mut self.writer
    }

    /// The deriver.
    #[must_use]
    pub const fn deriver(&self) -> &Deriver {
        &self.deriver
    }

    /// Writes what is left, the index and the statistics.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(self) -> io::Result<W> {
        self.finish_part().map(|(output, _)| output)
    }

    /// Likewise, and gives back the deriver for the next part.
    pub(super) fn finish_part(mut self) -> io::Result<(W, Deriver)> {
        self.end_line()?;
        Ok((self.writer.finish()?, self.deriver))
    }
}

/// The bytes of an entry that are not there yet, and how many are missing before them; `None` where all of them are.
fn fresh<D: AsRef<[u8]>>(entry: &Entry<D>, have: u64) -> Option<(u64, &[u8])> {
    let known = have.saturating_sub(entry.offset);
    let step = entry.offset.saturating_sub(have);
    let from = usize::try_from(known).unwrap_or(usize::MAX);
    Some((step, entry.data.as_ref().get(from..)?))
}

fn about((robot_id, version): (u8, FirmwareVersion)) -> BTreeMap<String, String> {
    BTreeMap::from([
        ("robot_id".to_owned(), robot_id.to_string()),
        (
            "firmware_version".to_owned(),
            format!("{}.{:02}", version.major, version.minor),
        ),
    ])
}

/// The time that a radio at 2400 baud takes for so many bytes: what stands in for the time of a read
/// that nobody noted.
#[must_use]
pub fn wire_ns(bytes: u64) -> u64 {
    const RATE: u64 = groundwave_protocol::BYTES_PER_S as u64;
    bytes / RATE * 1_000_000_000 + bytes % RATE * 1_000_000_000 / RATE
}

/// Nanoseconds since 1970; a time before that counts as 1970.
#[must_use]
pub fn since_1970_ns(wall: SystemTime) -> u64 {
    let since_1970 = wall.duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX)
}
