//! The words for layers and modes.

use groundwave_protocol::status_codes::{Layer, Mode};

/// The word for a layer.
#[must_use]
pub const fn layer_word(layer: Layer) -> &'static str {
    match layer {
        Layer::User => "user",
        Layer::Bumpers => "bumpers",
        Layer::Rotation => "rotation",
        Layer::Infrared => "infrared",
        Layer::Sonar => "sonar",
        Layer::Photo => "photo",
        Layer::Motion => "motion",
        Layer::DeadReckoning => "dead-reckoning",
    }
}

/// The word for a mode.
#[must_use]
pub const fn mode_word(mode: Mode) -> &'static str {
    match mode {
        Mode::Prowl => "prowl",
        Mode::Reactive => "reactive",
        Mode::Passive => "passive",
        Mode::Stop => "stop",
        Mode::User => "user",
        Mode::Wander => "wander",
        Mode::GoHome => "home",
        Mode::Forage => "forage",
        Mode::Calibrate => "calibrate",
    }
}
