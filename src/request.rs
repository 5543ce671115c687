//! What an operator can ask of the robot, and the words for it.
//!
//! The same words serve `groundwave send`, scripts and the dashboard.

mod preset;
mod tuning;

use std::fmt;

use groundwave_protocol::failsafe::{Failsafe, SILENCE_MAX_S, SILENCE_MIN_S};
use groundwave_protocol::letters::{Layer, LayerMask, Mode};
pub use tuning::Tuning;

use groundwave_protocol::parameter::{NAME_BYTES, VALUE_MAX};
use groundwave_protocol::{WAYPOINT_LIMIT_IN, WAYPOINTS_MAX, Waypoint};

/// A wish, before it has become frames on the radio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Motors off.
    Stop,
    /// Enter a mode.
    Mode(Mode),
    /// Allow these layers besides those allowed now.
    Enable(LayerMask),
    /// Allow these layers no longer.
    Disable(LayerMask),
    /// Allow exactly these layers.
    Only(LayerMask),
    /// Replace the waypoint list; empty clears it.
    Route(Vec<Waypoint>),
    /// Take this for the robot's pose.
    Pose {
        /// Where it is.
        position: Waypoint,
        /// Where it looks, 0 to 359 degrees.
        theta_deg: u16,
    },
    /// Look around.
    Scan,
    /// What to do when the ground falls silent; `None`: carry on.
    Failsafe(Option<Failsafe>),
    /// Read, change or keep the robot's parameters.
    Parameter(Tuning),
}

/// Why words are no request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// Nothing was asked.
    #[error("no command given; try `mode prowl`, `goto 48 0` or `stop`")]
    Empty,
    /// The first word is none of ours.
    #[error("unknown command `{0}`; commands are {COMMANDS}")]
    UnknownCommand(String),
    /// A word in the wrong place or too few of them.
    #[error("`{command}` takes {takes}; got `{got}`")]
    Arguments {
        /// The command.
        command: &'static str,
        /// What it takes.
        takes: &'static str,
        /// What it got.
        got: String,
    },
    /// No layer of that name.
    #[error("unknown layer `{0}`; layers are {LAYERS}")]
    UnknownLayer(String),
    /// No mode of that name.
    #[error("unknown mode `{0}`; modes are {MODES}")]
    UnknownMode(String),
    /// A coordinate too far out.
    #[error(
        "`{0}` is not a whole number of inches from -{WAYPOINT_LIMIT_IN} to {WAYPOINT_LIMIT_IN}"
    )]
    Coordinate(String),
    /// A silence or a mode that no robot would take.
    #[error(
        "`failsafe {0}`: the silence is {SILENCE_MIN_S} to {SILENCE_MAX_S} seconds, and the mode one that needs no operator; try `failsafe home 30s`"
    )]
    Failsafe(String),
    /// Nothing that a parameter could be called.
    #[error(
        "`{0}` is no parameter's name: 1 to {NAME_BYTES} lower case letters, digits and hyphens; `param list` shows them"
    )]
    ParameterName(String),
    /// Nothing that a parameter could be.
    #[error("`{0}` is not a whole number from -{VALUE_MAX} to {VALUE_MAX}")]
    ParameterValue(String),
    /// No preset of that name.
    #[error("unknown preset `{0}`; presets are {1}")]
    UnknownPreset(String, String),
    /// Too many waypoints for the robot's memory.
    #[error("{0} waypoints; the robot's list holds {WAYPOINTS_MAX}")]
    TooManyWaypoints(usize),
}

const COMMANDS: &str = "stop, mode, prowl, reactive, passive, wander, home, dock, enable, disable, only, preset, goto, \
                        route, clear, set-pose, reset-pose, scan, failsafe, param";
const LAYERS: &str = "user, bumpers, rotate, ir, sonar, photo, motion, route";
const MODES: &str = "prowl, reactive, passive, wander, home, forage, calibrate, user, stop";

/// The word for a layer.
#[must_use]
pub const fn layer_word(layer: Layer) -> &'static str {
    match layer {
        Layer::User => "user",
        Layer::Bumpers => "bumpers",
        Layer::Rotation => "rotate",
        Layer::Infrared => "ir",
        Layer::Sonar => "sonar",
        Layer::Photo => "photo",
        Layer::Motion => "motion",
        Layer::DeadReckoning => "route",
    }
}

