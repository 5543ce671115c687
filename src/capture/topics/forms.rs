//! Messages on their way out: encoded one at a time into the same memory.

use foxglove::messages::log::Level;
use foxglove::messages::{
    FrameTransform, FrameTransforms, LaserScan, Log, Pose, PoseInFrame, Quaternion, Vector3,
};
use groundwave_protocol::telemetry::StateLine;
use prost::Message;

use super::geometry::{BASE, M_PER_IN, ODOM, Place, timestamp};
use super::{Topic, TopicMessage};
use crate::capture::messages::RawBytes;

/// The sonars look so far to the right and to the left.
const SONAR_RAD: f64 = 7.5 / 180.0 * std::f64::consts::PI;

/// Encodes one message at a time into the same memory.
#[derive(Debug, Default)]
pub(super) struct Encoder {
    buffer: Vec<u8>,
}

impl Encoder {
    pub(super) fn encode(&mut self, message: &impl Message) {
        self.buffer.clear();
        // A vector grows as it must: there is nothing that could fail.
        let _ = message.encode(&mut self.buffer);
    }

    /// A [`RawBytes`], without a copy of the bytes in between.
    pub(super) fn raw(&mut self, stream_offset: u64, bytes: &[u8]) {
        use prost::encoding::{WireType, encode_key, encode_varint, uint64};
        self.buffer.clear();
        if stream_offset != 0 {
            uint64::encode(
                RawBytes::STREAM_OFFSET_TAG,
                &stream_offset,
                &mut self.buffer,
            );
        }
        encode_key(
            RawBytes::DATA_TAG,
            WireType::LengthDelimited,
            &mut self.buffer,
        );
        encode_varint(bytes.len() as u64, &mut self.buffer);
        self.buffer.extend_from_slice(bytes);
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

/// Messages that every line A fills in anew.
#[derive(Debug)]
pub(super) struct Forms {
    transforms: FrameTransforms,
    pose: PoseInFrame,
    scan: LaserScan,
}

impl Default for Forms {
    fn default() -> Self {
        Self {
            transforms: FrameTransforms {
                transforms: vec![FrameTransform {
                    parent_frame_id: ODOM.to_owned(),
                    child_frame_id: BASE.to_owned(),
                    ..FrameTransform::default()
                }],
            },
            pose: PoseInFrame {
                frame_id: ODOM.to_owned(),
                ..PoseInFrame::default()
            },
            scan: LaserScan {
                frame_id: BASE.to_owned(),
                pose: Some(Pose {
                    position: Some(Vector3::default()),
                    orientation: Some(Quaternion {
                        w: 1.0,
                        ..Quaternion::default()
                    }),
                }),
                start_angle: -SONAR_RAD,
                end_angle: SONAR_RAD,
                ranges: vec![0.0; 2],
                ..LaserScan::default()
            },
        }
    }
}

impl Forms {
    pub(super) fn transforms(&mut self, now_ns: u64, place: Place) -> &FrameTransforms {
        for transform in &mut self.transforms.transforms {
            transform.timestamp = Some(timestamp(now_ns));
            transform.translation = Some(place.translation());
            transform.rotation = Some(place.rotation());
        }
        &self.transforms
    }

    pub(super) fn pose(&mut self, now_ns: u64, place: Place) -> &PoseInFrame {
        self.pose.timestamp = Some(timestamp(now_ns));
        self.pose.pose = Some(place.pose());
        &self.pose
    }

    /// The right one first: angles grow to the left. No echo is no obstacle within reach: infinity.
    pub(super) fn scan(&mut self, now_ns: u64, state: &StateLine) -> &LaserScan {
        let range_m = |inches: Option<u16>| {
            inches.map_or(f64::INFINITY, |inches| f64::from(inches) * M_PER_IN)
        };
        self.scan.timestamp = Some(timestamp(now_ns));
        self.scan.ranges.clear();
        self.scan
            .ranges
            .extend([range_m(state.sonar_right_in), range_m(state.sonar_left_in)]);
        &self.scan
    }
}
