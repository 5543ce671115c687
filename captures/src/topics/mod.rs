//! Every topic of a capture, derived from what was received, sent and told.
//!
//! The [`Deriver`] is the one place that knows what follows from the bytes of the radio: the recorder
//! writes what it says to MCAP, `convert` does the same with raw text, recovery with a journal, and
//! a live server hands it to other programs. It is a pure fold: same inputs in the same order with the
//! same times, same messages.
//!
//! Metres, radians and REP 103 everywhere but in the topics that are ours (inches, degrees, as the
//! robot says them): x ahead, y left, counter-clockwise is positive. Frame [`ODOM`] is where the robot
//! was when it last reset its odometer, looking along x; frame [`BASE`] is the robot.

mod deriver;
mod encoder;
mod geometry;
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
pub use geometry::{BASE, ODOM};
pub(super) use log_messages::{LogMessages, is_contact};

pub use super::messages::StationEvent;
use super::messages::{RawBytes, Telemetry, UplinkEvent};
use super::schema::{DESCRIPTORS, Schema};

/// How schemas and messages are encoded.
const ENCODING: &str = "protobuf";

/// Every byte read from the radio.
pub const RAW_RX: &str = Topic::RawRx.name();
/// Every byte sent to the radio.
pub const RAW_TX: &str = Topic::RawTx.name();

/// The topics of a capture. Their numbers are those of their channels and of their schemas, and stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Topic {
    /// Every byte read from the radio.
    RawRx,
    /// Every byte sent to the radio.
    RawTx,
    /// Every intact line, decoded.
    Telemetry,
    /// Commands, repetitions, acknowledgements, digests of lists.
    Uplink,
    /// Where the robot is, as a transform from [`ODOM`] to [`BASE`].
    Tf,
    /// Where the robot is.
    Pose,
    /// Where it was, lately.
    Path,
    /// What its two sonars see.
    Sonar,
    /// The place of an occupancy grid; nothing writes one yet.
    Map,
    /// The robot's body, waypoints, bumps.
    Markers,
    /// What happened, in words.
    Log,
    /// What no byte tells: commands, the link, marks and notices.
    Station,
}

impl Topic {
    /// Every topic, in the order of their numbers.
    pub const ALL: [Self; 12] = [
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
    ];

    /// Its name in a capture.
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
        }
    }

    /// The number of its channel.
    #[must_use]
    pub const fn channel_id(self) -> u16 {
        self as u16 + 1
    }

    /// The number of its schema: that of the first topic that has it.
    const fn schema_id(self) -> u16 {
        match self {
            Self::RawTx => Self::RawRx.channel_id(),
            topic => topic.channel_id(),
        }
    }

    /// The topic of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// The protobuf type of its messages.
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
            Self::Tf => well_known::<FrameTransforms>(),
            Self::Pose => well_known::<PoseInFrame>(),
            Self::Path => well_known::<PosesInFrame>(),
            Self::Sonar => well_known::<LaserScan>(),
            Self::Map => well_known::<Grid>(),
            Self::Markers => well_known::<SceneUpdate>(),
            Self::Log => well_known::<Log>(),
            Self::Station => ours(StationEvent::NAME),
        }
    }
}

/// Adds topics and their schemas to a file under their numbers.
///
/// # Errors
/// When writing fails.
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

/// A protobuf type, as other programs need it to decode its messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicSchema {
    /// With the package: `groundwave.Telemetry`.
    pub name: Cow<'static, str>,
    /// A serialised `FileDescriptorSet` with everything that the type refers to.
    pub descriptors: Cow<'static, [u8]>,
}

/// The schema that comes with a type of the `foxglove` crate.
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

/// A message as it goes into a capture or to another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopicMessage<'a> {
    /// What it is about.
    pub topic: Topic,
    /// When the bytes it follows from were received or sent: nanoseconds since 1970, never less than
    /// those of the message before.
    pub log_time_ns: u64,
    /// The robot's own time where it is known, else `log_time_ns`.
    pub publish_time_ns: u64,
    /// The protobuf message.
    pub data: &'a [u8],
}
