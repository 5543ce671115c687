//! Result of a scan, and the directions found in it.

use crate::angle::Angle;
use crate::sensors::Senses;

/// Number of directions of a scan: one per 7.5 degrees.
pub const SAMPLES: usize = 48;

/// Maximum sonar range considered, as in the sonar layer, inches.
const FAR_IN: u16 = 180;

/// Lag of sonar in samples: an echo arrives two ticks after its ping and is kept for two more, 9 degrees at 45 degrees/s.
const SONAR_LAG: usize = 1;

/// Minimum difference of brightness, in 1/256.
const LIGHT_LEAST: u8 = 8;

/// Readings in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sample {
    /// The shorter sonar range in inches, at most [`FAR_IN`].
    view_in: u8,
    /// Mean of both photocells, 0 very bright to 255 dark.
    dark: u8,
    infrared: bool,
}

/// A scan, clockwise from the robot's heading at its start.
#[derive(Clone, Debug)]
pub struct Panorama {
    begin: Angle,
    samples: [Sample; SAMPLES],
    taken: u8,
}

impl Default for Panorama {
    fn default() -> Self {
        Self {
            begin: Angle(0),
            samples: [Sample::default(); SAMPLES],
            taken: 0,
        }
    }
}

/// Directions by odometry; `None` if all directions are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    /// Direction of the longest sonar range.
    pub longest: Option<Angle>,
    /// Direction of the brightest light.
    pub brightest: Option<Angle>,
    /// Middle of the widest sector without an infrared detection.
    pub widest: Option<Angle>,
}

/// Index of a place less than two turns from the start. A remainder would take an 8-bit microcontroller 200 cycles.
const fn around(place: usize) -> usize {
    if place < SAMPLES {
        place
    } else {
        place - SAMPLES
    }
}

impl Panorama {
    /// Takes the readings `place` samples after the start. Infrared detections count until the next sample.
    pub fn take_sample(&mut self, senses: &Senses, place: i32) {
        let place = place.clamp(0, SAMPLES as i32 - 1) as u8;
        if self.taken == 0 {
            self.begin = senses.pose.heading;
        }
        while self.taken <= place {
            if let Some(sample) = self.samples.get_mut(usize::from(self.taken)) {
                let view = |range_in: Option<u16>| range_in.unwrap_or(FAR_IN).min(FAR_IN);
                let ranges = senses.sonar;
                sample.view_in = view(ranges.left_in).min(view(ranges.right_in)) as u8;
                if let Some((left, right)) = senses.photo {
                    sample.dark = u16::midpoint(u16::from(left), u16::from(right)) as u8;
                }
            }
            self.taken += 1;
        }
        if let Some(sample) = self.samples.get_mut(usize::from(place)) {
            sample.infrared |= senses.infrared.any();
        }
    }

    /// Heading of the robot at a sample.
    fn heading(&self, place: usize) -> Angle {
        let turned = around(place) as u32 * 0x1_0000 / SAMPLES as u32;
        Angle(self.begin.0.wrapping_add(turned as u16))
    }

    fn sample(&self, place: usize) -> Sample {
        self.samples.get(around(place)).copied().unwrap_or_default()
    }

    /// Free distance in a direction in inches: the mean of three samples, to smooth a stray echo.
    fn view_in(&self, place: usize) -> u16 {
        let at = |offset| u16::from(self.sample(place + SONAR_LAG + offset).view_in);
        (at(SAMPLES - 1) + at(0) + at(1)) / 3
    }

    fn brightness(&self, place: usize) -> u8 {
        u8::MAX - self.sample(place).dark
    }

    /// Samples to the nearest infrared detection on either side; 24 without any.
    fn clearance(&self, place: usize) -> u8 {
        let is_clear = |&distance: &usize| {
            !self.sample(place + distance).infrared
                && !self.sample(place + SAMPLES - distance).infrared
        };
        (0..SAMPLES / 2).take_while(is_clear).count() as u8
    }

    /// The directions found.
    #[must_use]
    pub fn findings(&self) -> Findings {
        let (darkest, brightest) = self.lights();
        Findings {
            longest: self.most(|place| self.view_in(place)),
            brightest: self
                .most(|place| u16::from(self.brightness(place)))
                .filter(|_| brightest - darkest >= LIGHT_LEAST),
            widest: self.most(|place| u16::from(self.clearance(place))),
        }
    }

    /// Direction in which people are most likely: far, bright and clear, equally weighted.
    #[must_use]
    pub fn humans(&self) -> Angle {
        const SHARE: u16 = 100;
        let (darkest, brightest) = self.lights();
        let span = u16::from(brightest - darkest);
        self.most(|place| {
            let light = if span >= u16::from(LIGHT_LEAST) {
                u16::from(self.brightness(place) - darkest) * SHARE / span
            } else {
                0
            };
            let view = self.view_in(place) * SHARE / FAR_IN;
            let clear = u16::from(self.clearance(place)) * SHARE / (SAMPLES as u16 / 2);
            view + light + clear
        })
        .unwrap_or(self.begin)
    }

