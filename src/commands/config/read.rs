//! Reads the text of a configuration with serde. After each mistake, it reads the text again without the wrong entry.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use groundwave_lines::Profile;
use serde::{Deserialize, Deserializer};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::mistakes::{Mistake, Mistakes};
use super::{Config, Dashboard, Link, OwnRobot, Recording, Robot};
use crate::io::ports;
use crate::model::keys::{Keymap, Rebinding};
use crate::model::{AlarmSetting, Limits};
use crate::share::Address;
use crate::suggest;

/// Keys by context and action.
type Keys = BTreeMap<String, BTreeMap<Spanned<String>, Choice>>;

/// The sections of the file, without `[link.NAME]`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Sections {
    link: Link,
    robot: BTreeMap<String, Robot>,
    dashboard: Dashboard,
    recording: Recording,
    limits: Limits,
    alarms: Hook,
    keys: Keys,
}

/// Section `[alarms]`: the hook.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Hook {
    run: Option<String>,
}

/// The keys for one action.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a key such as \"F12\", several such as [\"F12\", \"Ctrl-B\"], or none: []"
)]
enum Choice {
    One(String),
    Several(Vec<String>),
}

/// Reads a configuration.
///
/// # Errors
/// Every mistake, in the order of the text.
pub fn parse(text: &str) -> Result<Config, Vec<Mistake>> {
    match parse_lenient(text) {
        (config, mistakes) if mistakes.is_empty() => Ok(config),
        (_, mistakes) => Err(mistakes),
    }
}

/// Reads a configuration without its wrong entries; returns those as mistakes, in the order of the text.
pub(super) fn parse_lenient(text: &str) -> (Config, Vec<Mistake>) {
    let mut mistakes = Mistakes::new(text);
    let (document, errors) = DeTable::parse_recoverable(text);
    let mut notes = Mistakes::new(text);
    let mut config = read(document.into_inner(), &mut mistakes, &mut notes);
    // A field that no line of the protocol has is the field of such a robot.
    let has_own = |robot: &Robot| robot.lines.is_some() || !robot.commands.is_empty();
    if !config.robots.values().any(has_own) {
        config.notes = notes.into_sorted();
    }
    if !errors.is_empty() {
        // Mistakes in the syntax may cause other mistakes.
        mistakes = Mistakes::new(text);
    }
    for error in &errors {
        mistakes.add(&error.span().unwrap_or_default(), error.message());
    }
    (config, mistakes.into_sorted())
}

fn read(
    mut document: DeTable<'_>,
    mistakes: &mut Mistakes<'_>,
    notes: &mut Mistakes<'_>,
) -> Config {
    let spans = Spans(document.clone());
    let mut profiles = DeTable::new();
    if let Some(link) = section(&mut document, "link") {
        profiles = split_tables(link);
        if let Some((port, _)) = link.remove_entry("port") {
            let message = "unknown key `port` in [link]; a port belongs to [link.NAME]";
            mistakes.add(&port.span(), message);
        }
    }
    if let Some(keys) = section(&mut document, "keys") {
        let elsewhere = split_tables(keys);
        let dashboard = std::mem::replace(keys, elsewhere);
        if let Some(own) = section(keys, "dashboard") {
            own.extend(dashboard);
        } else {
            insert(keys, "dashboard", dashboard);
        }
    }
    inherit_limits(&mut document);
    let alarms = alarms(&mut document, mistakes, notes);
    let mut sections: Sections = deserialize(document, &[], mistakes);
    let mut links: BTreeMap<String, Link> = deserialize(profiles, &["link"], mistakes);
    check_baud(sections.link.baud, &["link"], &spans, mistakes);
    links.retain(|name, link| {
        let path = ["link", name];
        check_baud(link.baud, &path, &spans, mistakes);
        let has_port = link.port.is_some();
        if !has_port && !mistakes.are_in(&path) {
            let message = format!(
                "[link.{name}] needs a port, such as port = \"{}\"",
                ports::EXAMPLE
            );
            mistakes.add(&spans.of(&path), message);
        }
        has_port
    });
    let mut robots = sections.robot;
    let before = sections.limits.clone();
    for alarm in &alarms {
        alarm.adjust(&mut sections.limits, &before);
        for robot in robots.values_mut() {
            alarm.adjust(&mut robot.limits, &before);
        }
    }
    check_limits(&sections.limits, &["limits"], &spans, mistakes);
    robots.retain(|name, robot| check_robot(name, robot, &links, &spans, mistakes));
    Config {
        link: sections.link,
        dashboard: sections.dashboard,
        limits: sections.limits,
        alarms,
        alarm_hook: sections.alarms.run,
        keys: keymap(sections.keys, mistakes),
        links,
        robots,
        own: OwnRobot::default(),
        notes: Vec::new(),
        recording: sections.recording,
        path: None,
        text: String::new(),
    }
}

