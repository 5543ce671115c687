//! What an operator can ask of the robot, and the words for it.
//!
//! The same words serve `groundwave send`, scripts and the dashboard.

mod amount;
mod listing;
mod parameters;
mod preset;
mod refusal;
mod tuning;
mod words;

use std::fmt;

pub use amount::{Amount, in_whole_unit};
pub use groundwave_captures::words::{layer_word, mode_word};
pub use listing::LISTING;
pub use parameters::known as known_parameters;
pub use preset::names as preset_names;
pub use refusal::Standing;
pub use tuning::Tuning;

use groundwave_protocol::failsafe::{Failsafe, SILENCE_MAX_S, SILENCE_MIN_S};
use groundwave_protocol::parameter::{NAME_BYTES, VALUE_MAX};
use groundwave_protocol::status_codes::{LayerMask, Mode};
use groundwave_protocol::{WAYPOINT_LIMIT_IN, WAYPOINTS_MAX, Waypoint};

use crate::suggest;
use words::{find_mode, layer_words, read_layers, read_mode};

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
    #[error("unknown command `{0}`{near}", near = told(.0, "commands", COMMANDS))]
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
    #[error("unknown layer `{0}`{near}", near = told(.0, "layers", LAYERS))]
    UnknownLayer(String),
    /// No mode of that name.
    #[error("unknown mode `{0}`{near}", near = told(.0, "modes", MODES))]
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
    /// Nearly what a known parameter is called.
    #[error(
        "no parameter `{0}` is known here; did you mean `{1}`? If the robot has one of that name, say `={0}`"
    )]
    ParameterUnknown(String, &'static str),
    /// Nothing that a parameter could be.
    #[error(
        "`{0}` is not a number that a parameter could have: a whole one from -{VALUE_MAX} to {VALUE_MAX}, or one like 11.6 in the whole unit"
    )]
    ParameterValue(String),
    /// No parameter is named.
    #[error("`param {0}` needs a name, as in `param {0} {1}`; `param list` shows them")]
    ParameterMissing(&'static str, &'static str),
    /// Nearly a verb.
    #[error("`param` has no `{0}`; did you mean `{1}`?")]
    ParameterVerb(String, &'static str),
    /// A name, and not what is wanted of it.
    #[error(
        "`param {0}` says no more than a name: `param get {0}` asks for its value, `param {0} VALUE` changes it"
    )]
    ParameterAlone(String),
    /// No value is given.
    #[error(
        "`param set {0}` needs a value; `param get {0}` says what it is now and what the robot takes"
    )]
    ValueMissing(String),
    /// No preset of that name.
    #[error("unknown preset `{0}`{near}", near = suggest::question_or(.0, preset_names(), format_args!("presets are {}", preset::names_text())))]
    UnknownPreset(String),
    /// Too many waypoints for the robot's memory.
    #[error("{0} waypoints; the robot's list holds {WAYPOINTS_MAX}")]
    TooManyWaypoints(usize),
}

impl RequestError {
    /// The same for somebody at a shell: zsh takes a word with `=` before it for the name of a program.
    #[must_use]
    pub fn in_shell(&self) -> String {
        let told = self.to_string();
        match self {
            Self::ParameterUnknown(name, _) => {
                told.replace(&format!("`={name}`"), &format!("`'={name}'`"))
            }
            _ => told,
        }
    }
}

const COMMANDS: &str = "stop, mode, prowl, reactive, passive, wander, home, dock, enable, disable, only, preset, goto, \
                        route, clear, set-pose, reset-pose, scan, failsafe, param";
const LAYERS: &str = "user, bumpers, rotation, infrared, sonar, photo, motion, dead-reckoning";
const MODES: &str = "prowl, reactive, passive, wander, home, forage, calibrate, user, stop";

/// What somebody who used another word may have meant, or all the words there are.
fn told(word: &str, what: &str, list: &'static str) -> String {
    suggest::question_or(word, words_of(list), format_args!("{what} are {list}"))
}

