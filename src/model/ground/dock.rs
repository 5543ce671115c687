//! The way to the dock, suggested while the battery lasts for it.
//!
//! A robot that forages drives to its dock when its battery is low, by its own odometer, which may be off by rooms then. The ground
//! knows the way better.

use std::collections::VecDeque;

use groundwave_mapping::{Compass, CorrectedPose};
use groundwave_protocol::status_codes::{Mode, Power};

use super::{HOME_IN, Situation, Suggestion, is_on_route, rules};
use crate::event::{Figure, Moment, SuggestionCode};
use crate::request::Request;

/// Time between two looks: each plans a route.
const LOOK_EVERY: Moment = Moment::from_secs(30);

/// Distance from home within which the robot finds its dock by the beacon, inches.
const NEAR_IN: f64 = 60.0;

/// Mean speed on a route with its detours, in/s, and the time for docking.
const SPEED_IN_S: f64 = 3.0;
const DOCKING_MIN: f64 = 2.0;

/// The battery must last for this many drives, and some minutes: it falls faster when it is nearly empty, and a drive may be longer.
const DRIVES: f64 = 2.0;
const SPARE_MIN: f64 = 15.0;

/// Remaining time from which a robot that is near its dock may stay out, minutes.
const NEAR_MIN: f64 = 45.0;

/// Name of the parameter that makes the robot forage.
const FORAGE: &str = "forage";
const BATTERY_LOW: &str = "battery-low";

/// When the way to the dock is suggested.
#[derive(Clone, Debug, Default)]
pub(super) struct Dock {
    discharge: Discharge,
    /// Whether the robot has been on its dock.
    is_known: bool,
    /// Whether a way to the dock was accepted since then.
    was_accepted: bool,
    looked_at: Option<Moment>,
    suggestion: Option<Suggestion>,
}

impl Dock {
    /// Takes the robot's battery, and looks for a way from time to time.
    pub(super) fn watch(
        &mut self,
        it: &Situation<'_>,
        pose: Option<CorrectedPose>,
        compass: &Compass,
    ) {
        let Some(state) = it.robot.state else {
            return;
        };
        if matches!(state.value.power, Power::Docked | Power::Charging) {
            *self = Self {
                is_known: true,
                ..Self::default()
            };
            return;
        }
        if let Some(status) = it.robot.battery() {
            self.discharge
                .take(status.at, f64::from(status.value.battery_dv));
        }
        if self
            .looked_at
            .is_none_or(|at| it.now.saturating_sub(at) >= LOOK_EVERY)
        {
            self.looked_at = Some(it.now);
            self.suggestion = pose.and_then(|pose| self.look(it, &pose, compass));
        }
    }

    /// Takes the acceptance of the suggestion.
    pub(super) fn take_accepted(&mut self) {
        self.was_accepted = true;
        self.suggestion = None;
    }

    /// The suggestion of the latest look.
    pub(super) fn suggestion(&self) -> Option<&Suggestion> {
        self.suggestion.as_ref()
    }

    fn look(
        &self,
        it: &Situation<'_>,
        pose: &CorrectedPose,
        compass: &Compass,
    ) -> Option<Suggestion> {
        let state = it.robot.state?.value;
        let value = |name: &str| it.parameters.value(name);
        let forages = self.is_known || value(FORAGE) == Some(1);
        let can_dock = it
            .robot
            .abilities
            .is_none_or(|robot| robot.has_mode(Mode::Forage));
        if !forages || !can_dock || is_on_route(it) {
            return None;
        }
        let home_in = pose.x_in.hypot(pose.y_in);
        let is_near = home_in < NEAR_IN;
        match state.mode {
            Mode::Prowl | Mode::Stop | Mode::Wander | Mode::Reactive | Mode::GoHome => {}
            // It finds its dock by itself if its own pose is right, and goes on by itself where the ground's way has not led to the dock.
            Mode::Forage
                if !is_near && !self.was_accepted && rules::is_clearly_off(&state, pose) => {}
            _ => return None,
        }
        let lasts_min = match state.power {
            Power::Low | Power::Critical => 0.0,
            _ => self
                .discharge
                .lasts_min(f64::from(value(BATTERY_LOW).unwrap_or(it.battery_low_dv)))?,
        };
        let figure = |code: &str, minutes: f64| Figure {
            code: code.to_owned(),
            value: minutes,
            half: None,
            unit: "min".to_owned(),
        };
        let lasts = figure("battery-lasts", lasts_min);
        if is_near {
            let prowl = (state.mode != Mode::Prowl).then_some(Request::Mode(Mode::Prowl));
            return (lasts_min < NEAR_MIN).then(|| Suggestion {
                code: SuggestionCode::DockNow,
                // After charging, the robot returns to the mode in which it was.
                requests: prowl
                    .into_iter()
                    .chain([Request::Mode(Mode::Forage)])
                    .collect(),
                target_in: None,
                figures: vec![lasts],
            });
        }
        let takes_min = |length_in: f64| length_in / SPEED_IN_S / 60.0 + DOCKING_MIN;
        let is_late = |takes_min: f64| lasts_min < DRIVES * takes_min + SPARE_MIN;
        let route = compass.route(HOME_IN, it.robot.list_capacity()).ok()?;
        let takes_min = takes_min(route.length_in);
        (is_late(takes_min) && !route.waypoints.is_empty()).then(|| Suggestion {
            code: SuggestionCode::DockNow,
            requests: vec![Request::Route(route.waypoints), Request::Mode(Mode::Prowl)],
            target_in: Some(HOME_IN),
            figures: vec![figure("dock-takes", takes_min), lasts],
        })
    }
}

