//! Commands for tests.

use std::iter;

use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::ParameterName;
use groundwave_protocol::{WAYPOINTS_MAX, Waypoint};

use super::{Amount, Request, Tuning};

/// A command of each kind, then other forms of some kinds.
pub(crate) fn samples() -> Vec<Request> {
    let far = Waypoint {
        x_in: -1023,
        y_in: 1023,
    };
    let layers = LayerMask::NONE.with(Layer::Sonar).with(Layer::User);
    let name = ParameterName::new;
    // Matched exhaustively, so that a new kind does not compile without a sample.
    let next = |request: &Request| {
        Some(match request {
            Request::Stop => Request::Mode(Mode::GoHome),
            Request::Mode(_) => Request::Enable(layers),
            Request::Enable(_) => Request::Disable(layers),
            Request::Disable(_) => Request::Only(layers),
            Request::Only(_) => Request::Route(vec![far]),
            Request::Route(_) => Request::Pose {
                position: far,
                theta_deg: 359,
            },
            Request::Pose { .. } => Request::Scan,
            Request::Scan => Request::Failsafe(Some(Failsafe {
                silence_s: 30,
                mode: Mode::GoHome,
            })),
            Request::Failsafe(_) => Request::Parameter(Tuning::List),
            Request::Parameter(Tuning::List) => Request::Parameter(Tuning::Get(name("track"))),
            Request::Parameter(Tuning::Get(_)) => {
                Request::Parameter(Tuning::Set(name("track"), Amount::Counts(-7)))
            }
            Request::Parameter(Tuning::Set(..)) => Request::Parameter(Tuning::Save),
            // Only the configuration knows command strings.
            Request::Parameter(Tuning::Save) | Request::Own(_) => return None,
        })
    };
    let each = iter::successors(Some(Request::Stop), next);
    let forms = [
        Request::Only(LayerMask::NONE),
        Request::Route(vec![]),
        Request::Route(vec![far; WAYPOINTS_MAX]),
        Request::Failsafe(None),
        // Similar to a known name, and a subcommand: the words must be unambiguous.
        Request::Parameter(Tuning::Get(name("trak"))),
        Request::Parameter(Tuning::Set(name("list"), Amount::Counts(-7))),
    ];
    each.chain(forms).collect()
}
