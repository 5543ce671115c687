//! Fuzzing of text input: route files, configurations, commands, the shared socket. `docs/fuzzing.md` describes longer
//! runs.

use groundwave::commands::config;
use groundwave::request::Request;
use groundwave::route;
use groundwave::share::{ClientLine, Lines, StationLine};

const ITERATIONS: usize = 5000;

/// A route is equal after writing and reading; an invalid one gets an error with the file's name.
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

/// A configuration is read, with all values in range, or gets an error.
#[test]
fn fuzz_configuration() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(
            |bytes: &[u8]| match config::parse(&String::from_utf8_lossy(bytes)) {
                Ok(config) => assert_eq!(
                    config.link.latency_ms.is_some(),
                    config.link.latency().is_some()
                ),
                Err(mistakes) => {
                    assert!(!mistakes.is_empty());
                    assert!(mistakes.iter().all(|mistake| !mistake.message.is_empty()));
                }
            },
        );
}

/// A command is equal after writing and reading.
#[test]
fn fuzz_command() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            let words: Vec<&str> = text.split_whitespace().collect();
            if let Ok(request) = Request::from_words(&words) {
                let said = request.to_string();
                let again: Vec<&str> = said.split_whitespace().collect();
                assert_eq!(Request::from_words(&again), Ok(request), "{said}");
            }
        });
}

/// Arbitrary bytes of a client: lines do not depend on the chunks, none is longer than allowed, and a parsed line is
/// equal after writing and reading.
#[test]
fn fuzz_socket() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            let whole = lines(bytes, bytes.len().max(1));
            assert_eq!(whole, lines(bytes, 1));
            assert_eq!(whole, lines(bytes, 7));
            for line in whole.into_iter().flatten() {
                if let Ok(read) = ClientLine::parse(&line) {
                    let written = read.to_line();
                    let written = written.strip_suffix(b"\n").expect("a line ends");
                    assert_eq!(ClientLine::parse(written), Ok(read));
                }
                let _ = StationLine::parse(&line);
            }
        });
}

/// The lines found in chunks of `chunk` bytes, up to the first that is too long, after which the client is cut off.
fn lines(bytes: &[u8], chunk: usize) -> Vec<Option<Vec<u8>>> {
    let mut lines = Lines::default();
    let mut found = Vec::new();
    for mut rest in bytes.chunks(chunk) {
        while !rest.is_empty() {
            let (taken, line) = lines.take(rest);
            rest = &rest[taken..];
            match line {
                Ok(Some(line)) => found.push(Some(line)),
                Ok(None) => {}
                Err(_) => {
                    found.push(None);
                    return found;
                }
            }
        }
    }
    found
}
