//! Messages on their way out: encoded one at a time into the same memory.

use foxglove::messages::log::Level;
use groundwave_protocol::decoder::Received;
use groundwave_protocol::telemetry::StateLine;
use prost::Message;

use super::geometry::{BASE, M_PER_IN, ODOM, Place, put_timestamp, upright};
use super::path::Path;
use super::scene::Scene;
use super::{Topic, TopicMessage};
use crate::messages::{RawBytes, Telemetry};
use crate::protobuf::Protobuf;

/// The sonars look so far to the right and to the left.
const SONAR_RAD: f64 = 7.5 / 180.0 * std::f64::consts::PI;

/// Encodes one message at a time into the same memory.
#[derive(Debug, Default)]
pub(super) struct Encoder {
    buffer: Vec<u8>,
}

impl Encoder {
    fn begin(&mut self) -> &mut Vec<u8> {
        self.buffer.clear();
        &mut self.buffer
    }

    pub(super) fn encode(&mut self, message: &impl Message) {
        // A vector grows as it must: there is nothing that could fail.
        let _ = message.encode(self.begin());
    }

    /// A `RawBytes`.
    pub(super) fn raw(&mut self, stream_offset: u64, bytes: &[u8]) {
        RawBytes::encode_parts(stream_offset, bytes, self.begin());
    }

    /// A `Telemetry`.
    pub(super) fn telemetry(&mut self, received: &Received) {
        Telemetry::encode_received(received, self.begin());
    }

    /// A `foxglove.FrameTransforms`.
    pub(super) fn transforms(&mut self, now_ns: u64, place: Place) {
        self.begin().message(1, |to| {
            put_timestamp(to, now_ns);
            to.string(2, ODOM);
            to.string(3, BASE);
            to.message(4, |to| place.translation(to));
            to.message(5, |to| place.rotation(to));
        });
    }

    /// A `foxglove.PoseInFrame`.
    pub(super) fn pose(&mut self, now_ns: u64, place: Place) {
        let to = self.begin();
        put_timestamp(to, now_ns);
        to.string(2, ODOM);
        to.message(3, |to| place.pose(to));
    }

    /// A `foxglove.LaserScan`. The right one first: angles grow to the left. No echo is no obstacle within reach:
    /// infinity.
    pub(super) fn scan(&mut self, now_ns: u64, state: &StateLine) {
        let range_m = |inches: Option<u16>| {
            inches.map_or(f64::INFINITY, |inches| f64::from(inches) * M_PER_IN)
        };
        let right_m = range_m(state.sonar_right_in).to_le_bytes();
        let left_m = range_m(state.sonar_left_in).to_le_bytes();
        let to = self.begin();
        put_timestamp(to, now_ns);
        to.string(2, BASE);
        to.message(3, |to| upright(to, [0.0; 3]));
        to.double(4, -SONAR_RAD);
        to.double(5, SONAR_RAD);
        to.bytes(6, [right_m, left_m].as_flattened());
    }

    /// A `foxglove.PosesInFrame`.
    pub(super) fn path(&mut self, now_ns: u64, path: &Path) {
        path.encode(now_ns, self.begin());
    }

    /// A `foxglove.SceneUpdate`.
    pub(super) fn scene(&mut self, now_ns: u64, scene: &Scene) {
        scene.encode(now_ns, self.begin());
    }

    /// A `foxglove.Log`.
    pub(super) fn log(&mut self, now_ns: u64, level: Level, name: &str, text: &str) {
        let to = self.begin();
        put_timestamp(to, now_ns);
        to.int32(2, level as i32);
        to.string(3, text);
        to.string(4, name);
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
