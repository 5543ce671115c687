//! The command line, as clap sees it.

mod captures;
mod layout;
mod live;
mod runs;
mod send;
mod setup;
mod simulation;

pub use captures::{
    Captures, Convert, Cut, Decode, DecodeFormat, Export, ExportFormat, Info, Output, Recover,
    Replay, Songs, Verify,
};
pub use live::{RadioArgs, Record, RecordingArgs, Sharing, Watch};
pub use runs::{Compare, Label, Runs};
pub use send::{Calibrate, Param, Send, Way};
pub use setup::{Completions, ConfigArgs, ConfigVerb, Man, Ports};
pub use simulation::{Demo, Sim, Simulated, World};

use std::path::PathBuf;
use std::time::Duration;

use clap::{Parser, Subcommand};

use crate::capture::when;
use layout::laid_out;

/// Ground station for a small robot on a 2400-baud radio.
#[derive(Debug, Parser)]
#[command(
    name = "groundwave",
    version,
    about,
    max_term_width = 100,
    after_help = laid_out(&after_help())
)]
pub struct Cli {
    /// Read this configuration instead of the usual one
    #[arg(long, value_name = "FILE", global = true)]
    pub config: Option<PathBuf>,
    /// What to do; nothing shows what can be done next.
    #[command(subcommand)]
    pub command: Option<Command>,
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
    #[command(after_help = laid_out("\
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

Examples:
  groundwave send /dev/ttyUSB0 goto -48 120 --go
  groundwave send tcp:robot.local:4000 route square.txt
  groundwave send /dev/ttyUSB0 -f run.txt         one command a line, # comments; stops at the first that fails
  groundwave send --dry-run route square.txt
  groundwave send --via /tmp/x.sock mode prowl    through a station started with --share /tmp/x.sock"))]
    Send(Send),
    /// Read, change or keep the robot's parameters.
    #[command(after_help = laid_out("\
Examples:
  groundwave param /dev/ttyUSB0 list
  groundwave param /dev/ttyUSB0 get top-speed
  groundwave param /dev/ttyUSB0 set top-speed 8      until the robot's next reset, unless saved
  groundwave param --via /tmp/x.sock save            over a reset; the same words go after `send`, as `param ...`

A value is proven when the robot acknowledged the order and then said the value itself."))]
    Param(Param),
    /// Drive two squares, and correct what the robot takes its wheels and track for.
    #[command(after_help = laid_out("\
The robot drives a square clockwise and one counter-clockwise, from a mark on the floor until it believes to be back on
it. After each you measure where it really is, seen as it stood at the start, and type two numbers of inches: to the
right of the mark and ahead of it. From these follow the track and the wheels' diameters, which are sent to the robot;
then it drives both again, and you see what it was good for.

Examples:
  groundwave calibrate /dev/ttyUSB0 --side 157 --save
  printf '%s\\n' '3.5 -2' '-4 1.5' '0.2 0' '-0.1 0.3' |
    groundwave calibrate /dev/ttyUSB0"))]
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
    #[command(after_help = laid_out("\
A recording that was interrupted is FILE.partial with its journal, FILE.journal, beside it: name any of them, or the
folder. What holds is kept, what came in last is taken from the journal, and you are told what was saved and what was
not. It can be interrupted and repeated. A damaged file stays as FILE.damaged.

  groundwave recover evening.mcap
  groundwave recover --json ~/captures"))]
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
    /// Print the configuration as it comes, say where it is read from, or check one.
    Config(ConfigArgs),
    /// Print what a shell needs to complete this command line.
    Completions(Completions),
    /// Print the manual page, or write one for each verb into a folder.
    Man(Man),
}

impl Command {
    /// Whether it opens a link or a dashboard, of which the configuration says something.
    #[must_use]
    pub const fn uses_config(&self) -> bool {
        matches!(
            self,
            Self::Demo(_)
                | Self::Watch(_)
                | Self::Record(_)
                | Self::Send(_)
                | Self::Param(_)
                | Self::Calibrate(_)
                | Self::Replay(_)
        )
    }

    /// Whether it is to stop the robot.
    #[must_use]
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Send(send) if send.is_stop())
    }
}

/// Where to begin, and how it ends.
fn after_help() -> String {
    let codes: Vec<String> = super::Exit::meanings()
        .map(|(code, meaning)| format!("  {code}  {meaning}"))
        .collect();
    let codes = codes.join("\n");
    format!(
        "Examples:
  groundwave demo                                    without a robot
  groundwave watch /dev/ttyUSB0 --tee evening.txt    a robot on a radio
  groundwave send /dev/ttyUSB0 goto 48 0             send it somewhere

Exit codes:
{codes}"
    )
}

/// `90`, `90s`, `1.5m`, `2h` or `250ms`.
fn parse_duration(text: &str) -> Result<Duration, String> {
    when::span(text)
        .filter(|duration| !duration.is_zero())
        .ok_or_else(|| format!("`{text}` is no duration; try 30s, 90m or 2h"))
}

/// `2400`
fn parse_baud(text: &str) -> Result<u32, String> {
    let baud = text.parse().ok().filter(|baud| *baud > 0);
    baud.ok_or_else(|| format!("`{text}` is no baud rate; try 2400, as the SR04's radio has"))
}

/// `4`, `0.5`
fn parse_factor(text: &str) -> Result<f64, String> {
    text.parse()
        .map_err(|_| format!("`{text}` is no number; try 10 or 0.5"))
}

/// `7`
fn parse_seed(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("`{text}` is no seed; try a whole number such as 7"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::link::LinkSpec;
    use crate::share::Address;
    use clap::CommandFactory;

    #[test]
    fn the_definitions_agree_with_each_other() {
        Cli::command().debug_assert();
    }

    /// Whoever asks for help sees a line to begin with.
    #[test]
    fn every_verb_shows_an_example_of_itself() {
        for verb in Cli::command().get_subcommands() {
            let help = verb
                .get_after_help()
                .map(ToString::to_string)
                .unwrap_or_default();
            let example = format!("  groundwave {}", verb.get_name());
            assert!(help.contains(&example), "{}", verb.get_name());
        }
    }

    #[test]
    fn what_stands_below_the_options_fits_a_narrow_terminal() {
        let mut all = vec![Cli::command()];
        while let Some(command) = all.pop() {
            let help = command.get_after_help().map(ToString::to_string);
            for pair in help
                .unwrap_or_default()
                .lines()
                .collect::<Vec<_>>()
                .windows(2)
            {
                let [row, next] = [pair[0], pair[1]];
                assert!(!row.starts_with(' ') || row.len() < 80, "{row}");
                let is_broken = [row, next]
                    .iter()
                    .all(|row| row.starts_with(char::is_alphabetic));
                assert!(!is_broken, "{row}\n{next}");
            }
            all.extend(command.get_subcommands().cloned());
        }
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
            command: Some(Command::Send(send)),
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
            command: Some(Command::Send(send)),
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
