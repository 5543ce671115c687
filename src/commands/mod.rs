//! What the program can be told to do, one file a verb.

mod appearance;
mod batch;
mod calibrate;
pub mod cli;
mod compare;
mod completions;
pub mod config;
mod config_command;
mod convert;
mod cut;
mod decode;
mod export;
mod fault;
mod headless;
mod info;
mod input;
mod label;
mod man;
mod output;
mod ports;
mod progress;
mod record;
mod recording;
mod recover;
mod replay;
mod runs;
mod send;
mod sharing;
mod sim;
pub mod simulated;
mod songs;
mod verify;
mod watch;
mod welcome;
mod world;

use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

use cli::{Cli, Command};
pub use completions::answer as answer_shell;
use config::Config;
pub use fault::{Exit, Fault};

/// Does what the command line says.
#[must_use]
pub fn run(cli: &Cli) -> ExitCode {
    match dispatch(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            say(format_args!("groundwave: {fault}"));
            ExitCode::from(fault.exit as u8)
        }
    }
}

/// Says what is wrong with the command line, or what was asked of it: help and version come this way too.
#[must_use]
pub fn refuse(error: &clap::Error) -> ExitCode {
    let text = error.render().to_string();
    // A stream that is closed or full changes nothing.
    let _ = error.print();
    if error.kind() == clap::error::ErrorKind::MissingRequiredArgument && text.contains("<LINK>") {
        say(
            "\n  tip: LINK is a serial device (`groundwave ports` lists them), tcp:HOST:PORT, a name of the configuration, or \
             sim for a simulated robot",
        );
    }
    u8::try_from(error.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from)
}

fn dispatch(cli: &Cli) -> Result<(), Fault> {
    let Some(command) = &cli.command else {
        return welcome::run(cli.config.as_deref());
    };
    // One that is named is read in any case: a mistake in it is told. The verb that is about it does so itself.
    let is_about_it = matches!(command, Command::Config(_));
    let is_named = cli.config.is_some() && !is_about_it;
    let (config, fault) = if is_named || command.uses_config() {
        config::load_lenient(cli.config.as_deref())
    } else {
        (Config::default(), None)
    };
    match fault {
        // A slip in the theme's name shall not keep a robot going.
        Some(fault) if command.is_stop() => say(format_args!(
            "groundwave: {fault}\nThe stop is tried all the same, with what could be read."
        )),
        Some(fault) => return Err(fault),
        None => {}
    }
    match command {
        Command::Demo(demo) => watch::demo(demo, &config),
        Command::Watch(watch) => watch::watch(watch, &config),
        Command::Record(record) => record::run(record, &config),
        Command::Send(send) => send::run(send, &config),
        Command::Param(param) => send::run(&param.to_send(), &config),
        Command::Calibrate(calibrate) => calibrate::run(calibrate, &config),
        Command::Sim(sim) => sim::run(sim),
        Command::Replay(replay) => replay::run(replay, &config),
        Command::Decode(decode) => decode::run(decode),
        Command::Info(info) => info::run(info),
        Command::Recover(recover) => recover::run(recover),
        Command::Convert(convert) => convert::run(convert),
        Command::Export(export) => export::run(export),
        Command::Cut(cut) => cut::run(cut),
        Command::Verify(verify) => verify::run(verify),
        Command::Songs(songs) => songs::run(songs),
        Command::Runs(runs) => runs::run(runs),
        Command::Label(label) => label::run(label),
        Command::Compare(compare) => compare::run(compare),
        Command::Ports(ports) => ports::run(ports),
        Command::World(world) => world::run(world),
        Command::Config(what) => config_command::run(what, cli.config.as_deref()),
        Command::Completions(completions) => completions::run(completions),
        Command::Man(man) => man::run(man),
    }
}

/// Writes a result to standard output.
fn show(text: impl AsRef<[u8]>) -> Result<(), Fault> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_ref())
        .and_then(|()| out.flush())
        .or_else(|error| Fault::output(&error))
}

/// Writes one line of results to standard output.
fn show_line(line: impl Display) -> Result<(), Fault> {
    show(format!("{line}\n"))
}

/// Tells the person at standard error. One that is closed or full changes neither what is done nor the
/// exit code.
fn say(text: impl Display) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Tells the person at a terminal how far it is, over what was told before.
fn say_progress(text: impl Display) {
    let _ = write!(io::stderr(), "\r{text} ");
}

/// One thread runs everything that is not a blocking read or write.
fn block_on<T>(future: impl Future<Output = Result<T, Fault>>) -> Result<T, Fault> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| Fault::new(Exit::Failed, format!("cannot start: {error}")))?;
    let result = runtime.block_on(future);
    // A conversation that was given up may block until its time is over: nobody waits for it.
    runtime.shutdown_background();
    result
}
