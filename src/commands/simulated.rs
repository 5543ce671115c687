//! A simulated robot inside this process.

use std::io::ErrorKind;

use groundwave_protocol::BYTES_PER_S;
use sr04_sim::serve::{Endpoint, ServeError, ServeOptions, Server, serve};
use sr04_sim::{
    ChannelSpec, Duplex, HC_12_PATIENCE_BYTES, Modem, Outline, OutlineKind, PATIENCE_BYTES,
    SimulationConfig, World, WorldError,
};

use super::cli::Simulated;
use super::{Exit, Fault};
use crate::capture::Session;
use crate::event::Truth;
use crate::hint;
use crate::io::link::LinkSpec;
use crate::radio::RadioKind;
use crate::suggest::question;

/// The default world.
const DEFAULT_WORLD: &str = "house";

/// Id of the simulated robot.
pub(super) const ROBOT_ID: u8 = 4;

/// Time for which a robot behind `XBee` modules waits for an answer, in byte times.
const XBEE_PATIENCE_BYTES: u8 = 60;

/// The simulation that the options describe.
pub(super) fn config(options: &Simulated) -> Result<SimulationConfig, Fault> {
    let world = World::open(&options.world).map_err(|error| bad_world(&error))?;
    let mut config = SimulationConfig::new(world, options.seed);
    config.robot_id = ROBOT_ID;
    config.conditions.charge = f64::from(options.battery) / 100.0;
    config.channel = options
        .channel
        .parse::<ChannelSpec>()
        .map_err(|error| Fault::new(Exit::Usage, error))?;
    fit_radio(&mut config, options.radio);
    Ok(config)
}

/// Sets channel and robot to the kind of radio; on a half-duplex channel the robot takes turns.
fn fit_radio(config: &mut SimulationConfig, kind: RadioKind) {
    match kind {
        RadioKind::Auto | RadioKind::Full | RadioKind::ReceiveOnly => {}
        RadioKind::Half => config.channel.half_duplex = true,
        RadioKind::Hc12 => config.channel.modem = Some(Modem::Hc12),
        RadioKind::Xbee => config.channel.modem = Some(Modem::Xbee),
    }
    let patience_bytes = match config.channel.modem {
        Some(Modem::Hc12) => HC_12_PATIENCE_BYTES,
        Some(Modem::Xbee) => XBEE_PATIENCE_BYTES,
        None if config.channel.half_duplex => PATIENCE_BYTES,
        None => return,
    };
    config.duplex = Duplex::Half { patience_bytes };
}

/// The fault for a world that cannot be used; a mistyped name gets a suggestion.
pub(super) fn bad_world(error: &WorldError) -> Fault {
    let near = match error {
        WorldError::Read { path, source } if source.kind() == ErrorKind::NotFound => {
            question(&path.to_string_lossy(), world_names())
        }
        _ => String::new(),
    };
    Fault::new(Exit::Usage, format!("{error}{near}"))
}

/// Names of the built-in worlds.
pub(super) fn world_names() -> impl Iterator<Item = &'static str> {
    World::built_in_names()
}

/// Starts a simulated robot.
pub(super) fn start(config: SimulationConfig, options: &ServeOptions) -> Result<Server, Fault> {
    serve(config, options).map_err(|error| fault_of(&error))
}

/// The fault of a simulated robot.
pub(super) fn fault_of(error: &ServeError) -> Fault {
    let exit = match error {
        ServeError::TimeFactor(_)
        | ServeError::Link { .. }
        | ServeError::Eeprom { .. }
        | ServeError::Recording { .. } => Exit::Usage,
        ServeError::Listen { source, .. } => match source.kind() {
            ErrorKind::AddrInUse | ErrorKind::PermissionDenied => Exit::Failed,
            _ => Exit::Usage,
        },
        ServeError::Pty(_) | ServeError::Thread(_) | ServeError::Incomplete { .. } => Exit::Failed,
    };
    match error {
        ServeError::Recording { source, .. } | ServeError::Incomplete { source, .. } => {
            Fault::new(exit, format!("{error}: {}", hint::of_writing(source)))
        }
        _ => Fault::new(exit, error),
    }
}

