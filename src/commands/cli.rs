//! The command line, as clap sees it.

mod captures;
mod runs;
mod sending;

pub use captures::{
    Captures, Convert, Cut, Decode, DecodeFormat, Export, ExportFormat, Info, Output, Verify,
};
pub use runs::{Compare, Label, Runs};
pub use sending::{Calibrate, Param, Send, Way};

use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgGroup, Args, Parser, Subcommand};

use super::config::Config;
use crate::io::foxglove::DEFAULT_ADDRESS;
use crate::io::link::{BAUD, LinkSpec};
use crate::radio::{Radio, RadioKind};
use crate::share::Address;

/// Ground station for a small robot on a 2400-baud radio.
#[derive(Debug, Parser)]
#[command(
    name = "groundwave",
    version,
    about,
    max_term_width = 100,
    after_help = "\
Try it without a robot:      groundwave demo
Watch a robot on a radio:    groundwave watch /dev/ttyUSB0 --tee evening.txt
Send it somewhere:           groundwave send /dev/ttyUSB0 goto 48 0

Exit codes: 0 proven or done; 1 failed, or a capture ends early; 2 usage or bad input file; 3 not confirmed in time;
4 the link cannot be opened; 5 the robot refused; 6 the link is receive-only."
)]
pub struct Cli {
    /// Read this configuration instead of the usual one
    #[arg(long, value_name = "FILE", global = true)]
    pub config: Option<PathBuf>,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Watch a simulated robot prowl a house, live.
    Demo(Demo),
    /// Watch a robot: the live dashboard.
    Watch(Watch),
    /// Record what the radio delivers, without a dashboard.
    Record(Record),
    /// Send a command and wait for the proof that the robot has executed it.
    #[command(after_help = "\
COMMAND is one of:
  stop                          motors off; needs no session and no proof of who asks
  mode prowl|reactive|home|...  enter a mode (passive, wander, forage, calibrate, user, stop)
  prowl reactive passive wander home dock     the same in one word; dock is forage
  enable L,L   disable L,L      layers: user bumpers rotation infrared (ir) sonar photo motion dead-reckoning (dr)
  only L,L|none                 these layers and no others
  preset NAME                   layers and mode: all sonar-only sonar-ir moth shy reactive passive wander
  param NAME VALUE              set a parameter; also param list, get NAME, set NAME VALUE, save
  goto X Y                      a list of one point, whole inches from the robot's origin
  route FILE|-                  a list of `X,Y` lines
  clear                         empty the robot's list
  set-pose X Y THETA            tell the robot where it is; reset-pose is 0 0 0
  scan                          look around
  failsafe MODE Ns|off          enter a mode after N seconds (10 to 4095) without a word from the ground

Neither goto nor route changes the mode, unless --go: then `mode prowl` follows.

  groundwave send /dev/ttyUSB0 goto -48 120 --go
  groundwave send tcp:robot.local:4000 route square.txt
  groundwave send /dev/ttyUSB0 -f evening.txt     one command a line, # comments; stops at the first that fails
  groundwave send --dry-run route square.txt
  groundwave send --via /tmp/x.sock mode prowl    through a station started with --share /tmp/x.sock")]
    Send(Send),
    /// Read, change or keep the robot's parameters.
    #[command(after_help = "\
  groundwave param /dev/ttyUSB0 list
  groundwave param /dev/ttyUSB0 get top-speed
  groundwave param /dev/ttyUSB0 set top-speed 8      until the robot's next reset, unless saved
  groundwave param --via /tmp/x.sock save            over a reset; the same words go after `send`, as `param ...`

A value is proven when the robot acknowledged the order and then said the value itself.")]
    Param(Param),
    /// Drive two squares, and correct what the robot takes its wheels and track for.
    #[command(after_help = "\
The robot drives a square clockwise and one counter-clockwise, from a mark on the floor until it believes to be back on
it. After each you measure where it really is, seen as it stood at the start, and type two numbers of inches: to the
right of the mark and ahead of it. From these follow the track and the wheels' diameters, which are sent to the robot;
then it drives both again, and you see what it was good for.

  groundwave calibrate /dev/ttyUSB0 --side 157 --save
  printf '%s\\n' '3.5 -2' '-4 1.5' '0.2 0' '-0.1 0.3' | groundwave calibrate /dev/ttyUSB0")]
    Calibrate(Calibrate),
    /// Serve a simulated robot on a pseudo-terminal or a TCP port.
    Sim(Sim),
    /// Play a capture in the dashboard.
    Replay(Replay),
    /// Decode a capture to JSON lines or CSV.
    Decode(Decode),
    /// Say what is in captures.
    Info(Info),
    /// Make recordings whole that were interrupted or damaged.
    #[command(after_help = "\
A recording that was interrupted is FILE.partial with its journal, FILE.journal, beside it: name any of them, or the
folder. What holds is kept, what came in last is taken from the journal, and you are told what was saved and what was
not. It can be interrupted and repeated. A damaged file stays as FILE.damaged.

