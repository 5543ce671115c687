//! The words for layers and modes.

use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};

use groundwave_captures::words::{layer_word, mode_word};

use super::{Request, RequestError};

/// Other, shorter or more common, words for layers.
const OTHER_WORDS: [(&str, Layer); 6] = [
    ("rotate", Layer::Rotation),
    ("ir", Layer::Infrared),
    ("route", Layer::DeadReckoning),
    ("dr", Layer::DeadReckoning),
    ("bumper", Layer::Bumpers),
    ("light", Layer::Photo),
];

/// The names of layers, separated by commas.
pub(super) fn layer_words(layers: LayerMask) -> String {
    let words: Vec<&str> = Layer::ALL
        .into_iter()
        .filter(|layer| layers.contains(*layer))
        .map(layer_word)
        .collect();
    words.join(",")
}

pub(super) fn read_layers(words: &str) -> Result<LayerMask, RequestError> {
    words.split(',').try_fold(LayerMask::NONE, |layers, word| {
        read_layer(word)
            .map(|layer| layers.with(layer))
            .ok_or_else(|| RequestError::UnknownLayer(word.to_owned()))
    })
}

fn read_layer(word: &str) -> Option<Layer> {
    let first = Layer::ALL.into_iter();
    let named = first.map(|layer| (layer_word(layer), layer));
    named
        .chain(OTHER_WORDS)
        .find_map(|(known, layer)| (known == word).then_some(layer))
}

/// Parses a mode; `mode stop` becomes `stop`, which is the safest way to stop.
pub(super) fn read_mode(word: &str) -> Result<Request, RequestError> {
    Ok(match find_mode(word)? {
        Mode::Stop => Request::Stop,
        mode => Request::Mode(mode),
    })
}

pub(super) fn find_mode(word: &str) -> Result<Mode, RequestError> {
    let known = Mode::ALL.iter().copied();
    known
        .into_iter()
        .find(|mode| mode_word(*mode) == word)
        .ok_or_else(|| RequestError::UnknownMode(word.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_parse_by_name_and_by_other_words() {
        for layer in Layer::ALL {
            let mask = LayerMask::NONE.with(layer);
            assert_eq!(read_layers(layer_word(layer)), Ok(mask));
            assert_eq!(read_layers(&layer_words(mask)), Ok(mask));
        }
        let both = LayerMask::NONE.with(Layer::Infrared).with(Layer::Rotation);
        assert_eq!(read_layers("ir,rotate"), Ok(both));
        assert_eq!(read_layers("infrared,rotation"), Ok(both));
        assert_eq!(layer_words(both), "rotation,infrared");
        assert!(read_layers("infrared,").is_err());
    }
}
