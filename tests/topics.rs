//! Topics for other tools: complete, in metres and radians, in order and of bounded size.

use crate::streams;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::time::Duration;

use foxglove::messages::{
    FrameTransforms, Grid, LaserScan, Log, PoseInFrame, PosesInFrame, SceneUpdate,
};
use groundwave::capture::messages::{
    OutageMessage, RawBytes, StationEvent, Telemetry, UplinkEvent,
};
use groundwave::capture::own_lines::Values;
use groundwave::capture::topics::{Deriver, Origin, Topic, TopicMessage};
use groundwave::event::{CommandId, CommandStatus, Event, LinkEvent};
use groundwave::recorded::to_recorded;
use groundwave::request::Request;
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::{
    Ack, Body, CountersLine, Detail, Line, Note, ParameterLine, ParameterName, Printable, SongLine,
    TextLine,
};
use groundwave_protocol::{LINE_BYTES, Waypoint};
use proptest::prelude::*;
use prost::Message;

const START_NS: u64 = 1_741_944_413_000_000_000;
const LINE_NS: u64 = 1_000_000_000 / 3;

#[derive(Clone, Debug, PartialEq)]
struct Kept {
    topic: Topic,
    log_time_ns: u64,
    publish_time_ns: u64,
    data: Vec<u8>,
}

fn keep(kept: &mut Vec<Kept>) -> impl FnMut(TopicMessage<'_>) -> Result<(), ()> {
    |message| {
        kept.push(Kept {
            topic: message.topic,
            log_time_ns: message.log_time_ns,
            publish_time_ns: message.publish_time_ns,
            data: message.data.to_vec(),
        });
        Ok(())
    }
}

/// All messages derived from a stream in reads of `sizes` bytes, each at the time at which its line ends.
fn derive(stream: &[u8], sizes: &[usize]) -> Vec<Kept> {
    derive_at(stream, sizes, |offset| {
        START_NS + offset.div_ceil(80) * LINE_NS
    })
}

/// Messages of bytes that are read in pieces; a read that ends at an offset is at a time.
fn derive_at(stream: &[u8], sizes: &[usize], at_ns: impl Fn(u64) -> u64) -> Vec<Kept> {
    let mut deriver = Deriver::new();
    let mut kept = Vec::new();
    let mut sizes = sizes.iter().cycle();
    let mut offset = 0;
    while offset < stream.len() {
        let size = *sizes.next().unwrap();
        let read = &stream[offset..stream.len().min(offset + size)];
        offset += read.len();
        let at_ns = at_ns(offset as u64);
        deriver.handle_rx(at_ns, read, keep(&mut kept)).unwrap();
    }
    deriver.finish(keep(&mut kept)).unwrap();
    kept
}

fn of(kept: &[Kept], topic: Topic) -> Vec<&Kept> {
    kept.iter()
        .filter(|message| message.topic == topic)
        .collect()
}

fn decoded<M: Message + Default>(kept: &[Kept], topic: Topic) -> Vec<M> {
    of(kept, topic)
        .into_iter()
        .map(|message| M::decode(&*message.data).unwrap())
        .collect()
}

const ID: CommandId = CommandId(7);

fn asked(waypoints: Vec<Waypoint>) -> Event {
    Event::Asked {
        id: ID,
        request: Request::Route(waypoints),
        by: None,
    }
}

#[test]
fn raw_bytes_are_the_stream_and_telemetry_is_every_line() {
    let stream = streams::noisy(600, 5);
    let kept = derive(&stream, &[80]);
    let mut concatenated = Vec::new();
    for raw in decoded::<RawBytes>(&kept, Topic::RawRx) {
        assert_eq!(raw.stream_offset, concatenated.len() as u64);
        assert!(raw.data.len() < 160);
        concatenated.extend(raw.data);
    }
    assert_eq!(concatenated, stream);
    let (mut decoder, mut rest) = (Decoder::default(), &stream[..]);
    let lines: Vec<_> = std::iter::from_fn(|| decoder.next_own_line(&mut rest)).collect();
    let expected: Vec<Telemetry> = lines.iter().map(Telemetry::from).collect();
    assert_eq!(decoded::<Telemetry>(&kept, Topic::Telemetry), expected);
    for pair in kept.windows(2) {
        assert!(pair[0].log_time_ns <= pair[1].log_time_ns);
    }
}