/// A section by name, if it is a table.
fn section<'d, 't>(document: &'d mut DeTable<'t>, name: &str) -> Option<&'d mut DeTable<'t>> {
    match document.get_mut(name)?.get_mut() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}

fn insert<'t>(table: &mut DeTable<'t>, name: &'static str, section: DeTable<'t>) {
    let value = Spanned::new(0..0, DeValue::Table(section));
    table.insert(Spanned::new(0..0, name.into()), value);
}

/// Takes the tables out of a section and returns them.
fn split_tables<'t>(section: &mut DeTable<'t>) -> DeTable<'t> {
    let (tables, own) = std::mem::take(section)
        .into_iter()
        .partition(|(_, value)| value.get_ref().is_table());
    *section = own;
    tables
}

/// Takes the tables of `[[alarm]]` out of the document; alarms with a mistake are left out.
fn alarms(
    document: &mut DeTable<'_>,
    mistakes: &mut Mistakes<'_>,
    notes: &mut Mistakes<'_>,
) -> Vec<AlarmSetting> {
    let Some((_, value)) = document.remove_entry("alarm") else {
        return Vec::new();
    };
    let at = value.span();
    let DeValue::Array(tables) = value.into_inner() else {
        mistakes.add(
            &at,
            "alarms are a list: write [[alarm]]; the hook is `run` in [alarms]",
        );
        return Vec::new();
    };
    let mut alarms = Vec::<AlarmSetting>::new();
    let mut codes = BTreeSet::new();
    for table in tables {
        let at = table.span();
        let DeValue::Table(table) = table.into_inner() else {
            mistakes.add(&at, "write each alarm as a table: [[alarm]]");
            continue;
        };
        let before = mistakes.count();
        let field_at = table.get("field").map_or_else(|| at.clone(), Spanned::span);
        let alarm: AlarmSetting = deserialize(table, &["alarm"], mistakes);
        if mistakes.count() > before {
            continue;
        }
        let code = alarm.code();
        match alarm.check() {
            _ if codes.contains(&code) => {
                mistakes.add(&at, format!("alarm `{}` is there twice", alarm.name));
            }
            Ok(()) => {
                codes.insert(code);
                if let Some(note) = alarm.note() {
                    notes.add(&field_at, note);
                }
                alarms.push(alarm);
            }
            Err(error) => mistakes.add(&at, error),
        }
    }
    alarms
}

/// Gives each robot the entries of `[limits]` that its own limits leave out.
fn inherit_limits(document: &mut DeTable<'_>) {
    let limits = section(document, "limits").cloned().unwrap_or_default();
    let Some(robots) = section(document, "robot") else {
        return;
    };
    for (_, robot) in robots.iter_mut() {
        let DeValue::Table(robot) = robot.get_mut() else {
            continue;
        };
        if !robot.contains_key("limits") {
            insert(robot, "limits", DeTable::new());
        }
        let Some(own) = section(robot, "limits") else {
            continue;
        };
        for (name, limit) in &limits {
            if !own.contains_key(name) {
                own.insert(name.clone(), limit.clone());
            }
        }
    }
}

/// Deserializes a table repeatedly, each time without the entry of the last error.
fn deserialize<'t, T: Deserialize<'t> + Default>(
    mut table: DeTable<'t>,
    path: &[&str],
    mistakes: &mut Mistakes<'_>,
) -> T {
    loop {
        let value = Spanned::new(0..0, DeValue::Table(table.clone()));
        let error = match T::deserialize(ValueDeserializer::from(value)) {
            Ok(read) => return read,
            Err(error) => error,
        };
        let at = error.span().unwrap_or_default();
        let removed = remove(&mut table, &at, path);
        mistakes.add_value(&at, removed.first(), error.message());
        if removed.is_empty() || mistakes.are_too_many() {
            return T::default();
        }
    }
}

/// Removes the entries whose key or value is at a range of the text; returns their paths.
fn remove(table: &mut DeTable<'_>, at: &Range<usize>, path: &[&str]) -> Vec<Vec<String>> {
    let mut removed = Vec::new();
    let entries = std::mem::take(table).into_iter();
    let rest = entries.filter_map(|(key, mut value)| {
        let span = value.span();
        let is_inside = span.start <= at.start && at.end <= span.end;
        let is_value = span == *at || is_inside && !value.get_ref().is_table();
        let path = [path, &[key.get_ref().as_ref()]].concat();
        if key.span() == *at || is_value {
            removed.push(path.into_iter().map(str::to_owned).collect());
            return None;
        }
        if let DeValue::Table(inner) = value.get_mut() {
            removed.extend(remove(inner, at, &path));
        }
        Some((key, value))
    });
    *table = rest.collect();
    removed
}

/// The document as written; knows the positions of its sections.
struct Spans<'t>(DeTable<'t>);

