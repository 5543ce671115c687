//! Presets: combinations of layers, mode and parameters.

use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::ParameterName;

use super::{Amount, Request, RequestError, Tuning};

struct Preset {
    name: &'static str,
    layers: &'static [Layer],
    mode: Mode,
    parameter: Option<(&'static str, i32)>,
}

/// Parameter that each preset with light sets, so that it does not depend on an earlier preset.
const TOWARD_LIGHT: Option<(&str, i32)> = Some(("photo-avoid", 0));

/// The presets. Each allows layer `user`, so that driving by hand continues.
const PRESETS: [Preset; 8] = [
    Preset {
        name: "all",
        layers: &Layer::ALL,
        mode: Mode::Prowl,
        parameter: TOWARD_LIGHT,
    },
    Preset {
        name: "sonar-only",
        layers: &[Layer::User, Layer::Bumpers, Layer::Sonar],
        mode: Mode::Prowl,
        parameter: None,
    },
    Preset {
        name: "sonar-ir",
        layers: &[Layer::User, Layer::Bumpers, Layer::Infrared, Layer::Sonar],
        mode: Mode::Prowl,
        parameter: None,
    },
    Preset {
        name: "moth",
        layers: &[Layer::User, Layer::Bumpers, Layer::Photo],
        mode: Mode::Prowl,
        parameter: TOWARD_LIGHT,
    },
    Preset {
        name: "shy",
        layers: &[Layer::User, Layer::Bumpers, Layer::Photo],
        mode: Mode::Prowl,
        parameter: Some(("photo-avoid", 1)),
    },
    Preset {
        name: "reactive",
        layers: &Layer::ALL,
        mode: Mode::Reactive,
        parameter: TOWARD_LIGHT,
    },
    Preset {
        name: "passive",
        layers: &Layer::ALL,
        mode: Mode::Passive,
        parameter: TOWARD_LIGHT,
    },
    Preset {
        name: "wander",
        layers: &Layer::ALL,
        mode: Mode::Wander,
        parameter: TOWARD_LIGHT,
    },
];

/// The commands of a preset, in order: parameter, layers, mode.
pub(super) fn requests(name: &str) -> Result<Vec<Request>, RequestError> {
    let preset = PRESETS
        .iter()
        .find(|preset| preset.name == name)
        .ok_or_else(|| RequestError::UnknownPreset(name.to_owned()))?;
    let tune = preset
        .parameter
        .map(|(name, value)| Tuning::Set(ParameterName::new(name), Amount::Counts(value)))
        .map(Request::Parameter);
    let layers = preset.layers.iter();
    let layers = layers.fold(LayerMask::NONE, |mask, layer| mask.with(*layer));
    let then = [Request::Only(layers), Request::Mode(preset.mode)];
    Ok(tune.into_iter().chain(then).collect())
}

/// The names of the presets.
pub fn names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|preset| preset.name)
}
