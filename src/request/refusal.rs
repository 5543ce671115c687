//! Reasons for a refusal, from the robot's last reported mode and layers, with a hint.

use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{Body, Outcome};

use super::{Request, Tuning, layer_word, mode_word};

/// The mode and layers that a robot last reported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    /// Mode, from line A.
    mode: Option<Mode>,
    /// Layers that the operator allows, from line B.
    allowed: Option<LayerMask>,
}

impl Standing {
    /// A state with a known mode and known layers.
    #[must_use]
    pub const fn new(mode: Option<Mode>, allowed: Option<LayerMask>) -> Self {
        Self { mode, allowed }
    }

    /// Takes the body of a line.
    pub const fn take(&mut self, body: &Body) {
        match body {
            Body::State(state) => self.mode = Some(state.mode),
            Body::Status(status) => self.allowed = Some(status.allowed),
            _ => {}
        }
    }

    /// Whether further lines may explain the refusal.
    #[must_use]
    pub const fn wants_more(&self, request: &Request, outcome: Outcome) -> bool {
        matches!((request, outcome), (Request::Scan, Outcome::NotNow))
            && (self.mode.is_none() || self.allowed.is_none())
    }

    /// The reason for a refusal with a hint; `None` if the outcome alone explains it.
    #[must_use]
    pub fn why(&self, request: &Request, outcome: Outcome) -> Option<String> {
        match (request, outcome) {
            (Request::Scan, Outcome::NotNow) => {}
            (Request::Parameter(Tuning::Get(name) | Tuning::Set(name, _)), Outcome::Unknown) => {
                return Some(format!(
                    "it has no parameter `{}`; `param list` shows its parameters",
                    name.as_str()
                ));
            }
            (Request::Mode(Mode::Forage), Outcome::NotFitted) => {
                return Some("it has no dock sensor: try `home`, or demo --world flat".to_owned());
            }
            (Request::Mode(Mode::Passive), Outcome::NotFitted) => {
                return Some(
                    "mode passive needs a motion detector, which it does not have; try `reactive`"
                        .to_owned(),
                );
            }
            _ => return None,
        }
        let rotation = layer_word(Layer::Rotation);
        if self
            .allowed
            .is_some_and(|allowed| !allowed.contains(Layer::Rotation))
        {
            return Some(format!(
                "layer {rotation} is forbidden; `enable {rotation}` first"
            ));
        }
        Some(match self.mode {
            Some(mode @ (Mode::Stop | Mode::User | Mode::Passive | Mode::Calibrate)) => format!(
                "in mode {} it does not turn by itself; `mode prowl` first",
                mode_word(mode)
            ),
            _ => format!("`enable {rotation}` and `mode prowl` first"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn standing(mode: Option<Mode>, allowed: Option<LayerMask>) -> String {
        let why = Standing::new(mode, allowed).why(&Request::Scan, Outcome::NotNow);
        why.expect("a scan that is refused has a reason")
    }

    #[test]
    fn refused_scan_has_a_hint() {
        let without = LayerMask::ALL.without(Layer::Rotation);
        let forbidden = standing(Some(Mode::Prowl), Some(without));
        assert!(forbidden.contains("`enable rotation` first"), "{forbidden}");
        let stopped = standing(Some(Mode::Stop), Some(LayerMask::ALL));
        assert!(stopped.starts_with("in mode stop"), "{stopped}");
        let unknown = standing(None, None);
        assert!(unknown.contains("`mode prowl`"), "{unknown}");
    }

    #[test]
    fn mode_without_its_sensor_has_an_alternative() {
        let why = |mode| Standing::default().why(&Request::Mode(mode), Outcome::NotFitted);
        let dock = why(Mode::Forage).expect("there is a reason");
        assert!(
            dock.contains("`home`") && dock.contains("--world flat"),
            "{dock}"
        );
        let hide = why(Mode::Passive).expect("there is a reason");
        assert!(
            hide.contains("motion detector") && hide.contains("`reactive`"),
            "{hide}"
        );
    }

    #[test]
    fn unknown_parameter_points_to_the_list() {
        let words = ["param", "set", "warp-speed", "9"];
        let request = Request::from_words(&words).expect("a name");
        let why = Standing::default().why(&request, Outcome::Unknown);
        let why = why.expect("there is a reason");
        assert!(
            why.contains("`warp-speed`") && why.contains("`param list`"),
            "{why}"
        );
    }

    #[test]
    fn other_refusals_have_no_hint() {
        let standing = Standing::default();
        assert_eq!(standing.why(&Request::Scan, Outcome::NotFitted), None);
        let mode = Request::Mode(Mode::Prowl);
        assert_eq!(standing.why(&mode, Outcome::NotNow), None);
        assert!(!standing.wants_more(&mode, Outcome::NotNow));
        assert!(standing.wants_more(&Request::Scan, Outcome::NotNow));
    }
}
