//! Commands to the robot, as typed on the command line, in scripts and in the dashboard.

mod amount;
mod commands;
pub mod completion;
mod parameters;
mod preset;
mod refusal;
#[cfg(test)]
pub(crate) mod testing;
mod tuning;
mod words;

use std::fmt;
use std::time::Duration;

pub use amount::{Amount, in_whole_unit, unit_words};
pub use commands::{command_description, dashboard_commands, dashboard_listing, listing};
pub use groundwave_captures::words::{layer_word, mode_word, outcome_words};
pub use parameters::{default_of as known_default, known as known_parameters};
pub use preset::names as preset_names;
pub use refusal::Standing;
pub use tuning::Tuning;

use groundwave_protocol::failsafe::{Failsafe, SILENCE_MAX_S, SILENCE_MIN_S};
use groundwave_protocol::parameter::{NAME_BYTES, VALUE_MAX};
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::{WAYPOINT_LIMIT_IN, WAYPOINTS_MAX, Waypoint};

use crate::suggest;
use words::{find_mode, layer_words, read_layers, read_mode};

/// A command to the robot, not yet encoded as frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Switch the motors off.
    Stop,
    /// Enter a mode.
    Mode(Mode),
    /// Allow these layers, in addition to the allowed ones.
    Enable(LayerMask),
    /// Forbid these layers.
    Disable(LayerMask),
    /// Allow exactly these layers.
    Only(LayerMask),
    /// Replace the robot's route; an empty route clears it.
    Route(Vec<Waypoint>),
    /// Set the robot's pose.
    Pose {
        /// Position.
        position: Waypoint,
        /// Heading, 0 to 359 degrees.
        theta_deg: u16,
    },
    /// Measure the distances all around.
    Scan,
    /// Set the mode that the robot enters when the ground is silent; `None` switches the failsafe off.
    Failsafe(Option<Failsafe>),
    /// Read, change or save the robot's parameters.
    Parameter(Tuning),
    /// A command string of the configuration: name and arguments, separated by spaces.
    Own(String),
}

/// The robot's parameter that switches its cliff guard on and off.
pub(crate) const CLIFF_GUARD: &str = "cliff-guard";

/// The robot's parameter for the voltage of a critical battery; 0 switches the protection off.
pub(crate) const CRITICAL_BATTERY: &str = "battery-critical";

/// Reason why words are not a command.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// No words were given.
    #[error("no command given; try `mode prowl`, `goto 48 0` or `stop`")]
    Empty,
    /// An unknown first word.
    #[error("unknown command `{0}`{near}", near = hint(.0, "commands", commands::words()))]
    UnknownCommand(String),
    /// An unknown first word, for a robot with these command strings.
    #[error("unknown command `{0}`{near}", near = hint(.0, "the robot's commands", .1.iter().map(String::as_str)))]
    UnknownOwn(String, Vec<String>),
    /// Wrong arguments.
    #[error("`{command}` takes {takes}; got {}", if got.is_empty() { "nothing".to_owned() } else { format!("`{got}`") })]
    Arguments {
        /// The command.
        command: &'static str,
        /// The expected arguments.
        takes: &'static str,
        /// The given arguments.
        got: String,
    },
    /// An unknown layer.
    #[error("unknown layer `{0}`{near}", near = hint(.0, "layers", Layer::ALL.into_iter().map(layer_word)))]
    UnknownLayer(String),
    /// An unknown mode.
    #[error("unknown mode `{0}`{near}", near = hint(.0, "modes", Mode::ALL.iter().copied().map(mode_word)))]
    UnknownMode(String),
    /// A coordinate that is not a number or out of range.
    #[error(
        "`{0}` is not a whole number of inches from -{WAYPOINT_LIMIT_IN} to {WAYPOINT_LIMIT_IN}"
    )]
    Coordinate(String),
    /// A silence or a mode that no robot accepts.
    #[error(
        "`failsafe {0}`: the silence must be {SILENCE_MIN_S} to {SILENCE_MAX_S} seconds, and the mode one without an operator; try `failsafe home 30s`"
    )]
    Failsafe(String),
    /// The word is not a valid parameter name.
    #[error(
        "`{0}` is not a parameter name (1 to {NAME_BYTES} lower case letters, digits and hyphens); `param list` shows the names"
    )]
    ParameterName(String),
    /// The name is unknown but similar to a known parameter.
    #[error(
        "unknown parameter `{0}`; did you mean `{1}`? If the robot has a parameter of that name, write `={0}`"
    )]
    ParameterUnknown(String, &'static str),
    /// The word is not a valid parameter value.
    #[error(
        "`{0}` is not a parameter value; write a whole number from -{VALUE_MAX} to {VALUE_MAX}, or one like 11.6 in the whole unit"
    )]
    ParameterValue(String),
    /// The name of the parameter is missing.
    #[error("`param {0}` needs a name, as in `param {0} {1}`; `param list` shows the names")]
    ParameterMissing(&'static str, &'static str),
    /// The subcommand is unknown but similar to a subcommand of `param`.
    #[error("`param` has no `{0}`; did you mean `{1}`?")]
    ParameterVerb(String, &'static str),
    /// Only the name of a parameter was given.
    #[error(
        "`param {0}` is incomplete: `param get {0}` shows the value, `param {0} VALUE` changes it"
    )]
    ParameterAlone(String),
    /// The value of the parameter is missing.
    #[error(
        "`param set {0}` needs a value; `param get {0}` shows the current value and the limits"
    )]
    ValueMissing(String),
    /// An unknown preset.
    #[error("unknown preset `{0}`{near}", near = hint(.0, "presets", preset_names()))]
    UnknownPreset(String),
    /// Too many waypoints for the robot's memory.
    #[error("{0} waypoints; the robot holds {WAYPOINTS_MAX}")]
    TooManyWaypoints(usize),
}

