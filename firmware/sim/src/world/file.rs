//! The TOML form of a world and its conversion.

use serde::Deserialize;
use toml::Spanned;

use super::World;
use super::clutter::{self, ClutterKind};
use super::dock::Dock;
use super::error::{Source, WorldError};
use super::ground::{Ground, GroundKind};
use super::material::Material;
use super::outline::Outline;
use super::parts::{Lamp, Obstacle, Walker, WalkerKind};
use super::plan::Plan;
use crate::dimensions::RADIUS_IN;
use crate::geometry::Vec2;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    about: String,
    cell_in: Spanned<f64>,
    #[serde(default)]
    daylight_lux: f64,
    plan: Spanned<String>,
    #[serde(default)]
    lamp: Vec<LampEntry>,
    #[serde(default)]
    walker: Vec<WalkerEntry>,
    #[serde(default)]
    clutter: Vec<ClutterEntry>,
    dock: Option<DockEntry>,
    #[serde(default)]
    ground: Vec<GroundEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LampEntry {
    name: String,
    at: Spanned<Place>,
    candela: Spanned<f64>,
    #[serde(default = "default_lamp_height")]
    height_in: f64,
    #[serde(default = "default_on")]
    on: bool,
}

const fn default_lamp_height() -> f64 {
    48.0
}

const fn default_on() -> bool {
    true
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WalkerEntry {
    kind: WalkerKind,
    path: Spanned<Vec<Spanned<Place>>>,
    speed_in_s: Option<Spanned<f64>>,
    #[serde(default)]
    pause_s: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClutterEntry {
    kind: ClutterKind,
    at: Spanned<Place>,
    size_in: Option<[f64; 2]>,
    radius_in: Option<f64>,
    height_in: Option<f64>,
    #[serde(default)]
    turned_deg: f64,
    made_of: Option<Material>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DockEntry {
    at: Spanned<Place>,
    facing_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GroundEntry {
    kind: GroundKind,
    at: Spanned<Place>,
    size_in: [f64; 2],
    #[serde(default)]
    turned_deg: f64,
    grade_percent: Option<f64>,
}

/// A mark of the plan, or inches from the plan's south-west corner.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a place: a mark of the plan (\"A\") or [x, y] in inches"
)]
enum Place {
    Mark(char),
    Inches([f64; 2]),
}

impl World {
    /// Parses the text of a world; error messages name `file`.
    ///
    /// # Errors
    ///
    /// The first error in the text, with file, line, column and hint.
    pub fn parse(file: &str, text: &str) -> Result<Self, WorldError> {
        let source = Source { file, text };
        let entries: File = toml::from_str(text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            source.error(offset, error.message())
        })?;
        let cell_in = *entries.cell_in.get_ref();
        if !(1.0..=24.0).contains(&cell_in) {
            return Err(source.error(
                entries.cell_in.span().start,
                "cell_in must be between 1 and 24 inches",
            ));
        }
        let plan = Plan::parse(&source, entries.plan.span(), cell_in)?;
        let places = Places {
            source: &source,
            plan: &plan,
        };

        let mut obstacles: Vec<Obstacle> = plan
            .solids()
            .into_iter()
            .map(|(solid, material)| Obstacle { solid, material })
            .collect();
        let plan_solids = obstacles.len();
        let mut outlines = plan.outlines();
        outlines.extend(plan.walls());
        let mut overheads = Vec::new();
        let mut snags = Vec::new();
        for entry in &entries.clutter {
            let parts = clutter::parts(&clutter::Spec {
                kind: entry.kind,
                center: places.find(&entry.at)?,
                size: entry.size_in.map(Vec2::from),
                radius_in: entry.radius_in,
                height_in: entry.height_in,
                turned_deg: entry.turned_deg,
                material: entry.made_of,
            })
            .map_err(|problem| source.error(entry.at.span().start, problem))?;
            overheads.extend(parts.overhead);
            snags.extend(parts.snag);
            for part in parts.obstacles {
                outlines.extend(Outline::of(&part.solid, part.material));
                obstacles.push(part);
            }
        }
        let dock = match &entries.dock {
            Some(entry) => Some(Dock::new(places.find(&entry.at)?, entry.facing_deg)),
            None => None,
        };
        if let Some(dock) = &dock {
            let plate = dock.obstacle();
            outlines.extend(Outline::of(&plate.solid, plate.material));
            obstacles.push(plate);
        }
        let grounds = entries
            .ground
            .iter()
            .map(|entry| places.ground(entry))
            .collect::<Result<Vec<_>, _>>()?;
        let lamps = entries
            .lamp
            .iter()
            .map(|entry| places.lamp(entry))
            .collect::<Result<Vec<_>, _>>()?;
        let walkers = entries
            .walker
            .iter()
            .map(|entry| places.walker(entry, &obstacles))
            .collect::<Result<Vec<_>, _>>()?;
        let start = Vec2::new(plan.start.x_in, plan.start.y_in);
        if !is_clear(&obstacles, start, RADIUS_IN + START_MARGIN_IN) {
            return Err(source.error(
                plan.start_offset,
                "the robot does not fit at its start: keep 6 inches free on every side",
            ));
        }
        let size = plan.size();
        Ok(Self {
            name: entries.name,
            about: entries.about,
            start: plan.start,
            size_in: [size.x, size.y],
            daylight_lux: entries.daylight_lux.max(0.0),
            grid: plan.grid(&source),
            drops: plan.drops(),
            obstacles,
            plan_solids,
            grounds,
            snags,
            overheads,
            outlines,
            dock,
            lamps,
            walkers,
        })
    }
}

const START_MARGIN_IN: f64 = 0.5;

/// Step in inches of the check that a walker's path is free.
const WALK_CHECK_IN: f64 = 3.0;

fn is_clear(obstacles: &[Obstacle], center: Vec2, radius_in: f64) -> bool {
    obstacles
        .iter()
        .all(|obstacle| obstacle.solid.approach(center).0 > radius_in)
}

/// Resolves the places in a world file.
struct Places<'a> {
    source: &'a Source<'a>,
    plan: &'a Plan,
}

