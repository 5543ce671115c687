//! The arguments of the verbs that listen to a link: `watch` and `record`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgGroup, Args};
use clap_complete::engine::ArgValueCompleter;

use super::super::completions;
use super::super::config::Config;
use super::{laid_out, parse_baud, parse_duration};
use crate::capture::Rotation;
use crate::io::foxglove::DEFAULT_ADDRESS;
use crate::io::link::{BAUD, LinkSpec};
use crate::radio::{Radio, RadioKind};
use crate::share::Address;

/// What is known of the radio.
#[derive(Clone, Debug, Default, Args)]
pub struct RadioArgs {
    /// Baud rate of the serial device [default: 2400]
    #[arg(long, value_parser = parse_baud)]
    pub baud: Option<u32>,
    /// What kind of radio it is [default: auto]
    #[arg(long, value_enum, value_name = "KIND")]
    pub radio: Option<RadioKind>,
    /// What the radio adds to the time on the wire, both ways together: 80ms
    #[arg(long, value_name = "T", value_parser = parse_duration)]
    pub latency: Option<Duration>,
    /// Never send a byte: as --radio receive-only
    #[arg(long, conflicts_with = "radio")]
    pub no_uplink: bool,
}

impl RadioArgs {
    /// The port's rate: what is said here outranks the configuration.
    #[must_use]
    pub fn baud(&self, config: &Config) -> u32 {
        self.baud.or(config.link.baud).unwrap_or(BAUD)
    }

    /// The radio: what is said here outranks the configuration.
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

/// Where received bytes are kept.
#[derive(Clone, Debug, Default, Args)]
pub struct RecordingArgs {
    /// Copy every received byte to FILE, before anything else happens to it
    #[arg(long, value_name = "FILE")]
    pub tee: Option<PathBuf>,
    /// Record to an MCAP file; without FILE under a name made from the date
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    pub record: Option<Option<PathBuf>>,
    /// Go on in another MCAP file after so long, or when the disk has so many bytes of it (what comes in 10 s is more):
    /// 1h, 64MB, 1h,64MB, never [default: 24h]
    #[arg(long, value_name = "T|SIZE")]
    pub rotate: Option<Rotation>,
    /// Add to an existing --tee file
    #[arg(long, conflicts_with = "force")]
    pub append: bool,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// Who else may use the link.
#[derive(Clone, Debug, Default, Args)]
#[command(group = ArgGroup::new("shared").args(["share", "foxglove"]).multiple(true))]
pub struct Sharing {
    /// Share the link on a port of this machine (4001, 127.0.0.1:4001) or a Unix socket (/tmp/x.sock):
    /// others read the raw bytes there, and `send --via` sends through it
    #[arg(long, value_name = "ADDR|PATH")]
    pub share: Option<Address>,
    /// Let Foxglove, Lichtblick and others watch live and steer, on this port or address
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = DEFAULT_ADDRESS)]
    pub foxglove: Option<Address>,
    /// Let --share and --foxglove be reached from other machines: whoever reaches them can steer the robot
    #[arg(long, requires = "shared")]
    pub share_open_to_network: bool,
}

impl Sharing {
    /// What is said here outranks the configuration.
    #[must_use]
    pub fn or(&self, config: &Config) -> Self {
        Self {
            share: self.share.clone().or_else(|| config.link.share.clone()),
            ..self.clone()
        }
    }
}

/// `watch`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave watch /dev/ttyUSB0 --tee evening.txt --record
  groundwave watch tcp:robot.local:4000
  groundwave watch /dev/ttyUSB0 --share /tmp/x.sock     then: groundwave send --via /tmp/x.sock stop
  ssh robot cat /dev/ttyS0 | groundwave watch -"))]
pub struct Watch {
    /// A serial device, tcp:HOST:PORT, unix:PATH, - (standard input) or sim
    #[arg(add = ArgValueCompleter::new(completions::links))]
    pub link: LinkSpec,
    /// What is known of the radio.
    #[command(flatten)]
    pub radio: RadioArgs,
    /// No dashboard: events as JSON lines on standard output
    #[arg(long)]
    pub headless: bool,
    /// Ring the bell for alarms and songs; key b switches it while it runs
    #[arg(long)]
    pub bell: bool,
    /// Where received bytes are kept.
    #[command(flatten)]
    pub recording: RecordingArgs,
    /// Who else may use the link.
    #[command(flatten)]
    pub sharing: Sharing,
}

/// `record`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave record /dev/ttyUSB0 -o evening.mcap
  groundwave record /dev/ttyUSB0 -o evening.txt --duration 90m"))]
pub struct Record {
    /// A serial device, tcp:HOST:PORT, unix:PATH, - (standard input) or sim
    #[arg(add = ArgValueCompleter::new(completions::links))]
    pub link: LinkSpec,
    /// Where to; .mcap is recorded as MCAP, anything else as the raw bytes. Without it, as MCAP under a name made
    /// from the date
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Go on in another MCAP file after so long, or when the disk has so many bytes of it (what comes in 10 s is more):
    /// 1h, 64MB, 1h,64MB, never [default: 24h]
    #[arg(long, value_name = "T|SIZE")]
    pub rotate: Option<Rotation>,
    /// Stop after this long: 30s, 90m, 2h
    #[arg(long, value_name = "T", value_parser = parse_duration)]
    pub duration: Option<Duration>,
    /// Baud rate of the serial device [default: 2400]
    #[arg(long, value_parser = parse_baud)]
    pub baud: Option<u32>,
    /// Add to an existing raw file
    #[arg(long, conflicts_with = "force")]
    pub append: bool,
    /// Overwrite an existing file
    #[arg(long)]
    pub force: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Who else may use the link; nobody can send through a recording.
    #[command(flatten)]
    pub sharing: Sharing,
}
