//! Checks the crates as users get them: builds each package from its own files alone, and runs its tests offline.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::{root, run};

/// Packs and builds the crates as `cargo publish` does, and runs the tests of the unpacked crates.
pub(crate) fn check() -> Result<(), String> {
    forget_unpacked();
    super::cargo(&["publish", "--workspace", "--dry-run", "--locked"])?;
    let metadata = super::metadata(&["--no-deps"])?;
    let packages = metadata["packages"]
        .as_array()
        .ok_or("cargo metadata lists no packages")?;
    // `publish = false` is an empty list of registries.
    let published: Vec<(&str, &str)> = packages
        .iter()
        .filter(|package| package["publish"].is_null())
        .filter_map(|package| Some((package["name"].as_str()?, package["version"].as_str()?)))
        .collect();
    // The dry run builds packages but leaves none.
    let mut package = vec!["package", "--no-verify", "--locked"];
    package.extend(published.iter().flat_map(|(name, _)| ["-p", name]));
    super::cargo(&package)?;
    // Outside the repository, so that a test cannot find files of a sibling.
    let folder = std::env::temp_dir().join(format!("groundwave-crates-{}", std::process::id()));
    let result = test_in(&folder, &published);
    let _ = fs::remove_dir_all(&folder);
    result
}

/// Removes the packages that cargo unpacked for an earlier dry run: of the same version, it would take them instead of the new ones.
fn forget_unpacked() {
    let home = std::env::home_dir().map(|home| home.join(".cargo"));
    let Some(home) = std::env::var_os("CARGO_HOME").map(Into::into).or(home) else {
        return;
    };
    let unpacked = fs::read_dir(Path::new(&home).join("registry/src"));
    for entry in unpacked.into_iter().flatten().flatten() {
        // The registry of a dry run is a folder and has no name before the hyphen.
        if entry.file_name().to_string_lossy().starts_with('-') {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

fn test_in(folder: &Path, published: &[(&str, &str)]) -> Result<(), String> {
    let failed = |error| format!("cannot write {}: {error}", folder.display());
    fs::create_dir_all(folder).map_err(failed)?;
    let mut manifest =
        "[workspace]\nresolver = \"3\"\nmembers = [\"*-*\"]\n\n[patch.crates-io]\n".to_owned();
    for (name, version) in published {
        run(Command::new("tar")
            .arg("-xzf")
            .arg(root().join(format!("target/package/{name}-{version}.crate")))
            .arg("-C")
            .arg(folder))?;
        // Writing to a string cannot fail.
        let _ = writeln!(manifest, "{name} = {{ path = \"{name}-{version}\" }}");
    }
    manifest += &profiles().map_err(failed)?;
    fs::write(folder.join("Cargo.toml"), manifest).map_err(failed)?;
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock")).map_err(failed)?;
    run(Command::new(super::cargo_path())
        .current_dir(folder)
        .args(["test", "--workspace", "--all-features", "--offline"])
        .env("CARGO_TARGET_DIR", root().join("target/crates")))
}

/// The profiles of the repository, without which the searches of the protocol's tests take half an hour.
fn profiles() -> std::io::Result<String> {
    let manifest = fs::read_to_string(root().join("Cargo.toml"))?;
    let from = manifest.find("[profile.").unwrap_or(manifest.len());
    Ok(format!("\n{}", &manifest[from..]))
}
