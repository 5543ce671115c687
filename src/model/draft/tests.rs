//! Changes of a draft.

use super::*;
use proptest::prelude::*;

fn waypoints(places: &[(i16, i16)]) -> Vec<Waypoint> {
    places
        .iter()
        .map(|&(x_in, y_in)| Waypoint { x_in, y_in })
        .collect()
}

fn drafted(places: &[(i16, i16)]) -> Draft {
    let mut draft = Draft::default();
    draft.replace(&waypoints(places));
    draft
}

#[expect(clippy::unnecessary_wraps, reason = "what an edit asks for")]
fn robot(x_in: f64, y_in: f64) -> Option<Pose> {
    Some(Pose {
        x_in,
        y_in,
        theta_deg: 0.0,
    })
}

#[test]
fn the_first_lies_where_the_robot_is_and_the_next_go_on() {
    let mut draft = Draft::default();
    let here = robot(5.0, 7.0);
    draft.edit(Edit::Append, here).unwrap();
    draft.edit(Edit::Append, here).unwrap();
    draft.edit(Edit::Move(6.0, 0.0), here).unwrap();
    draft.edit(Edit::Append, here).unwrap();
    assert_eq!(draft.waypoints(), waypoints(&[(5, 7), (11, 19), (17, 31)]));
    draft.select(-1);
    draft.edit(Edit::Insert, here).unwrap();
    assert_eq!(draft.waypoints()[1], Waypoint { x_in: 8, y_in: 13 });
    assert_eq!(draft.selected(), Some(1));
    draft.edit(Edit::Delete, here).unwrap();
    assert_eq!(draft.waypoints(), waypoints(&[(5, 7), (11, 19), (17, 31)]));
}

#[test]
fn a_route_drafted_beside_a_robot_that_drives_on_goes_where_it_looks() {
    let mut draft = Draft::default();
    // To the east, and the first point is behind it when the next is added.
    let at = |x_in| {
        Some(Pose {
            x_in,
            y_in: 0.0,
            theta_deg: 90.0,
        })
    };
    for x_in in [0.0, 4.0, 8.0] {
        draft.edit(Edit::Append, at(x_in)).unwrap();
    }
    assert_eq!(draft.waypoints(), waypoints(&[(0, 0), (12, 0), (24, 0)]));
    draft.select(-2);
    draft.edit(Edit::Insert, at(9.0)).unwrap();
    assert_eq!(draft.waypoints()[0], Waypoint { x_in: -12, y_in: 0 });
}

#[test]
fn a_square_is_turned_mirrored_scaled_shifted_and_reversed() {
    let mut draft = drafted(&[(0, 0), (10, 0), (10, 20), (0, 20)]);
    draft.edit(Edit::Rotate(90.0), None).unwrap();
    assert_eq!(
        draft.waypoints(),
        waypoints(&[(-5, 15), (-5, 5), (15, 5), (15, 15)])
    );
    draft.edit(Edit::Rotate(-90.0), None).unwrap();
    draft.edit(Edit::Mirror, None).unwrap();
    assert_eq!(
        draft.waypoints(),
        waypoints(&[(10, 0), (0, 0), (0, 20), (10, 20)])
    );
    draft.edit(Edit::Scale(2.0), None).unwrap();
    assert_eq!(
        draft.waypoints(),
        waypoints(&[(15, -10), (-5, -10), (-5, 30), (15, 30)])
    );
    draft.edit(Edit::Shift(5.0, 10.0), None).unwrap();
    draft.edit(Edit::Reverse, None).unwrap();
    assert_eq!(
        draft.waypoints(),
        waypoints(&[(20, 40), (0, 40), (0, 0), (20, 0)])
    );
}

#[test]
fn refused_edit_has_a_reason_and_changes_nothing() {
    let mut draft = Draft::default();
    assert_eq!(draft.edit(Edit::Delete, None), Err(DraftError::Empty));
    assert_eq!(draft.undo(), Err(DraftError::NothingToUndo));
    assert_eq!(draft.redo(), Err(DraftError::NothingToRedo));
    let mut draft = drafted(&[(9990, 0), (0, 0)]);
    assert_eq!(
        draft.edit(Edit::Shift(10.0, 0.0), None),
        Err(DraftError::TooFar)
    );
    assert_eq!(draft.waypoints(), waypoints(&[(9990, 0), (0, 0)]));
    let mut draft = drafted(&[(0, 0); WAYPOINTS_MAX]);
    assert_eq!(draft.edit(Edit::Append, None), Err(DraftError::Full));
}

#[test]
fn legs_begin_at_the_robot() {
    let draft = drafted(&[(0, 10), (30, 50)]);
    assert_eq!(draft.legs_in(robot(0.0, 0.0)), [10.0, 50.0]);
    assert_eq!(draft.legs_in(None), [0.0, 50.0]);
}

fn any_edit() -> impl Strategy<Value = Edit> {
    prop_oneof![
        Just(Edit::Append),
        Just(Edit::Insert),
        (-9000.0..9000.0, -9000.0..9000.0).prop_map(|(x, y)| Edit::AppendAt(x, y)),
        Just(Edit::Delete),
        (-50.0..50.0, -50.0..50.0).prop_map(|(x, y)| Edit::Move(x, y)),
        (-50.0..50.0, -50.0..50.0).prop_map(|(x, y)| Edit::Shift(x, y)),
        (-180.0..180.0).prop_map(Edit::Rotate),
        Just(Edit::Mirror),
        (0.5..2.0).prop_map(Edit::Scale),
        Just(Edit::Reverse),
        Just(Edit::Clear),
    ]
}

proptest! {
    #[test]
    fn every_change_can_be_taken_back_and_made_again(
        edits in proptest::collection::vec(any_edit(), 1..UNDO_MAX),
    ) {
        let mut draft = Draft::default();
        let mut versions = vec![draft.waypoints().to_vec()];
        for edit in edits {
            let before = draft.past.len();
            let _ = draft.edit(edit, robot(0.0, 0.0));
            if draft.past.len() > before {
                versions.push(draft.waypoints().to_vec());
            }
            prop_assert!(draft.selected().is_none_or(|n| n < draft.waypoints().len()));
        }
        for version in versions.iter().rev().skip(1) {
            draft.undo().unwrap();
            prop_assert_eq!(draft.waypoints(), &version[..]);
        }
        prop_assert_eq!(draft.undo(), Err(DraftError::NothingToUndo));
        for version in &versions[1..] {
            draft.redo().unwrap();
            prop_assert_eq!(draft.waypoints(), &version[..]);
        }
    }

    #[test]
    fn turning_to_and_fro_leaves_a_route_as_it_was(
        places in proptest::collection::vec((-500_i16..500, -500_i16..500), 1..40),
        turns in proptest::collection::vec(-90.0..90.0_f64, 1..12),
    ) {
        let mut draft = drafted(&places);
        // About a middle that moves when the bounds do, only the same way back leads back.
        for deg in &turns {
            draft.edit(Edit::Rotate(*deg), None).unwrap();
        }
        // A single place does not turn: there is nothing to undo then.
        while draft.past.len() > 1 {
            draft.undo().unwrap();
        }
        prop_assert_eq!(draft.waypoints(), waypoints(&places));
        let sum: f64 = draft.legs_in(None).iter().sum();
        draft.edit(Edit::Rotate(37.0), None).unwrap();
        let turned: f64 = draft.legs_in(None).iter().sum();
        prop_assert!((sum - turned).abs() <= 2.0 * places.len() as f64);
    }
}
