//! The table of commands: source of errors, completion, the help of `send` and the list in the dashboard.

use super::RequestError;

/// The commands: form (the first word names the command), expected arguments for errors, and
/// description (empty if another row describes the command).
const COMMANDS: [(&str, &str, &str); 20] = [
    ("stop", "nothing", "switch off the motors in any state"),
    (
        "mode M",
        "one mode",
        "prowl reactive passive wander home dock calibrate user",
    ),
    ("prowl reactive ..", "nothing", "short for mode prowl etc."),
    ("reactive", "nothing", ""),
    ("passive", "nothing", ""),
    ("wander", "nothing", ""),
    ("home", "nothing", ""),
    ("dock", "nothing", ""),
    (
        "enable L,L",
        "layers separated by commas",
        "layers: user bumpers rotation ir sonar photo motion dr",
    ),
    (
        "disable L,L",
        "layers separated by commas",
        "forbid these layers",
    ),
    (
        "only L,L",
        "layers separated by commas, or `none`",
        "allow only these layers; `only none` forbids all",
    ),
    (
        "preset P",
        "the name of one group of commands",
        "all sonar-only sonar-ir moth shy reactive passive wander",
    ),
    (
        "goto X Y",
        "X and Y in inches",
        "one waypoint in inches; --go drives it",
    ),
    (
        "route FILE",
        "the name of one file of `X,Y` lines",
        "waypoints from a file of X,Y lines; --go drives them",
    ),
    ("clear", "nothing", "delete the route in the robot"),
    (
        "set-pose X Y DEG",
        "X and Y in inches and theta, 0 to 359 degrees",
        "set the robot's pose",
    ),
    ("reset-pose", "nothing", "set the pose to 0 0 0"),
    ("scan", "nothing", "measure the distances in all directions"),
    (
        "failsafe M 30s",
        "`off`, or a mode and the silence after which to enter it, like `home 30s`",
        "enter mode M after 30 s of silence; or off",
    ),
    (
        "param NAME VALUE",
        "`list`, `get NAME`, `set NAME VALUE`, `NAME VALUE` or `save`",
        "set a parameter; also list, get, save, save-to, load, diff",
    ),
];

/// Forms and descriptions of the commands of the dashboard itself; the description is empty if another row describes the command.
const DASHBOARD_COMMANDS: [(&str, &str); 15] = [
    (
        "wait until THIS",
        "tells when: mode home, driven, stopped, a field of a line",
    ),
    ("expect THIS", ""),
    (
        "plan home",
        "draft a route home; plan X Y; advise: accept suggestion",
    ),
    ("advise", ""),
    ("acknowledge", ""),
    (
        "shelve NAME 10m",
        "silence an alarm; unshelve NAME, acknowledge",
    ),
    ("unshelve", ""),
    (
        "name TEXT",
        "name the run being recorded; note TEXT adds a note",
    ),
    ("note", ""),
    ("void WHY", "mark the run void; counts undoes it"),
    ("counts", ""),
    ("runs FOLDER", "list runs; <runs-window/submit> replays one"),
    ("compare A B", "compare the runs of two captures"),
    ("help", ""),
    ("quit", "quit; a real robot continues"),
];

/// Forms and descriptions of the commands to the robot.
pub fn listing() -> impl Iterator<Item = (&'static str, &'static str)> {
    COMMANDS
        .into_iter()
        .filter(|(_, _, does)| !does.is_empty())
        .map(|(form, _, does)| (form, does))
}

/// Forms and descriptions of all commands in the dashboard, which replaces names in angle brackets by keys.
pub fn dashboard_listing() -> impl Iterator<Item = (&'static str, &'static str)> {
    let own = DASHBOARD_COMMANDS.into_iter();
    listing().chain(own.filter(|(_, does)| !does.is_empty()))
}

/// First words of the commands to the robot.
pub(super) fn words() -> impl Iterator<Item = &'static str> {
    COMMANDS.into_iter().map(|(form, ..)| first_word(form))
}

/// First words of the commands of the dashboard itself.
pub fn dashboard_commands() -> impl Iterator<Item = &'static str> {
    DASHBOARD_COMMANDS
        .into_iter()
        .map(|(form, _)| first_word(form))
}

/// Returns the description of the command with this first word; `None` where another row describes it.
#[must_use]
pub fn command_description(word: &str) -> Option<&'static str> {
    let mut all = dashboard_listing();
    let row = all.find(|(form, _)| first_word(form) == word && !form.ends_with(".."));
    row.map(|(_, does)| does)
}

/// The error for an unknown command or wrong arguments.
pub(super) fn wrong(command: &str, arguments: &[&str]) -> RequestError {
    COMMANDS
        .into_iter()
        .map(|(form, takes, _)| (first_word(form), takes))
        .find(|(known, _)| *known == command)
        .map_or_else(
            || RequestError::UnknownCommand(command.to_owned()),
            |(command, takes)| RequestError::Arguments {
                command,
                takes,
                got: arguments.join(" "),
            },
        )
}

fn first_word(form: &'static str) -> &'static str {
    form.split(' ').next().unwrap_or(form)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::preset_names;

    #[test]
    fn every_command_and_preset_is_listed() {
        let listed: Vec<&str> = listing()
            .flat_map(|(form, does)| [form, does])
            .flat_map(|text| text.split([' ', ',', ':', ';', '`']))
            .collect();
        for word in words().chain(preset_names()) {
            assert!(listed.contains(&word), "{word}");
        }
    }
}
