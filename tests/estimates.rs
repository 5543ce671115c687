//! The ground's estimate in recordings and live views, for the real robot program in a simulated house.

use std::sync::Arc;
use std::time::Duration;
use std::{fs, iter};

use foxglove::messages::{FrameTransforms, Grid, PoseInFrame};
use groundwave::event::Event;
use groundwave::model::{Config, Facts};
use groundwave::recorded::to_recorded;
use groundwave::runtime::Reports;
use groundwave_captures::cut::{Window, cut_mcap};
use groundwave_captures::messages::{EstimateMessage, FloorKind, FloorMessage};
use groundwave_captures::session::since_1970_ns;
use groundwave_captures::session_writer::SessionWriter;
use groundwave_captures::topics::{Deriver, Topic, TopicMessage};
use groundwave_captures::verify::verify_mcap;
use groundwave_captures::when::When;
use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::telemetry::{Body, Line};
use prost::Message;
use sr04_sim::{SimulationConfig, World};

use crate::common::lines;
use crate::programs::{expect, scratch};
use crate::recordings::session;

const M_PER_IN: f64 = 0.0254;

/// Reports of a session, and the messages that are derived from them.
#[derive(Default)]
struct Session {
    estimates: Vec<(Duration, EstimateMessage)>,
    floors: Vec<(Duration, FloorMessage)>,
    poses: Vec<PoseInFrame>,
    transforms: Vec<FrameTransforms>,
    grids: Vec<Grid>,
}

/// A robot prowls for some minutes. `change` changes its lines; `take` gets each line and the reports that follow from it.
fn prowl(
    config: &SimulationConfig,
    minutes: u64,
    change: fn(Duration, &mut Line),
    mut take: impl FnMut(Duration, [u8; LINE_BYTES], Vec<Event>),
) {
    let mut facts = Facts::new(Arc::new(Config::default()));
    let mut reports = Reports::default();
    lines(
        config,
        Duration::from_mins(minutes),
        |now, mut line, raw| {
            change(now, &mut line);
            let line = Box::new(line);
            let event = Event::Line { line, raw };
            facts.update(now, &event);
            take(now, raw, reports.take(now, &event, &facts));
        },
    );
}

fn house(seed: u64) -> SimulationConfig {
    SimulationConfig::new(World::built_in("house").unwrap(), seed)
}

impl Session {
    /// A session with bit errors; `change` changes its lines.
    fn new(seed: u64, minutes: u64, change: fn(Duration, &mut Line)) -> Self {
        let mut session = Self::default();
        let mut deriver = Deriver::of_decoded_lines();
        let mut config = house(seed);
        config.channel.ber = 1e-4;
        prowl(&config, minutes, change, |now, _, reports| {
            for report in reports {
                session.take(now, &report, &mut deriver);
            }
        });
        session
    }

    fn take(&mut self, now: Duration, report: &Event, deriver: &mut Deriver) {
        match report {
            Event::Estimate(estimate) => self.estimates.push((now, *estimate)),
            Event::Floor(floor) => self.floors.push((now, (**floor).clone())),
            _ => return,
        }
        let recorded = to_recorded(now, report).unwrap();
        let at_ns = now.as_nanos() as u64;
        let keep = |message: TopicMessage<'_>| {
            match message.topic {
                Topic::PoseCorrected => self.poses.push(decoded(&message)),
                Topic::TfMap => self.transforms.push(decoded(&message)),
                Topic::Map => self.grids.push(decoded(&message)),
                Topic::Station => {}
                // An unknown heading.
                Topic::Log => assert!(
                    self.estimates
                        .last()
                        .is_some_and(|it| it.1.corrected.is_none())
                ),
                topic => panic!("{topic:?}"),
            }
            Ok::<(), ()>(())
        };
        deriver.handle_event(at_ns, &recorded, keep).unwrap();
    }
}

fn decoded<M: Message + Default>(message: &TopicMessage<'_>) -> M {
    M::decode(message.data).unwrap()
}

fn are_apart<T>(reports: &[(Duration, T)], least: Duration) -> bool {
    reports
        .windows(2)
        .all(|two| two[1].0.saturating_sub(two[0].0) >= least)
}

