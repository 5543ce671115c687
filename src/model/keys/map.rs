//! The keys of a session: the table, with the configuration's changes.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, LazyLock};

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::notation::Key;
use super::{Action, Binding, Context, RouteAction, TABLE, notation, words};
use crate::suggest;

/// The name of each row in the configuration.
static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let actions = TABLE.iter().map(|binding| binding.action);
    actions.map(notation::action_name).collect()
});

/// The configuration's keys for one action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rebinding {
    /// The context: `dashboard`, `drive` and so on.
    pub context: String,
    /// Name of the action.
    pub name: String,
    /// Keys for the action; may be empty.
    pub keys: Vec<String>,
}

/// A mistake in the configuration of keys.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyMistake {
    /// Index of the rebinding.
    pub index: usize,
    /// Reason for the refusal.
    pub message: String,
}

/// A row of the table in this session.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) context: Context,
    pub(crate) label: Cow<'static, str>,
    /// Keys of this row and of the rows that it describes, as in the table (`1-7`, `arrows`), or the first
    /// key of each where the configuration changed them; may be empty.
    pub(crate) labels: Cow<'static, str>,
    pub(crate) keys: Vec<Key>,
    pub(crate) action: Action,
    /// Name in the configuration.
    pub(crate) name: &'static str,
    pub(crate) help: Cow<'static, str>,
    pub(crate) footer: &'static str,
}

/// The action of every key, for dispatch, footer, help, palette and manual.
#[derive(Clone, Debug, PartialEq)]
pub struct Keymap(Arc<[Row]>);

impl Default for Keymap {
    fn default() -> Self {
        Self::of(table().collect())
    }
}

impl Keymap {
    /// The table with the configuration's changes.
    ///
    /// # Errors
    /// Every mistake: unknown names and keys, and keys with two meanings.
    pub fn with(rebindings: &[Rebinding]) -> Result<Self, Vec<KeyMistake>> {
        let mut rows: Vec<Row> = table().collect();
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
        stop_everywhere(&mut rows, &mut chosen);
        mistakes.extend(clashes(&rows, &chosen, rebindings));
        if mistakes.is_empty() {
            Ok(Self::of(rows))
        } else {
            Err(mistakes)
        }
    }

    fn of(mut rows: Vec<Row>) -> Self {
        for at in 0..rows.len() {
            rows[at].labels = labels(&rows, at);
        }
        Self(rows.into())
    }

    /// All rows, in the order of the help.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &Row> {
        self.0.iter()
    }

    /// The first key of an action; empty if it has none.
    pub(crate) fn label(&self, context: Context, action: Action) -> String {
        let mut rows = self.rows();
        let row = rows.find(|row| row.context == context && row.action == action);
        row.map_or_else(String::new, Row::first_key)
    }

    /// A text with key names in place of action names: `<scan>` becomes the first key of that action on the dashboard,
    /// `<route/route-undo>` that of another context, `<toggle-layer-bumpers..>` the keys of a row and of the rows it
    /// describes. An action without a key keeps its name, which the palette finds; other brackets are not changed.
    pub(crate) fn with_keys(&self, text: &str) -> String {
        let (mut shown, mut rest) = (String::new(), text);
        while let Some((before, after)) = rest.split_once('<') {
            shown += before;
            let named = after.split_once('>');
            let keys = named.and_then(|(name, after)| Some((self.named(name)?, after)));
            let (keys, after) = keys.unwrap_or_else(|| ("<".to_owned(), after));
            shown += &keys;
            rest = after;
        }
        shown + rest
    }

    /// The keys for a name in brackets.
    fn named(&self, what: &str) -> Option<String> {
        let (place, name) = what.split_once('/').unwrap_or(("dashboard", what));
        let only = name.strip_suffix("..");
        let name = only.unwrap_or(name);
        let is_it = |row: &Row| row.name == name && row.context.name() == place;
        let at = self.rows().position(is_it)?;
        let mut keys = match only {
            Some(_) => self.0[at].labels.to_string(),
            None => self.0[at].first_key(),
        };
        if self.0[at].context == Context::Modes && !keys.is_empty() {
            keys = format!("{} {keys}", self.label(Context::Dashboard, Action::AskMode));
        }
        Some(if keys.is_empty() {
            name.to_owned()
        } else {
            keys
        })
    }

    /// The action of a key in a context. A key of STOP with Control is also STOP, unless it has another action.
    pub(crate) fn action(&self, context: Context, key: KeyEvent) -> Option<Action> {
        let action = |key| {
            let mut rows = self.rows();
            let found = rows.find(|row| row.context == context && row.takes(key));
            found.map(|row| row.action)
        };
        let modifiers = key.modifiers - KeyModifiers::CONTROL;
        let is_stop = |action: &Action| *action == Action::Stop;
        action(key).or_else(|| action(KeyEvent { modifiers, ..key }).filter(is_stop))
    }

    /// Rows of the manual: context, group of the dashboard's rows, keys, name in the configuration and description.
    pub fn manual(&self) -> impl Iterator<Item = [Cow<'_, str>; 5]> {
        self.rows().map(|row| {
            let group = match row.context {
                Context::Dashboard => row.action.group().name(),
                _ => "",
            };
            let does = self.with_keys(&row.does()).into();
            let (context, name) = (row.context.name().into(), row.name.into());
            [context, group.into(), row.key_names().into(), name, does]
        })
    }
}

