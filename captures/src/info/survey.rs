//! Collects the summary of a capture from its lines.

use std::convert::Infallible;
use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Received};
use groundwave_protocol::status_codes::Layer;
use groundwave_protocol::telemetry::{Body, CountersLine, HOLDERS, Line};
use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};

use super::{HolderShare, Info, LineCounts, Robot, Sent};
use crate::bumps::Bumps;
use crate::chunk::Chunk;
use crate::diagnosis::{Diagnosis, Line as AnyLine};
use crate::gaps::Gaps;
use crate::odometer::Odometer;
use crate::outages::OutageList;
use crate::own_lines::{OwnSummary, recognizer};
use crate::session::Session;
use crate::statistics::{
    self, BITS_PER_BYTE, Damaged, Loss, OtherRobot, SHARE_MAX_PCT, per_cent, share_pct,
};
use crate::words::layer_word;
use crate::{Capture, CaptureError};

/// Silence after which the tick count (modulo 4096, at 20 Hz) is ambiguous, seconds.
const TICKS_ROUND_S: u32 = 200;

/// Airtime of `bytes` within `time`, per cent; `None` if the radio cannot carry them.
fn plausible_share_pct(bytes: u64, time: Duration, bytes_per_s: u32) -> Option<f64> {
    if time.is_zero() && bytes > 0 {
        return None;
    }
    Some(share_pct(bytes, time, bytes_per_s)).filter(|share_pct| *share_pct <= SHARE_MAX_PCT)
}

/// Totals so far.
#[derive(Default)]
pub(super) struct Survey {
    lines: LineCounts,
    robot: Option<Robot>,
    odometer: Odometer,
    battery_dv: Option<(u16, u16)>,
    counters: Option<CountersLine>,
    robot_clock_s: Option<u64>,
    ticks: [u64; HOLDERS],
    bumps: Bumps,
    since_line_feed: u64,
    /// Number of bytes at time zero.
    first_bytes: u64,
    /// Rate that the robot's latest line I shows.
    own_bytes_per_s: Option<u32>,
    gaps: Gaps,
    noise: statistics::Gaps,
    outages: OutageList,
    own: OwnSummary,
}

impl Survey {
    /// Reads a capture to its end; returns the counts and the mistakes in its lines.
    pub(super) fn take_all(
        &mut self,
        capture: &mut Capture,
    ) -> (Diagnosis, Result<(), CaptureError>) {
        let (mut diagnosis, mut latest) = (None, Duration::ZERO);
        let result = self.take_chunks(capture, &mut diagnosis, &mut latest);
        for (received, counters) in diagnosis.iter().flat_map(Diagnosis::undecided_lines) {
            self.take(latest, &received, counters);
        }
        (diagnosis.unwrap_or_default(), result)
    }

    fn take_chunks(
        &mut self,
        capture: &mut Capture,
        diagnosis: &mut Option<Diagnosis>,
        latest: &mut Duration,
    ) -> Result<(), CaptureError> {
        while let Some(chunk) = capture.next_chunk()? {
            let diagnosis =
                diagnosis.get_or_insert_with(|| Diagnosis::new(recognizer(chunk.session)));
            if chunk.has_time {
                diagnosis.set_time(chunk.at);
            }
            if chunk.is_interrupted() {
                self.gaps.interrupt();
                self.noise.interrupt();
                if chunk.is_after_missing {
                    diagnosis.skip();
                } else {
                    diagnosis.interrupt();
                }
            }
            self.outages.handle_chunk(&chunk);
            let Chunk { at, bytes, .. } = chunk;
            if at.is_zero() {
                self.first_bytes += bytes.len() as u64;
            }
            self.since_line_feed = match bytes.iter().rposition(|&byte| byte == b'\n') {
                Some(at) => (bytes.len() - at - 1) as u64,
                None => self.since_line_feed + bytes.len() as u64,
            };
            *latest = at;
            let Ok(()) = diagnosis.each_line(bytes, |line, counters| {
                match line {
                    AnyLine::Own(line) => self.own.take(line),
                    AnyLine::Wire(received) => self.take(at, received, counters),
                }
                Ok::<(), Infallible>(())
            });
        }
        Ok(())
    }

    fn take(&mut self, at: Duration, received: &Received, counters: &Counters) {
        self.outages.handle_line(at, received, counters);
        self.gaps.take_line(at, received, counters);
        self.noise.take_line(counters);
        self.odometer.take(at, received);
        self.lines.add(received);
        if let Received::Line(line, _) = received {
            self.take_line(line);
        }
    }

