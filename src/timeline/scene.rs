//! A capture's state: a station that hears what was heard, and what it tells.

use std::sync::Arc;

use groundwave_protocol::arq;

use super::keyframes::Keyframes;
use super::reel::Cursor;
use crate::capture::index::{Piece, Place, SeekableReader};
use crate::event::{Event, Level, LinkEvent, Moment, Notice, NoticeCode};
use crate::model::{Config, Facts};
use crate::recorded::from_recorded;
use crate::station::Station;
use crate::travel::{Landmark, MARKER_REACH, MARKERS_MAX, Mark};

/// The spacing of states that a capture begins with; a day ends with some of five minutes.
pub const SPACING: Moment = Moment::from_secs(20);

/// A state that is to be there at once has heard so much of what came before: what is told of the latest
/// minute is as it was.
const HEARD_BEFORE: Moment = Moment::from_mins(3);

/// What happens next.
enum Next {
    /// Station or model waited for this.
    Timeout,
    /// The capture goes on.
    Piece,
    /// The capture ends.
    End,
}

/// Station and model at a moment of a capture.
#[derive(Clone, Debug)]
pub struct Scene {
    station: Station,
    facts: Facts,
    name: String,
    place: Place,
    at: Moment,
    /// A time has come and changed nothing: the next piece is waited for.
    is_waiting: bool,
    is_over: bool,
    is_lost: bool,
    /// Moments that were marked while it was recorded, in order.
    marks: Vec<Moment>,
    /// What could not be read, the first of it.
    damage: Option<String>,
}

impl Scene {
    /// The beginning of a capture, of which the screen says the name. Limits of alarms are the configuration's.
    #[must_use]
    pub fn new(name: &str, config: Arc<Config>, tape: &dyn SeekableReader) -> Self {
        Self::from(name, config, tape.place(), tape)
    }

    fn from(name: &str, config: Arc<Config>, place: Place, tape: &dyn SeekableReader) -> Self {
        let mut station = Station::new(arq::Config::new(1), false);
        station.handle_link(opened(name));
        let mut scene = Self {
            station,
            facts: Facts::new(config),
            name: name.to_owned(),
            place,
            at: place.at(),
            is_waiting: false,
            is_over: false,
            is_lost: false,
            marks: Vec::new(),
            damage: None,
        };
        scene.listen();
        if let Some(truth) = tape.truth() {
            scene.tell(&Event::Truth(truth));
        }
        scene
    }

    /// When the last thing happened.
    #[must_use]
    pub const fn moment(&self) -> Moment {
        self.at
    }

    fn listen(&mut self) {
        while let Some(event) = self.station.poll_event() {
            self.tell(&event);
        }
    }

    /// Takes an event at this moment.
    pub fn tell(&mut self, event: &Event) {
        self.facts.update(self.at, event);
    }

    fn next(&self, tape: &mut dyn SeekableReader) -> Option<(Moment, Next)> {
        if self.is_over {
            return None;
        }
        if tape.place() != self.place {
            tape.seek(self.place);
        }
        let Some(piece_at) = tape.next_at() else {
            return Some((self.at, Next::End));
        };
        // At the same time bytes come first, however they are cut into pieces.
        let timeout = self.poll_timeout().filter(|_| !self.is_waiting);
        match timeout.map(|at| at.max(self.at)) {
            Some(at) if at < piece_at => Some((at, Next::Timeout)),
            _ => Some((piece_at, Next::Piece)),
        }
    }

    /// When time alone changes something: what the station hears, or what has been wrong for too long.
    fn poll_timeout(&self) -> Option<Moment> {
        let station = self.station.poll_timeout();
        station.into_iter().chain(self.facts.poll_timeout()).min()
    }

    fn take_piece(&mut self, piece: Option<Piece<'_>>) {
        match piece {
            Some(Piece::Received(bytes)) => self.station.handle_bytes(self.at, bytes),
            Some(Piece::Sent(bytes)) => self.station.handle_sent(self.at, bytes),
            Some(Piece::Event(event)) => match from_recorded(&event) {
                Some(Event::Link(event)) => self.take_link(event),
                Some(Event::Mark(mark)) => self.take_mark(mark),
                Some(event) => self.tell(&event),
                None => {}
            },
            Some(Piece::Missing(bytes)) => {
                self.station.handle_interruption();
                self.tell(&Event::Notice(Notice::new(
                    NoticeCode::Missing,
                    Level::Warning,
                    format!("{bytes} bytes are missing from the capture here"),
                )));
            }
            Some(Piece::Damaged(text)) => {
                self.station.handle_interruption();
                self.damage.get_or_insert_with(|| text.clone());
                self.tell(&Event::Notice(Notice::new(
                    NoticeCode::Damaged,
                    Level::Alarm,
                    text,
                )));
            }
            Some(Piece::Repeated(_)) | None => {}
        }
    }