impl RequestError {
    /// The message with words quoted for a shell: zsh reads `=word` as the path of a program.
    #[must_use]
    pub fn in_shell(&self) -> String {
        let message = self.to_string();
        match self {
            Self::ParameterUnknown(name, _) => {
                message.replace(&format!("`={name}`"), &format!("`'={name}'`"))
            }
            _ => message,
        }
    }
}

/// A hint: the most similar known word, or all of them.
fn hint<'a>(word: &str, what: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.collect();
    let all = format!("{what} are {}", known.join(", "));
    suggest::question_or(word, known, all)
}

impl Request {
    /// Parses the words of a command; `preset` stands for several commands.
    ///
    /// # Errors
    /// The error names the wrong word and the valid ones.
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

    /// Parses the words of one command, except for `route`: the caller reads its file with [`crate::route`].
    ///
    /// # Errors
    /// The error names the wrong word and the valid ones.
    pub fn from_words<S: AsRef<str>>(words: &[S]) -> Result<Self, RequestError> {
        // A script or a shell may give empty words.
        let words = words.iter().map(AsRef::as_ref);
        let words: Vec<&str> = words.filter(|word| !word.trim().is_empty()).collect();
        let (&command, arguments) = words.split_first().ok_or(RequestError::Empty)?;
        let wrong = || commands::wrong(command, arguments);
        match (command, arguments) {
            ("stop" | "STOP", []) => Ok(Self::Stop),
            ("mode", [mode]) => read_mode(mode),
            ("prowl" | "reactive" | "passive" | "wander" | "home", []) => read_mode(command),
            ("dock", []) => Ok(Self::Mode(Mode::Forage)),
            ("only", ["none"]) => Ok(Self::Only(LayerMask::NONE)),
            ("only", [layers]) => Ok(Self::Only(read_layers(layers)?)),
            ("param", words) => Tuning::from_words(words).map(Self::Parameter),
            ("enable", [layers]) => Ok(Self::Enable(read_layers(layers)?)),
            ("disable", [layers]) => Ok(Self::Disable(read_layers(layers)?)),
            ("goto", [x, y]) => Ok(Self::Route(vec![read_point(x, y)?])),
            ("clear", []) => Ok(Self::Route(Vec::new())),
            ("set-pose", [x, y, theta]) => Ok(Self::Pose {
                position: read_point(x, y)?,
                theta_deg: theta
                    .parse()
                    .ok()
                    .filter(|theta| *theta < 360)
                    .ok_or_else(wrong)?,
            }),
            ("reset-pose", []) => Ok(Self::Pose {
                position: Waypoint::default(),
                theta_deg: 0,
            }),
            ("scan", []) => Ok(Self::Scan),
            ("failsafe", ["off"]) => Ok(Self::Failsafe(None)),
            ("failsafe", [mode, silence]) => read_failsafe(mode, silence),
            _ => Err(wrong()),
        }
    }

