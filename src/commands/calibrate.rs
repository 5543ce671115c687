//! `calibrate`: two squares, a tape measure, and what follows from them.

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

/// What is corrected, in the order of a [`Gauge`].
const CORRECTED: [&str; 3] = ["track", "wheel-left", "wheel-right"];

/// How the robot is told which square to drive.
const SQUARE: &str = "square";

/// A robot that believes to be farther than this from its start did not drive the whole square.
const BROKEN_OFF_IN: f64 = 12.0;

/// Lines A to wait for at the end: by then the wheels stand.
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

/// The lines of standard input, read beside the radio.
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

#[derive(Clone, Copy)]
enum Way {
    Clockwise,
    Counter,
}

impl Way {
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
    /// What the robot's square was before, while it is another.
    square: Option<i16>,
}

impl Guide<'_> {
    /// Whatever went wrong, the robot does not drive on blindly in mode Calibrate, and its square is what it was.
    async fn stop(&mut self) {
        if self.has_driven {
            if self.operator.deliver(Request::Stop).await.is_err() {
                say("Whether the robot has stopped is NOT known: stop it by hand.");
                return;
            }
            say("The robot has stopped.");
        }
        if let Some(square) = self.square
            && self.put_square_back().await.is_err()
        {
            say(format_args!(
                "Its parameter `{SQUARE}` was {square} before: `param set {SQUARE} {square}` puts that back."
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
            "The robot takes its track for {} and its wheels for {} and {} thousandths of an inch.",
            before.track, before.wheel_left, before.wheel_right
        ));
        let squares = self.squares().await?;
        say(error_text("before", &squares));
        let gauge = squares
            .correct(before)
            .map_err(|error| Fault::new(Exit::Failed, error))?;
        say(format_args!(
            "So its track is {} and its wheels are {} and {} thousandths of an inch.",
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
                "{:.1} times better.",
                squares.error_in() / after.error_in().max(0.1)
            ));
        }
        self.put_square_back().await?;
        if self.options.save {
            return self.save().await;
        }
        say("Until the robot's next reset; `param save` keeps it for longer.");
        Ok(())
    }

    /// The robot keeps all its parameters or none: what somebody else changed and has not kept is put back for the
    /// moment.
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
            _ => fault.within("", format_args!("; set before and not kept were {names}")),
        })?;
        say("Kept over a reset.");
        if !others.is_empty() {
            say(format_args!("Not kept, as before: {names}."));
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

    /// What the robot takes its wheels and track for now.
    async fn gauge(&mut self) -> Result<Gauge, Fault> {
        Ok(Gauge {
            track: self.operator.get("track").await?,
            wheel_left: self.operator.get("wheel-left").await?,
            wheel_right: self.operator.get("wheel-right").await?,
        })
    }

    /// Drives both squares and has them measured.
    async fn squares(&mut self) -> Result<Squares, Fault> {
        Ok(Squares {
            side_in: self.options.side.into(),
            clockwise: self.square(Way::Clockwise).await?,
            counter: self.square(Way::Counter).await?,
        })
    }

    async fn square(&mut self, way: Way) -> Result<Offset, Fault> {
        let side = match way {
            Way::Clockwise => self.options.side,
            Way::Counter => -self.options.side,
        };
        if io::stdin().is_terminal() {
            say(format_args!(
                "Put the robot on its mark, with {} in free ahead and to the {}. Then press Enter.",
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
        say(format_args!("Driving {} …", way.words()));
        let (end, is_spoilt) = self.until_it_stands().await?;
        let believed = Offset {
            right_in: f64::from(end.x_tenths_in) / 10.0,
            ahead_in: f64::from(end.y_tenths_in) / 10.0,
        };
        if is_spoilt || believed.length_in() > BROKEN_OFF_IN {
            return Err(Fault::new(
                Exit::Failed,
                format!(
                    "the {} square was broken off: the robot touched something, saw no floor, stalled or was stopped, \
                     {:.0} in from its start by its own reckoning. Clear the floor and begin again",
                    way.words(),
                    believed.length_in()
                ),
            ));
        }
        say(
            "Where is it now? Inches to the right of its mark and ahead of it, as it stood there (left and behind are \
             negative):",
        );
        let measured = self.measurement().await?;
        Ok(Offset {
            right_in: measured.right_in - believed.right_in,
            ahead_in: measured.ahead_in - believed.ahead_in,
        })
    }

    /// Until mode C has ended and the wheels stand; also whether anything happened on the way that spoils a
    /// square.
    async fn until_it_stands(&mut self) -> Result<(StateLine, bool), Fault> {
        let speed_in_s = 4;
        let limit_s = 60 + 4 * u64::from(self.options.side.unsigned_abs()) / speed_in_s;
        let limit = Instant::now() + std::time::Duration::from_secs(limit_s);
        let (mut is_spoilt, mut settled) = (false, 0);
        loop {
            while let Some(event) = self.operator.poll_event() {
                let line = match event {
                    Event::Line { line, .. } => line,
                    Event::Link(LinkEvent::Lost { reason }) => {
                        say(format_args!("link lost: {reason}; trying again"));
                        continue;
                    }
                    _ => continue,
                };
                match line.body {
                    Body::Text(text) => say(format_args!("robot: {}", text.as_str())),
                    // The first one may have been composed before the order.
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
                    format!("the end of the square was not heard within {limit_s} s: stop the robot and look at the link"),
                )),
            }
        }
    }

    /// The next line of standard input; the radio goes on meanwhile.
    async fn answer(&mut self) -> Result<String, Fault> {
        loop {
            while self.operator.poll_event().is_some() {}
            tokio::select! {
                () = self.operator.step() => {}
                answer = self.answers.recv() => return answer.ok_or_else(|| Fault::new(
                    Exit::Usage,
                    "standard input has ended before everything was measured: two numbers a line, one line a square",
                )),
            }
        }
    }

    async fn measurement(&mut self) -> Result<Offset, Fault> {
        loop {
            let answer = self.answer().await?;
            match measurement(&answer) {
                Some(offset) if offset.length_in() > f64::from(self.options.side) => {
                    say("That is farther than a side is long. Again:");
                }
                Some(offset) => return Ok(offset),
                None => say(format_args!(
                    "`{}` are not two numbers of inches, like `3.5 -2`. Again:",
                    answer.trim()
                )),
            }
        }
    }
}

/// A square on which this happened is none.
fn spoils(state: &StateLine) -> bool {
    !matches!(state.bump, Bump::None | Bump::NotFitted)
        || !matches!(state.cliff, Cliff::None | Cliff::NotFitted)
        || state.drive == Drive::Stalled
}

/// Two numbers, with spaces or a comma between them.
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
        "Error {when}: {:.1} in clockwise, {:.1} in counter-clockwise, {:.2} % of the way.",
        squares.clockwise.length_in(),
        squares.counter.length_in(),
        squares.error_share() * 100.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measurement_is_two_numbers() {
        let offset = |right_in, ahead_in| Some(Offset { right_in, ahead_in });
        assert_eq!(measurement("3.5 -2"), offset(3.5, -2.0));
        assert_eq!(measurement(" 0,+1.25\t"), offset(0.0, 1.25));
        for wrong in ["", "3", "3 4 5", "a b", "nan 1", "inf 0", "3..5 1"] {
            assert_eq!(measurement(wrong), None, "{wrong}");
        }
    }
}
