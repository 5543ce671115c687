//! The state of a capture: a station that receives the recorded bytes, and the facts from its events.

use std::sync::Arc;

use groundwave_protocol::arq;

use super::cursor::{Cursor, Shortcuts};
use super::keyframes::Keyframes;
use super::timeline::Timeline;
use crate::capture::index::{Piece, Place, SeekableReader};
use crate::capture::marks::Marks;
use crate::event::{Event, Level, LinkEvent, Moment, Notice, NoticeCode};
use crate::model::{Config, Facts};
use crate::recorded::from_recorded;
use crate::station::Station;

/// Initial time between two keyframes; in a capture of a day, it grows to about five minutes.
pub const SPACING: Moment = Moment::from_secs(20);

/// Time before its moment from which a fresh state reads the capture: enough for the figures of the latest minute.
const HEARD_BEFORE: Moment = Moment::from_mins(3);

/// The next step of a state.
enum Next {
    /// A timeout of the station or the facts.
    Timeout,
    /// The next piece of the capture.
    Piece,
    /// The end of the capture.
    End,
}

/// Station and facts at a moment of a capture.
#[derive(Clone, Debug)]
pub struct CaptureState {
    station: Station,
    facts: Facts,
    name: String,
    place: Place,
    at: Moment,
    /// Whether a timeout changed nothing, so that the next piece comes first.
    is_waiting: bool,
    is_over: bool,
    is_lost: bool,
    /// Moments marked in the recording, in order.
    marks: Marks,
    /// The first damaged part.
    damage: Option<String>,
}

impl CaptureState {
    /// The state at the beginning of a capture, displayed as `name`.
    #[must_use]
    pub fn new(name: &str, config: Arc<Config>, reader: &dyn SeekableReader) -> Self {
        Self::from(name, config, reader.place(), reader)
    }

    fn from(name: &str, config: Arc<Config>, place: Place, reader: &dyn SeekableReader) -> Self {
        let mut station = Station::new(arq::Config::new(1), false);
        if let Some(baud) = reader.baud() {
            station.set_baud(baud);
        }
        station.set_own_lines(reader.own_lines());
        if !reader.has_times() {
            station.set_estimated_times();
        }
        station.handle_link(place.at(), opened(name));
        let mut scene = Self {
            station,
            facts: Facts::new(config),
            name: name.to_owned(),
            place,
            at: place.at(),
            is_waiting: false,
            is_over: false,
            is_lost: false,
            marks: Marks::default(),
            damage: None,
        };
        scene.listen();
        if let Some(truth) = reader.truth() {
            scene.tell(&Event::Truth(truth));
        }
        scene
    }

    /// Time of the last step.
    #[must_use]
    pub const fn moment(&self) -> Moment {
        self.at
    }

    fn listen(&mut self) {
        while let Some(event) = self.station.poll_event() {
            self.tell(&event);
        }
    }

    /// Takes an event at the current moment.
    pub fn tell(&mut self, event: &Event) {
        self.facts.update(self.at, event);
    }

    fn next(&self, reader: &mut dyn SeekableReader) -> Option<(Moment, Next)> {
        if self.is_over {
            return None;
        }
        if reader.place() != self.place {
            reader.seek(self.place);
        }
        let Some(piece_at) = reader.next_at() else {
            return Some((self.at, Next::End));
        };
        // At the same moment, bytes come before timeouts, however the bytes are split into pieces.
        let timeout = self.poll_timeout().filter(|_| !self.is_waiting);
        match timeout.map(|at| at.max(self.at)) {
            Some(at) if at < piece_at => Some((at, Next::Timeout)),
            _ => Some((piece_at, Next::Piece)),
        }
    }

    /// Time of the next change without an event.
    fn poll_timeout(&self) -> Option<Moment> {
        let station = self.station.poll_timeout();
        station.into_iter().chain(self.facts.poll_timeout()).min()
    }

    fn take_piece(&mut self, piece: Option<Piece<'_>>) {
        match piece {
            Some(Piece::Received([]) | Piece::Repeated(_)) | None => {}
            Some(Piece::Received(bytes)) => self.station.handle_bytes(self.at, bytes),
            Some(Piece::Sent(bytes)) => self.station.handle_sent(self.at, bytes),
            Some(Piece::Event(event)) => match from_recorded(self.at, &event) {
                Some(Event::Link(event)) => self.take_link(event),
                Some(Event::Mark(mark)) => self.marks.take(self.at, mark),
                Some(Event::Suspended(duration)) => {
                    self.station.handle_suspension(self.at, duration);
                }
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
        }
    }

    /// Takes a loss or return of the recorded link.
    fn take_link(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::Lost { .. } => self.is_lost = true,
            LinkEvent::Opened { .. } if self.is_lost => self.is_lost = false,
            LinkEvent::Opened { .. } | LinkEvent::Ended => return,
        }
        let event = match event {
            LinkEvent::Opened { .. } => opened(&self.name),
            event => event,
        };
        self.station.handle_link(self.at, event);
    }
}

