use super::*;
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::Outcome;

const CALL: CallId = CallId(1);

/// Service calls after one call with this payload at 1 s.
fn called(payload: &str) -> Calls {
    let mut calls = Calls::default();
    calls.handle_call(Duration::from_secs(1), CALL, payload.as_bytes());
    calls
}

/// The request that the calls start now.
fn start(calls: &mut Calls, command: u32) -> Request {
    let Some(CallOutput::Start(CALL, request)) = calls.poll_output() else {
        panic!("nothing to start: {calls:?}");
    };
    calls.handle_started(CALL, CommandId(command));
    request
}

fn answer(calls: &mut Calls) -> Value {
    let Some(CallOutput::Answer(CALL, answer)) = calls.poll_output() else {
        panic!("no answer: {calls:?}");
    };
    serde_json::from_slice(&answer).unwrap()
}

fn refusal(payload: &str) -> String {
    let mut calls = called(payload);
    let answer = answer(&mut calls);
    assert_eq!(calls.poll_output(), None);
    assert_eq!(calls.poll_timeout(), None);
    assert_eq!(answer["status"], "failed");
    assert_eq!(answer["code"], "not-understood");
    answer["text"].as_str().unwrap().to_owned()
}

#[test]
fn a_list_is_answered_when_the_robot_has_confirmed_it() {
    let mut calls = called(r#"{"route":[{"x_in":48,"y_in":0},{"x_in":48,"y_in":-48}]}"#);
    let points = [(48, 0), (48, -48)].map(|(x, y)| Waypoint::new(x, y).unwrap());
    assert_eq!(start(&mut calls, 7), Request::Route(points.to_vec()));
    let id = CommandId(7);
    calls.handle_status(id, &CommandStatus::Sent { frames: 2 });
    let half = CommandStatus::Progress {
        acknowledged: 1,
        total: 2,
    };
    calls.handle_status(id, &half);
    // A command of another client.
    calls.handle_status(CommandId(6), &CommandStatus::Confirmed { digest: None });
    assert_eq!(calls.poll_output(), None);
    let digest = Some(0x89ab_cdef);
    calls.handle_status(id, &CommandStatus::Confirmed { digest });
    let confirmed = answer(&mut calls);
    let expected = json!({
        "status": "confirmed",
        "command": "route of 2",
        "digest": "89abcdef",
    });
    assert_eq!(confirmed, expected);
    calls.handle_status(id, &CommandStatus::Confirmed { digest });
    assert_eq!(calls.poll_output(), None, "answered once");
    assert_eq!(calls.poll_timeout(), None);
}

#[test]
fn a_preset_goes_one_by_one_and_ends_with_the_first_that_is_refused() {
    let mut calls = called(r#"{"do":"preset sonar-only"}"#);
    assert!(matches!(start(&mut calls, 1), Request::Only(_)));
    assert_eq!(calls.poll_output(), None);
    calls.handle_status(CommandId(1), &CommandStatus::Confirmed { digest: None });
    let next = start(&mut calls, 2);
    calls.handle_status(CommandId(2), &CommandStatus::Refused(Outcome::NotNow));
    let expected = json!({
        "status": "refused",
        "command": next.to_string(),
        "code": "not-now",
        "text": "not in its present state",
    });
    assert_eq!(answer(&mut calls), expected);
    assert_eq!(calls.poll_output(), None);
}

#[test]
fn an_unconfirmed_command_ends_at_its_timeout() {
    let mut calls = called(r#"{"do":"mode prowl","timeout_ms":1500}"#);
    assert_eq!(start(&mut calls, 3), Request::Mode(Mode::Prowl));
    let deadline = calls.poll_timeout().unwrap();
    assert_eq!(deadline, Duration::from_millis(2500));
    calls.handle_timeout(deadline.checked_sub(Duration::from_millis(1)).unwrap());
    assert_eq!(calls.poll_output(), None);
    calls.handle_timeout(deadline);
    let failed = answer(&mut calls);
    assert_eq!(failed["status"], "failed");
    assert_eq!(failed["code"], "timed-out");
    assert_eq!(calls.poll_output(), Some(CallOutput::GiveUp(CommandId(3))));
    assert_eq!(calls.poll_timeout(), None);
}

#[test]
fn invalid_calls_get_an_error() {
    for (rubbish, says) in [
        ("", "not understood: EOF"),
        ("mode prowl", "A call is {\"do\":\"mode prowl\"}"),
        (r#"{"mode":"prowl"}"#, "unknown field `mode`"),
        ("{}", "needs either \"do\" or \"route\""),
        (
            r#"{"do":"stop","route":[]}"#,
            "needs either \"do\" or \"route\"",
        ),
        (r#"{"do":""}"#, "no command given"),
        (r#"{"do":"fly"}"#, "unknown command `fly`"),
        (r#"{"do":"mode flying"}"#, "unknown mode `flying`"),
        (r#"{"route":[[48,0,48]]}"#, "not understood"),
        (r#"{"route":[{"x_in":48.5,"y_in":0}]}"#, "not understood"),
        (
            r#"{"route":[{"x_in":32000,"y_in":0}]}"#,
            "(32000, 0) is too far",
        ),
        (r#"{"do":"stop","timeout_ms":0}"#, "timeout_ms must be"),
    ] {
        let said = refusal(rubbish);
        assert!(said.contains(says), "{rubbish}: {said}");
    }
    let many = json!({ "route": vec![json!({ "x_in": 0, "y_in": 0 }); 2000] });
    let said = refusal(&many.to_string());
    assert!(said.contains("2000 waypoints"), "{said}");
    let mut calls = Calls::default();
    calls.handle_call(Duration::ZERO, CALL, &[0xFF, 0x00]);
    assert_eq!(answer(&mut calls)["code"], "not-understood");
}
