//! From the text of a configuration to what it says.

mod entries;
mod mistakes;

use std::collections::BTreeMap;
use std::ops::Range;

use serde::{Deserialize, Deserializer};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::{Config, Link, Robot};
use crate::model::Limits;
use crate::model::keys::{Keymap, Rebinding};
use crate::share::Address;
use crate::suggest;
use entries::{DASHBOARD, Entry, LIMITS, LINK, LINK_PROFILE, RECORDING, ROBOT, SECTIONS};
use mistakes::Found;
pub use mistakes::Mistake;

/// Reads a configuration.
///
/// # Errors
/// Everything that is wrong with it, in the order of the text.
pub fn parse(text: &str) -> Result<Config, Vec<Mistake>> {
    match parse_what_holds(text) {
        (config, mistakes) if mistakes.is_empty() => Ok(config),
        (_, mistakes) => Err(mistakes),
    }
}

/// Reads what can be read of a configuration; what is wrong with the rest stands beside it, in the order of the text.
pub(super) fn parse_what_holds(text: &str) -> (Config, Vec<Mistake>) {
    let mut found = Found::in_text(text);
    let (document, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        let config = read(document.into_inner(), &mut found);
        return (config, found.mistakes());
    }
    // What follows from a slip in the notation is no mistake of its own.
    let config = read(document.into_inner(), &mut Found::in_text(text));
    for error in &errors {
        found.say_syntax(error);
    }
    (config, found.mistakes())
}

fn read(document: DeTable<'_>, found: &mut Found<'_>) -> Config {
    let mut config = Config::default();
    // What a robot does not limit itself. The table is in alphabetical order: this comes before the robots.
    let mut limits = DeTable::new();
    for (key, value) in document {
        let Some(section) = found.known(&key, SECTIONS, "at the top of the file") else {
            continue;
        };
        let at = value.span();
        let Some(table) = table(&key, value, found) else {
            continue;
        };
        match section {
            "link" => {
                let (own, profiles) = apart(table);
                config.link = section_of(own, LINK, "[link]", found);
                carries(&config.link, &at, "[link]", found);
                let profiles = profiles.into_iter().filter_map(|(name, at, profile)| {
                    link(&name, &at, profile, found).map(|link| (name, link))
                });
                config.links = profiles.collect();
            }
            "robot" => {
                let (own, profiles) = apart(table);
                for (stray, _) in own {
                    found.say(&stray.span(), "a robot has a name: [robot.NAME]");
                }
                let profiles = profiles.into_iter().filter_map(|(name, at, profile)| {
                    let robot = robot(&name, &at, profile, &limits, &config.links, found);
                    robot.map(|robot| (name, robot))
                });
                config.robots = profiles.collect();
            }
            "limits" => {
                limits = good::<Limits>(table, LIMITS, "[limits]", found);
                config.limits = whole(limits.clone());
                in_order(&config.limits, &at, "[limits]", found);
            }
            "recording" => config.recording = section_of(table, RECORDING, "[recording]", found),
            "dashboard" => config.dashboard = section_of(table, DASHBOARD, "[dashboard]", found),
            _ => config.keys = keys(table, found),
        }
    }
    config
}

fn link(
    name: &str,
    at: &Range<usize>,
    profile: DeTable<'_>,
    found: &mut Found<'_>,
) -> Option<Link> {
    let what = format!("[link.{name}]");
    let (has_port, before) = (profile.contains_key("port"), found.count());
    let link: Link = section_of(profile, LINK_PROFILE, &what, found);
    carries(&link, at, &what, found);
    // A slip in the section may be the port that was meant.
    if !has_port && found.count() == before {
        found.say(
            at,
            format!("{what} needs a port, such as port = \"/dev/ttyUSB0\""),
        );
    }
    has_port.then_some(link)
}

fn robot<'t>(
    name: &str,
    at: &Range<usize>,
    profile: DeTable<'t>,
    limits: &DeTable<'t>,
    links: &BTreeMap<String, Link>,
    found: &mut Found<'_>,
) -> Option<Robot> {
    let what = format!("[robot.{name}]");
    let (own, sections) = apart(profile);
    let (has_link, before) = (own.contains_key("link"), found.count());
    let mut robot: Robot = section_of(own, ROBOT, &what, found);
    let mut all = limits.clone();
    for (section, at, own) in sections {
        let section = Spanned::new(at, section);
        if found
            .known(&section, &["limits"], &format!("in {what}"))
            .is_some()
        {
            let place = format!("[robot.{name}.limits]");
            all.extend(good::<Limits>(own, LIMITS, &place, found));
        }
    }
    robot.limits = whole(all);
    in_order(&robot.limits, at, &format!("[robot.{name}.limits]"), found);
    let Some(link) = &robot.link else {
        if !has_link && found.count() == before {
            found.say(
                at,
                format!("{what} needs a link, such as link = \"/dev/ttyUSB0\""),
            );
        }
        return None;
    };
    let names = links.keys().map(String::as_str);
    let may_be_a_name = link != "sim" && !link.contains(['/', ':']);
    let near = suggest::nearest(link, names).filter(|near| near != link);
    if let Some(near) = near.filter(|_| may_be_a_name) {
        let message = format!("{what}: there is no [link.{link}]; did you mean `{near}`?");
        found.say(at, message);
    }
    Some(robot)
}

