//! The list of commands in the dashboard.

/// Commands and their descriptions, in the order of the list. The dashboard replaces names in angle brackets by keys.
pub const LISTING: [(&str, &str); 22] = [
    ("stop", "motors off"),
    (
        "mode M",
        "prowl reactive passive wander home forage calibrate user",
    ),
    (
        "prowl reactive ..",
        "short for `mode ..`: passive, wander, home; dock is forage",
    ),
    (
        "enable L,L",
        "layers: user bumpers rotation ir sonar photo motion dr",
    ),
    ("disable L,L", "forbid these layers"),
    ("only L,L", "allow these and no others; or none"),
    (
        "preset P",
        "all sonar-only sonar-ir moth shy reactive passive wander",
    ),
    ("goto X Y", "one waypoint in inches; --go drives it"),
    (
        "route FILE",
        "load X,Y lines as a draft; <send-draft> sends it, --go drives it",
    ),
    ("clear", "delete the robot's route (asks)"),
    ("set-pose X Y DEG", "set the robot's pose (asks)"),
    ("reset-pose", "set the pose to 0 0 0 (asks)"),
    ("scan", "measure the distances all around"),
    (
        "failsafe M 30s",
        "mode after this time without frames; or off",
    ),
    (
        "param NAME VALUE",
        "set a parameter; also param list, get NAME, save",
    ),
    ("name TEXT", "name the run being recorded"),
    ("note TEXT", "add a note to the run"),
    ("void WHY", "mark the run void; `counts` undoes it"),
    (
        "runs FOLDER",
        "list runs; <runs-window/submit> on two compares them",
    ),
    ("compare A B", "compare the runs of two captures"),
    ("help", "show this list"),
    ("quit", "quit; the robot carries on"),
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
                    .split([' ', ',', ':', ';', '`'])
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
