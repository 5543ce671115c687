//! Arbitrary text for what people write: route files. `docs/fuzzing.md` says how to run these for longer.

use groundwave::route;

const ITERATIONS: usize = 5000;

/// Whatever is read as a route is written so that it reads the same; whatever is not has an error that
/// names the file.
#[test]
fn fuzz_route() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            match route::parse("r.txt", &text) {
                Ok(waypoints) => {
                    assert!((1..=groundwave_protocol::WAYPOINTS_MAX).contains(&waypoints.len()));
                    let again = route::parse("r.txt", &route::format(&waypoints));
                    assert_eq!(again, Ok(waypoints));
                }
                Err(error) => assert!(error.to_string().starts_with("r.txt:"), "{error}"),
            }
        });
}
