//! Exhaustive search of the shipping state machines: every order in which a few things can happen.
//!
//! Each test is a small setting that is searched to its end. What is searched and what is not is said
//! in `search/model.rs` and `search/instants.rs`.

#[path = "search/ground.rs"]
mod ground;
#[path = "search/instants.rs"]
mod instants;
#[path = "search/model.rs"]
mod model;
#[path = "search/robot.rs"]
mod robot;
mod world;

use ground::Wish::{List, Order};
use model::Setting;
use stateright::{Checker, HasDiscoveries, Model};

fn alone(wishes: &[ground::Wish]) -> Setting {
    Setting {
        stations: vec![(0x2A5, wishes.to_vec())],
        reboots: 0,
        restarts: 0,
        stops: 0,
        held: usize::MAX,
        owners_differ: true,
    }
}

/// Searches all of it; says how much that was.
fn search(name: &str, setting: Setting) {
    let checker = setting
        .checker()
        .threads(1)
        .finish_when(HasDiscoveries::AnyFailures)
        .spawn_bfs()
        .join();
    println!(
        "{name}: {} states, {} steps, {} deep",
        checker.unique_state_count(),
        checker.state_count(),
        checker.max_depth()
    );
    for property in checker.model().properties() {
        let Some(path) = checker.discovery(property.name) else {
            continue;
        };
        assert!(
            property.expectation == stateright::Expectation::Sometimes,
            "broken: {}\n{}",
            property.name,
            path.into_actions()
                .iter()
                .map(|a| format!("{a:?} "))
                .collect::<String>()
        );
    }
    checker.assert_properties();
}

#[test]
fn two_orders() {
    search("two orders", alone(&[Order, Order]));
}

#[test]
fn two_orders_and_a_reboot() {
    search(
        "two orders and a reboot",
        Setting {
            reboots: 1,
            ..alone(&[Order, Order])
        },
    );
}
