//! The robot's failsafe: the mode that the robot enters when the ground station is silent.

use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::Link;

use super::ledger::Ledger;
use super::robot::Robot;
use super::words;
use crate::event::Level;

/// The setting in the latest line C, or of a later confirmed command.
fn setting(link: Link, robot: &Robot, ledger: &Ledger) -> Option<Failsafe> {
    let reported = robot.counters.and_then(|counters| counters.value.failsafe);
    match ledger.failsafe() {
        Some((Some(at), setting)) if robot.counters.is_none_or(|c| c.at <= at) => setting,
        // The line that confirms a command is the first to show its effect.
        Some((None, setting)) if link != Link::Ok && reported.is_none() => setting,
        _ => reported,
    }
}

/// The setting as text: "home after 30 s of silence".
fn words_of(setting: Option<Failsafe>) -> String {
    match setting {
        Some(Failsafe { silence_s, mode }) => {
            format!("{} after {silence_s} s of silence", words::mode(mode))
        }
        // Line A arrives first; line C arrives every four seconds.
        None => "setting not known yet".to_owned(),
    }
}

/// Describes the state in the latest line A; `None` if the failsafe is not set or unknown.
pub(crate) fn standing(robot: &Robot, ledger: &Ledger) -> Option<(Link, String)> {
    let link = robot.state.map_or(Link::Ok, |state| state.value.link);
    let setting = setting(link, robot, ledger);
    let does = words_of(setting);
    match link {
        Link::Ok => setting.map(|_| (link, format!("{does}, once a session is open"))),
        Link::Armed => Some((link, format!("{does}, armed"))),
        Link::Failsafe => Some((link, format!("ACTS: {does}"))),
    }
}

/// The log line for a change of line A's link letter.
pub(super) fn news(
    before: Option<Link>,
    now: Link,
    robot: &Robot,
    ledger: &Ledger,
) -> Option<(Level, String)> {
    let does = || words_of(setting(now, robot, ledger));
    match (before.unwrap_or(Link::Ok), now) {
        (before, now) if before == now => None,
        (_, Link::Failsafe) => Some((Level::Alarm, format!("FAILSAFE acts: {}", does()))),
        (Link::Failsafe, Link::Armed) => Some((
            Level::Warning,
            "failsafe is over, and armed again".to_owned(),
        )),
        (Link::Failsafe, _) => Some((Level::Warning, "failsafe is over".to_owned())),
        (_, Link::Armed) => Some((Level::Info, format!("failsafe armed: {}", does()))),
        (_, Link::Ok) => Some((Level::Info, "failsafe no longer armed".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use groundwave_protocol::status_codes::Mode;

    use super::*;
    use crate::event::CommandStatus;
    use crate::model::Config;
    use crate::model::log::Entry;
    use crate::model::testing::Scene;
    use crate::request::Request;

    #[test]
    fn every_entry_and_exit_is_in_the_log() {
        let mut scene = Scene::new(Config::default());
        scene.hear();
        let standing_of = |scene: &Scene| {
            let facts = &scene.model.facts;
            standing(&facts.robot, &facts.ledger)
        };
        assert_eq!(standing_of(&scene), None);
        scene.failsafe = Some(Failsafe {
            silence_s: 30,
            mode: Mode::GoHome,
        });
        scene.hear_ticks(10, [0; 9]);
        let standing_now = |scene: &Scene| standing_of(scene).map(|(_, says)| says);
        assert_eq!(
            standing_now(&scene).as_deref(),
            Some("home after 30 s of silence, once a session is open")
        );
        for link in [Link::Armed, Link::Armed, Link::Failsafe, Link::Failsafe] {
            scene.state.link = link;
            scene.hear();
        }
        assert_eq!(
            standing_now(&scene).as_deref(),
            Some("ACTS: home after 30 s of silence")
        );
        for link in [Link::Armed, Link::Failsafe, Link::Ok] {
            scene.state.link = link;
            scene.hear();
        }
        let logged = scene.model.facts.log.newest_first();
        let mut logged: Vec<(Level, &str)> = logged
            .map(|entry| (entry.level, entry.text.as_str()))
            .filter(|(_, text)| text.to_lowercase().contains("failsafe"))
            .collect();
        logged.reverse();
        let acts = (Level::Alarm, "FAILSAFE acts: home after 30 s of silence");
        assert_eq!(
            logged,
            [
                (Level::Info, "failsafe armed: home after 30 s of silence"),
                acts,
                (Level::Warning, "failsafe is over, and armed again"),
                acts,
                (Level::Warning, "failsafe is over"),
            ]
        );
    }

    #[test]
    fn a_confirmed_setting_is_known_before_line_c() {
        let mut scene = Scene::new(Config::default());
        scene.hear_ticks(10, [0; 9]);
        let setting = Some(Failsafe {
            silence_s: 30,
            mode: Mode::GoHome,
        });
        scene.ask(1, Request::Failsafe(setting));
        // The line that confirms the command comes first.
        scene.state.link = Link::Armed;
        scene.hear();
        scene.status_of(1, CommandStatus::Confirmed { digest: None });
        let facts = &scene.model.facts;
        let mut logged = facts.log.newest_first().map(|entry| entry.text.as_str());
        let armed = "failsafe armed: home after 30 s of silence";
        assert!(logged.any(|text| text == armed));
        let says = standing(&facts.robot, &facts.ledger).map(|(_, says)| says);
        assert_eq!(
            says.as_deref(),
            Some("home after 30 s of silence, armed"),
            "line C is older"
        );
    }

    #[test]
    fn late_station_logs_an_acting_failsafe() {
        let mut scene = Scene::new(Config::default());
        scene.state.link = Link::Failsafe;
        scene.hear();
        let mut logged = scene.model.facts.log.newest_first();
        let entry = logged.find(|entry| entry.level == Level::Alarm);
        assert!(entry.is_some_and(Entry::is_news));
    }
}
