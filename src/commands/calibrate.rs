//! `calibrate`: guides the operator through two squares and sets the robot's wheel and track size.

mod operator;

use std::io::{self, BufRead, IsTerminal};

use groundwave_protocol::status_codes::{Bump, Cliff, Drive, Mode};
use groundwave_protocol::telemetry::{Body, ParameterLine, StateLine};
use tokio::sync::mpsc::Receiver;
use tokio::time::{Instant, sleep_until};

use super::cli::Calibrate;
use super::config::Config;
use super::{Exit, Fault, block_on, say};
use crate::calibration::{Gauge, Offset, Squares};
use crate::event::{Event, LinkEvent};
use crate::request::{Request, Tuning};
use operator::Operator;

/// The corrected parameters, in the order of a [`Gauge`].
const CORRECTED: [&str; 3] = ["track", "wheel-left", "wheel-right"];

/// The parameter with the side of the square; negative is counter-clockwise.
const SQUARE: &str = "square";

/// Maximum reported distance from the start after a complete square, inches.
const BROKEN_OFF_IN: f64 = 12.0;

/// Number of lines A to wait for at the end, until the wheels have stopped.
const SETTLED_LINES: u8 = 4;

pub(super) fn run(options: &Calibrate, config: &Config) -> Result<(), Fault> {
    block_on(async {
        let mut guide = Guide {
            options,
            operator: Operator::connect(options, config)?,
            answers: answers(),
            has_driven: false,
            square: None,
        };
        let result = tokio::select! {
            result = guide.calibrate() => result,
            _ = tokio::signal::ctrl_c() => Err(Fault::new(Exit::Failed, "interrupted")),
        };
        if result.is_err() {
            guide.stop().await;
        }
        result
    })
}

/// The lines of standard input, read on a separate thread.
fn answers() -> Receiver<String> {
    let (send, receive) = tokio::sync::mpsc::channel(1);
    std::thread::spawn(move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if send.blocking_send(line).is_err() {
                return;
            }
        }
    });
    receive
}

/// The direction of a square.
#[derive(Clone, Copy)]
enum Direction {
    Clockwise,
    Counter,
}

impl Direction {
    const fn words(self) -> &'static str {
        match self {
            Self::Clockwise => "clockwise",
            Self::Counter => "counter-clockwise",
        }
    }
}

struct Guide<'a> {
    options: &'a Calibrate,
    operator: Operator,
    answers: Receiver<String>,
    has_driven: bool,
    /// Earlier value of the parameter `square`, while it is changed.
    square: Option<i16>,
}

