//! What a recovery claims, and what it keeps where it can claim nothing.

use crate::streams;
use std::fs;

use crate::recordings::{chunks, finished, killed};
use groundwave::capture::recover::{End, Outcome, recover};
use tempfile::TempDir;

/// An older file of that name is another's evidence.
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

/// Our reader stops at the end mark, as others do; `verify` and the next station do not.
#[test]
fn what_follows_the_end_mark_is_cut_off_and_kept() {
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

/// "All" is said only of what the journal proves.
#[test]
fn an_end_that_nobody_knows_is_told() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(60);
    let paths = killed(folder.path(), &stream);
    let partial = fs::read(&paths.partial).unwrap();
    let journal = fs::read(&paths.journal).unwrap();
    for (kept, end, said) in [
        (
            Some(journal.len()),
            End::Known,
            "bytes that reached the disk",
        ),
        (
            Some(journal.len() - 1),
            End::JournalCut,
            "the journal ends in the middle of an entry: what came after byte",
        ),
        (
            None,
            End::NoJournal,
            "the journal is missing: what came after byte",
        ),
        (
            Some(0),
            End::JournalShort,
            "the journal ends before the recording",
        ),
    ] {
        fs::write(&paths.partial, &partial).unwrap();
        if let Some(bytes) = kept {
            fs::write(&paths.journal, &journal[..bytes]).unwrap();
        }
        let recovery = recover(&paths.target).unwrap();
        let headline = recovery.headline();
        assert_eq!(recovery.end, end, "{headline}");
        assert_eq!(recovery.outcome, Outcome::Recovered, "{headline}");
        assert!(headline.contains(said), "{headline}");
        assert_eq!(headline.contains(" all "), end == End::Known, "{headline}");
        fs::remove_file(&paths.target).unwrap();
    }
}

/// The unfinished file cannot be read and the journal is no proof that nothing was in it.
#[test]
fn what_the_journal_does_not_replace_is_kept() {
    let folder = TempDir::new().unwrap();
    let paths = killed(folder.path(), &streams::clean(60));
    let mut partial = fs::read(&paths.partial).unwrap();
    let journal = fs::read(&paths.journal).unwrap();
    let chunks = chunks(&paths.partial);
    for (start, length) in &chunks {
        partial[start + length / 2] ^= 1;
    }
    let mut damaged = journal.clone();
    damaged[40] ^= 1;
    for (journal, outcome) in [
        (&journal[..], Outcome::Recovered),
        (&[], Outcome::Partly),
        (&damaged, Outcome::Partly),
    ] {
        fs::write(&paths.partial, &partial).unwrap();
        fs::write(&paths.journal, journal).unwrap();
        let recovery = recover(&paths.target).unwrap();
        let headline = recovery.headline();
        assert_eq!(recovery.damage.len(), chunks.len(), "{headline}");
        assert_eq!(recovery.outcome, outcome, "{headline}");
        let kept = recovery.original.map(|kept| fs::read(kept).unwrap());
        let is_kept = kept.as_ref() == Some(&partial);
        assert_eq!(is_kept, outcome == Outcome::Partly, "{headline}");
        fs::remove_file(&paths.target).unwrap();
    }
}

/// The last chunk is damaged and stands at the end; the journal ends before it.
#[test]
fn a_journal_that_ends_before_the_damage_proves_nothing_of_it() {
    let folder = TempDir::new().unwrap();
    let paths = killed(folder.path(), &streams::clean(60));
    let mut partial = fs::read(&paths.partial).unwrap();
    let (start, length) = *chunks(&paths.partial).last().unwrap();
    partial.truncate(start + length);
    partial[start + length / 2] ^= 1;
    fs::write(&paths.partial, partial).unwrap();
    fs::write(&paths.journal, "").unwrap();
    let recovery = recover(&paths.target).unwrap();
    assert_eq!(recovery.end, End::JournalShort);
    assert_eq!(recovery.outcome, Outcome::Partly, "{}", recovery.headline());
}
