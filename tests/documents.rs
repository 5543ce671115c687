//! The documents that are made from tables are those of the tables as they are now.

use std::fs;

#[path = "../examples/documents.rs"]
mod made;

#[test]
fn what_is_made_from_tables_is_current() {
    for (name, make) in made::DOCUMENTS {
        let written = fs::read_to_string(made::path(name)).unwrap_or_default();
        assert!(
            written == make(),
            "docs/{name} is not current: `cargo run --example documents`, and look at what has changed"
        );
    }
}
