//! Restarts of robot or station at every frame boundary of a transfer, and STOP in every phase, in virtual time, of
//! the simulated robot and of the robot in C. A first run finds the boundaries; then there is one run per boundary.

#[cfg(unix)]
use crate::common::c_robot::CSimulation;
use crate::common::{CoSimulation, Robot, is_nightly, on_all_cores};
use crate::witness::Trial;
use groundwave::event::CommandStatus;
use groundwave::request::Request;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::PATIENCE_BYTES;
use sr04_sim::Simulation;

/// Channels; over a radio with delay, frames sent before a restart arrive after it.
const CHANNELS: [&str; 4] = ["", "ber=1e-3", "delay=700ms", "dup=0.02,delay=80ms"];

/// Half-duplex channels. A restarted station must detect them.
const TURNING: [&str; 2] = ["half-duplex", "half-duplex,ber=1e-3"];

/// Numbers of waypoints of the old list, 0 for a station that has just started, and of the new list.
const LISTS: [(usize, usize); 3] = [(20, 60), (0, 40), (5, 1)];

#[derive(Clone, Copy, Debug)]
enum Restart {
    Robot,
    Station,
    Both,
}

/// Runs until the new list is sent; returns its number.
fn begin<R: Robot>(seed: u64, channel: &str, (old, new): (usize, usize)) -> (Trial<R>, usize) {
    let mut trial = if TURNING.contains(&channel) {
        Trial::taking_turns(seed, channel, PATIENCE_BYTES, 40)
    } else {
        Trial::new(seed, channel)
    };
    trial.run_ms(1000 + seed);
    if old > 0 {
        let old = trial.some_list(old);
        let number = trial.order(old);
        trial.run_to_end(number);
        trial.run_ms(1500);
    }
    let new = trial.some_list(new);
    let number = trial.order(new);
    (trial, number)
}

/// Ends of frames and lines from the command until a second after its confirmation, milliseconds.
fn boundaries_ms<R: Robot>(seed: u64, channel: &str, lists: (usize, usize)) -> Vec<u64> {
    let (mut trial, number) = begin::<R>(seed, channel, lists);
    trial.boundaries_ms.clear();
    trial.run_to_end(number);
    trial.run_ms(1000);
    trial.boundaries_ms
}

fn restart_at<R: Robot>(
    restart: Restart,
    at_ms: u64,
    seed: u64,
    channel: &str,
    lists: (usize, usize),
) {
    let (mut trial, number) = begin::<R>(seed, channel, lists);
    while trial.co.simulation.now_ms() < at_ms {
        trial.step();
    }
    if !matches!(restart, Restart::Robot) {
        trial.restart_station(seed + 500);
    }
    if !matches!(restart, Restart::Station) {
        trial.reboot_robot();
    }
    if matches!(restart, Restart::Robot) {
        trial.run_to_end(number);
        // The restarted robot had no list, so a confirmation is about its present life or came before the restart.
        assert!(
            trial.is_executed(number) || !trial.is_confirmed(number),
            "{}",
            trial.co.context()
        );
    }
    // Commands begun before the station knows of the restart fail.
    trial.run_ms(3000);
    trial.finish();
}

#[test]
fn restart_at_any_boundary_mixes_and_repeats_nothing() {
    restart_at_boundaries::<Simulation>();
    #[cfg(unix)]
    restart_at_boundaries::<CSimulation>();
}

fn restart_at_boundaries<R: Robot>() {
    for restart in [Restart::Robot, Restart::Station, Restart::Both] {
        let mut runs = 0;
        for (seed, channel) in (40..).zip(CHANNELS.into_iter().chain(TURNING)) {
            let lists = if matches!(restart, Restart::Both) || TURNING.contains(&channel) {
                &LISTS[..1]
            } else {
                &LISTS[..]
            };
            for &lists in lists {
                let boundaries = boundaries_ms::<R>(seed, channel, lists);
                assert!(boundaries.len() > 5, "a transfer has frames and lines");
                let tried: Vec<u64> = boundaries.into_iter().step_by(sampling::<R>()).collect();
                on_all_cores(0..tried.len() as u64, |n| {
                    restart_at::<R>(restart, tried[n as usize], seed, channel, lists);
                });
                runs += tried.len();
            }
        }
        println!("{restart:?}: {runs} boundaries");
    }
}

/// A radio repeats all bytes of an earlier session while a new session is open.
#[test]
fn bytes_of_an_earlier_session_do_nothing_in_a_later_one() {
    repeat_an_earlier_session::<Simulation>(70);
    #[cfg(unix)]
    repeat_an_earlier_session::<CSimulation>(4);
}

fn repeat_an_earlier_session<R: Robot>(seeds: u64) {
    for restart in [Restart::Robot, Restart::Station, Restart::Both] {
        on_all_cores(0..seeds, |seed| {
            let (mut trial, number) = begin::<R>(seed, "", (20, 30));
            trial.run_to_end(number);
            for _ in 0..3 {
                let pose = trial.some_pose();
                let number = trial.order(pose);
                trial.run_to_end(number);
            }
            if !matches!(restart, Restart::Robot) {
                trial.restart_station(seed);
            }
            if !matches!(restart, Restart::Station) {
                trial.reboot_robot();
            }
            trial.run_ms(1000 + seed * 7);
            let earlier = trial.co.sent.clone();
            let pose = trial.some_pose();
            let number = trial.order(pose);
            trial.run_to_end(number);
            assert!(trial.is_confirmed(number), "{}", trial.co.context());
            // The check in every millisecond would see any repeated execution.
            trial.co.simulation.handle_uplink(&earlier);
            trial.run_ms(5000);
            trial.finish();
        });
    }
}

