//! From the text of a configuration to what it says; what is wrong is named by line and column.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Deserializer};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::{Config, Link, Robot};
use crate::model::Limits;
use crate::model::keys::{Keymap, Rebinding};
use crate::share::Address;
use crate::suggest;

const SECTIONS: &[&str] = &["link", "robot", "dashboard", "recording", "limits", "keys"];

const LINK: &[&str] = &["baud", "radio", "latency_ms", "share"];

const LINK_PROFILE: &[&str] = &["port", "baud", "radio", "latency_ms", "share"];

const DASHBOARD: &[&str] = &["theme", "ascii", "bell", "mouse"];

const RECORDING: &[&str] = &["keep_minutes", "rotate"];

const LIMITS: &[&str] = &[
    "battery_low_dv",
    "battery_critical_dv",
    "battery_hysteresis_dv",
    "battery_for_s",
    "silent_s",
    "loss_pct",
    "loss_for_s",
    "stalled_s",
    "fallen_s",
    "thrash_s",
];

const ROBOT: &[&str] = &["link", "theme", "ascii", "bell", "mouse"];

/// What is wrong with a configuration, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)
    }
}

impl std::error::Error for Mistake {}

/// A mistake at bytes of the text.
struct Misplaced {
    at: Option<Range<usize>>,
    message: String,
}

impl Misplaced {
    fn new(at: Range<usize>, message: impl Into<String>) -> Self {
        Self {
            at: Some(at),
            message: message.into(),
        }
    }

    fn of(error: &toml::de::Error) -> Self {
        Self {
            at: error.span(),
            message: error.message().to_owned(),
        }
    }

    fn place(self, text: &str) -> Mistake {
        let at = self.at.map_or(0, |at| at.start).min(text.len());
        let before = text.get(..at).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |end| end + 1);
        Mistake {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message: self.message,
        }
    }
}

/// Reads a configuration.
///
/// # Errors
/// Says where what is wrong.
pub fn parse(text: &str) -> Result<Config, Mistake> {
    read(text).map_err(|misplaced| misplaced.place(text))
}

fn read(text: &str) -> Result<Config, Misplaced> {
    let document = DeTable::parse(text).map_err(|error| Misplaced::of(&error))?;
    let mut config = Config::default();
    // What a robot does not limit itself. The table is in alphabetical order: this comes before the robots.
    let mut limits = DeTable::new();
    for (key, value) in document.into_inner() {
        match known(&key, SECTIONS, "at the top of the file")? {
            "link" => {
                let (own, profiles) = apart(&key, value)?;
                let at = own.span();
                config.link = section(own, LINK, "[link]")?;
                carries(&config.link, at, "[link]")?;
                config.links = each(profiles, link)?;
            }
            "robot" => {
                let (own, profiles) = apart(&key, value)?;
                if let Some((stray, _)) = own.get_ref().as_table().and_then(|own| own.iter().next())
                {
                    let message = "a robot has a name: [robot.NAME]";
                    return Err(Misplaced::new(stray.span(), message));
                }
                config.robots = each(profiles, |name, profile| {
                    robot(name, profile, &limits, &config.links)
                })?;
            }
            "limits" => {
                limits = table(&key, value.clone())?;
                let at = value.span();
                config.limits = section(value, LIMITS, "[limits]")?;
                in_order(&config.limits, at, "[limits]")?;
            }
            "recording" => config.recording = section(value, RECORDING, "[recording]")?,
            "dashboard" => config.dashboard = section(value, DASHBOARD, "[dashboard]")?,
            _ => config.keys = keys(&key, value)?,
        }
    }
    Ok(config)
}

fn each<'t, T>(
    profiles: Named<'t>,
    read: impl Fn(&str, Spanned<DeValue<'t>>) -> Result<T, Misplaced>,
) -> Result<BTreeMap<String, T>, Misplaced> {
    let read = |(name, profile): (String, _)| {
        let profile = read(&name, profile)?;
        Ok((name, profile))
    };
    profiles.into_iter().map(read).collect()
}

fn link(name: &str, profile: Spanned<DeValue<'_>>) -> Result<Link, Misplaced> {
    let (what, at) = (format!("[link.{name}]"), profile.span());
    let link: Link = section(profile, LINK_PROFILE, &what)?;
    carries(&link, at.clone(), &what)?;
    if link.port.is_none() {
        return Err(Misplaced::new(at, format!("{what} needs a port")));
    }
    Ok(link)
}

fn robot<'t>(
    name: &str,
    profile: Spanned<DeValue<'t>>,
    limits: &DeTable<'t>,
    links: &BTreeMap<String, Link>,
) -> Result<Robot, Misplaced> {
    let (what, at) = (format!("[robot.{name}]"), profile.span());
    let (own, sections) = apart(&Spanned::new(at.clone(), name), profile)?;
    let mut robot: Robot = section(own, ROBOT, &what)?;
    let mut all = limits.clone();
    for (key, value) in sections {
        let key = Spanned::new(value.span(), key);
        known(&key, &["limits"], &format!("in {what}"))?;
        all.extend(table(&key, value)?);
    }
    let all = Spanned::new(at.clone(), DeValue::Table(all));
    robot.limits = section(all, LIMITS, &format!("[robot.{name}.limits]"))?;
    let Some(link) = &robot.link else {
        return Err(Misplaced::new(at, format!("{what} needs a link")));
    };
    let names = links.keys().map(String::as_str);
    let may_be_a_name = link != "sim" && !link.contains(['/', ':']);
    let near = suggest::nearest(link, names).filter(|near| near != link);
    if let Some(near) = near.filter(|_| may_be_a_name) {
        let message = format!("{what}: there is no [link.{link}]; did you mean `{near}`?");
        return Err(Misplaced::new(at, message));
    }
    in_order(&robot.limits, at, &format!("[robot.{name}.limits]"))?;
    Ok(robot)
}

