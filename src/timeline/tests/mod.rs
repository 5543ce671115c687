//! A moment again is that moment: of live sessions made of anything, and of captures.

mod captures;
mod live;
mod player;
mod reel;
mod unread;

use std::path::Path;
use std::sync::Arc;

use super::reel::{Cursor, Found, STEPS_MAX};
use super::scene::SPACING;
use super::*;
use crate::capture::Session;
use crate::capture::composer::Composer;
use crate::capture::index::{self, SeekableReader};
use crate::event::{CommandId, Event, Moment};
use crate::model::{Config, Facts};
use crate::request::Request;
use crate::travel::{Landmark, Target, Travel};

fn told(facts: &Facts) -> String {
    format!("{facts:?}")
}

fn capture(name: &str) -> Box<dyn SeekableReader + Send> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    index::open(&folder.join(name)).unwrap()
}

fn text(bytes: &[u8]) -> Box<dyn SeekableReader + Send> {
    index::read(Arc::new(bytes.to_vec()), Path::new("text")).unwrap()
}

/// A capture with all its states.
fn surveyed(tape: Box<dyn SeekableReader + Send>) -> (Reel<Scene>, Moment) {
    let first = Scene::new("radio", Arc::default(), &*tape);
    let mut again = tape.reopen();
    let mut reel = Reel::new(tape, first.clone(), SPACING);
    let mut end = Moment::ZERO;
    survey(first, &mut again, |finding| {
        match finding {
            Finding::State(scene) => reel.keep(*scene),
            Finding::Marks(_) => {}
            Finding::End(at) => end = at,
        }
        true
    });
    reel.complete();
    (reel, end)
}

const CAPTURES: [&str; 4] = [
    "house-clean.txt",
    "house-noisy.txt",
    "living-room-bursts.txt",
    "demo-commands.mcap",
];