impl Cursor for CaptureState {
    type Source = Box<dyn SeekableReader + Send>;

    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn for_search(mut self) -> Self {
        self.facts.end_estimate();
        self
    }

    fn at(&self) -> Moment {
        self.at
    }

    fn next_at(&self, reader: &mut Self::Source) -> Option<Moment> {
        self.next(&mut **reader).map(|(at, _)| at)
    }

    fn step(&mut self, reader: &mut Self::Source) {
        let Some((at, next)) = self.next(&mut **reader) else {
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
                self.take_piece(reader.next_piece());
                self.place = reader.place();
            }
            Next::End => {
                self.is_over = true;
                self.station.handle_link(self.at, LinkEvent::Ended);
            }
        }
        self.listen();
    }
}

/// Functions that start reading a capture at any time.
pub(super) static SHORTCUTS: Shortcuts<CaptureState> = Shortcuts {
    fresh: |state, reader, at| {
        let place = reader.find(at.saturating_sub(HEARD_BEFORE));
        let config = Arc::clone(state.facts.config());
        CaptureState::from(&state.name, config, place, &**reader).for_search()
    },
    about_line: |reader, number| reader.about_line(number),
    may_hold: |reader, landmark, from, until| reader.may_hold(landmark, from, until),
};

/// The timeline of an unread capture, which has only its first state.
#[must_use]
pub fn timeline(
    reader: Box<dyn SeekableReader + Send>,
    first: CaptureState,
) -> Timeline<CaptureState> {
    Timeline::unread(reader, &SHORTCUTS, first, SPACING)
}

/// The link of a capture, which is receive-only.
fn opened(name: &str) -> LinkEvent {
    LinkEvent::Opened {
        name: name.to_owned(),
        can_send: false,
    }
}

/// A finding of [`read_through`].
#[derive(Debug)]
pub enum Finding {
    /// A keyframe.
    State(Box<CaptureState>),
    /// All marks known so far.
    Marks(Vec<Moment>),
    /// The end of the capture, and its time.
    End(Moment),
}

