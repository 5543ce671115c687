//! What a capture holds, at a glance.

use std::io::{self, Write};
use std::time::Duration;

use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::letters::{Drive, Layer};
use groundwave_protocol::telemetry::{Body, CountersLine, HOLDERS, Line, StateLine};
use serde::Serialize;

use super::bumps::Bumps;
use super::odometer::{can_be_driven, seconds_of, slots_between};
use super::runs::label::Label;
use super::source::{Chunk, Form};
use super::{Capture, CaptureError};
use crate::request::layer_word;
use crate::statistics::{Gaps, Rejected, Resync, per_cent, share_pct};

/// What a capture holds.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// How it is stored.
    pub form: Form,
    /// What of a raw capture is not as the radio delivered it, in words: times before the lines, other line ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stored: Option<String>,
    /// When it was made, in UTC, as an MCAP says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// The link it was made with, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// The program that made it and its version, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub software: Option<String>,
    /// What the run is called.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Why the run does not count; of one that counts there is nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub void: Option<String>,
    /// From its beginning to its last byte, seconds. Of a raw capture whose lines say no time, the time that a radio at
    /// 2400 baud takes for as many bytes.
    pub duration_s: f64,
    /// Bytes received.
    pub bytes: u64,
    /// Bytes that belong to no intact line.
    pub noise_bytes: u64,
    /// Those of them that may be the beginning of a line under way when the capture ended.
    pub unfinished_bytes: u64,
    /// Bytes that were received and could not be recorded.
    pub missing_bytes: u64,
    /// Intact lines.
    pub lines: LineCounts,
    /// Lines that the sequence says were sent and that did not arrive intact.
    pub lines_lost: u64,
    /// `lines_lost` in per cent of the lines sent.
    pub loss_pct: f64,
    /// What was taken for a line and rejected.
    pub rejected: Rejected,
    /// Bytes from an intact line to the next, where there were any between them.
    pub resync: Option<Resync>,
    /// Share of the way down in use, per cent; unknown of a raw capture, which knows no time, and where the
    /// clock of the capture is not that of the radio: read from a pipe, or from a simulator that runs faster.
    pub airtime_down_pct: Option<f64>,
    /// What was sent; unknown of a raw capture.
    pub sent: Option<Sent>,
    /// Robot and firmware, as it last said.
    pub robot: Option<Robot>,
    /// Times the robot is seen to have booted in the middle: another boot counter, or an uptime that runs backwards.
    pub restarts: u64,
    /// Way between the reported positions, inches.
    pub distance_in: f64,
    /// Who held the motors, in per cent of the ticks between the first line C and the last.
    pub holders: Vec<HolderShare>,
    /// First voltage reported.
    pub battery_first_v: Option<f64>,
    /// Last voltage reported.
    pub battery_last_v: Option<f64>,
    /// Bumper contacts: by the robot's own count between the first line C and the last, else as seen in lines A.
    pub bumps: u32,
    /// Why the capture could not be read to its end.
    pub problem: Option<String>,
}

/// Intact lines by type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub struct LineCounts {
    /// State.
    pub a: u64,
    /// Status.
    pub b: u64,
    /// Counters.
    pub c: u64,
    /// Text.
    pub t: u64,
    /// Acknowledgement.
    pub k: u64,
    /// Parameter.
    #[serde(skip_serializing_if = "is_none")]
    pub p: u64,
    /// Song.
    #[serde(skip_serializing_if = "is_none")]
    pub s: u64,
}

impl LineCounts {
    /// Intact lines of every type.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.a + self.b + self.c + self.t + self.k + self.p + self.s
    }
}

/// Lines that most captures have none of are told of only where there are some.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
const fn is_none(count: &u64) -> bool {
    *count == 0
}

/// What was sent while it was recorded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sent {
    /// Bytes handed to the device.
    pub bytes: u64,
    /// STOPs, requests for a session, commands and waypoints.
    pub frames: u64,
    /// Those of them that had gone before.
    pub frames_again: u64,
    /// Share of the way up in use, per cent; unknown where that of the way down is.
    pub airtime_up_pct: Option<f64>,
}

/// Who sent it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Robot {
    /// 1 to 99.
    pub id: u8,
    /// Major and minor.
    pub firmware_version: String,
}

