//! The command line, defined for clap.

mod captures;
mod groups;
mod layout;
mod live;
mod runs;
mod send;
mod setup;
mod simulation;

pub use captures::{
    Captures, Cut, Export, ExportFormat, Info, Map, Output, Recover, Replay, Songs, Verify,
};
pub use live::{Check, LinkArgs, RadioArgs, Record, RecordingArgs, Sharing, Watch};
pub use runs::{Compare, Label, Runs};
pub use send::{Calibrate, Connection, Param, Send};
pub use setup::{Completions, ConfigArgs, ConfigVerb, Man, Ports};
pub use simulation::{Demo, Sim, Simulated, World};

use std::path::PathBuf;
use std::time::Duration;

use clap::{Parser, Subcommand};

use crate::capture::when;
use crate::request::listing;
use layout::laid_out;

/// Ground station for a small robot on a 2400-baud radio.
#[derive(Debug, Parser)]
#[command(
    name = "groundwave",
    version,
    max_term_width = 100,
    help_template = groups::template(),
    subcommand_value_name = "VERB",
    after_long_help = laid_out(&after_help())
)]
pub struct Cli {
    /// Read this configuration instead of the default one
    #[arg(long, value_name = "FILE", global = true)]
    pub config: Option<PathBuf>,
    /// The verb; without one, Groundwave suggests what to run on this machine.
    #[command(subcommand)]
    pub verb: Option<Verb>,
}

/// The verbs: the commands of the command line.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Simulate a robot in a house and show it in the dashboard.
    Demo(Demo),
    /// Show a robot in the live dashboard.
    Watch(Watch),
    /// Record the received bytes without a dashboard.
    Record(Record),
    /// Send a command and wait until the robot confirms it.
    #[command(after_help = laid_out(&send_help()))]
    Send(Send),
    /// Read, change or save the robot's parameters.
    #[command(after_help = laid_out("\
Examples:
  groundwave param /dev/ttyUSB0 list
  groundwave param /dev/ttyUSB0 get top-speed
  groundwave param /dev/ttyUSB0 set top-speed 8      until the robot's next reset
  groundwave param --via /tmp/x.sock save            keep the values after a reset
  groundwave param /dev/ttyUSB0 save-to good.toml    a file to read and edit
  groundwave param /dev/ttyUSB0 load good.toml       set the parameters that differ, after checking all of them
  groundwave param /dev/ttyUSB0 diff good.toml       exit code 1 if a parameter differs

`send LINK param ...` does the same. A value is confirmed when the robot has reported it."))]
    Param(Param),
    /// Calibrate the wheel diameters and the track by driving two squares.
    #[command(after_help = laid_out("\
The robot starts on a mark on the floor and drives a square clockwise, then one counter-clockwise. After each square,
measure where the robot stands and type two numbers in inches: its distance to the right of the mark and its distance
ahead of the mark, as seen at the start. Groundwave computes the track and the wheel diameters and sends them to the robot. Then the
robot drives both squares again to show the improvement.

Examples:
  groundwave calibrate /dev/ttyUSB0 --side 157 --save
  printf '%s\\n' '3.5 -2' '-4 1.5' '0.2 0' '-0.1 0.3' |
    groundwave calibrate /dev/ttyUSB0"))]
    Calibrate(Calibrate),
    /// Play a capture in the dashboard.
    Replay(Replay),
    /// Summarize captures.
    Info(Info),
    /// List captures with their labels and figures.
    Runs(Runs),
    /// Name a run, add notes to it, or mark it void.
    Label(Label),
    /// Compare two runs.
    Compare(Compare),
    /// Export captures as tables, pictures, recordings or raw text.
    Export(Export),
    /// Make one map of the floor from several captures.
    Map(Map),
    /// Cut a time range out of captures.
    Cut(Cut),
    /// Check captures for damage and gaps.
    Verify(Verify),
    /// Find the mistakes in the lines of your own robot.
    Check(Check),
    /// Finish interrupted recordings and repair damaged ones.
    Recover(Recover),
    /// List the songs in a capture and save them as sound.
    Songs(Songs),
    /// Serve a simulated robot on a pseudo-terminal or a TCP port.
    Sim(Sim),
    /// List, check or draw worlds.
    World(World),
    /// List the serial ports.
    Ports(Ports),
    /// Print the default configuration, its path, or check a file.
    Config(ConfigArgs),
    /// Print the completion script for a shell.
    Completions(Completions),
    /// Print the manual page, or write one for each command.
    Man(Man),
}

impl Verb {
    /// Whether the command stops the robot.
    #[must_use]
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Send(send) if send.is_stop())
    }
}

