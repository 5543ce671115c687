//! What a robot tells of its board: the reason of its boot, and sensors that are not wired.

use crate::common::{BOOTS, Bench, ROBOT_ID, texts};
use groundwave_protocol::status_codes::{Bump, Infrared, Layer, LayerMask, LayerState};
use sr04_firmware::board::{Duplex, Echo, Identity, Restart, Side, Switches};

fn identity() -> Identity {
    Identity::new(ROBOT_ID, BOOTS, 1, Duplex::Full)
}

#[test]
fn the_reason_of_a_boot_is_told_once() {
    for (restart, told) in [
        (Restart::PowerOn, ""),
        (Restart::BrownOut, "voltage"),
        (Restart::Watchdog, "watchdog"),
        (Restart::Panic, "panicked"),
    ] {
        let mut bench = Bench::with_identity(Identity {
            restart,
            ..identity()
        });
        bench.run_ms(10_000);
        let texts = texts(&bench);
        let count = usize::from(restart != Restart::PowerOn);
        assert_eq!(texts.len(), count, "{restart:?}: {texts:?}");
        assert!(texts.iter().all(|text| text.contains(told)), "{texts:?}");
    }
}

#[test]
fn sensors_that_are_not_wired_are_not_fitted() {
    let wired = [Layer::User, Layer::Rotation, Layer::DeadReckoning];
    let fitted = wired.into_iter().fold(LayerMask::NONE, LayerMask::with);
    let mut bench = Bench::with_identity(Identity {
        fitted,
        ..identity()
    });
    // Pins that nothing drives read anything.
    bench.reflects = (true, true);
    bench.inputs.bumper = Switches {
        left: true,
        ..Switches::default()
    };
    bench.inputs.sonar = Some(Echo::after_us(Side::Left, Some(3000)));
    bench.run_ms(5000);
    let state = bench.latest_state();
    assert_eq!(state.bump, Bump::NotFitted);
    assert_eq!(state.infrared, Infrared::NotFitted);
    assert_eq!((state.sonar_left_in, state.sonar_right_in), (None, None));
    assert_eq!(bench.outputs.ping, None);
    assert!(!bench.leds_on);
    for layer in [Layer::Bumpers, Layer::Infrared, Layer::Sonar] {
        assert_eq!(state.layers.get(layer), LayerState::Off, "{layer:?}");
    }
}