/// The part of the time that a behaviour held the motors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HolderShare {
    /// A layer or `prowl`.
    pub holder: &'static str,
    /// Per cent.
    pub share_pct: f64,
}

impl Info {
    /// Reads a whole capture. A capture that is damaged or ends early is told about up to there.
    #[must_use]
    pub fn read(capture: &mut Capture) -> Self {
        let mut decoder = Decoder::default();
        let mut survey = Survey::default();
        let result = survey.take_all(capture, &mut decoder);
        survey.into_info(
            capture,
            decoder.counters(),
            result.err().map(|e| e.to_string()),
        )
    }

    /// With what an operator says of the run.
    #[must_use]
    pub fn with_label(self, label: Label) -> Self {
        let Label { name, void, .. } = label;
        Self { name, void, ..self }
    }

    /// Which run it is and where it comes from.
    fn write_origin(&self, output: &mut impl Write) -> io::Result<()> {
        for (what, words) in [
            ("run", &self.name),
            ("VOID", &self.void),
            ("made", &self.start),
            ("link", &self.link),
            ("software", &self.software),
        ] {
            if let Some(words) = words {
                writeln!(output, "{what:<11}{words}")?;
            }
        }
        if let Some(words) = &self.stored {
            writeln!(output, "stored     {words}")?;
        }
        Ok(())
    }

    /// Writes it for a person, a line a fact.
    ///
    /// # Errors
    /// When the output takes no more.
    pub fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        let LineCounts {
            a,
            b,
            c,
            t,
            k,
            p,
            s,
        } = self.lines;
        let all = self.lines.total();
        self.write_origin(output)?;
        writeln!(output, "duration   {}", duration_words(self.duration_s))?;
        writeln!(
            output,
            "bytes      {} received, {} noise",
            self.bytes,
            self.noise_bytes - self.unfinished_bytes
        )?;
        if self.unfinished_bytes > 0 {
            writeln!(
                output,
                "end        in the middle of a line, {} bytes of it",
                self.unfinished_bytes
            )?;
        }
        if self.missing_bytes > 0 {
            writeln!(output, "missing    {} bytes", self.missing_bytes)?;
        }
        let rare = match (p, s) {
            (0, 0) => String::new(),
            (p, s) => format!(", P {p}, S {s}"),
        };
        writeln!(
            output,
            "lines      {all} intact: {} packets (A {a}, B {b}, C {c}, T {t}{rare}), {k} acknowledgements (K)",
            all - k
        )?;
        writeln!(
            output,
            "loss       {} lines, {:.1} %",
            self.lines_lost, self.loss_pct
        )?;
        let Rejected { crc, shape, field } = self.rejected;
        writeln!(
            output,
            "rejected   {crc} checksum, {shape} shape, {field} field"
        )?;
        if let Some(resync) = self.resync {
            writeln!(
                output,
                "resync     {} times, {:.0} bytes on average, {} at worst",
                resync.count, resync.mean_bytes, resync.worst_bytes
            )?;
        }
        if let Some(down_pct) = self.airtime_down_pct {
            write!(output, "airtime    {down_pct:.1} % down")?;
            if let Some(up_pct) = self.sent.and_then(|sent| sent.airtime_up_pct) {
                write!(output, ", {up_pct:.1} % up")?;
            }
            writeln!(output)?;
        }
        if let Some(sent) = self.sent.filter(|sent| sent.bytes > 0) {
            writeln!(
                output,
                "sent       {} bytes, {} frames, {} of them again",
                sent.bytes, sent.frames, sent.frames_again
            )?;
        }
        if let Some(robot) = &self.robot {
            writeln!(
                output,
                "robot      {}, firmware {}, restarts {}",
                robot.id, robot.firmware_version, self.restarts
            )?;
        }
        writeln!(output, "distance   {:.1} in", self.distance_in)?;
        writeln!(output, "bumps      {}", self.bumps)?;
        if let (Some(first), Some(last)) = (self.battery_first_v, self.battery_last_v) {
            writeln!(output, "battery    {first:.1} V to {last:.1} V")?;
        }
        if !self.holders.is_empty() {
            let shares: Vec<_> = self
                .holders
                .iter()
                .map(|h| format!("{} {:.1} %", h.holder, h.share_pct))
                .collect();
            writeln!(output, "behaviours {}", shares.join(", "))?;
        }
        if let Some(problem) = &self.problem {
            writeln!(output, "problem    {problem}")?;
        }
        Ok(())
    }
}