/// The commands to the robot, and examples, for the help of `send`.
fn send_help() -> String {
    let commands: Vec<String> = listing()
        .map(|(form, does)| format!("  {form:<19}{does}"))
        .collect();
    let commands = commands.join("\n");
    format!(
        "COMMAND is one of:
{commands}

Layers also have long names: infrared (ir), dead-reckoning (dr). X and Y are whole inches from
the robot's origin. A failsafe silence is 10 to 4095 s. goto and route do not change the mode. With --go, `mode prowl` follows, and the robot drives.

Examples:
  groundwave send /dev/ttyUSB0 goto -48 120 --go
  groundwave send tcp:robot.local:4000 route square.txt
  groundwave send /dev/ttyUSB0 -f run.txt         one command per line, # starts a comment; stops at a failure
  groundwave send --dry-run route square.txt
  groundwave send --via mode prowl                through a station started with --share
  groundwave send --via /tmp/x.sock mode prowl    through a station started with --share /tmp/x.sock"
    )
}

/// Examples and exit codes for the help.
fn after_help() -> String {
    let codes: Vec<String> = super::Exit::meanings()
        .map(|(code, meaning)| format!("  {code}  {meaning}"))
        .collect();
    let codes = codes.join("\n");
    format!(
        "Examples:
  groundwave demo                                    simulate a robot
  groundwave watch /dev/ttyUSB0 --tee evening.txt    watch a robot and keep its bytes
  groundwave send /dev/ttyUSB0 goto 48 0 --go        drive it to a point

Exit codes:
{codes}"
    )
}

/// Parses a duration: `90`, `90s`, `1.5m`, `2h` or `250ms`.
fn parse_duration(text: &str) -> Result<Duration, String> {
    when::span(text)
        .filter(|duration| !duration.is_zero())
        .ok_or_else(|| format!("`{text}` is not a duration; write 30s, 90m or 2h"))
}

/// Parses a baud rate: `2400`.
fn parse_baud(text: &str) -> Result<u32, String> {
    let baud = text.parse().ok().filter(|baud| *baud > 0);
    baud.ok_or_else(|| format!("`{text}` is not a baud rate; write a number such as 2400"))
}

/// Parses a speed factor: `4`, `0.5`.
fn parse_factor(text: &str) -> Result<f64, String> {
    text.parse()
        .map_err(|_| format!("`{text}` is not a number; write 10 or 0.5"))
}

/// Parses a seed: `7`.
fn parse_seed(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("`{text}` is not a seed; write a whole number such as 7"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::link::LinkSpec;
    use crate::io::share::usual_address;
    use crate::share::Address;
    use clap::CommandFactory;

    #[test]
    fn definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn help_of_every_command_has_an_example() {
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
    fn examples_fit_80_columns() {
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
    fn negative_coordinates_need_no_double_dash() {
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
            verb: Some(Verb::Send(send)),
            ..
        }) = cli
        else {
            panic!("{cli:?}");
        };
        let link = Connection::Link(LinkSpec::Serial("/dev/ttyUSB0".into()));
        assert_eq!(send.connection(), Ok((link, vec!["goto", "-48", "-120"])));
        assert!(send.go);
    }

    #[test]
    fn with_via_no_link_precedes_the_command() {
        let cli = Cli::try_parse_from(["groundwave", "send", "--via", "4001", "goto", "-48", "0"]);
        let Ok(Cli {
            verb: Some(Verb::Send(send)),
            ..
        }) = cli
        else {
            panic!("{cli:?}");
        };
        let via = Connection::Via(Address::Tcp("127.0.0.1:4001".to_owned()));
        assert_eq!(send.connection(), Ok((via, vec!["goto", "-48", "0"])));
    }

    #[test]
    fn via_finds_its_station_without_an_address() {
        let usual = usual_address().expect("a home folder");
        for (words, wanted) in [
            (&["send", "--via", "stop"][..], &["stop"][..]),
            (&["send", "stop", "--via"], &["stop"]),
            (&["send", "--via", "--json", "stop"], &["stop"]),
            (
                &["send", "--via", "goto", "-48", "0"],
                &["goto", "-48", "0"],
            ),
            (
                &["param", "--via", "get", "track"],
                &["param", "get", "track"],
            ),
            (&["param", "--via", "list"], &["param", "list"]),
        ] {
            let cli = Cli::try_parse_from(["groundwave"].iter().chain(words));
            let send = match cli.map(|cli| cli.verb) {
                Ok(Some(Verb::Send(send))) => send,
                Ok(Some(Verb::Param(param))) => param.to_send(),
                other => panic!("{words:?}: {other:?}"),
            };
            let via = Connection::Via(usual.clone());
            assert_eq!(send.connection(), Ok((via, wanted.to_vec())), "{words:?}");
        }
    }

    #[test]
    fn durations_take_units() {
        assert_eq!(parse_duration("90"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("250ms"), Ok(Duration::from_millis(250)));
        for wrong in ["", "s", "-1s", "1d", "0s", "1e400s", "ten"] {
            assert!(parse_duration(wrong).is_err(), "{wrong}");
        }
    }
}