/// Minutes over which the voltage's fall is measured, and the least number of them.
const MINUTES: usize = 30;
const MINUTES_LEAST: usize = 10;

/// Mean voltages of the latest minutes.
#[derive(Clone, Debug, Default)]
struct Discharge {
    /// Middle of each minute, and the mean voltage in it, decivolts.
    means: VecDeque<(f64, f64)>,
    newest: Option<Moment>,
    sum: f64,
    count: u32,
}

impl Discharge {
    /// Takes the voltage of a line B, decivolts, that arrived at a time; the same line may be given again.
    fn take(&mut self, at: Moment, voltage_dv: f64) {
        if self.newest.is_some_and(|newest| newest >= at) {
            return;
        }
        let minute = |at: Moment| at.as_secs() / 60;
        if let Some(newest) = self.newest.filter(|newest| minute(*newest) != minute(at)) {
            if self.means.len() == MINUTES {
                self.means.pop_front();
            }
            let mean_dv = self.sum / f64::from(self.count);
            self.means.push_back((minute(newest) as f64, mean_dv));
            (self.sum, self.count) = (0.0, 0);
        }
        self.newest = Some(at);
        self.sum += voltage_dv;
        self.count += 1;
    }

    /// Minutes until the voltage falls below a limit, by the line of least squares; `None` while its fall is not known.
    fn lasts_min(&self, limit_dv: f64) -> Option<f64> {
        let count = self.means.len() as f64;
        if self.means.len() < MINUTES_LEAST {
            return None;
        }
        let mean = |of: fn(&(f64, f64)) -> f64| self.means.iter().map(of).sum::<f64>() / count;
        let (minute, voltage_dv) = (mean(|it| it.0), mean(|it| it.1));
        let (mut both, mut squares) = (0.0, 0.0);
        for (at, value_dv) in &self.means {
            both += (at - minute) * (value_dv - voltage_dv);
            squares += (at - minute) * (at - minute);
        }
        let fall_dv = -both / squares;
        let (newest, _) = self.means.back()?;
        (fall_dv > 0.0).then(|| {
            let now_dv = voltage_dv - fall_dv * (newest - minute);
            ((now_dv - limit_dv) / fall_dv).max(0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Readings of whole decivolts that fall at a steady rate of 3 dV an hour or more, as those of a driving robot do, with the noise of the
        /// motors' load. Without noise of at least a reading, rounding hides a slow fall.
        #[test]
        fn battery_lasts_until_its_line_meets_the_limit(
            fall_dv_h in 3.0..12.0_f64, begin_dv in 118.0..126.0_f64, noise_dv in 1.0..2.0_f64, minutes in 30..50_u32,
        ) {
            let mut discharge = Discharge::default();
            let mut true_dv = begin_dv;
            for second in (0..minutes * 60).step_by(2) {
                true_dv = begin_dv - fall_dv_h * f64::from(second) / 3600.0;
                let noise = (f64::from(second) * 2.399_963).sin() * noise_dv;
                let at = Moment::from_secs(u64::from(second));
                discharge.take(at, (true_dv + noise).round());
                discharge.take(at, 0.0);
            }
            let lasts_min = discharge.lasts_min(116.0).unwrap();
            let true_min = ((true_dv - 116.0) / fall_dv_h * 60.0).max(0.0);
            prop_assert!((lasts_min - true_min).abs() < 3.0 + 0.15 * true_min, "{lasts_min} of {true_min}");
        }
    }

    #[test]
    fn a_battery_that_does_not_fall_lasts_for_an_unknown_time() {
        let mut discharge = Discharge::default();
        for second in 0..1200 {
            discharge.take(Moment::from_secs(second), 130.0);
        }
        assert_eq!(discharge.lasts_min(116.0), None);
        assert_eq!(Discharge::default().lasts_min(116.0), None);
    }
}