/// Lines too short to be intact share messages, so a flood of line feeds stays small.
#[test]
fn a_flood_of_short_lines_makes_few_messages() {
    for (line, flood) in [("\n", 80), ("x\r\n", 81), ("twelve bytes\n", 91)] {
        let stream = line.repeat(10_000).into_bytes();
        for size in [1, 33, 4096] {
            let raw = decoded::<RawBytes>(&derive(&stream, &[size]), Topic::RawRx);
            // A read that comes late ends a message.
            let most = stream.len().div_ceil(flood) + stream.len() / 4096;
            assert!(raw.len() <= most, "{line:?} by {size}: {}", raw.len());
            let all: Vec<u8> = raw.into_iter().flat_map(|raw| raw.data).collect();
            assert!(all == stream, "{line:?} by {size}");
        }
    }
}

/// A short line keeps its time, unless others follow at once.
#[test]
fn a_lone_line_feed_keeps_its_time() {
    let mut deriver = Deriver::new();
    let mut kept = Vec::new();
    for (at_ns, bytes) in [
        (0, &b"\n"[..]),
        (LINE_NS / 2, b"\r\n"),
        (9 * LINE_NS, b"x\n"),
    ] {
        deriver
            .handle_rx(START_NS + at_ns, bytes, keep(&mut kept))
            .unwrap();
    }
    let line = &streams::clean(1)[..80];
    deriver
        .handle_rx(START_NS + 20 * LINE_NS, line, keep(&mut kept))
        .unwrap();
    let raw = of(&kept, Topic::RawRx);
    let times = raw.iter().map(|message| message.log_time_ns - START_NS);
    assert_eq!(
        times.collect::<Vec<_>>(),
        [LINE_NS / 2, 9 * LINE_NS, 20 * LINE_NS]
    );
}

