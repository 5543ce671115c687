//! Parameters over the radio: set, reported, kept and refused.

use crate::common::{Bench, running};
use groundwave_protocol::command::Order;
use groundwave_protocol::parameter::key as key_of;
use groundwave_protocol::telemetry::{Body, Outcome, ParameterLine};
use sr04_firmware::parameters::Parameter;

fn reported(bench: &Bench) -> Vec<ParameterLine> {
    let lines = bench.lines.iter();
    lines
        .filter_map(|(_, line)| match line.body {
            Body::Parameter(parameter) => Some(parameter),
            _ => None,
        })
        .collect()
}

#[test]
fn parameter_is_set_reported_and_kept() {
    let (mut bench, key) = running();
    let speed = Parameter::TopSpeed;
    let named = key_of(speed.definition().name);
    bench.order(
        key,
        Order::SetParameter {
            key: named,
            value: 8,
        },
    );
    assert_eq!(bench.robot.ack().outcome, Outcome::Done);
    assert_eq!(bench.robot.parameters().get(speed), 8);
    // The new session's line I comes first.
    bench.run_ms(3000);
    let [line] = reported(&bench)[..] else {
        panic!("expected one line P");
    };
    assert_eq!(
        (line.name.as_str(), line.unit.as_str()),
        ("top-speed", "in/s")
    );
    assert_eq!(
        (line.value, line.kept, line.least, line.most),
        (8, 12, 2, 12)
    );
    assert_eq!(usize::from(line.count), Parameter::ALL.len());

    bench.order(key, Order::KeepParameters);
    assert!(!bench.outputs.keep_parameters);
    bench.run_ticks(1);
    assert!(bench.outputs.keep_parameters, "for one tick");
    bench.run_ticks(1);
    assert!(!bench.outputs.keep_parameters, "for one tick only");
    bench.run_ms(2000);
    let kept = reported(&bench).last().map(|line| (line.value, line.kept));
    assert_eq!(kept, Some((8, 8)));
    assert_eq!(
        reported(&bench).len(),
        2,
        "only changed parameters are reported"
    );
}

#[test]
fn invalid_parameters_and_values_are_refused() {
    let (mut bench, key) = running();
    let before = bench.robot.parameters().clone();
    let set = |value| Order::SetParameter {
        key: key_of("top-speed"),
        value,
    };
    let unknown = key_of("warp-speed");
    for (order, outcome, lines) in [
        (set(13), Outcome::BadValue, 1),
        (set(70_000), Outcome::BadValue, 1),
        (
            Order::SetParameter {
                key: unknown,
                value: 1,
            },
            Outcome::Unknown,
            0,
        ),
        (Order::ReadParameter { key: unknown }, Outcome::Unknown, 0),
        (Order::ReadParameters { place: 4095 }, Outcome::BadValue, 0),
    ] {
        bench.lines.clear();
        bench.order(key, order);
        assert_eq!(bench.robot.ack().outcome, outcome, "{order:?}");
        bench.run_ms(3000);
        assert_eq!(reported(&bench).len(), lines, "{order:?}");
        assert_eq!(bench.robot.parameters(), &before);
    }
}

#[test]
fn all_parameters_are_reported_on_request() {
    let (mut bench, key) = running();
    bench.order(key, Order::ReadParameters { place: 0 });
    bench.run_ms(40_000);
    let places: Vec<_> = reported(&bench)
        .iter()
        .map(|line| usize::from(line.place))
        .collect();
    let all: Vec<_> = (1..=Parameter::ALL.len()).collect();
    assert_eq!(places, all);
    bench.lines.clear();
    bench.order(key, Order::ReadParameters { place: 3 });
    bench.run_ms(2000);
    let [line] = reported(&bench)[..] else {
        panic!("expected one line P");
    };
    assert_eq!(line.name.as_str(), Parameter::ALL[2].definition().name);
}
