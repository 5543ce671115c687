//! Arbitrary text for what people and programs write: route files, configurations, commands, the shared socket.
//! `docs/fuzzing.md` says how to run these for longer.

use groundwave::commands::config;
use groundwave::request::Request;
use groundwave::route;
use groundwave::share::{ClientLine, Lines, StationLine};

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

/// A configuration is read or refused with words; whatever was read says only what can be said.
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

/// Whatever is read as a command reads the same from its own words.
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

/// A client may send anything: lines are found whatever the chunks, none is longer than allowed, and what is
/// read as a line is written so that it reads the same.
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

/// The lines found in chunks of so many bytes, up to the first that is too long: its client is cut off.
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