/// Messages have the canonical protobuf form, like those of generated encoders: fields in the order of their tags,
/// defaults omitted.
#[test]
fn messages_are_as_derived_encoders_write_them() {
    fn again<M: Message + Default>(data: &[u8]) -> Vec<u8> {
        M::decode(data).unwrap().encode_to_vec()
    }
    let ack = Ack {
        detail: Detail::Idle {
            owner: 0,
            robot_id: 7,
        },
        ..Ack::default()
    };
    let told = [
        Body::Parameter(ParameterLine {
            place: 2,
            count: 9,
            name: ParameterName::new("gain"),
            value: -3,
            kept: 12,
            least: i32::from(i16::MIN),
            most: 0,
            unit: Printable::new(""),
        }),
        Body::Song(SongLine::new(
            [(523, 4), (0, 1)].map(|(hz, ticks)| Note { hz, ticks }),
        )),
        Body::Text(TextLine::new("")),
        // The reboot before these is an outage, whose lines the next line C counts.
        Body::Counters(CountersLine {
            robot_id: 7,
            uptime_s: 1,
            boots: 8,
            ..CountersLine::default()
        }),
        // The outage is reported half a second later, since nothing explained it until then.
        Body::Text(TextLine::new("")),
    ];
    let told = (1..).zip(told).map(|(sequence, body)| Line {
        sequence,
        body,
        ack,
    });
    let mut stream = streams::noisy(10_000, 7);
    stream.extend(told.flat_map(|line| line.encode()));
    let mut deriver = Deriver::new();
    let mut kept = Vec::new();
    for count in [0, 1, 100] {
        let waypoints = (0..count).map(|n| Waypoint::new(n, -n).unwrap()).collect();
        let status = CommandStatus::Confirmed { digest: Some(99) };
        for event in [asked(waypoints), Event::Command { id: ID, status }] {
            let event = to_recorded(Duration::ZERO, &event).unwrap();
            deriver
                .handle_event(START_NS, &event, keep(&mut kept))
                .unwrap();
        }
    }
    // At time zero, and at times without a fraction of a second.
    let (parts, last) = stream.split_at(stream.len() - LINE_BYTES);
    for (at_ns, part) in [0, START_NS, START_NS + LINE_NS]
        .into_iter()
        .zip(parts.chunks(parts.len() / 3 + 1))
        .chain([(START_NS + 3 * LINE_NS, last)])
    {
        deriver.handle_rx(at_ns, part, keep(&mut kept)).unwrap();
    }
    let (mut decoder, mut rest) = (Decoder::default(), &stream[..]);
    let lines: Vec<_> = std::iter::from_fn(|| decoder.next_own_line(&mut rest)).collect();
    let expected: Vec<Telemetry> = lines.iter().map(Telemetry::from).collect();
    assert_eq!(decoded::<Telemetry>(&kept, Topic::Telemetry), expected);
    let mut counts = BTreeMap::new();
    for message in &kept {
        let again = match message.topic {
            Topic::RawRx | Topic::RawTx => again::<RawBytes>,
            Topic::Telemetry => again::<Telemetry>,
            Topic::Uplink => again::<UplinkEvent>,
            Topic::Station => again::<StationEvent>,
            Topic::Outages => again::<OutageMessage>,
            Topic::Tf | Topic::TfMap => again::<FrameTransforms>,
            Topic::Pose | Topic::PoseCorrected => again::<PoseInFrame>,
            Topic::Path => again::<PosesInFrame>,
            Topic::Sonar => again::<LaserScan>,
            Topic::Map => again::<Grid>,
            Topic::Markers => again::<SceneUpdate>,
            Topic::Log => again::<Log>,
            Topic::Values => again::<Values>,
        };
        assert_eq!(again(&message.data), message.data, "{:?}", message.topic);
        *counts.entry(message.topic).or_insert(0) += 1;
    }
    for topic in Topic::ALL {
        let is_kept =
            topic.origin() != Origin::Event && !matches!(topic, Topic::RawTx | Topic::Values);
        assert_eq!(counts.contains_key(&topic), is_kept, "{topic:?}");
    }
}

/// Poses are converted from inches and degrees clockwise from +Y to metres and radians with x ahead, y left,
/// counter-clockwise.
#[test]
fn poses_are_in_the_conventions_of_others() {
    let stream = streams::lines(60);
    let kept = derive(&stream, &[80]);
    let (lines, _) = streams::live(&stream);
    let states: Vec<_> = lines
        .iter()
        .filter_map(|received| match received {
            Received::Line(line, _) => match line.body {
                Body::State(state) => Some(state),
                _ => None,
            },
            Received::Ack(_) => None,
        })
        .collect();
    let transforms = decoded::<FrameTransforms>(&kept, Topic::Tf);
    let poses = decoded::<PoseInFrame>(&kept, Topic::Pose);
    let scans = decoded::<LaserScan>(&kept, Topic::Sonar);
    assert_eq!(states.len(), 50);
    assert_eq!([transforms.len(), poses.len(), scans.len()], [50; 3]);
    for (((state, transforms), pose), scan) in
        states.iter().zip(&transforms).zip(&poses).zip(&scans)
    {
        let transform = &transforms.transforms[0];
        assert_eq!(transform.parent_frame_id, "odom");
        assert_eq!(transform.child_frame_id, "base_link");
        let at = transform.translation.unwrap();
        assert!((at.x - f64::from(state.y_tenths_in) * 0.00254).abs() < 1e-9);
        assert!((at.y + f64::from(state.x_tenths_in) * 0.00254).abs() < 1e-9);
        let turn = transform.rotation.unwrap();
        let yaw_rad = 2.0 * turn.z.atan2(turn.w);
        let expected = -f64::from(state.theta_deg).to_radians();
        assert!(
            ((yaw_rad - expected).sin()).abs() < 1e-9,
            "{yaw_rad} {expected}"
        );
        assert!(((yaw_rad - expected).cos() - 1.0).abs() < 1e-9);
        let pose = pose.pose.unwrap();
        assert_eq!(pose.position, Some(at));
        assert_eq!(pose.orientation, Some(turn));
        let range_m = |inches: Option<u16>| inches.map_or(f64::INFINITY, |i| f64::from(i) * 0.0254);
        assert_eq!(
            scan.ranges,
            [range_m(state.sonar_right_in), range_m(state.sonar_left_in)]
        );
        assert!((scan.start_angle + 7.5 * FRAC_PI_2 / 90.0).abs() < 1e-12);
        assert!((scan.end_angle - 7.5 * FRAC_PI_2 / 90.0).abs() < 1e-12);
        assert_eq!(scan.frame_id, "base_link");
    }
}

