//! The layout for Foxglove and Lichtblick, attached to each recording.
//!
//! The layout shows the room from above, plots, states, the log, and the bytes beside each decoded line; for live connections also a
//! panel that sends commands.

/// Name of the attachment.
pub const NAME: &str = "groundwave.layout.json";

/// The layout; `docs/opening-captures.md` describes how to import it.
pub const JSON: &str = include_str!("layout.json");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::Telemetry;
    use crate::topics::Topic;
    use serde_json::Value;
    use std::collections::BTreeSet;

    /// Collects every string under these keys, and every key under `topics`.
    fn paths(value: &Value, found: &mut BTreeSet<String>) {
        match value {
            Value::Object(fields) => {
                for (key, value) in fields {
                    match (key.as_str(), value) {
                        ("topics", Value::Object(topics)) => found.extend(topics.keys().cloned()),
                        ("value" | "topicPath" | "topicToRender", Value::String(path)) => {
                            found.insert(path.clone());
                        }
                        _ => paths(value, found),
                    }
                }
            }
            Value::Array(values) => values.iter().for_each(|value| paths(value, found)),
            _ => {}
        }
    }

    fn panels(layout: &Value, found: &mut BTreeSet<String>) {
        match layout {
            Value::String(panel) => assert!(found.insert(panel.clone()), "{panel} is there twice"),
            split => {
                assert!(split["direction"] == "row" || split["direction"] == "column");
                panels(&split["first"], found);
                panels(&split["second"], found);
            }
        }
    }

    #[test]
    fn every_path_of_the_layout_is_in_a_capture() {
        let layout: Value = serde_json::from_str(JSON).unwrap();
        let mut found = BTreeSet::new();
        paths(&layout, &mut found);
        assert!(found.len() > 10, "{found:?}");
        for path in found {
            let (topic, field) = path
                .split_once('.')
                .map_or((&*path, None), |(topic, field)| (topic, Some(field)));
            let topic = Topic::from_name(topic);
            assert!(topic.is_some(), "{path}");
            if let Some(field) = field {
                assert_eq!(topic, Some(Topic::Telemetry), "{path}");
                assert!(
                    Telemetry::FIELDS.iter().any(|known| known.name == field),
                    "{path}"
                );
            }
        }
    }

    #[test]
    fn every_panel_has_its_place() {
        let layout: Value = serde_json::from_str(JSON).unwrap();
        let configured = layout["configById"].as_object().unwrap();
        let mut placed = BTreeSet::new();
        panels(&layout["layout"], &mut placed);
        for tab in configured["Tab!details"]["tabs"].as_array().unwrap() {
            panels(&tab["layout"], &mut placed);
        }
        let configured: BTreeSet<String> = configured.keys().cloned().collect();
        assert_eq!(placed, configured);
    }
}
