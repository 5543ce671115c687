//! The keys of a session: those of the table, and what the configuration says instead.

use std::borrow::Cow;
use std::sync::Arc;

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::{Action, Binding, Context, TABLE, notation, words};
use crate::suggest;

/// A key and what is held with it.
pub(super) type Key = (KeyCode, KeyModifiers);

/// Another choice of keys for one action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rebinding {
    /// Where it counts: `dashboard`, `drive` and so on.
    pub context: String,
    /// What is to be done, by its name.
    pub name: String,
    /// The keys for it; none at all leaves it without.
    pub keys: Vec<String>,
}

/// Why a choice of keys does not do, and which one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyMistake {
    /// Place among the rebindings.
    pub index: usize,
    /// What is wrong with it.
    pub message: String,
}

/// A row of the table as it is in this session.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) context: Context,
    pub(crate) label: Cow<'static, str>,
    pub(crate) keys: Vec<Key>,
    pub(crate) action: Action,
    pub(crate) help: Cow<'static, str>,
    pub(crate) footer: &'static str,
}

/// What every key does: dispatch, footer, help, palette and manual read it here.
#[derive(Clone, Debug, PartialEq)]
pub struct Keymap(Arc<[Row]>);

impl Default for Keymap {
    fn default() -> Self {
        Self(TABLE.iter().map(Row::of).collect())
    }
}

impl Keymap {
    /// The table with some keys chosen otherwise. What is not named keeps its keys.
    ///
    /// # Errors
    /// Names all that do not do: unknown names and keys, keys that have two meanings.
    pub fn with(rebindings: &[Rebinding]) -> Result<Self, Vec<KeyMistake>> {
        let mut rows: Vec<Row> = TABLE.iter().map(Row::of).collect();
        let mut chosen = vec![None; rows.len()];
        let mut mistakes = Vec::new();
        for (index, rebinding) in rebindings.iter().enumerate() {
            match read(&rows, rebinding) {
                Ok((at, keys)) => {
                    rebind(&mut rows, at, keys);
                    chosen[at] = Some(index);
                }
                Err(message) => mistakes.push(KeyMistake { index, message }),
            }
        }
        mistakes.extend(clashes(&rows, &chosen));
        if mistakes.is_empty() {
            Ok(Self(rows.into()))
        } else {
            Err(mistakes)
        }
    }

    /// All rows, in the order of the help.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &Row> {
        self.0.iter()
    }

    /// How the first key for something is written; empty where it has none.
    pub(crate) fn label(&self, context: Context, action: Action) -> String {
        let row = self
            .rows()
            .find(|row| row.context == context && row.action == action);
        let first = row.and_then(|row| row.keys.first());
        first.map_or_else(String::new, |key| notation::name(*key))
    }

    /// What a key does in a context.
    pub(crate) fn action(&self, context: Context, key: KeyEvent) -> Option<Action> {
        let found = self
            .rows()
            .find(|row| row.context == context && row.takes(key));
        found.map(|row| row.action)
    }

    /// Everything for a manual: where, the keys, the name in the configuration and what it does.
    pub fn manual(&self) -> impl Iterator<Item = [Cow<'_, str>; 4]> {
        self.rows().map(|row| {
            let (context, name) = (row.context.name().into(), row.name().into());
            [context, row.key_names().into(), name, row.does()]
        })
    }
}

/// Which row is meant, and the keys for it.
fn read(rows: &[Row], rebinding: &Rebinding) -> Result<(usize, Vec<Key>), String> {
    let at = find(rows, context(&rebinding.context)?, &rebinding.name)?;
    let keys = rebinding.keys.iter().map(|word| notation::read(word));
    let mut keys = keys.collect::<Result<Vec<Key>, String>>()?;
    if rows[at].action == Action::Stop {
        keys.extend(rows[at].keys.iter().copied());
    }
    Ok((at, keys))
}

fn rebind(rows: &mut [Row], at: usize, keys: Vec<Key>) {
    speak_for_themselves(rows, at);
    rows[at].keys = keys;
    rows[at].label = rows[at].key_names().into();
}

/// Keys that mean two things in one place; the choice is blamed that came last.
fn clashes(rows: &[Row], chosen: &[Option<usize>]) -> Vec<KeyMistake> {
    let mut clashes = Vec::new();
    for (at, row) in rows.iter().enumerate() {
        for (other, twin) in rows.iter().enumerate().skip(at + 1) {
            let shared = row.keys.iter().find(|key| twin.keys.contains(key));
            let (Some(key), true) = (shared, row.context == twin.context) else {
                continue;
            };
            // The table itself has no such pair.
            let (index, taker, owner) = match (chosen[at], chosen[other]) {
                (Some(index), Some(later)) if index < later => (later, twin, row),
                (Some(index), _) => (index, row, twin),
                (None, later) => (later.unwrap_or_default(), twin, row),
            };
            let (key, taker, owner) = (notation::name(*key), taker.name(), owner.name());
            let message = format!(
                "`{key}` cannot be the key for `{taker}`: it is the key for `{owner}`. Choose another one, or take it from \
                 `{owner}` first: {owner} = []"
            );
            clashes.push(KeyMistake { index, message });
        }
    }
    clashes
}

