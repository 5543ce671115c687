//! `send`: sends commands from a shell or a script; the robot confirms each.

pub(super) mod direct_link;
mod dry_run;
pub(super) mod faults;
mod parameter_task;
mod report;
mod script;
mod shared_link;
mod step;

use super::cli::{Connection, Send};
use super::config::Config;
use super::{Exit, Fault, block_on};
use crate::io::link::LinkSpec;
use faults::receive_only;
use script::Script;

pub(super) fn run(options: &Send, config: &Config) -> Result<(), Fault> {
    let usage = |message| Fault::new(Exit::Usage, message);
    if options.dry_run {
        let words = options.words_to_plan().map_err(usage)?;
        let baud = options.radio.link.baud(config);
        return dry_run::run(options, &Script::read(options, &words, &[])?, baud);
    }
    let (way, words) = options.connection().map_err(usage)?;
    let (way, config) = &way.at(config, &options.radio.link)?;
    let radio = options.radio.radio(config);
    let own = match way {
        Connection::Via(_) => config.all_own_commands(),
        Connection::Link(_) => config.own.commands.keys().cloned().collect(),
    };
    let mut script = Script::read(options, &words, &own)?;
    match way {
        Connection::Via(_) if options.radio.link.wait.is_some() => Err(usage(
            "--wait waits for a link of one's own; with --via the station waits for the robot"
                .to_owned(),
        )),
        Connection::Via(address) if !radio.can_send() => Err(receive_only(address)),
        Connection::Via(address) => shared_link::deliver(options, address, &mut script),
        Connection::Link(link @ LinkSpec::Stdin) => Err(receive_only(link)),
        Connection::Link(link) if !radio.can_send() => Err(receive_only(link)),
        Connection::Link(link) => {
            let baud = options.radio.link.asked_baud(config);
            let opened = direct_link::open(link, baud, &options.radio.link, radio)?;
            match (opened.station(), link) {
                (Some(address), _) => {
                    drop(opened);
                    shared_link::deliver(options, &address, &mut script)
                }
                (None, LinkSpec::Unix(_)) => Err(receive_only(link)),
                (None, _) => {
                    let (driver, simulator) = opened.start(radio);
                    let driver =
                        driver.reading(config.own.recognizer()?, config.own.commands.clone());
                    block_on(direct_link::deliver(
                        options,
                        driver,
                        simulator,
                        &mut script,
                    ))
                }
            }
        }
    }
}
