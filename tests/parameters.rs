//! Parameters end to end: set, reported, saved, restored by a reset; with many seeds and from the command line.

use std::collections::BTreeSet;

use crate::common::{CoSimulation, on_all_cores, seeds};
use crate::programs;
use crate::witness::Trial;
use groundwave::event::{CommandStatus, Event};
use groundwave::request::{Amount, Request, Tuning};
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{Outcome, ParameterLine, ParameterName};
use sr04_firmware::parameters::Parameter;
use sr04_sim::Simulation;

const SEEDS: u64 = 5;

/// A perfect radio, and one that damages every second long line.
const CHANNELS: [&str; 2] = ["", "ber=1e-3"];

const CONFIRMED: CommandStatus = CommandStatus::Confirmed { digest: None };

fn over_seeds(property: impl Fn(&mut CoSimulation) + Sync) {
    on_all_cores(seeds(SEEDS), |seed| {
        for channel in CHANNELS {
            property(&mut CoSimulation::new("open-room", seed, channel));
        }
    });
}

fn set(value: i32) -> Request {
    Request::Parameter(Tuning::Set(
        ParameterName::new("top-speed"),
        Amount::Counts(value),
    ))
}

fn told(co: &CoSimulation) -> Vec<ParameterLine> {
    let events = co.events.iter();
    events
        .filter_map(|(_, event)| match event {
            Event::Command {
                status: CommandStatus::Reported(line),
                ..
            } => Some(*line),
            _ => None,
        })
        .collect()
}

#[test]
fn parameter_is_set_confirmed_saved_and_restored_by_a_reset() {
    over_seeds(|co| {
        assert_eq!(co.deliver(set(8)), CONFIRMED, "{}", co.context());
        let parameters = co.simulation.robot().parameters();
        assert_eq!(parameters.get(Parameter::TopSpeed), 8, "{}", co.context());
        let said = told(co).last().map(|line| line.value);
        assert_eq!(said, Some(8), "the robot said so: {}", co.context());

        co.simulation.reboot();
        let parameters = co.simulation.robot().parameters();
        assert_eq!(parameters.get(Parameter::TopSpeed), 12, "not kept yet");
        co.run(3);

        assert_eq!(co.deliver(set(7)), CONFIRMED, "{}", co.context());
        let save = Request::Parameter(Tuning::Save);
        assert_eq!(co.deliver(save), CONFIRMED, "{}", co.context());
        co.run(1);
        co.simulation.reboot();
        let parameters = co.simulation.robot().parameters();
        assert_eq!(parameters.get(Parameter::TopSpeed), 7, "{}", co.context());
    });
}

#[test]
fn value_outside_the_limits_is_refused_with_the_limits() {
    over_seeds(|co| {
        let refused = CommandStatus::Refused(Outcome::BadValue);
        assert_eq!(co.deliver(set(13)), refused, "{}", co.context());
        let parameters = co.simulation.robot().parameters();
        assert_eq!(parameters.get(Parameter::TopSpeed), 12, "{}", co.context());
        let nobody = Request::Parameter(Tuning::Get(ParameterName::new("warp-speed")));
        let unknown = CommandStatus::Refused(Outcome::Unknown);
        assert_eq!(co.deliver(nobody), unknown, "{}", co.context());
    });
}

/// The station first requests the unit.
#[test]
fn decimal_value_is_in_the_whole_unit() {
    let set = |name, word| {
        let words = ["param", "set", name, word];
        Request::from_words(&words).expect("it reads")
    };
    over_seeds(|co| {
        let low = set("battery-low", "11.8");
        assert_eq!(co.deliver(low), CONFIRMED, "{}", co.context());
        let charge = set("motion-charge", "2.0");
        assert_eq!(co.deliver(charge), CONFIRMED, "{}", co.context());
        let parameters = co.simulation.robot().parameters();
        let values = [Parameter::LowBattery, Parameter::Charge].map(|one| parameters.get(one));
        assert_eq!(values, [118, 20], "{}", co.context());
        let refused = CommandStatus::Refused(Outcome::BadValue);
        for (name, word) in [
            ("battery-low", "20.0"),
            ("battery-low", "11.65"),
            ("top-speed", "8.5"),
            ("battery-low", "99999.9"),
        ] {
            let end = co.deliver(set(name, word));
            assert_eq!(end, refused, "{name} {word}: {}", co.context());
        }
        let nobody = co.deliver(set("warp-speed", "9.9"));
        let unknown = CommandStatus::Refused(Outcome::Unknown);
        assert_eq!(nobody, unknown, "{}", co.context());
        let parameters = co.simulation.robot().parameters();
        assert_eq!(parameters.get(Parameter::LowBattery), 118);
    });
}

