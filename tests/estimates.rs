//! The ground's estimate in recordings and live views, for the real robot program in a simulated house.

use std::sync::Arc;
use std::time::Duration;

use foxglove::messages::{FrameTransforms, Grid, PoseInFrame};
use groundwave::event::Event;
use groundwave::model::{Config, Facts};
use groundwave::recorded::to_recorded;
use groundwave::runtime::Reports;
use groundwave_captures::messages::{EstimateMessage, FloorKind, FloorMessage};
use groundwave_captures::topics::{Deriver, Topic, TopicMessage};
use groundwave_protocol::telemetry::Body;
use prost::Message;
use sr04_sim::{SimulationConfig, World};

use crate::common::lines;

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

impl Session {
    /// A robot prowls for some minutes with bit errors, with or without echoes.
    fn new(seed: u64, minutes: u64, has_echoes: bool) -> Self {
        let mut session = Self::default();
        let mut facts = Facts::new(Arc::new(Config::default()));
        let (mut reports, mut deriver) = (Reports::default(), Deriver::of_decoded_lines());
        let mut config = SimulationConfig::new(World::built_in("house").unwrap(), seed);
        config.channel.ber = 1e-4;
        lines(
            &config,
            Duration::from_mins(minutes),
            |now, mut line, raw| {
                if let Body::State(state) = &mut line.body
                    && !has_echoes
                {
                    state.sonar_left_in = None;
                    state.sonar_right_in = None;
                }
                let event = Event::Line {
                    line: Box::new(line),
                    raw,
                };
                facts.update(now, &event);
                for report in reports.take(now, &event, &facts) {
                    session.take(now, &report, &mut deriver);
                }
            },
        );
        session
    }

    fn take(&mut self, now: Duration, report: &Event, deriver: &mut Deriver) {
        match report {
            Event::Estimate(estimate) => self.estimates.push((now, *estimate)),
            Event::Floor(floor) => self.floors.push((now, (**floor).clone())),
            _ => return,
        }
        let recorded = to_recorded(report).unwrap();
        let at_ns = now.as_nanos() as u64;
        let keep = |message: TopicMessage<'_>| {
            match message.topic {
                Topic::PoseCorrected => self.poses.push(decoded(&message)),
                Topic::Tf => self.transforms.push(decoded(&message)),
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
    let session = Session::new(1, 15, true);
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
    let session = Session::new(1, 15, false);
    let unknown = session.estimates.iter().map(|it| it.1.corrected.is_none());
    let unknown: Vec<bool> = unknown.collect();
    assert!(unknown.contains(&true), "the heading is lost");
    assert!(!unknown.windows(2).any(|two| two[0] && two[1]));
}
