//! Worlds by name: built-in, generated and from files.

use std::fs;
use std::io;
use std::path::Path;

use crate::world::{BUILT_IN, World, WorldError};

/// Limits the length of a world file, bytes.
const BYTES_MAX: u64 = 256 << 10;

impl World {
    /// Names of the built-in worlds, the default first.
    pub fn built_in_names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// A built-in world; `None` if none has this name.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        Self::parse(name, built_in_text(name)?).ok()
    }

    /// Opens a built-in world by name, a generated house as `generated:SEED`, or a world file by path.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or has an error.
    pub fn open(name_or_path: &str) -> Result<Self, WorldError> {
        Self::parse(name_or_path, &Self::source(name_or_path)?)
    }

    /// The text of a world that [`World::open`] would open, even with errors in it.
    ///
    /// # Errors
    ///
    /// If the file cannot be read.
    pub fn source(name_or_path: &str) -> Result<String, WorldError> {
        if let Some(text) = built_in_text(name_or_path) {
            return Ok(text.to_owned());
        }
        let seed = name_or_path.strip_prefix("generated:");
        if let Some(seed) = seed.and_then(|seed| seed.parse().ok()) {
            return Ok(Self::generated_text(seed));
        }
        let path = Path::new(name_or_path);
        read_text(path).map_err(|source| WorldError::Read {
            path: path.to_owned(),
            source,
        })
    }
}

/// Reads a regular file of at most [`BYTES_MAX`]: opening a pipe can block.
pub(crate) fn read_text(path: &Path) -> io::Result<String> {
    let about = fs::metadata(path)?;
    if !about.is_file() && !about.is_dir() {
        return Err(io::Error::other("it is not a regular file"));
    }
    if about.len() > BYTES_MAX {
        return Err(io::Error::other("it is longer than 256 KiB"));
    }
    fs::read_to_string(path)
}

fn built_in_text(name: &str) -> Option<&'static str> {
    let (_, text) = BUILT_IN.iter().find(|(known, _)| *known == name)?;
    Some(text)
}

impl Default for World {
    /// The built-in world `house`.
    fn default() -> Self {
        // A test parses every built-in world.
        Self::built_in(BUILT_IN[0].0).expect("the built-in house is a valid world")
    }
}