/// The row and keys of a rebinding.
fn read(rows: &[Row], rebinding: &Rebinding) -> Result<(usize, Vec<Key>), String> {
    let at = find(rows, context(&rebinding.context)?, &rebinding.name)?;
    let keys = rebinding.keys.iter().map(|word| notation::read(word));
    let keys = keys.collect::<Result<Vec<Key>, String>>()?;
    if rows[at].action == Action::Stop {
        return Ok((at, besides(keys, &rows[at].keys)));
    }
    if keys.is_empty() && leads_out(&rows[at]) {
        return Err(format!(
            "nothing would lead out of [keys.{}]: give `{}` a key",
            rows[at].context.name(),
            rows[at].name
        ));
    }
    Ok((at, keys))
}

/// Whether the action closes an overlay.
fn leads_out(row: &Row) -> bool {
    let leaves = matches!(
        row.action,
        Action::Close | Action::LeaveDrive | Action::Route(RouteAction::Leave)
    );
    leaves && row.context != Context::Dashboard
}

/// Joins two lists of keys without repetition.
fn besides(mut keys: Vec<Key>, others: &[Key]) -> Vec<Key> {
    for key in others {
        if !keys.contains(key) {
            keys.push(*key);
        }
    }
    keys
}

/// Adds the dashboard's STOP keys to every context without separate STOP keys; except characters in prompts, where they are text.
fn stop_everywhere(rows: &mut [Row], chosen: &mut [Option<usize>]) {
    let is_stop = |row: &Row| row.action == Action::Stop;
    let stop = rows
        .iter()
        .position(is_stop)
        .filter(|&at| chosen[at].is_some());
    let Some(stop) = stop else {
        return;
    };
    for at in stop + 1..rows.len() {
        if is_stop(&rows[at]) && chosen[at].is_none() {
            let types = matches!(rows[at].context, Context::Text | Context::Palette);
            let is_typed = |(code, held): &Key| {
                matches!(code, KeyCode::Char(_)) && !held.contains(KeyModifiers::CONTROL)
            };
            let keys = rows[stop].keys.iter().copied();
            let keys = keys.filter(|key| !(types && is_typed(key))).collect();
            let keys = besides(keys, &rows[at].keys);
            rebind(rows, at, keys);
            chosen[at] = chosen[stop];
        }
    }
}

fn rebind(rows: &mut [Row], at: usize, keys: Vec<Key>) {
    speak_for_themselves(rows, at);
    let row = &mut rows[at];
    row.keys = keys;
    row.label = row.key_names().into();
    row.help = without_key(&row.help).to_owned().into();
}

/// The help text without the second key at its end, as in `draft a waypoint (Enter)`.
fn without_key(help: &str) -> &str {
    let named = help
        .strip_suffix(')')
        .and_then(|help| help.rsplit_once(" ("));
    match named {
        Some((help, key)) if notation::read(key).is_ok() => help,
        _ => help,
    }
}

/// Finds keys with two meanings in one context; the later rebinding is the mistake.
fn clashes(rows: &[Row], chosen: &[Option<usize>], rebindings: &[Rebinding]) -> Vec<KeyMistake> {
    let mut clashes: Vec<Clash<'_>> = Vec::new();
    for (at, row) in rows.iter().enumerate() {
        for (other, twin) in rows.iter().enumerate().skip(at + 1) {
            let shared = row.keys.iter().find(|key| twin.keys.contains(key));
            let (Some(&key), true) = (shared, row.context == twin.context) else {
                continue;
            };
            // The default table has no such pair.
            let (index, taker, owner) = match (chosen[at], chosen[other]) {
                (Some(index), Some(later)) if index < later => (later, twin, row),
                (Some(index), _) => (index, row, twin),
                (None, later) => (later.unwrap_or_default(), twin, row),
            };
            let known = clashes
                .iter_mut()
                .find(|clash| (clash.index, clash.key) == (index, key));
            if let Some(clash) = known {
                clash.owners.push(owner);
            } else {
                let owners = vec![owner];
                clashes.push(Clash {
                    index,
                    key,
                    taker,
                    owners,
                });
            }
        }
    }
    let mistakes = clashes.iter().map(|clash| KeyMistake {
        index: clash.index,
        message: clash.message(&rebindings[clash.index].context),
    });
    mistakes.collect()
}

/// A rebound key with another meaning in one or more contexts.
struct Clash<'r> {
    /// Index of the rebinding.
    index: usize,
    key: Key,
    taker: &'r Row,
    owners: Vec<&'r Row>,
}

