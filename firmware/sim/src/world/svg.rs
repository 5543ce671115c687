//! A world as an SVG drawing.

use std::fmt::Write as _;

use super::World;
use super::material::Material;
use super::outline::{Outline, Point};
use super::parts::Obstacle;
use crate::dimensions::RADIUS_IN;
use crate::geometry::{Solid, Vec2, heading};

/// Number of pixels per inch.
const SCALE: f64 = 2.0;

impl World {
    /// The world from above, north up and to scale, as an SVG document.
    #[must_use]
    pub fn svg(&self) -> String {
        let [width, height] = self.size_in;
        let mut drawing = Drawing {
            height_in: height,
            text: format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {width} {height}\" \
                 font-family=\"sans-serif\" font-size=\"6\">\n<title>{}</title>\n\
                 <rect width=\"{width}\" height=\"{height}\" fill=\"#fdfcf8\"/>\n",
                width * SCALE,
                height * SCALE,
                escaped(&self.name)
            ),
        };
        let grid = &self.grid;
        for (index, _) in grid
            .glyphs
            .iter()
            .enumerate()
            .filter(|(_, glyph)| **glyph == '~')
        {
            let center = grid
                .layout
                .center(index / grid.layout.columns, index % grid.layout.columns);
            let cell = Solid::block(center, Vec2::splat(grid.layout.cell_in), 0.0);
            drawing.solid(&cell, "#444");
        }
        for ground in &self.grounds {
            drawing.solid(&ground.solid, "#e6dcc8");
        }
        for overhead in &self.overheads {
            drawing.solid(&overhead.solid, "#d9c7a855");
        }
        for Obstacle { solid, material } in &self.obstacles {
            drawing.solid(solid, color(*material));
        }
        for snag in &self.snags {
            drawing.solid(&snag.solid, "#b03060");
        }
        for walker in &self.walkers {
            drawing.path(&walker.path);
        }
        for lamp in &self.lamps {
            let fill = if lamp.on { "#f4b400" } else { "#bbb" };
            drawing.solid(&Solid::round(lamp.center, 3.0), fill);
            drawing.label(lamp.center, &lamp.name);
        }
        let start = Vec2::new(self.start.x_in, self.start.y_in);
        drawing.solid(&Solid::round(start, RADIUS_IN), "#3366cc88");
        let nose = start + heading(self.start.theta_deg.to_radians()) * RADIUS_IN;
        drawing.path(&[start, nose]);
        drawing.text.push_str("</svg>\n");
        drawing.text
    }
}

/// An SVG document in progress. SVG's Y axis points down, the plan's up.
struct Drawing {
    height_in: f64,
    text: String,
}

impl Drawing {
    fn solid(&mut self, solid: &Solid, fill: &str) {
        let outlines = Outline::of(solid, Material::Wall);
        if let [
            Outline::Circle {
                center, radius_in, ..
            },
        ] = outlines[..]
        {
            let (x, y) = self.place(center);
            let _ = writeln!(
                self.text,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius_in:.1}\" fill=\"{fill}\"/>"
            );
            return;
        }
        let corners: Vec<String> = outlines
            .iter()
            .filter_map(|outline| match outline {
                Outline::Segment { from, .. } => Some(*from),
                Outline::Block { .. } | Outline::Circle { .. } => None,
            })
            .map(|corner| {
                let (x, y) = self.place(corner);
                format!("{x:.1},{y:.1}")
            })
            .collect();
        let _ = writeln!(
            self.text,
            "<polygon points=\"{}\" fill=\"{fill}\"/>",
            corners.join(" ")
        );
    }

    fn path(&mut self, places: &[Vec2]) {
        let points: Vec<String> = places
            .iter()
            .map(|place| {
                let (x, y) = self.place(Point::from(*place));
                format!("{x:.1},{y:.1}")
            })
            .collect();
        let _ = writeln!(
            self.text,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"#c33\" stroke-width=\"1\"/>",
            points.join(" ")
        );
    }

    fn label(&mut self, at: Vec2, text: &str) {
        let (x, y) = self.place(Point::from(at));
        let _ = writeln!(
            self.text,
            "<text x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
            x + 5.0,
            escaped(text)
        );
    }

    fn place(&self, point: Point) -> (f64, f64) {
        (point.x_in, self.height_in - point.y_in)
    }
}

const fn color(material: Material) -> &'static str {
    match material {
        Material::Wall => "#555",
        Material::Glass => "#9cd",
        Material::Wood | Material::Leg => "#a9764c",
        Material::Soft => "#7a9e7e",
        Material::Dark | Material::DarkLeg => "#222",
        Material::Low => "#c9b458",
        Material::Alive => "#d08080",
        Material::Dock => "#2a8",
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
