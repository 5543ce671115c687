//! Strategies and checks shared by the tests of all frames.

use super::{Command, Frame, FrameType, Key, Message, Order, OrderType};
use crate::crc;
use crate::sixbit;
use proptest::prelude::*;

/// Type and payload of a frame.
pub(super) fn content(frame: &Frame) -> &[u8] {
    let bytes = frame.as_bytes();
    &bytes[1..bytes.len() - 1 - crc::CHARACTERS]
}

pub(super) fn read_back(message: Message) -> Option<Message> {
    Message::parse(content(&message.encode(Key::robot(7))))
}

pub(super) fn sixbit_text(
    length: impl Into<prop::collection::SizeRange>,
) -> impl Strategy<Value = std::vec::Vec<u8>> {
    prop::collection::vec((0..64_u8).prop_map(sixbit::encode), length)
}

proptest! {
    #[test]
    fn readable_messages_have_one_form(
        kind in prop::sample::select(FrameType::ALL),
        order in prop::option::of(prop::sample::select(OrderType::ALL)),
        rest in sixbit_text(0..12),
    ) {
        let mut bytes = std::vec![kind.letter()];
        if let Some(order) = order {
            bytes.extend([b'!', order.letter()]);
        }
        bytes.extend(rest);
        match Message::parse(&bytes) {
            None | Some(Message::Command(Command { order: Order::Unknown, .. })) => {}
            Some(message) => {
                let frame = message.encode(Key::robot(7));
                prop_assert_eq!(content(&frame), &bytes[..]);
            }
        }
    }

    #[test]
    fn parsing_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
        let _ = Message::parse(&bytes);
    }
}

#[test]
fn frames_of_wrong_length_or_unknown_type_are_refused() {
    for content in [
        &b""[..],
        b"Z",
        b"x",
        b" ",
        b"XX",
        b"O",
        b"O!!",
        b"O!!!!",
        b"C",
        b"L!",
        b"L!!!",
        b"D!!!",
        b"D!!!!!",
        b"W",
        b"W!``",
        b"W!``!!!!",
    ] {
        assert_eq!(Message::parse(content), None, "{}", content.escape_ascii());
    }
    assert_eq!(Message::parse(b"X"), Some(Message::Stop(None)));
}
