//! Sentences of GPS receivers, NMEA 0183.

use ::nmea::{ParseResult, parse_str};

use super::{Cell, CellValue, finite};
use crate::field::Role;

/// Length of a degree of latitude, metres.
const M_PER_DEG: f64 = 111_194.93;

/// The first position, which is the origin of x and y.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Origin(Option<(f64, f64)>);

/// The values of a sentence; `None` if the line is damaged or not a sentence. A sentence without known values has no cells.
pub(crate) fn nmea(line: &str, origin: &mut Origin) -> Option<Vec<Cell<'static>>> {
    // The parser needs the bytes of a sentence without a line end, and takes 102 of them.
    let sentence = line.trim_end();
    if !sentence.starts_with('$') {
        return None;
    }
    let mut cells = Cells(Vec::new());
    match parse_str(sentence).ok()? {
        ParseResult::GGA(gga) => {
            if gga.fix_satellites.is_some_and(|satellites| satellites > 0) {
                cells.place(gga.latitude, gga.longitude, origin);
            }
            cells.add("altitude", "m", gga.altitude.map(widened));
            cells.add("satellites", "", gga.fix_satellites.map(f64::from));
            cells.add("hdop", "", gga.hdop.map(widened));
        }
        ParseResult::RMC(rmc) => {
            cells.place(rmc.lat, rmc.lon, origin);
            cells.movement(rmc.speed_over_ground, rmc.true_course);
        }
        ParseResult::VTG(vtg) => cells.movement(vtg.speed_over_ground, vtg.true_course),
        ParseResult::GLL(gll) => cells.place(gll.latitude, gll.longitude, origin),
        ParseResult::GSA(gsa) => {
            cells.add("pdop", "", gsa.pdop.map(widened));
            cells.add("vdop", "", gsa.vdop.map(widened));
        }
        _ => {}
    }
    Some(cells.0)
}

struct Cells(Vec<Cell<'static>>);

impl Cells {
    fn add(&mut self, name: &'static str, unit: &'static str, value: Option<f64>) {
        self.add_with_role(name, unit, None, value);
    }

    fn add_with_role(
        &mut self,
        name: &'static str,
        unit: &'static str,
        role: Option<Role>,
        value: Option<f64>,
    ) {
        self.0.push(Cell {
            unit: Some(unit).filter(|unit| !unit.is_empty()),
            role,
            ..Cell::new(name, value.map_or(CellValue::Missing, finite))
        });
    }

    fn movement(&mut self, speed_kn: Option<f32>, course_deg: Option<f32>) {
        self.add_with_role("speed", "kn", Some(Role::Speed), speed_kn.map(widened));
        self.add_with_role(
            "course",
            "deg",
            Some(Role::Heading),
            course_deg.map(widened),
        );
    }

    /// Adds a position: in degrees, and in metres east and north of the first position.
    fn place(&mut self, latitude: Option<f64>, longitude: Option<f64>, origin: &mut Origin) {
        self.add("latitude", "deg", latitude);
        self.add("longitude", "deg", longitude);
        let (Some(latitude), Some(longitude)) = (latitude, longitude) else {
            return;
        };
        let (from_latitude, from_longitude) = *origin.0.get_or_insert((latitude, longitude));
        let east_deg = (longitude - from_longitude + 540.0).rem_euclid(360.0) - 180.0;
        let x_m = east_deg * M_PER_DEG * from_latitude.to_radians().cos();
        let y_m = (latitude - from_latitude) * M_PER_DEG;
        self.add_with_role("x", "m", Some(Role::X), Some(x_m));
        self.add_with_role("y", "m", Some(Role::Y), Some(y_m));
    }
}

/// Converts a number with its decimal digits unchanged: 61.7, not 61.70000076.
fn widened(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::NAN)
}
