//! The counts of a run, and the expected counts.

use crate::corruption::Kind;
use crate::damage::bytes_of;
use groundwave_protocol::decoder::{Counters, Received};
use std::fmt;

/// Maximum number of wrong lines shown at the end.
const SHOWN_MAX: usize = 20;

/// Probability that a checksum of 24 bits is valid by chance.
const BY_ACCIDENT: f64 = 1.0 / (1 << 24) as f64;

/// Counts of the lines with one kind of damage.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub lines: u64,
    /// Number of lines with at most five wrong bits and no lost byte; the checksum must reject them.
    pub guaranteed: u64,
    /// Number of lines received as sent, with damage beside them.
    pub intact: u64,
    /// Number of other lines that got a new checksum.
    pub sealed: u64,
    /// Number of lines with a new checksum that were readable.
    pub sealed_readable: u64,
    wrong: u64,
    wrong_against_the_guarantee: u64,
    shown: Vec<Vec<u8>>,
    crc_rejected: u64,
    shape_rejected: u64,
    field_rejected: u64,
}

impl Tally {
    pub fn accept(&mut self, line: &Received) {
        self.wrong += 1;
        self.shown.push(bytes_of(line));
    }

    pub fn accept_against_the_guarantee(&mut self, line: &Received) {
        self.wrong_against_the_guarantee += 1;
        self.accept(line);
    }

    pub fn take_counters(&mut self, counters: &Counters) {
        self.crc_rejected += counters.crc_rejected;
        self.shape_rejected += counters.shape_rejected;
        self.field_rejected += counters.field_rejected;
    }

    fn add(&mut self, other: &Self) {
        self.lines += other.lines;
        self.guaranteed += other.guaranteed;
        self.intact += other.intact;
        self.sealed += other.sealed;
        self.sealed_readable += other.sealed_readable;
        self.wrong += other.wrong;
        self.wrong_against_the_guarantee += other.wrong_against_the_guarantee;
        self.shown.extend_from_slice(&other.shown);
        self.crc_rejected += other.crc_rejected;
        self.shape_rejected += other.shape_rejected;
        self.field_rejected += other.field_rejected;
    }

    /// Share of damaged lines that are readable with a new checksum.
    fn readable(&self) -> f64 {
        self.sealed_readable as f64 / (self.sealed as f64).max(1.0)
    }

    /// Expected number of wrong lines, if the checksum always detects up to five wrong bits, and other damage with the probability of chance.
    fn expected(&self) -> f64 {
        (self.lines - self.guaranteed) as f64 * BY_ACCIDENT * self.readable()
    }
}

/// Counts of all kinds of damage.
#[derive(Clone, Debug, Default)]
pub struct Totals([Tally; Kind::ALL.len()]);

impl Totals {
    pub fn add(&mut self, kind: Kind, tally: &Tally) {
        self.0[kind as usize].add(tally);
    }

    pub fn guarantee_holds(&self) -> bool {
        self.0.iter().all(|t| t.wrong_against_the_guarantee == 0)
    }
}

impl fmt::Display for Totals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<10} {:>11} {:>11} {:>6} {:>9} {:>11} {:>11} {:>7} {:>9} {:>9} {:>6}",
            "damage",
            "lines",
            "<= 5 bits",
            "taken",
            "intact",
            "checksum",
            "shape",
            "fields",
            "readable",
            "expected",
            "found"
        )?;
        let mut all = Tally::default();
        let mut expected = 0.0;
        for (kind, tally) in Kind::ALL.iter().zip(&self.0) {
            row(f, &format!("{kind:?}"), tally, tally.expected())?;
            all.add(tally);
            expected += tally.expected();
        }
        row(f, "all", &all, expected)?;
        for line in all.shown.iter().take(SHOWN_MAX) {
            writeln!(f, "wrong and accepted: {}", line.escape_ascii())?;
        }
        Ok(())
    }
}

fn row(f: &mut fmt::Formatter<'_>, name: &str, t: &Tally, expected: f64) -> fmt::Result {
    writeln!(
        f,
        "{name:<10} {:>11} {:>11} {:>6} {:>9} {:>11} {:>11} {:>7} {:>9.4} {expected:>9.3} {:>6}",
        t.lines,
        t.guaranteed,
        t.wrong_against_the_guarantee,
        t.intact,
        t.crc_rejected,
        t.shape_rejected,
        t.field_rejected,
        t.readable(),
        t.wrong,
    )
}
