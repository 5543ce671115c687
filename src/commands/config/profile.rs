//! Resolves the name of a link: a robot or link of the configuration, a USB adapter, or a link as given.

use super::super::cli::{Connection, LinkArgs};
use std::path::Path;

use super::{Config, Dashboard, Exit, Fault, Link, OwnRobot, Robot};
use crate::io::link::{LinkSpec, has_port};
use crate::io::ports;
use crate::suggest;

impl Config {
    /// Resolves a link; returns the link and its configuration. A robot's settings take precedence over its link's, and those over `[link]`.
    pub(in super::super) fn at(
        &self,
        link: &LinkSpec,
        options: &LinkArgs,
    ) -> Result<(LinkSpec, Self), Fault> {
        let usage = |message: String| Fault::new(Exit::Usage, message);
        let mut config = self.clone();
        let mut link = link.clone();
        let mut robot_baud = None;
        if let Some(robot) = named(&link).and_then(|name| self.robots.get(name)) {
            config.dashboard = dashboard(robot, &self.dashboard);
            config.limits = robot.limits.clone();
            config.own = OwnRobot::of(robot);
            config.alarms.extend(robot.field_alarms());
            robot_baud = robot.baud;
            link = parse(robot.link.as_deref()).map_err(usage)?;
        }
        if let Some(profile) = named(&link).and_then(|name| self.links.get(name)) {
            config.link = merged(profile, &self.link);
            link = parse(profile.port.as_deref()).map_err(usage)?;
        }
        config.link.baud = robot_baud.or(config.link.baud);
        if let Some(name) = named(&link) {
            if let Some(adapter) = name.strip_prefix("usb:") {
                let port =
                    ports::find_usb(adapter).map_err(|error| Fault::new(Exit::NoLink, error))?;
                return Ok((LinkSpec::Serial(port.into()), config));
            }
            match self.check_port(name) {
                // The device comes later.
                Err(fault) if fault.exit == Exit::NoLink && options.wait.is_some() => {}
                checked => checked?,
            }
        }
        Ok((link, config))
    }

    /// Refuses a name that is neither configured nor an existing device.
    fn check_port(&self, name: &str) -> Result<(), Fault> {
        if Path::new(name).exists() || !cfg!(unix) && ports::is_there(name) {
            return Ok(());
        }
        let names: Vec<&str> = self
            .robots
            .keys()
            .chain(self.links.keys())
            .map(String::as_str)
            .collect();
        if let Some(near) = suggest::nearest(name, names.iter().copied()) {
            let message =
                format!("no link or robot `{name}` in the configuration; did you mean `{near}`?");
            return Err(Fault::new(Exit::Usage, message));
        }
        let address = match name.parse::<u16>() {
            Ok(port) => Some(format!("127.0.0.1:{port}")),
            Err(_) => has_port(name).then(|| name.to_owned()),
        };
        if let Some(address) = address {
            let message = format!("no device is called `{name}`; did you mean tcp:{address}?");
            return Err(Fault::new(Exit::Usage, message));
        }
        let configured = match names[..] {
            [] => "none configured".to_owned(),
            _ => format!("configured: {}", names.join(", ")),
        };
        let is_key = name
            .bytes()
            .all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b));
        let to_configure = if is_key {
            let example = ports::EXAMPLE;
            format!("; to configure a name, write [robot.{name}] and link = \"{example}\"")
        } else {
            String::new()
        };
        let message = format!(
            "cannot open {name}: no such file or device, and no link or robot of that name ({configured}). `groundwave ports` lists \
             the devices{to_configure}"
        );
        Err(Fault::new(Exit::NoLink, message))
    }
}

impl Connection {
    /// Resolves the connection's link; returns the connection and its configuration.
    pub(in super::super) fn at(
        self,
        config: &Config,
        options: &LinkArgs,
    ) -> Result<(Self, Config), Fault> {
        match self {
            Self::Link(link) => {
                let (link, config) = config.at(&link, options)?;
                Ok((Self::Link(link), config))
            }
            Self::Via(_) => Ok((self, config.clone())),
        }
    }
}

