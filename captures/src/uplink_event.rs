//! What became of commands, as a protobuf message.

/// What happened to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, prost::Enumeration)]
#[repr(i32)]
pub enum UplinkStep {
    /// Waits for its turn.
    Queued = 0,
    /// A frame of it went to the radio.
    Sent = 1,
    /// Some of a list was acknowledged.
    Progress = 2,
    /// The robot told of a parameter.
    Told = 3,
    /// The robot's acknowledgement proves it.
    Proven = 4,
    /// The robot refused.
    Refused = 5,
    /// Given up without proof.
    Failed = 6,
    /// Somebody who shares the link asked for it.
    Asked = 7,
    /// The robot acknowledges another command than before; from its lines alone.
    Acknowledged = 8,
    /// The robot holds another list than before; from its lines alone.
    List = 9,
}

/// A step of a command on its way to the robot, or something new in the robot's own acknowledgement.
/// What a step does not say is absent.
#[derive(Clone, PartialEq, prost::Message)]
pub struct UplinkEvent {
    /// What happened.
    #[prost(enumeration = "UplinkStep", tag = 1)]
    pub step: i32,
    /// Number of the command in its session at the station, from 1.
    #[prost(uint32, optional, tag = 2)]
    pub command_id: Option<u32>,
    /// The command in the words of the command line.
    #[prost(string, optional, tag = 3)]
    pub command: Option<String>,
    /// Frames sent for it so far, repetitions included.
    #[prost(uint32, optional, tag = 4)]
    pub frames: Option<u32>,
    /// Waypoints that the robot acknowledged.
    #[prost(uint32, optional, tag = 5)]
    pub acknowledged: Option<u32>,
    /// Waypoints in the list.
    #[prost(uint32, optional, tag = 6)]
    pub total: Option<u32>,
    /// Digest of a waypoint list that the robot verified.
    #[prost(uint32, optional, tag = 7)]
    pub list_digest: Option<u32>,
    /// What the robot says became of the command: the place of the outcome in the wire's list.
    #[prost(int32, optional, tag = 8)]
    pub outcome: Option<i32>,
    /// Why it ended without proof.
    #[prost(string, optional, tag = 9)]
    pub reason: Option<String>,
    /// Who asked for it.
    #[prost(string, optional, tag = 10)]
    pub by: Option<String>,
    /// Low 3 bits of the robot's boot counter.
    #[prost(uint32, optional, tag = 11)]
    pub boot: Option<u32>,
    /// Session, 1 to 7 in turn; 0 before the first.
    #[prost(uint32, optional, tag = 12)]
    pub session: Option<u32>,
    /// Sequence of the latest command taken, low 3 bits.
    #[prost(uint32, optional, tag = 13)]
    pub sequence: Option<u32>,
    /// Waypoints of the list that is queued, inches.
    #[prost(sint32, repeated, tag = 14)]
    pub waypoints_x_in: Vec<i32>,
    /// The same, inches.
    #[prost(sint32, repeated, tag = 15)]
    pub waypoints_y_in: Vec<i32>,
    /// A parameter that the robot told of.
    #[prost(string, optional, tag = 16)]
    pub parameter_name: Option<String>,
    /// What it is.
    #[prost(sint32, optional, tag = 17)]
    pub parameter_value: Option<i32>,
}

impl UplinkEvent {
    /// A step that says nothing more.
    #[must_use]
    pub fn new(step: UplinkStep) -> Self {
        Self {
            step: step as i32,
            ..Self::default()
        }
    }
}
