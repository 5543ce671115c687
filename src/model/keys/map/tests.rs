//! Keys changed by the configuration.

use super::*;

fn with(pairs: &[(&str, &str, &[&str])]) -> Result<Keymap, Vec<KeyMistake>> {
    let rebindings: Vec<Rebinding> = pairs
        .iter()
        .map(|(context, name, keys)| Rebinding {
            context: (*context).to_owned(),
            name: (*name).to_owned(),
            keys: keys.iter().map(|key| (*key).to_owned()).collect(),
        })
        .collect();
    Keymap::with(&rebindings)
}

fn press(keymap: &Keymap, code: KeyCode) -> Option<Action> {
    keymap.action(Context::Dashboard, KeyEvent::new(code, KeyModifiers::NONE))
}

#[test]
fn empty_configuration_is_the_table() {
    assert_eq!(with(&[]), Ok(Keymap::default()));
}

#[test]
fn every_name_is_its_rows_alone_and_reads_as_one() {
    let keymap = Keymap::default();
    for row in keymap.rows() {
        let name = row.name;
        let is_word = name
            .bytes()
            .all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-');
        assert!(is_word && !name.contains("--"), "{name}");
        let alike = keymap
            .rows()
            .filter(|other| other.context == row.context && other.name == name);
        assert_eq!(alike.count(), 1, "{name}");
        let is_section = Context::ALL.iter().any(|context| context.name() == name);
        assert!(!is_section, "[keys.{name}] is keys of another place");
        for &key in &row.keys {
            assert_eq!(notation::read(&notation::name(key)), Ok(key), "{name}");
        }
    }
}

#[test]
fn rows_of_a_context_have_different_descriptions() {
    let keymap = Keymap::default();
    let manual: Vec<_> = keymap.manual().collect();
    for (at, [context, _, _, name, does]) in manual.iter().enumerate() {
        assert!(!does.is_empty(), "{name}");
        let mut others = manual[at + 1..].iter().filter(|other| other[0] == *context);
        let twin = others.find(|other| other[3] == *does);
        assert_eq!(twin, None, "{name}");
    }
}

#[test]
fn rebound_key_is_shown() {
    let keymap = with(&[("dashboard", "scan", &["F12", "Ctrl-V"])]).expect("it is free");
    assert_eq!(press(&keymap, KeyCode::F(12)), Some(Action::Scan));
    assert_eq!(press(&keymap, KeyCode::Char('v')), None);
    let row = keymap.rows().find(|row| row.action == Action::Scan);
    assert_eq!(row.expect("it is still there").label, "F12 Ctrl-V");
    let bare = with(&[("dashboard", "scan", &[])]).expect("none is a choice too");
    assert_eq!(press(&bare, KeyCode::Char('v')), None);
}

#[test]
fn rebinding_one_row_of_a_group_keeps_the_others_described() {
    let keymap = with(&[("dashboard", "toggle-layer-sonar", &["F10"])]).expect("it is free");
    let told = |name: &str| {
        let row = keymap.rows().find(|row| row.name == name);
        row.map(|row| (row.label.to_string(), row.help.to_string()))
    };
    let sonar = ("F10".to_owned(), "allow or forbid layer sonar".to_owned());
    assert_eq!(told("toggle-layer-sonar"), Some(sonar));
    let photo = ("5".to_owned(), "allow or forbid layer photo".to_owned());
    assert_eq!(told("toggle-layer-photo"), Some(photo));
}

#[test]
fn text_names_keys_of_actions() {
    let text = "<scan> looks, <route/route-undo>, forbid one (<toggle-layer-bumpers..>), <move-cursor-left..> move, <1 s";
    let told = Keymap::default().with_keys(text);
    assert_eq!(told, "v looks, u, forbid one (1-7), arrows move, <1 s");
    let chosen = [
        ("dashboard", "scan", &[] as &[&str]),
        ("dashboard", "toggle-layer-sonar", &["F10", "F11"]),
        ("dashboard", "move-cursor-up", &[]),
        ("route", "route-undo", &["F12"]),
    ];
    let told = with(&chosen).expect("they are free").with_keys(text);
    assert_eq!(
        told,
        "scan looks, F12, forbid one (1 2 3 F10 5 6 7), Left Right Down move, <1 s"
    );
    for text in ["", "<", "a <b> c", "<scan", ">"] {
        assert_eq!(Keymap::default().with_keys(text), text);
    }
}