/// `5 min 5.3 s`; from an hour on `23 h 56 min 57 s`.
fn duration_words(duration_s: f64) -> String {
    // Rounded first: 119.97 s are 2 minutes and not 1 minute and 60 seconds.
    let tenths = (duration_s * 10.0).round() as u64;
    if tenths < 36_000 {
        return format!(
            "{} min {}.{} s",
            tenths / 600,
            tenths / 10 % 60,
            tenths % 10
        );
    }
    let s = duration_s.round() as u64;
    format!("{} h {} min {} s", s / 3600, s / 60 % 60, s % 60)
}

/// The count of ticks goes round after 4096; a longer silence than this at 20 Hz cannot be told.
const TICKS_ROUND_S: u32 = 200;

/// More of the radio than this cannot have been in use: clocks of serial ports differ by a few per cent.
const SHARE_MAX_PCT: f64 = 105.0;

/// So many bytes in a time, in per cent of what the radio can carry, if it can.
fn plausible_share_pct(bytes: u64, time: Duration) -> Option<f64> {
    if time.is_zero() && bytes > 0 {
        return None;
    }
    Some(share_pct(bytes, time)).filter(|share_pct| *share_pct <= SHARE_MAX_PCT)
}

#[derive(Default)]
struct Survey {
    lines: LineCounts,
    robot: Option<Robot>,
    place: Option<Place>,
    distance_in: f64,
    battery_dv: Option<(u16, u16)>,
    counters: Option<CountersLine>,
    ticks: [u64; HOLDERS],
    bumps: Bumps,
    since_line_feed: u64,
    /// Bytes that came before the clock of the capture began to run.
    first_bytes: u64,
    gaps: Gaps,
}

/// Where the robot was, and the sequence of that line.
#[derive(Clone, Copy)]
struct Place {
    x_in: f64,
    y_in: f64,
    sequence: u8,
}

impl Survey {
    fn take_all(
        &mut self,
        capture: &mut Capture,
        decoder: &mut Decoder,
    ) -> Result<(), CaptureError> {
        while let Some(chunk) = capture.next_chunk()? {
            let Chunk { at, mut bytes, .. } = chunk;
            if chunk.is_interrupted {
                decoder.interrupt();
                self.gaps.interrupt();
            }
            if at.is_zero() {
                self.first_bytes += bytes.len() as u64;
            }
            self.since_line_feed = match bytes.iter().rposition(|&byte| byte == b'\n') {
                Some(at) => (bytes.len() - at - 1) as u64,
                None => self.since_line_feed + bytes.len() as u64,
            };
            while !bytes.is_empty() {
                let (taken, received) = decoder.handle_bytes(bytes);
                bytes = &bytes[taken..];
                if let Some(received) = received {
                    self.gaps.take_line(decoder.counters());
                    self.take(&received);
                }
            }
        }
        Ok(())
    }

    fn take(&mut self, received: &Received) {
        match received {
            Received::Ack(_) => self.lines.k += 1,
            Received::Line(line, _) => self.take_line(line),
        }
    }

    fn take_line(&mut self, line: &Line) {
        match &line.body {
            Body::State(state) => {
                self.lines.a += 1;
                self.take_state(line.sequence, state);
            }
            Body::Status(status) => {
                self.lines.b += 1;
                let (first, _) = self.battery_dv.unwrap_or((status.battery_dv, 0));
                self.battery_dv = Some((first, status.battery_dv));
            }
            Body::Counters(counters) => {
                self.lines.c += 1;
                self.take_counters(counters);
            }
            Body::Text(_) => self.lines.t += 1,
            Body::Parameter(_) => self.lines.p += 1,
            Body::Song(_) => self.lines.s += 1,
        }
    }