impl Clash<'_> {
    /// The message about the mistake in a context.
    fn message(&self, place: &str) -> String {
        let list = |tell: fn(&Row) -> String| {
            let owned = self.owners.iter().map(|owner| {
                if owner.context.name() == place {
                    tell(owner)
                } else {
                    format!("{} in {}", tell(owner), section_of(owner.context))
                }
            });
            owned.collect::<Vec<_>>().join(", ")
        };
        let (key, taker) = (notation::name(self.key), self.taker.name);
        let from = match &self.owners[..] {
            [only] => format!("`{}`", only.name),
            _ => "them".to_owned(),
        };
        format!(
            "`{key}` cannot be the key for `{taker}`: it is the key for {}. Choose another one, or take it from {from} first: \
             {}",
            list(|owner| format!("`{}`", owner.name)),
            list(|owner| format!("{} = []", owner.name))
        )
    }
}

/// Gives a row with changed keys its own description, and also the rows that shared its description.
fn speak_for_themselves(rows: &mut [Row], at: usize) {
    let first = (0..=at).rev().find(|&row| TABLE[row].has_description());
    let first = first.unwrap_or(at);
    for row in &mut rows[group(first)] {
        row.label = row.key_names().into();
        let in_words = words::alone(row.action).is_some();
        let has_help = matches!(row.context, Context::Dashboard | Context::Route);
        if has_help && (in_words || row.help.is_empty()) {
            row.help = row.does().into_owned().into();
        }
    }
}

/// The value of [`Row::labels`].
fn labels(rows: &[Row], at: usize) -> Cow<'static, str> {
    let group = group(at);
    let (rows, table) = (&rows[group.clone()], &TABLE[group]);
    let mut pairs = rows.iter().zip(table);
    if pairs.all(|(row, binding)| row.keys == binding.keys) {
        return table[0].label.into();
    }
    let first = table[0].keys.first();
    if first.is_some_and(|first| notation::name(*first) == table[0].label) {
        return rows[0].first_key().into();
    }
    let keys = rows.iter().map(Row::first_key);
    let keys: Vec<_> = keys.filter(|key| !key.is_empty()).collect();
    keys.join(" ").into()
}

/// A row of the table and the following rows without a description of their own.
fn group(first: usize) -> Range<usize> {
    let follow = TABLE[first + 1..]
        .iter()
        .take_while(|row| !row.has_description());
    first..first + 1 + follow.count()
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
    let is_it = |row: &Row| row.context == context && row.name == name;
    rows.iter()
        .position(is_it)
        .ok_or_else(|| format!("no key does `{name}`{}", instead(rows, context, name)))
}

/// Suggestions for an unknown name: the same or a similar name in this context, then in other contexts, then names with a word
/// in common.
fn instead(rows: &[Row], context: Context, name: &str) -> String {
    let of = |here: bool| {
        let names = rows
            .iter()
            .filter(move |row| (row.context == context) == here);
        names.map(|row| row.name)
    };
    if let Some(near) = suggest::nearest(name, of(true)) {
        return format!("; did you mean `{near}`?");
    }
    if let Some(near) = suggest::nearest(name, of(false)) {
        let mut elsewhere = rows.iter().filter(|row| row.context != context);
        let section = elsewhere.find(|row| row.name == near);
        let section = section.map_or_else(String::new, |row| section_of(row.context));
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

/// The configuration table of a context.
fn section_of(context: Context) -> String {
    match context {
        Context::Dashboard => "[keys]".to_owned(),
        context => format!("[keys.{}]", context.name()),
    }
}

/// The rows of the default table.
fn table() -> impl Iterator<Item = Row> {
    let names = NAMES.iter().map(String::as_str);
    TABLE
        .iter()
        .zip(names)
        .map(|(binding, name)| Row::of(binding, name))
}

impl Binding {
    /// Whether the row has a description, which also covers the following rows without one.
    const fn has_description(&self) -> bool {
        !self.help.is_empty() || !self.footer.is_empty()
    }
}

impl Row {
    fn of(binding: &Binding, name: &'static str) -> Self {
        Self {
            context: binding.context,
            label: binding.label.into(),
            labels: Cow::default(),
            keys: binding.keys.to_vec(),
            action: binding.action,
            name,
            help: binding.help.into(),
            footer: binding.footer,
        }
    }

    /// The first key of the row; empty without keys.
    fn first_key(&self) -> String {
        let first = self.keys.first();
        first.map_or_else(String::new, |key| notation::name(*key))
    }

    /// The keys of the row, separated by spaces.
    pub(crate) fn key_names(&self) -> String {
        notation::names(&self.keys)
    }

    /// The description of the row, even if another row of the table covers it.
    pub(crate) fn does(&self) -> Cow<'_, str> {
        match words::alone(self.action) {
            Some(words) => words.into(),
            None if !self.help.is_empty() => self.help.as_ref().into(),
            None if !self.footer.is_empty() => self.footer.into(),
            None => self.name.replace('-', " ").into(),
        }
    }

    fn takes(&self, key: KeyEvent) -> bool {
        let mut held = key.modifiers & (KeyModifiers::CONTROL | KeyModifiers::SHIFT);
        if let KeyCode::Char(_) = key.code {
            // The character implies Shift: some terminals also report Shift for `W`, others do not.
            held -= KeyModifiers::SHIFT;
        }
        self.keys.contains(&(key.code, held))
    }
}

#[cfg(test)]
mod tests;
