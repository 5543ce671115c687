//! The palette on the screen, and what choosing in it does.

use crossterm::event::KeyCode;
use groundwave_protocol::letters::Mode;

use super::{demo, flight, row, screen};
use crate::event::Effect;
use crate::request::Request;

#[test]
fn a_few_letters_find_what_to_do_and_enter_does_it() {
    let mut scene = flight(demo());
    scene.ctrl('p');
    for (width, height) in [(80, 24), (120, 40), (200, 60)] {
        let all = screen(&scene, width, height);
        row(&all, "what to do");
        row(&all, "STOP (Ctrl-S while typing)");
    }
    scene.type_text("go home");
    let found = screen(&scene, 80, 24);
    row(&found, "▶ home: back to the origin");
    row(&found, "Ctrl-S STOP");
    let effects = scene.press(&[KeyCode::Enter]);
    let home = Effect::Send(Request::Mode(Mode::GoHome));
    assert_eq!(effects, [home]);
    scene.ctrl('p');
    scene.type_text("failsa");
    scene.press(&[KeyCode::Enter]);
    row(&screen(&scene, 80, 24), ":failsafe ▏");
}
