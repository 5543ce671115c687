//! Topics of a recording, derived from received bytes, sent bytes and station events.
//!
//! Only the [`Deriver`] derives messages. Recording, recovery and `export` write them to MCAP; the Foxglove server
//! sends them to other programs. The deriver is a pure fold: the same inputs in the same order with the same times give the same
//! messages.
//!
//! Topics with a schema of our own have the robot's units: inches and degrees. All others follow REP 103: metres and
//! radians, x ahead, y left, counter-clockwise positive. The origin of frame [`ODOM`] is the robot's pose when its
//! odometer was last reset; frame [`BASE`] moves with the robot; frame [`MAP`] is the floor as the ground knows it.

mod deriver;
mod encoder;
mod geometry;
mod ground;
mod log_messages;
mod path;
mod scene;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Seek, Write};

use ::mcap::{McapResult, Writer};
use foxglove::Encode;
use foxglove::messages::{
    FrameTransforms, Grid, LaserScan, Log, PoseInFrame, PosesInFrame, SceneUpdate,
};

pub use deriver::Deriver;
pub use geometry::{BASE, MAP, ODOM};
pub(super) use log_messages::{LogMessages, is_contact};

pub use super::messages::StationEvent;
use super::messages::{OutageMessage, RawBytes, Telemetry, UplinkEvent};
use super::own_lines::Values;
use super::schema::{DESCRIPTORS, Schema};

/// Encoding of schemas and messages.
const ENCODING: &str = "protobuf";

/// Every byte read from the radio.
pub const RAW_RX: &str = Topic::RawRx.name();
/// Every byte sent to the radio.
pub const RAW_TX: &str = Topic::RawTx.name();

/// A topic of a recording. Its number determines those of its channel and its schema, and never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Topic {
    /// Every byte read from the radio.
    RawRx,
    /// Every byte sent to the radio.
    RawTx,
    /// Every intact line, decoded.
    Telemetry,
    /// Statuses of commands, and changes of the robot's acknowledgement and route.
    Uplink,
    /// The robot's pose as a transform from [`ODOM`] to [`BASE`].
    Tf,
    /// The robot's pose.
    Pose,
    /// The newest part of the robot's path.
    Path,
    /// Distances measured by the robot's two sonars.
    Sonar,
    /// The floor that the robot has seen, as an occupancy grid in [`MAP`].
    Map,
    /// The robot's body, waypoints and bumps.
    Markers,
    /// Events as text.
    Log,
    /// Events that are not in the bytes: commands, the link, marks, the ground's estimate and notices.
    Station,
    /// Times without lines.
    Outages,
    /// Values of each line of the robot's own.
    Values,
    /// The ground's estimate of the robot's pose, in [`MAP`].
    PoseCorrected,
    /// The odometer's error as a transform from [`MAP`] to [`ODOM`].
    TfMap,
}

impl Topic {
    /// Every topic, in the order of their numbers.
    pub const ALL: [Self; 16] = [
        Self::RawRx,
        Self::RawTx,
        Self::Telemetry,
        Self::Uplink,
        Self::Tf,
        Self::Pose,
        Self::Path,
        Self::Sonar,
        Self::Map,
        Self::Markers,
        Self::Log,
        Self::Station,
        Self::Outages,
        Self::Values,
        Self::PoseCorrected,
        Self::TfMap,
    ];

