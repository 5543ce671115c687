//! Shell completion. The shell asks the program, so that worlds, ports and the names in the configuration are up to date.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::CommandFactory as _;
use clap_complete::CompleteEnv;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter as _};
use clap_complete::env::Shells;

use super::cli::{Cli, Completions};
use super::{Exit, Fault, config, show, simulated};
use crate::io::ports;
use crate::request::completion::{self, Candidate, Completion};
use crate::request::{Request, Tuning, known_parameters};

type Candidates = Vec<CompletionCandidate>;

/// Parts of a channel specification.
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

/// Answers a completion request from a shell and exits; returns if there is none. Must be called first.
pub fn answer() {
    CompleteEnv::with_factory(Cli::command)
        .bin("groundwave")
        .complete();
}

/// Prints the script that connects a shell to the program.
pub(super) fn run(options: &Completions) -> Result<(), Fault> {
    let name = options.shell.to_string();
    let shells = Shells::builtins();
    let mut script = Vec::new();
    shells
        .completer(&name)
        .ok_or_else(|| std::io::Error::other(format!("no completions for the shell {name}")))
        .and_then(|shell| {
            let bin = Cli::command().get_name().to_owned();
            shell.write_registration("COMPLETE", &bin, &bin, &bin, &mut script)
        })
        .map_err(|error| Fault::new(Exit::Failed, error))?;
    show(&script)
}

/// Completes captures, as `runs` lists them, and folders.
pub(super) fn captures(current: &OsStr) -> Candidates {
    let is_capture = |path: &Path| has_extension(path, completion::CAPTURES);
    files(is_capture, current)
}

/// Completes captures and links.
pub(super) fn checked(current: &OsStr) -> Candidates {
    let mut found = captures(current);
    found.extend(links(current));
    found
}

/// Completes built-in worlds and TOML files, except labels of runs.
pub(super) fn worlds(current: &OsStr) -> Candidates {
    let names = simulated::world_names().chain(["generated:"]);
    let mut found = starting_with(current, names);
    let is_world = |path: &Path| {
        has_extension(path, &["toml"]) && !path.to_string_lossy().ends_with(".run.toml")
    };
    found.extend(files(is_world, current));
    found
}

/// Completes files that are wanted, then the folders that may hold them. The current folder is not offered.
fn files(is_wanted: fn(&Path) -> bool, current: &OsStr) -> Candidates {
    let is_file = move |path: &Path| !path.is_dir() && is_wanted(path);
    PathCompleter::any().filter(is_file).complete(current)
}

/// Completes robots and links of the configuration, ports and other links; also command words if LINK may be omitted.
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
    let mut found = starting_with(current, names.chain(ports).chain(others));
    if current.to_string_lossy().contains('/') {
        found.extend(PathCompleter::any().complete(current));
    }
    found
}

/// Completes the words of `send`.
pub(super) fn commands(current: &OsStr) -> Candidates {
    command_words(&words_before(), current)
}

/// Completes the words of `param`.
pub(super) fn param(current: &OsStr) -> Candidates {
    param_words(&words_before(), current)
}

/// Completes the part of a channel specification after the last comma.
pub(super) fn channel(current: &OsStr) -> Candidates {
    candidates(
        completion::after_comma(&current.to_string_lossy(), CHANNEL),
        current,
    )
}

fn param_words(before: &[String], current: &OsStr) -> Candidates {
    let words = before.iter().map(String::as_str);
    let is_first = |word: &&str| {
        Tuning::verbs()
            .chain(known_names())
            .any(|known| known == *word)
    };
    let words: Vec<&str> = words
        .skip_while(|word| !is_first(word))
        .filter(is_word)
        .collect();
    candidates(
        completion::of_param(&words, &current.to_string_lossy()),
        current,
    )
}

fn known_names() -> impl Iterator<Item = &'static str> {
    known_parameters().map(|(name, _)| name)
}

fn is_word(word: &&str) -> bool {
    !word.starts_with("--")
}

fn candidates(completion: Completion, current: &OsStr) -> Candidates {
    let Completion::Words(words) = completion else {
        return PathCompleter::any().stdio().complete(current);
    };
    let candidate = |word: Candidate| {
        let about = Some(word.about).filter(|about| !about.is_empty());
        CompletionCandidate::new(word.text).help(about.map(Into::into))
    };
    words.into_iter().map(candidate).collect()
}

/// Names of the command strings of the robot named earlier on the command line, or of all robots after `--via`.
fn own_commands(before: &[String]) -> Vec<String> {
    let config = config::load(named_config(before).as_deref()).unwrap_or_default();
    if before.iter().any(|word| word == "--via") {
        return config.all_own_commands();
    }
    let mut named = before.iter().rev();
    let robot = named.find_map(|word| config.robots.get(word));
    robot.map_or(Vec::new(), |robot| robot.commands.keys().cloned().collect())
}

fn command_words(before: &[String], current: &OsStr) -> Candidates {
    let own = own_commands(before);
    let is_own = |word: &str| own.iter().any(|name| name == word);
    let words = before.iter().map(String::as_str);
    let words = words.skip_while(|word| !Request::is_command(word) && !is_own(word));
    let words: Vec<&str> = words.filter(is_word).collect();
    candidates(
        completion::of_command(&words, &current.to_string_lossy(), &own),
        current,
    )
}

/// The words before the word being typed.
fn words_before() -> Vec<String> {
    let words: Vec<String> = env::args_os()
        .skip_while(|word| word != "--")
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    // Some shells pass its index; otherwise it is the last word.
    let index = env::var("_CLAP_COMPLETE_INDEX").ok();
    let index = index.and_then(|index| index.parse().ok());
    let count = index.unwrap_or(words.len().saturating_sub(1));
    words.into_iter().take(count).collect()
}

fn named_config(before: &[String]) -> Option<PathBuf> {
    let mut words = before.iter().skip_while(|word| *word != "--config");
    words.nth(1).map(PathBuf::from)
}

fn starting_with<'a>(current: &OsStr, words: impl IntoIterator<Item = &'a str>) -> Candidates {
    let current = current.to_string_lossy();
    let words = words.into_iter().filter(|word| word.starts_with(&*current));
    words.map(CompletionCandidate::new).collect()
}

fn has_extension(path: &Path, wanted: &[&str]) -> bool {
    let extension = path.extension().and_then(OsStr::to_str);
    extension.is_some_and(|extension| wanted.contains(&extension))
}
