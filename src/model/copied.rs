//! The text for the clipboard: a traced value, a found line of the log, or the newest line.

use groundwave_protocol::LINE_BYTES;

use super::news::Passing;
use super::{Facts, Overlay, Ui, trace};
use crate::event::{Effect, Moment};

impl Ui {
    pub(super) fn copy(&mut self, facts: &Facts, now: Moment) -> Vec<Effect> {
        let text = match &self.overlay {
            Overlay::Trace(at) => traced(facts, *at),
            Overlay::Search(search) => {
                let mut entries = facts.log.numbered();
                let found = entries.find(|(number, _)| *number == search.at);
                found.map(|(_, entry)| entry.text.clone())
            }
            _ => {
                let raw = facts.link.newest_raw().map(printable);
                raw.or_else(|| facts.fields.newest.clone())
            }
        };
        let words = match &text {
            Some(text) => format!("copied, if the terminal allows it: {}", text.trim()),
            None => "nothing to copy yet".to_owned(),
        };
        self.pass_on(now, Passing::Words(words));
        text.map(|text| Effect::Copy(text.trim().to_owned()))
            .into_iter()
            .collect()
    }
}

/// The columns of a traced value.
fn traced(facts: &Facts, at: usize) -> Option<String> {
    let field = trace::FIELDS.get(at)?;
    let line = printable(&facts.link.newest_of(field.line_type)?.value);
    let (first, last) = field.columns;
    line.get(first - 1..last).map(str::to_owned)
}

/// A line as text, with a space for each byte that cannot be shown.
pub(crate) fn printable(raw: &[u8; LINE_BYTES]) -> String {
    raw.iter()
        .map(|&byte| match byte {
            b' '..=b'~' => char::from(byte),
            _ => ' ',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::event::Effect;
    use crate::model::Config;
    use crate::model::testing::Scene;

    #[test]
    fn the_newest_line_or_a_traced_value_is_copied() {
        let mut scene = Scene::new(Config::default());
        assert_eq!(scene.type_text("c"), []);
        scene.state.x_tenths_in = 759;
        scene.hear();
        let [Effect::Copy(line)] = &scene.type_text("c")[..] else {
            panic!("a line");
        };
        assert!(line.starts_with("A00 +075.9 "), "{line}");
        assert_eq!(line.len(), 78, "without its end");
        scene.type_text("il");
        assert_eq!(scene.type_text("c"), [Effect::Copy("+075.9".to_owned())]);
    }
}