    /// Parses the words of a command for a robot with command strings of these names. They take precedence over other commands.
    ///
    /// # Errors
    /// The error names the wrong word and the valid ones.
    pub fn all_from_words_or_own<S: AsRef<str>>(
        words: &[S],
        own: &[String],
    ) -> Result<Vec<Self>, RequestError> {
        let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
        match words.first() {
            Some(&"stop") => Self::all_from_words(&words),
            Some(name) if own.iter().any(|known| known == name) => {
                Ok(vec![Self::Own(words.join(" "))])
            }
            _ => Self::all_from_words(&words).map_err(|error| match error {
                RequestError::UnknownCommand(word) if !own.is_empty() => {
                    RequestError::UnknownOwn(word, own.to_vec())
                }
                error => error,
            }),
        }
    }

    /// Time within which the robot should confirm the command. Listing all parameters takes half a minute at 2400 baud, two
    /// with an HC-12 or with bit errors.
    #[must_use]
    pub const fn default_timeout(&self) -> Duration {
        match self {
            Self::Parameter(Tuning::List) => Duration::from_mins(5),
            _ => Duration::from_secs(20),
        }
    }

    /// Returns the mode that the command orders.
    #[must_use]
    pub const fn mode(&self) -> Option<Mode> {
        match self {
            Self::Stop => Some(Mode::Stop),
            Self::Mode(mode) => Some(*mode),
            _ => None,
        }
    }

    /// The first words of all commands.
    pub fn commands() -> impl Iterator<Item = &'static str> {
        commands::words()
    }

    /// Whether `word` is the first word of a command.
    #[must_use]
    pub fn is_command(word: &str) -> bool {
        Self::commands().any(|command| command == word)
    }

    /// Whether the dashboard asks before it sends the command.
    #[must_use]
    pub fn is_hazardous(&self) -> bool {
        match self {
            Self::Pose { .. } | Self::Mode(Mode::User) => true,
            Self::Route(waypoints) => waypoints.is_empty(),
            Self::Stop
            | Self::Mode(_)
            | Self::Enable(_)
            | Self::Disable(_)
            | Self::Only(_)
            | Self::Scan
            | Self::Failsafe(_)
            | Self::Parameter(_)
            | Self::Own(_) => self.turns_off().is_some(),
        }
    }

    /// The protection of the robot that the command turns off.
    #[must_use]
    pub fn turns_off(&self) -> Option<&'static str> {
        match self {
            Self::Disable(layers) if layers.contains(Layer::Bumpers) => Some("its bumpers"),
            Self::Only(layers) if !layers.contains(Layer::Bumpers) => Some("its bumpers"),
            Self::Failsafe(None) => Some("its failsafe"),
            Self::Parameter(Tuning::Set(name, value)) if value.is_zero() => match name.as_str() {
                CLIFF_GUARD => Some("its cliff guard"),
                CRITICAL_BATTERY => Some("its stop at a critical battery"),
                _ => None,
            },
            Self::Stop
            | Self::Mode(_)
            | Self::Enable(_)
            | Self::Disable(_)
            | Self::Only(_)
            | Self::Route(_)
            | Self::Pose { .. }
            | Self::Scan
            | Self::Failsafe(_)
            | Self::Parameter(_)
            | Self::Own(_) => None,
        }
    }

    /// A command with this route.
    ///
    /// # Errors
    /// If the route has more waypoints than the robot holds.
    pub fn route(waypoints: Vec<Waypoint>) -> Result<Self, RequestError> {
        if waypoints.len() > WAYPOINTS_MAX {
            return Err(RequestError::TooManyWaypoints(waypoints.len()));
        }
        Ok(Self::Route(waypoints))
    }
}