/// The word for a mode.
#[must_use]
pub const fn mode_word(mode: Mode) -> &'static str {
    match mode {
        Mode::Prowl => "prowl",
        Mode::Reactive => "reactive",
        Mode::Passive => "passive",
        Mode::Stop => "stop",
        Mode::User => "user",
        Mode::Wander => "wander",
        Mode::GoHome => "home",
        Mode::Forage => "forage",
        Mode::Calibrate => "calibrate",
    }
}

impl Request {
    /// Reads what words ask for, one request after the other: `preset` asks for several.
    ///
    /// # Errors
    /// Says which word is wrong and what would be right.
    pub fn all_from_words<S: AsRef<str>>(words: &[S]) -> Result<Vec<Self>, RequestError> {
        match words {
            [preset, name] if preset.as_ref() == "preset" => preset::requests(name.as_ref()),
            words => Self::from_words(words).map(|request| vec![request]),
        }
    }

    /// Reads a request from words. `route` is not among them: its words name a file, which the caller
    /// reads with [`crate::route`].
    ///
    /// # Errors
    /// Says which word is wrong and what would be right.
    pub fn from_words<S: AsRef<str>>(words: &[S]) -> Result<Self, RequestError> {
        let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
        let (&command, arguments) = words.split_first().ok_or(RequestError::Empty)?;
        let wrong = |command, takes| RequestError::Arguments {
            command,
            takes,
            got: arguments.join(" "),
        };
        match (command, arguments) {
            ("stop", []) => Ok(Self::Stop),
            ("stop", _) => Err(wrong("stop", "nothing")),
            ("mode", [mode]) => read_mode(mode),
            ("mode", _) => Err(wrong("mode", "one mode")),
            ("prowl" | "reactive" | "passive" | "wander" | "home", []) => read_mode(command),
            ("dock", []) => Ok(Self::Mode(Mode::Forage)),
            ("preset", _) => Err(wrong("preset", "one name, and stands for several commands")),
            ("only", ["none"]) => Ok(Self::Only(LayerMask::NONE)),
            ("only", [layers]) => Ok(Self::Only(read_layers(layers)?)),
            ("only", _) => Err(wrong("only", "layers separated by commas, or `none`")),
            ("param", words) => Tuning::from_words(words).map(Self::Parameter),
            ("enable", [layers]) => Ok(Self::Enable(read_layers(layers)?)),
            ("enable", _) => Err(wrong("enable", "layers separated by commas")),
            ("disable", [layers]) => Ok(Self::Disable(read_layers(layers)?)),
            ("disable", _) => Err(wrong("disable", "layers separated by commas")),
            ("goto", [x, y]) => Ok(Self::Route(vec![read_point(x, y)?])),
            ("goto", _) => Err(wrong("goto", "X and Y in inches")),
            ("route", _) => Err(wrong("route", "the name of one file of `X,Y` lines")),
            ("clear", []) => Ok(Self::Route(Vec::new())),
            ("clear", _) => Err(wrong("clear", "nothing")),
            ("set-pose", [x, y, theta]) => {
                let theta_deg = theta.parse().ok().filter(|theta| *theta < 360);
                Ok(Self::Pose {
                    position: read_point(x, y)?,
                    theta_deg: theta_deg.ok_or_else(|| {
                        wrong("set-pose", "X and Y in inches and theta, 0 to 359 degrees")
                    })?,
                })
            }
            ("set-pose", _) => Err(wrong(
                "set-pose",
                "X and Y in inches and theta, 0 to 359 degrees",
            )),
            ("reset-pose", []) => Ok(Self::Pose {
                position: Waypoint::default(),
                theta_deg: 0,
            }),
            ("reset-pose", _) => Err(wrong("reset-pose", "nothing")),
            ("scan", []) => Ok(Self::Scan),
            ("scan", _) => Err(wrong("scan", "nothing")),
            ("failsafe", ["off"]) => Ok(Self::Failsafe(None)),
            ("failsafe", [mode, silence]) => read_failsafe(mode, silence),
            ("failsafe", _) => Err(wrong(
                "failsafe",
                "`off`, or a mode and the silence after which to enter it, like `home 30s`",
            )),
            _ => Err(RequestError::UnknownCommand(command.to_owned())),
        }
    }

