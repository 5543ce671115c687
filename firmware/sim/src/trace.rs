//! True pose, estimated pose, inputs and decisions of the robot at every tick, as CSV.

use std::io::{self, Write};

use groundwave_protocol::status_codes::Layer;
use sr04_firmware::arbiter::Holder;
use sr04_firmware::board::{COUNTS_PER_IN, Edges, Sides};
use sr04_firmware::odometry::UNITS_PER_IN;

use crate::simulation::Simulation;
use crate::time::TICK_MS;

/// Column names. `firmware/trials/README.md` defines each column.
const COLUMNS: &str = "time_ms,true_x_in,true_y_in,true_theta_deg,believed_x_in,believed_y_in,believed_theta_deg,\
mode,target_x_in,target_y_in,counts_left,counts_right,bumper,sonar_side,sonar_in,ir_count,ir_jammed,photo_left,\
photo_right,cliff,motion,top_hat,beacon,docked,battery_v,flags,winner,velocity_in_s,rotation_in_s,pwm_left,pwm_right,\
note_hz,arm_up,touching,charge,guard,fallen";

/// Writes one CSV row per tick.
#[derive(Debug)]
pub struct Trace<W> {
    out: W,
    written_ms: u64,
}

impl<W: Write> Trace<W> {
    /// Writes the column names.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written.
    pub fn new(mut out: W) -> io::Result<Self> {
        writeln!(out, "{COLUMNS}")?;
        Ok(Self { out, written_ms: 0 })
    }

    /// Writes a row if the simulation has ticked since the last call. Call it at least once per tick.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written.
    pub fn observe(&mut self, simulation: &Simulation) -> io::Result<()> {
        let now_ms = simulation.now_ms();
        if now_ms / TICK_MS == self.written_ms / TICK_MS {
            return Ok(());
        }
        self.written_ms = now_ms;
        let (robot, inputs) = (simulation.robot(), simulation.inputs());
        let (outputs, truth) = (simulation.outputs(), simulation.truth());
        let believed = robot.pose();
        let inches = |units: i32| f64::from(units) / f64::from(UNITS_PER_IN);
        write!(
            self.out,
            "{now_ms},{:.3},{:.3},{:.2},{:.3},{:.3},{:.2},",
            truth.pose.x_in,
            truth.pose.y_in,
            truth.pose.theta_deg,
            inches(believed.x_units),
            inches(believed.y_units),
            f64::from(believed.heading.0 as i16) * 360.0 / 65536.0,
        )?;
        let target = robot.target();
        write!(
            self.out,
            "{:?},{},{},{},{},{},",
            robot.mode(),
            number(target.map(|target| target.x_in)),
            number(target.map(|target| target.y_in)),
            inputs.counts_left,
            inputs.counts_right,
            marks(&[
                ('L', inputs.bumper.left),
                ('C', inputs.bumper.center),
                ('R', inputs.bumper.right),
            ]),
        )?;
        let edges = inputs.cliff.unwrap_or_default();
        write!(
            self.out,
            "{},{},{},{},{},{},{},{},{},{},{},{:.1},",
            inputs
                .sonar
                .map_or(String::new(), |echo| format!("{:?}", echo.side)),
            number(inputs.sonar.and_then(|echo| echo.range_in)),
            robot.infrared().max_count(),
            u8::from(robot.infrared().is_jammed()),
            number(inputs.photo_left),
            number(inputs.photo_right),
            marks(&[
                ('L', edges.meets(Edges::AHEAD_LEFT.or(Edges::BESIDE_LEFT))),
                ('C', edges.meets(Edges::AHEAD)),
                ('R', edges.meets(Edges::AHEAD_RIGHT.or(Edges::BESIDE_RIGHT))),
                ('T', edges.meets(Edges::REAR)),
            ]),
            sides(inputs.motion),
            u8::from(inputs.top_hat),
            sides(inputs.beacon),
            u8::from(inputs.is_docked),
            f64::from(inputs.battery_dv) / 10.0,
        )?;
        let (requests, motion) = (robot.requests(), robot.motion());
        let flags: String = requests
            .iter()
            .enumerate()
            .map(|(place, request)| match Layer::ALL.get(place) {
                _ if !request.flag => '-',
                Some(layer) => char::from(layer.letter()),
                None => 'p',
            })
            .collect();
        let winner = match robot.holder() {
            None => String::new(),
            Some(Holder::Prowl) => "Prowl".to_owned(),
            Some(Holder::Layer(layer)) => format!("{layer:?}"),
        };
        let in_s = |cps: i16| f64::from(cps) / f64::from(COUNTS_PER_IN);
        writeln!(
            self.out,
            "{flags},{winner},{:.2},{:.2},{},{},{},{},{},{:.5},{},{}",
            in_s(motion.velocity_cps),
            in_s(motion.rotation_cps),
            outputs.pwm_left,
            outputs.pwm_right,
            outputs.note_hz,
            u8::from(outputs.arm_up),
            u8::from(truth.is_touching),
            truth.charge,
            robot
                .guarded()
                .map_or(String::new(), |guard| format!("{guard:?}")),
            u8::from(truth.has_fallen),
        )
    }

