//! The arguments of the verbs that send: `send`, `param` and `calibrate`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use clap_complete::engine::ArgValueCompleter;

use super::{RadioArgs, parse_duration};
use crate::commands::completions;
use crate::io::link::LinkSpec;
use crate::request::Request;
use crate::share::Address;

/// `send`
#[derive(Debug, Args)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a flag on the command line"
)]
pub struct Send {
    /// A serial device, tcp:HOST:PORT or sim; none with --via
    #[arg(required_unless_present_any = ["via", "dry_run"], add = ArgValueCompleter::new(completions::links))]
    link: Option<String>,
    /// The command and its arguments
    #[arg(value_name = "COMMAND", allow_negative_numbers = true, add = ArgValueCompleter::new(completions::commands))]
    words: Vec<String>,
    /// Send through the station that owns the radio and shares it with --share
    #[arg(long, value_name = "ADDR|PATH")]
    pub via: Option<Address>,
    /// Read commands from FILE (- is standard input), one a line; stop at the first that fails
    #[arg(short, long, value_name = "FILE", conflicts_with = "words")]
    pub file: Option<PathBuf>,
    /// Send nothing and open no link: say which bytes would go out, and how long they take at least.
    /// LINK may be left out
    #[arg(long)]
    pub dry_run: bool,
    /// After goto or route, enter mode prowl so that the robot drives there
    #[arg(long)]
    pub go: bool,
    /// Give up after this long without proof
    #[arg(long, value_name = "T", value_parser = parse_duration, default_value = "20s")]
    pub timeout: Duration,
    /// What is known of the radio.
    #[command(flatten)]
    pub radio: RadioArgs,
    /// Each stage as a JSON line on standard output
    #[arg(long)]
    pub json: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// `param`
#[derive(Debug, Args)]
pub struct Param {
    /// A serial device, tcp:HOST:PORT or sim; none with --via
    #[arg(required_unless_present = "via", add = ArgValueCompleter::new(completions::links))]
    link: Option<String>,
    /// list, get NAME, set NAME VALUE or save
    #[arg(value_name = "WHAT", allow_negative_numbers = true, add = ArgValueCompleter::new(completions::param))]
    words: Vec<String>,
    /// Send through the station that owns the radio and shares it with --share
    #[arg(long, value_name = "ADDR|PATH")]
    via: Option<Address>,
    /// Give up after this long without proof
    #[arg(long, value_name = "T", value_parser = parse_duration, default_value = "2m")]
    timeout: Duration,
    /// What is known of the radio.
    #[command(flatten)]
    radio: RadioArgs,
    /// Each stage as a JSON line on standard output
    #[arg(long)]
    json: bool,
    /// Say nothing but values and errors
    #[arg(short, long)]
    quiet: bool,
}

impl Param {
    /// The same as `send`, whose words begin with `param`.
    #[must_use]
    pub fn to_send(&self) -> Send {
        let word = || "param".to_owned();
        let (link, words): (Option<String>, Vec<String>) = match &self.via {
            Some(_) => (
                Some(word()),
                self.link.iter().chain(&self.words).cloned().collect(),
            ),
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
            via: self.via.clone(),
            file: None,
            dry_run: false,
            go: false,
            timeout: self.timeout,
            radio: self.radio.clone(),
            json: self.json,
            quiet: self.quiet,
        }
    }
}

/// `calibrate`
#[derive(Debug, Args)]
pub struct Calibrate {
    /// A serial device, tcp:HOST:PORT or sim; none with --via
    #[arg(required_unless_present = "via", conflicts_with = "via", add = ArgValueCompleter::new(completions::links))]
    link: Option<LinkSpec>,
    /// Send through the station that owns the radio and shares it with --share
    #[arg(long, value_name = "ADDR|PATH")]
    via: Option<Address>,
    /// Side of the square in inches; the floor has to be free for a foot more on every side
    #[arg(long, value_name = "IN", default_value_t = 157, value_parser = clap::value_parser!(i16).range(40..=400))]
    pub side: i16,
    /// Let the robot keep the result over a reset
    #[arg(long)]
    pub save: bool,
    /// Do not drive the squares a second time
    #[arg(long)]
    pub once: bool,
    /// Give up after this long without proof of an order
    #[arg(long, value_name = "T", value_parser = parse_duration, default_value = "20s")]
    pub timeout: Duration,
    /// What is known of the radio.
    #[command(flatten)]
    pub radio: RadioArgs,
}

impl Calibrate {
    /// Which way.
    ///
    /// # Errors
    /// When there is none.
    pub fn way(&self) -> Result<Way, String> {
        match (&self.via, &self.link) {
            (Some(address), _) => Ok(Way::Via(address.clone())),
            (None, Some(link)) => Ok(Way::Link(link.clone())),
            (None, None) => Err("no link given".to_owned()),
        }
    }
}

/// How a command gets to the radio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Way {
    /// Over a link of our own.
    Link(LinkSpec),
    /// Through the station that shares its link here.
    Via(Address),
}

impl Send {
    /// Whether it is to stop the robot, and nothing else.
    #[must_use]
    pub fn is_stop(&self) -> bool {
        self.way().is_ok_and(|(_, words)| words == ["stop"])
    }

    /// Which way, and the words of the command: with `--via` no link stands before them.
    ///
    /// # Errors
    /// When the link is none.
    pub fn way(&self) -> Result<(Way, Vec<&str>), String> {
        let first = self.link.as_deref();
        let words = self.words.iter().map(String::as_str);
        if let Some(address) = &self.via {
            Ok((
                Way::Via(address.clone()),
                first.into_iter().chain(words).collect(),
            ))
        } else {
            let words: Vec<&str> = words.collect();
            Ok((
                Way::Link(read_link(first.unwrap_or_default(), &words)?),
                words,
            ))
        }
    }
}

/// Reads a link. A command's own word in its place is more likely a link forgotten than a file of that name.
fn read_link(first: &str, words: &[&str]) -> Result<LinkSpec, String> {
    let is_forgotten = match words.first() {
        Some(&"param") => matches!(first, "list" | "get" | "set" | "save"),
        _ => Request::is_command(first),
    };
    if is_forgotten && !Path::new(first).exists() {
        return Err(format!(
            "`{first}` stands where the link belongs: LINK comes first, as in /dev/ttyUSB0 or tcp:HOST:PORT; \
             `groundwave ports` lists what is plugged in, and --via ADDR needs none"
        ));
    }
    first.parse()
}

impl Send {
    /// The words of the command for `--dry-run`, before which a link may stand: it is checked and not
    /// opened. A link that is called like a command is taken for one.
    ///
    /// # Errors
    /// When the link is none.
    pub fn words_to_plan(&self) -> Result<Vec<&str>, String> {
        let first = self.link.as_deref();
        let is_link = self.via.is_none() && !first.is_some_and(Request::is_command);
        let words = self.words.iter().map(String::as_str);
        if is_link {
            first.map(str::parse::<LinkSpec>).transpose()?;
            return Ok(words.collect());
        }
        Ok(first.into_iter().chain(words).collect())
    }
}
