//! `watch` and `demo`: the live dashboard.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use sr04_sim::serve::{ServeOptions, Server};

use super::appearance::appearance;
use super::cli::{Connection, Demo, LinkArgs, RecordingArgs, Sharing, Watch};
use super::connecting::connect;
use super::output::check_inputs;
use super::{
    Exit, Fault, block_on, config, headless, recording, replay, say, sharing, simulated, terminal,
    tour,
};
use crate::capture::files;
use crate::event::{Event, Level, Notice, NoticeCode, Truth};
use crate::hint::shell_word;
use crate::io::link::{BAUD, Link, LinkSpec};
use crate::io::share_client::ShareClientError;
use crate::model::{Advise, Config, Facts, Ui};
use crate::radio::Radio;
use crate::runtime::{Dashboard, Driver, Keeper, LiveSource, Source, run};
use crate::share::Address;

/// Maximum time for which the last messages wait for a stalled terminal.
const REPORT_PATIENCE: Duration = Duration::from_secs(1);

pub(super) fn watch(options: &Watch, config: &config::Config) -> Result<(), Fault> {
    let usage = |message| Fault::new(Exit::Usage, message);
    let given = options.connection().map_err(usage)?;
    let (way, config) = &given.clone().at(config, &options.radio.link)?;
    let link = &way.link();
    if !options.headless {
        terminal::needed("groundwave watch --headless")?;
    }
    if *link == LinkSpec::Stdin && !options.headless && !cfg!(unix) {
        return Err(Fault::new(
            Exit::Usage,
            "the dashboard needs standard input for keys; use --headless with link -",
        ));
    }
    let advise = options.advise.unwrap_or_default();
    if advise == Advise::Auto && options.headless {
        let text = "--advise=auto needs the dashboard, which shows what it sends; omit --headless";
        return Err(Fault::new(Exit::Usage, text));
    }
    let started = Instant::now();
    let (spec, server) = simulated::embed(link, options.radio.radio(config).kind)?;
    let plan = Plan {
        name: given.link().to_string(),
        spec,
        via: match way {
            Connection::Via(address) => Some(address.clone()),
            Connection::Link(_) => None,
        },
        baud: options.radio.link.asked_baud(config),
        opening: options.radio.link.clone(),
        radio: options.radio.radio(config),
        started,
        recording: options.recording.clone(),
        sharing: options.sharing.or(config),
        notes: server.iter().filter_map(simulated::truth_note).collect(),
        config: config.clone(),
        truth: server.as_ref().map(truth_of),
        tour: false,
        theme: options.theme,
        advise,
    };
    let mut model = appearance(config, options.theme);
    model.advise = advise;
    if plan.via.is_some() {
        model.own_commands = config.all_own_commands();
    }
    if options.headless {
        return block_on(async {
            let (driver, keeper) = plan.open().await?;
            let _finish = keeper.finish_on_drop();
            let run = headless::run(driver, &keeper, model, *link == LinkSpec::Stdin);
            let result = Box::pin(run).await;
            recording::finish(&keeper).await?;
            result
        });
    }
    model.bell |= options.bell;
    show(&plan, model, Vec::new())
}

pub(super) fn demo(options: &Demo, settings: &config::Config) -> Result<(), Fault> {
    let started = Instant::now();
    let recordings = [
        &options.recording.tee,
        &options.recording.record.clone().flatten(),
    ];
    for path in recordings.into_iter().flatten() {
        check_inputs(path, [&options.simulated.world])?;
    }
    let config = simulated::config(&options.simulated)?;
    terminal::needed("groundwave sim")?;
    let warnings = config.world.warnings(&options.simulated.world);
    let server = simulated::start(
        config,
        &ServeOptions {
            endpoints: vec![simulated::endpoint(false), simulated::endpoint(true)],
            time_factor: options.simulated.time_factor,
            ..ServeOptions::default()
        },
    )?;
    let mut notes = BTreeMap::from([
        ("world".to_owned(), options.simulated.world.clone()),
        ("seed".to_owned(), options.simulated.seed.to_string()),
        ("channel".to_owned(), options.simulated.channel.clone()),
    ]);
    notes.extend(simulated::truth_note(&server));
    let plan = Plan {
        name: format!(
            "demo, {} seed {}",
            options.simulated.world, options.simulated.seed
        ),
        spec: simulated::link_to(address(&server, 0)),
        via: None,
        baud: None,
        opening: LinkArgs::default(),
        radio: Radio {
            kind: options.simulated.radio,
            latency: None,
        },
        started,
        recording: options.recording.clone(),
        sharing: options.sharing.clone(),
        notes,
        config: settings.clone(),
        truth: Some(truth_of(&server)),
        tour: tour::is_due(),
        theme: options.theme,
        advise: options.advise.unwrap_or_default(),
    };
    let raw = address(&server, 1);
    let mut model = appearance(settings, options.theme);
    model.bell |= options.bell;
    model.advise = plan.advise;
    model.raw_copy = Some(if cfg!(unix) {
        format!("cat {raw}")
    } else {
        format!("tcp:{raw}")
    });
    let warnings = warnings
        .into_iter()
        .map(|text| Event::Notice(Notice::new(NoticeCode::Configuration, Level::Warning, text)));
    show(&plan, model, warnings.collect())
}

fn truth_of(server: &Server) -> Truth {
    simulated::truth(server.outlines())
}

fn address(server: &Server, index: usize) -> &str {
    server.addresses().get(index).map_or("", String::as_str)
}

