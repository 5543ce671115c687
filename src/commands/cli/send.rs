//! The arguments of `send`, `param` and `calibrate`.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use clap::Args;
use clap_complete::engine::ArgValueCompleter;

use super::{RadioArgs, parse_duration};
use crate::commands::completions;
use crate::commands::sharing::parse_station;
use crate::io::link::LinkSpec;
use crate::io::ports;
use crate::request::{Request, Tuning};
use crate::share::Address;

/// Arguments of `send`.
#[derive(Debug, Args)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a flag on the command line"
)]
pub struct Send {
    /// A serial device, tcp:HOST:PORT, unix:PATH or sim; omit it with --via
    #[arg(required_unless_present_any = ["via", "dry_run"], allow_negative_numbers = true, add = ArgValueCompleter::new(completions::links))]
    link: Option<String>,
    /// The command and its arguments
    #[arg(value_name = "COMMAND", allow_negative_numbers = true, add = ArgValueCompleter::new(completions::commands))]
    words: Vec<String>,
    /// Send through a station that was started with --share [default: the station on this machine]
    #[arg(long, value_name = "ADDR|PATH", num_args = 0..=1, default_missing_value = "")]
    pub via: Option<Via>,
    /// Read commands, `wait 30s`, `wait until driven within 2m` and `expect battery > 12` from FILE (- is standard input), one per line;
    /// stop at the first failure
    #[arg(short, long, value_name = "FILE", conflicts_with = "words")]
    pub file: Option<PathBuf>,
    /// Send nothing; print the frames and the minimum time for sending them. LINK may be omitted
    #[arg(long)]
    pub dry_run: bool,
    /// Send commands that turn off a protection: bumpers, cliff guard, critical battery, failsafe
    #[arg(long)]
    pub yes: bool,
    /// After goto or route, enter mode prowl, so that the robot drives
    #[arg(long)]
    pub go: bool,
    /// Give up if the robot has not confirmed after this time [default: 20s; 5m for `param list`]
    #[arg(long, value_name = "T", value_parser = parse_duration)]
    timeout: Option<Duration>,
    /// Overwrite an existing file (`param save-to`)
    #[arg(long)]
    pub force: bool,
    /// The radio.
    #[command(flatten)]
    pub radio: RadioArgs,
    /// Print each status as a JSON line
    #[arg(long)]
    pub json: bool,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `param`.
#[derive(Debug, Args)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a flag on the command line"
)]
pub struct Param {
    /// A serial device, tcp:HOST:PORT, unix:PATH or sim; omit it with --via
    #[arg(required_unless_present = "via", add = ArgValueCompleter::new(completions::links))]
    link: Option<String>,
    /// list, get NAME, set NAME VALUE, save, save-to FILE, load FILE or diff FILE
    #[arg(value_name = "WHAT", allow_negative_numbers = true, add = ArgValueCompleter::new(completions::param))]
    words: Vec<String>,
    /// Send through a station that was started with --share [default: the station on this machine]
    #[arg(long, value_name = "ADDR|PATH", num_args = 0..=1, default_missing_value = "")]
    via: Option<Via>,
    /// Overwrite an existing file (save-to)
    #[arg(long)]
    force: bool,
    /// Set a parameter even if its value turns off a protection: cliff-guard 0, battery-critical 0
    #[arg(long)]
    yes: bool,
    /// Give up if the robot has not confirmed after this time
    #[arg(long, value_name = "T", value_parser = parse_duration, default_value = "5m")]
    timeout: Duration,
    /// The radio.
    #[command(flatten)]
    radio: RadioArgs,
    /// Print each status as a JSON line
    #[arg(long)]
    json: bool,
    /// Print only values and errors
    #[arg(short, long)]
    quiet: bool,
}

/// The value of `--via`: a station's address; or, without an address, the first word of the command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Via {
    address: Address,
    word: Option<String>,
}

impl FromStr for Via {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let is_word = Request::is_command(text) || Tuning::verbs().any(|verb| verb == text);
        Ok(Self {
            address: parse_station(if is_word { "" } else { text })?,
            word: is_word.then(|| text.to_owned()),
        })
    }
}

