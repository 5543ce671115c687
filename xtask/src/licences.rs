//! Checks that every installed crate has a permitted licence.

use std::process::Command;

use serde_json::Value;
use spdx::{Expression, LicenseReq};

/// Permissive licences; MPL-2.0, whose terms stay within its own files; OFL-1.1, which covers a font.
const ALLOWED: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "MPL-2.0",
    "OFL-1.1",
    "Unicode-3.0",
    "Unlicense",
    "WTFPL",
    "Zlib",
];

pub(crate) fn check() -> Result<(), String> {
    let output = Command::new(super::cargo_path())
        .args([
            "metadata",
            "--all-features",
            "--format-version",
            "1",
            "--locked",
        ])
        .current_dir(super::root())
        .output()
        .map_err(|error| format!("cannot run cargo metadata: {error}"))?;
    let metadata: Value = serde_json::from_slice(&output.stdout)
        .map_err(|error| format!("cannot read cargo metadata: {error}"))?;
    let packages = metadata["packages"]
        .as_array()
        .ok_or("cargo metadata lists no packages")?;
    let wrong: Vec<String> = packages.iter().filter_map(objection).collect();
    if wrong.is_empty() {
        println!("{} packages, all under licences we accept", packages.len());
        Ok(())
    } else {
        Err(format!(
            "licences we do not accept:\n  {}",
            wrong.join("\n  ")
        ))
    }
}

fn objection(package: &Value) -> Option<String> {
    let name = format!(
        "{} {}",
        package["name"].as_str()?,
        package["version"].as_str()?
    );
    let Some(licence) = package["license"].as_str() else {
        return Some(format!("{name}: names no licence"));
    };
    // Old manifests write `MIT/Apache-2.0`.
    match Expression::parse(&licence.replace('/', " OR ")) {
        Ok(expression) if expression.evaluate(is_allowed) => None,
        Ok(_) => Some(format!("{name}: {licence}")),
        Err(error) => Some(format!("{name}: cannot read `{licence}`: {error}")),
    }
}

fn is_allowed(requirement: &LicenseReq) -> bool {
    requirement
        .license
        .id()
        .is_some_and(|id| ALLOWED.contains(&id.name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn gpl_is_found_and_a_choice_is_enough() {
        let package =
            |licence: &str| json!({ "name": "x", "version": "1.0.0", "license": licence });
        assert_eq!(objection(&package("MIT OR GPL-3.0-only")), None);
        assert_eq!(objection(&package("MIT/Apache-2.0")), None);
        assert_eq!(objection(&package("Apache-2.0 WITH LLVM-exception")), None);
        assert!(objection(&package("GPL-3.0-only")).is_some());
        assert!(objection(&package("MIT AND GPL-2.0-or-later")).is_some());
        assert!(objection(&json!({ "name": "x", "version": "1.0.0" })).is_some());
    }
}