fn carries(link: &Link, at: Range<usize>, what: &str) -> Result<(), Misplaced> {
    if link.baud == Some(0) {
        let message = format!("{what}: nothing passes at 0 baud; the SR04's radio has 2400");
        return Err(Misplaced::new(at, message));
    }
    Ok(())
}

fn in_order(limits: &Limits, at: Range<usize>, what: &str) -> Result<(), Misplaced> {
    if limits.battery_low_dv < limits.battery_critical_dv {
        let message = format!(
            "{what}: battery_low_dv = {} lies below battery_critical_dv = {}: it would never be told",
            limits.battery_low_dv, limits.battery_critical_dv
        );
        return Err(Misplaced::new(at, message));
    }
    Ok(())
}

/// A key that is one of these.
fn known<'k>(
    key: &'k Spanned<impl AsRef<str>>,
    all: &[&'static str],
    place: &str,
) -> Result<&'k str, Misplaced> {
    let word = key.get_ref().as_ref();
    if all.contains(&word) {
        return Ok(word);
    }
    let near = suggest::question_or(
        word,
        all.iter().copied(),
        format_args!("there are {}", all.join(", ")),
    );
    Err(Misplaced::new(
        key.span(),
        format!("unknown key `{word}` {place}{near}"),
    ))
}

/// Tables by their names.
type Named<'t> = Vec<(String, Spanned<DeValue<'t>>)>;

/// A section's own keys, and the tables that are named in it.
fn apart<'t>(
    key: &Spanned<impl AsRef<str>>,
    value: Spanned<DeValue<'t>>,
) -> Result<(Spanned<DeValue<'t>>, Named<'t>), Misplaced> {
    let span = value.span();
    let mut own = DeTable::new();
    let mut named = Vec::new();
    for (key, value) in table(key, value)? {
        if value.get_ref().is_table() {
            named.push((key.into_inner().into_owned(), value));
        } else {
            own.insert(key, value);
        }
    }
    Ok((Spanned::new(span, DeValue::Table(own)), named))
}

fn table<'t>(
    key: &Spanned<impl AsRef<str>>,
    value: Spanned<DeValue<'t>>,
) -> Result<DeTable<'t>, Misplaced> {
    let span = value.span();
    if let DeValue::Table(table) = value.into_inner() {
        Ok(table)
    } else {
        let name = key.get_ref().as_ref();
        Err(Misplaced::new(
            span,
            format!("`{name}` is a section: [{name}]"),
        ))
    }
}

fn section<'t, T: Deserialize<'t>>(
    value: Spanned<DeValue<'t>>,
    keys: &[&'static str],
    place: &str,
) -> Result<T, Misplaced> {
    for (key, _) in value.get_ref().as_table().into_iter().flatten() {
        known(key, keys, &format!("in {place}"))?;
    }
    T::deserialize(ValueDeserializer::from(value)).map_err(|error| Misplaced::of(&error))
}

/// `[keys]` is about the dashboard, `[keys.drive]` and the like about other places.
fn keys(key: &Spanned<impl AsRef<str>>, value: Spanned<DeValue<'_>>) -> Result<Keymap, Misplaced> {
    let (own, elsewhere) = apart(key, value)?;
    let mut rebindings = Vec::new();
    let mut spans = Vec::new();
    let places = [("dashboard".to_owned(), own)];
    for (context, value) in places.into_iter().chain(elsewhere) {
        let named = Spanned::new(value.span(), &context);
        for (name, keys) in table(&named, value)? {
            spans.push(name.span());
            rebindings.push(Rebinding {
                context: context.clone(),
                name: name.into_inner().into_owned(),
                keys: chosen(keys)?,
            });
        }
    }
    Keymap::with(&rebindings).map_err(|mistake| {
        let at = spans.get(mistake.index).cloned().unwrap_or_default();
        Misplaced::new(at, mistake.message)
    })
}

fn chosen(keys: Spanned<DeValue<'_>>) -> Result<Vec<String>, Misplaced> {
    let span = keys.span();
    // A choice of two shapes does not say where it fails.
    OneOrMore::deserialize(ValueDeserializer::from(keys))
        .map(Vec::from)
        .map_err(|error| Misplaced::new(span, error.message()))
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "a key such as \"F9\", or several such as [\"F9\", \"Ctrl-B\"]"
)]
enum OneOrMore {
    One(String),
    More(Vec<String>),
}

impl From<OneOrMore> for Vec<String> {
    fn from(keys: OneOrMore) -> Self {
        match keys {
            OneOrMore::One(key) => vec![key],
            OneOrMore::More(keys) => keys,
        }
    }
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
