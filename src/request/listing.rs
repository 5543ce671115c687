//! What every command is for, as the dashboard lists it.

/// The words of commands and what they are for, in the order of the list; keys by the names that they have in the
/// configuration, as the dashboard fills them in.
pub const LISTING: [(&str, &str); 22] = [
    ("stop", "motors off"),
    (
        "mode M",
        "prowl reactive passive wander home forage calibrate user",
    ),
    (
        "prowl reactive ..",
        "a mode in one word: passive, wander, home; dock is forage",
    ),
    (
        "enable L,L",
        "layers: user bumpers rotation ir sonar photo motion dr",
    ),
    ("disable L,L", "forbid them"),
    ("only L,L", "allow these and no others; or none"),
    (
        "preset P",
        "all sonar-only sonar-ir moth shy reactive passive wander",
    ),
    (
        "goto X Y",
        "one waypoint, inches; with --go it prowls there at once",
    ),
    (
        "route FILE",
        "load X,Y lines as the draft; <send-draft> sends it, --go drives it",
    ),
    ("clear", "empty the robot's list (asks)"),
    ("set-pose X Y DEG", "tell the robot where it is (asks)"),
    ("reset-pose", "the same for 0 0 0 (asks)"),
    ("scan", "look around once"),
    (
        "failsafe M 30s",
        "a mode after so long without a word from here; or off",
    ),
    (
        "param NAME VALUE",
        "set it; also param list, get NAME, save",
    ),
    ("name TEXT", "call the run that is being recorded"),
    ("note TEXT", "add a note to it"),
    ("void WHY", "it does not count; counts takes that back"),
    (
        "runs FOLDER",
        "list the runs there, or beside this one; <runs-window/submit> on two",
    ),
    (
        "compare A B",
        "lay the runs of two captures over each other",
    ),
    ("help", "this list"),
    ("quit", "leave; the robot carries on"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::{Request, preset_names};

    #[test]
    fn every_command_and_preset_is_listed() {
        let listed: Vec<String> = LISTING
            .iter()
            .flat_map(|(words, does)| {
                format!("{words} {does}")
                    .split([' ', ',', ':', ';'])
                    .map(str::to_owned)
                    .collect::<Vec<_>>()
            })
            .collect();
        let presets: Vec<&str> = preset_names().collect();
        for word in Request::commands().chain(presets) {
            assert!(listed.iter().any(|listed| listed == word), "{word}");
        }
    }
}
