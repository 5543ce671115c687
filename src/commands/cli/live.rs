//! The arguments of `watch` and `record`, and those about radio, recording and sharing.

use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgGroup, Args};
use clap_complete::engine::ArgValueCompleter;

use super::super::completions;
use super::super::config::{Config, Theme};
use super::super::sharing::{parse_address, parse_station};
use super::{Connection, laid_out, parse_baud, parse_duration};
use crate::capture::Rotation;
use crate::io::foxglove::DEFAULT_ADDRESS;
use crate::io::link::{BAUD, LinkSpec};
use crate::model::Advise;
use crate::radio::{Radio, RadioKind};
use crate::share::Address;

/// Options for opening a link.
#[derive(Clone, Debug, Default, Args)]
pub struct LinkArgs {
    /// Baud rate of the serial device [default: 2400], or of a serial server on the network [default: the robot's]
    #[arg(long, value_parser = parse_baud)]
    pub baud: Option<u32>,
    /// Wait until the link exists, without limit or at most for a time (--wait=30s)
    #[arg(long, value_name = "T", num_args = 0..=1, require_equals = true, value_parser = parse_duration)]
    pub wait: Option<Option<Duration>>,
}

impl LinkArgs {
    /// The port's baud rate, from the command line or else the configuration.
    #[must_use]
    pub fn baud(&self, config: &Config) -> u32 {
        self.asked_baud(config).unwrap_or(BAUD)
    }

    /// The baud rate on the command line or else in the configuration.
    #[must_use]
    pub fn asked_baud(&self, config: &Config) -> Option<u32> {
        self.baud.or(config.link.baud)
    }
}

/// The radio.
#[derive(Clone, Debug, Default, Args)]
pub struct RadioArgs {
    /// The link.
    #[command(flatten)]
    pub link: LinkArgs,
    /// Kind of radio [default: auto]
    #[arg(long, value_enum, value_name = "KIND")]
    pub radio: Option<RadioKind>,
    /// Latency that the radio adds to a round trip, such as 80ms [default: measured, or known for this kind of radio]
    #[arg(long, value_name = "T", value_parser = parse_duration)]
    pub latency: Option<Duration>,
    /// Never send a byte; the same as --radio receive-only
    #[arg(long, conflicts_with = "radio")]
    pub no_uplink: bool,
}

impl RadioArgs {
    /// The radio, from the command line or else the configuration.
    #[must_use]
    pub fn radio(&self, config: &Config) -> Radio {
        let kind = if self.no_uplink {
            RadioKind::ReceiveOnly
        } else {
            self.radio.or(config.link.radio).unwrap_or_default()
        };
        Radio {
            kind,
            latency: self.latency.or_else(|| config.link.latency()),
        }
    }
}

/// Options for recording received bytes.
#[derive(Clone, Debug, Default, Args)]
pub struct RecordingArgs {
    /// Copy every received byte to FILE
    #[arg(long, value_name = "FILE")]
    pub tee: Option<PathBuf>,
    /// Record to an MCAP file [default name: from date and time]
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    pub record: Option<Option<PathBuf>>,
    /// Start another MCAP file after a time, a size or the first of both: 1h, 64MB or 1h,64MB; never [default: 24h]
    #[arg(long, value_name = "T|SIZE")]
    pub rotate: Option<Rotation>,
    /// Append to an existing --tee file
    #[arg(long, conflicts_with = "force")]
    pub append: bool,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// Options for sharing the link.
#[derive(Clone, Debug, Default, Args)]
#[command(group = ArgGroup::new("shared").args(["share", "foxglove"]).multiple(true))]
pub struct Sharing {
    /// Share the link on a Unix socket (/tmp/x.sock) or a local port (4001, 127.0.0.1:4001): your other programs
    /// read the raw bytes there, and `watch --via` and `send --via` send through it [default: a socket that --via finds]
    #[arg(long, value_name = "ADDR|PATH", num_args = 0..=1, default_missing_value = "", value_parser = parse_address)]
    pub share: Option<Address>,
    /// Serve Foxglove and Lichtblick on this port or address; every user of this machine can watch and steer the robot there
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = DEFAULT_ADDRESS)]
    pub foxglove: Option<Address>,
    /// Allow addresses that other machines can reach. Clients of --share must then send its token; with --foxglove every
    /// machine can steer the robot; neither is encrypted
    #[arg(long, requires = "shared")]
    pub share_open_to_network: bool,
}

impl Sharing {
    /// The sharing options, with missing values from the configuration.
    #[must_use]
    pub fn or(&self, config: &Config) -> Self {
        Self {
            share: self.share.clone().or_else(|| config.link.share.clone()),
            ..self.clone()
        }
    }
}

/// Arguments of `watch`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave watch /dev/ttyUSB0 --tee evening.txt --record
  groundwave watch tcp:robot.local:4000
  groundwave watch /dev/ttyUSB0 --share                 then: groundwave send --via stop
  groundwave watch --via                                a second dashboard of the same robot
  ssh robot cat /dev/ttyS0 | groundwave watch -"))]