/// The settings of a station.
struct Plan {
    name: String,
    spec: LinkSpec,
    /// Address of the station that the operator named; a different kind of server there is refused.
    via: Option<Address>,
    /// Baud rate, if one is asked for.
    baud: Option<u32>,
    opening: LinkArgs,
    radio: Radio,
    started: Instant,
    recording: RecordingArgs,
    sharing: Sharing,
    notes: BTreeMap<String, String>,
    config: config::Config,
    /// The world of a simulated robot, which ends with the program; `None` for a real robot.
    truth: Option<Truth>,
    /// Whether to begin the tour.
    tour: bool,
    /// The theme given with `--theme`; later replays use it, too.
    theme: Option<config::Theme>,
    advise: Advise,
}

impl Plan {
    /// Describes what the robot does after the program has ended.
    fn robot_after(&self, last: Option<&str>) -> Option<String> {
        if self.truth.is_some() {
            return Some("the simulated robot ended with the program".to_owned());
        }
        last.map(str::to_owned)
    }

    /// Opens the link, then servers and recordings. If the link cannot be opened, no empty file is left behind.
    async fn open(&self) -> Result<(Driver, Keeper), Fault> {
        let (inputs, from_link) = tokio::sync::mpsc::channel(256);
        let baud = self.baud.unwrap_or(BAUD);
        let connection = connect(&self.spec, baud, &self.opening)?;
        if let Some(address) = self.via.as_ref().filter(|_| !connection.is_shared()) {
            let error = ShareClientError::NoStation(address.clone());
            return Err(Fault::new(Exit::NoLink, error));
        }
        if self.advise == Advise::Auto && connection.is_shared() {
            let text = "--advise=auto: only the station with the radio may send by itself; start that one with it";
            return Err(Fault::new(Exit::Usage, text));
        }
        let share = sharing::listen(&self.sharing)?;
        let foxglove = sharing::foxglove(&self.sharing, &self.name).await?;
        let rate = self.spec.rate(self.baud);
        let mut notes = self.notes.clone();
        notes.extend(recording::baud_note(rate));
        notes.extend(self.config.own.note());
        let keeper = recording::open(
            &self.recording,
            &self.name,
            notes,
            &self.config,
            self.started,
        )?;
        let link = Link::start(
            self.spec.clone(),
            baud,
            connection,
            sharing::sink(share.as_ref(), keeper.sink()),
            inputs,
        );
        let driver = Driver::new(
            self.name.clone(),
            link,
            from_link,
            self.radio,
            self.started,
            keeper.sent_sink(),
        )
        .at_baud(rate)
        .advising(self.spec.baud(baud))
        .reading(
            self.config.own.recognizer()?,
            self.config.own.commands.clone(),
        )
        .observed_by(keeper.event_sink())
        .shared(share)
        .hooked(self.config.start_alarm_hook()?)
        .simulating(self.truth.clone())
        .watched(foxglove);
        Ok((driver, keeper))
    }
}

fn show(plan: &Plan, mut config: Config, first: Vec<Event>) -> Result<(), Fault> {
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).ok();
    config.unix = unix.and_then(|unix| unix.checked_sub(plan.started.elapsed()));
    let next = block_on(async {
        let (driver, keeper) = plan.open().await?;
        let driver = driver.attended();
        let status = keeper.clone();
        let config = Arc::new(config);
        let facts = Facts::new(Arc::clone(&config));
        let mut ui = Ui::new(config);
        if plan.tour {
            ui.begin_tour();
        }
        let dashboard = Dashboard {
            source: Source::Live(Box::new(LiveSource::new(driver, facts))),
            ui,
            recording: Box::new(move || status.status()),
            first,
            keeper: Some(keeper.clone()),
        };
        let _finish = keeper.finish_on_drop();
        let result = Box::pin(run(dashboard)).await;
        let finished = recording::finish(&keeper).await;
        let last = result.as_ref().ok().and_then(|left| left.robot.as_deref());
        report(told_of(&keeper.finished()).chain(plan.robot_after(last)));
        finished?;
        if result.as_ref().is_ok_and(|left| left.ui.has_ended_tour()) {
            tour::end();
        }
        result.map_or_else(
            |error| terminal::failed(&error).map(|()| None),
            |left| Ok(left.replay),
        )
    })?;
    let replay = |capture: String| replay::replay(capture.into(), 1.0, plan.theme, &plan.config);
    next.map_or(Ok(()), replay)
}

/// The finished recordings, each with the command that replays it.
fn told_of(recordings: &[PathBuf]) -> impl Iterator<Item = String> {
    let nothing = recordings
        .is_empty()
        .then(|| "nothing was recorded".to_owned());
    let all = recordings.iter().map(|path| {
        let command = format!("groundwave replay {}", shell_word(path));
        let place = files::full_path(path);
        format!("recorded {}; `{command}` plays it", place.display())
    });
    nothing.into_iter().chain(all)
}

/// Prints lines; waits at most [`REPORT_PATIENCE`] for a stalled terminal.
fn report(lines: impl Iterator<Item = String>) {
    let lines: Vec<String> = lines.collect();
    let (done, ended) = mpsc::channel::<()>();
    let reporting = thread::Builder::new().spawn(move || {
        let _done = done;
        for line in lines {
            say(line);
        }
    });
    if reporting.is_ok() {
        // The channel closes when the thread ends.
        let _ = ended.recv_timeout(REPORT_PATIENCE);
    }
}