#[test]
fn pose_and_floor_of_the_ground_are_reported_and_derived() {
    let session = Session::new(1, 15, |_, _| {});
    assert!(are_apart(&session.estimates, Duration::from_secs(1)));
    assert!(are_apart(&session.floors, Duration::from_mins(1)));
    let count = session.estimates.len();
    assert!((600..=900).contains(&count), "{count} poses in 15 min");
    let count = session.floors.len();
    assert!((5..=15).contains(&count), "{count} floors in 15 min");

    let corrected: Vec<_> = session
        .estimates
        .iter()
        .filter_map(|it| it.1.corrected)
        .collect();
    assert_eq!(session.poses.len(), corrected.len());
    assert_eq!(session.transforms.len(), corrected.len());
    for (pose, corrected) in session.poses.iter().zip(&corrected) {
        assert_eq!(pose.frame_id, "map");
        let at = pose.pose.unwrap().position.unwrap();
        assert!((at.x - corrected.y_in * M_PER_IN).abs() < 1e-9, "{at:?}");
        assert!((at.y + corrected.x_in * M_PER_IN).abs() < 1e-9, "{at:?}");
    }

    assert_eq!(session.grids.len(), session.floors.len());
    let (grid, (_, floor)) = (
        session.grids.last().unwrap(),
        session.floors.last().unwrap(),
    );
    let cells = floor.cells().unwrap();
    let count = |kinds: &[FloorKind]| cells.iter().filter(|it| kinds.contains(it)).count();
    let valued = |value: i8| {
        grid.data
            .iter()
            .filter(|it| it.cast_signed() == value)
            .count()
    };
    let known = [
        count(&[FloorKind::Free]),
        count(&[FloorKind::Obstacle, FloorKind::Drop]),
    ];
    assert_eq!([valued(0), valued(100)], known);
    assert!(
        known[0] > 1000 && known[1] > 50,
        "{known:?} cells free and occupied"
    );
    assert_eq!(grid.data.len(), cells.len());
}

/// Without echoes, the heading becomes unknown after some driving.
#[test]
fn unknown_heading_is_reported_once() {
    let session = Session::new(1, 15, |_, line| {
        if let Body::State(state) = &mut line.body {
            state.sonar_left_in = None;
            state.sonar_right_in = None;
        }
    });
    let unknown = session.estimates.iter().map(|it| it.1.corrected.is_none());
    let unknown: Vec<bool> = unknown.collect();
    assert!(unknown.contains(&true), "the heading is lost");
    assert!(!unknown.windows(2).any(|two| two[0] && two[1]));
}

/// After a restart, the floor before is in another frame; until the walls are known again, a viewer is to show none.
#[test]
fn restart_of_the_robot_takes_the_floor_back() {
    const RESTART: Duration = Duration::from_mins(6);
    let session = Session::new(1, 10, |now, line| {
        if now >= RESTART {
            line.ack.boot = (line.ack.boot + 1) % 8;
        }
    });
    let (before, after): (Vec<_>, Vec<_>) =
        session.floors.iter().partition(|(at, _)| *at < RESTART);
    assert!(before.len() > 2, "{} floors before", before.len());
    let (at, taken_back) = after[0];
    assert!(*at < RESTART + Duration::from_secs(3), "{at:?}");
    assert_eq!(taken_back.cells(), Some(vec![FloorKind::Unknown]));
    assert!(after.len() > 1 && after[1].1.cells().unwrap().len() > 100);
}

/// The bytes and reports of a session come back from a recording, and the floor of a hall does not stop a reader.
#[test]
fn recording_with_estimates_is_verified_cut_and_read() {
    let kinds = [FloorKind::Free, FloorKind::Obstacle].into_iter().cycle();
    let hall = FloorMessage::new((0.0, 0.0), 3.0, 100, kinds.take(16_000));
    let hall = Box::new(hall.unwrap());
    let mut writer = SessionWriter::new(Vec::new(), &session()).unwrap();
    let start_ns = since_1970_ns(session().start);
    let mut counts = [0; 2];
    prowl(
        &house(1),
        6,
        |_, _| {},
        |now, raw, reports| {
            let at_ns = start_ns + now.as_nanos() as u64;
            writer.handle_rx(at_ns, &raw).unwrap();
            for report in reports {
                counts[0] += u64::from(matches!(report, Event::Estimate(_)));
                counts[1] += u64::from(matches!(report, Event::Floor(_)));
                let hall = matches!(report, Event::Floor(_)).then(|| Event::Floor(hall.clone()));
                for event in iter::once(report).chain(hall) {
                    let recorded = to_recorded(now, &event).unwrap();
                    writer.handle_event(at_ns, &recorded).unwrap();
                }
            }
        },
    );
    let mcap = writer.finish().unwrap();
    let [poses, floors] = counts;
    assert!(poses > 100 && floors > 2, "{counts:?}");

    let verdict = verify_mcap(&mcap[..], None).unwrap();
    assert!(verdict.is_good(), "{:?}", verdict.faults);
    assert_eq!(verdict.derived_unchecked, 0);
    let count = |topic: Topic| verdict.messages.get(topic.name()).copied();
    for topic in [Topic::PoseCorrected, Topic::TfMap] {
        assert_eq!(count(topic), Some(poses), "{topic:?}");
    }
    assert_eq!(count(Topic::Map), Some(2 * floors));

    let mut piece = Vec::new();
    let half = Window {
        from: Some(When::Since(Duration::from_mins(3))),
        to: None,
    };
    assert_eq!(cut_mcap(&mcap[..], half, &mut piece).unwrap().problem, None);
    let verdict = verify_mcap(&piece[..], None).unwrap();
    assert!(verdict.is_good(), "{:?}", verdict.faults);

    let folder = scratch("estimates");
    let path = folder.join("run.mcap");
    fs::write(&path, &mcap).unwrap();
    let path = path.display().to_string();
    let (table, _) = expect(0, &["export", &path, "--to", "csv", "-o", "-"]);
    assert!(table.lines().count() > 1000);
    fs::remove_dir_all(folder).unwrap();
}
