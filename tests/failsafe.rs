//! The robot's failsafe triggers only when the station has ended: the real station and the robot's real program, or
//! the robot in C, in virtual time.

#[cfg(unix)]
use crate::common::c_robot::CSimulation;
use crate::common::{CoSimulation, Robot, on_all_cores, seeds};
use crate::witness::Trial;
use groundwave::event::CommandStatus;
use groundwave::request::Request;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::PATIENCE_BYTES;
use sr04_sim::Simulation;

const SILENCE_S: u16 = 10;

/// Time without commands, with a station present, seconds.
const QUIET_S: u64 = 300;

/// Sets the failsafe, then mode prowl; the seed selects the radio.
fn armed<R: Robot>(seed: u64) -> CoSimulation<R> {
    let channel = ["", "ber=1e-3", "half-duplex", "half-duplex,ber=1e-3"][seed as usize % 4];
    let trial = if channel.starts_with("half-duplex") {
        Trial::taking_turns(seed, channel, PATIENCE_BYTES, 40)
    } else {
        Trial::new(seed, channel)
    };
    let mut co = trial.co;
    let failsafe = Failsafe {
        silence_s: SILENCE_S,
        mode: Mode::GoHome,
    };
    for request in [
        Request::Failsafe(Some(failsafe)),
        Request::Mode(Mode::Prowl),
    ] {
        let end = co.deliver(request);
        assert_eq!(
            end,
            CommandStatus::Confirmed { digest: None },
            "{}",
            co.context()
        );
    }
    co
}

#[test]
fn a_quiet_station_is_not_a_silent_ground() {
    stay_quiet::<Simulation>(8);
    #[cfg(unix)]
    stay_quiet::<CSimulation>(4);
}

fn stay_quiet<R: Robot>(few: u64) {
    on_all_cores(seeds(few), |seed| {
        let mut co = armed::<R>(seed);
        for _ in 0..QUIET_S * 1000 {
            co.step();
            let mode = co.simulation.mode();
            assert_eq!(mode, Mode::Prowl, "{}", co.context());
        }
    });
}

#[test]
fn a_silent_ground_sends_the_robot_home_in_time() {
    let mut silences = go_silent::<Simulation>(20);
    #[cfg(unix)]
    silences.extend(go_silent::<CSimulation>(8));
    // The latest keepalive came shortly before, unless bit errors damaged four in a row.
    let early: Vec<_> = silences
        .iter()
        .filter(|(_, silent_ms)| *silent_ms < u64::from(SILENCE_S) * 600)
        .collect();
    assert!(early.len() * 10 <= silences.len(), "{early:?}");
}

/// Milliseconds until the robot goes home, by seeds.
fn go_silent<R: Robot>(few: u64) -> Vec<(u64, u64)> {
    on_all_cores(seeds(few), |seed| {
        let mut co = armed::<R>(seed);
        co.run(1 + seed % 20);
        let gone_ms = co.simulation.now_ms();
        while co.simulation.mode() == Mode::Prowl {
            co.simulation.step();
            while co.simulation.poll_downlink().is_some() {}
            let silent_s = (co.simulation.now_ms() - gone_ms) / 1000;
            assert!(silent_s <= u64::from(SILENCE_S), "{}", co.context());
        }
        // A robot that is at home already has stopped there.
        let (x_in, y_in) = co.simulation.position_in();
        let is_home = x_in.abs().max(y_in.abs()) <= 1;
        let expected = [
            Mode::GoHome,
            if is_home { Mode::Stop } else { Mode::GoHome },
        ];
        let mode = co.simulation.mode();
        assert!(expected.contains(&mode), "{mode:?}: {}", co.context());
        co.simulation.now_ms() - gone_ms
    })
}
