//! The command `plan`: the draft becomes a route over the floor that the robot has seen.

use groundwave_captures::words::counted;
use groundwave_protocol::Waypoint;

use super::ground::HOME_IN;
use super::{Facts, Ui};
use crate::event::{Effect, Level};
use crate::request::Request;

/// Form of the command, for its errors.
const FORM: &str = "`plan` takes `home`, or X and Y in inches: plan 96 40";

impl Ui {
    /// Carries out `plan home` and `plan X Y`; `None` for other commands.
    pub(super) fn plan(
        &mut self,
        facts: &Facts,
        words: &[&str],
    ) -> Option<Result<Vec<Effect>, String>> {
        let (_, to) = words.split_first().filter(|(verb, _)| **verb == "plan")?;
        Some(
            self.draft_planned(facts, &to.join(" "))
                .map(|()| Vec::new()),
        )
    }

    fn draft_planned(&mut self, facts: &Facts, to: &str) -> Result<(), String> {
        let most = facts.robot.list_capacity();
        if most == 0 {
            return Err("this robot takes no routes".to_owned());
        }
        let target_in = destination_in(to)?;
        let route = facts.ground.route(target_in, most);
        let route = route.map_err(|reason| format!("no route planned: {reason}"))?;
        let count = counted(route.waypoints.len() as u64, "waypoint");
        let mut parts = vec![
            format!("plan {to}: {count} drafted"),
            format!("{:.0} in", route.length_in),
        ];
        if route.unknown_in >= 1.0 {
            parts.push(format!("{:.0} in unseen", route.unknown_in));
        }
        if route.short_in >= 1.0 {
            parts.push(format!("ends {:.0} in short", route.short_in));
        }
        let text = parts.join(", ") + &self.with_keys("; <send-draft> sends them");
        self.note(Level::Info, text);
        self.map.take_draft(&route.waypoints);
        self.automatic.take_planned(to, target_in, route.waypoints);
        self.show_selected();
        Ok(())
    }
}

/// The true point that words name, inches.
fn destination_in(to: &str) -> Result<(f64, f64), String> {
    let point: Vec<&str> = to
        .split([',', ' '])
        .filter(|word| !word.is_empty())
        .collect();
    match point[..] {
        ["home"] => Ok(HOME_IN),
        [x, y] => match Request::from_words(&["goto", x, y]) {
            Ok(Request::Route(waypoints)) if waypoints.len() == 1 => {
                let Waypoint { x_in, y_in } = waypoints[0];
                Ok((f64::from(x_in), f64::from(y_in)))
            }
            Err(error) => Err(error.to_string()),
            Ok(_) => Err(FORM.to_owned()),
        },
        _ => Err(FORM.to_owned()),
    }
}
