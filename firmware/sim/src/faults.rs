//! Faults of the edge sensors, the bumper switches and the encoders.

use sr04_firmware::board::{Side, Switches};

use crate::rng::{Rng, Stream};
use crate::time::TICK_MS;

/// Number of edge sensors.
pub(crate) const EDGE_SENSORS: usize = 28;

/// Duration of a dropout.
const DROPOUT_S: (f64, f64) = (0.2, 2.0);

/// Rates of sensor errors. The default is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faults {
    /// Share of the ticks in which an edge sensor misses an edge.
    pub edge_misses: f64,
    /// Share of the ticks in which an edge sensor reports an edge where there is floor.
    pub edge_false: f64,
    /// Number of dropouts of each edge sensor per hour; after a dropout, the sensor sees no edge for up to 2 s.
    pub edge_dropouts_per_h: f64,
    /// Share of the ticks in which a closed bumper switch reads open.
    pub bumper_misses: f64,
    /// Share of the ticks in which an open bumper switch reads closed.
    pub bumper_false: f64,
    /// Share of the encoder edges that are lost.
    pub encoder_misses: f64,
    /// Mean number of additional encoder edges per edge.
    pub encoder_false: f64,
    /// An encoder without any edge from the start on.
    pub dead_encoder: Option<Side>,
}

impl Faults {
    /// A robot that has been in use for a long time.
    pub const WORN: Self = Self {
        edge_misses: 0.05,
        edge_false: 0.0001,
        edge_dropouts_per_h: 20.0,
        bumper_misses: 0.05,
        bumper_false: 0.000_02,
        encoder_misses: 0.002,
        encoder_false: 0.002,
        dead_encoder: None,
    };

    /// Sensors in very bad condition: edge sensors miss half of their ticks.
    pub const ROTTEN: Self = Self {
        edge_misses: 0.5,
        edge_false: 0.001,
        edge_dropouts_per_h: 60.0,
        bumper_misses: 0.3,
        bumper_false: 0.0002,
        encoder_misses: 0.01,
        encoder_false: 0.01,
        dead_encoder: None,
    };
}

/// Sensors that err.
pub(crate) struct Faulty {
    faults: Faults,
    rng: Rng,
    /// Ticks of dropout left for each edge sensor.
    blind_ticks: [u32; EDGE_SENSORS],
}

impl Faulty {
    pub(crate) fn new(faults: Faults, seed: u64) -> Self {
        Self {
            faults,
            rng: Rng::new(seed, Stream::Faults),
            blind_ticks: [0; EDGE_SENSORS],
        }
    }

    /// Whether an edge sensor can err.
    pub(crate) const fn has_edge_faults(&self) -> bool {
        self.faults.edge_false > 0.0
    }

    /// Whether an edge sensor reports an edge.
    pub(crate) fn edge(&mut self, spot: usize, is_over: bool) -> bool {
        let Faults {
            edge_misses,
            edge_false,
            edge_dropouts_per_h,
            ..
        } = self.faults;
        let per_tick = TICK_MS as f64 / 3_600_000.0;
        let blind = &mut self.blind_ticks[spot];
        if *blind > 0 {
            *blind -= 1;
            return false;
        }
        if self.rng.chance(edge_dropouts_per_h * per_tick) {
            let (least, most) = DROPOUT_S;
            let duration_s = least + (most - least) * self.rng.unit();
            *blind = (duration_s * 1000.0) as u32 / TICK_MS as u32;
        }
        if is_over {
            !self.rng.chance(edge_misses)
        } else {
            self.rng.chance(edge_false)
        }
    }

    /// The bumper switches as read.
    pub(crate) fn switches(&mut self, closed: Switches) -> Switches {
        let mut read = |is_closed| {
            if is_closed {
                !self.rng.chance(self.faults.bumper_misses)
            } else {
                self.rng.chance(self.faults.bumper_false)
            }
        };
        Switches {
            left: read(closed.left),
            center: read(closed.center),
            right: read(closed.right),
        }
    }

    /// The encoder edges as counted.
    pub(crate) fn edges(&mut self, side: Side, edges: u16) -> u16 {
        if self.faults.dead_encoder == Some(side) {
            return 0;
        }
        let mut counted = edges;
        for _ in 0..edges {
            counted -= u16::from(self.rng.chance(self.faults.encoder_misses));
            counted += u16::from(self.rng.chance(self.faults.encoder_false));
        }
        counted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_without_faults_never_err() {
        let mut faulty = Faulty::new(Faults::default(), 1);
        let closed = Switches {
            left: true,
            ..Switches::default()
        };
        for _ in 0..1000 {
            assert!(faulty.edge(0, true) && !faulty.edge(1, false));
            assert_eq!(faulty.switches(closed), closed);
            assert_eq!(faulty.edges(Side::Left, 9), 9);
        }
    }

    #[test]
    fn sensors_err_as_often_as_configured() {
        let mut faulty = Faulty::new(Faults::ROTTEN, 1);
        let seen = (0..10_000).filter(|_| faulty.edge(0, true)).count();
        assert!((4700..5100).contains(&seen), "{seen}");
        let edges: u32 = (0..1000)
            .map(|_| u32::from(faulty.edges(Side::Right, 10)))
            .sum();
        assert!((9950..10_050).contains(&edges), "{edges}");
        let mut dead = Faulty::new(
            Faults {
                dead_encoder: Some(Side::Left),
                ..Faults::default()
            },
            1,
        );
        assert_eq!(
            (dead.edges(Side::Left, 9), dead.edges(Side::Right, 9)),
            (0, 9)
        );
    }
}
