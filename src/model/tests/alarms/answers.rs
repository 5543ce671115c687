//! Answers to alarms: acknowledged and shelved.

use super::*;

#[test]
fn alarms_are_acknowledged_one_by_one() {
    let mut scene = scene();
    scene.state.power = Power::Critical;
    scene.hear();
    let effects = scene.type_text("E");
    assert_eq!(
        raised(&scene),
        [
            ("battery critical", true, true),
            ("battery low", true, false)
        ]
    );
    let Some(Effect::AnswerAlarm(event)) = effects.first() else {
        panic!("{effects:?}");
    };
    assert_eq!(event.code, "battery_critical");
    assert_eq!(event.status, AlarmStatus::Acknowledged);
    say(&mut scene, ":acknowledge battery low");
    assert_eq!(scene.calling(), 0);
    let effects = scene.type_text("E");
    assert!(
        effects
            .iter()
            .all(|effect| matches!(effect, Effect::Notice(_)))
    );
}

#[test]
fn an_acknowledged_alarm_can_be_shelved_by_its_key() {
    let mut scene = scene();
    scene.state.power = Power::Critical;
    scene.hear();
    scene.type_text("A");
    for shelved_for in [Some(600), Some(3600), Some(28_800), None] {
        let effects = scene.type_text("Z");
        let Some(Effect::AnswerAlarm(event)) = effects.first() else {
            panic!("{effects:?}");
        };
        assert_eq!(event.code, "battery_critical");
        assert_eq!(event.shelved_for, shelved_for.map(Moment::from_secs));
    }
}

#[test]
fn an_alarm_that_is_not_on_is_not_acknowledged() {
    let mut scene = scene();
    scene.hear();
    let effects = say(&mut scene, ":acknowledge battery_low");
    assert!(
        !effects
            .iter()
            .any(|effect| matches!(effect, Effect::AnswerAlarm(_))),
        "{effects:?}"
    );
}

#[test]
fn alarms_are_acknowledged_all_at_once() {
    let mut scene = scene();
    scene.state.power = Power::Critical;
    scene.hear();
    assert_eq!(scene.calling(), 2);
    let effects = scene.type_text("A");
    let acknowledged: Vec<_> = effects
        .iter()
        .filter_map(|effect| match effect {
            Effect::AnswerAlarm(event) => Some((event.code.as_str(), event.status)),
            _ => None,
        })
        .collect();
    assert_eq!(
        acknowledged,
        [
            ("battery_critical", AlarmStatus::Acknowledged),
            ("battery_low", AlarmStatus::Acknowledged)
        ]
    );
    assert_eq!(scene.calling(), 0);
    assert!(
        raised(&scene)
            .iter()
            .all(|(.., acknowledged)| *acknowledged)
    );
}

/// With many alarms the one at the top of the list may be the last of the table.
#[test]
fn in_their_panel_the_keys_concern_the_first_raised_alarm() {
    let mut scene = scene();
    scene.model.ui.panel = Panel::Alarms;
    let effects = scene.type_text("Z");
    let is_notice = |effect: &Effect| matches!(effect, Effect::Notice(_));
    assert!(effects.iter().all(is_notice), "{effects:?}");
    scene.state.power = Power::Low;
    scene.hear();
    let effects = scene.type_text("Z");
    assert!(
        matches!(&effects[..], [Effect::AnswerAlarm(event)] if event.code == "battery_low"),
        "{effects:?}"
    );
    // The arrows choose another.
    scene.press(&[KeyCode::Down]);
    let effects = scene.type_text("Z");
    assert!(
        matches!(&effects[..], [Effect::AnswerAlarm(event)] if event.code == "battery_critical"),
        "{effects:?}"
    );
}