#[test]
fn a_label_that_is_a_key_speaks_for_that_alone() {
    let chosen = [
        ("help-screen", "turn-page-more", &["F12"] as &[&str]),
        ("text", "close", &["F12"]),
    ];
    let keymap = with(&chosen).expect("they are free");
    for name in ["<help-screen/turn-page-more..>", "<text/close..>"] {
        assert_eq!(keymap.with_keys(name), "F12");
    }
}

/// The help never names a key that was replaced.
#[test]
fn help_names_no_replaced_key() {
    let chosen = [
        ("dashboard", "add-waypoint", &["Ctrl-B"] as &[&str]),
        ("dashboard", "turn-page-less", &["F10"]),
        ("dashboard", "playback-newest", &["F11"]),
        ("dashboard", "enter-drive", &["F12"]),
    ];
    let keymap = with(&chosen).expect("they are free");
    let help = |name: &str| {
        let row = keymap.rows().find(|row| row.name == name);
        row.map(|row| row.help.to_string())
    };
    for (name, told) in [
        ("add-waypoint", "draft a waypoint"),
        ("turn-page-less", "the previous page"),
        ("playback-newest", "to the present, or to the end"),
        ("enter-drive", "drive by hand (asks)"),
    ] {
        assert_eq!(help(name).as_deref(), Some(told));
    }
}

#[test]
fn stop_keeps_its_keys() {
    let keymap = with(&[("dashboard", "stop", &["F12"])]).expect("one more");
    assert_eq!(press(&keymap, KeyCode::F(12)), Some(Action::Stop));
    assert_eq!(press(&keymap, KeyCode::Char(' ')), Some(Action::Stop));
}

#[test]
fn a_key_that_stops_does_so_everywhere() {
    let keymap = with(&[("dashboard", "stop", &["F12", "Y"])]).expect("they are free");
    let stops = |context, code: KeyCode| keymap.action(context, code.into()) == Some(Action::Stop);
    for context in Context::ALL {
        assert!(stops(context, KeyCode::F(12)), "{context:?}");
        let is_typed_in = matches!(context, Context::Text | Context::Palette);
        assert_eq!(
            stops(context, KeyCode::Char('Y')),
            !is_typed_in,
            "{context:?}"
        );
        assert_eq!(keymap.label(context, Action::Stop), "F12");
    }
    let otherwise = with(&[
        ("dashboard", "stop", &["F12"]),
        ("drive", "stop", &["F11"]),
        ("jump", "stop", &[]),
    ]);
    let otherwise = otherwise.expect("they are free");
    let label = |context| otherwise.label(context, Action::Stop);
    assert_eq!(label(Context::Drive), "F11");
    assert_eq!(label(Context::Jump), "Space");
    assert_eq!(label(Context::Question), "F12");
}

/// A key of STOP is not listed twice.
#[test]
fn stop_has_each_of_its_keys_once() {
    let keymap = with(&[("dashboard", "stop", &["Ctrl-S", "F12", "Space"])]).expect("free");
    let stops = keymap.rows().filter(|row| row.action == Action::Stop);
    for row in stops {
        let typed = if row.keys.len() == 2 {
            "Ctrl-S F12"
        } else {
            "Ctrl-S F12 Space"
        };
        assert_eq!(row.key_names(), typed, "{:?}", row.context);
    }
}