    /// A mark before the beginning is in another file.
    fn take_mark(&mut self, mark: Mark) {
        let Some(at) = self.at.checked_sub(mark.ago) else {
            return;
        };
        if mark.is_set && self.marks.len() < MARKERS_MAX {
            let place = self.marks.partition_point(|marked| *marked < at);
            self.marks.insert(place, at);
        } else if !mark.is_set {
            self.marks
                .retain(|marked| marked.abs_diff(at) >= MARKER_REACH);
        }
    }

    /// The link of the session that was recorded went and came back.
    fn take_link(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::Lost { .. } => self.is_lost = true,
            LinkEvent::Opened { .. } if self.is_lost => self.is_lost = false,
            LinkEvent::Opened { .. } | LinkEvent::Ended => return,
        }
        self.station.handle_link(match event {
            LinkEvent::Opened { .. } => opened(&self.name),
            event => event,
        });
    }
}

impl Cursor for Scene {
    type Supply = Box<dyn SeekableReader + Send>;

    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn at(&self) -> Moment {
        self.at
    }

    fn next_at(&self, tape: &mut Self::Supply) -> Option<Moment> {
        self.next(&mut **tape).map(|(at, _)| at)
    }

    fn step(&mut self, tape: &mut Self::Supply) {
        let Some((at, next)) = self.next(&mut **tape) else {
            return;
        };
        self.at = at;
        match next {
            Next::Timeout => {
                self.station.handle_timeout(at);
                self.listen();
                self.tell(&Event::Tick);
                self.is_waiting = self.poll_timeout().is_some_and(|next| next <= at);
            }
            Next::Piece => {
                self.is_waiting = false;
                self.take_piece(tape.next_piece());
                self.place = tape.place();
            }
            Next::End => {
                self.is_over = true;
                self.station.handle_link(LinkEvent::Ended);
            }
        }
        self.listen();
    }

    fn afresh(&self, tape: &mut Self::Supply, at: Moment) -> Option<Self> {
        let place = tape.find(at.saturating_sub(HEARD_BEFORE));
        Some(Self::from(
            &self.name,
            Arc::clone(self.facts.config()),
            place,
            &**tape,
        ))
    }

    fn about_line(tape: &mut Self::Supply, number: u64) -> Option<(Moment, u64)> {
        tape.about_line(number)
    }

    fn may_hold(tape: &mut Self::Supply, landmark: Landmark, from: Moment, until: Moment) -> bool {
        tape.may_hold(landmark, from, until)
    }
}

/// Nobody can send anything into a capture.
fn opened(name: &str) -> LinkEvent {
    LinkEvent::Opened {
        name: name.to_owned(),
        can_send: false,
    }
}

/// What was found when a capture was read through.
#[derive(Debug)]
pub enum Finding {
    /// A state to be kept.
    State(Box<Scene>),
    /// Moments that were marked while it was recorded, all that are known.
    Marks(Vec<Moment>),
    /// There is no more; the last of it happened then.
    End(Moment),
}

/// Reads a capture through and tells of states to keep, as many as are wanted of a capture of its length,
/// until nobody wants to know. Returns what could not be read, the first of it.
pub fn survey(
    mut scene: Scene,
    tape: &mut Box<dyn SeekableReader + Send>,
    mut tell: impl FnMut(Finding) -> bool,
) -> Option<String> {
    let mut told = Keyframes::new(SPACING);
    told.push(scene.at, ());
    while scene.next_at(tape).is_some() {
        let marks = scene.marks.len();
        scene.step(tape);
        if scene.marks.len() != marks && !tell(Finding::Marks(scene.marks.clone())) {
            return scene.damage;
        }
        if told.wants(scene.at) {
            told.push(scene.at, ());
            if !tell(Finding::State(Box::new(scene.clone()))) {
                return scene.damage;
            }
        }
    }
    tell(Finding::End(scene.at));
    scene.damage
}

#[cfg(test)]
mod tests {
    use prost::Message as _;
    use std::io::Cursor as Bytes;
    use std::path::Path;

