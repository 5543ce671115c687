//! `record`: records received bytes without a dashboard.

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::appearance::appearance;
use super::cli::Record;
use super::config::Config;
use super::connecting::connect;
use super::headless::Observer;
use super::{Exit, Fault, block_on, recording, say, say_progress, sharing, simulated};
use crate::capture::words::lost_words;
use crate::event::{Event, LinkEvent};
use crate::io::link::Link;
use crate::io::signals::{Signal, Signals, stop_myself};
use crate::radio::Radio;
use crate::runtime::{Driver, KeepOptions, Keeper};
use groundwave_captures::words::counted;

const REPORT_EVERY: Duration = Duration::from_secs(1);

pub(super) fn run(options: &Record, config: &Config) -> Result<(), Fault> {
    let (link, config) = &config.at(&options.link, &options.radio.link)?;
    let baud = options.radio.link.baud(config);
    let started = Instant::now();
    let output = options
        .output
        .clone()
        .unwrap_or_else(recording::automatic_name);
    recording::check_name(&output)?;
    let is_mcap = output
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("mcap"));
    if is_mcap && options.append {
        return Err(Fault::new(
            Exit::Usage,
            "--append needs a raw file; a finished MCAP file cannot be appended to",
        ));
    }
    let sharing = options.sharing.or(config);
    // A recorder by itself never sends; with a shared link, its clients may send.
    let radio = if sharing.share.is_some() || sharing.foxglove.is_some() {
        options.radio.radio(config)
    } else {
        Radio::RECEIVE_ONLY
    };
    let (spec, simulator) = simulated::embed(link, radio.kind)?;
    let name = options.link.to_string();
    let (tee, mcap) = if is_mcap {
        (None, Some(output.clone()))
    } else {
        (Some(output.clone()), None)
    };
    let (port_baud, rate) = (
        spec.baud(baud),
        spec.rate(options.radio.link.asked_baud(config)),
    );
    let keep = KeepOptions {
        tee,
        mcap,
        is_unnamed: options.output.is_none(),
        existing: recording::existing(options.append, options.force),
        link: name.clone(),
        notes: simulator
            .iter()
            .filter_map(simulated::truth_note)
            .chain(recording::baud_note(rate))
            .chain(config.own.note())
            .collect(),
        configuration: config.text.clone(),
        rotation: recording::rotation(options.rotate, config),
        // The recording runs from the start, so no time before it is needed.
        remembered: Duration::ZERO,
    };
    block_on(async {
        let (inputs, from_link) = tokio::sync::mpsc::channel(256);
        // The link is opened first, so that a failure leaves no empty file behind.
        let connection = connect(&spec, baud, &options.radio.link)?;
        let share = sharing::listen(&sharing)?;
        let foxglove = sharing::foxglove(&sharing, &name).await?;
        let keeper = Keeper::open(&keep, started)?;
        let sink = sharing::sink(share.as_ref(), keeper.sink());
        let link = Link::start(spec, baud, connection, sink, inputs);
        let driver = Driver::new(name, link, from_link, radio, started, keeper.sent_sink());
        let driver = driver
            .at_baud(rate)
            .advising(port_baud)
            .reading(config.own.recognizer()?, config.own.commands.clone())
            .observed_by(keeper.event_sink())
            .shared(share)
            .hooked(config.start_alarm_hook()?)
            .watched(foxglove);
        let _finish = keeper.finish_on_drop();
        let result = Box::pin(until_done(options, driver, &keeper, config)).await;
        let mcap = keeper.status().mcap.map(PathBuf::from);
        let written = recording::finish(&keeper).await;
        say_notices(&keeper, options.quiet);
        let written = written?;
        let heard = result?;
        if !options.quiet {
            say(format_args!(
                "recorded {}: {heard}; {} written",
                mcap.as_ref().unwrap_or(&output).display(),
                counted(written, "byte"),
            ));
        }
        Ok(())
    })
}

/// Prints the recording manager's notices.
fn say_notices(keeper: &Keeper, quiet: bool) {
    while let Some((_, text)) = keeper.poll_notice() {
        if !quiet {
            say(format_args!("groundwave: {text}"));
        }
    }
}

/// What the station has heard, in words. Bytes are not among it: those of an unfinished line may be in the recording alone.
fn heard_words(driver: &Driver) -> String {
    let (station, counters) = (driver.station(), driver.station().totals(driver.now()));
    match station.own_lines() {
        _ if counters.bytes == 0 => "nothing was received".to_owned(),
        own if own > 0 && counters.intact() == 0 => counted(own, "own line"),
        _ => format!(
            "{}, {} lost",
            counted(counters.intact(), "line"),
            lost_words(counters.lost())
        ),
    }
}

/// Records until a signal, the end of the link or of the duration; returns what was heard, in words.
async fn until_done(
    options: &Record,
    mut driver: Driver,
    keeper: &Keeper,
    config: &Config,
) -> Result<String, Fault> {
    let mut observer = Observer::new(appearance(config, None));
    let mut signals = Signals::listen()
        .map_err(|error| Fault::new(Exit::Failed, format!("cannot listen for signals: {error}")))?;
    let shows_progress = !options.quiet && io::stderr().is_terminal();
    let mut report = tokio::time::interval(REPORT_EVERY);
    let mut is_report_due = false;
    let end = tokio::time::sleep(options.duration.unwrap_or(Duration::MAX));
    tokio::pin!(end);
    loop {
        tokio::select! {
            signal = signals.next() => match signal {
                Signal::Leave => break,
                Signal::Suspend => stop_myself(),
            },
            () = &mut end => break,
            () = driver.step() => {}
            _ = report.tick() => {
                // The facts know of a suspension before they judge a silence.
                driver.detect_suspension();
                is_report_due = true;
            }
        }
        let mut ended = false;
        while let Some(event) = driver.poll_event() {
            observer.take(&mut driver, &event);
            match event {
                Event::Link(LinkEvent::Ended) => ended = true,
                Event::Link(LinkEvent::Lost { reason }) if !options.quiet => {
                    say(format_args!(
                        "groundwave: link lost: {reason}; reconnecting"
                    ));
                }
                Event::Notice(notice) if !options.quiet => {
                    say(format_args!("groundwave: {}", notice.text));
                }
                _ => {}
            }
        }
        if ended {
            break;
        }
        if std::mem::take(&mut is_report_due) {
            say_notices(keeper, options.quiet);
            let status = keeper.status();
            observer.take(&mut driver, &Event::Recording(status.clone()));
            if let Some(problem) = status.problem {
                return Err(Fault::new(Exit::Failed, problem));
            }
            if shows_progress {
                let bytes = driver.station().totals(driver.now()).bytes;
                say_progress(format_args!(
                    "{} received, {}",
                    counted(bytes, "byte"),
                    heard_words(&driver)
                ));
            }
        }
    }
    if shows_progress {
        say("");
    }
    driver.end();
    while let Some(event) = driver.poll_event() {
        observer.take(&mut driver, &event);
    }
    Ok(heard_words(&driver))
}