    /// Name of the topic in a recording.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RawRx => "/raw/rx",
            Self::RawTx => "/raw/tx",
            Self::Telemetry => "/telemetry",
            Self::Uplink => "/uplink",
            Self::Tf => "/tf",
            Self::Pose => "/pose",
            Self::Path => "/path",
            Self::Sonar => "/sonar",
            Self::Map => "/map",
            Self::Markers => "/markers",
            Self::Log => "/log",
            Self::Station => "/station",
            Self::Outages => "/outages",
            Self::Values => "/values",
            Self::PoseCorrected => "/pose_corrected",
            Self::TfMap => "/tf_map",
        }
    }

    /// Number of the topic's channel.
    #[must_use]
    pub const fn channel_id(self) -> u16 {
        self as u16 + 1
    }

    /// Number of the topic's schema: the number of the first topic with the same schema. A test finds a missing arm.
    const fn schema_id(self) -> u16 {
        match self {
            Self::RawTx => Self::RawRx.channel_id(),
            Self::PoseCorrected => Self::Pose.channel_id(),
            Self::TfMap => Self::Tf.channel_id(),
            topic => topic.channel_id(),
        }
    }

    /// Source of the topic's messages.
    #[must_use]
    pub const fn origin(self) -> Origin {
        match self {
            Self::RawRx | Self::RawTx | Self::Station => Origin::Recorded,
            Self::Telemetry | Self::Tf | Self::Pose | Self::Sonar => Origin::Line,
            Self::PoseCorrected | Self::TfMap | Self::Map => Origin::Event,
            Self::Uplink
            | Self::Path
            | Self::Markers
            | Self::Log
            | Self::Outages
            | Self::Values => Origin::History,
        }
    }

    /// The topic with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// The protobuf type of the topic's messages.
    #[must_use]
    pub fn schema(self) -> TopicSchema {
        let ours = |name| TopicSchema {
            name: Cow::Borrowed(name),
            descriptors: Cow::Borrowed(DESCRIPTORS),
        };
        match self {
            Self::RawRx | Self::RawTx => ours(RawBytes::NAME),
            Self::Telemetry => ours(Telemetry::NAME),
            Self::Uplink => ours(UplinkEvent::NAME),
            Self::Tf | Self::TfMap => well_known::<FrameTransforms>(),
            Self::Pose | Self::PoseCorrected => well_known::<PoseInFrame>(),
            Self::Path => well_known::<PosesInFrame>(),
            Self::Sonar => well_known::<LaserScan>(),
            Self::Map => well_known::<Grid>(),
            Self::Markers => well_known::<SceneUpdate>(),
            Self::Log => well_known::<Log>(),
            Self::Station => ours(StationEvent::NAME),
            Self::Outages => ours(OutageMessage::NAME),
            Self::Values => ours(Values::NAME),
        }
    }
}

/// Source of a topic's messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Recorded, not derived.
    Recorded,
    /// Each message is derived from one line.
    Line,
    /// Each message is derived from one event of the station.
    Event,
    /// Messages are derived from all lines, sent bytes and events so far.
    History,
}

/// Adds topics and their schemas to a file, under fixed numbers.
///
/// # Errors
/// If writing fails.
pub(super) fn register<W: Write + Seek>(
    writer: &mut Writer<W>,
    topics: &[Topic],
) -> McapResult<()> {
    for topic in topics {
        let TopicSchema { name, descriptors } = topic.schema();
        let schema_id = topic.schema_id();
        writer.add_schema_with_id(schema_id, &name, ENCODING, &descriptors)?;
        let metadata = BTreeMap::new();
        writer.add_channel_with_id(
            topic.channel_id(),
            schema_id,
            topic.name(),
            ENCODING,
            &metadata,
        )?;
    }
    Ok(())
}

/// A protobuf type with everything that other programs need to decode it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicSchema {
    /// Name with its package: `groundwave.Telemetry`.
    pub name: Cow<'static, str>,
    /// Serialised `FileDescriptorSet` of the type and of all types that it refers to.
    pub descriptors: Cow<'static, [u8]>,
}

/// The schema of a type of the `foxglove` crate.
fn well_known<T: Encode>() -> TopicSchema {
    T::get_schema().map_or_else(
        || TopicSchema {
            name: Cow::Borrowed(""),
            descriptors: Cow::Borrowed(&[]),
        },
        |schema| TopicSchema {
            name: Cow::Owned(schema.name),
            descriptors: schema.data,
        },
    )
}

/// A message for a recording or for another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopicMessage<'a> {
    /// Topic of the message.
    pub topic: Topic,
    /// Time at which the bytes were received or sent, nanoseconds since 1970; never before the previous message.
    pub log_time_ns: u64,
    /// Time by the robot's clock if known, else `log_time_ns`.
    pub publish_time_ns: u64,
    /// The protobuf message.
    pub data: &'a [u8],
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A schema that is registered twice would look like two.
    #[test]
    fn topics_with_one_schema_share_its_number() {
        for topic in Topic::ALL {
            let is_alike = |it: &Topic| it.schema().name == topic.schema().name;
            let first = Topic::ALL.into_iter().find(is_alike).unwrap();
            assert_eq!(topic.schema_id(), first.channel_id(), "{topic:?}");
        }
    }

    /// Recordings refer to topics by these numbers.
    #[test]
    fn numbers_of_topics_never_change() {
        assert_eq!(
            Topic::ALL.map(|topic| (topic.channel_id(), topic.name())),
            [
                (1, "/raw/rx"),
                (2, "/raw/tx"),
                (3, "/telemetry"),
                (4, "/uplink"),
                (5, "/tf"),
                (6, "/pose"),
                (7, "/path"),
                (8, "/sonar"),
                (9, "/map"),
                (10, "/markers"),
                (11, "/log"),
                (12, "/station"),
                (13, "/outages"),
                (14, "/values"),
                (15, "/pose_corrected"),
                (16, "/tf_map"),
            ]
        );
    }
}