#[test]
fn a_key_for_stop_that_means_something_elsewhere_is_named_with_the_place() {
    let taken = with(&[
        ("dashboard", "toggle-bell", &["F12"]),
        ("dashboard", "stop", &["b"]),
    ]);
    let taken = taken.expect_err("they jump and choose by it");
    assert_eq!(taken.len(), 1, "{taken:?}");
    assert_eq!(taken[0].index, 1);
    assert_eq!(
        taken[0].message,
        "`b` cannot be the key for `stop`: it is the key for `route-select-less` in [keys.route], `jump-to-bump` in \
         [keys.jump]. Choose another one, or take it from them first: route-select-less = [] in [keys.route], jump-to-bump \
         = [] in [keys.jump]"
    );
    let later = with(&[
        ("dashboard", "stop", &["F12"]),
        ("drive", "leave-drive", &["F12"]),
    ]);
    let later = later.expect_err("it stops there");
    assert_eq!(later.len(), 1, "{later:?}");
    assert_eq!(later[0].index, 1);
    assert_eq!(
        later[0].message,
        "`F12` cannot be the key for `leave-drive`: it is the key for `stop`. Choose another one, or take it from `stop` \
         first: stop = []"
    );
    let freed = with(&[
        ("dashboard", "stop", &["F12"]),
        ("drive", "leave-drive", &["F12"]),
        ("drive", "stop", &[]),
    ]);
    assert!(freed.is_ok());
}

#[test]
fn mistakes_are_named() {
    let errors = |pairs: &[(&str, &str, &[&str])]| with(pairs).expect_err("it is wrong");
    let error = |pairs: &[(&str, &str, &[&str])]| match &errors(pairs)[..] {
        [only] => only.clone(),
        all => panic!("{all:?}"),
    };
    let taken = error(&[
        ("dashboard", "quit", &["F12"]),
        ("dashboard", "scan", &["x"]),
    ]);
    assert_eq!(taken.index, 1);
    assert!(
        taken
            .message
            .contains("`x` cannot be the key for `scan`: it is the key for `cancel-commands`"),
        "{}",
        taken.message
    );
    let stop = error(&[("dashboard", "stop", &["y"])]);
    assert!(
        stop.message
            .starts_with("`y` cannot be the key for `stop`: it is the key for `why`"),
        "{}",
        stop.message
    );
    let both = error(&[
        ("dashboard", "scan", &["F12"]),
        ("dashboard", "quit", &["F12"]),
    ]);
    assert_eq!(both.index, 1);
    assert!(
        both.message
            .starts_with("`F12` cannot be the key for `quit`: it is the key for `scan`"),
        "{}",
        both.message
    );
    let unknown = error(&[("dashboard", "scna", &["F12"])]);
    assert!(
        unknown.message.contains("did you mean `scan`?"),
        "{}",
        unknown.message
    );
    let elsewhere = error(&[("dashboard", "leave-drive", &["F12"])]);
    assert!(
        elsewhere
            .message
            .contains("did you mean `leave-drive` in [keys.drive]?"),
        "{}",
        elsewhere.message
    );
    let alike = error(&[("dashboard", "layer-light", &["F12"])]);
    assert!(
        alike.message.contains("toggle-layer-photo"),
        "{}",
        alike.message
    );
    let several = errors(&[
        ("dashboard", "scna", &["F12"]),
        ("dashboard", "scan", &["x"]),
        ("dashboard", "why", &["Alt-x"]),
    ]);
    let indices: Vec<usize> = several.iter().map(|mistake| mistake.index).collect();
    assert_eq!(indices, [0, 2, 1], "{several:?}");
    let context = error(&[("dashbord", "scan", &["F12"])]);
    assert!(
        context.message.contains("did you mean `dashboard`?"),
        "{}",
        context.message
    );
    let key = error(&[("dashboard", "scan", &["Alt-x"])]);
    assert!(key.message.contains("Alt"), "{}", key.message);
    // A key that no action uses any more is free.
    let swapped = with(&[
        ("dashboard", "scan", &["x"]),
        ("dashboard", "cancel-commands", &["v"]),
    ]);
    assert!(swapped.is_ok());
}