#[test]
fn a_shelved_alarm_calls_again_when_its_time_is_over() {
    let mut scene = scene();
    scene.type_text("b");
    let effects = say(&mut scene, ":shelve battery_low 30s");
    assert!(
        matches!(&effects[..], [Effect::AnswerAlarm(event)]
            if event.status == AlarmStatus::Shelved && event.shelved_for == Some(Moment::from_secs(30))),
        "{effects:?}"
    );
    scene.state.power = Power::Low;
    scene.hear();
    assert_eq!(raised(&scene), [("battery low", true, false)]);
    assert_eq!(scene.calling(), 0);
    let shelf_ends = scene.now + Moment::from_secs(29);
    while scene.now < shelf_ends {
        scene.hear();
        assert_eq!(scene.calling(), 0);
    }
    scene.now = scene.model.poll_timeout().expect("it comes back");
    scene.event(Event::Tick);
    assert_eq!(scene.calling(), 1);
    // The key shelves the alarm for 10 minutes, an hour, eight hours, and then unshelves it.
    let mut times = Vec::new();
    for _ in 0..4 {
        let effects = scene.type_text("Z");
        let [Effect::AnswerAlarm(event)] = &effects[..] else {
            panic!("{effects:?}");
        };
        times.push(event.shelved_for.map(|time| time.as_secs()));
    }
    assert_eq!(times, [Some(600), Some(3600), Some(28_800), None]);
    say(&mut scene, ":shelve robot silent 1h");
    scene.wait_ms(60_000);
    let effects = scene.event(Event::Tick);
    assert!(
        raised(&scene).contains(&("robot silent", true, false)),
        "{:?}",
        raised(&scene)
    );
    assert_eq!(rings(&effects), 0);
}

/// A program that joins the link later is given the answers before its own alarms begin.
#[test]
fn an_alarm_that_begins_within_a_minute_after_its_acknowledgement_is_acknowledged() {
    for (wait_ms, is_acknowledged) in [(1000, true), (90_000, false)] {
        let mut scene = scene_with(vec![AlarmSetting {
            below: Some(12.0),
            ..setting("Weak battery", "battery")
        }]);
        scene.event(Event::AlarmAnswer(AlarmAnswer {
            alarm: "weak_battery".to_owned(),
            answer: Answer::Acknowledged,
            by: "pid 7".to_owned(),
        }));
        scene.wait_ms(wait_ms);
        scene.status.battery_dv = 118;
        scene.hear_status();
        assert_eq!(
            raised(&scene).first(),
            Some(&("Weak battery", true, is_acknowledged))
        );
        // The next time it is new.
        scene.status.battery_dv = 130;
        scene.hear_status();
        scene.wait_ms(90_000);
        scene.status.battery_dv = 118;
        scene.hear_status();
        assert_eq!(raised(&scene).first(), Some(&("Weak battery", true, false)));
    }
}

#[test]
fn answers_of_other_programs_count_like_the_operators() {
    let mut scene = scene_with(vec![AlarmSetting {
        below: Some(12.0),
        ..setting("Weak battery", "battery")
    }]);
    let reported = |scene: &Scene, answer| {
        let (alarm, by) = ("weak_battery".to_owned(), "pid 7".to_owned());
        let answer = AlarmAnswer { alarm, answer, by };
        scene.model.facts.answer_event(&answer)
    };
    assert_eq!(reported(&scene, Answer::Acknowledged), None, "not on");
    scene.status.battery_dv = 118;
    scene.hear_status();
    let event = reported(&scene, Answer::Acknowledged).expect("an event");
    assert_eq!(event.by.as_deref(), Some("pid 7"));
    assert_eq!(raised(&scene), [("Weak battery", true, false)]);
    let hear = |scene: &mut Scene, alarm: &str, answer| {
        let (alarm, by) = (alarm.to_owned(), "pid 7".to_owned());
        scene.event(Event::AlarmAnswer(AlarmAnswer { alarm, answer, by }));
    };
    hear(&mut scene, "other_program's", Answer::Acknowledged);
    assert_eq!(raised(&scene), [("Weak battery", true, false)]);
    hear(&mut scene, "weak_battery", Answer::Acknowledged);
    assert_eq!(raised(&scene), [("Weak battery", true, true)]);
    for (answer, is_shelved) in [(Answer::Shelved(60), true), (Answer::Unshelved, false)] {
        hear(&mut scene, "weak_battery", answer);
        let listed = scene.model.ui.listed(&scene.model.facts);
        let mut listed = listed.iter();
        assert_eq!(
            listed.any(|shown| shown.shelved_until.is_some()),
            is_shelved
        );
    }
}