/// The words of a list with commas.
fn words_of(list: &'static str) -> impl Iterator<Item = &'static str> {
    list.split(", ")
}

impl Request {
    /// Reads what words ask for, one request after the other: `preset` asks for several.
    ///
    /// # Errors
    /// Says which word is wrong and what would be right.
    pub fn all_from_words<S: AsRef<str>>(words: &[S]) -> Result<Vec<Self>, RequestError> {
        match words {
            [preset, name] if preset.as_ref() == "preset" => preset::requests(name.as_ref()),
            [goto @ .., go]
                if goto.len() == 3 && goto[0].as_ref() == "goto" && go.as_ref() == "--go" =>
            {
                Ok(vec![Self::from_words(goto)?, Self::Mode(Mode::Prowl)])
            }
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
            ("prowl", _) => Err(wrong("prowl", "nothing")),
            ("reactive", _) => Err(wrong("reactive", "nothing")),
            ("passive", _) => Err(wrong("passive", "nothing")),
            ("wander", _) => Err(wrong("wander", "nothing")),
            ("home", _) => Err(wrong("home", "nothing")),
            ("dock", []) => Ok(Self::Mode(Mode::Forage)),
            ("dock", _) => Err(wrong("dock", "nothing")),
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

    /// The words that a command begins with.
    pub fn commands() -> impl Iterator<Item = &'static str> {
        words_of(COMMANDS)
    }

    /// Whether a command begins with this word.
    #[must_use]
    pub fn is_command(word: &str) -> bool {
        Self::commands().any(|command| command == word)
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

fn read_failsafe(mode: &str, silence: &str) -> Result<Request, RequestError> {
    let mode = find_mode(mode)?;
    let silence_s = silence.strip_suffix('s').unwrap_or(silence).parse();
    silence_s
        .ok()
        .map(|silence_s| Failsafe { silence_s, mode })
        .filter(Failsafe::is_valid)
        .map(|failsafe| Request::Failsafe(Some(failsafe)))
        .ok_or_else(|| RequestError::Failsafe(format!("{} {silence}", mode_word(mode))))
}

fn read_point(x: &str, y: &str) -> Result<Waypoint, RequestError> {
    let part = |word: &str| {
        word.parse()
            .map_err(|_| RequestError::Coordinate(word.to_owned()))
    };
    let (x_in, y_in) = (part(x)?, part(y)?);
    Waypoint::new(x_in, y_in).ok_or_else(|| RequestError::Coordinate(format!("{x} {y}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(words: &str) -> String {
        let words: Vec<&str> = words.split(' ').collect();
        let error = Request::all_from_words(&words).expect_err("it is wrong");
        error.to_string()
    }

    /// Whoever knows the word and says too much is not told that the word is unknown.
    #[test]
    fn a_known_command_with_a_word_too_many_is_called_by_its_name() {
        for command in Request::commands() {
            let told = error(&format!("{command} one too many words"));
            assert!(told.starts_with(&format!("`{command}` takes ")), "{told}");
        }
    }

    #[test]
    fn a_mistyped_word_is_answered_with_the_one_that_was_meant() {
        assert!(error("porwl").starts_with("unknown command `porwl`; did you mean `prowl`?"));
        assert!(error("mode hoem").contains("did you mean `home`?"));
        assert!(error("enable sonra").contains("did you mean `sonar`?"));
        assert!(error("preset mtoh").contains("did you mean `moth`?"));
    }

    /// What is near to a name that is known is asked about; what is not, the robot may know.
    #[test]
    fn a_mistyped_parameter_is_asked_about_and_can_be_insisted_on() {
        for words in [
            "param set top-sped 8",
            "param get top-sped",
            "param top-sped 8",
        ] {
            let told = error(words);
            assert!(told.contains("did you mean `top-speed`?"), "{told}");
            assert!(told.contains("`=top-sped`"), "{told}");
        }
        for (words, sent) in [
            ("param set =top-sped 8", "param set =top-sped 8"),
            ("param set =top-speed 8", "param set top-speed 8"),
            ("param get warp-speed", "param get warp-speed"),
            ("param get =warp-speed", "param get warp-speed"),
        ] {
            let split: Vec<&str> = words.split(' ').collect();
            let request = Request::from_words(&split).expect(words);
            assert_eq!(request.to_string(), sent);
        }
        assert!(error("param get =Top").contains("is no parameter's name"));
    }

    #[test]
    fn a_point_is_gone_to_at_once_when_that_is_said() {
        let went = Request::all_from_words(&["goto", "12", "-8", "--go"]);
        let list = Request::all_from_words(&["goto", "12", "-8"]).expect("a list of one");
        let both = [&list[..], &[Request::Mode(Mode::Prowl)]].concat();
        assert_eq!(went, Ok(both));
        assert!(error("goto 12 --go").contains("`--go` is not a whole number"));
    }

    #[test]
    fn what_is_missing_is_named() {
        assert!(error("param set top-speed").contains("`param get top-speed` says"));
        assert!(error("param set").contains("needs a name, as in `param set top-speed 8`"));
        assert!(error("param get").contains("needs a name"));
        let alone = error("param top-speed");
        assert!(alone.contains("`param get top-speed`"), "{alone}");
        assert!(alone.contains("`param top-speed VALUE`"), "{alone}");
        assert!(error("param top-sped").contains("did you mean `top-speed`?"));
    }

    #[test]
    fn a_mistyped_verb_of_parameters_is_asked_about() {
        for (words, meant) in [
            ("param gte top-speed", "get"),
            ("param ste top-speed 8", "set"),
            ("param lst", "list"),
            ("param svae", "save"),
        ] {
            let told = error(words);
            assert!(told.contains(&format!("did you mean `{meant}`?")), "{told}");
        }
        let forms = error("param one too many words");
        assert!(forms.contains("`NAME VALUE`"), "{forms}");
        let gets = Request::from_words(&["param", "gets", "8"]).expect("the robot may have it");
        assert_eq!(gets.to_string(), "param set gets 8");
    }

    /// There a word with `=` before it stands for the path of a program.
    #[test]
    fn what_zsh_would_take_for_something_else_is_quoted_for_a_shell() {
        let slip = Request::from_words(&["param", "get", "top-sped"]).expect_err("it is a slip");
        assert!(slip.to_string().ends_with("say `=top-sped`"), "{slip}");
        assert!(slip.in_shell().ends_with("say `'=top-sped'`"));
    }
}
