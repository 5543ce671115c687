//! A layout for Foxglove and Lichtblick: without one, a capture opens with an empty screen.

/// The name of the attachment.
pub const NAME: &str = "groundwave.layout.json";

/// Import it as a layout; `docs/opening-captures.md` shows how.
pub const JSON: &str = include_str!("layout.json");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::topics::Topic;

    #[test]
    fn it_is_json_and_shows_topics_that_there_are() {
        let layout: serde_json::Value = serde_json::from_str(JSON).unwrap();
        let shown = layout["configById"]["3D!groundwave"]["topics"]
            .as_object()
            .unwrap();
        assert!(shown.len() > 3);
        assert!(shown.keys().all(|topic| Topic::from_name(topic).is_some()));
    }
}