    fn take_state(&mut self, sequence: u8, state: &StateLine) {
        self.bumps.take_state(state);
        let place = Place {
            x_in: f64::from(state.x_tenths_in) / 10.0,
            y_in: f64::from(state.y_tenths_in) / 10.0,
            sequence,
        };
        if let Some(last) = self.place
            && state.drive != Drive::OdometerReset
        {
            let step_in = (place.x_in - last.x_in).hypot(place.y_in - last.y_in);
            let passed_s = seconds_of(slots_between(last.sequence, sequence));
            if can_be_driven(step_in, passed_s) {
                self.distance_in += step_in;
            }
        }
        self.place = Some(place);
    }

    fn take_counters(&mut self, counters: &CountersLine) {
        self.robot = Some(Robot {
            id: counters.robot_id,
            firmware_version: format!("{}.{:02}", counters.version.major, counters.version.minor),
        });
        self.bumps.take_counters(counters);
        if let Some(last) = &self.counters
            && last.boots == counters.boots
            && let Some(passed_s) = counters.uptime_s.checked_sub(last.uptime_s)
            && passed_s < TICKS_ROUND_S
        {
            let won = counters.ticks_won.iter().zip(&last.ticks_won);
            for (total, (now, then)) in self.ticks.iter_mut().zip(won) {
                *total += u64::from(now.wrapping_sub(*then) % 4096);
            }
        }
        self.counters = Some(*counters);
    }

    fn into_info(self, capture: &Capture, seen: &Counters, problem: Option<String>) -> Info {
        let ticks: u64 = self.ticks.iter().sum();
        let names = Layer::ALL.into_iter().map(layer_word).chain(["prowl"]);
        let mut holders: Vec<HolderShare> = names
            .zip(self.ticks)
            .filter(|(_, won)| *won > 0)
            .map(|(holder, won)| HolderShare {
                holder,
                share_pct: per_cent(won, ticks),
            })
            .collect();
        holders.sort_by(|a, b| b.share_pct.total_cmp(&a.share_pct));
        let lines = seen.lines + seen.ack_lines;
        let volts = |dv: u16| f64::from(dv) / 10.0;
        let may_become_a_line = self.since_line_feed < LINE_BYTES as u64;
        let unfinished_bytes = if may_become_a_line {
            self.since_line_feed.min(seen.noise_bytes)
        } else {
            0
        };
        let after_first = seen.bytes - self.first_bytes;
        let airtime_down_pct = capture
            .uplink()
            .and_then(|_| plausible_share_pct(after_first, capture.end()));
        let said = |what: &str| capture.session()?.get(what).cloned();
        let version = said("software_version").map(|version| format!(" {version}"));
        Info {
            start: said("start"),
            link: said("link"),
            software: said("software").map(|it| it + &version.unwrap_or_default()),
            name: None,
            void: None,
            form: capture.form(),
            stored: capture.stored(),
            duration_s: capture.end().as_secs_f64(),
            bytes: seen.bytes,
            noise_bytes: seen.noise_bytes,
            unfinished_bytes,
            missing_bytes: capture.missing_bytes(),
            lines: self.lines,
            lines_lost: seen.lines_lost,
            loss_pct: per_cent(seen.lines_lost, lines + seen.lines_lost),
            rejected: Rejected::of(seen),
            resync: self.gaps.resync(),
            airtime_down_pct,
            sent: capture.uplink().map(|uplink| Sent {
                bytes: uplink.bytes(),
                frames: uplink.frames(),
                frames_again: uplink.frames_again(),
                airtime_up_pct: airtime_down_pct
                    .and_then(|_| plausible_share_pct(uplink.bytes(), capture.end())),
            }),
            robot: self.robot,
            restarts: seen.restarts,
            distance_in: self.distance_in,
            holders,
            battery_first_v: self.battery_dv.map(|(first, _)| volts(first)),
            battery_last_v: self.battery_dv.map(|(_, last)| volts(last)),
            bumps: self.bumps.total(),
            problem,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::duration_words;

    #[test]
    fn a_duration_is_told_as_people_say_it() {
        for (duration_s, words) in [
            (0.04, "0 min 0.0 s"),
            (119.97, "2 min 0.0 s"),
            (305.3, "5 min 5.3 s"),
            (3599.94, "59 min 59.9 s"),
            (3599.96, "1 h 0 min 0 s"),
            (86_217.0, "23 h 56 min 57 s"),
        ] {
            assert_eq!(duration_words(duration_s), words);
        }
    }
}
