//! Runs: lists, comparisons, names and notes.

use super::*;
use crate::event::Remark;
use crate::model::runs::Runs;

#[test]
fn a_note_without_words_is_asked_for_them() {
    for (text, told) in [
        ("note", "note TEXT"),
        ("name", "name TEXT"),
        ("counts 3", "stands alone"),
    ] {
        let mut scene = scene();
        scene.type_text(&format!(":{text}"));
        assert_eq!(scene.press(&[KeyCode::Enter]), []);
        let Overlay::Text(entry) = &scene.model.ui.overlay else {
            panic!("the text stays to be mended");
        };
        let error = entry.error.as_deref().unwrap_or_default();
        assert!(error.contains(told), "{text}: {error}");
    }
}

#[test]
fn label_of_a_run_is_kept_beside_its_recording() {
    let mut scene = scene();
    scene.type_text(":note the glass door");
    assert_eq!(scene.press(&[KeyCode::Enter]), []);
    let Overlay::Text(entry) = &scene.model.ui.overlay else {
        panic!("the text stays to be mended");
    };
    assert!(entry.error.as_ref().is_some_and(|e| e.contains("R begins")));
    scene.press(&[KeyCode::Esc]);
    scene.event(Event::Recording(crate::event::Recording {
        mcap: Some("evening.mcap".to_owned()),
        ..crate::event::Recording::default()
    }));
    for (text, remark) in [
        ("name new wheels", Remark::Name("new wheels".to_owned())),
        (
            "name \"new wheels, third try\"",
            Remark::Name("new wheels, third try".to_owned()),
        ),
        (
            "note 'fast' and \"loose\"",
            Remark::Note("'fast' and \"loose\"".to_owned()),
        ),
        ("note \"the door\"", Remark::Note("the door".to_owned())),
        ("void 'the cat'", Remark::Void("the cat".to_owned())),
        (
            "note the glass door",
            Remark::Note("the glass door".to_owned()),
        ),
        ("void the cat", Remark::Void("the cat".to_owned())),
        ("void", Remark::Void(String::new())),
        ("counts", Remark::Counts),
    ] {
        scene.type_text(":");
        scene.type_text(text);
        let label = Effect::Label {
            capture: "evening.mcap".to_owned(),
            remark,
            ago: Moment::ZERO,
        };
        assert_eq!(scene.press(&[KeyCode::Enter]), [label], "{text}");
    }
}

#[test]
fn runs_are_listed_beside_the_recording_and_two_are_compared() {
    let mut scene = scene();
    let asked = |scene: &mut Scene, text: &str| {
        scene.type_text(text);
        scene.press(&[KeyCode::Enter])
    };
    let list = |folder: &str| [Effect::ListRuns(folder.to_owned())];
    let compare = |a: &str, b: &str| [Effect::CompareRuns([a, b].map(str::to_owned))];
    assert_eq!(asked(&mut scene, ":runs"), list("."));
    scene.press(&[KeyCode::Esc]);
    scene.event(Event::Recording(crate::event::Recording {
        mcap: Some("evenings/first.mcap".to_owned()),
        ..crate::event::Recording::default()
    }));
    assert_eq!(asked(&mut scene, ":runs"), list("evenings"));
    scene.event(Event::Runs(Ok(listed())));
    // The newest run that is finished is chosen: picked, dropped and picked again; then another run.
    let c = KeyCode::Char('c');
    scene.press(&[c, c, c]);
    let wanted = compare("runs/morning.mcap", "runs/evening.mcap");
    assert_eq!(scene.press(&[KeyCode::Up, c]), wanted);
    scene.event(Event::Overlaid(Ok(overlaid())));
    let Overlay::Runs(Runs::Overlaid(_)) = &scene.model.ui.overlay else {
        panic!("{:?}", scene.model.ui.overlay);
    };
    // Closing it returns to the list.
    scene.press(&[KeyCode::Esc]);
    let Overlay::Runs(Runs::Listed { chosen: 0, .. }) = &scene.model.ui.overlay else {
        panic!("{:?}", scene.model.ui.overlay);
    };
    scene.press(&[KeyCode::Esc]);
    assert_eq!(scene.model.ui.overlay, Overlay::None);
    assert_eq!(asked(&mut scene, ":runs elsewhere"), list("elsewhere"));
    // A closed overlay stays closed.
    scene.press(&[KeyCode::Esc]);
    scene.event(Event::Runs(Ok(listed())));
    assert_eq!(scene.model.ui.overlay, Overlay::None);
    assert_eq!(asked(&mut scene, ":compare a b"), compare("a", "b"));
    scene.press(&[KeyCode::Esc]);
    let blanks = asked(&mut scene, ":compare \"my evening.mcap\" 'b c'");
    assert_eq!(blanks, compare("my evening.mcap", "b c"));
    scene.press(&[KeyCode::Esc]);
    assert_eq!(asked(&mut scene, ":runs \"my runs\""), list("my runs"));
    scene.event(Event::Overlaid(Err("a: no".to_owned())));
    let failed = Overlay::Runs(Runs::Failed("a: no".to_owned()));
    assert_eq!(scene.model.ui.overlay, failed);
}