/// Reads a capture to its end and reports keyframes, spaced by its length, until `report` returns `false` or the findings
/// are no longer received. Returns the first damaged part.
pub fn read_through(
    mut scene: CaptureState,
    reader: &mut Box<dyn SeekableReader + Send>,
    are_wanted: impl Fn() -> bool,
    mut report: impl FnMut(Finding) -> bool,
) -> Option<String> {
    let mut kept = Keyframes::new(SPACING);
    kept.push(scene.at, ());
    while scene.next_at(reader).is_some() {
        if !are_wanted() {
            return scene.damage;
        }
        let marks = scene.marks.moments().len();
        scene.step(reader);
        if scene.marks.moments().len() != marks
            && !report(Finding::Marks(scene.marks.moments().to_vec()))
        {
            return scene.damage;
        }
        if kept.wants(scene.at) {
            kept.push(scene.at, ());
            if !report(Finding::State(Box::new(scene.clone()))) {
                return scene.damage;
            }
        }
    }
    report(Finding::End(scene.at));
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
    use crate::capture::session_writer::{CHUNK_BYTES, TopicWriter};
    use crate::capture::topics::{Topic, TopicMessage};
    use crate::capture::{Capture, index};
    use proptest::prelude::*;

    use crate::event::OutageCause;
    use crate::statistics::{Damaged, Loss, Resync};

    /// The summary (`info`) of a capture, and its state after playing to the end.
    fn both(bytes: Vec<u8>) -> (Info, CaptureState) {
        let mut capture = Capture::read("", Box::new(Bytes::new(bytes.clone()))).unwrap();
        let info = Info::read(&mut capture);
        let mut reader = index::read(Arc::new(bytes), Path::new("")).unwrap();
        let mut scene = CaptureState::new("", Arc::default(), &*reader);
        while scene.next_at(&mut reader).is_some() {
            scene.step(&mut reader);
        }
        (info, scene)
    }

    fn counts(info: &Info) -> (u64, Loss, Damaged, Option<Resync>) {
        (info.lines.total(), info.loss, info.damaged, info.resync)
    }

    /// Asserts that `info`, the link panel and the raw panel agree.
    fn assert_the_same(bytes: Vec<u8>) -> (Info, CaptureState) {
        let (info, scene) = both(bytes);
        let link = &scene.facts.link;
        let panel = *link.statistics().unwrap();
        let said = (panel.lines, panel.loss, panel.damaged, panel.resync);
        assert_eq!(said, counts(&info));
        let seen = link.counters();
        assert_eq!(Loss::of(seen), info.loss);
        assert_eq!(seen.intact(), info.lines.total());
        assert_eq!(seen.lines, scene.facts.tally().lines, "lines");
        (info, scene)
    }

    #[test]
    fn every_count_is_the_same_at_the_end() {
        for name in [
            "house-noisy.txt",
            "demo-commands.mcap",
            "living-room-bursts.txt",
        ] {
            let folder = groundwave_captures::samples();
            let bytes = std::fs::read(folder.join(name)).unwrap();
            // The last piece may be of any kind.
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
    fn a_line_cut_off_by_a_lost_link_is_not_an_error() {
        let folder = groundwave_captures::samples();
        let bytes = std::fs::read(folder.join("house-clean.txt")).unwrap();
        let mut mcap = TopicWriter::new(Vec::new(), CHUNK_BYTES).unwrap();
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
        assert_eq!((info.loss.lines_lost, info.resync), (90, None));
        let [outage] = info.outages[..] else {
            panic!("{:?}", info.outages);
        };
        assert_eq!(outage.cause, OutageCause::Unplugged);
        assert_eq!(outage.begin, Moment::from_secs(2));
        assert_eq!(
            (outage.end, outage.lost.min),
            (Some(Moment::from_mins(1)), 90)
        );
    }

    /// Where an appended run begins, neither the screen nor `info` counts lost lines: their number is unknown.
    #[test]
    fn an_appended_run_is_a_restart_and_no_alarm() {
        let folder = groundwave_captures::samples();
        let bytes = std::fs::read(folder.join("house-clean.txt")).unwrap();
        let whole = bytes.len() - bytes.len() % 80;
        let (info, scene) = assert_the_same(bytes[..whole].repeat(3));
        let mut restarts = 0;
        for entry in scene.facts.log.newest_first() {
            restarts += u64::from(entry.text == "the robot restarted") * u64::from(entry.times);
            let counts = entry.text.replace("an unknown number of lines lost", "");
            assert!(!counts.contains("lines lost"), "{}", entry.text);
        }
        assert_eq!((restarts, info.restarts), (2, 2));
    }

    /// The fate of a number of lines.
    #[derive(Clone, Copy, Debug)]
    enum Fate {
        Arrive,
        Damage,
        Lose,
        Unplug,
    }

    fn any_fate() -> impl Strategy<Value = (Fate, usize)> {
        let fates = [Fate::Arrive, Fate::Damage, Fate::Lose, Fate::Unplug];
        (prop::sample::select(fates.to_vec()), 1..105_usize)
    }

    proptest! {
        /// A live station, `info` and the replay have the same figures, for every fate of the lines.
        #[test]
        fn live_and_replayed_figures_are_equal(fates in prop::collection::vec(any_fate(), 1..4)) {
            let folder = groundwave_captures::samples();
            let sample = std::fs::read(folder.join("house-clean.txt")).unwrap();
            let mut lines = sample.chunks_exact(80).enumerate();
            let mut mcap = TopicWriter::new(Vec::new(), CHUNK_BYTES).unwrap();
            let mut write = |topic, at: Moment, data: &[u8]| {
                let at_ns = at.as_nanos() as u64;
                let (log_time_ns, publish_time_ns) = (at_ns, at_ns);
                mcap.write(&TopicMessage { topic, log_time_ns, publish_time_ns, data }).unwrap();
            };
            let mut station = Station::new(arq::Config::new(1), false);
            station.handle_link(Moment::ZERO, opened(""));
            let (mut stream_offset, mut end) = (0, Moment::ZERO);
            let fates = [(Fate::Arrive, 5)].into_iter().chain(fates).chain([(Fate::Arrive, 30)]);
            for (fate, count) in fates {
                if let Fate::Unplug = fate {
                    let lost = LinkEvent::Lost { reason: "unplugged".to_owned() };
                    for event in [lost, opened("")] {
                        write(Topic::Station, end, &StationEvent::from(&event).encode_to_vec());
                        station.handle_link(end, event);
                    }
                }
                for (n, line) in lines.by_ref().take(count) {
                    let mut data = line.to_vec();
                    match fate {
                        Fate::Arrive => {}
                        Fate::Damage => data[n % 70] ^= 4,
                        Fate::Lose | Fate::Unplug => continue,
                    }
                    end = Moment::from_millis(n as u64 * 1000 / 3);
                    station.handle_bytes(end, &data);
                    let bytes = RawBytes { stream_offset, data };
                    stream_offset += 80;
                    write(Topic::RawRx, end, &bytes.encode_to_vec());
                }
            }
            station.handle_link(end, LinkEvent::Ended);
            let outages: Vec<_> = std::iter::from_fn(|| station.poll_event())
                .filter_map(|event| match event {
                    Event::Outage(outage) => Some(outage),
                    _ => None,
                })
                .filter(|outage| outage.end.is_some())
                .collect();
            let (info, _) = assert_the_same(mcap.finish().unwrap());
            let live = station.statistics(end);
            prop_assert_eq!((live.loss, live.damaged), (info.loss, info.damaged));
            prop_assert_eq!(outages, info.outages);
        }
    }
}