impl Places<'_> {
    fn find(&self, place: &Spanned<Place>) -> Result<Vec2, WorldError> {
        let offset = place.span().start;
        let size = self.plan.size();
        match *place.get_ref() {
            Place::Mark(mark) => self.plan.mark(mark).ok_or_else(|| {
                self.source.error(
                    offset,
                    format!("the plan has no mark {mark}: put the letter on a floor cell"),
                )
            }),
            Place::Inches([x, y]) if (0.0..=size.x).contains(&x) && (0.0..=size.y).contains(&y) => {
                Ok(Vec2::new(x, y))
            }
            Place::Inches([x, y]) => Err(self.source.error(
                offset,
                format!(
                    "[{x}, {y}] is outside the plan: use 0 to {} and 0 to {} inches",
                    size.x, size.y
                ),
            )),
        }
    }

    fn positive(&self, value: &Spanned<f64>, name: &str) -> Result<f64, WorldError> {
        let number = *value.get_ref();
        if number > 0.0 && number.is_finite() {
            Ok(number)
        } else {
            Err(self
                .source
                .error(value.span().start, format!("{name} must be above 0")))
        }
    }

    fn ground(&self, entry: &GroundEntry) -> Result<Ground, WorldError> {
        Ground::new(
            entry.kind,
            self.find(&entry.at)?,
            Vec2::from(entry.size_in),
            entry.turned_deg,
            entry.grade_percent,
        )
        .map_err(|problem| self.source.error(entry.at.span().start, problem))
    }

    fn lamp(&self, entry: &LampEntry) -> Result<Lamp, WorldError> {
        Ok(Lamp {
            name: entry.name.clone(),
            center: self.find(&entry.at)?,
            candela: self.positive(&entry.candela, "candela")?,
            height_in: entry.height_in.max(1.0),
            on: entry.on,
        })
    }

    fn walker(&self, entry: &WalkerEntry, obstacles: &[Obstacle]) -> Result<Walker, WorldError> {
        let places = entry.path.get_ref();
        if places.len() < 2 {
            return Err(self
                .source
                .error(entry.path.span().start, "a path needs at least two places"));
        }
        let path = places
            .iter()
            .map(|place| self.find(place))
            .collect::<Result<Vec<_>, _>>()?;
        let radius_in = entry.kind.radius_in();
        let legs = path.iter().zip(path.iter().cycle().skip(1));
        for ((from, to), place) in legs.zip(places) {
            if let Some(at) = blocked(obstacles, *from, *to, radius_in) {
                return Err(self.source.error(
                    place.span().start,
                    format!(
                        "an obstacle at [{:.0}, {:.0}] blocks the path after this place: add places so that \
                         {radius_in} inches stay free on each side (the path returns from its end to its start)",
                        at.x, at.y
                    ),
                ));
            }
        }
        let speed_in_s = match &entry.speed_in_s {
            Some(speed) => self.positive(speed, "speed_in_s")?,
            None => entry.kind.speed_in_s(),
        };
        Ok(Walker {
            kind: entry.kind,
            path,
            speed_in_s,
            pause_s: entry.pause_s.max(0.0),
        })
    }
}

/// The place at which a round body first hits an obstacle on the straight line between two places.
fn blocked(obstacles: &[Obstacle], from: Vec2, to: Vec2, radius_in: f64) -> Option<Vec2> {
    let offset = to - from;
    let steps = (offset.length() / WALK_CHECK_IN).ceil().max(1.0) as u32;
    (0..=steps)
        .map(|step| from + offset * (f64::from(step) / f64::from(steps)))
        .find(|at| !is_clear(obstacles, *at, radius_in))
}
