//! `replay`: a capture in the dashboard.

use std::sync::Arc;
use std::thread;
use std::time::Instant;

use super::appearance::appearance;
use super::cli::Replay;
use super::{Exit, Fault, block_on, config, input, watch};
use crate::capture::index;
use crate::capture::source::unfinished;
use crate::event::{Event, Level, Moment, Notice, NoticeCode, Recording};
use crate::model::{Config, Ui};
use crate::playback::capture::timeline;
use crate::playback::{CaptureState, Player, read_through};
use crate::playback::{SPEED_MAX, SPEED_MIN};
use crate::runtime::{CaptureSource, Dashboard, Source, run as run_dashboard};

/// Most findings waiting for the dashboard.
const FINDINGS: usize = 4;

pub(super) fn run(options: &Replay, config: &config::Config) -> Result<(), Fault> {
    if !(SPEED_MIN..=SPEED_MAX).contains(&options.speed) {
        return Err(Fault::new(
            Exit::Usage,
            format!(
                "--speed {}: give a number from {SPEED_MIN} to {SPEED_MAX}",
                options.speed
            ),
        ));
    }
    watch::needs_terminal("groundwave export")?;
    let tape = index::open(&options.file)?;
    let name = format!("replay of {}", options.file.display());
    // A replay does not ring.
    let config = Arc::new(Config {
        bell: false,
        capture: Some(options.file.display().to_string()),
        ..appearance(config, options.theme)
    });
    let mut first = CaptureState::new(&name, Arc::clone(&config), &*tape);
    if let Some(unfinished) = unfinished(&options.file) {
        first.tell(&Event::Notice(Notice::new(
            NoticeCode::Damaged,
            Level::Warning,
            unfinished.to_string(),
        )));
    }
    let (tell, findings) = tokio::sync::mpsc::channel(FINDINGS);
    let reader = {
        let (state, mut tape) = (first.clone(), tape.reopen());
        thread::spawn(move || {
            let are_wanted = || !tell.is_closed();
            read_through(state, &mut tape, are_wanted, |found| {
                tell.blocking_send(found).is_ok()
            })
        })
    };
    let started = Instant::now();
    let (length, unix) = (tape.length(), tape.unix());
    let timeline = timeline(tape, first);
    let player = Player::of_capture(timeline, Moment::ZERO, options.speed, length, unix);
    block_on(async {
        let dashboard = Dashboard {
            source: Source::Capture(Box::new(CaptureSource {
                player,
                findings,
                started,
            })),
            ui: Ui::new(config),
            recording: Box::new(Recording::default),
            first: Vec::new(),
            keeper: None,
        };
        Box::pin(run_dashboard(dashboard))
            .await
            .map_or_else(|error| watch::terminal_failed(&error), |_| Ok(()))
    })?;
    // Report unreadable parts again, on the restored terminal.
    match reader.join() {
        Ok(None) => Ok(()),
        Ok(Some(damage)) => Err(input::not_whole(&options.file, &damage)),
        Err(_) => Err(Fault::new(
            Exit::Failed,
            "the capture could not be read through",
        )),
    }
}