#[test]
fn the_robots_own_time_is_the_publish_time() {
    let kept = derive(&streams::lines(60), &[80]);
    let telemetry = of(&kept, Topic::Telemetry);
    // The first line C is the sixth line.
    for message in &telemetry[..5] {
        assert_eq!(message.publish_time_ns, message.log_time_ns);
    }
    let zero_ns = telemetry[5].publish_time_ns;
    for (n, message) in (0..).zip(&telemetry[5..11]) {
        let expected = zero_ns + n * LINE_NS;
        assert!(message.publish_time_ns.abs_diff(expected) < 10, "line {n}");
    }
    for raw in of(&kept, Topic::RawRx) {
        assert_eq!(raw.publish_time_ns, raw.log_time_ns);
    }
}

/// The robot drives 3.5 inches per line for an hour.
#[test]
fn the_path_is_bounded_and_sent_from_time_to_time() {
    let kept = derive(&streams::lines(10_000), &[80]);
    let paths = decoded::<PosesInFrame>(&kept, Topic::Path);
    assert!((100..1000).contains(&paths.len()), "{}", paths.len());
    assert!(paths.iter().all(|path| path.poses.len() <= 512));
    assert_eq!(paths.last().unwrap().poses.len(), 512);
    let bytes: usize = of(&kept, Topic::Path).iter().map(|m| m.data.len()).sum();
    let all: usize = kept.iter().map(|message| message.data.len()).sum();
    assert!(bytes * 2 < all, "the path takes {bytes} of {all} bytes");
    let scenes = of(&kept, Topic::Markers);
    assert!(scenes.iter().all(|scene| scene.data.len() < 20_000));
    assert!(scenes.len() > 150, "{}", scenes.len());
}