/// Writes the words that [`Request::from_words`] parses to the same command. Captures, scripts and the shared link rely on this;
/// a route of several waypoints is an exception: they store its points.
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
            Self::Own(words) => f.write_str(words),
            Self::Route(waypoints) => match waypoints[..] {
                [] => f.write_str("clear"),
                [Waypoint { x_in, y_in }] => write!(f, "goto {x_in} {y_in}"),
                _ => write!(f, "route of {}", waypoints.len()),
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

    #[test]
    fn empty_words_are_no_words() {
        assert_eq!(error(""), RequestError::Empty.to_string());
        assert!(
            error("goto 1 ").ends_with("got `1`"),
            "{}",
            error("goto 1 ")
        );
        assert!(
            !error("param get ").contains("``"),
            "{}",
            error("param get ")
        );
    }

    #[test]
    fn commands_that_take_a_protection_away_are_hazardous() {
        for (words, turns_off) in [
            ("disable bumpers,sonar", true),
            ("disable sonar", false),
            ("only sonar", true),
            ("only none", true),
            ("only bumpers,sonar", false),
            ("failsafe off", true),
            ("failsafe home 30s", false),
            ("param set cliff-guard 0", true),
            ("param cliff-guard 0.0", true),
            ("param set cliff-guard 1", false),
            ("param set battery-critical 0", true),
            ("param set photo-avoid 0", false),
        ] {
            let split: Vec<&str> = words.split(' ').collect();
            let request = Request::from_words(&split).expect(words);
            assert_eq!(request.turns_off().is_some(), turns_off, "{words}");
            assert_eq!(request.is_hazardous(), turns_off, "{words}");
        }
    }

    #[test]
    fn too_many_words_are_reported_with_the_arguments_of_the_command() {
        for command in Request::commands() {
            let message = error(&format!("{command} one too many words"));
            let start = format!("`{command}` takes ");
            assert!(message.starts_with(&start), "{message}");
        }
    }

    #[test]
    fn words_of_a_command_parse_to_it() {
        for request in testing::samples() {
            let words = request.to_string();
            let split: Vec<&str> = words.split(' ').collect();
            assert!(Request::is_command(split[0]), "{words}");
            let is_file = matches!(&request, Request::Route(waypoints) if waypoints.len() > 1);
            let parsed = Request::from_words(&split).ok();
            assert_eq!(parsed, (!is_file).then_some(request), "{words}");
        }
    }

    #[test]
    fn mistyped_words_get_a_suggestion() {
        assert!(error("porwl").starts_with("unknown command `porwl`; did you mean `prowl`?"));
        assert!(error("mode hoem").contains("did you mean `home`?"));
        assert!(error("enable sonra").contains("did you mean `sonar`?"));
        assert!(error("preset mtoh").contains("did you mean `moth`?"));
    }

    /// A name unlike all known names is passed on, because the robot may know it.
    #[test]
    fn mistyped_parameters_get_a_suggestion_unless_written_with_an_equals_sign() {
        for words in [
            "param set top-sped 8",
            "param get top-sped",
            "param top-sped 8",
        ] {
            let message = error(words);
            assert!(message.contains("did you mean `top-speed`?"), "{message}");
            assert!(message.contains("`=top-sped`"), "{message}");
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
        assert!(error("param get =Top").contains("is not a parameter name"));
    }

    #[test]
    fn goto_with_go_also_enters_mode_prowl() {
        let parsed = Request::all_from_words(&["goto", "12", "-8", "--go"]);
        let list = Request::all_from_words(&["goto", "12", "-8"]).expect("a list of one");
        let both = [&list[..], &[Request::Mode(Mode::Prowl)]].concat();
        assert_eq!(parsed, Ok(both));
        assert!(error("goto 12 --go").contains("`--go` is not a whole number"));
    }

    #[test]
    fn incomplete_param_commands_name_the_missing_word() {
        assert!(error("param set top-speed").contains("`param get top-speed` shows"));
        assert!(error("param set").contains("needs a name, as in `param set top-speed 8`"));
        assert!(error("param get").contains("needs a name"));
        let alone = error("param top-speed");
        assert!(alone.contains("`param get top-speed`"), "{alone}");
        assert!(alone.contains("`param top-speed VALUE`"), "{alone}");
        assert!(error("param top-sped").contains("did you mean `top-speed`?"));
    }

    #[test]
    fn mistyped_subcommands_of_param_get_a_suggestion() {
        for (words, meant) in [
            ("param gte top-speed", "get"),
            ("param ste top-speed 8", "set"),
            ("param lst", "list"),
            ("param svae", "save"),
        ] {
            let message = error(words);
            let suggestion = format!("did you mean `{meant}`?");
            assert!(message.contains(&suggestion), "{message}");
        }
        let forms = error("param one too many words");
        assert!(forms.contains("`NAME VALUE`"), "{forms}");
        let gets = Request::from_words(&["param", "gets", "8"]).expect("the robot may have it");
        assert_eq!(gets.to_string(), "param set gets 8");
    }

    #[test]
    fn word_with_an_equals_sign_is_quoted_for_zsh() {
        let error = Request::from_words(&["param", "get", "top-sped"]).expect_err("mistyped");
        assert!(error.to_string().ends_with("write `=top-sped`"), "{error}");
        assert!(error.in_shell().ends_with("write `'=top-sped'`"));
    }
}
