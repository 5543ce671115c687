//! The faults that can end a command.

use std::fmt::Display;
use std::time::Duration;

use super::super::{Exit, Fault};
use crate::event::Failure;
use crate::request::Request;
use crate::share::Heard;
use groundwave_captures::words::counted;

/// Fault for the link `name`, which has no transmitter.
pub(in super::super) fn receive_only(name: &dyn Display) -> Fault {
    let message = format!(
        "cannot send to {name}: the link is receive-only; name a link that can send, or a station that shares one: \
         --via ADDR"
    );
    Fault::new(Exit::ReceiveOnly, message)
}

/// Fault for a command that the robot refused, for the reason `why`.
pub(in super::super) fn refused(request: &Request, why: &str) -> Fault {
    let message = format!("the robot refused `{request}`: {why}");
    Fault::new(Exit::Refused, message)
}

/// Fault for a command that failed without a confirmation.
pub(in super::super) fn failed(request: &Request, failure: Failure) -> Fault {
    let exit = match failure {
        Failure::ReceiveOnly => Exit::ReceiveOnly,
        Failure::TimedOut | Failure::NotSent => Exit::NotConfirmed,
        Failure::BeyondLevel(_) | Failure::BeyondCapacity(_) => Exit::Refused,
        _ => Exit::Failed,
    };
    Fault::new(exit, format!("`{request}`: {failure}"))
}

/// Fault for a missing confirmation, with the reason why the link was `lost` or the counts of received bytes and lines, and the possible state of the robot.
pub(in super::super) fn not_confirmed(
    request: &Request,
    lost: Option<&str>,
    heard: Heard,
    waited: Duration,
    frames: u32,
) -> Fault {
    let why = if let Some(reason) = lost {
        format!("the station lost its link meanwhile: {reason}")
    } else if heard.bytes == 0 {
        "nothing was received from the robot; check that it is switched on and that the port is right"
            .to_owned()
    } else if heard.lines == 0 {
        format!(
            "{} received and no intact line; check the baud rate",
            counted(heard.bytes, "byte")
        )
    } else {
        "lines were received, but no confirmation; the robot may be out of range of our transmitter, or the link is only a copy of \
         what the station receives, such as the demo's (--via ADDR sends through the station that has the radio)"
            .to_owned()
    };
    let state = match request {
        // No frames are sent for a command that another client has already sent.
        _ if frames == 0 && *request != Request::Stop => " It was not sent.",
        Request::Route(_) => " The robot holds its old route or the new one, whole.",
        _ => " The robot may or may not have executed it.",
    };
    let waited = if waited < Duration::from_secs(1) {
        format!("{} ms", waited.as_millis())
    } else {
        format!("{:.1} s", waited.as_secs_f64())
    };
    Fault::new(
        Exit::NotConfirmed,
        format!("`{request}` was not confirmed within {waited}: {why}.{state}"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two clients that send STOP at once share one frame, and the second client has sent none.
    #[test]
    fn joined_stop_is_not_reported_as_unsent() {
        let text = |request, frames| {
            let waited = Duration::from_millis(10);
            not_confirmed(&request, None, Heard::default(), waited, frames).to_string()
        };
        assert!(text(Request::Stop, 0).ends_with("The robot may or may not have executed it."));
        assert!(text(Request::Scan, 0).ends_with("It was not sent."));
        assert!(text(Request::Scan, 1).ends_with("The robot may or may not have executed it."));
    }

    #[test]
    fn a_lost_link_is_the_reason_and_not_the_range() {
        let heard = Heard {
            bytes: 80,
            lines: 1,
        };
        let text = |lost| {
            not_confirmed(&Request::Stop, lost, heard, Duration::from_secs(2), 3).to_string()
        };
        assert!(text(None).contains("out of range"));
        let lost = text(Some("unplugged"));
        assert!(
            lost.contains("lost its link meanwhile: unplugged. The robot may"),
            "{lost}"
        );
    }
}
