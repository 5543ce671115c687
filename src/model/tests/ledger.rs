//! Claims of the ledger about commands.

use super::*;
use crate::request::Tuning;

#[test]
fn the_acknowledged_list_is_active_until_the_robot_reports_another() {
    let list = Request::Route(route(&[(1, 2), (3, 4)]));
    let mut scene = scene();
    let active = |scene: &Scene| {
        scene
            .model
            .facts
            .ledger
            .active()
            .map(|a| (a.digest, a.driven))
    };
    scene.ask(1, list.clone());
    for status in [
        CommandStatus::Sent { frames: 1 },
        CommandStatus::Progress {
            acknowledged: 2,
            total: 2,
        },
    ] {
        scene.status_of(1, status);
        assert_eq!(active(&scene), None, "delivered is not active");
    }
    scene.status_of(1, CommandStatus::Confirmed { digest: Some(7) });
    assert_eq!(active(&scene), Some((7, None)), "active is not driven");
    scene.status.digest = 7;
    scene.status.list = ListPlace {
        driven: 1,
        count: 2,
    };
    scene.hear_status();
    assert_eq!(active(&scene), Some((7, Some(scene.status.list))));
    scene.status.digest = 8;
    scene.hear_status();
    assert_eq!(active(&scene), None, "another list is driven");

    scene.command(2, list, CommandStatus::Confirmed { digest: Some(9) });
    assert_eq!(active(&scene), Some((9, None)));
    scene.ack.boot = 1;
    scene.hear();
    assert_eq!(active(&scene), None, "the robot restarted");
}

/// The line that confirms a mode was begun before the robot entered it.
#[test]
fn a_confirmed_mode_is_the_mode_until_the_next_line_a() {
    let mut scene = scene();
    scene.state.mode = Mode::Prowl;
    scene.hear();
    let mode = |scene: &Scene| scene.model.facts.robot.mode();
    assert_eq!(mode(&scene), Some(Mode::Prowl));
    scene.ask(1, Request::Stop);
    scene.status_of(1, CommandStatus::Sent { frames: 1 });
    assert_eq!(mode(&scene), Some(Mode::Prowl), "sent is not confirmed");
    scene.status_of(1, CommandStatus::Confirmed { digest: None });
    assert_eq!(mode(&scene), Some(Mode::Stop));
    scene.hear_status();
    assert_eq!(mode(&scene), Some(Mode::Stop), "a line B has no mode");
    scene.hear();
    assert_eq!(mode(&scene), Some(Mode::Prowl), "the robot's word counts");
    scene.command(
        2,
        Request::Mode(Mode::GoHome),
        CommandStatus::Confirmed { digest: None },
    );
    assert_eq!(mode(&scene), Some(Mode::GoHome));
}

#[test]
fn a_command_of_a_client_names_the_client() {
    let mut scene = scene();
    let (id, by) = (CommandId(1), "pid 7".to_owned());
    scene.event(Event::Asked {
        id,
        request: Request::Scan,
        by: Some(by.clone()),
    });
    let entry = scene.model.facts.ledger.entries().next();
    assert_eq!(entry.and_then(|entry| entry.by.clone()), Some(by.clone()));
    let newest = scene.model.facts.log.newest_first().next();
    assert_eq!(
        newest.map(|entry| entry.text.clone()),
        Some(format!("scan: asked by {by}"))
    );
}

#[test]
fn a_list_of_parameters_does_not_hide_commands_that_overtake_it() {
    let mut scene = scene();
    let newest = |scene: &Scene| {
        let newest = scene.model.facts.ledger.newest();
        newest.map(|entry| entry.request.to_string())
    };
    scene.ask(1, Request::Parameter(Tuning::List));
    scene.ask(2, Request::Scan);
    scene.now += Moment::from_secs(1);
    scene.status_of(1, CommandStatus::Sent { frames: 1 });
    assert_eq!(newest(&scene).as_deref(), Some("scan"));
    scene.status_of(2, CommandStatus::Confirmed { digest: None });
    scene.now += Moment::from_secs(1);
    scene.status_of(1, CommandStatus::Sent { frames: 2 });
    assert_eq!(newest(&scene).as_deref(), Some("param list"));
}
