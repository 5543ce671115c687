//! Commands over bad channels: the robot has either the old list or the new one, executes each command once, and every claim
//! is true. The real station and the robot's real program, or the robot in C, in virtual time; failures print the seed.

#[cfg(unix)]
use crate::common::c_robot::CSimulation;
use crate::common::{Robot, on_all_cores, seeds};
use crate::witness::Trial;
use groundwave::event::CommandStatus;
use groundwave_protocol::arq;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::{Duplex, HC_12_PATIENCE_BYTES};
use sr04_sim::Simulation;

const SEEDS: u64 = 20;

/// Seeds with the robot in C, a process that answers at every byte time.
#[cfg(unix)]
const SEEDS_IN_C: u64 = 5;

/// Number of commands per seed, besides those at the end.
const ORDERS: usize = 4;

/// Radio and the duplex that each end is configured for.
struct Setting {
    channel: String,
    robot: Duplex,
    station: arq::Duplex,
    latency_ms: u64,
}

impl Setting {
    fn full(channel: String) -> Self {
        Self {
            channel,
            robot: Duplex::Full,
            station: arq::Duplex::Full,
            latency_ms: 40,
        }
    }

    fn half(channel: String, patience_bytes: u8, latency_ms: u64) -> Self {
        Self {
            channel,
            robot: Duplex::Half { patience_bytes },
            station: arq::Duplex::Half,
            latency_ms,
        }
    }

    fn begin<R: Robot>(&self, seed: u64) -> Trial<R> {
        Trial::with(
            seed,
            &self.channel,
            self.robot,
            self.station,
            self.latency_ms,
        )
    }
}

/// Runs a few commands over each seed's channel, with random pauses.
fn under(channel_of: impl Fn(u64) -> String + Sync) {
    over_seeds(|seed| Setting::full(channel_of(seed)));
}

fn over_seeds(setting_of: impl Fn(u64) -> Setting + Sync) {
    deliver::<Simulation>(SEEDS, &setting_of);
    #[cfg(unix)]
    deliver::<CSimulation>(SEEDS_IN_C, &setting_of);
}

fn deliver<R: Robot>(few: u64, setting_of: &(impl Fn(u64) -> Setting + Sync)) {
    let trials = on_all_cores(seeds(few), |seed| {
        let mut trial = setting_of(seed).begin::<R>(seed);
        let mut confirmed = 0;
        for _ in 0..ORDERS {
            let pause_ms = trial.below(3000);
            trial.run_ms(pause_ms);
            let deed = trial.some_deed();
            let number = trial.order(deed);
            trial.run_to_end(number);
            confirmed += usize::from(trial.is_confirmed(number));
        }
        trial.finish();
        confirmed
    });
    let confirmed: usize = trials.iter().map(|(_, confirmed)| confirmed).sum();
    println!("{confirmed} of {} orders confirmed", trials.len() * ORDERS);
}

#[test]
fn independent_errors() {
    let rates = ["1e-4", "1e-3", "3e-3", "5e-3"];
    under(|seed| format!("ber={}", rates[seed as usize % rates.len()]));
}

#[test]
fn bursts() {
    let rates = [
        "1e-3,burst=50",
        "3e-3,burst=400",
        "0.02,burst=3000",
        "5e-3,burst=8",
    ];
    under(|seed| format!("ber={}", rates[seed as usize % rates.len()]));
}

#[test]
fn dropouts() {
    under(|seed| {
        let outages = (0..6).map(|n| {
            let from_ms = n * 7000 + seed * 613 % 5000;
            format!(",out={from_ms}ms..{}ms", from_ms + 200 + seed * 379 % 6000)
        });
        format!("drop=0.01{}", outages.collect::<String>())
    });
}

#[test]
fn squelch_noise() {
    let also = [
        "",
        ",ber=1e-3",
        "=out,out=3s..9s",
        "=out,out=2s..4s,out=5s..8s,drop=0.01",
    ];
    under(|seed| format!("squelch{}", also[seed as usize % also.len()]));
}

