//! `ports`: lists the serial ports of this machine.

use std::io::{self, Write};

use serde_json::json;

use super::cli::Ports;
use super::{Exit, Fault, out};
use crate::io::ports::{Port, list};

pub(super) fn run(options: &Ports) -> Result<(), Fault> {
    let ports = list().map_err(|error| Fault::new(Exit::Failed, error))?;
    if ports.is_empty() && !options.json {
        super::say("no serial ports found; connect a radio, or try `groundwave demo`");
    }
    let written = if options.json {
        write_json(&ports)
    } else {
        write_table(&ports)
    };
    written.or_else(|error| Fault::output(&error))
}

fn write_json(ports: &[Port]) -> io::Result<()> {
    let mut out = out();
    for port in ports {
        writeln!(
            out,
            "{}",
            json!({ "name": port.name, "kind": port.kind, "description": port.description })
        )?;
    }
    out.flush()
}

fn write_table(ports: &[Port]) -> io::Result<()> {
    let mut out = out();
    let width = ports.iter().map(|port| port.name.len()).max().unwrap_or(0);
    for port in ports {
        let description = port.description.as_deref().unwrap_or("");
        writeln!(
            out,
            "{}",
            format!("{:width$}  {:13}  {description}", port.name, port.kind).trim_end()
        )?;
    }
    out.flush()
}
