//! Generated documents match their tables.

use std::fs;

use groundwave::capture::topics::Topic;

#[path = "../examples/documents.rs"]
mod made;

#[test]
fn every_topic_is_documented() {
    let text = include_str!("../docs/opening-captures.md");
    for topic in Topic::ALL {
        let name = format!("`{}`", topic.name());
        assert!(text.contains(&name), "{name}");
    }
}

#[test]
fn generated_documents_are_current() {
    for (name, make) in made::DOCUMENTS {
        let written = fs::read_to_string(made::path(name)).unwrap_or_default();
        assert!(
            written == make(),
            "{name} is not current: `cargo run --example documents`, and look at what has changed"
        );
    }
}
