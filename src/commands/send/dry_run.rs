//! `send --dry-run`: prints the bytes and the minimum time of each command, and sends nothing.

use groundwave_protocol::command::Frame;
use serde_json::{Value, json};

use super::super::cli::Send;
use super::super::{Fault, show, show_line};
use super::script::Script;
use super::step::{Line, Step};
use crate::request::Request;
use crate::station::plan::{BOOT, OWNER, Plan, Planner, ROBOT_ID};

/// Measured time of a command in full duplex without bit errors, from docs/measurements.md.
#[derive(Clone, Copy)]
struct Typical {
    /// The measured case.
    of: &'static str,
    mean_s: f64,
    /// 95th percentile, seconds.
    p95_s: f64,
}

const fn typical(of: &'static str, mean_s: f64, p95_s: f64) -> Typical {
    Typical { of, mean_s, p95_s }
}

const STOP: Typical = typical("STOP", 0.35, 0.62);
const COMMAND: Typical = typical("one command, session open", 0.25, 0.40);
const COLD_COMMAND: Typical = typical("one command, nothing heard before", 1.08, 1.25);

/// Measured routes by number of waypoints; a shorter route takes no longer.
const LISTS: [(usize, Typical); 3] = [
    (10, typical("10 waypoints, session open", 0.7, 0.7)),
    (100, typical("100 waypoints, session open", 2.7, 2.7)),
    (300, typical("300 waypoints, session open", 7.3, 7.3)),
];
const COLD_LIST: (usize, Typical) = (
    100,
    typical("100 waypoints, nothing heard before", 3.43, 3.68),
);

pub(super) fn run(options: &Send, script: &Script, baud: u32) -> Result<(), Fault> {
    let mut planner = Planner::default();
    for (index, step) in script.steps().iter().enumerate() {
        let line = match step {
            Step::Send(line) => line,
            Step::Wait(wait, _) => {
                if options.json {
                    show_line(json!({ "status": "dry-run", "wait": wait.to_string() }))?;
                } else {
                    show_line(wait)?;
                }
                continue;
            }
        };
        let plan = planner.plan(&line.request);
        let typical = most_similar(&line.request, index == 0);
        if options.json {
            show_line(to_json(line, &plan, typical, baud))?;
        } else {
            show_text(line, &plan, typical, baud)?;
        }
    }
    if !options.json && !options.quiet {
        show(format!(
            "Nothing was sent. The four characters before each frame's last \\n are a checksum that depends on robot, \
             boot,\nsession and owner, and so do the frames `open` and STOP: here robot {ROBOT_ID}, boot {BOOT}, owner {OWNER}. \
             Least time: the bytes at\n{baud} baud and the shortest acknowledgement. Measured time: 2400 baud, full duplex \
             without bit errors\n(docs/measurements.md); a shorter route takes no longer.\n"
        ))?;
    }
    Ok(())
}

fn show_text(line: &Line, plan: &Plan, typical: Typical, baud: u32) -> Result<(), Fault> {
    let Typical { of, mean_s, p95_s } = typical;
    let number = line
        .number
        .map_or(String::new(), |number| format!("{number}: "));
    show_line(format_args!(
        "{number}{}: {} bytes, at least {:.2} s; measured: {mean_s} s on average, 95 % within {p95_s} s ({of})",
        line.request,
        plan.bytes(),
        plan.at_least_s(baud),
    ))?;
    let opening = plan.opening.iter().map(|frame| ("open", frame));
    let frames = plan.frames.iter().map(|frame| ("", frame));
    for (what, frame) in opening.chain(frames) {
        let bytes = frame.as_bytes();
        show_line(format_args!(
            "  {:>2} bytes  {}{}{what}",
            bytes.len(),
            String::from_utf8_lossy(bytes),
            if what.is_empty() { "" } else { "  " },
        ))?;
    }
    Ok(())
}

fn to_json(line: &Line, plan: &Plan, typical: Typical, baud: u32) -> Value {
    let Typical { of, mean_s, p95_s } = typical;
    let text = |frame: &Frame| String::from_utf8_lossy(frame.as_bytes()).into_owned();
    let mut value = json!({
        "status": "dry-run",
        "command": line.request.to_string(),
        "opening": plan.opening.as_ref().map(text),
        "frames": plan.frames.iter().map(text).collect::<Vec<_>>(),
        "bytes": plan.bytes(),
        "at_least_s": (plan.at_least_s(baud) * 1000.0).round() / 1000.0,
        "measured": { "of": of, "mean_s": mean_s, "p95_s": p95_s },
        "example_key": { "robot_id": ROBOT_ID, "boot": BOOT, "owner": OWNER },
    });
    if let Some(number) = line.number {
        value["line"] = json!(number);
    }
    value
}

/// The most similar measured case. Cold starts were measured for one command and for 100 waypoints only.
fn most_similar(request: &Request, is_cold: bool) -> Typical {
    let count = match request {
        Request::Stop => return STOP,
        Request::Route(waypoints) => waypoints.len(),
        _ => 0,
    };
    let longer = LISTS.iter().find(|(most, _)| count <= *most);
    match longer {
        _ if count == 0 && is_cold => COLD_COMMAND,
        _ if count == 0 => COMMAND,
        Some((most, _)) if is_cold && *most == COLD_LIST.0 => COLD_LIST.1,
        longer => longer.map_or(LISTS[LISTS.len() - 1].1, |(_, typical)| *typical),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEASURED: &str = include_str!("../../../docs/measurements.md");

    fn check_row(row: &str) {
        assert!(
            MEASURED.lines().any(|line| line.starts_with(row)),
            "docs/measurements.md has no row `{row}`: measured anew?"
        );
    }

    #[test]
    fn typical_times_are_those_in_the_docs() {
        for (count, Typical { mean_s, p95_s, .. }) in &LISTS {
            check_row(&format!("| full duplex | {count} | {mean_s} ({p95_s}) |"));
        }
        let (count, Typical { mean_s, p95_s, .. }) = COLD_LIST;
        check_row(&format!(
            "| full duplex, {count} waypoints | 0 | {mean_s:.2} | {p95_s:.2} |"
        ));
        let Typical { mean_s, p95_s, .. } = COLD_COMMAND;
        check_row(&format!(
            "| full duplex, one command | 0 | {mean_s:.2} | {p95_s:.2} |"
        ));
        let Typical { mean_s, p95_s, .. } = COMMAND;
        check_row(&format!("| full duplex | 0 | {mean_s:.2} | {p95_s:.2} |"));
        let Typical { mean_s, p95_s, .. } = STOP;
        check_row(&format!(
            "| full duplex, confirmed | 0 | {mean_s:.2} | {p95_s:.2} |"
        ));
    }
}