fn carries(link: &Link, at: &Range<usize>, what: &str, found: &mut Found<'_>) {
    if link.baud == Some(0) {
        let message = format!("{what}: nothing passes at 0 baud; the SR04's radio has 2400");
        found.say(at, message);
    }
}

fn in_order(limits: &Limits, at: &Range<usize>, what: &str, found: &mut Found<'_>) {
    if limits.battery_low_dv < limits.battery_critical_dv {
        let message = format!(
            "{what}: battery_low_dv = {} lies below battery_critical_dv = {}: it would never be told",
            limits.battery_low_dv, limits.battery_critical_dv
        );
        found.say(at, message);
    }
    if limits.loss_pct > 100 {
        let message = format!(
            "{what}: loss_pct = {} would never be told: at most 100",
            limits.loss_pct
        );
        found.say(at, message);
    }
}

/// Tables by their names, and where they are.
type Named<'t> = Vec<(String, Range<usize>, DeTable<'t>)>;

/// A section's own keys, and the tables that are named in it.
fn apart(table: DeTable<'_>) -> (DeTable<'_>, Named<'_>) {
    let mut own = DeTable::new();
    let mut named = Vec::new();
    for (key, value) in table {
        let at = value.span();
        match value.into_inner() {
            DeValue::Table(table) => named.push((key.into_inner().into_owned(), at, table)),
            value => {
                own.insert(key, Spanned::new(at, value));
            }
        }
    }
    (own, named)
}

fn table<'t>(
    key: &Spanned<impl AsRef<str>>,
    value: Spanned<DeValue<'t>>,
    found: &mut Found<'_>,
) -> Option<DeTable<'t>> {
    let at = value.span();
    if let DeValue::Table(table) = value.into_inner() {
        return Some(table);
    }
    let name = key.get_ref().as_ref();
    found.say(&at, format!("`{name}` is a section: [{name}]"));
    None
}

/// What a section says; what is wrong in it is as if it were not there.
fn section_of<'t, T: Deserialize<'t> + Default>(
    table: DeTable<'t>,
    entries: &[Entry],
    place: &str,
    found: &mut Found<'_>,
) -> T {
    whole(good::<T>(table, entries, place, found))
}

/// The entries that can be read, each tried by itself.
fn good<'t, T: Deserialize<'t>>(
    table: DeTable<'t>,
    entries: &[Entry],
    place: &str,
    found: &mut Found<'_>,
) -> DeTable<'t> {
    let names: Vec<&str> = entries.iter().map(|(name, _)| *name).collect();
    let mut good = DeTable::new();
    for (key, value) in table {
        let Some(name) = found.known(&key, &names, &format!("in {place}")) else {
            continue;
        };
        let Some(entry) = entries.iter().find(|(known, _)| *known == name) else {
            continue;
        };
        let (at, alone) = (
            value.span(),
            DeTable::from_iter([(key.clone(), value.clone())]),
        );
        match T::deserialize(deserializer(alone)) {
            Ok(_) => {
                good.insert(key, value);
            }
            Err(error) => found.say_value(entry, &at, &error),
        }
    }
    good
}

/// Entries that can be read one by one can be read together.
fn whole<'t, T: Deserialize<'t> + Default>(good: DeTable<'t>) -> T {
    T::deserialize(deserializer(good)).unwrap_or_default()
}

fn deserializer(table: DeTable<'_>) -> ValueDeserializer<'_> {
    ValueDeserializer::from(Spanned::new(0..0, DeValue::Table(table)))
}

/// `[keys]` is about the dashboard, `[keys.drive]` and the like about other places.
fn keys(table: DeTable<'_>, found: &mut Found<'_>) -> Keymap {
    let (own, elsewhere) = apart(table);
    let mut rebindings = Vec::new();
    let mut spans = Vec::new();
    let places = [("dashboard".to_owned(), own)];
    let elsewhere = elsewhere.into_iter().map(|(place, _, keys)| (place, keys));
    for (context, table) in places.into_iter().chain(elsewhere) {
        for (name, keys) in table {
            let Some(keys) = chosen(keys, found) else {
                continue;
            };
            spans.push(name.span());
            rebindings.push(Rebinding {
                context: context.clone(),
                name: name.into_inner().into_owned(),
                keys,
            });
        }
    }
    Keymap::with(&rebindings).unwrap_or_else(|mistakes| {
        for mistake in mistakes {
            let at = spans.get(mistake.index).cloned().unwrap_or_default();
            found.say(&at, mistake.message);
        }
        Keymap::default()
    })
}

fn chosen(keys: Spanned<DeValue<'_>>, found: &mut Found<'_>) -> Option<Vec<String>> {
    let at = keys.span();
    // A choice of two shapes does not say where it fails.
    match OneOrMore::deserialize(ValueDeserializer::from(keys)) {
        Ok(OneOrMore::One(key)) => Some(vec![key]),
        Ok(OneOrMore::More(keys)) => Some(keys),
        Err(_) => {
            let message =
                "give a key such as \"F9\", several such as [\"F9\", \"Ctrl-B\"], or none: []";
            found.say(&at, message);
            None
        }
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum OneOrMore {
    One(String),
    More(Vec<String>),
}

/// An address to share on.
pub(super) fn address<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Address>, D::Error> {
    let text = String::deserialize(deserializer)?;
    text.parse().map(Some).map_err(serde::de::Error::custom)
}

#[cfg(test)]
mod tests;
