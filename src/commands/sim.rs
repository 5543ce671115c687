//! `sim`: a simulated robot for cat, tio, minicom and `watch`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use sr04_sim::serve::{Endpoint, ServeOptions, Server};

use super::cli::Sim;
use super::output::check_inputs;
use super::{Exit, Fault, block_on, out, say, say_fault, simulated};
use crate::capture::files;
use crate::io::signals::{Signal, Signals, stop_myself};

/// Interval of the checks for the end of a simulation with a duration.
const CHECK_EVERY: Duration = Duration::from_millis(50);

/// A boot number from the clock. It differs from the number of a recently killed simulator, so that a station notices the
/// new robot even without an EEPROM file.
fn boots_now() -> u16 {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since_1970.map_or(1, |time| (time.as_secs() % 999) as u16 + 1)
}

/// The EEPROM file, which keeps the boot number. A link with a fixed name has one by default, because stations stay
/// connected to it from one simulator to the next.
fn eeprom(options: &Sim) -> Option<PathBuf> {
    let beside = |link: &PathBuf| {
        let name = link.file_name()?.to_string_lossy();
        Some(link.with_file_name(format!(".{name}.eeprom")))
    };
    let named = options.eeprom.clone();
    named.or_else(|| options.pty.as_ref().and_then(beside))
}

/// Refuses two outputs to one file, an output to the world's file, and named pipes, because opening a pipe can block.
fn check_outputs(options: &Sim) -> Result<(), Fault> {
    let outputs = [&options.trace, &options.wav, &eeprom(options)];
    let mut taken: Vec<&PathBuf> = Vec::new();
    for output in outputs.into_iter().flatten() {
        check_inputs(output, [&options.simulated.world])?;
        if files::is_named_pipe(output) {
            let message = format!("{} is a named pipe; choose a file", output.display());
            return Err(Fault::new(Exit::Usage, message));
        }
        let is_it = |other: &&PathBuf| {
            files::is_same(other, output) || files::full_path(other) == files::full_path(output)
        };
        if taken.iter().any(is_it) {
            let message = format!(
                "{} would be written twice; give --trace, --wav and --eeprom different files",
                output.display()
            );
            return Err(Fault::new(Exit::Usage, message));
        }
        taken.push(output);
    }
    Ok(())
}

/// Refuses an existing regular file without `--force`.
fn refuse_to_overwrite(path: &Path, force: bool) -> Result<(), Fault> {
    if force || !path.is_file() {
        return Ok(());
    }
    let message = format!(
        "{} exists; choose another name, or use --force to overwrite it",
        path.display()
    );
    Err(Fault::new(Exit::Usage, message))
}

pub(super) fn run(options: &Sim) -> Result<(), Fault> {
    check_outputs(options)?;
    if cfg!(not(unix)) && options.pty.is_some() {
        let message =
            "this system has no pseudo-terminals; use --listen 127.0.0.1:4000 instead of --pty";
        return Err(Fault::new(Exit::Usage, message));
    }
    for path in [&options.trace, &options.wav].into_iter().flatten() {
        refuse_to_overwrite(path, options.force)?;
    }
    let mut config = simulated::config(&options.simulated)?;
    for warning in config.world.warnings(&options.simulated.world) {
        say(format_args!("{warning}"));
    }
    config.boots = boots_now();
    let endpoint = match &options.listen {
        Some(address) => Endpoint::Tcp {
            address: address.clone(),
            copy_only: false,
        },
        None if cfg!(unix) => Endpoint::Pty {
            link: options.pty.clone(),
            copy_only: false,
        },
        None => simulated::endpoint(false),
    };
    let is_tcp = matches!(endpoint, Endpoint::Tcp { .. });
    let mut server = simulated::start(
        config,
        &ServeOptions {
            endpoints: vec![endpoint],
            time_factor: options.simulated.time_factor,
            duration: options.duration,
            eeprom: eeprom(options),
            trace: options.trace.clone(),
            wav: options.wav.clone(),
        },
    )?;
    let address = server.addresses().first().map_or("", String::as_str);
    let shown = options
        .pty
        .as_ref()
        .map_or_else(|| address.to_owned(), |path| path.display().to_string());
    let link = if is_tcp {
        format!("tcp:{address}")
    } else {
        shown.clone()
    };
    // Only the address goes to standard output, for scripts.
    let mut out = out();
    writeln!(out, "{}", if is_tcp { &link } else { &shown })
        .and_then(|()| out.flush())
        .or_else(|error| Fault::output(&error))?;
    drop(out);
    say(format_args!(
        "robot {} in world `{}`, seed {}, {}",
        simulated::ROBOT_ID,
        options.simulated.world,
        options.simulated.seed,
        simulated::rate_words(options.simulated.time_factor)
    ));
    if !is_tcp {
        say(format_args!("raw lines:  cat {shown}"));
    }
    say(format_args!("dashboard:  groundwave watch {link}"));
    say("stop:       Ctrl-C");
    let mut is_whole = true;
    block_on(async {
        let mut signals = Signals::listen().map_err(|error| {
            Fault::new(Exit::Failed, format!("cannot listen for signals: {error}"))
        })?;
        while server.is_running() {
            tokio::select! {
                signal = signals.next() => match signal {
                    Signal::Leave => break,
                    Signal::Suspend => stop_myself(),
                },
                () = tokio::time::sleep(CHECK_EVERY) => is_whole &= say_errors(&server),
            }
        }
        Ok(())
    })?;
    server.end();
    is_whole &= say_errors(&server);
    if is_whole {
        return Ok(());
    }
    let message = "the robot ran to its end, but a file is incomplete";
    Err(Fault::new(Exit::Failed, message))
}

/// Prints errors of files when they occur, because the robot continues; returns whether there were none.
fn say_errors(server: &Server) -> bool {
    let mut is_whole = true;
    while let Some(error) = server.poll_error() {
        say_fault(&simulated::fault_of(&error));
        is_whole = false;
    }
    is_whole
}
