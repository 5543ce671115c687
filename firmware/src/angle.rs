//! Binary angles: a full turn is 65,536, so angles wrap like integers.

/// A heading or a difference of headings, clockwise from +Y, in 1/65,536 of a turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Angle(pub u16);

/// Sines of a quarter turn in 64 steps; 32,767 is one.
const QUARTER: [i16; 65] = [
    0, 804, 1608, 2410, 3212, 4011, 4808, 5602, 6393, 7179, 7962, 8739, 9512, 10278, 11039, 11793,
    12539, 13279, 14010, 14732, 15446, 16151, 16846, 17530, 18204, 18868, 19519, 20159, 20787,
    21403, 22005, 22594, 23170, 23731, 24279, 24811, 25329, 25832, 26319, 26790, 27245, 27683,
    28105, 28510, 28898, 29268, 29621, 29956, 30273, 30571, 30852, 31113, 31356, 31580, 31785,
    31971, 32137, 32285, 32412, 32521, 32609, 32678, 32728, 32757, 32767,
];

impl Angle {
    /// The angle of whole degrees.
    #[must_use]
    pub const fn from_degrees(degrees: u16) -> Self {
        Self(((degrees as u32 % 360 * 65_536 + 180) / 360) as u16)
    }

    /// Whole degrees, 0 to 359, rounded.
    #[must_use]
    pub const fn degrees(self) -> u16 {
        ((self.0 as u32 * 360 + 32_768) / 65_536 % 360) as u16
    }

    /// Sine; 32,767 is one.
    #[must_use]
    pub fn sin(self) -> i16 {
        let quadrant = self.0 >> 14;
        let within = self.0 & 0x3FFF;
        let from_axis = if quadrant & 1 == 0 {
            within
        } else {
            0x4000 - within
        };
        let step = usize::from(from_axis >> 8);
        let low = i32::from(QUARTER.get(step).copied().unwrap_or(i16::MAX));
        let high = i32::from(QUARTER.get(step + 1).copied().unwrap_or(i16::MAX));
        let sine = (low + ((high - low) * i32::from(from_axis & 0xFF) + 128) / 256) as i16;
        if quadrant < 2 { sine } else { -sine }
    }

    /// Cosine; 32,767 is one.
    #[must_use]
    pub fn cos(self) -> i16 {
        Self(self.0.wrapping_add(0x4000)).sin()
    }

    /// Signed turn from `other` to `self` by the shorter direction, positive to the right; half a turn is 32,768.
    #[must_use]
    pub const fn minus(self, other: Self) -> i16 {
        self.0.wrapping_sub(other.0) as i16
    }

    /// Heading from the origin to a point, accurate to a quarter of a degree.
    #[must_use]
    pub fn toward(x: i32, y: i32) -> Self {
        let (across, along) = (x.unsigned_abs(), y.unsigned_abs());
        let (small, large) = (across.min(along), across.max(along));
        if large == 0 {
            return Self(0);
        }
        // At most 15 bits each, so that the products below fit 32 bits.
        let shift = 17_u32.saturating_sub(large.leading_zeros());
        let ratio = (((small >> shift) << 15) / (large >> shift)) as i32;
        // atan(r) = r * (pi/4 + 0.273 * (1 - r)) radians: 8192 and 2847 in binary angle.
        let octant = (ratio * (8192 + ((2847 * (32_768 - ratio)) >> 15))) >> 15;
        let from_y = if across <= along {
            octant
        } else {
            0x4000 - octant
        };
        let from_y = if y < 0 { 0x8000 - from_y } else { from_y };
        Self(if x < 0 { -from_y } else { from_y } as u16)
    }
}

/// Integer square root, rounded down.
#[must_use]
pub fn square_root(value: u32) -> u32 {
    let (mut rest, mut root, mut bit) = (value, 0, 1 << 30);
    while bit != 0 {
        if rest >= root + bit {
            rest -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
        bit >>= 2;
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_accurate_to_four_digits() {
        for angle in 0..=u16::MAX {
            let turn = f64::from(angle) / 65_536.0 * core::f64::consts::TAU;
            let (sin, cos) = (f64::from(Angle(angle).sin()), f64::from(Angle(angle).cos()));
            assert!((sin / 32_767.0 - turn.sin()).abs() < 1.2e-4, "{angle}");
            assert!((cos / 32_767.0 - turn.cos()).abs() < 1.2e-4, "{angle}");
        }
    }

    #[test]
    fn heading_to_a_point_is_accurate_to_a_quarter_degree() {
        for (x, y) in [(0, 1), (1, 0), (0, -1), (-1, 0), (i32::MAX, i32::MIN + 1)] {
            check(x, y);
        }
        for i in -60..60 {
            for j in -60..60 {
                if (i, j) != (0, 0) {
                    check(i * 1009, j * 997);
                    check(i * 20_000_003, j * 29_999_999);
                }
            }
        }
        assert_eq!(Angle::toward(0, 0), Angle(0));
    }

    fn check(x: i32, y: i32) {
        let exact = f64::from(x).atan2(f64::from(y)).to_degrees();
        let ours = f64::from(Angle::toward(x, y).0) * 360.0 / 65_536.0;
        let error = (ours - exact + 540.0).rem_euclid(360.0) - 180.0;
        assert!(error.abs() < 0.25, "({x}, {y}): {ours} for {exact}");
    }

    #[test]
    fn degrees_survive_the_round_trip() {
        for degrees in 0..360 {
            assert_eq!(Angle::from_degrees(degrees).degrees(), degrees);
        }
        assert_eq!(Angle(65_535).degrees(), 0);
        assert_eq!(Angle::from_degrees(720), Angle(0));
    }

    #[test]
    fn difference_takes_the_shorter_direction() {
        let (a, b) = (Angle::from_degrees(10), Angle::from_degrees(350));
        assert_eq!(a.minus(b), 3640);
        assert_eq!(b.minus(a), -3640);
    }

    #[test]
    fn square_roots_are_floors() {
        for root in 0..2000_u32 {
            assert_eq!(square_root(root * root), root);
            assert_eq!(square_root(root * root + root), root);
        }
        assert_eq!(square_root(u32::MAX), 65_535);
    }
}