#[test]
fn parameter_list_is_complete() {
    over_seeds(|co| {
        let list = Request::Parameter(Tuning::List);
        let (begun, timeout) = (co.now(), list.default_timeout());
        assert_eq!(co.deliver(list), CONFIRMED, "{}", co.context());
        let took = co.now().saturating_sub(begun);
        assert!(took < timeout, "{took:?}: {}", co.context());
        let mut names: Vec<_> = told(co)
            .iter()
            .map(|line| line.name.as_str().to_owned())
            .collect();
        names.sort();
        let mut all: Vec<_> = Parameter::ALL
            .iter()
            .map(|one| one.definition().name)
            .collect();
        all.sort_unstable();
        assert_eq!(names, all, "each once: {}", co.context());
    });
}

/// HC-12 modules take 102 s for the list, half duplex with bit errors 150 s.
#[test]
fn parameter_list_takes_less_than_its_time_on_slow_radios() {
    let radios = [("modem=hc-12", 160, 400), ("half-duplex,ber=1e-3", 16, 40)];
    on_all_cores(seeds(SEEDS), |seed| {
        let (channel, patience_bytes, latency_ms) = radios[seed as usize % radios.len()];
        let mut co =
            Trial::<Simulation>::taking_turns(seed, channel, patience_bytes, latency_ms).co;
        let list = Request::Parameter(Tuning::List);
        let limit_s = list.default_timeout().as_secs();
        let id = co.request(list);
        co.run_until("the list ends", limit_s, |co| co.fate(id).is_some());
        assert_eq!(co.fate(id), Some(CONFIRMED), "{channel}: {}", co.context());
    });
}

/// A list takes half a minute; other commands do not wait for it.
#[test]
fn other_commands_come_before_the_rest_of_a_list() {
    over_seeds(|co| {
        let list = co.request(Request::Parameter(Tuning::List));
        co.run(4);
        for request in [
            Request::Mode(Mode::GoHome),
            set(8),
            Request::Mode(Mode::Prowl),
        ] {
            assert_eq!(co.deliver(request), CONFIRMED, "{}", co.context());
        }
        assert_eq!(co.fate(list), None, "before the list: {}", co.context());
        co.run_until("the list ends", 120, |co| co.fate(list).is_some());
        assert_eq!(co.fate(list), Some(CONFIRMED), "{}", co.context());
        let names: BTreeSet<_> = (told(co).iter())
            .map(|line| line.name.as_str().to_owned())
            .collect();
        assert_eq!(names.len(), Parameter::ALL.len(), "{}", co.context());
    });
}

#[test]
fn stop_ends_a_parameter_list() {
    over_seeds(|co| {
        let id = co.request(Request::Parameter(Tuning::List));
        co.run(4);
        assert_eq!(co.fate(id), None, "{}", co.context());
        assert_eq!(co.deliver(Request::Stop), CONFIRMED, "{}", co.context());
        assert!(co.fate(id).is_some(), "{}", co.context());
        assert_eq!(co.deliver(set(8)), CONFIRMED, "{}", co.context());
    });
}

#[test]
fn layers_are_switched_one_by_one_and_as_a_set() {
    over_seeds(|co| {
        for layer in Layer::ALL {
            let mask = LayerMask::NONE.with(layer);
            let allowed = |co: &CoSimulation| co.simulation.robot().allowed();
            for (request, is_on) in [
                (Request::Disable(mask), false),
                (Request::Enable(mask), true),
            ] {
                let end = co.deliver(request);
                // The simulated robot may lack a sensor; it then refuses and nothing changes.
                if end == CONFIRMED {
                    assert_eq!(allowed(co).contains(layer), is_on, "{}", co.context());
                } else {
                    assert_eq!(end, CommandStatus::Refused(Outcome::NotFitted));
                }
            }
        }
        let only = LayerMask::NONE.with(Layer::Bumpers).with(Layer::Sonar);
        assert_eq!(
            co.deliver(Request::Only(only)),
            CONFIRMED,
            "{}",
            co.context()
        );
        assert_eq!(co.simulation.robot().allowed(), only, "{}", co.context());
    });
}