#[test]
fn duplicates() {
    let rates = ["0.001", "0.01", "0.05", "0.01,ber=1e-3"];
    under(|seed| format!("dup={}", rates[seed as usize % rates.len()]));
}

#[test]
fn delays_to_two_seconds() {
    under(|seed| {
        let errors = if seed % 2 == 0 { "" } else { ",ber=1e-3" };
        format!("delay={}ms{errors}", 10 + seed * 10)
    });
}

#[test]
fn everything_at_once() {
    under(|seed| {
        let out_s = 2 + seed % 9;
        format!(
            "ber=1e-3,burst=30,drop=0.002,dup=0.002,delay={}ms,squelch=out,out={out_s}s..{}s",
            seed * 7 % 900,
            out_s + 4
        )
    });
}

#[test]
fn half_duplex() {
    let also = [
        "",
        ",ber=1e-3",
        ",drop=0.01,dup=0.01",
        ",out=2s..5s,out=8s..11s",
        ",squelch",
    ];
    over_seeds(|seed| {
        let channel = format!("half-duplex{}", also[seed as usize % also.len()]);
        Setting::half(channel, 16, 40)
    });
}

#[test]
fn buffered_modules() {
    let also = ["", ",ber=1e-4", ",out=2s..5s,out=8s..11s"];
    over_seeds(|seed| {
        let also = also[seed as usize / 2 % also.len()];
        if seed % 2 == 0 {
            Setting::half(format!("modem=xbee{also}"), 60, 200)
        } else {
            Setting::half(format!("modem=hc-12{also}"), HC_12_PATIENCE_BYTES, 400)
        }
    });
}

/// A STOP before the first line waits for its turn on a half-duplex radio.
#[test]
fn a_cold_stop_takes_its_turn() {
    cold_stop::<Simulation>(SEEDS);
    #[cfg(unix)]
    cold_stop::<CSimulation>(SEEDS_IN_C);
}

fn cold_stop<R: Robot>(few: u64) {
    on_all_cores(seeds(few), |seed| {
        let channel = ["half-duplex", "half-duplex,ber=1e-3"][seed as usize % 2];
        let mut trial = Trial::<R>::taking_turns(seed, channel, 16, 40);
        trial.run_ms(seed * 13 % 1000);
        stop(&mut trial, 30_000);
        let mode = trial.co.simulation.mode();
        assert_eq!(mode, Mode::Stop, "seed {seed}");
    });
}

/// Presses STOP, which must be confirmed within this time.
fn stop<R: Robot>(trial: &mut Trial<R>, time_ms: u64) {
    trial.stop();
    trial.run_ms(time_ms);
    let confirmed = CommandStatus::Confirmed { digest: None };
    assert_eq!(trial.stopped(), Some(&confirmed), "{}", trial.co.context());
}

/// The radio is configured on one end only: a station for modems whose robot does not take turns, and vice versa.
#[test]
fn a_radio_known_to_one_end() {
    known_to_one_end::<Simulation>(SEEDS);
    #[cfg(unix)]
    known_to_one_end::<CSimulation>(SEEDS_IN_C);
}

fn known_to_one_end<R: Robot>(few: u64) {
    on_all_cores(seeds(few), |seed| {
        let also = ["", "ber=1e-3", "drop=0.01,dup=0.01"][seed as usize / 2 % 3];
        let robot_takes_turns = seed % 2 == 0;
        let (channel, robot, station) = if robot_takes_turns {
            let robot = Duplex::Half { patience_bytes: 16 };
            (format!("half-duplex,{also}"), robot, arq::Duplex::Full)
        } else {
            (also.to_owned(), Duplex::Full, arq::Duplex::Half)
        };
        let setting = Setting {
            channel: channel.trim_end_matches(',').to_owned(),
            robot,
            station,
            latency_ms: 400,
        };
        let mut trial = setting.begin::<R>(seed);
        trial.run_ms(seed * 13 % 3000);
        stop(&mut trial, 15_000);
        let deed = trial.some_deed();
        let number = trial.order(deed);
        trial.run_to_end(number);
        let is_clean = also.is_empty();
        assert!(!is_clean || trial.is_confirmed(number), "seed {seed}");
        trial.finish();
    });
}
