//! A day of an unreliable link in virtual time: every command ends, and memory does not grow.
//!
//! The robot is the real program without a world, so that a day takes seconds; it stands still and senses nothing.
//! Station, dashboard model and radio are real.

use std::fmt::{self, Write as _};
use std::process::Command;
use std::time::Duration;

use groundwave::event::{CommandStatus, Event, LinkEvent};
use groundwave::model::{Config as ModelConfig, Model};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::Config;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::{Duplex, Identity, Inputs};
use sr04_firmware::robot::Robot;
use sr04_sim::{ChannelSpec, Radio, TICK_MS};

use crate::common::is_nightly;

const HOUR_MS: u64 = 3_600_000;

/// Environment variable that is set for the child process.
const ALONE: &str = "GROUNDWAVE_TEST_ALONE";

/// Channels in turn, with their durations in seconds.
const WEATHER: [(&str, u64); 8] = [
    ("", 211),
    ("ber=1e-3", 97),
    ("out=0s..1000000s", 41),
    ("ber=3e-3,burst=80", 61),
    ("out=0s..1000000s", 7),
    ("squelch,delay=400ms", 47),
    ("out=0s..1000000s", 173),
    ("drop=0.01,dup=0.01", 31),
];

/// Interval of commands, seconds; they meet good and bad channels.
const ORDER_EVERY_S: u64 = 149;

struct Day {
    now_ms: u64,
    robot: Robot,
    radio: Radio,
    station: Station,
    model: Model,
    orders: u64,
    confirmed: u64,
    failed: u64,
}

impl Day {
    fn new() -> Self {
        let identity = Identity::new(7, 1, 1, Duplex::Full);
        Self {
            now_ms: 0,
            robot: Robot::new(identity),
            radio: Radio::new(&ChannelSpec::default(), 1),
            station: Station::new(Config::new(677), true),
            model: Model::new(ModelConfig::default()),
            orders: 0,
            confirmed: 0,
            failed: 0,
        }
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.now_ms)
    }

    fn run_s(&mut self, seconds: u64) {
        for _ in 0..seconds * 1000 {
            self.step();
        }
    }

    fn step(&mut self) {
        self.now_ms += 1;
        if self.now_ms.is_multiple_of(TICK_MS) {
            self.robot.tick(&Inputs::default());
        }
        self.radio.step(self.now_ms, || self.robot.poll_downlink());
        while let Some(byte) = self.radio.poll_uplink(self.now_ms) {
            self.robot.handle_uplink(byte);
        }
        let now = self.now();
        while let Some(byte) = self.radio.poll_downlink(self.now_ms) {
            self.station.handle_bytes(now, &[byte]);
        }
        // A byte time, the shortest interval of anything.
        if self.now_ms.is_multiple_of(4) {
            self.serve_station(now);
        }
    }

    fn serve_station(&mut self, now: Duration) {
        if self.station.poll_timeout().is_some_and(|at| at <= now) {
            self.station.handle_timeout(now);
        }
        while let Some(bytes) = self.station.poll_transmit(now) {
            self.radio.transmit(&bytes);
        }
        while let Some(event) = self.station.poll_event() {
            if let Event::Command { status, .. } = &event {
                match status {
                    CommandStatus::Confirmed { .. } => self.confirmed += 1,
                    CommandStatus::Refused(_) | CommandStatus::Failed(_) => self.failed += 1,
                    _ => {}
                }
            }
            self.model.update(now, event);
        }
        if self.model.poll_timeout().is_some_and(|at| at <= now) {
            self.model.update(now, Event::Tick);
        }
    }

    fn weather(&mut self, channel: &str) {
        self.radio.set(&channel.parse().expect("a channel"));
        // Some outages are those of the cable.
        if channel.starts_with("out") && self.orders.is_multiple_of(2) {
            let lost = LinkEvent::Lost {
                reason: "unplugged".to_owned(),
            };
            let opened = LinkEvent::Opened {
                name: "/dev/ttyUSB0".to_owned(),
                can_send: true,
            };
            for event in [lost, opened] {
                self.station.handle_link(self.now(), event);
            }
        }
    }

    fn order(&mut self) {
        let n = self.orders as i16;
        let request = match self.orders % 5 {
            0 => Request::Mode(Mode::Reactive),
            1 => Request::Route(points(n, 30)),
            2 => Request::Pose {
                position: points(n, 1)[0],
                theta_deg: 90,
            },
            3 => Request::Route(points(n, 300)),
            _ => Request::Stop,
        };
        self.orders += 1;
        self.station.handle_request(self.now(), request, None);
    }

    /// Runs all channels for an hour, with commands.
    fn hour(&mut self) {
        let end_ms = self.now_ms + HOUR_MS;
        let (mut weather_s, mut order_s) = (0, ORDER_EVERY_S);
        let mut turn = WEATHER.iter().cycle();
        while self.now_ms < end_ms {
            if weather_s == 0 {
                let (channel, time_s) = turn.next().expect("it goes round");
                self.weather(channel);
                weather_s = *time_s;
            }
            if order_s == 0 {
                self.order();
                order_s = ORDER_EVERY_S;
            }
            let time_s = weather_s.min(order_s);
            self.run_s(time_s);
            weather_s -= time_s;
            order_s -= time_s;
        }
    }

    /// Length in bytes of the printed state of station and model. The text is not kept: it would count as resident memory.
    fn size(&self) -> usize {
        let mut length = Length(0);
        write!(length, "{:?}{:?}{:?}", self.station, self.model, self.radio)
            .expect("it takes any text");
        length.0
    }
}

/// Counts the bytes of a text.
struct Length(usize);

impl fmt::Write for Length {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0 += text.len();
        Ok(())
    }
}

fn points(n: i16, count: i16) -> Vec<Waypoint> {
    (0..count)
        .map(|k| Waypoint {
            x_in: n % 900 * 10 + k,
            y_in: k - n % 700,
        })
        .collect()
}

/// Resident memory of this process without its program, whose pages come in as they are first used; `None` if the system
/// does not report it.
fn resident_kib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("RssAnon:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// Runs as a separate process, because other tests of this binary would count as resident memory.
#[test]
fn nothing_grows_over_a_day_of_outages() {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "endurance::a_day_of_outages", "--nocapture"])
        .env(ALONE, "1")
        .output()
        .unwrap();
    let said =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(output.status.success(), "{}", said.concat());
}

/// The child process of the test above: a whole day in `cargo xtask nightly`, otherwise six hours.
#[test]
fn a_day_of_outages() {
    if std::env::var_os(ALONE).is_none() {
        return;
    }
    let hours = if is_nightly() { 24 } else { 6 };
    let mut day = Day::new();
    // Logs, trails and charts are full after this.
    for _ in 0..4 {
        day.hour();
    }
    let (early_size, early_kib) = (day.size(), resident_kib());
    for _ in 4..hours {
        day.hour();
    }
    let (late_size, late_kib) = (day.size(), resident_kib());
    day.weather("");
    day.run_s(300);
    println!(
        "{} orders, {} confirmed, {} failed; {early_size} then {late_size} characters of state, resident \
         {early_kib:?} then {late_kib:?} KiB",
        day.orders, day.confirmed, day.failed
    );
    assert!(day.station.is_settled(), "everything has ended");
    assert_eq!(day.confirmed + day.failed, day.orders);
    assert!(
        day.confirmed > day.orders / 2,
        "{} confirmed",
        day.confirmed
    );
    assert!(late_size < early_size + early_size / 10);
    if let (Some(early), Some(late)) = (early_kib, late_kib) {
        assert!(late < early + 256, "resident {early} then {late} KiB");
    }
}