/// The text of a link that may be a name; `None` for a path.
fn named(link: &LinkSpec) -> Option<&str> {
    match link {
        LinkSpec::Serial(path) => path.to_str().filter(|name| !name.contains('/')),
        _ => None,
    }
}

fn parse(link: Option<&str>) -> Result<LinkSpec, String> {
    link.unwrap_or_default().parse()
}

fn merged(profile: &Link, all: &Link) -> Link {
    Link {
        port: profile.port.clone(),
        radio: profile.radio.or(all.radio),
        latency_ms: profile.latency_ms.or(all.latency_ms),
        baud: profile.baud.or(all.baud),
        share: profile.share.clone().or_else(|| all.share.clone()),
    }
}

fn dashboard(robot: &Robot, all: &Dashboard) -> Dashboard {
    Dashboard {
        theme: robot.theme.or(all.theme),
        ascii: robot.ascii.or(all.ascii),
        map: robot.map.or(all.map),
        bell: robot.bell.or(all.bell),
        mouse: robot.mouse.or(all.mouse),
        clock: all.clock,
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse as read;
    use super::*;

    const TEXT: &str = "[link]\nbaud = 2400\nradio = \"half\"\n[link.shed]\nport = \"/dev/ttyUSB7\"\nbaud = 9600\n\
                        [robot.marvin]\nlink = \"shed\"\nbell = false\n[robot.arthur]\nlink = \"tcp:robot:4000\"\n\
                        [robot.marvin.limits]\nsilent_s = 9\n[dashboard]\nmouse = false\n[limits]\nloss_pct = 50\n";

    fn at(name: &str) -> (LinkSpec, Config) {
        let config = read(TEXT).expect("it is right");
        let link = name.parse().expect("a link");
        config.at(&link, &LinkArgs::default()).expect("it is found")
    }

    #[test]
    fn robot_settings_outrank_link_settings_and_those_the_defaults() {
        let (link, config) = at("marvin");
        assert_eq!(link, LinkSpec::Serial("/dev/ttyUSB7".into()));
        assert_eq!(config.link.baud, Some(9600));
        assert!(config.link.radio.is_some());
        assert_eq!(config.dashboard.bell, Some(false));
        assert_eq!(config.dashboard.mouse, Some(false));
        assert_eq!((config.limits.silent_s, config.limits.loss_pct), (9, 50));
        assert_eq!(at("shed").0, link);
        assert_eq!(at("arthur").1.limits, at("shed").1.limits);
        assert_eq!(at("arthur").0, LinkSpec::Tcp("robot:4000".to_owned()));
        assert_eq!(at("arthur").1.link.baud, Some(2400));
    }

    #[test]
    fn names_that_are_not_configured_stay_links() {
        for name in ["/dev/ttyUSB0", "sim", "tcp:x:1", "./shed"] {
            assert_eq!(at(name).0, name.parse::<LinkSpec>().expect("a link"));
        }
        let config = read(TEXT).expect("it is right");
        let error = config
            .at(&LinkSpec::Serial("shde".into()), &LinkArgs::default())
            .expect_err("none is called so");
        assert!(
            error.to_string().contains("did you mean `shed`?"),
            "{error}"
        );
        let device = LinkSpec::Serial("trillian".into());
        let error = config
            .at(&device, &LinkArgs::default())
            .expect_err("none is called so");
        let names = "configured: arthur, marvin, shed";
        assert!(error.to_string().contains(names), "{error}");
        let waits = LinkArgs {
            wait: Some(None),
            ..LinkArgs::default()
        };
        let (link, _) = config.at(&device, &waits).expect("it may come");
        assert_eq!(link, device);
    }
}