impl Guide<'_> {
    /// Stops the robot after a fault and restores its parameter.
    async fn stop(&mut self) {
        if self.has_driven {
            if self.operator.deliver(Request::Stop).await.is_err() {
                say("The stop was NOT confirmed: stop the robot by hand.");
                return;
            }
            say("The robot has stopped.");
        }
        if let Some(square) = self.square
            && self.put_square_back().await.is_err()
        {
            say(format_args!(
                "Its parameter `{SQUARE}` was {square} before; restore it with `param set {SQUARE} {square}`."
            ));
        }
    }

    async fn put_square_back(&mut self) -> Result<(), Fault> {
        if let Some(square) = self.square {
            self.operator.set(SQUARE, square.into()).await?;
            self.square = None;
        }
        Ok(())
    }

    async fn calibrate(&mut self) -> Result<(), Fault> {
        let before = self.gauge().await?;
        say(format_args!(
            "The robot assumes a track of {} and wheels of {} and {} thousandths of an inch.",
            before.track, before.wheel_left, before.wheel_right
        ));
        let squares = self.squares().await?;
        say(error_text("before", &squares));
        let gauge = squares
            .correct(before)
            .map_err(|error| Fault::new(Exit::Failed, error))?;
        say(format_args!(
            "Measured: a track of {} and wheels of {} and {} thousandths of an inch.",
            gauge.track, gauge.wheel_left, gauge.wheel_right
        ));
        let values = [gauge.track, gauge.wheel_left, gauge.wheel_right];
        for (name, value) in CORRECTED.into_iter().zip(values) {
            self.operator.set(name, value.into()).await?;
        }
        if !self.options.once {
            let after = self.squares().await?;
            say(error_text("after", &after));
            say(format_args!(
                "The error is {:.1} times smaller.",
                squares.error_in() / after.error_in().max(0.1)
            ));
        }
        self.put_square_back().await?;
        if self.options.save {
            return self.save().await;
        }
        say("Valid until the robot's next reset; `param save` keeps the values.");
        Ok(())
    }

    /// Saves only the corrected parameters. The robot saves all of them at once, so others that were changed but not
    /// saved are reset during the save.
    async fn save(&mut self) -> Result<(), Fault> {
        let list = Request::Parameter(Tuning::List);
        let mut others = self.operator.deliver(list).await?;
        others.retain(|line| line.value != line.kept && !CORRECTED.contains(&line.name.as_str()));
        let result = self.save_without(&others).await;
        let names: Vec<String> = others
            .iter()
            .map(|line| format!("{} {}", line.name.as_str(), line.value))
            .collect();
        let names = names.join(", ");
        result.map_err(|fault| match others[..] {
            [] => fault,
            _ => fault.within(
                "",
                format_args!("; these values were set but not saved: {names}"),
            ),
        })?;
        say("Saved permanently.");
        if !others.is_empty() {
            say(format_args!("Not saved, as before: {names}."));
        }
        Ok(())
    }

    async fn save_without(&mut self, others: &[ParameterLine]) -> Result<(), Fault> {
        for line in others {
            self.operator.set(line.name.as_str(), line.kept).await?;
        }
        let save = Request::Parameter(Tuning::Save);
        self.operator.deliver(save).await?;
        for line in others {
            self.operator.set(line.name.as_str(), line.value).await?;
        }
        Ok(())
    }

    /// The wheel and track size that the robot assumes.
    async fn gauge(&mut self) -> Result<Gauge, Fault> {
        Ok(Gauge {
            track: self.operator.get("track").await?,
            wheel_left: self.operator.get("wheel-left").await?,
            wheel_right: self.operator.get("wheel-right").await?,
        })
    }

    /// Drives both squares and asks for the measurements.
    async fn squares(&mut self) -> Result<Squares, Fault> {
        Ok(Squares {
            side_in: self.options.side.into(),
            clockwise: self.square(Direction::Clockwise).await?,
            counter: self.square(Direction::Counter).await?,
        })
    }

    /// Drives a square; returns the measured offset less the reported one.
    async fn square(&mut self, direction: Direction) -> Result<Offset, Fault> {
        let side = match direction {
            Direction::Clockwise => self.options.side,
            Direction::Counter => -self.options.side,
        };
        if io::stdin().is_terminal() {
            say(format_args!(
                "Put the robot on its mark, with {} in of free floor ahead and to the {}. Then press Enter.",
                self.options.side + 12,
                if side > 0 { "right" } else { "left" }
            ));
            self.answer().await?;
        }
        if self.square.is_none() {
            self.square = Some(self.operator.get(SQUARE).await?);
        }
        self.operator.set(SQUARE, side.into()).await?;
        self.operator.deliver(Request::Mode(Mode::Stop)).await?;
        self.has_driven = true;
        self.operator
            .deliver(Request::Mode(Mode::Calibrate))
            .await?;
        say(format_args!("Driving {} …", direction.words()));
        let (end, is_spoilt) = self.wait_for_end().await?;
        let reported = Offset {
            right_in: f64::from(end.x_tenths_in) / 10.0,
            ahead_in: f64::from(end.y_tenths_in) / 10.0,
        };
        if is_spoilt || reported.length_in() > BROKEN_OFF_IN {
            return Err(Fault::new(
                Exit::Failed,
                format!(
                    "the {} square ended early: the robot bumped, saw no floor, stalled or was stopped, {:.0} in from \
                     its start by odometry. Clear the floor and start again",
                    direction.words(),
                    reported.length_in()
                ),
            ));
        }
        say(
            "Measure its position in inches, to the right of the mark and ahead of it, as seen at the start (left and \
             behind are negative):",
        );
        let measured = self.measurement().await?;
        Ok(Offset {
            right_in: measured.right_in - reported.right_in,
            ahead_in: measured.ahead_in - reported.ahead_in,
        })
    }

    /// Waits until mode Calibrate has ended and the wheels have stopped; also returns whether the square was spoilt.
    async fn wait_for_end(&mut self) -> Result<(StateLine, bool), Fault> {
        let speed_in_s = 4;
        let limit_s = 60 + 4 * u64::from(self.options.side.unsigned_abs()) / speed_in_s;
        let limit = Instant::now() + std::time::Duration::from_secs(limit_s);
        let (mut is_spoilt, mut settled) = (false, 0);
        loop {
            while let Some(event) = self.operator.poll_event() {
                let line = match event {
                    Event::Line { line, .. } => line,
                    Event::Link(LinkEvent::Lost { reason }) => {
                        say(format_args!("link lost: {reason}; reconnecting"));
                        continue;
                    }
                    _ => continue,
                };
                match line.body {
                    Body::Text(text) => say(format_args!("robot: {}", text.as_str())),
                    // The first line A may have been sent before the command took effect.
                    Body::State(state) if state.mode == Mode::Calibrate => {
                        is_spoilt |= spoils(&state);
                        settled = 0;
                    }
                    Body::State(state) => {
                        settled += 1;
                        if settled >= SETTLED_LINES {
                            return Ok((state, is_spoilt));
                        }
                    }
                    _ => {}
                }
            }
            tokio::select! {
                () = self.operator.step() => {}
                () = sleep_until(limit) => return Err(Fault::new(
                    Exit::NotConfirmed,
                    format!("the square did not end within {limit_s} s; stop the robot and check the link"),
                )),
            }
        }
    }

    /// The next line of standard input. Serves the link while waiting.
    async fn answer(&mut self) -> Result<String, Fault> {
        loop {
            while self.operator.poll_event().is_some() {}
            tokio::select! {
                () = self.operator.step() => {}
                answer = self.answers.recv() => return answer.ok_or_else(|| Fault::new(
                    Exit::Usage,
                    "standard input ended too early; give two numbers per line, one line per square",
                )),
            }
        }
    }

    async fn measurement(&mut self) -> Result<Offset, Fault> {
        loop {
            let answer = self.answer().await?;
            match measurement(&answer) {
                Some(offset) if offset.length_in() > f64::from(self.options.side) => {
                    say("That is more than the side of the square. Again:");
                }
                Some(offset) => return Ok(offset),
                None => say(format_args!(
                    "`{}` is not two numbers in inches, such as `3.5 -2`. Again:",
                    answer.trim()
                )),
            }
        }
    }
}

