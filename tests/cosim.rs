//! Commands over many seeds: a confirmed command has arrived, is kept by the robot, and is executed.

use std::collections::HashSet;

use crate::common::{CoSimulation, Rng, on_all_cores, seeds};
use groundwave::event::{CommandStatus, Failure, LinkEvent};
use groundwave::request::Request;
use groundwave_protocol::Waypoint;
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};

const SEEDS: u64 = 20;

/// A perfect radio, and one that damages every second line.
const CHANNELS: [&str; 2] = ["", "ber=1e-3"];

const CONFIRMED: CommandStatus = CommandStatus::Confirmed { digest: None };

/// Runs a property over all seeds and channels.
fn over_seeds(property: impl Fn(u64, &str) + Sync) {
    on_all_cores(seeds(SEEDS), |seed| {
        for channel in CHANNELS {
            property(seed, channel);
        }
    });
}

#[test]
fn a_mode_change_arrives() {
    over_seeds(|seed, channel| {
        let mut co = CoSimulation::new("house", seed, channel);
        assert_eq!(
            co.deliver(Request::Mode(Mode::Reactive)),
            CONFIRMED,
            "{}",
            co.context()
        );
        assert_eq!(
            co.simulation.robot().mode(),
            Mode::Reactive,
            "{}",
            co.context()
        );
        co.run_until("line A reports the mode", 60, |co| {
            co.modes.last() == Some(&Mode::Reactive)
        });
    });
}

#[test]
fn a_layer_is_switched_off_and_on_and_the_others_stay() {
    over_seeds(|seed, channel| {
        let mut co = CoSimulation::new("house", seed, channel);
        let sonar = LayerMask::NONE.with(Layer::Sonar);
        assert_eq!(
            co.deliver(Request::Disable(sonar)),
            CONFIRMED,
            "{}",
            co.context()
        );
        let without = co.simulation.robot().allowed();
        assert!(!without.contains(Layer::Sonar), "{}", co.context());
        assert_eq!(
            co.deliver(Request::Enable(sonar)),
            CONFIRMED,
            "{}",
            co.context()
        );
        assert_eq!(
            co.simulation.robot().allowed(),
            without.with(Layer::Sonar),
            "{}",
            co.context()
        );
    });
}

#[test]
fn a_route_of_forty_waypoints_is_held_exactly_and_driven() {
    over_seeds(|seed, channel| {
        let mut co = CoSimulation::new("open-room", seed, channel);
        let route = zigzag(seed);
        let wanted = digest(route.iter());
        assert_eq!(
            co.deliver(Request::Route(route.clone())),
            CommandStatus::Confirmed {
                digest: Some(wanted)
            },
            "{}",
            co.context()
        );
        assert_eq!(
            co.simulation.robot().lists().active(),
            route,
            "{}",
            co.context()
        );
        co.run_until("line B says that the list is driven", 600, |co| {
            co.list == Some((40, 40, wanted))
        });
        co.run_until("the robot stops at its end", 10, |co| {
            co.simulation.robot().mode() == Mode::Stop
        });
    });
}

/// Forty random points near the start.
fn zigzag(seed: u64) -> Vec<Waypoint> {
    let mut rng = Rng(seed);
    let mut part = || rng.below(41) as i16 - 20;
    (0..40)
        .map(|_| Waypoint {
            x_in: part(),
            y_in: part(),
        })
        .collect()
}

#[test]
fn no_two_seeds_draw_the_same_route() {
    let routes: HashSet<u32> = (0..SEEDS).map(|seed| digest(zigzag(seed).iter())).collect();
    assert_eq!(routes.len() as u64, SEEDS);
}

/// A command without a link is not sent, and not said to be; one that still waits when the link is open again arrives.
#[test]
fn a_command_waits_for_a_lost_link_and_is_given_up_unsent() {
    over_seeds(|seed, channel| {
        let mut co = CoSimulation::new("house", seed, channel);
        co.run(2);
        let lost = LinkEvent::Lost {
            reason: "unplugged".to_owned(),
        };
        co.station.handle_link(co.now(), lost);
        let begun = co.now();
        let mode = co.request(Request::Mode(Mode::Reactive));
        let give_up = |co: &mut CoSimulation, id| {
            while co.fate(id).is_none() {
                let at = co.station.poll_timeout();
                let at = at.unwrap_or_else(|| panic!("it ends: {}", co.context()));
                co.station.handle_timeout(at);
                assert_eq!(co.station.poll_transmit(at), None, "{}", co.context());
                while let Some(event) = co.station.poll_event() {
                    co.take_event(at, event);
                }
            }
            co.fate(id)
        };
        let not_sent = Some(CommandStatus::Failed(Failure::NotSent));
        assert_eq!(give_up(&mut co, mode), not_sent, "{}", co.context());
        let stop = co.station.handle_request(begun, Request::Stop, None);
        assert_eq!(give_up(&mut co, stop), not_sent, "{}", co.context());

        let waiting = co.request(Request::Mode(Mode::Reactive));
        let opened = LinkEvent::Opened {
            name: "radio".to_owned(),
            can_send: true,
        };
        co.station.handle_link(co.now(), opened);
        co.run_until("the command arrives", 60, |co| co.fate(waiting).is_some());
        assert_eq!(co.fate(waiting), Some(CONFIRMED), "{}", co.context());
    });
}

