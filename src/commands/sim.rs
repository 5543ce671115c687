//! `sim`: a robot for cat, tio, minicom and `watch`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use sr04_sim::serve::{Endpoint, ServeOptions};

use super::cli::Sim;
use super::{Exit, Fault, block_on, say, simulated};
use crate::io::signals::{Signal, Signals, stop_myself};

/// How often the end of a simulation with a duration is looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// A boot number that differs from that of a simulator killed a moment ago: without an EEPROM file nothing
/// else would tell a station that the robot is another.
fn boots_now() -> u16 {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since_1970.map_or(1, |time| (time.as_secs() % 999) as u16 + 1)
}

/// Where the robot remembers how often it has booted. Under a steady name stations stay while simulators
/// come and go, and a robot whose boot number happens to agree with the last one's passes for it.
fn eeprom(options: &Sim) -> Option<PathBuf> {
    let beside = |link: &PathBuf| {
        let name = link.file_name()?.to_string_lossy();
        Some(link.with_file_name(format!(".{name}.eeprom")))
    };
    let given = options.eeprom.clone();
    given.or_else(|| options.pty.as_ref().and_then(beside))
}

/// A file that is there holds something; a pipe or a device holds nothing.
fn refuse_to_overwrite(path: &Path, force: bool) -> Result<(), Fault> {
    if force || !path.is_file() {
        return Ok(());
    }
    let message = format!(
        "{} exists: choose another name, or say --force to overwrite it",
        path.display()
    );
    Err(Fault::new(Exit::Usage, message))
}

pub(super) fn run(options: &Sim) -> Result<(), Fault> {
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
    let server = simulated::start(
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
    // The address alone on standard output, for scripts; the rest is for a person.
    let mut out = io::stdout().lock();
    writeln!(out, "{}", if is_tcp { &link } else { &shown })
        .and_then(|()| out.flush())
        .or_else(|error| Fault::output(&error))?;
    drop(out);
    say(format_args!(
        "SR04 number {} prowls the world `{}`, seed {}, {}",
        simulated::ROBOT_ID,
        options.simulated.world,
        options.simulated.seed,
        simulated::rate_words(options.simulated.time_factor)
    ));
    if !is_tcp {
        say(format_args!("look at it:  cat {shown}"));
    }
    say(format_args!("watch it:    groundwave watch {link}"));
    say("Ctrl-C ends it");
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
                () = tokio::time::sleep(LOOK_EVERY), if options.duration.is_some() => {}
            }
        }
        Ok(())
    })
}