/// Whether a bump, a cliff or a stall spoilt the square.
fn spoils(state: &StateLine) -> bool {
    !matches!(state.bump, Bump::None | Bump::NotFitted)
        || !matches!(state.cliff, Cliff::None | Cliff::NotFitted)
        || state.drive == Drive::Stalled
}

/// Parses two numbers, separated by spaces or a comma.
fn measurement(answer: &str) -> Option<Offset> {
    let mut numbers = answer
        .split([',', ' ', '\t'])
        .filter(|word| !word.is_empty())
        .map(|word| word.parse::<f64>().ok().filter(|number| number.is_finite()));
    let offset = Offset {
        right_in: numbers.next()??,
        ahead_in: numbers.next()??,
    };
    numbers.next().is_none().then_some(offset)
}

fn error_text(when: &str, squares: &Squares) -> String {
    format!(
        "Error {when}: {:.1} in clockwise, {:.1} in counter-clockwise, {:.2} % of the distance driven.",
        squares.clockwise.length_in(),
        squares.counter.length_in(),
        squares.error_share() * 100.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measurement_is_two_finite_numbers() {
        let offset = |right_in, ahead_in| Some(Offset { right_in, ahead_in });
        assert_eq!(measurement("3.5 -2"), offset(3.5, -2.0));
        assert_eq!(measurement(" 0,+1.25\t"), offset(0.0, 1.25));
        for wrong in ["", "3", "3 4 5", "a b", "nan 1", "inf 0", "3..5 1"] {
            assert_eq!(measurement(wrong), None, "{wrong}");
        }
    }
}
