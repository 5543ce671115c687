//! A moment shown again is equal, in random live sessions and in captures.

mod captures;
mod live;
mod long;
mod player;
mod timeline;
mod unread;
mod wording;

use std::path::Path;
use std::sync::Arc;

use super::cursor::Cursor;
use super::search::Found;
use super::timeline::STEPS_MAX;
use super::*;
use crate::capture::Session;
use crate::capture::SessionWriter;
use crate::capture::index::{self, SeekableReader};
use crate::event::{CommandId, Event, Moment};
use crate::model::{Config, Facts};
use crate::playback::{Control, Landmark, Position};
use crate::request::Request;

fn text_of(facts: &Facts) -> String {
    format!("{facts:?}")
}

/// The message about the last control; empty if there is none.
fn said(playback: Playback) -> String {
    playback.note.map(|(_, text)| text).unwrap_or_default()
}

fn capture(name: &str) -> Box<dyn SeekableReader + Send> {
    let folder = groundwave_captures::samples();
    index::open(&folder.join(name)).unwrap()
}

fn text(bytes: &[u8]) -> Box<dyn SeekableReader + Send> {
    index::read(Arc::new(bytes.to_vec()), Path::new("text")).unwrap()
}

/// A capture with all its states.
fn read_whole(reader: Box<dyn SeekableReader + Send>) -> (Timeline<CaptureState>, Moment) {
    let first = CaptureState::new("radio", Arc::default(), &*reader);
    let mut again = reader.reopen();
    let mut timeline = capture::timeline(reader, first.clone());
    let mut end = Moment::ZERO;
    read_through(
        first,
        &mut again,
        || true,
        |finding| {
            match finding {
                Finding::State(scene) => timeline.keep(*scene),
                Finding::Marks(_) => {}
                Finding::End(at) => end = at,
            }
            true
        },
    );
    timeline.complete();
    (timeline, end)
}

const CAPTURES: [&str; 4] = [
    "house-clean.txt",
    "house-noisy.txt",
    "living-room-bursts.txt",
    "demo-commands.mcap",
];
