//! Builds and encodes the messages of the topics.

use foxglove::messages::log::Level;
use foxglove::messages::{FrameTransform, FrameTransforms, LaserScan, Log, PoseInFrame};
use groundwave_protocol::decoder::Received;
use groundwave_protocol::telemetry::StateLine;
use prost::Message;

use super::geometry::{BASE, M_PER_IN, ODOM, Place, timestamp, upright};
use super::{Topic, TopicMessage};
use crate::messages::{RawBytes, Telemetry};

/// Angle of each sonar from straight ahead, radians.
const SONAR_RAD: f64 = 7.5 / 180.0 * std::f64::consts::PI;

/// Encodes messages one at a time into a reused buffer.
#[derive(Debug, Default)]
pub(super) struct Encoder {
    buffer: Vec<u8>,
    /// The latest message of bytes; its memory is used again.
    raw: RawBytes,
}

impl Encoder {
    pub(super) fn encode(&mut self, message: &impl Message) {
        self.buffer.clear();
        // Encoding into a vector cannot fail.
        let _ = message.encode(&mut self.buffer);
    }

    pub(super) fn raw(&mut self, stream_offset: u64, bytes: &[u8]) {
        let mut raw = std::mem::take(&mut self.raw);
        raw.stream_offset = stream_offset;
        raw.data.clear();
        raw.data.extend_from_slice(bytes);
        self.encode(&raw);
        self.raw = raw;
    }

    pub(super) fn telemetry(&mut self, received: &Received) {
        self.encode(&Telemetry::from(received));
    }

    pub(super) fn transforms(&mut self, now_ns: u64, place: Place) {
        self.encode(&FrameTransforms {
            transforms: vec![FrameTransform {
                timestamp: Some(timestamp(now_ns)),
                parent_frame_id: ODOM.to_owned(),
                child_frame_id: BASE.to_owned(),
                translation: Some(place.translation()),
                rotation: Some(place.rotation()),
            }],
        });
    }

    pub(super) fn pose(&mut self, now_ns: u64, place: Place) {
        self.encode(&PoseInFrame {
            timestamp: Some(timestamp(now_ns)),
            frame_id: ODOM.to_owned(),
            pose: Some(place.pose()),
        });
    }

    /// Encodes the sonars, the right one first because angles grow to the left. A missing echo is encoded as infinity: there is no obstacle in
    /// range.
    pub(super) fn scan(&mut self, now_ns: u64, state: &StateLine) {
        let range_m = |inches: Option<u16>| {
            inches.map_or(f64::INFINITY, |inches| f64::from(inches) * M_PER_IN)
        };
        self.encode(&LaserScan {
            timestamp: Some(timestamp(now_ns)),
            frame_id: BASE.to_owned(),
            pose: Some(upright([0.0; 3])),
            start_angle: -SONAR_RAD,
            end_angle: SONAR_RAD,
            ranges: vec![range_m(state.sonar_right_in), range_m(state.sonar_left_in)],
            intensities: Vec::new(),
        });
    }

    pub(super) fn log(&mut self, now_ns: u64, level: Level, name: &str, text: &str) {
        self.encode(&Log {
            timestamp: Some(timestamp(now_ns)),
            level: level as i32,
            message: text.to_owned(),
            name: name.to_owned(),
            ..Log::default()
        });
    }

    pub(super) fn message(
        &self,
        topic: Topic,
        now_ns: u64,
        robot_ns: Option<u64>,
    ) -> TopicMessage<'_> {
        TopicMessage {
            topic,
            log_time_ns: now_ns,
            publish_time_ns: robot_ns.unwrap_or(now_ns),
            data: &self.buffer,
        }
    }
}
