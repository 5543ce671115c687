//! Checks that every installed crate has a permitted licence, and collects the licences that a release must carry.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

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
    let metadata = super::metadata(&["--all-features"])?;
    let packages = list(&metadata["packages"]);
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

/// The crates that are linked into the program for a target, each with its licence, and the texts of these licences.
pub(crate) fn notices(target: &str) -> Result<String, String> {
    let metadata = super::metadata(&["--filter-platform", target])?;
    let mut texts: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in linked(&metadata)? {
        let name = format!(
            "{} {} ({}, {})",
            text(&package["name"]),
            text(&package["version"]),
            text(&package["license"]),
            text(&package["repository"])
        );
        for licence in licence_texts(package)? {
            texts.entry(licence).or_default().insert(name.clone());
        }
    }
    let mut notices = String::new();
    for (text, names) in texts {
        let names: Vec<String> = names.into_iter().collect();
        // Writing to a string cannot fail.
        let _ = write!(notices, "{}:\n\n{text}\n\n---\n\n", names.join("\n"));
    }
    Ok(notices)
}

/// The program's dependencies from other authors, without what only builds or tests it.
fn linked(metadata: &Value) -> Result<Vec<&Value>, String> {
    let packages = list(&metadata["packages"]);
    let root = packages
        .iter()
        .find(|package| package["name"] == "groundwave")
        .ok_or("cargo metadata lists no groundwave")?;
    let mut found = BTreeMap::new();
    let mut open = vec![&root["id"]];
    while let Some(id) = open.pop() {
        let package = packages.iter().find(|package| package["id"] == *id);
        let Some(package) = package.filter(|package| !is_macro(package)) else {
            continue;
        };
        if found.insert(text(id), package).is_none() {
            let nodes = list(&metadata["resolve"]["nodes"]).iter();
            let dependencies = nodes
                .filter(|node| node["id"] == *id)
                .flat_map(|node| list(&node["deps"]));
            let linked = dependencies.filter(|dependency| {
                let kinds = list(&dependency["dep_kinds"]);
                kinds.iter().any(|kind| kind["kind"].is_null())
            });
            open.extend(linked.map(|dependency| &dependency["pkg"]));
        }
    }
    let packages = found.into_values();
    Ok(packages
        .filter(|package| !package["source"].is_null())
        .collect())
}

/// Whether a crate runs in the compiler.
fn is_macro(package: &Value) -> bool {
    let targets = list(&package["targets"]).iter();
    targets
        .flat_map(|target| list(&target["kind"]))
        .any(|kind| kind == "proc-macro")
}

/// The files that a crate brings, or the standard texts if it brings none.
fn licence_texts(package: &Value) -> Result<Vec<String>, String> {
    let folder = Path::new(text(&package["manifest_path"]))
        .parent()
        .unwrap_or(Path::new(""));
    let failed = |error| format!("cannot read {}: {error}", folder.display());
    let mut texts = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .to_uppercase();
        let is_licence = ["LICEN", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE"]
            .iter()
            .any(|start| name.starts_with(start));
        if is_licence && path.is_file() {
            texts.push(fs::read_to_string(&path).map_err(failed)?.trim().to_owned());
        }
    }
    if texts.is_empty() {
        let expression = expression(text(&package["license"]))
            .map_err(|error| format!("{}: {error}", package["name"]))?;
        let ids = expression
            .requirements()
            .filter_map(|term| term.req.license.id());
        texts.extend(ids.map(|id| id.text().trim().to_owned()));
    }
    Ok(texts)
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or("no address")
}

/// Old manifests write `MIT/Apache-2.0`.
fn expression(licence: &str) -> Result<Expression, String> {
    Expression::parse(&licence.replace('/', " OR ")).map_err(|error| error.to_string())
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
    match expression(licence) {
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
    fn notices_have_what_is_linked_and_only_that() {
        let package = |name: &str, kind: &str| json!({ "id": name, "name": name, "source": "registry", "targets": [{ "kind": [kind] }] });
        let mut root = package("groundwave", "lib");
        root["source"] = Value::Null;
        let needs = |id: &str, kind: Value| json!({ "pkg": id, "dep_kinds": [{ "kind": kind }] });
        let metadata = json!({
            "packages": [
                root, package("linked", "lib"), package("deep", "lib"), package("derive", "proc-macro"),
                package("tester", "lib"), package("builder", "lib"),
            ],
            "resolve": { "nodes": [
                { "id": "groundwave", "deps": [
                    needs("linked", Value::Null), needs("derive", Value::Null),
                    needs("tester", json!("dev")), needs("builder", json!("build")),
                ] },
                { "id": "linked", "deps": [needs("deep", Value::Null)] },
            ] },
        });
        let linked = linked(&metadata).expect("a program");
        let names: Vec<&str> = linked
            .iter()
            .map(|package| text(&package["name"]))
            .collect();
        assert_eq!(names, ["deep", "linked"]);
    }

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