    /// Flushes and returns the writer.
    ///
    /// # Errors
    ///
    /// If buffered rows cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}

/// The letter of each active signal, `-` for an inactive one.
fn marks(all: &[(char, bool)]) -> String {
    all.iter()
        .map(|&(letter, is_so)| if is_so { letter } else { '-' })
        .collect()
}

/// `L` and `R` for the active sides; empty when the sensor is not fitted.
fn sides(sides: Option<Sides>) -> String {
    sides.map_or(String::new(), |sides| {
        marks(&[('L', sides.left), ('R', sides.right)])
    })
}

/// The value as text; empty for `None`.
fn number<T: ToString>(value: Option<T>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::SimulationConfig;
    use crate::world::World;
    use sr04_firmware::parameters::Parameter;

    #[test]
    fn trace_has_one_complete_row_per_tick() {
        let mut simulation = Simulation::new(&SimulationConfig::new(World::default(), 1));
        let mut trace = Trace::new(Vec::new()).unwrap();
        for _ in 0..2000 {
            simulation.step();
            trace.observe(&simulation).unwrap();
        }
        let text = String::from_utf8(trace.finish().unwrap()).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|row| row.split(',').collect()).collect();
        assert_eq!(rows.len(), 1 + 40);
        assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{text}");
        let column = |name| rows[0].iter().position(|&column| column == name).unwrap();
        assert_eq!(rows[1][column("time_ms")], "50");
        assert_eq!(rows[40][column("mode")], "Prowl");
        assert_eq!(rows[40][column("bumper")], "---");
        let ahead: f64 = rows[40][column("true_y_in")].parse().unwrap();
        assert!(ahead > 3.0, "{ahead}");
    }

    #[test]
    fn trace_shows_the_acting_guard_and_a_fall() {
        let world = World::built_in("stairs").unwrap();
        for guard in [1, 0] {
            let mut config = SimulationConfig::new(world.clone(), 3);
            assert!(config.parameters.set(Parameter::CliffGuard, guard));
            let mut simulation = Simulation::new(&config);
            let mut trace = Trace::new(Vec::new()).unwrap();
            for _ in 0..600_000 {
                simulation.step();
                trace.observe(&simulation).unwrap();
                if simulation.truth().has_fallen {
                    simulation.run_for_ms(TICK_MS);
                    trace.observe(&simulation).unwrap();
                    break;
                }
            }
            let text = String::from_utf8(trace.finish().unwrap()).unwrap();
            let ends = |end: &str| text.lines().any(|row| row.ends_with(end));
            assert_eq!(ends(",Cliff,0"), guard == 1);
            assert_eq!(ends(",1"), guard == 0);
        }
    }
}
