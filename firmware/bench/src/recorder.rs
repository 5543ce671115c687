//! The robot's program on the host, with a recording of its calls and results.

use sr04_firmware::board::{Identity, Inputs, Outputs, Sides};
use sr04_firmware::parameters::Parameters;
use sr04_firmware::robot::Robot;
use sr04_replay::{Call, Port, write_downlink, write_leds, write_outputs};

/// Several byte strings, stored one after another.
#[derive(Default)]
pub(crate) struct Frames {
    bytes: Vec<u8>,
    /// End of each string.
    ends: Vec<usize>,
}

impl Frames {
    fn end(&mut self) {
        self.ends.push(self.bytes.len());
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u8]> {
        let begins = std::iter::once(&0).chain(&self.ends);
        begins
            .zip(&self.ends)
            .map(|(&begin, &end)| &self.bytes[begin..end])
    }

    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// All strings as one.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Number of the string that contains the byte at an index.
    pub(crate) fn containing(&self, place: usize) -> usize {
        self.ends.partition_point(|&end| end <= place)
    }
}

impl Port for Frames {
    fn read(&mut self) -> u8 {
        unreachable!("the host only writes")
    }

    fn write(&mut self, byte: u8) {
        self.bytes.push(byte);
    }
}

/// A recorded run: the calls, and the result of each.
#[derive(Default)]
pub(crate) struct Recording {
    pub(crate) calls: Frames,
    pub(crate) results: Frames,
    /// Bytes to the radio.
    pub(crate) downlink: Vec<u8>,
}

/// The robot, whose calls are recorded.
pub(crate) struct Recorder {
    pub(crate) robot: Robot,
    pub(crate) recording: Recording,
}

impl Recorder {
    pub(crate) fn new(identity: Identity, parameters: &Parameters) -> Self {
        let mut recorder = Self {
            robot: Robot::restored(identity, parameters.clone()),
            recording: Recording::default(),
        };
        recorder.record(Call::Boot(identity, parameters));
        recorder.recording.results.end();
        recorder
    }

    pub(crate) fn reboot(&mut self, identity: Identity, parameters: &Parameters) {
        self.record(Call::Boot(identity, parameters));
        self.robot = Robot::restored(identity, parameters.clone());
        self.recording.results.end();
    }

    pub(crate) fn tick(&mut self, inputs: &Inputs) -> Outputs {
        self.record(Call::Tick(inputs));
        let outputs = self.robot.tick(inputs);
        let results = &mut self.recording.results;
        write_outputs(results, outputs, self.robot.parameters());
        results.end();
        outputs
    }

    pub(crate) fn infrared_sample(&mut self, left: bool, right: bool) -> bool {
        self.record(Call::Infrared(Sides { left, right }));
        let leds_on = self.robot.infrared_sample(left, right);
        write_leds(&mut self.recording.results, leds_on);
        self.recording.results.end();
        leds_on
    }

    pub(crate) fn handle_uplink(&mut self, byte: u8) {
        self.record(Call::Uplink(byte));
        self.robot.handle_uplink(byte);
        self.recording.results.end();
    }

    pub(crate) fn poll_downlink(&mut self) -> Option<u8> {
        self.record(Call::Downlink);
        let byte = self.robot.poll_downlink();
        write_downlink(&mut self.recording.results, byte);
        self.recording.results.end();
        self.recording.downlink.extend(byte);
        byte
    }

    fn record(&mut self, call: Call<'_>) {
        call.write(&mut self.recording.calls);
        self.recording.calls.end();
    }
}
