//! Draws two courses over each other with characters.

use super::Course;
use super::course::Place;

/// Ratio of a character's height to its width.
const CELL_RATIO: f64 = 2.0;

/// Draws two courses at one scale, north up, in at most the given columns and rows: `1` for the first, `2` for the second, `#`
/// for both. Empty when neither has a place.
#[must_use]
pub fn sketch(courses: [&Course; 2], columns: usize, rows: usize) -> String {
    let all = || courses.iter().flat_map(|course| course.points());
    let Some(&first) = all().next() else {
        return String::new();
    };
    let (low, high) = all().fold((first, first), |(low, high), &(x, y)| {
        ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)))
    });
    let scale = [
        (high.0 - low.0) / (columns.max(2) - 1) as f64,
        (high.1 - low.1) / (rows.max(2) - 1) as f64 / CELL_RATIO,
        f64::MIN_POSITIVE,
    ]
    .into_iter()
    .fold(0.0, f64::max);
    let cell = |(x, y): Place| {
        let column = ((x - low.0) / scale).round() as usize;
        let row = ((high.1 - y) / scale / CELL_RATIO).round() as usize;
        (row, column)
    };
    let (last_row, _) = cell((low.0, low.1));
    let mut cells = vec![vec![0_u8; columns.max(2)]; last_row + 1];
    for (bit, course) in [1, 2].into_iter().zip(courses) {
        let mut last: Option<Place> = None;
        for &to in course.points() {
            let from = last.unwrap_or(to);
            let steps = ((to.0 - from.0).hypot(to.1 - from.1) / scale)
                .ceil()
                .max(1.0);
            for step in 0..=steps as usize {
                let part = step as f64 / steps;
                let place = (
                    from.0 + part * (to.0 - from.0),
                    from.1 + part * (to.1 - from.1),
                );
                let (row, column) = cell(place);
                if let Some(cell) = cells.get_mut(row).and_then(|row| row.get_mut(column)) {
                    *cell |= bit;
                }
            }
            last = Some(to);
        }
    }
    let mut text = String::new();
    for row in cells {
        let row: String = row
            .iter()
            .map(|bits| [' ', '1', '2', '#'][usize::from(*bits)])
            .collect();
        text.push_str(row.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::course::tests::through;
    use super::*;

    #[test]
    fn each_track_has_its_own_sign_and_the_common_way_a_third() {
        let a = through(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]);
        let b = through(&[(0.0, 0.0), (10.0, 0.0)]);
        assert_eq!(
            sketch([&a, &b], 11, 6),
            "          1\n          1\n          1\n          1\n          1\n###########\n"
        );
    }

    #[test]
    fn nothing_and_a_point_can_be_drawn() {
        let (none, point) = (Course::default(), through(&[(3.0, 3.0)]));
        assert_eq!(sketch([&none, &none], 80, 24), "");
        assert_eq!(sketch([&none, &point], 80, 24), "2\n");
    }
}