impl Param {
    /// The equivalent `send` command, beginning with the word `param`.
    #[must_use]
    pub fn to_send(&self) -> Send {
        let word = || "param".to_owned();
        let mut via = self.via.clone();
        let (link, words): (Option<String>, Vec<String>) = match &mut via {
            Some(via) => {
                let first = via.word.take();
                let words = first.iter().chain(&self.link).chain(&self.words);
                (Some(word()), words.cloned().collect())
            }
            None => (
                self.link.clone(),
                std::iter::once(word())
                    .chain(self.words.iter().cloned())
                    .collect(),
            ),
        };
        Send {
            link,
            words,
            via,
            file: None,
            dry_run: false,
            yes: self.yes,
            go: false,
            timeout: Some(self.timeout),
            force: self.force,
            radio: self.radio.clone(),
            json: self.json,
            quiet: self.quiet,
        }
    }
}

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub struct Calibrate {
    /// A serial device, tcp:HOST:PORT, unix:PATH or sim; omit it with --via
    #[arg(required_unless_present = "via", conflicts_with = "via", add = ArgValueCompleter::new(completions::links))]
    link: Option<LinkSpec>,
    /// Send through a station that was started with --share [default: the station on this machine]
    #[arg(long, value_name = "ADDR|PATH", num_args = 0..=1, default_missing_value = "", value_parser = parse_station)]
    via: Option<Address>,
    /// Side of the square in inches; keep another foot of floor free around it
    #[arg(long, value_name = "IN", default_value_t = 157, value_parser = clap::value_parser!(i16).range(40..=400))]
    pub side: i16,
    /// Save the result in the robot permanently
    #[arg(long)]
    pub save: bool,
    /// Do not drive the squares a second time
    #[arg(long)]
    pub once: bool,
    /// Give up if the robot has not confirmed a command after this time
    #[arg(long, value_name = "T", value_parser = parse_duration, default_value = "20s")]
    pub timeout: Duration,
    /// The radio.
    #[command(flatten)]
    pub radio: RadioArgs,
}

impl Calibrate {
    /// The connection to the radio.
    ///
    /// # Errors
    /// If neither a link nor `--via` is given.
    pub fn connection(&self) -> Result<Connection, String> {
        Connection::new(self.via.as_ref(), self.link.as_ref())
    }
}

/// The connection to the radio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Connection {
    /// A link that this process opens.
    Link(LinkSpec),
    /// A station that shares its link at this address.
    Via(Address),
}

impl Connection {
    /// The connection given by the options.
    ///
    /// # Errors
    /// If neither a link nor `--via` is given.
    pub fn new(via: Option<&Address>, link: Option<&LinkSpec>) -> Result<Self, String> {
        match (via, link) {
            (Some(address), _) => Ok(Self::Via(address.clone())),
            (None, Some(link)) => Ok(Self::Link(link.clone())),
            (None, None) => Err("no link given".to_owned()),
        }
    }

    /// The link, or a link to the station.
    #[must_use]
    pub fn link(&self) -> LinkSpec {
        match self {
            Self::Link(link) => link.clone(),
            Self::Via(address) => address.clone().into(),
        }
    }
}

impl Send {
    /// Time to wait for the robot's confirmation of a command.
    #[must_use]
    pub fn timeout_of(&self, request: &Request) -> Duration {
        self.timeout.unwrap_or_else(|| request.default_timeout())
    }

    /// Time to wait for the confirmation of a short command, for a station, or for a condition.
    #[must_use]
    pub fn usual_timeout(&self) -> Duration {
        self.timeout_of(&Request::Stop)
    }

    /// Whether the command is `stop`.
    #[must_use]
    pub fn is_stop(&self) -> bool {
        self.connection().is_ok_and(|(_, words)| words == ["stop"])
    }

    /// The connection to the radio, and the words of the command. With `--via`, all words belong to the command.
    ///
    /// # Errors
    /// If the link is not valid.
    pub fn connection(&self) -> Result<(Connection, Vec<&str>), String> {
        let first = self.link.as_deref();
        let words = self.words.iter().map(String::as_str);
        if let Some(via) = &self.via {
            let word = via.word.as_deref();
            Ok((
                Connection::Via(via.address.clone()),
                word.into_iter().chain(first).chain(words).collect(),
            ))
        } else {
            let words: Vec<&str> = words.collect();
            Ok((
                Connection::Link(read_link(first.unwrap_or_default(), &words)?),
                words,
            ))
        }
    }
}

/// Parses a link. A command word instead of a link probably means that the link was forgotten.
fn read_link(first: &str, words: &[&str]) -> Result<LinkSpec, String> {
    let is_forgotten = match words.first() {
        Some(&"param") => Tuning::verbs().any(|verb| verb == first),
        _ => Request::is_command(first),
    };
    if is_forgotten && !Path::new(first).exists() {
        return Err(format!(
            "`{first}` is in the place of LINK; give the link first, such as {} or tcp:HOST:PORT \
             (`groundwave ports` lists the ports), or use --via ADDR",
            ports::EXAMPLE
        ));
    }
    first.parse()
}

impl Send {
    /// The words of the command for `--dry-run`. A link before the words is checked but not opened.
    ///
    /// # Errors
    /// If the link is not valid.
    pub fn words_to_plan(&self) -> Result<Vec<&str>, String> {
        let first = self.link.as_deref();
        let is_link = self.via.is_none() && !first.is_some_and(Request::is_command);
        let words = self.words.iter().map(String::as_str);
        if is_link {
            first.map(str::parse::<LinkSpec>).transpose()?;
            return Ok(words.collect());
        }
        let word = self.via.as_ref().and_then(|via| via.word.as_deref());
        Ok(word.into_iter().chain(first).chain(words).collect())
    }
}
