//! `replay`: plays a capture in the dashboard.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use super::appearance::appearance;
use super::cli::Replay;
use super::config::Theme;
use super::{Exit, Fault, block_on, config, input, say_fault, terminal};
use crate::capture::runs::Label;
use crate::capture::source::unfinished;
use crate::capture::{CaptureError, index};
use crate::event::{Event, Level, Moment, Notice, NoticeCode, Recording};
use crate::model::{Config, Ui};
use crate::playback::capture::timeline;
use crate::playback::{CaptureState, Player, read_through};
use crate::playback::{SPEED_MAX, SPEED_MIN};
use crate::runtime::{CaptureSource, Dashboard, Source, run as run_dashboard};

/// Maximum number of findings queued for the dashboard.
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
    terminal::needed("groundwave export")?;
    replay(options.file.clone(), options.speed, options.theme, config)
}

/// Replays a capture, then each capture that the operator chooses from the list of runs.
pub(super) fn replay(
    file: PathBuf,
    speed: f64,
    theme: Option<Theme>,
    config: &config::Config,
) -> Result<(), Fault> {
    let mut next = Some(file);
    let mut damage = Ok(());
    while let Some(file) = next {
        // Report unreadable parts again, on the restored terminal.
        if let Err(fault) = std::mem::replace(&mut damage, Ok(())) {
            say_fault(&fault);
        }
        (next, damage) = play(&file, speed, theme, config)?;
    }
    damage
}

/// Plays one capture; returns the next capture to play, and the reason if reading was incomplete.
fn play(
    file: &Path,
    speed: f64,
    theme: Option<Theme>,
    config: &config::Config,
) -> Result<(Option<PathBuf>, Result<(), Fault>), Fault> {
    let tape = index::open(file)?;
    let label = Label::of(file);
    let name = format!("replay of {}", file.display());
    // A replay does not ring the bell.
    let config = Arc::new(Config {
        bell: false,
        capture: Some(file.display().to_string()),
        ..appearance(config, theme)
    });
    let mut first = CaptureState::new(&name, Arc::clone(&config), &*tape);
    let warning = |code, text| Event::Notice(Notice::new(code, Level::Warning, text));
    // Whole in the log; shorter in the row above the keys, until a key is pressed.
    let mut hints = Vec::new();
    if let Some(unfinished) = unfinished(file) {
        first.tell(&warning(NoticeCode::Damaged, unfinished.to_string()));
        let text = match unfinished {
            CaptureError::Unfinished {
                is_in_use: true, ..
            } => "this recording is under way: its end is not written yet",
            _ => "this recording was interrupted; `groundwave recover FILE` finishes it",
        };
        hints.push(warning(NoticeCode::Damaged, text.to_owned()));
    }
    if let Err(error) = &label {
        let warning = warning(NoticeCode::Label, error.to_string());
        first.tell(&warning);
        hints.push(warning);
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
    let mut player = Player::of_capture(timeline, Moment::ZERO, speed, length, unix);
    for note in label.unwrap_or_default().notes {
        if let Some(at) = note
            .at_s
            .and_then(|at_s| Moment::try_from_secs_f64(at_s).ok())
        {
            player.add_noted_mark(at, note.text);
        }
    }
    let next = block_on(async {
        let dashboard = Dashboard {
            source: Source::Capture(Box::new(CaptureSource {
                player,
                findings,
                started,
            })),
            ui: Ui::new(config),
            recording: Box::new(Recording::default),
            first: hints,
            keeper: None,
        };
        Box::pin(run_dashboard(dashboard)).await.map_or_else(
            |error| terminal::failed(&error).map(|()| None),
            |left| Ok(left.replay),
        )
    })?;
    let read = match reader.join() {
        Ok(None) => Ok(()),
        Ok(Some(damage)) => Err(input::not_whole(file, &damage)),
        Err(_) => Err(Fault::new(
            Exit::Failed,
            "the capture could not be read through",
        )),
    };
    Ok((next.map(PathBuf::from), read))
}