/// A row whose keys are chosen otherwise is told by itself, and so are those that it spoke for, or that spoke for it.
fn speak_for_themselves(rows: &mut [Row], at: usize) {
    let first = (0..=at).rev().find(|&row| rows[row].is_told());
    let first = first.unwrap_or(at);
    let count = 1 + rows[first + 1..]
        .iter()
        .take_while(|row| !row.is_told())
        .count();
    for row in &mut rows[first..first + count] {
        row.label = row.key_names().into();
        if row.help.is_empty() && matches!(row.context, Context::Dashboard | Context::Route) {
            row.help = row.does().into_owned().into();
        }
    }
}

fn context(name: &str) -> Result<Context, String> {
    let found = Context::ALL
        .into_iter()
        .find(|context| context.name() == name);
    found.ok_or_else(|| {
        let names = Context::ALL.map(Context::name);
        let near = suggest::question(name, names);
        format!(
            "there are no keys called `{name}`{near}; there are {}",
            names.join(", ")
        )
    })
}

fn find(rows: &[Row], context: Context, name: &str) -> Result<usize, String> {
    let is_it = |row: &Row| row.context == context && row.name() == name;
    rows.iter()
        .position(is_it)
        .ok_or_else(|| format!("no key does `{name}`{}", instead(rows, context, name)))
}

/// What may have been meant by a name that is none: the same or a near one here, then elsewhere, then names with a word
/// in common.
fn instead(rows: &[Row], context: Context, name: &str) -> String {
    let names: Vec<(Context, String)> = rows.iter().map(|row| (row.context, row.name())).collect();
    let of = |here: bool| {
        let names = names.iter().filter(move |(at, _)| (*at == context) == here);
        names.map(|(_, name)| name.as_str())
    };
    if let Some(near) = suggest::nearest(name, of(true)) {
        return format!("; did you mean `{near}`?");
    }
    if let Some(near) = suggest::nearest(name, of(false)) {
        let place = names
            .iter()
            .find(|(at, name)| *at != context && name == near);
        let place = place.map_or("", |(place, _)| place.name());
        let section = match place {
            "dashboard" => "[keys]".to_owned(),
            place => format!("[keys.{place}]"),
        };
        return format!(" here; did you mean `{near}` in {section}?");
    }
    let is_alike = |known: &&str| {
        known
            .split('-')
            .any(|word| name.split('-').any(|part| part == word))
    };
    let alike: Vec<&str> = of(true).filter(is_alike).collect();
    if alike.is_empty() {
        "; `groundwave config` lists what keys do".to_owned()
    } else {
        format!(
            "; there are {}; `groundwave config` lists all",
            alike.join(", ")
        )
    }
}

impl Row {
    fn of(binding: &Binding) -> Self {
        Self {
            context: binding.context,
            label: binding.label.into(),
            keys: binding.keys.to_vec(),
            action: binding.action,
            help: binding.help.into(),
            footer: binding.footer,
        }
    }

    /// What the configuration calls it.
    pub(crate) fn name(&self) -> String {
        notation::action_name(self.action)
    }

    /// Its keys with spaces between.
    pub(crate) fn key_names(&self) -> String {
        notation::names(&self.keys)
    }

    /// What it does, in words of its own even where another row of the table speaks for it.
    pub(crate) fn does(&self) -> Cow<'_, str> {
        match words::alone(self.action) {
            Some(words) => words.into(),
            None if !self.help.is_empty() => self.help.as_ref().into(),
            None if !self.footer.is_empty() => self.footer.into(),
            None => self.name().replace('-', " ").into(),
        }
    }

    /// Whether it says what it does, for itself and for those that follow it without a word.
    fn is_told(&self) -> bool {
        !self.help.is_empty() || !self.footer.is_empty()
    }

    fn takes(&self, key: KeyEvent) -> bool {
        let mut held = key.modifiers & (KeyModifiers::CONTROL | KeyModifiers::SHIFT);
        if let KeyCode::Char(_) = key.code {
            // The character says it: some terminals report Shift beside `W`, some do not.
            held -= KeyModifiers::SHIFT;
        }
        self.keys.contains(&(key.code, held))
    }
}

#[cfg(test)]
mod tests {
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
    fn nothing_said_is_the_table() {
        assert_eq!(with(&[]), Ok(Keymap::default()));
    }

    #[test]
    fn every_name_is_its_rows_alone_and_reads_as_one() {
        let keymap = Keymap::default();
        for row in keymap.rows() {
            let name = row.name();
            let is_word = name
                .bytes()
                .all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-');
            assert!(is_word && !name.contains("--"), "{name}");
            let alike = keymap
                .rows()
                .filter(|other| other.context == row.context && other.name() == name);
            assert_eq!(alike.count(), 1, "{name}");
            let is_section = Context::ALL.iter().any(|context| context.name() == name);
            assert!(!is_section, "[keys.{name}] is keys of another place");
            for &key in &row.keys {
                assert_eq!(notation::read(&notation::name(key)), Ok(key), "{name}");
            }
        }
    }