#[test]
fn preset_sets_layers_and_mode() {
    let requests = Request::all_from_words(&["preset", "shy"]).expect("a preset");
    let words: Vec<_> = requests.iter().map(ToString::to_string).collect();
    let expected = [
        "param set photo-avoid 1",
        "only user,bumpers,photo",
        "mode prowl",
    ];
    assert_eq!(words, expected);
    let error = Request::all_from_words(&["preset", "bold"]).expect_err("no preset");
    assert!(error.to_string().contains("moth"), "{error}");
}

#[test]
fn words_become_commands() {
    for words in [
        "param list",
        "param get top-speed",
        "param set square -157",
        "param save",
        "only none",
        "only bumpers,photo",
    ] {
        let split: Vec<_> = words.split(' ').collect();
        let request = Request::from_words(&split).expect(words);
        assert_eq!(request.to_string(), words);
    }
    for words in [
        "param",
        "param set Top 3",
        "param top-speed x",
        "param set a 100000",
        "only",
    ] {
        let split: Vec<_> = words.split(' ').collect();
        assert!(Request::from_words(&split).is_err(), "{words}");
    }
}

#[cfg(unix)]
#[test]
fn param_command_sets_saves_and_shows() {
    use programs::{Sim, expect, scratch};
    let eeprom = scratch("param").join("eeprom");
    let kept = eeprom.to_str().expect("a plain name");
    let sim = Sim::start(&["--eeprom", kept, "--time-factor", "4"]);
    let (out, _) = expect(0, &["param", &sim.path, "set", "top-speed", "8"]);
    assert!(
        out.starts_with("param set top-speed 8: confirmed after"),
        "{out}"
    );
    let (_, err) = expect(5, &["param", &sim.path, "set", "top-speed", "13"]);
    assert!(err.contains("it takes 2 to 12 (in/s)"), "{err}");
    let (_, err) = expect(5, &["param", &sim.path, "get", "warp-speed"]);
    assert!(err.contains("it has no parameter `warp-speed`"), "{err}");
    let (out, _) = expect(0, &["param", &sim.path, "get", "top-speed", "--json"]);
    assert!(
        out.contains("\"status\":\"reported\"") && out.contains("\"value\":8"),
        "{out}"
    );
    expect(0, &["send", &sim.path, "param", "save"]);
    let (out, _) = expect(0, &["param", &sim.path, "list"]);
    assert_eq!(out.lines().count(), Parameter::ALL.len(), "{out}");
    expect(2, &["param", &sim.path, "set", "Top Speed", "8"]);
    expect(2, &["param", &sim.path, "forget"]);
    sim.end();
    let text = std::fs::read_to_string(&eeprom).expect("the robot kept it");
    assert!(text.contains("top-speed=8"), "{text}");
}

#[cfg(unix)]
#[test]
fn set_of_parameters_is_saved_edited_compared_and_loaded() {
    use programs::{Sim, expect, scratch};
    let path = scratch("param-file").join("good.toml");
    let file = path.to_str().expect("a plain name");
    let sim = Sim::start(&["--time-factor", "8"]);
    let param = |code, verb, more: &[&str]| {
        expect(code, &[&["param", &sim.path, verb, file], more].concat())
    };
    let (out, _) = param(0, "save-to", &[]);
    assert_eq!(out.trim(), format!("saved 27 parameters to {file}"));
    let (_, err) = param(2, "save-to", &[]);
    assert!(err.contains("use --force"), "{err}");
    let saved = std::fs::read_to_string(&path).expect("it is saved");
    assert!(saved.contains("top-speed = 12  # in/s, 2 to 12"), "{saved}");
    param(0, "diff", &[]);

    let write = |text: &str| std::fs::write(&path, text).expect("it is written");
    // Nothing is sent where one value is wrong.
    write("top-speed = 8\nbattery-low = 20.0\n");
    let (_, err) = param(2, "load", &[]);
    assert!(
        err.contains("good.toml:2: ") && err.contains("4.0 to 13.0 V"),
        "{err}"
    );
    write("top-speed = 8\ncliff-guard = 0\n");
    let (_, err) = param(2, "load", &[]);
    assert!(
        err.contains("good.toml:2: ") && err.contains("--yes"),
        "{err}"
    );
    let (out, _) = param(1, "diff", &[]);
    let differing = [
        "top-speed: 8 in the file, 12 in the robot (in/s)",
        "cliff-guard: 0 in the file, 1 in the robot",
    ];
    assert_eq!(out.lines().collect::<Vec<_>>(), differing);
    let (out, _) = param(0, "load", &["--yes"]);
    assert!(
        out.starts_with("2 of 2 parameters differ\nparam set top-speed 8: confirmed"),
        "{out}"
    );
    param(0, "diff", &[]);
    sim.end();
}
