//! Claims of a recovery, and the files that it keeps.

use crate::streams;
use std::fs;

use crate::recordings::{chunks, finished, killed};
use groundwave::capture::recover::{Outcome, recover};
use tempfile::TempDir;

/// An existing backup with this name is kept.
#[test]
fn a_damaged_file_is_kept_under_a_name_that_is_free() {
    let folder = TempDir::new().unwrap();
    let path = finished(folder.path(), &streams::clean(60));
    let mut bad = fs::read(&path).unwrap();
    let (start, length) = chunks(&path)[2];
    bad[start + length / 2] ^= 1;
    fs::write(&path, &bad).unwrap();
    let older = folder.path().join("finished.mcap.damaged");
    fs::write(&older, "older").unwrap();
    let recovery = recover(&path).unwrap();
    let kept = folder.path().join("finished.mcap.damaged-2");
    assert_eq!(recovery.original.as_deref(), Some(&*kept));
    assert_eq!(fs::read(&older).unwrap(), b"older");
    assert_eq!(fs::read(&kept).unwrap(), bad);
}

/// Our reader stops at the end mark, as other readers do; `verify` and `recover` do not.
#[test]
fn bytes_after_the_end_mark_are_cut_off_and_kept() {
    let folder = TempDir::new().unwrap();
    let path = finished(folder.path(), &streams::clean(60));
    let whole = fs::read(&path).unwrap();
    assert_eq!(recover(&path).unwrap().outcome, Outcome::Whole);
    for more in [&[0; 300][..], &whole] {
        fs::write(&path, [&whole, more].concat()).unwrap();
        let recovery = recover(&path).unwrap();
        assert_ne!(recovery.outcome, Outcome::Whole);
        assert!(recovery.original.is_some());
        assert_eq!(recover(&path).unwrap().outcome, Outcome::Whole);
    }
}

/// Only a file that ends with a whole message is reported as complete.
#[test]
fn a_torn_end_is_reported() {
    let folder = TempDir::new().unwrap();
    let path = killed(folder.path(), &streams::clean(60));
    let unfinished = fs::read(&path).unwrap();
    for (bytes, said) in [
        (unfinished.len(), "bytes that reached the disk"),
        (unfinished.len() - 1, "bytes received after byte"),
    ] {
        fs::write(&path, &unfinished[..bytes]).unwrap();
        let recovery = recover(&path).unwrap();
        let headline = recovery.headline();
        let is_whole = bytes == unfinished.len();
        assert_eq!(recovery.is_cut, !is_whole, "{headline}");
        assert_eq!(recovery.outcome, Outcome::Recovered, "{headline}");
        assert!(headline.contains(said), "{headline}");
        assert_eq!(headline.contains(" all "), is_whole, "{headline}");
    }
}

/// A finished file without its end has lost messages.
#[test]
fn a_finished_file_that_was_cut_is_kept() {
    let folder = TempDir::new().unwrap();
    let path = finished(folder.path(), &streams::clean(60));
    let (start, length) = *chunks(&path).last().unwrap();
    let mut cut = fs::read(&path).unwrap();
    cut.truncate(start + length / 2);
    fs::write(&path, &cut).unwrap();
    let recovery = recover(&path).unwrap();
    assert_eq!(recovery.outcome, Outcome::Partly, "{}", recovery.headline());
    assert!(recovery.headline().contains("the file was cut"));
    assert_eq!(fs::read(recovery.original.unwrap()).unwrap(), cut);
}
