//! Whole-system tests in one binary, with one module for each subject.
#![expect(clippy::unwrap_used, reason = "a test stops where something is wrong")]
#![cfg_attr(
    not(unix),
    allow(
        unused,
        reason = "tests on pseudo-terminals and Unix sockets are left out"
    )
)]

mod adversary;
mod advice;
mod calibrate;
mod calibration;
mod capture;
mod captures;
mod check;
mod check_send;
mod claims;
mod command_line;
mod common;
mod cosim;
mod disks;
mod documents;
mod endurance;
mod estimates;
mod failsafe;
mod failures;
mod floor_map;
mod foraging;
mod fuzz;
mod hints;
mod hostile_captures;
mod hostile_text;
mod house;
mod infrared;
mod interrupted;
mod kills;
mod ledger;
mod levels;
mod link;
mod map;
mod other_robots;
mod outages;
mod outputs;
mod own_lines;
mod parameters;
mod planned_routes;
mod processes;
#[path = "common/programs.rs"]
mod programs;
#[path = "common/pty.rs"]
mod pty;
mod ranks;
mod recording;
mod recordings;
mod recovery;
mod repaired;
mod restarts;
#[path = "../firmware/sim/tests/common/mod.rs"]
mod rig;
mod runs;
mod screens;
mod second_stations;
mod sending;
mod sharing;
mod songs;
mod statistics;
mod streams;
mod terminal;
mod text;
mod tools;
mod topics;
mod unchunked;
mod untimed_text;
mod verbs;
mod verify;
mod visits;
mod witness;