#[test]
fn enter_replays_a_run_and_asks_before_it_leaves_a_robot() {
    let chosen = |config: Config| {
        let mut scene = Scene::new(config);
        scene.type_text(":runs");
        scene.press(&[KeyCode::Enter]);
        scene.event(Event::Runs(Ok(listed())));
        scene
    };
    let replay = [Effect::Replay("runs/morning.mcap".to_owned())];
    let mut live = chosen(Config::default());
    assert_eq!(live.press(&[KeyCode::Enter]), []);
    let Overlay::Question(question) = &live.model.ui.overlay else {
        panic!("{:?}", live.model.ui.overlay);
    };
    assert!(question.text.contains("replay runs/morning.mcap"));
    assert_eq!(live.press(&[KeyCode::Char('y')]), replay);
    let mut shown = chosen(Config {
        capture: Some("runs/evening.mcap".to_owned()),
        ..Config::default()
    });
    shown.model.ui.show_moment(Some(playback(false)));
    // The replayed run is selected.
    assert_eq!(shown.press(&[KeyCode::Down, KeyCode::Enter]), replay);
}

#[test]
fn the_run_being_recorded_is_not_selected_first() {
    let mut scene = scene();
    scene.event(Event::Recording(crate::event::Recording {
        mcap: Some("runs/morning.mcap".to_owned()),
        ..crate::event::Recording::default()
    }));
    scene.type_text(":runs");
    scene.press(&[KeyCode::Enter]);
    scene.event(Event::Runs(Ok(listed())));
    scene.press(&[KeyCode::Enter]);
    let Overlay::Question(question) = &scene.model.ui.overlay else {
        panic!("{:?}", scene.model.ui.overlay);
    };
    assert!(question.text.contains("replay runs/evening.mcap"));
}

#[test]
fn file_names_with_spaces_need_quotes() {
    let mut scene = scene();
    let load = [Effect::LoadRoute("my tour.csv".to_owned())];
    for text in [
        ":route \"my tour.csv\"",
        ":route my tour.csv",
        "r\"my tour.csv\"",
        "rmy tour.csv",
    ] {
        scene.type_text(text);
        assert_eq!(scene.press(&[KeyCode::Enter]), load, "{text}");
        scene.press(&[KeyCode::Esc]);
    }
    for (text, told) in [
        (":compare my evening.mcap b", "`compare` takes two captures"),
        (":compare a", "quote a name with spaces"),
        (":runs my evenings", "`runs` takes one folder"),
        (":compare \"a b", "a quote is not closed"),
    ] {
        scene.type_text(text);
        assert_eq!(scene.press(&[KeyCode::Enter]), [], "{text}");
        let Overlay::Text(entry) = &scene.model.ui.overlay else {
            panic!("{text}: the prompt stays");
        };
        let error = entry.error.as_deref().unwrap_or_default();
        assert!(error.contains(told), "{text}: {error}");
        scene.press(&[KeyCode::Esc]);
    }
}

#[test]
fn shown_run_is_named_and_past_moments_take_notes() {
    let mut scene = Scene::new(Config {
        capture: Some("old/house.mcap".to_owned()),
        ..Config::default()
    });
    scene.type_text(":name the house");
    let label = Effect::Label {
        capture: "old/house.mcap".to_owned(),
        remark: Remark::Name("the house".to_owned()),
        ago: Moment::ZERO,
    };
    assert_eq!(scene.press(&[KeyCode::Enter]), [label]);
}
