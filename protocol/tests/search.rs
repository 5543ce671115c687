//! Exhaustive search of the state machines: all possible orders of a few steps.
//!
//! Each test searches a small setting: `cargo xtask nightly` to its end, other runs its nearest states. `search/model.rs` and `search/instants.rs` describe the limits.

mod ground;
mod instants;
mod model;
mod robot;

use ground::Request::{List, Order};
use model::Setting;
use stateright::{Checker, Expectation, HasDiscoveries, Model};
use std::sync::{Condvar, Mutex};

fn alone(requests: &[ground::Request]) -> Setting {
    Setting {
        stations: vec![(0x2A5, requests.to_vec())],
        reboots: 0,
        restarts: 0,
        stops: 0,
        held: (4, 4),
        sessions: 4,
        commands: 3,
        owners_differ: true,
    }
}

/// Steps of a search outside `cargo xtask nightly`; the nearest states come first.
const STEPS_SAMPLED: usize = 400_000;

/// Steps after which a search counts as without an end.
const STEPS_MAX: usize = 12_000_000;

/// Number of searches at once: two take 2.5 GB, ten 4.1 GB and not less time.
const AT_ONCE: usize = 2;

/// Number of searches that run now.
static RUNNING: (Mutex<usize>, Condvar) = (Mutex::new(0), Condvar::new());

const UNBROKEN: &str = "nothing panics while it holds the count";

/// The right to search; waits until it is free.
struct Turn;

impl Turn {
    fn take() -> Self {
        let running = RUNNING.0.lock().expect(UNBROKEN);
        *RUNNING
            .1
            .wait_while(running, |n| *n == AT_ONCE)
            .expect(UNBROKEN) += 1;
        Self
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        *RUNNING.0.lock().expect(UNBROKEN) -= 1;
        RUNNING.1.notify_one();
    }
}

/// Searches the states and prints their number.
fn search(name: &str, setting: Setting) {
    search_to(usize::MAX, name, setting);
}

/// Searches all states within `depth` steps.
fn search_to(depth: usize, name: &str, setting: Setting) {
    let _turn = Turn::take();
    let is_nightly = std::env::var_os("GROUNDWAVE_SEEDS").is_some();
    let steps_max = if is_nightly { STEPS_MAX } else { STEPS_SAMPLED };
    let checker = setting
        .checker()
        .target_max_depth(depth)
        .threads(1)
        .finish_when(HasDiscoveries::AnyFailures)
        .target_state_count(steps_max)
        .spawn_bfs()
        .join();
    println!(
        "{name}: {} states, {} steps, {} deep",
        checker.unique_state_count(),
        checker.state_count(),
        checker.max_depth()
    );
    let properties = checker.model().properties();
    let broken: Vec<String> = properties
        .iter()
        .filter(|property| property.expectation != Expectation::Sometimes)
        .filter_map(|property| Some((property.name, checker.discovery(property.name)?)))
        .map(|(name, path)| format!("broken: {name}\n{:?}", path.into_actions()))
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    let is_whole = checker.state_count() < steps_max;
    assert!(is_whole || !is_nightly, "{name}: not searched to its end");
    checker.assert_properties();
}

#[test]
fn orders() {
    search("three orders", alone(&[Order, Order, Order]));
}

#[test]
fn reboots() {
    let setting = Setting {
        reboots: 2,
        ..alone(&[Order, Order])
    };
    search("two orders, two reboots", setting);
}

#[test]
fn lists() {
    let setting = Setting {
        held: (2, 2),
        commands: 2,
        ..alone(&[List(2), List(1)])
    };
    search("two lists", setting);
}

#[test]
fn list_and_reboot() {
    let setting = Setting {
        reboots: 1,
        held: (2, 2),
        commands: 2,
        ..alone(&[List(1), List(1)])
    };
    search("two lists, a reboot", setting);
}

#[test]
fn stop() {
    let setting = Setting {
        stops: 1,
        held: (3, 2),
        sessions: 3,
        commands: 2,
        ..alone(&[Order, Order])
    };
    search("two orders, STOP", setting);
}

/// The lines are late, so the first operator learns of the second one's STOP after requesting a STOP.
#[test]
fn stop_by_two_operators() {
    let setting = Setting {
        stations: vec![(0x2A5, vec![]), (0x111, vec![])],
        stops: 2,
        held: (2, 3),
        commands: 2,
        ..alone(&[])
    };
    search("two operators, two STOPs", setting);
}

#[test]
fn stop_and_reboot() {
    let setting = Setting {
        stops: 1,
        reboots: 1,
        held: (2, 2),
        sessions: 3,
        commands: 1,
        ..alone(&[List(1)])
    };
    search("a list, STOP, a reboot", setting);
}

#[test]
fn restart() {
    let setting = Setting {
        restarts: 1,
        reboots: 1,
        held: (3, 2),
        commands: 2,
        ..alone(&[Order, List(1)])
    };
    search("an order, a list, a restart, a reboot", setting);
}

#[test]
fn two_stations() {
    let setting = Setting {
        stations: vec![(0x2A5, vec![Order]), (0x111, vec![Order])],
        held: (2, 1),
        sessions: 2,
        commands: 1,
        ..alone(&[])
    };
    search("two stations", setting);
}

/// One in a thousand pairs of stations draws the same owner. Then neither knows which station's commands were executed, but lists
/// do not mix. The setting is too large for a search to its end.
#[test]
fn two_stations_with_the_same_owner() {
    let setting = Setting {
        stations: vec![(0x2A5, vec![List(2)]), (0x2A5, vec![List(1)])],
        owners_differ: false,
        held: (3, 1),
        sessions: 1,
        commands: 1,
        ..alone(&[])
    };
    search_to(16, "two stations with the same owner", setting);
}