    use super::*;
    use crate::capture::info::Info;
    use crate::capture::messages::{RawBytes, StationEvent};
    use crate::capture::topics::{Topic, TopicMessage};
    use crate::capture::writer::McapWriter;
    use crate::capture::{Capture, index};
    use crate::statistics::{Rejected, Resync};

    /// The same bytes read by `info`, and played to their end.
    fn both(bytes: Vec<u8>) -> (Info, Scene) {
        let mut capture = Capture::read("", Box::new(Bytes::new(bytes.clone()))).unwrap();
        let info = Info::read(&mut capture);
        let mut tape = index::read(Arc::new(bytes), Path::new("")).unwrap();
        let mut scene = Scene::new("", Arc::default(), &*tape);
        while scene.next_at(&mut tape).is_some() {
            scene.step(&mut tape);
        }
        (info, scene)
    }

    fn counts(info: &Info) -> (u64, u64, Rejected, Option<Resync>) {
        (
            info.lines.total(),
            info.lines_lost,
            info.rejected,
            info.resync,
        )
    }

    /// What `info`, the link panel and the raw panel say.
    fn assert_the_same(bytes: Vec<u8>) -> (Info, Scene) {
        let (info, scene) = both(bytes);
        let link = &scene.facts.link;
        let panel = *link.statistics().unwrap();
        let said = (panel.lines, panel.lines_lost, panel.rejected, panel.resync);
        assert_eq!(said, counts(&info));
        assert!((panel.loss_pct - info.loss_pct).abs() < 1e-9);
        let seen = link.counters();
        assert_eq!(Rejected::of(seen), info.rejected);
        assert_eq!(seen.lines + seen.ack_lines, info.lines.total());
        assert_eq!(seen.lines, scene.facts.tally().lines, "packets");
        (info, scene)
    }

    #[test]
    fn every_count_is_the_same_at_the_end() {
        for name in [
            "house-noisy.txt",
            "demo-commands.mcap",
            "living-room-bursts.txt",
        ] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
            let bytes = std::fs::read(folder.join(name)).unwrap();
            // The last thing may be anything.
            let ends = match name {
                "demo-commands.mcap" => bytes.len()..=bytes.len(),
                _ => bytes.len() - 160..=bytes.len(),
            };
            for end in ends.step_by(16) {
                assert_the_same(bytes[..end].to_vec());
            }
        }
    }

    #[test]
    fn a_line_cut_off_by_a_lost_link_is_no_error() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
        let bytes = std::fs::read(folder.join("house-clean.txt")).unwrap();
        let mut mcap = McapWriter::new(Vec::new()).unwrap();
        let mut write = |topic, at_s: u64, data: &[u8]| {
            let at_ns = at_s * 1_000_000_000;
            mcap.write(&TopicMessage {
                topic,
                log_time_ns: at_ns,
                publish_time_ns: at_ns,
                data,
            })
            .unwrap();
        };
        let raw = |from: usize, data: &[u8]| {
            RawBytes {
                stream_offset: from as u64,
                data: data.to_vec(),
            }
            .encode_to_vec()
        };
        let link = |event: &LinkEvent| StationEvent::from(event).encode_to_vec();
        let lost = LinkEvent::Lost {
            reason: "unplugged".to_owned(),
        };
        write(Topic::Station, 1, &link(&opened("radio")));
        write(Topic::RawRx, 2, &raw(0, &bytes[..840]));
        write(Topic::Station, 3, &link(&lost));
        write(Topic::Station, 60, &link(&opened("radio")));
        write(Topic::RawRx, 61, &raw(840, &bytes[8010..9600]));
        let (info, _) = assert_the_same(mcap.finish().unwrap());
        assert_eq!((info.lines_lost, info.resync), (0, None));
    }

    /// Where an appended run begins nothing was lost on the air, and the screen says what `info` says.
    #[test]
    fn an_appended_run_is_a_restart_and_no_alarm() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
        let bytes = std::fs::read(folder.join("house-clean.txt")).unwrap();
        let whole = bytes.len() - bytes.len() % 80;
        let (info, scene) = assert_the_same(bytes[..whole].repeat(3));
        let mut restarts = 0;
        for entry in scene.facts.log.newest_first() {
            restarts += u64::from(entry.text == "the robot restarted") * u64::from(entry.times);
            assert!(!entry.text.contains("lines lost"), "{}", entry.text);
        }
        assert_eq!((restarts, info.restarts), (2, 2));
    }
}
