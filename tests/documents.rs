//! Generated documents match their tables.

use std::fs;

#[path = "../examples/documents.rs"]
mod made;

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