/// A STOP of an operator is sent as soon as the robot is there again, however late; other commands are not, because another station may have
/// stopped the robot meanwhile.
#[test]
fn a_stop_of_an_operator_outlives_a_lost_link() {
    over_seeds(|seed, channel| {
        let mut co = CoSimulation::new("house", seed, channel);
        co.station.set_attended();
        co.run(2);
        let lost = LinkEvent::Lost {
            reason: "unplugged".to_owned(),
        };
        co.station.handle_link(co.now(), lost);
        let late = co.request(Request::Mode(Mode::Reactive));
        let given_up = co.request(Request::Stop);
        co.run(20);
        assert_eq!(co.fate(given_up), None, "{}", co.context());
        co.station.handle_cancel(co.now());
        let stop = co.request(Request::Stop);
        co.run(40);
        assert_eq!(co.fate(stop), None, "{}", co.context());
        let of_a_client = co.request(Request::Stop);
        co.station
            .handle_give_up(co.now(), of_a_client, Failure::Cancelled);
        assert_ne!(co.simulation.robot().mode(), Mode::Stop, "{}", co.context());
        let opened = LinkEvent::Opened {
            name: "radio".to_owned(),
            can_send: true,
        };
        co.station.handle_link(co.now(), opened);
        co.run_until("STOP is confirmed", 60, |co| {
            co.fate(stop) == Some(CONFIRMED)
        });
        let failed = |why| Some(CommandStatus::Failed(why));
        assert_eq!(co.fate(late), failed(Failure::NotSent), "{}", co.context());
        for given_up in [given_up, of_a_client] {
            let cancelled = failed(Failure::Cancelled);
            assert_eq!(co.fate(given_up), cancelled, "{}", co.context());
        }
        assert_eq!(co.simulation.robot().mode(), Mode::Stop, "{}", co.context());
    });
}

/// The operator presses STOP before the first line arrives.
#[test]
fn a_stop_before_anything_was_heard_goes_out() {
    over_seeds(|seed, channel| {
        let mut co = CoSimulation::new("house", seed, channel);
        let stop = co.request(Request::Stop);
        co.run_until("STOP is confirmed", 60, |co| {
            co.fate(stop) == Some(CONFIRMED)
        });
        assert_eq!(co.simulation.robot().mode(), Mode::Stop, "{}", co.context());
    });
}

#[test]
fn stop_stops_and_nothing_sent_before_it_moves_the_robot_again() {
    over_seeds(|seed, channel| {
        let mut co = CoSimulation::new("house", seed, channel);
        co.run(1 + seed % 5);
        let prowl = co.request(Request::Mode(Mode::Prowl));
        let stop = co.request(Request::Stop);
        co.run_until("STOP is confirmed", 60, |co| {
            co.fate(stop) == Some(CONFIRMED)
        });
        assert!(
            matches!(co.fate(prowl), Some(CommandStatus::Failed(_))),
            "{}",
            co.context()
        );
        for _ in 0..5000 {
            co.step();
            assert_eq!(co.simulation.robot().mode(), Mode::Stop, "{}", co.context());
        }
    });
}

/// A client's command ends at the client's timeout; other commands continue.
#[test]
fn a_command_that_is_given_up_leaves_the_others_alone() {
    over_seeds(|seed, channel| {
        let mut co = CoSimulation::new("house", seed, channel);
        let route = vec![Waypoint { x_in: 9, y_in: 9 }; 100];
        let first = co.request(Request::Route(route));
        let second = co.request(Request::Mode(Mode::Passive));
        let third = co.request(Request::Mode(Mode::Reactive));
        co.run_until("the list is on its way", 60, |co| {
            co.events.iter().any(|(_, event)| {
                matches!(
                    event,
                    groundwave::event::Event::Command {
                        status: CommandStatus::Progress { .. },
                        ..
                    }
                )
            })
        });
        let now = co.now();
        co.station.handle_give_up(now, second, Failure::TimedOut);
        co.station.handle_give_up(now, first, Failure::TimedOut);
        co.run_until("the third ends", 120, |co| co.fate(third).is_some());
        assert_eq!(co.fate(third), Some(CONFIRMED), "{}", co.context());
        for (given_up, why) in [(first, Failure::TimedOut), (second, Failure::NotSent)] {
            let failed = Some(CommandStatus::Failed(why));
            assert_eq!(co.fate(given_up), failed, "{}", co.context());
        }
        assert!(!co.modes.contains(&Mode::Passive), "{}", co.context());
    });
}