#[test]
fn markers_show_body_bumps_and_the_confirmed_list() {
    let mut deriver = Deriver::new();
    let mut kept = Vec::new();
    let waypoints = [(0, 0), (0, 48), (48, 48)].map(|(x, y)| Waypoint::new(x, y).unwrap());
    let statuses = [
        CommandStatus::Sent { frames: 1 },
        CommandStatus::Sent { frames: 2 },
        CommandStatus::Progress {
            acknowledged: 2,
            total: 3,
        },
        CommandStatus::Confirmed { digest: Some(99) },
    ];
    let statuses = statuses.map(|status| Event::Command { id: ID, status });
    for event in [asked(waypoints.to_vec())].into_iter().chain(statuses) {
        let event = to_recorded(Duration::ZERO, &event).unwrap();
        deriver
            .handle_event(START_NS, &event, keep(&mut kept))
            .unwrap();
    }
    deriver
        .handle_rx(START_NS, &streams::lines(30), keep(&mut kept))
        .unwrap();
    let uplink = decoded::<UplinkEvent>(&kept, Topic::Uplink);
    let codes: Vec<&str> = uplink[..5]
        .iter()
        .map(|event| event.status.as_str())
        .collect();
    assert_eq!(codes, ["queued", "sent", "sent", "progress", "confirmed"]);
    assert_eq!(uplink[0].waypoints_y_in, [0, 48, 48]);
    assert_eq!(uplink[4].list_digest, Some(99));
    let robot_says = |code| uplink.iter().any(|event| event.status == code);
    assert!(robot_says(UplinkEvent::ACKNOWLEDGEMENT) && robot_says(UplinkEvent::LIST));
    let scene = decoded::<SceneUpdate>(&kept, Topic::Markers).pop().unwrap();
    let entity = |id: &str| scene.entities.iter().find(|e| e.id == id).unwrap();
    assert_eq!(entity("robot").frame_id, "base_link");
    assert_eq!(entity("robot").cylinders.len(), 1);
    let route = &entity("waypoints").lines[0].points;
    assert_eq!(route.len(), 3);
    assert!((route[2].x - 1.2192).abs() < 1e-9 && (route[2].y + 1.2192).abs() < 1e-9);
    assert_eq!(entity("bumps").spheres.len(), 1);
    let log: Vec<String> = decoded::<Log>(&kept, Topic::Log)
        .into_iter()
        .map(|log| format!("{}: {}", log.name, log.message))
        .collect();
    assert_eq!(log[0], "command: route of 3: confirmed");
    assert!(log.contains(&"robot: bump left".to_owned()), "{log:?}");
}

#[test]
fn every_topic_has_a_schema_that_others_can_use() {
    for topic in Topic::ALL {
        let schema = topic.schema();
        assert!(!schema.descriptors.is_empty(), "{topic:?}");
        let set = prost_types::FileDescriptorSet::decode(&*schema.descriptors).unwrap();
        let (package, name) = schema.name.split_once('.').unwrap();
        let has_it = set.file.iter().any(|file| {
            file.package() == package && file.message_type.iter().any(|m| m.name() == name)
        });
        assert!(has_it, "{}", schema.name);
        assert_eq!(Topic::from_name(topic.name()), Some(topic));
    }
}

#[test]
fn events_that_are_no_part_of_a_capture_are_left_out() {
    assert_eq!(to_recorded(Duration::ZERO, &Event::Tick), None);
    let lost = Event::Link(LinkEvent::Lost {
        reason: "unplugged".to_owned(),
    });
    assert!(to_recorded(Duration::ZERO, &lost).unwrap().is_urgent());
}

/// Topics from lines that the station decoded equal those from the bytes.
#[test]
fn topics_of_decoded_lines_are_those_of_the_bytes() {
    let (mut of_bytes, mut of_lines) = (Deriver::new(), Deriver::of_decoded_lines());
    let (mut expected, mut kept) = (Vec::new(), Vec::new());
    let mut decoder = Decoder::default();
    for run in streams::noisy(3000, 7).split_inclusive(|byte| *byte == b'\n') {
        of_bytes
            .handle_rx(START_NS, run, keep(&mut expected))
            .unwrap();
        of_lines.handle_rx(START_NS, run, keep(&mut kept)).unwrap();
        for received in decoder.lines(run) {
            of_lines
                .handle_received(START_NS, &received, keep(&mut kept))
                .unwrap();
        }
    }
    assert!(kept.len() > 3000, "{}", kept.len());
    assert_eq!(kept, expected);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Messages do not depend on how the bytes arrive at one time; later ones are not joined to a short line.
    #[test]
    fn reads_of_any_size_give_the_same_messages(
        seed in any::<u64>(),
        sizes in prop::collection::vec(1_usize..300, 1..20),
    ) {
        let stream = streams::noisy(60, seed);
        let topics = |sizes: &[usize]| -> Vec<(Topic, Vec<u8>)> {
            derive_at(&stream, sizes, |_| START_NS).iter()
                .filter(|m| matches!(m.topic, Topic::RawRx | Topic::Telemetry | Topic::Uplink))
                .map(|m| (m.topic, m.data.clone()))
                .collect()
        };
        prop_assert!(topics(&sizes) == topics(&[80]));
    }
}