pub struct Watch {
    /// A serial device, tcp:HOST:PORT, unix:PATH, - (standard input) or sim; omit it with --via
    #[arg(required_unless_present = "via", conflicts_with = "via", add = ArgValueCompleter::new(completions::links))]
    link: Option<LinkSpec>,
    /// A second dashboard for a station that was started with --share [default: the station on this machine]
    #[arg(long, value_name = "ADDR|PATH", num_args = 0..=1, default_missing_value = "", value_parser = parse_station)]
    via: Option<Address>,
    /// The radio.
    #[command(flatten)]
    pub radio: RadioArgs,
    /// Write events as JSON lines to standard output instead of showing a dashboard
    ///
    /// An outage has an event when it begins (`end_s` is null) and one when it has ended and its lost lines are known. Both have the same
    /// `begin_s`; the second one has the final cause. If the session ends in an outage,
    /// its second event has no `end_s` and counts the lines that may be lost.
    #[arg(long)]
    pub headless: bool,
    /// Ring the bell for alarms and songs; key b switches it
    #[arg(long)]
    pub bell: bool,
    /// Colours of the dashboard; key Ctrl-T changes them
    #[arg(long, value_name = "THEME")]
    pub theme: Option<Theme>,
    /// Use of the station's suggestions [default: suggest]
    #[arg(long, value_enum, value_name = "HOW", num_args = 0..=1, require_equals = true, default_missing_value = "suggest")]
    pub advise: Option<Advise>,
    /// Options for recording received bytes.
    #[command(flatten)]
    pub recording: RecordingArgs,
    /// Options for sharing the link.
    #[command(flatten)]
    pub sharing: Sharing,
}

impl Watch {
    /// The connection to the radio.
    ///
    /// # Errors
    /// If neither a link nor `--via` is given.
    pub fn connection(&self) -> Result<Connection, String> {
        Connection::new(self.via.as_ref(), self.link.as_ref())
    }
}

/// Arguments of `record`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave record /dev/ttyUSB0 -o evening.mcap
  groundwave record /dev/ttyUSB0 -o evening.txt --duration 90m
  groundwave record /dev/ttyUSB0 --share            then: groundwave send --via stop"))]
pub struct Record {
    /// A serial device, tcp:HOST:PORT, unix:PATH, - (standard input) or sim
    #[arg(add = ArgValueCompleter::new(completions::links))]
    pub link: LinkSpec,
    /// Output file: MCAP if the name ends in .mcap, else the raw bytes [default: MCAP, named by date and time]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Start another MCAP file after a time, a size or the first of both: 1h, 64MB or 1h,64MB; never [default: 24h]
    #[arg(long, value_name = "T|SIZE")]
    pub rotate: Option<Rotation>,
    /// Stop after this time: 30s, 90m, 2h
    #[arg(long, value_name = "T", value_parser = parse_duration)]
    pub duration: Option<Duration>,
    /// Options of the radio, for commands from clients of a shared link.
    #[command(flatten)]
    pub radio: RadioArgs,
    /// Append to an existing raw file
    #[arg(long, conflicts_with = "force")]
    pub append: bool,
    /// Overwrite an existing file
    #[arg(long)]
    pub force: bool,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Options for sharing the link; `record` itself never sends.
    #[command(flatten)]
    pub sharing: Sharing,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave check evening.txt
  groundwave check /dev/ttyUSB0 --duration 1m
  groundwave check tcp:robot.local:4000 --json | jq .findings
  groundwave check sim --send --yes                  check the rules for commands, too

For the programmer of a robot. Each mistake is reported with its line, column, content, the form that SPEC.md expects, the likely cause and
the remedy. Damage by the radio is not a mistake: a fault that the radio may have caused counts only if it recurs and a common mistake explains it.
From a link, the command only receives, until Ctrl-C. The level reported is the highest that the lines show. docs/check.md lists the codes.

With --send, the command sends commands that the robot must execute, refuse or ignore: repeated ones, some with wrong keys, lists with
missing waypoints, late hand drive, STOP, a reset. Lift the robot's wheels off the floor. The test takes two to four minutes. Exit codes:
0 no mistake, 1 mistakes or no intact line."))]
pub struct Check {
    /// A capture (the robot's bytes as received, or MCAP), - for standard input, or a link as for `watch`
    #[arg(value_name = "FILE|LINK", add = ArgValueCompleter::new(completions::checked))]
    pub from: LinkSpec,
    /// Listen to a link for this time: 30s, 90m, 2h
    #[arg(long, value_name = "T", value_parser = parse_duration, conflicts_with = "send")]
    pub duration: Option<Duration>,
    /// Options for opening a link.
    #[command(flatten)]
    pub link: LinkArgs,
    /// Send commands and check the robot's reactions; asks before sending
    #[arg(long)]
    pub send: bool,
    /// Send without asking
    #[arg(long, requires = "send")]
    pub yes: bool,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}