    /// Whether a command begins with this word.
    #[must_use]
    pub fn is_command(word: &str) -> bool {
        COMMANDS.split(", ").any(|command| command == word)
    }

    /// A waypoint list that fits the robot.
    ///
    /// # Errors
    /// When it does not.
    pub fn route(waypoints: Vec<Waypoint>) -> Result<Self, RequestError> {
        if waypoints.len() > WAYPOINTS_MAX {
            return Err(RequestError::TooManyWaypoints(waypoints.len()));
        }
        Ok(Self::Route(waypoints))
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stop => f.write_str("stop"),
            Self::Mode(mode) => write!(f, "mode {}", mode_word(*mode)),
            Self::Enable(layers) => write!(f, "enable {}", layer_words(*layers)),
            Self::Disable(layers) => write!(f, "disable {}", layer_words(*layers)),
            Self::Only(LayerMask::NONE) => f.write_str("only none"),
            Self::Only(layers) => write!(f, "only {}", layer_words(*layers)),
            Self::Parameter(tuning) => tuning.fmt(f),
            Self::Route(waypoints) => match waypoints[..] {
                [] => f.write_str("clear"),
                [Waypoint { x_in, y_in }] => write!(f, "goto {x_in} {y_in}"),
                _ => write!(f, "route of {} waypoints", waypoints.len()),
            },
            Self::Pose {
                position,
                theta_deg,
            } => {
                write!(
                    f,
                    "set-pose {} {} {theta_deg}",
                    position.x_in, position.y_in
                )
            }
            Self::Scan => f.write_str("scan"),
            Self::Failsafe(None) => f.write_str("failsafe off"),
            Self::Failsafe(Some(Failsafe { silence_s, mode })) => {
                write!(f, "failsafe {} {silence_s}s", mode_word(*mode))
            }
        }
    }
}

fn layer_words(layers: LayerMask) -> String {
    let words: Vec<&str> = Layer::ALL
        .into_iter()
        .filter(|layer| layers.contains(*layer))
        .map(layer_word)
        .collect();
    words.join(",")
}

/// `mode stop` is STOP: there is one way to stop, the safest.
fn read_mode(word: &str) -> Result<Request, RequestError> {
    Mode::ALL
        .iter()
        .copied()
        .find(|mode| mode_word(*mode) == word)
        .map(|mode| {
            if mode == Mode::Stop {
                Request::Stop
            } else {
                Request::Mode(mode)
            }
        })
        .ok_or_else(|| RequestError::UnknownMode(word.to_owned()))
}

fn read_failsafe(mode: &str, silence: &str) -> Result<Request, RequestError> {
    let mode = Mode::ALL
        .iter()
        .copied()
        .find(|known| mode_word(*known) == mode)
        .ok_or_else(|| RequestError::UnknownMode(mode.to_owned()))?;
    let silence_s = silence.strip_suffix('s').unwrap_or(silence).parse();
    silence_s
        .ok()
        .map(|silence_s| Failsafe { silence_s, mode })
        .filter(Failsafe::is_valid)
        .map(|failsafe| Request::Failsafe(Some(failsafe)))
        .ok_or_else(|| RequestError::Failsafe(format!("{} {silence}", mode_word(mode))))
}

fn read_layers(words: &str) -> Result<LayerMask, RequestError> {
    words.split(',').try_fold(LayerMask::NONE, |layers, word| {
        Layer::ALL
            .into_iter()
            .find(|layer| layer_word(*layer) == word)
            .map(|layer| layers.with(layer))
            .ok_or_else(|| RequestError::UnknownLayer(word.to_owned()))
    })
}

fn read_point(x: &str, y: &str) -> Result<Waypoint, RequestError> {
    let part = |word: &str| {
        word.parse()
            .map_err(|_| RequestError::Coordinate(word.to_owned()))
    };
    let (x_in, y_in) = (part(x)?, part(y)?);
    Waypoint::new(x_in, y_in).ok_or_else(|| RequestError::Coordinate(format!("{x} {y}")))
}
