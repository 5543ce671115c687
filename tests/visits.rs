//! Floor that a prowling robot has seen and never visited.

use groundwave::event::{SuggestionCode, SuggestionStatus};
use groundwave::model::Advise;
use sr04_sim::World;

use crate::advice::Dashboard;
use crate::common::on_all_cores;

/// The station suggests a visit to floor that the robot has only seen. The operator accepts it, and the robot drives where it has not been
/// before.
#[test]
fn suggested_visit_leads_where_the_robot_has_not_been() {
    let runs = on_all_cores(20_400..20_406, |seed| {
        let mut robot = Dashboard::new(World::generated(seed), seed, 0.0, Advise::Suggest);
        let mut path = Vec::new();
        for _ in 0..40 * 60 {
            robot.run(1);
            let truth = robot.co.simulation.truth().pose;
            path.push((truth.x_in, truth.y_in));
            let newest = robot.suggestions.last();
            let newest = newest.filter(|it| it.status == SuggestionStatus::Begun);
            if newest.is_some_and(|it| it.code == SuggestionCode::Unvisited) {
                break;
            }
        }
        let suggestion = robot.suggestions.pop()?;
        robot.accept();
        robot.run(10);
        let mut new_in: f64 = 0.0;
        for _ in 0..10 * 60 {
            robot.run(1);
            let far_in = path.iter().map(|place| robot.distance_in(*place));
            new_in = new_in.max(far_in.fold(f64::MAX, f64::min));
            if robot.has_stopped() {
                return Some((true, new_in, suggestion.to_string()));
            }
        }
        Some((false, new_in, suggestion.to_string()))
    });
    for run in &runs {
        println!("{run:?}");
    }
    let visits = runs.iter().filter_map(|(_, run)| run.as_ref());
    let visits: Vec<_> = visits.filter(|(_, new_in, _)| *new_in > 20.0).collect();
    assert!(visits.len() >= 4, "{}", visits.len());
    // The others still drove after ten minutes.
    let arrived = visits.iter().filter(|(arrived, ..)| *arrived).count();
    assert!(arrived >= 2, "{arrived}");
}