const CONFIRMED: CommandStatus = CommandStatus::Confirmed { digest: None };

/// Step between moments: the gate tries every eighth, the nightly run each; with the robot in C, an eighth of them.
fn sampling<R: Robot>() -> usize {
    let step = if is_nightly() { 1 } else { 8 };
    if R::IS_IN_C { 8 * step } else { step }
}

/// Maximum time from the key until the robot's program stops, on a clean link in any phase.
const STOP_MS: u64 = 150;

#[test]
fn stop_stops_in_every_phase_of_a_transfer() {
    stop_in_phases::<Simulation>();
    #[cfg(unix)]
    stop_in_phases::<CSimulation>();
}

fn stop_in_phases<R: Robot>() {
    for (seed, channel) in (60..).zip(CHANNELS) {
        for lists in [(20, 60), (0, 60)] {
            let phases = 130 / sampling::<R>() as u64;
            let step_ms = 31 * sampling::<R>() as u64;
            on_all_cores(0..phases, |phase| {
                stop_at::<R>(phase * step_ms, seed, channel, lists);
            });
        }
    }
}

fn stop_at<R: Robot>(phase_ms: u64, seed: u64, channel: &str, lists: (usize, usize)) {
    let (mut trial, number) = begin::<R>(seed, channel, lists);
    trial.run_ms(phase_ms);
    let pressed_ms = trial.co.simulation.now_ms();
    let had_ended = trial.end(number).is_some();
    trial.stop();
    let mut is_standing = false;
    while trial.stopped().is_none() {
        trial.step();
        let mode = trial.co.simulation.mode();
        let since_ms = trial.co.simulation.now_ms() - pressed_ms;
        is_standing |= mode == Mode::Stop;
        let must_stand = is_standing || channel.is_empty() && since_ms > STOP_MS;
        assert!(!must_stand || mode == Mode::Stop, "{}", trial.co.context());
    }
    // Only an intact line A confirms it. With doubled bytes, one line in five survives, and in one run of a thousand
    // none does within fifteen seconds.
    assert!(
        is_standing && (channel.contains("dup") || trial.stopped() == Some(&CONFIRMED)),
        "{:?}: {}",
        trial.stopped(),
        trial.co.context()
    );
    let end = trial.end(number);
    assert!(
        had_ended || matches!(end, Some(CommandStatus::Failed(_))),
        "{end:?}: {}",
        trial.co.context()
    );
    let list = trial.co.simulation.active_digest();
    for _ in 0..3000 {
        trial.step();
        let robot = &trial.co.simulation;
        assert_eq!(robot.mode(), Mode::Stop, "{}", trial.co.context());
        assert_eq!(robot.active_digest(), list, "{}", trial.co.context());
    }
    trial.finish();
}

#[test]
fn stop_ends_hand_drive() {
    stop_hand_drive::<Simulation>(40);
    #[cfg(unix)]
    stop_hand_drive::<CSimulation>(4);
}

fn stop_hand_drive<R: Robot>(seeds: u64) {
    for channel in CHANNELS {
        on_all_cores(0..seeds, |seed| {
            let mut co = Trial::<R>::new(seed, channel).co;
            co.deliver(Request::Mode(Mode::User));
            for _ in 0..seed * 40 {
                let now = co.now();
                co.station.handle_drive(now, 6, 2);
                co.step();
            }
            let stop = co.request(Request::Stop);
            co.run_until("STOP is confirmed", 30, |co| {
                co.fate(stop) == Some(CONFIRMED)
            });
            for _ in 0..5000 {
                assert_eq!(co.simulation.mode(), Mode::Stop, "{}", co.context());
                co.step();
            }
        });
    }
}

/// The downlink takes longer than the operator to press the key again.
#[test]
fn stop_is_confirmed_while_it_is_requested_again_and_again() {
    stop_again_and_again::<Simulation>(20);
    #[cfg(unix)]
    stop_again_and_again::<CSimulation>(2);
}

fn stop_again_and_again<R: Robot>(seeds: u64) {
    on_all_cores(0..seeds, |seed| {
        let mut co = Trial::<R>::new(seed, "delay=1s").co;
        co.deliver(Request::Mode(Mode::Prowl));
        let stops: Vec<_> = (0..20)
            .map(|_| {
                let stop = co.request(Request::Stop);
                for _ in 0..400 {
                    co.step();
                }
                stop
            })
            .collect();
        let is_confirmed = |co: &CoSimulation<R>, n: usize| co.fate(stops[n]) == Some(CONFIRMED);
        assert!(is_confirmed(&co, 0), "{}", co.context());
        assert!(!is_confirmed(&co, 19), "{}", co.context());
        co.run_until("the last STOP is confirmed", 30, |co| is_confirmed(co, 19));
        assert!((0..20).all(|n| is_confirmed(&co, n)), "{}", co.context());
    });
}