  groundwave recover evening.mcap
  groundwave recover --json ~/captures")]
    Recover(Recover),
    /// Turn raw captures into MCAP and back.
    Convert(Convert),
    /// Make tables and pictures of captures.
    Export(Export),
    /// Cut a part out of captures, by time.
    Cut(Cut),
    /// Check captures: checksums, gaps, what was recorded against what it decodes to.
    Verify(Verify),
    /// List the songs in a capture, and make them audible.
    Songs(Songs),
    /// List the captures there are, with what is said of them.
    Runs(Runs),
    /// Give a run a name and remarks, or say that it does not count.
    Label(Label),
    /// Lay two runs over each other.
    Compare(Compare),
    /// List the serial ports of this machine.
    Ports(Ports),
    /// Show a world as a picture and check it; without a name, list those that come with the program.
    World(World),
}

impl Command {
    /// Whether it opens a link, of which the configuration says something.
    #[must_use]
    pub const fn uses_config(&self) -> bool {
        matches!(
            self,
            Self::Watch(_) | Self::Record(_) | Self::Send(_) | Self::Param(_) | Self::Calibrate(_)
        )
    }
}

/// What to simulate.
#[derive(Clone, Debug, Args)]
pub struct Simulated {
    /// A world that comes with the program, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = "house")]
    pub world: String,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How the radio behaves, any of these with commas between: ber=1e-3 (bit errors), burst=50 (in clumps of so many
    /// bits), drop=0.01 and dup=0.01 (bytes lost, doubled), delay=0.5s, half-duplex, squelch (noise while the other
    /// side is silent; squelch=out: in outages too), modem=hc-12 or modem=xbee (buffered half-duplex modules),
    /// out=10s..12s (nothing passes)
    #[arg(long, value_name = "SPEC", default_value = "")]
    pub channel: String,
    /// What kind of radio the robot has; half, hc-12 and xbee make it take turns with the ground
    #[arg(long, value_enum, value_name = "KIND", default_value = "full")]
    pub radio: RadioKind,
    /// Multiple of real time
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub time_factor: f64,
}

/// What is known of the radio.
#[derive(Clone, Debug, Default, Args)]
pub struct RadioArgs {
    /// Baud rate of the serial device [default: 2400]
    #[arg(long)]
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
pub struct Keeping {
    /// Copy every received byte to FILE, before anything else happens to it
    #[arg(long, value_name = "FILE")]
    pub tee: Option<PathBuf>,
    /// Record to an MCAP file; without FILE under a name made from the date
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    pub record: Option<Option<PathBuf>>,
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

/// `demo`
#[derive(Debug, Args)]
#[command(after_help = "\
  groundwave demo --seed 3 --channel ber=1e-3
  groundwave demo --world living-room --record")]
pub struct Demo {
    /// What to simulate.
    #[command(flatten)]
    pub simulated: Simulated,
    /// Never ring the bell: neither for a song nor for a low battery
    #[arg(long)]
    pub no_bell: bool,
    /// Where received bytes are kept.
    #[command(flatten)]
    pub keeping: Keeping,
    /// Who else may use the link.
    #[command(flatten)]
    pub sharing: Sharing,
}

/// `watch`
#[derive(Debug, Args)]
#[command(after_help = "\
  groundwave watch /dev/ttyUSB0 --tee evening.txt --record
  groundwave watch tcp:robot.local:4000
  groundwave watch /dev/ttyUSB0 --share /tmp/x.sock     then: groundwave send --via /tmp/x.sock stop
  ssh robot cat /dev/ttyS0 | groundwave watch -")]
pub struct Watch {
    /// A serial device, tcp:HOST:PORT, unix:PATH, - (standard input) or sim
    pub link: LinkSpec,
    /// What is known of the radio.
    #[command(flatten)]
    pub radio: RadioArgs,
    /// No dashboard: events as JSON lines on standard output
    #[arg(long)]
    pub headless: bool,
    /// Never ring the bell: neither for a song nor for a low battery
    #[arg(long)]
    pub no_bell: bool,
    /// Where received bytes are kept.
    #[command(flatten)]
    pub keeping: Keeping,
    /// Who else may use the link.
    #[command(flatten)]
    pub sharing: Sharing,
}

/// `record`
#[derive(Debug, Args)]
#[command(after_help = "\
  groundwave record /dev/ttyUSB0 -o evening.mcap
  groundwave record /dev/ttyUSB0 -o evening.txt --duration 90m")]
pub struct Record {
    /// A serial device, tcp:HOST:PORT, unix:PATH, - (standard input) or sim
    pub link: LinkSpec,
    /// Where to; .mcap is recorded as MCAP, anything else as the raw bytes
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Stop after this long: 30s, 90m, 2h
    #[arg(long, value_name = "T", value_parser = parse_duration)]
    pub duration: Option<Duration>,
    /// Baud rate of the serial device [default: 2400]
    #[arg(long)]
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

/// `sim`
#[derive(Debug, Args)]
#[command(after_help = "\
  groundwave sim                            prints the path of a pseudo-terminal: cat it, tio it, watch it
  groundwave sim --listen 127.0.0.1:4000    then: groundwave watch tcp:127.0.0.1:4000")]
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

/// `replay`
#[derive(Debug, Args)]
pub struct Replay {
    /// A raw capture or an MCAP file
    pub file: PathBuf,
    /// Multiple of the speed it was recorded at
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub speed: f64,
}

/// `recover`
#[derive(Debug, Args)]
pub struct Recover {
    /// Recordings, or folders with interrupted ones
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// What was saved as a JSON line for each
    #[arg(long)]
    pub json: bool,
}

/// `songs`
#[derive(Debug, Args)]
#[command(after_help = "\
  groundwave songs evening.mcap
  groundwave songs evening.txt --wav songs      songs/song-01.wav and so on, numbered as listed

A note is named by the nearest key of a piano (A4 is 440 Hz), with its length in seconds; a dash is a rest.")]
pub struct Songs {
    /// A raw capture, an MCAP file, or - for standard input
    pub file: PathBuf,
    /// Write each song into this folder, which is made if it is not there
    #[arg(long, value_name = "DIR")]
    pub wav: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long, requires = "wav")]
    pub force: bool,
}

/// `world`
#[derive(Debug, Args)]
#[command(after_help = "\
  groundwave world                          list them
  groundwave world office                   show one
  groundwave world my-flat.toml             check and show your own
  groundwave world my-flat.toml --check     say nothing but what is wrong; exit code 1 if something is to be looked at
  groundwave world generated:7 --text       a house made from a seed, as a file to start from
  groundwave world house --svg house.svg    draw it to scale")]
pub struct World {
    /// A world that comes with the program, generated:SEED or a TOML file
    #[arg(value_name = "NAME|FILE")]
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

/// `ports`
#[derive(Debug, Args)]
pub struct Ports {
    /// As JSON, one object a port
    #[arg(long)]
    pub json: bool,
}

/// `90`, `90s`, `1.5m`, `2h` or `250ms`.
fn parse_duration(text: &str) -> Result<Duration, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit_s = match &text[digits.len()..] {
        "ms" => 0.001,
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(format!("`{text}` is no duration; try 30s, 90m or 2h")),
    };
    digits
        .parse::<f64>()
        .ok()
        .and_then(|number| Duration::try_from_secs_f64(number * unit_s).ok())
        .filter(|duration| !duration.is_zero())
        .ok_or_else(|| format!("`{text}` is no duration; try 30s, 90m or 2h"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definitions_agree_with_each_other() {
        Cli::command().debug_assert();
    }

    #[test]
    fn negative_coordinates_need_no_dashes() {
        let cli = Cli::try_parse_from([
            "groundwave",
            "send",
            "/dev/ttyUSB0",
            "goto",
            "-48",
            "-120",
            "--go",
        ]);
        let Ok(Cli {
            command: Command::Send(send),
            ..
        }) = cli
        else {
            panic!("{cli:?}");
        };
        let link = Way::Link(LinkSpec::Serial("/dev/ttyUSB0".into()));
        assert_eq!(send.way(), Ok((link, vec!["goto", "-48", "-120"])));
        assert!(send.go);
    }

    #[test]
    fn through_a_station_there_is_no_link_before_the_words() {
        let cli = Cli::try_parse_from(["groundwave", "send", "--via", "4001", "goto", "-48", "0"]);
        let Ok(Cli {
            command: Command::Send(send),
            ..
        }) = cli
        else {
            panic!("{cli:?}");
        };
        let via = Way::Via(Address::Tcp("127.0.0.1:4001".to_owned()));
        assert_eq!(send.way(), Ok((via, vec!["goto", "-48", "0"])));
    }

    #[test]
    fn durations_have_units() {
        assert_eq!(parse_duration("90"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("250ms"), Ok(Duration::from_millis(250)));
        for wrong in ["", "s", "-1s", "1d", "0s", "1e400s", "ten"] {
            assert!(parse_duration(wrong).is_err(), "{wrong}");
        }
    }
}
