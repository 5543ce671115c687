//! What is meant by a link's name: a profile of the configuration, an adapter by what it says of itself, or the link as
//! it stands.

use super::super::cli::Way;
use std::path::Path;

use super::{Config, Dashboard, Exit, Fault, Link, Robot};
use crate::io::link::LinkSpec;
use crate::io::ports;
use crate::suggest;

impl Config {
    /// The link that is meant, and what is configured for it: a robot's own word comes before its link's, and that before
    /// what holds for all.
    pub(in super::super) fn at(&self, link: &LinkSpec) -> Result<(LinkSpec, Self), Fault> {
        let usage = |message: String| Fault::new(Exit::Usage, message);
        let mut config = self.clone();
        let mut link = link.clone();
        if let Some(robot) = named(&link).and_then(|name| self.robots.get(name)) {
            config.dashboard = dashboard(robot, &self.dashboard);
            config.limits = robot.limits.clone();
            link = parse(robot.link.as_deref()).map_err(usage)?;
        }
        if let Some(profile) = named(&link).and_then(|name| self.links.get(name)) {
            config.link = merged(profile, &self.link);
            link = parse(profile.port.as_deref()).map_err(usage)?;
        }
        if let Some(name) = named(&link) {
            if let Some(adapter) = name.strip_prefix("usb:") {
                let port =
                    ports::find_usb(adapter).map_err(|error| Fault::new(Exit::NoLink, error))?;
                return Ok((LinkSpec::Serial(port.into()), config));
            }
            self.is_port(name)?;
        }
        Ok((link, config))
    }

    /// A word without a path that is nothing here is a name that nobody gave.
    fn is_port(&self, name: &str) -> Result<(), Fault> {
        let may_be = Path::new(name).exists() || !cfg!(unix) && ports::is_there(name);
        if may_be {
            return Ok(());
        }
        let names: Vec<&str> = self
            .robots
            .keys()
            .chain(self.links.keys())
            .map(String::as_str)
            .collect();
        if let Some(near) = suggest::nearest(name, names.iter().copied()) {
            let message = format!(
                "no link and no robot is called `{name}` in the configuration; did you mean `{near}`?"
            );
            return Err(Fault::new(Exit::Usage, message));
        }
        let there_are = match names[..] {
            [] => "the configuration names none yet".to_owned(),
            _ => format!("the configuration has {}", names.join(", ")),
        };
        let message = format!(
            "cannot open {name}: there is no such device here, and no link or robot of that name ({there_are}). `groundwave \
             ports` lists the devices, `groundwave config` shows how a name is given: [robot.{name}], link = \"/dev/ttyUSB0\""
        );
        Err(Fault::new(Exit::NoLink, message))
    }
}

impl Way {
    /// The way that is meant, and what is configured for it.
    pub(in super::super) fn at(self, config: &Config) -> Result<(Self, Config), Fault> {
        match self {
            Self::Link(link) => {
                let (link, config) = config.at(&link)?;
                Ok((Self::Link(link), config))
            }
            Self::Via(_) => Ok((self, config.clone())),
        }
    }
}

/// What may be a name: a path is none.
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
        bell: robot.bell.or(all.bell),
        mouse: robot.mouse.or(all.mouse),
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
        config.at(&link).expect("it is found")
    }

    #[test]
    fn a_robot_has_its_links_word_and_that_the_word_for_all() {
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
    fn what_is_no_profile_stays_what_it_is() {
        for name in ["/dev/ttyUSB0", "sim", "tcp:x:1", "./shed"] {
            assert_eq!(at(name).0, name.parse::<LinkSpec>().expect("a link"));
        }
        let config = read(TEXT).expect("it is right");
        let error = config
            .at(&LinkSpec::Serial("shde".into()))
            .expect_err("none is called so");
        assert!(
            error.to_string().contains("did you mean `shed`?"),
            "{error}"
        );
        let error = config
            .at(&LinkSpec::Serial("trillian".into()))
            .expect_err("none is called so");
        let told = "the configuration has arthur, marvin, shed";
        assert!(error.to_string().contains(told), "{error}");
    }
}
