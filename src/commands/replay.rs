//! `replay`: a capture in the dashboard.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use tokio::sync::mpsc::Sender as ToStation;

use super::appearance::appearance;
use super::cli::Replay;
use super::{Exit, Fault, block_on, config, keeping, watch};
use crate::capture::{Capture, CaptureError};
use crate::event::{self, Event, Recording};
use crate::io::link::{Link, LinkInput};
use crate::model::{Config, Model};
use crate::radio::Radio;
use crate::runtime::{Dashboard, Driver, Player, run as run_dashboard};

pub(super) fn run(options: &Replay, config: &config::Config) -> Result<(), Fault> {
    if !(SPEED_MIN..=SPEED_MAX).contains(&options.speed) {
        return Err(Fault::new(
            Exit::Usage,
            format!(
                "--speed {}: choose from {SPEED_MIN} to {SPEED_MAX}",
                options.speed
            ),
        ));
    }
    watch::needs_terminal("groundwave decode")?;
    let capture = Capture::open(&options.file).map_err(keeping::fault)?;
    let name = format!("replay of {}", options.file.display());
    let started = Instant::now();
    let (inputs, from_player) = tokio::sync::mpsc::channel(256);
    let (orders, for_player) = channel();
    let speed = options.speed;
    let player = thread::spawn(move || play(capture, speed, &for_player, &inputs));
    block_on(async {
        let driver = Driver::new(
            name,
            Link::receive_only(),
            from_player,
            Radio::RECEIVE_ONLY,
            started,
            Box::new(|_, _| {}),
        );
        let state = event::Replay {
            paused: false,
            speed,
        };
        let dashboard = Dashboard {
            driver,
            // What rang once need not ring again.
            model: Model::new(Config {
                silent: true,
                ..appearance(config)
            }),
            player: Some(Box::new(Remote { orders, state })),
            recording: Box::new(Recording::default),
            first: vec![Event::Replay(state)],
        };
        Box::pin(run_dashboard(dashboard))
            .await
            .or_else(|error| watch::terminal_failed(&error))
    })?;
    // The dashboard is gone; a player that met a damaged capture says so on the restored terminal.
    match player.join() {
        Ok(result) => result.map_err(keeping::fault),
        Err(_) => Err(Fault::new(Exit::Failed, "the player failed")),
    }
}

const SPEED_MIN: f64 = 0.1;
const SPEED_MAX: f64 = 1000.0;

enum Order {
    Pause(bool),
    Speed(f64),
}

struct Remote {
    orders: Sender<Order>,
    state: event::Replay,
}

impl Player for Remote {
    fn pause(&mut self, paused: bool) -> event::Replay {
        // A player at its end hears nothing more.
        let _ = self.orders.send(Order::Pause(paused));
        self.state.paused = paused;
        self.state
    }

    fn speed(&mut self, factor: f64) -> event::Replay {
        let speed = factor.clamp(SPEED_MIN, SPEED_MAX);
        let _ = self.orders.send(Order::Speed(speed));
        self.state.speed = speed;
        self.state
    }
}

/// Hands out the capture's bytes when they are due.
fn play(
    mut capture: Capture,
    speed: f64,
    orders: &Receiver<Order>,
    inputs: &ToStation<LinkInput>,
) -> Result<(), CaptureError> {
    let mut clock = Clock::new(speed);
    if inputs
        .blocking_send(LinkInput::Opened { renamed: None })
        .is_err()
    {
        return Ok(());
    }
    let mut result = Ok(());
    loop {
        let chunk = match capture.next_chunk() {
            Ok(Some(chunk)) => chunk,
            Ok(None) => break,
            Err(error) => {
                // What came before has been shown; the reason is told when the dashboard is closed.
                result = Err(error);
                break;
            }
        };
        let bytes = chunk.bytes.to_vec();
        if !clock.wait_until(chunk.at, orders) {
            return Ok(());
        }
        if inputs
            .blocking_send(LinkInput::Bytes(Instant::now(), bytes))
            .is_err()
        {
            return Ok(());
        }
    }
    // A station that is gone needs no word of the end.
    let _ = inputs.blocking_send(LinkInput::Ended);
    result
}

/// Time in the capture.
struct Clock {
    position: Duration,
    set_at: Instant,
    speed: f64,
    paused: bool,
}

impl Clock {
    fn new(speed: f64) -> Self {
        Self {
            position: Duration::ZERO,
            set_at: Instant::now(),
            speed,
            paused: false,
        }
    }

    fn now(&self) -> Duration {
        if self.paused {
            self.position
        } else {
            self.position + self.set_at.elapsed().mul_f64(self.speed)
        }
    }

    /// Waits until a time in the capture, obeying orders meanwhile; false when nobody gives them any
    /// more.
    fn wait_until(&mut self, at: Duration, orders: &Receiver<Order>) -> bool {
        loop {
            let now = self.now();
            if now >= at {
                return true;
            }
            let order = if self.paused {
                orders.recv().map_err(|_| RecvTimeoutError::Disconnected)
            } else {
                orders.recv_timeout(at.saturating_sub(now).div_f64(self.speed))
            };
            match order {
                Ok(order) => self.obey(&order),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return false,
            }
        }
    }

    fn obey(&mut self, order: &Order) {
        self.position = self.now();
        self.set_at = Instant::now();
        match *order {
            Order::Pause(paused) => self.paused = paused,
            Order::Speed(speed) => self.speed = speed,
        }
    }
}
