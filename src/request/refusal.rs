//! Why a robot refuses, as far as it has said what it is set to, and what would help.

use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use groundwave_protocol::telemetry::{Body, Outcome};

use super::{Request, Tuning, layer_word, mode_word};

/// What a robot last said it is set to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    /// From line A.
    mode: Option<Mode>,
    /// Layers that the operator allows, from line B.
    allowed: Option<LayerMask>,
}

impl Standing {
    /// As far as it is known already.
    #[must_use]
    pub const fn new(mode: Option<Mode>, allowed: Option<LayerMask>) -> Self {
        Self { mode, allowed }
    }

    /// Takes what a line says.
    pub const fn take(&mut self, body: &Body) {
        match body {
            Body::State(state) => self.mode = Some(state.mode),
            Body::Status(status) => self.allowed = Some(status.allowed),
            _ => {}
        }
    }

    /// Whether the lines that have not come yet may say more of why.
    #[must_use]
    pub const fn wants_more(&self, request: &Request, outcome: Outcome) -> bool {
        matches!((request, outcome), (Request::Scan, Outcome::NotNow))
            && (self.mode.is_none() || self.allowed.is_none())
    }

    /// Why the robot refused, and what to do about it; `None` where the outcome alone says all there is.
    #[must_use]
    pub fn why(&self, request: &Request, outcome: Outcome) -> Option<String> {
        match (request, outcome) {
            (Request::Scan, Outcome::NotNow) => {}
            (Request::Parameter(Tuning::Get(name) | Tuning::Set(name, _)), Outcome::Unknown) => {
                return Some(format!(
                    "it has no parameter `{}`; `param list` shows those it has",
                    name.as_str()
                ));
            }
            (Request::Mode(Mode::Forage), Outcome::NotFitted) => {
                return Some("it has no sensor for a dock's beacon; try `home`".to_owned());
            }
            (Request::Mode(Mode::Passive), Outcome::NotFitted) => {
                return Some("it has no motion detector to wait with; try `reactive`".to_owned());
            }
            _ => return None,
        }
        let rotation = layer_word(Layer::Rotation);
        if self
            .allowed
            .is_some_and(|allowed| !allowed.contains(Layer::Rotation))
        {
            return Some(format!(
                "it looks around with layer {rotation}, which is not allowed: `enable {rotation}` first"
            ));
        }
        Some(match self.mode {
            Some(mode @ (Mode::Stop | Mode::User | Mode::Passive | Mode::Calibrate)) => format!(
                "in mode {} it does not turn by itself: enter another first, such as `mode prowl`",
                mode_word(mode)
            ),
            _ => format!(
                "it looks around only where it drives by itself and layer {rotation} is allowed: \
                 `enable {rotation}` and `mode prowl` first"
            ),
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
    fn a_scan_that_is_refused_comes_with_its_remedy() {
        let without = LayerMask::ALL.without(Layer::Rotation);
        let forbidden = standing(Some(Mode::Prowl), Some(without));
        assert!(forbidden.contains("`enable rotation` first"), "{forbidden}");
        let stopped = standing(Some(Mode::Stop), Some(LayerMask::ALL));
        assert!(stopped.starts_with("in mode stop"), "{stopped}");
        let unknown = standing(None, None);
        assert!(unknown.contains("`mode prowl`"), "{unknown}");
    }

    #[test]
    fn a_mode_without_its_sensor_is_refused_with_the_one_to_take_instead() {
        let why = |mode| Standing::default().why(&Request::Mode(mode), Outcome::NotFitted);
        let dock = why(Mode::Forage).expect("there is a reason");
        assert!(dock.contains("beacon") && dock.contains("`home`"), "{dock}");
        let hide = why(Mode::Passive).expect("there is a reason");
        assert!(
            hide.contains("motion detector") && hide.contains("`reactive`"),
            "{hide}"
        );
    }

    #[test]
    fn an_unknown_parameter_is_refused_with_where_to_look() {
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
    fn other_refusals_speak_for_themselves() {
        let standing = Standing::default();
        assert_eq!(standing.why(&Request::Scan, Outcome::NotFitted), None);
        let mode = Request::Mode(Mode::Prowl);
        assert_eq!(standing.why(&mode, Outcome::NotNow), None);
        assert!(!standing.wants_more(&mode, Outcome::NotNow));
        assert!(standing.wants_more(&Request::Scan, Outcome::NotNow));
    }
}
