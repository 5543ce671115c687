//! Writes the documents that are made from tables: `cargo run --example documents`. `tests/documents.rs` sees to it that
//! they are current.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use groundwave::request::in_whole_unit;
use sr04_firmware::parameters::Parameter;

/// Each document's name below `docs/`, and what makes it.
pub const DOCUMENTS: &[(&str, fn() -> String)] = &[("parameters.md", parameters)];

/// Where a document is.
pub fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(name)
}

#[allow(dead_code, reason = "the test that uses this file does not write")]
fn main() -> Result<(), Box<dyn Error>> {
    for (name, make) in DOCUMENTS {
        fs::write(path(name), make())?;
    }
    Ok(())
}

/// The robot's parameters, from the table of its program.
fn parameters() -> String {
    let mut text = String::from(
        "# The robot's parameters\n\n\
         Made from the table in `firmware/src/parameters.rs` by `cargo run --example documents`.\n\n\
         A parameter is read with `groundwave param LINK get NAME`, changed until the robot's next reset with\n\
         `groundwave param LINK set NAME VALUE`, and `groundwave param LINK save` keeps all of them as they are. A whole number is\n\
         what the robot counts, in the unit of the third column; a number with a decimal point is in the whole unit: `set battery-low\n\
         118` and `set battery-low 11.8` are the same. The robot itself\n\
         tells name, limits and unit, and refuses what lies outside.\n\n\
         | name | what it is | counted in | from | to | at first | which is |\n\
         |---|---|---|---:|---:|---:|---|\n",
    );
    for parameter in Parameter::ALL {
        let about = parameter.about();
        let one = parameter.definition();
        let whole = in_whole_unit(one.default.into(), one.unit);
        let whole = whole.map_or(String::new(), |(number, unit)| format!("{number} {unit}"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| `{}` | {about} | {} | {} | {} | {} | {whole} |",
            one.name, one.unit, one.least, one.most, one.default
        );
    }
    text
}
