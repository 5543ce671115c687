//! The verbs of the program, one file each, and shared helpers. `watch` contains `demo`, and `send` contains `param`.

// The verbs.
mod calibrate;
mod check;
mod compare;
mod completions;
mod config_command;
mod cut;
mod export;
mod info;
mod label;
mod man;
mod map;
mod ports;
mod record;
mod recover;
mod replay;
mod runs;
mod send;
mod sim;
mod songs;
mod verify;
mod watch;
mod world;

// Helpers shared by the verbs.
mod appearance;
mod batch;
pub mod cli;
pub mod config;
mod connecting;
mod fault;
mod headless;
mod input;
mod output;
mod progress;
mod recording;
mod sharing;
pub mod simulated;
mod terminal;
mod tour;
mod welcome;

use std::env;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, StdoutLock, Write};
use std::panic;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory as _, Parser as _};
use cli::{Cli, Verb};
pub use completions::answer as answer_shell;
pub use fault::{Exit, Fault};

use crate::hint;
use crate::io::open_files;
use crate::io::signals::survive_file_limit;
use crate::safe_text::{self, SafeWriter};

/// Parses the command line.
///
/// # Errors
/// clap's error, help or version.
pub fn parse() -> Result<Cli, clap::Error> {
    Cli::try_parse().map_err(|error| {
        // The same error, with arguments that are safe to show.
        let safe = |argument: OsString| safe_text::line(&argument.to_string_lossy()).into_owned();
        let again = Cli::try_parse_from(env::args_os().map(safe));
        again.err().unwrap_or(error)
    })
}

/// Runs the command line; returns the exit code.
#[must_use]
pub fn run(cli: &Cli) -> ExitCode {
    watch_for_panics();
    survive_file_limit();
    match check_open_files(open_files::ANY_COMMAND).and_then(|()| dispatch(cli)) {
        // The hook has reported the panic.
        Ok(()) if HAS_PANICKED.load(Ordering::Relaxed) => ExitCode::from(Exit::Failed as u8),
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            say_fault(&fault);
            ExitCode::from(fault.exit as u8)
        }
    }
}

/// Fails if the program may not have `count` more files open.
fn check_open_files(count: usize) -> Result<(), Fault> {
    open_files::ensure(count).map_err(|error| {
        let message = format!("cannot start: {}", hint::words(&error));
        Fault::new(Exit::Failed, message)
    })
}

/// Whether any thread has panicked.
static HAS_PANICKED: AtomicBool = AtomicBool::new(false);

/// Records a panic in any thread, so that the program does not report success.
fn watch_for_panics() {
    let report = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        HAS_PANICKED.store(true, Ordering::Relaxed);
        report(info);
    }));
}

/// Prints clap's error, help or version; returns the exit code.
#[must_use]
pub fn refuse(error: &clap::Error) -> ExitCode {
    let text = error.render().to_string();
    // A closed or full stream does not change the exit code.
    let _ = error.print();
    if error.kind() == ErrorKind::MissingRequiredArgument && text.contains("<LINK>") {
        say("");
        say(
            "  tip: LINK is a serial device (`groundwave ports` lists them), tcp:HOST:PORT, a name from the configuration, \
             or sim for a simulated robot",
        );
    }
    if let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg)
        && error.kind() == ErrorKind::UnknownArgument
    {
        say_verbs_with(option);
    }
    u8::try_from(error.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from)
}

/// Names the verbs that have an option, for a verb that has not.
fn say_verbs_with(option: &str) {
    let name = option.trim_start_matches("--");
    let cli = Cli::command();
    let verbs = cli.get_subcommands().filter(|verb| {
        let mut options = verb.get_arguments();
        !verb.is_hide_set() && options.any(|it| it.get_long() == Some(name))
    });
    let verbs: Vec<_> = verbs.map(|verb| format!("`{}`", verb.get_name())).collect();
    if !verbs.is_empty() {
        say("");
        say(format_args!(
            "  tip: {option} is an option of {}",
            verbs.join(", ")
        ));
    }
}