impl Spans<'_> {
    /// Position of a section in the text; the start of the text if the section is not written.
    fn of(&self, path: &[&str]) -> Range<usize> {
        self.find(path).unwrap_or_default()
    }

    fn find(&self, path: &[&str]) -> Option<Range<usize>> {
        let (first, rest) = path.split_first()?;
        let mut value = self.0.get(*first)?;
        for name in rest {
            value = value.get_ref().as_table()?.get(*name)?;
        }
        Some(value.span())
    }
}

fn check_baud(baud: Option<u32>, path: &[&str], spans: &Spans<'_>, mistakes: &mut Mistakes<'_>) {
    if baud == Some(0) {
        let section = path.join(".");
        let message = format!("[{section}]: baud must be above 0; the SR04's radio has 2400");
        mistakes.add(&spans.of(path), message);
    }
}

fn check_limits(limits: &Limits, path: &[&str], spans: &Spans<'_>, mistakes: &mut Mistakes<'_>) {
    let section = path.join(".");
    if limits.battery_low_dv < limits.battery_critical_dv {
        let message = format!(
            "[{section}]: battery_low_dv = {} is below battery_critical_dv = {}, so the alarm \"low\" would never come",
            limits.battery_low_dv, limits.battery_critical_dv
        );
        mistakes.add(&spans.of(path), message);
    }
    if limits.loss_pct > 100 {
        let message = format!(
            "[{section}]: loss_pct = {} is above 100, so the alarm would never come",
            limits.loss_pct
        );
        mistakes.add(&spans.of(path), message);
    }
}

/// Checks `[robot.NAME]`; returns whether it names a link.
fn check_robot(
    name: &str,
    robot: &Robot,
    links: &BTreeMap<String, Link>,
    spans: &Spans<'_>,
    mistakes: &mut Mistakes<'_>,
) -> bool {
    let path = ["robot", name];
    let limits_path = ["robot", name, "limits"];
    if spans.find(&limits_path).is_some() {
        check_limits(&robot.limits, &limits_path, spans, mistakes);
    }
    check_baud(robot.baud, &path, spans, mistakes);
    check_own(name, robot, spans, mistakes);
    let Some(link) = &robot.link else {
        if !mistakes.are_in(&path) {
            let message = format!(
                "[robot.{name}] needs a link, such as link = \"{}\"",
                ports::EXAMPLE
            );
            mistakes.add(&spans.of(&path), message);
        }
        return false;
    };
    let names = links.keys().map(String::as_str);
    let may_be_a_name = link != "sim" && !link.contains(['/', ':']);
    let near = suggest::nearest(link, names).filter(|near| near != link);
    if let Some(near) = near.filter(|_| may_be_a_name) {
        let message = format!("there is no [link.{link}]; did you mean `{near}`?");
        mistakes.add(&spans.of(&["robot", name, "link"]), message);
    }
    true
}

/// Checks `[robot.NAME.lines]` and `[robot.NAME.commands]`.
fn check_own(name: &str, robot: &Robot, spans: &Spans<'_>, mistakes: &mut Mistakes<'_>) {
    if let Some(Err(error)) = robot.lines.as_ref().map(Profile::check) {
        let path = ["robot", name, "lines", error.setting];
        let place = spans.find(&path).unwrap_or_else(|| spans.of(&path[..3]));
        mistakes.add(&place, format!("[robot.{name}.lines]: {error}"));
    }
    for (command, own) in &robot.commands {
        let is_word = !command.is_empty() && !command.contains(char::is_whitespace);
        let checked = own.check().map_err(|error| error.to_string());
        let checked = if is_word {
            checked
        } else {
            Err("the name of a command is one word".to_owned())
        };
        if let Err(error) = checked {
            let path = ["robot", name, "commands", command];
            let message = format!("[robot.{name}.commands] {command}: {error}");
            mistakes.add(&spans.of(&path), message);
        }
    }
}

fn keymap(keys: Keys, mistakes: &mut Mistakes<'_>) -> Keymap {
    let mut spans = Vec::new();
    let mut rebindings = Vec::new();
    for (context, choices) in keys {
        for (name, choice) in choices {
            spans.push(name.span());
            rebindings.push(Rebinding {
                context: context.clone(),
                name: name.into_inner(),
                keys: match choice {
                    Choice::One(key) => vec![key],
                    Choice::Several(keys) => keys,
                },
            });
        }
    }
    Keymap::with(&rebindings).unwrap_or_else(|found| {
        for mistake in found {
            let at = spans.get(mistake.index).cloned().unwrap_or_default();
            mistakes.add(&at, mistake.message);
        }
        Keymap::default()
    })
}

/// Deserializes an address to share on.
pub(super) fn address<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Address>, D::Error> {
    let text = String::deserialize(deserializer)?;
    text.parse().map(Some).map_err(serde::de::Error::custom)
}
