//! The arguments of the verbs that simulate: `demo`, `sim` and `world`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap_complete::engine::ArgValueCompleter;

use super::live::{RecordingArgs, Sharing};
use super::{laid_out, parse_duration, parse_factor, parse_seed};
use crate::commands::completions;
use crate::radio::RadioKind;

/// What to simulate.
#[derive(Clone, Debug, Args)]
pub struct Simulated {
    /// A world that comes with the program, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = "house", add = ArgValueCompleter::new(completions::worlds))]
    pub world: String,
    /// Seed of everything random
    #[arg(long, default_value_t = 1, value_parser = parse_seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// How the radio behaves, any of these with commas between: ber=1e-3 (bit errors), burst=50 (in clumps of so many
    /// bits), drop=0.01 and dup=0.01 (bytes lost, doubled), delay=0.5s, half-duplex, squelch (noise while the other
    /// side is silent; squelch=out: in outages too), modem=hc-12 or modem=xbee (buffered half-duplex modules),
    /// out=10s..12s (nothing passes)
    #[arg(long, value_name = "SPEC", default_value = "", add = ArgValueCompleter::new(completions::channel))]
    pub channel: String,
    /// What kind of radio the robot has; half, hc-12 and xbee make it take turns with the ground
    #[arg(long, value_enum, value_name = "KIND", default_value = "full")]
    pub radio: RadioKind,
    /// Charge of the robot's battery at the start, per cent: with 15 it soon calls
    #[arg(long, value_name = "PERCENT", default_value_t = 100, value_parser = clap::value_parser!(u8).range(..=100))]
    pub battery: u8,
    /// Multiple of real time
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_factor)]
    pub time_factor: f64,
}

/// `demo`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave demo --seed 3 --channel ber=1e-3
  groundwave demo --world living-room --record"))]
pub struct Demo {
    /// What to simulate.
    #[command(flatten)]
    pub simulated: Simulated,
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

/// `sim`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave sim                            prints the path of a pseudo-terminal: cat it, tio it, watch it
  groundwave sim --listen 127.0.0.1:4000    then: groundwave watch tcp:127.0.0.1:4000"))]
pub struct Sim {
    /// What to simulate.
    #[command(flatten)]
    pub simulated: Simulated,
    /// Link the pseudo-terminal under this path
    #[arg(long, value_name = "PATH", conflicts_with = "listen")]
    pub pty: Option<PathBuf>,
    /// Serve on a TCP address instead
    #[arg(long, value_name = "ADDR")]
    pub listen: Option<String>,
    /// Stop after this much simulated time: 30s, 90m, 2h
    #[arg(long, value_name = "T", value_parser = parse_duration)]
    pub duration: Option<Duration>,
    /// Keep what the robot remembers over a reset in this file; --pty PATH keeps it beside PATH
    #[arg(long, value_name = "FILE")]
    pub eeprom: Option<PathBuf>,
    /// Write here, as CSV, what is really so and why the robot does what it does, tick by tick
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Write here what the robot's beeper sounds, in simulated time
    #[arg(long, value_name = "FILE")]
    pub wav: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// `world`
#[derive(Debug, Args)]
#[command(after_help = laid_out("\
Examples:
  groundwave world                          list them
  groundwave world office                   show one
  groundwave world my-flat.toml             check and show your own
  groundwave world my-flat.toml --check     say nothing but what is wrong; exit code 1 if something is to be looked at
  groundwave world generated:7 --text       a house made from a seed, as a file to start from
  groundwave world house --svg house.svg    draw it to scale"))]
pub struct World {
    /// A world that comes with the program, generated:SEED or a TOML file
    #[arg(value_name = "NAME|FILE", add = ArgValueCompleter::new(completions::worlds))]
    pub world: Option<String>,
    /// No picture: warnings alone, and exit code 1 when there is one
    #[arg(long, requires = "world", conflicts_with_all = ["svg", "text"])]
    pub check: bool,
    /// Write it as a drawing
    #[arg(long, value_name = "FILE", requires = "world")]
    pub svg: Option<PathBuf>,
    /// Write the world's own text instead of a picture
    #[arg(long, requires = "world", conflicts_with = "svg")]
    pub text: bool,
    /// Overwrite an existing file
    #[arg(long, requires = "svg")]
    pub force: bool,
}
