//! Long parts of a capture without a line, which keys and signals must not wait for.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::capture::index::{Piece, Place};
use crate::event::Truth;

/// A capture that counts the returned pieces.
struct Counted {
    capture: Box<dyn SeekableReader + Send>,
    pieces: Arc<AtomicUsize>,
}

impl SeekableReader for Counted {
    fn next_at(&mut self) -> Option<Moment> {
        self.capture.next_at()
    }

    fn next_piece(&mut self) -> Option<Piece<'_>> {
        self.pieces.fetch_add(1, Ordering::Relaxed);
        self.capture.next_piece()
    }

    fn place(&self) -> Place {
        self.capture.place()
    }

    fn seek(&mut self, place: Place) {
        self.capture.seek(place);
    }

    fn find(&mut self, at: Moment) -> Place {
        self.capture.find(at)
    }

    fn about_line(&mut self, number: u64) -> Option<(Moment, u64)> {
        self.capture.about_line(number)
    }

    fn may_hold(&mut self, landmark: Landmark, from: Moment, until: Moment) -> bool {
        self.capture.may_hold(landmark, from, until)
    }

    fn length(&self) -> Moment {
        self.capture.length()
    }

    fn unix(&self) -> Option<Moment> {
        self.capture.unix()
    }

    fn truth(&self) -> Option<Truth> {
        self.capture.truth()
    }

    fn reopen(&self) -> Box<dyn SeekableReader + Send> {
        self.capture.reopen()
    }
}

/// Maximum number of pieces read after a key before keys and signals are handled again.
const PIECES_MAX: usize = 25_000;

#[test]
fn no_key_waits_for_a_long_part_without_a_line() {
    let lines = std::fs::read(groundwave_captures::samples().join("house-clean.txt")).unwrap();
    let (begin, end) = lines.split_at(8000);
    let noise = vec![b'x'; 16 << 20];
    let stamped: Vec<u8> = begin
        .split_inclusive(|byte| *byte == b'\n')
        .flat_map(|line| [b"20:46:48 ", line].concat())
        .collect();
    for begin in [begin, &stamped] {
        let pieces = Arc::<AtomicUsize>::default();
        let capture: Box<dyn SeekableReader + Send> = Box::new(Counted {
            capture: text(&[begin, &noise, end].concat()),
            pieces: Arc::clone(&pieces),
        });
        let length = capture.length();
        let first = CaptureState::new("radio", Arc::default(), &*capture);
        let timeline = capture::timeline(capture, first);
        let mut player = Player::of_capture(timeline, Moment::ZERO, 1.0, length, None);
        for control in [
            Control::Seek(Position::At(Moment::from_mins(1))),
            Control::Step { forward: true },
            Control::Newest,
            Control::Step { forward: false },
            Control::Seek(Position::Percent(50.0)),
            Control::Step { forward: true },
            Control::Seek(Position::Line(150)),
            Control::Jump {
                to: Some(Landmark::Bump),
                forward: true,
            },
        ] {
            pieces.store(0, Ordering::Relaxed);
            player.handle(Moment::ZERO, control);
            let taken = pieces.load(Ordering::Relaxed);
            assert!(taken < PIECES_MAX, "{taken} pieces for {control:?}");
            for _ in 0..3 {
                pieces.store(0, Ordering::Relaxed);
                player.work(512);
                let taken = pieces.load(Ordering::Relaxed);
                assert!(taken < PIECES_MAX, "{taken} pieces after {control:?}");
            }
        }
    }
}
