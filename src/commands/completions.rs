//! What a shell offers while a command line is typed: the program itself is asked, so that worlds, modes, layers, presets,
//! ports and the names of the configuration are those there are.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::CommandFactory as _;
use clap_complete::CompleteEnv;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter as _};
use clap_complete::env::Shells;
use groundwave_protocol::status_codes::{Layer, Mode};

use super::cli::{Cli, Completions};
use super::{Exit, Fault, config, show, simulated};
use crate::io::ports;
use crate::request::{Request, known_parameters, layer_word, mode_word, preset_names};

type Candidates = Vec<CompletionCandidate>;

/// What a channel can be made of.
const CHANNEL: [&str; 9] = [
    "ber=",
    "burst=",
    "drop=",
    "dup=",
    "delay=",
    "half-duplex",
    "squelch",
    "modem=",
    "out=",
];

/// Answers a shell that asks, and leaves; does nothing when none does. To be called before anything else.
pub fn answer() {
    CompleteEnv::with_factory(Cli::command)
        .bin("groundwave")
        .complete();
}

/// `completions`: the few lines with which a shell comes to ask.
pub(super) fn run(options: &Completions) -> Result<(), Fault> {
    let name = options.shell.to_string();
    let shells = Shells::builtins();
    let mut script = Vec::new();
    shells
        .completer(&name)
        .ok_or_else(|| std::io::Error::other(format!("nothing is known of {name}")))
        .and_then(|shell| {
            let bin = Cli::command().get_name().to_owned();
            shell.write_registration("COMPLETE", &bin, &bin, &bin, &mut script)
        })
        .map_err(|error| Fault::new(Exit::Failed, error))?;
    show(&script)
}

/// Worlds that come with the program, and files.
pub(super) fn worlds(current: &OsStr) -> Candidates {
    let names = simulated::world_names().chain(["generated:"]);
    let mut found = beginning_with(current, names);
    let is_world = |path: &Path| path.is_dir() || has_extension(path, &["toml"]);
    found.extend(PathCompleter::any().filter(is_world).complete(current));
    found
}

/// Robots and links of the configuration, ports and other links; where no link need stand, commands too.
pub(super) fn links(current: &OsStr) -> Candidates {
    let before = words_before();
    if before
        .iter()
        .any(|word| word == "--via" || word == "--dry-run")
    {
        let is_param = before.iter().any(|word| word == "param");
        return if is_param {
            param_words(&before, current)
        } else {
            command_words(&before, current)
        };
    }
    let config = config::load(named_config(&before).as_deref()).unwrap_or_default();
    let ports = ports::list().unwrap_or_default();
    let names = config.robots.keys().chain(config.links.keys());
    let names = names.map(String::as_str);
    let ports = ports.iter().map(|port| port.name.as_str());
    let others = ["sim", "tcp:", "unix:"];
    let mut found = beginning_with(current, names.chain(ports).chain(others));
    if current.to_string_lossy().contains('/') {
        found.extend(PathCompleter::any().complete(current));
    }
    found
}

/// The words of `send`.
pub(super) fn commands(current: &OsStr) -> Candidates {
    command_words(&words_before(), current)
}

/// The words of `param`.
pub(super) fn param(current: &OsStr) -> Candidates {
    param_words(&words_before(), current)
}

const PARAM: [&str; 4] = ["list", "get", "set", "save"];

/// What a channel is made of, after the last comma.
pub(super) fn channel(current: &OsStr) -> Candidates {
    after_comma(current, CHANNEL)
}

/// A verb, a parameter, or nothing more.
fn param_words(before: &[String], current: &OsStr) -> Candidates {
    let is_verb = |word: &str| PARAM.contains(&word);
    let is_known = |word: &str| known_parameters().any(|(name, _)| name == word);
    let takes_name = |word: &str| word == "get" || word == "set";
    let mut last = before.iter().rev().map(String::as_str);
    let (last, before_last) = (last.next(), last.next());
    let names = || {
        let current = current.to_string_lossy();
        let all = known_parameters().filter(move |(name, _)| name.starts_with(&*current));
        all.map(|(name, about)| CompletionCandidate::new(name).help(Some(about.into())))
    };
    match last {
        _ if before_last.is_some_and(takes_name) => Candidates::new(),
        Some(word) if takes_name(word) => names().collect(),
        Some(word) if is_verb(word) || is_known(word) => Candidates::new(),
        _ => {
            let mut found = beginning_with(current, PARAM);
            found.extend(names());
            found
        }
    }
}

fn command_words(before: &[String], current: &OsStr) -> Candidates {
    let mut words = before
        .iter()
        .map(String::as_str)
        .skip_while(|word| !Request::is_command(word))
        .filter(|word| !word.starts_with("--"));
    let modes = || Mode::ALL.iter().map(|mode| mode_word(*mode));
    let layers = || Layer::ALL.into_iter().map(layer_word);
    match (words.next(), words.count()) {
        (None, _) => beginning_with(current, Request::commands()),
        (Some("mode"), 0) => beginning_with(current, modes()),
        (Some("enable" | "disable"), 0) => after_comma(current, layers()),
        (Some("only"), 0) => after_comma(current, layers().chain(["none"])),
        (Some("preset"), 0) => beginning_with(current, preset_names()),
        (Some("failsafe"), 0) => beginning_with(current, modes().chain(["off"])),
        (Some("param"), _) => param_words(before, current),
        (Some("route"), 0) => PathCompleter::any().stdio().complete(current),
        _ => Candidates::new(),
    }
}

/// The words of the line that stand before the one that is typed.
fn words_before() -> Vec<String> {
    let words: Vec<String> = env::args_os()
        .skip_while(|word| word != "--")
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    // Some shells say which word it is; with the others it is the last.
    let index = env::var("_CLAP_COMPLETE_INDEX").ok();
    let index = index.and_then(|index| index.parse().ok());
    let count = index.unwrap_or(words.len().saturating_sub(1));
    words.into_iter().take(count).collect()
}

fn named_config(before: &[String]) -> Option<PathBuf> {
    let mut words = before.iter().skip_while(|word| *word != "--config");
    words.nth(1).map(PathBuf::from)
}

fn beginning_with<'a>(current: &OsStr, words: impl IntoIterator<Item = &'a str>) -> Candidates {
    let current = current.to_string_lossy();
    let words = words.into_iter().filter(|word| word.starts_with(&*current));
    words.map(CompletionCandidate::new).collect()
}

/// Another word of a list with commas.
fn after_comma<'a>(current: &OsStr, words: impl IntoIterator<Item = &'a str>) -> Candidates {
    let current = current.to_string_lossy();
    let (said, rest) = current.rsplit_once(',').unwrap_or(("", &current));
    let prefix = if current.contains(',') {
        format!("{said},")
    } else {
        String::new()
    };
    let is_said = |word: &str| said.split(',').any(|before| before == word);
    words
        .into_iter()
        .filter(|word| word.starts_with(rest) && !is_said(word))
        .map(|word| CompletionCandidate::new(format!("{prefix}{word}")))
        .collect()
}

fn has_extension(path: &Path, wanted: &[&str]) -> bool {
    let extension = path.extension().and_then(OsStr::to_str);
    extension.is_some_and(|extension| wanted.contains(&extension))
}