/// A pseudo-terminal on Unix, a TCP port elsewhere.
pub(super) fn endpoint(copy_only: bool) -> Endpoint {
    if cfg!(unix) {
        Endpoint::Pty {
            link: None,
            copy_only,
        }
    } else {
        Endpoint::Tcp {
            address: "127.0.0.1:0".to_owned(),
            copy_only,
        }
    }
}

/// The link to an endpoint's address.
pub(super) fn link_to(address: &str) -> LinkSpec {
    if cfg!(unix) {
        LinkSpec::Serial(address.into())
    } else {
        LinkSpec::Tcp(address.to_owned())
    }
}

/// The simulated robot behind a link `sim`; dropping it ends the simulation.
pub(super) type Embedded = Option<Server>;

/// Replaces the link `sim` by a link to a new simulated robot. The robot runs until the returned
/// server is dropped.
pub(super) fn embed(link: &LinkSpec, radio: RadioKind) -> Result<(LinkSpec, Embedded), Fault> {
    if *link != LinkSpec::Sim {
        return Ok((link.clone(), None));
    }
    let config = config(&Simulated {
        world: DEFAULT_WORLD.to_owned(),
        seed: 1,
        channel: String::new(),
        radio,
        battery: 100,
        time_factor: 1.0,
    })?;
    let options = ServeOptions {
        endpoints: vec![endpoint(false)],
        ..ServeOptions::default()
    };
    let server = start(config, &options)?;
    let address = server.addresses().first().map_or("", String::as_str);
    Ok((link_to(address), Some(server)))
}

/// The world's walls and furniture for the map.
#[must_use]
pub fn truth(outlines: &[Outline]) -> Truth {
    let mut truth = Truth::default();
    for outline in outlines {
        match *outline {
            Outline::Segment { from, to, kind } => {
                let lines = match kind {
                    OutlineKind::Wall | OutlineKind::Edge => &mut truth.walls,
                    OutlineKind::Furniture | OutlineKind::Low => &mut truth.furniture,
                };
                lines.push([(from.x_in, from.y_in), (to.x_in, to.y_in)]);
            }
            Outline::Block { from, to } => {
                truth
                    .blocks
                    .push([(from.x_in, from.y_in), (to.x_in, to.y_in)]);
            }
            Outline::Circle {
                center, radius_in, ..
            } => {
                truth.circles.push(((center.x_in, center.y_in), radius_in));
            }
        }
    }
    truth
}

/// The world's walls and furniture as metadata for a recording, for the map in a replay.
pub(super) fn truth_note(server: &Server) -> Option<(String, String)> {
    let truth = serde_json::to_string(&truth(server.outlines())).ok()?;
    Some((Session::TRUTH.to_owned(), truth))
}

/// Baud rate and bytes per second, as text.
pub(super) fn rate_words(time_factor: f64) -> String {
    let bytes_s = f64::from(BYTES_PER_S) * time_factor;
    format!("2400 baud 8N1, {bytes_s:.0} bytes/s")
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use groundwave_protocol::decoder::{Decoder, Received};
    use groundwave_protocol::status_codes::Power;
    use groundwave_protocol::telemetry::Body;
    use sr04_sim::Simulation;

    use super::*;
    use crate::commands::cli::{Cli, Verb};

    fn options(line: &[&str]) -> Simulated {
        match Cli::try_parse_from(line).expect("it reads").verb {
            Some(Verb::Demo(demo)) => demo.simulated,
            _ => panic!("demo"),
        }
    }

    #[test]
    fn low_battery_is_reported_within_a_minute() {
        for (line, power) in [
            (&["groundwave", "demo", "--battery", "14"][..], Power::Low),
            (&["groundwave", "demo"][..], Power::Ok),
        ] {
            let config = config(&options(line)).expect("it can be simulated");
            let mut simulation = Simulation::new(&config);
            let (mut decoder, mut reported) = (Decoder::default(), Power::Ok);
            simulation.run_for_ms(60_000);
            while let Some(byte) = simulation.poll_downlink() {
                if let Some(Received::Line(line, _)) = decoder.lines(&[byte]).next()
                    && let Body::State(state) = line.body
                {
                    reported = state.power;
                }
            }
            assert_eq!(reported, power);
        }
        let too_full = ["groundwave", "demo", "--battery", "101"];
        assert!(Cli::try_parse_from(too_full).is_err());
    }
}