fn dispatch(cli: &Cli) -> Result<(), Fault> {
    let Some(verb) = &cli.verb else {
        return welcome::run(cli.config.as_deref());
    };
    let load = || {
        let (config, fault) = config::load_lenient(cli.config.as_deref());
        match fault {
            // A mistake in the configuration must not prevent STOP.
            Some(fault) if verb.is_stop() => {
                say_fault(&fault);
                say("Trying to stop anyway, with the rest of the configuration.");
            }
            Some(fault) => return Err(fault),
            None => {}
        }
        Ok(config)
    };
    // A file named with --config is read and checked by every command; `config` does so itself.
    let is_named = cli.config.is_some() && !matches!(verb, Verb::Config(_));
    let named = is_named.then(load).transpose()?;
    let config = || named.map_or_else(load, Ok);
    match verb {
        Verb::Demo(demo) => watch::demo(demo, &config()?),
        Verb::Watch(watch) => watch::watch(watch, &config()?),
        Verb::Record(record) => record::run(record, &config()?),
        Verb::Send(send) => send::run(send, &config()?),
        Verb::Param(param) => send::run(&param.to_send(), &config()?),
        Verb::Calibrate(calibrate) => calibrate::run(calibrate, &config()?),
        Verb::Sim(sim) => sim::run(sim),
        Verb::Replay(replay) => replay::run(replay, &config()?),
        Verb::Info(info) => info::run(info),
        Verb::Recover(recover) => recover::run(recover),
        Verb::Export(export) => export::run(export),
        Verb::Map(map) => map::run(map),
        Verb::Cut(cut) => cut::run(cut),
        Verb::Check(check) => check::run(check, &config()?),
        Verb::Verify(verify) => verify::run(verify),
        Verb::Songs(songs) => songs::run(songs),
        Verb::Runs(runs) => runs::run(runs),
        Verb::Label(label) => label::run(label),
        Verb::Compare(compare) => compare::run(compare),
        Verb::Ports(ports) => ports::run(ports),
        Verb::World(world) => world::run(world),
        Verb::Config(what) => config_command::run(what, cli.config.as_deref()),
        Verb::Completions(completions) => completions::run(completions),
        Verb::Man(man) => man::run(man),
    }
}

/// Standard output for text and JSON; the bytes of captures and tables go through [`output::Output`].
fn out() -> SafeWriter<StdoutLock<'static>> {
    SafeWriter(io::stdout().lock())
}

/// Writes whole lines of our own text to standard output.
fn show(text: impl AsRef<[u8]>) -> Result<(), Fault> {
    let mut out = out();
    out.write_all(text.as_ref())
        .and_then(|()| out.flush())
        .or_else(|error| Fault::output(&error))
}

/// Writes one line of results to standard output.
fn show_line(line: impl Display) -> Result<(), Fault> {
    let mut out = out();
    writeln!(out, "{line}")
        .and_then(|()| out.flush())
        .or_else(|error| Fault::output(&error))
}

/// Writes a one-line message to standard error. Write errors are ignored.
fn say(line: impl Display) {
    let _ = writeln!(SafeWriter(io::stderr()), "{line}");
}

/// Writes the message of a fault to standard error.
fn say_fault(fault: &Fault) {
    let message = format!("groundwave: {fault}");
    message.lines().for_each(say);
}

/// Writes a progress message over the last one.
fn say_progress(line: impl Display) {
    let line = line.to_string();
    let _ = write!(io::stderr(), "\r{} ", safe_text::line(&line));
}

/// Erases the progress message.
fn erase_progress() {
    let _ = write!(io::stderr(), "\r\x1b[2K");
}

/// Runs a future on a single-threaded runtime.
fn block_on<T>(future: impl Future<Output = Result<T, Fault>>) -> Result<T, Fault> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| Fault::new(Exit::Failed, format!("cannot start: {error}")))?;
    let result = runtime.block_on(future);
    // A blocking task may still wait for a station; do not wait for it.
    runtime.shutdown_background();
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_in_a_thread_is_noticed() {
        watch_for_panics();
        let thread = std::thread::spawn(|| panic!("on purpose"));
        assert!(thread.join().is_err());
        assert!(HAS_PANICKED.load(Ordering::Relaxed));
    }
}
