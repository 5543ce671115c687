//! Small text files named by the operator while the dashboard runs.

use std::env;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;

use crate::capture::text_file;
use crate::event::SaveProblem;
use crate::hint;

/// Maximum number of files listed for a completion.
const LISTED_MAX: usize = 1000;

/// Reads a text file; `~/` is the home folder. Refuses pipes and devices, because opening one can block.
///
/// # Errors
/// One line for the user: the path, the reason, the remedy.
pub fn read_text(path: &str) -> Result<String, String> {
    let full = expand_home(path, env::home_dir().as_deref());
    text_file::read(&full, text_file::BYTES_MAX)
        .map_err(|error| format!("cannot read {path}: {}", hint::of_reading(&error)))
}

/// Refuses to replace a file that is not `alike`, such as a capture, a label or a configuration; an empty file may be replaced.
///
/// # Errors
/// [`SaveProblem::Failed`], which names the file.
pub fn check_replaced(path: &str, alike: impl Fn(&str) -> bool) -> Result<(), SaveProblem> {
    let full = expand_home(path, env::home_dir().as_deref());
    if fs::symlink_metadata(&full).is_err() {
        return Ok(());
    }
    match text_file::read(&full, text_file::BYTES_MAX) {
        Ok(text) if text.trim().is_empty() || alike(&text) => Ok(()),
        _ => Err(SaveProblem::Failed(format!(
            "{path} exists and is of another kind; choose another name"
        ))),
    }
}

/// Writes a complete text file or none; `~/` is the home folder. Replaces a file only with `overwrite`.
///
/// # Errors
/// Error message that the file exists, or about another problem, in one line.
pub fn write_text(path: &str, text: &str, overwrite: bool) -> Result<(), SaveProblem> {
    let full = expand_home(path, env::home_dir().as_deref());
    if !overwrite && fs::symlink_metadata(&full).is_ok() {
        return Err(SaveProblem::Exists);
    }
    let fail = |error: io::Error| {
        SaveProblem::Failed(format!("cannot write {path}: {}", hint::of_writing(&error)))
    };
    let new = beside(&full);
    File::create_new(&new)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .and_then(|()| fs::rename(&new, &full))
        .map_err(|error| {
            // An unfinished file is useless.
            let _ = fs::remove_file(&new);
            fail(error)
        })
}

/// Sorted files with these extensions and folders whose names begin with a text; if there are none, all files. Folders end with a
/// slash. Hidden files only if the text begins with a dot.
#[must_use]
pub fn beginning_with(text: &str, extensions: &[&str]) -> Vec<String> {
    let (folder, beginning) = text.split_at(text.rfind('/').map_or(0, |slash| slash + 1));
    let full = expand_home(
        if folder.is_empty() { "./" } else { folder },
        env::home_dir().as_deref(),
    );
    let Ok(entries) = fs::read_dir(full) else {
        return Vec::new();
    };
    let named = entries.flatten().filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let is_hidden = name.starts_with('.') && !beginning.starts_with('.');
        let slash = if entry.path().is_dir() { "/" } else { "" };
        (name.starts_with(beginning) && !is_hidden).then(|| format!("{folder}{name}{slash}"))
    });
    let named: Vec<String> = named.take(LISTED_MAX).collect();
    let is_wanted = |name: &&String| {
        let extension = Path::new(name.as_str()).extension();
        let extension = extension.and_then(OsStr::to_str).unwrap_or_default();
        name.ends_with('/') || (extensions.contains(&extension) && !name.ends_with(".run.toml"))
    };
    let wanted: Vec<String> = named.iter().filter(is_wanted).cloned().collect();
    let mut listed = if wanted.is_empty() { named } else { wanted };
    listed.sort();
    listed
}

/// A temporary file name in the folder of `path`, so that a rename is atomic.
#[must_use]
pub fn beside(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".unfinished-{}", process::id()));
    name.into()
}

fn expand_home(path: &str, home: Option<&Path>) -> PathBuf {
    match (path.strip_prefix("~/"), home) {
        (Some(rest), Some(home)) => home.join(rest),
        _ => path.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_home_folder_has_a_short_name() {
        let home = Some(Path::new("/home/user"));
        assert_eq!(
            expand_home("~/routes/lamp.txt", home),
            Path::new("/home/user/routes/lamp.txt")
        );
        assert_eq!(expand_home("lamp~/a.txt", home), Path::new("lamp~/a.txt"));
        assert_eq!(expand_home("~/a.txt", None), Path::new("~/a.txt"));
    }

    #[test]
    fn an_existing_file_is_replaced_only_on_request() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tour.txt");
        let path = path.to_str().unwrap();
        assert_eq!(write_text(path, "1,2\n", false), Ok(()));
        assert_eq!(write_text(path, "3,4\n", false), Err(SaveProblem::Exists));
        assert_eq!(read_text(path).unwrap(), "1,2\n");
        assert_eq!(write_text(path, "3,4\n", true), Ok(()));
        assert_eq!(read_text(path).unwrap(), "3,4\n");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        let other = format!("{path}.new");
        fs::write(&other, "mine").unwrap();
        assert_eq!(write_text(path, "5,6\n", true), Ok(()));
        assert_eq!(fs::read_to_string(other).unwrap(), "mine");
        let nowhere = folder.path().join("none").join("tour.txt");
        let error = write_text(nowhere.to_str().unwrap(), "", false).unwrap_err();
        assert!(
            matches!(error, SaveProblem::Failed(text) if text.ends_with("; create the folder first"))
        );
    }

    #[test]
    fn files_of_the_wanted_kind_are_listed_or_else_all() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.csv", "a.mcap", "a.run.toml", "a.toml", "b.svg"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        fs::create_dir(folder.path().join("ab")).unwrap();
        let at = |name: &str| format!("{}/{name}", folder.path().display());
        for (beginning, extensions, listed) in [
            ("a", ["csv"], &["a.csv", "ab/"][..]),
            ("a", ["toml"], &["a.toml", "ab/"]),
            ("b", ["csv"], &["b.svg"]),
            ("c", ["csv"], &[]),
        ] {
            let listed: Vec<String> = listed.iter().map(|name| at(name)).collect();
            assert_eq!(beginning_with(&at(beginning), &extensions), listed);
        }
    }

    #[test]
    fn only_files_of_the_same_kind_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        fs::write(at("a.mcap"), b"\x89MCAP0\r\n\xff").unwrap();
        fs::write(at("config.toml"), "[link.shed]\n").unwrap();
        fs::write(at("tour.csv"), "3,4\n").unwrap();
        fs::write(at("empty"), "").unwrap();
        fs::create_dir(at("folder")).unwrap();
        let is_route = |text: &str| crate::route::parse("", text).is_ok();
        for (name, is_replaced) in [
            ("a.mcap", false),
            ("config.toml", false),
            ("folder", false),
            ("tour.csv", true),
            ("empty", true),
            ("new", true),
        ] {
            let checked = check_replaced(&at(name), is_route);
            assert_eq!(checked.is_ok(), is_replaced, "{name}: {checked:?}");
        }
    }

    #[test]
    fn files_that_are_no_text_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = |path: &Path| read_text(path.to_str().unwrap()).unwrap_err();
        assert!(error(folder.path()).contains("name a file in it"));
        assert!(error(&folder.path().join("none")).starts_with("cannot read"));
    }
}