    #[test]
    fn no_two_rows_of_a_place_are_told_in_the_same_words() {
        let keymap = Keymap::default();
        let manual: Vec<_> = keymap.manual().collect();
        for (at, [context, _, name, does]) in manual.iter().enumerate() {
            assert!(!does.is_empty(), "{name}");
            let mut others = manual[at + 1..].iter().filter(|other| other[0] == *context);
            let twin = others.find(|other| other[3] == *does);
            assert_eq!(twin, None, "{name}");
        }
    }

    #[test]
    fn a_key_is_chosen_otherwise_and_told_so() {
        let keymap = with(&[("dashboard", "scan", &["F9", "Ctrl-V"])]).expect("it is free");
        assert_eq!(press(&keymap, KeyCode::F(9)), Some(Action::Scan));
        assert_eq!(press(&keymap, KeyCode::Char('v')), None);
        let row = keymap.rows().find(|row| row.action == Action::Scan);
        assert_eq!(row.expect("it is still there").label, "F9 Ctrl-V");
        let bare = with(&[("dashboard", "scan", &[])]).expect("none is a choice too");
        assert_eq!(press(&bare, KeyCode::Char('v')), None);
    }

    #[test]
    fn a_row_of_a_group_leaves_none_of_the_others_untold() {
        let keymap = with(&[("dashboard", "toggle-layer-sonar", &["F10"])]).expect("it is free");
        let told = |name: &str| {
            let row = keymap.rows().find(|row| row.name() == name);
            row.map(|row| (row.label.to_string(), row.help.to_string()))
        };
        let sonar = ("F10".to_owned(), "allow or forbid layer sonar".to_owned());
        assert_eq!(told("toggle-layer-sonar"), Some(sonar));
        let photo = ("5".to_owned(), "allow or forbid layer photo".to_owned());
        assert_eq!(told("toggle-layer-photo"), Some(photo));
    }

    #[test]
    fn stop_keeps_its_keys() {
        let keymap = with(&[("dashboard", "stop", &["F12"])]).expect("one more");
        assert_eq!(press(&keymap, KeyCode::F(12)), Some(Action::Stop));
        assert_eq!(press(&keymap, KeyCode::Char(' ')), Some(Action::Stop));
    }

    #[test]
    fn what_does_not_do_is_named() {
        let errors = |pairs: &[(&str, &str, &[&str])]| with(pairs).expect_err("it is wrong");
        let error = |pairs: &[(&str, &str, &[&str])]| match &errors(pairs)[..] {
            [only] => only.clone(),
            all => panic!("{all:?}"),
        };
        let taken = error(&[
            ("dashboard", "quit", &["F9"]),
            ("dashboard", "scan", &["p"]),
        ]);
        assert_eq!(taken.index, 1);
        assert!(
            taken
                .message
                .contains("`p` cannot be the key for `scan`: it is the key for `mode-prowl`"),
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
            ("dashboard", "scan", &["F9"]),
            ("dashboard", "quit", &["F9"]),
        ]);
        assert_eq!(both.index, 1);
        assert!(
            both.message
                .starts_with("`F9` cannot be the key for `quit`: it is the key for `scan`"),
            "{}",
            both.message
        );
        let unknown = error(&[("dashboard", "scna", &["F9"])]);
        assert!(
            unknown.message.contains("did you mean `scan`?"),
            "{}",
            unknown.message
        );
        let elsewhere = error(&[("dashboard", "leave-drive", &["F9"])]);
        assert!(
            elsewhere
                .message
                .contains("did you mean `leave-drive` in [keys.drive]?"),
            "{}",
            elsewhere.message
        );
        let alike = error(&[("dashboard", "layer-light", &["F9"])]);
        assert!(
            alike.message.contains("toggle-layer-photo"),
            "{}",
            alike.message
        );
        let several = errors(&[
            ("dashboard", "scna", &["F9"]),
            ("dashboard", "scan", &["p"]),
            ("dashboard", "why", &["Alt-x"]),
        ]);
        let indices: Vec<usize> = several.iter().map(|mistake| mistake.index).collect();
        assert_eq!(indices, [0, 2, 1], "{several:?}");
        let context = error(&[("dashbord", "scan", &["F9"])]);
        assert!(
            context.message.contains("did you mean `dashboard`?"),
            "{}",
            context.message
        );
        let key = error(&[("dashboard", "scan", &["Alt-x"])]);
        assert!(key.message.contains("Alt"), "{}", key.message);
        // A key that was given away is free.
        let swapped = with(&[
            ("dashboard", "scan", &["p"]),
            ("dashboard", "mode-prowl", &["v"]),
        ]);
        assert!(swapped.is_ok());
    }
}
