//! The screen of the robot's parameters.

use groundwave_protocol::telemetry::{Body, ParameterLine, ParameterName, Printable};

use super::*;
use crate::parameter_file::ParameterFile;

fn row(screen: &str, name: &str) -> String {
    let row = screen.lines().find(|row| row.contains(name));
    let row = row.unwrap_or_else(|| panic!("{screen}"));
    row.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn every_figure_of_a_parameter_is_shown() {
    for (width, height) in [(80, 24), (120, 40)] {
        let mut scene = Scene::new(demo());
        scene.type_text("P");
        assert!(screen(&scene, width, height).contains("parameters: none heard yet"));
        for (place, name, value, kept, limits, unit) in [
            (1, "top-speed", 10, 12, [2, 12], "in/s"),
            (2, "battery-low", 116, 116, [100, 130], "V/10"),
        ] {
            scene.hear_line(Body::Parameter(ParameterLine {
                place,
                count: 3,
                name: ParameterName::new(name),
                value,
                kept,
                least: limits[0],
                most: limits[1],
                unit: Printable::new(unit),
            }));
        }
        let screen = screen(&scene, width, height);
        assert!(screen.contains("parameters: 2 of 3 heard"), "{screen}");
        let speed = row(&screen, "top-speed");
        assert!(
            speed.contains("top-speed 10 in/s 2 to 12 12 saved: 12"),
            "{screen}"
        );
        let battery = row(&screen, "battery-low");
        assert!(
            battery.contains("battery-low 11.6 V 10.0 to 13.0 11.6"),
            "{screen}"
        );
        assert!(screen.contains("Maximum prowling speed"), "{screen}");
        insta::assert_snapshot!(format!("parameters_{width}"), screen);
        let file = ParameterFile::parse("garden.toml", "top-speed = 8").unwrap();
        scene.model.ui.compared = Some(file);
        let screen = self::screen(&scene, width, height);
        // Of a robot that has not named all, the count heard matters more.
        assert!(screen.contains("parameters: 2 of 3 heard"), "{screen}");
        assert!(row(&screen, "top-speed").contains("file: 8"), "{screen}");
    }
}