    fn take_line(&mut self, line: &Line) {
        match &line.body {
            Body::State(state) => {
                self.bumps.take_state(state);
            }
            Body::Status(status) => {
                let (first, _) = self.battery_dv.unwrap_or((status.battery_dv, 0));
                self.battery_dv = Some((first, status.battery_dv));
            }
            Body::Counters(counters) => self.take_counters(counters),
            Body::Abilities(robot) => self.own_bytes_per_s = Some(robot.rate_bytes_per_s),
            Body::Text(_)
            | Body::Parameter(_)
            | Body::Song(_)
            | Body::Field(_)
            | Body::Values(_) => {}
        }
    }

    fn take_counters(&mut self, counters: &CountersLine) {
        self.robot = Some(Robot {
            id: counters.robot_id,
            firmware_version: format!("{}.{:02}", counters.version.major, counters.version.minor),
        });
        self.bumps.take_counters(counters);
        if let Some(last) = &self.counters
            && (last.robot_id, last.boots) == (counters.robot_id, counters.boots)
            && let Some(passed_s) = counters.uptime_s.checked_sub(last.uptime_s)
        {
            *self.robot_clock_s.get_or_insert_default() += u64::from(passed_s);
            if passed_s < TICKS_ROUND_S {
                let won = counters.ticks_won.iter().zip(&last.ticks_won);
                for (total, (now, then)) in self.ticks.iter_mut().zip(won) {
                    *total += u64::from(now.wrapping_sub(*then) % 4096);
                }
            }
        }
        self.counters = Some(*counters);
    }

    pub(super) fn into_info(
        self,
        capture: &Capture,
        diagnosis: &Diagnosis,
        problem: Option<String>,
    ) -> Info {
        let seen = &diagnosis.counters_until(capture.latest());
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
        let volts = |dv: u16| f64::from(dv) / 10.0;
        let may_become_a_line = self.since_line_feed < LINE_BYTES as u64;
        let unfinished_bytes = if may_become_a_line {
            self.since_line_feed.min(seen.noise_bytes)
        } else {
            0
        };
        let after_first = seen.bytes - self.first_bytes;
        let said = |what: &str| capture.session()?.get(what).cloned();
        let baud = said(Session::BAUD).and_then(|baud| baud.parse::<u32>().ok());
        let port_bytes_per_s = baud.map(|baud| baud / BITS_PER_BYTE);
        let slower = [port_bytes_per_s, self.own_bytes_per_s];
        let bytes_per_s = slower.into_iter().flatten().min().unwrap_or(BYTES_PER_S);
        let share_pct = |bytes| plausible_share_pct(bytes, capture.end(), bytes_per_s);
        let is_timed = capture.uplink().is_some() && capture.has_time();
        let airtime_down_pct = share_pct(after_first).filter(|_| is_timed);
        let version = said("software_version").map(|version| format!(" {version}"));
        let is_own = self.lines.total() == 0 && self.own.outweighs(&Damaged::of(seen));
        Info {
            start: said("start"),
            link: said("link"),
            software: said("software").map(|it| it + &version.unwrap_or_default()),
            name: None,
            void: None,
            marks: (capture.marks().moments().iter().copied())
                .map(Into::into)
                .collect(),
            notes: Vec::new(),
            form: capture.form(),
            stored: capture.stored(),
            duration_s: capture.end().as_secs_f64(),
            robot_clock_s: self.robot_clock_s,
            bytes: seen.bytes,
            noise_bytes: seen.noise_bytes,
            unfinished_bytes,
            missing_bytes: capture.missing_bytes(),
            lines: self.lines,
            loss: Loss::of(seen),
            gaps: self.gaps.count(),
            // The first line of another kind of robot may not have been recognized as the robot's own.
            damaged: if is_own {
                Damaged::default()
            } else {
                Damaged::of(seen)
            },
            mistakes: if is_own {
                Vec::new()
            } else {
                diagnosis.findings()
            },
            other: OtherRobot::of(seen),
            outages: capture.outages(self.outages, seen),
            resync: self.noise.resync(),
            airtime_down_pct,
            sent: capture.uplink().map(|uplink| Sent {
                bytes: uplink.bytes(),
                frames: uplink.frames(),
                frames_again: uplink.frames_again(),
                airtime_up_pct: airtime_down_pct.and_then(|_| share_pct(uplink.bytes())),
            }),
            robot: self.robot,
            restarts: seen.restarts,
            distance_in: self.odometer.distance_in,
            holders,
            battery_first_v: self.battery_dv.map(|(first, _)| volts(first)),
            battery_last_v: self.battery_dv.map(|(_, last)| volts(last)),
            bumps: self.bumps.total(),
            own: (!self.own.is_empty()).then_some(self.own),
            problem,
        }
    }
}
