//! The arguments of `demo`, `sim` and `world`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap_complete::engine::ArgValueCompleter;

use super::live::{RecordingArgs, Sharing};
use super::{laid_out, parse_duration, parse_factor, parse_seed};
use crate::commands::completions;
use crate::commands::config::Theme;
use crate::model::Advise;
use crate::radio::RadioKind;

/// Options of the simulation.
#[derive(Clone, Debug, Args)]
pub struct Simulated {
    /// A built-in world or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = "house", add = ArgValueCompleter::new(completions::worlds))]
    pub world: String,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1, value_parser = parse_seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// Faults of the radio, separated by commas: ber=1e-3 (bit error rate), burst=50 (errors in bursts of 50 bits),
    /// drop=0.01 and dup=0.01 (bytes lost, doubled), delay=0.5s, half-duplex, squelch (noise while the other side is
    /// silent; squelch=out: in outages too), modem=hc-12 or modem=xbee (buffered half-duplex modules), out=10s..12s
    /// (outage)
    #[arg(long, value_name = "SPEC", default_value = "", add = ArgValueCompleter::new(completions::channel))]
    pub channel: String,
    /// The robot's radio; with half, hc-12 and xbee, the robot and the station take turns
    #[arg(long, value_enum, value_name = "KIND", default_value = "full")]
    pub radio: RadioKind,
    /// Charge of the robot's battery at the start in per cent; at 15 the alarm follows soon
    #[arg(long, value_name = "PERCENT", default_value_t = 100, value_parser = clap::value_parser!(u8).range(..=100))]
    pub battery: u8,
    /// Speed, as a multiple of real time
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_factor)]
    pub time_factor: f64,
}

/// Arguments of `demo`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave demo --seed 3 --channel ber=1e-3
  groundwave demo --world living-room --record"))]
pub struct Demo {
    /// Options of the simulation.
    #[command(flatten)]
    pub simulated: Simulated,
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

/// Arguments of `sim`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave sim                            prints the path of a pseudo-terminal, for cat, tio or watch
  groundwave sim --listen 127.0.0.1:4000    then: groundwave watch tcp:127.0.0.1:4000"))]
pub struct Sim {
    /// Options of the simulation.
    #[command(flatten)]
    pub simulated: Simulated,
    /// Make PATH a link to the pseudo-terminal
    #[arg(long, value_name = "PATH", conflicts_with = "listen")]
    pub pty: Option<PathBuf>,
    /// Serve on a TCP address instead of a pseudo-terminal
    #[arg(long, value_name = "ADDR")]
    pub listen: Option<String>,
    /// Stop after this much simulated time: 30s, 90m, 2h
    #[arg(long, value_name = "T", value_parser = parse_duration)]
    pub duration: Option<Duration>,
    /// File for the robot's EEPROM; with --pty PATH a file beside PATH is the default
    #[arg(long, value_name = "FILE")]
    pub eeprom: Option<PathBuf>,
    /// Write the true state and the robot's decisions of each tick to FILE, as CSV
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Write the sound of the robot's beeper to FILE as WAV, in simulated time
    #[arg(long, value_name = "FILE")]
    pub wav: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `world`.
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave world                          list the built-in worlds
  groundwave world office                   show one
  groundwave world my-flat.toml             check and show a world of your own
  groundwave world my-flat.toml --check     print only warnings; exit code 1 if any
  groundwave world generated:7 --text       print a generated house as a file to edit
  groundwave world house --svg house.svg    draw it to scale"))]
pub struct World {
    /// A built-in world, generated:SEED or a TOML file
    #[arg(value_name = "NAME|FILE", add = ArgValueCompleter::new(completions::worlds))]
    pub world: Option<String>,
    /// Print only warnings; exit code 1 if there are any
    #[arg(long, requires = "world", conflicts_with_all = ["svg", "text"])]
    pub check: bool,
    /// Draw the world to scale
    #[arg(long, value_name = "FILE", requires = "world")]
    pub svg: Option<PathBuf>,
    /// Print the world's TOML text
    #[arg(long, requires = "world", conflicts_with = "svg")]
    pub text: bool,
    /// Overwrite an existing file
    #[arg(long, requires = "svg")]
    pub force: bool,
}