    /// Minimum and maximum brightness.
    fn lights(&self) -> (u8, u8) {
        (0..SAMPLES).fold((u8::MAX, 0), |(least, most), place| {
            let now = self.brightness(place);
            (least.min(now), most.max(now))
        })
    }

    /// Direction of the maximum of a measure, in the middle of its first run of samples; `None` if the measure is constant.
    fn most(&self, measure: impl Fn(usize) -> u16) -> Option<Angle> {
        // Measuring once per sample keeps the call short on an 8-bit microcontroller.
        let measures: [u16; SAMPLES] = core::array::from_fn(measure);
        let best = measures.iter().copied().max()?;
        let is_best = |place| measures.get(around(place)) == Some(&best);
        // Start of a run of maxima.
        let first = (0..SAMPLES).find(|&place| is_best(place) && !is_best(place + SAMPLES - 1))?;
        let length = (0..SAMPLES)
            .take_while(|&offset| is_best(first + offset))
            .count();
        Some(self.heading(first + (length - 1) / 2))
    }
}

impl Findings {
    /// Text of the findings for a line T, with directions in degrees as in line A.
    #[must_use]
    pub fn text(&self) -> [u8; 61] {
        let mut text = *b"scan: longest view ---, brightest light ---, clearest --- deg";
        let places = [(19, self.longest), (40, self.brightest), (54, self.widest)];
        for (place, heading) in places {
            let (Some(heading), Some(columns)) = (heading, text.get_mut(place..place + 3)) else {
                continue;
            };
            let degrees = heading.degrees();
            for (column, unit) in columns.iter_mut().zip([100, 10, 1]) {
                *column = b'0' + (degrees / unit % 10) as u8;
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Sides;
    use crate::sensors::Ranges;

    /// A scan that starts at a heading with readings from `sense`.
    fn scan(begin_deg: u16, sense: impl Fn(usize) -> (u16, u8, bool)) -> Panorama {
        let mut panorama = Panorama::default();
        for place in 0..SAMPLES {
            let (view_in, dark, infrared) = sense(place);
            let mut odometer = crate::odometry::Odometer::default();
            odometer.set(
                groundwave_protocol::Waypoint { x_in: 0, y_in: 0 },
                Angle::from_degrees(begin_deg),
            );
            let senses = Senses {
                pose: odometer.pose(),
                sonar: Ranges {
                    left_in: Some(view_in),
                    right_in: Some(view_in),
                },
                photo: Some((dark, dark)),
                infrared: Sides {
                    left: infrared,
                    right: false,
                },
                ..Senses::idle()
            };
            panorama.take_sample(&senses, place as i32);
        }
        panorama
    }

    fn degrees(found: Option<Angle>) -> Option<u16> {
        found.map(Angle::degrees)
    }

    #[test]
    fn findings_are_the_longest_brightest_and_widest_directions() {
        // The sonar reads a direction one sample after the robot faced it.
        let panorama = scan(90, |place| {
            let view_in = if (11..=13).contains(&place) { 150 } else { 40 };
            let dark = if place == 24 { 50 } else { 90 };
            (view_in, dark, place < 24)
        });
        let findings = panorama.findings();
        assert_eq!(degrees(findings.longest), Some(172));
        assert_eq!(degrees(findings.brightest), Some(270));
        // Clear from 24 to 47, whose middle is 35.5.
        assert_eq!(degrees(findings.widest), Some(352));
        let text = findings.text();
        assert_eq!(
            core::str::from_utf8(&text).ok(),
            Some("scan: longest view 172, brightest light 270, clearest 352 deg")
        );
    }

    #[test]
    fn equal_directions_give_no_findings() {
        let panorama = scan(10, |place| {
            (200 + place as u16, 90 + place as u8 % 5, false)
        });
        let findings = panorama.findings();
        assert_eq!(findings, Findings::default());
        assert_eq!(panorama.humans(), Angle::from_degrees(10));
        let text = findings.text();
        assert_eq!(
            core::str::from_utf8(&text).ok(),
            Some("scan: longest view ---, brightest light ---, clearest --- deg")
        );
    }

    #[test]
    fn people_are_where_two_of_three_measures_agree() {
        let panorama = scan(0, |place| {
            let far = if (1..=3).contains(&place) || (29..=31).contains(&place) {
                180
            } else {
                60
            };
            (far, if place == 29 { 60 } else { 120 }, place < 10)
        });
        assert_eq!(panorama.humans().degrees(), 217);
    }

    #[test]
    fn skipped_samples_are_filled() {
        let mut panorama = Panorama::default();
        let senses = Senses {
            photo: Some((60, 60)),
            ..Senses::idle()
        };
        for place in [-1, 0, 3, 2, 47, 48] {
            panorama.take_sample(&senses, place);
        }
        assert!((0..SAMPLES).all(|place| panorama.sample(place).dark == 60));
    }
}
