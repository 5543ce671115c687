//! Special floor: sills, carpets and inclines.

use serde::Deserialize;

use crate::geometry::{Solid, Vec2, heading};

/// Kinds of special floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum GroundKind {
    /// A door sill, which holds back each wheel on it.
    Sill,
    /// A carpet: wheels turn hard and lose distance.
    Carpet,
    /// An incline.
    Ramp,
}

/// A rectangle of special floor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground {
    pub(crate) kind: GroundKind,
    pub(crate) solid: Solid,
    /// Uphill direction with the rise per distance as its length; zero on level floor.
    pub(crate) slope: Vec2,
}

/// Maximum incline that the wheels can hold.
const GRADE_MAX_PERCENT: f64 = 20.0;

impl Ground {
    /// A rectangle turned clockwise by `turned_deg`; a ramp rises in that direction.
    pub(super) fn new(
        kind: GroundKind,
        center: Vec2,
        size: Vec2,
        turned_deg: f64,
        grade_percent: Option<f64>,
    ) -> Result<Self, String> {
        if !(size.min_element() >= 1.0 && size.max_element() <= 1000.0) {
            return Err("each number of size_in must be between 1 and 1000 inches".to_owned());
        }
        let grade = match (kind, grade_percent) {
            (GroundKind::Ramp, Some(grade)) if (0.0..=GRADE_MAX_PERCENT).contains(&grade) => grade,
            (GroundKind::Ramp, _) => {
                return Err(format!(
                    "a ramp needs grade_percent from 0 to {GRADE_MAX_PERCENT}: its rise in the direction of turned_deg"
                ));
            }
            (_, None) => 0.0,
            (_, Some(_)) => return Err("only a ramp has grade_percent: remove it".to_owned()),
        };
        Ok(Self {
            kind,
            solid: Solid::block(center, size, turned_deg),
            slope: heading(turned_deg.to_radians()) * (grade / 100.0),
        })
    }

    pub(crate) fn has(&self, point: Vec2) -> bool {
        self.solid.approach(point).0 <= 0.0
    }
}
