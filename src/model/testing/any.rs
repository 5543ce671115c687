//! Strategies for any event, possible or not.

use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use std::sync::Arc;

use groundwave_lines::{Content, Field, Limits, OwnLine, Role, Sample, Value};
use groundwave_protocol::Waypoint;
use groundwave_protocol::decoder::Counters;
use groundwave_protocol::status_codes::{
    Arm, Bump, Cliff, Drive, Infrared, Layer, LayerMask, LayerState, Link, Mode, Power,
};
use groundwave_protocol::telemetry::{
    AbilitiesLine, Ack, AckLine, Body, FIELDS_MAX, FieldLine, HOLDERS, LayerStates, Line, LineType,
    ListPlace, Note, Outcome, ParameterLine, ParameterName, Printable, SongLine, StateLine,
    StatusLine, TextLine, ValuesLine,
};
use proptest::prelude::*;
use proptest::sample::select;

use super::{counters, status};
use crate::event::{
    AlarmAnswer, Answer, CommandId, CommandStatus, Event, Failure, Level, LineRate, LinkEvent,
    Moment, Notice, NoticeCode, Reception, Recording, SHELF_MAX, Truth,
};
use crate::playback::Playback;
use crate::request::Request;
use crate::request::testing::samples;

fn any_state() -> impl Strategy<Value = StateLine> {
    let place = || prop_oneof![-20_000..20_000, -999_999..999_999];
    let speed = || -99_i8..=99;
    let states = prop::collection::vec(select(LayerState::ALL), 7);
    (
        (place(), place(), 0_u16..360, speed(), speed(), speed()),
        (
            any::<Option<u16>>(),
            prop::option::of(0_u16..1000),
            prop::option::of(0_u8..100),
        ),
        (
            select(Bump::ALL),
            select(Infrared::ALL),
            select(Cliff::ALL),
            select(Arm::ALL),
        ),
        (
            select(Drive::ALL),
            select(Power::ALL),
            select(Link::ALL),
            select(Mode::ALL),
        ),
        states,
    )
        .prop_map(|(motion, ranges, letters, more, states)| {
            let mut layers = LayerStates::OFF;
            for (layer, state) in Layer::ALL.into_iter().skip(1).zip(states) {
                layers.set(layer, state);
            }
            StateLine {
                x_tenths_in: motion.0,
                y_tenths_in: motion.1,
                theta_deg: motion.2,
                velocity_in_s: motion.3,
                rotation_in_s: motion.4,
                wheel_left_in_s: motion.5,
                wheel_right_in_s: motion.4,
                sonar_left_in: ranges.0,
                sonar_right_in: ranges.1,
                photo_left_pct: ranges.2,
                photo_right_pct: ranges.2,
                bump: letters.0,
                infrared: letters.1,
                cliff: letters.2,
                arm: letters.3,
                drive: more.0,
                power: more.1,
                link: more.2,
                mode: more.3,
                layers,
            }
        })
}

fn any_body() -> impl Strategy<Value = Body> {
    prop_oneof![
        any_body_of(LineType::State),
        select(LineType::ALL).prop_flat_map(any_body_of),
    ]
}

fn any_body_of(line_type: LineType) -> BoxedStrategy<Body> {
    let status_line = (
        any::<(u16, u8, u8, u16)>(),
        any::<Option<(i16, i16)>>(),
        0_u32..4,
    );
    match line_type {
        LineType::State => any_state().prop_map(Body::State).boxed(),
        LineType::Status => status_line
            .prop_map(
                |((battery_dv, fitted, allowed, count), target_in, digest)| {
                    Body::Status(StatusLine {
                        battery_dv,
                        target_in,
                        list: ListPlace {
                            driven: count / 2,
                            count,
                        },
                        digest,
                        fitted: LayerMask::from_bits(fitted),
                        allowed: LayerMask::from_bits(allowed),
                        ..status()
                    })
                },
            )
            .boxed(),
        LineType::Counters => any::<(u32, [u16; HOLDERS])>()
            .prop_map(|(uptime_s, ticks_won)| Body::Counters(counters(uptime_s, ticks_won)))
            .boxed(),
        LineType::Text => "[ -~]{0,80}"
            .prop_map(|text| Body::Text(TextLine::new(&text)))
            .boxed(),
        LineType::Parameter => any::<(u8, u8, String, i32, i32, String)>()
            .prop_map(|(place, count, name, value, kept, unit)| {
                Body::Parameter(ParameterLine {
                    place,
                    count,
                    name: ParameterName::new(&name),
                    value,
                    kept,
                    least: value.saturating_neg(),
                    most: value,
                    unit: Printable::new(&unit),
                })
            })
            .boxed(),
        LineType::Song => prop::collection::vec(any::<(u16, u8)>(), 0..30)
            .prop_map(|notes| notes.into_iter().map(|(hz, ticks)| Note { hz, ticks }))
            .prop_map(|notes| Body::Song(SongLine::new(notes)))
            .boxed(),
        LineType::Abilities => any::<(u8, u16, u16, u8, u32, u8)>()
            .prop_map(
                |(level, capacity, modes, measured, rate_bytes_per_s, fields)| {
                    Body::Abilities(AbilitiesLine {
                        robot_id: 7,
                        level,
                        capacity,
                        modes,
                        measured,
                        rate_bytes_per_s,
                        fields,
                    })
                },
            )
            .boxed(),
        LineType::Field => any::<(u8, u8, String, u8, String)>()
            .prop_map(|(place, count, name, decimals, unit)| {
                Body::Field(FieldLine {
                    place: place.clamp(1, FIELDS_MAX),
                    count,
                    name: ParameterName::new(&name),
                    decimals,
                    unit: Printable::new(&unit),
                })
            })
            .boxed(),
        LineType::Values => any::<[Option<i32>; 10]>()
            .prop_map(|values| Body::Values(ValuesLine::new(values)))
            .boxed(),
    }
}

fn any_waypoints() -> impl Strategy<Value = Vec<Waypoint>> {
    let waypoint = (-9999_i16..=9999, -9999_i16..=9999);
    prop::collection::vec(
        waypoint.prop_map(|(x_in, y_in)| Waypoint { x_in, y_in }),
        0..5,
    )
}

fn any_request() -> impl Strategy<Value = Request> {
    prop_oneof![
        3 => select(samples()),
        1 => select(Mode::ALL).prop_map(Request::Mode),
        1 => any::<u8>().prop_map(|bits| Request::Enable(LayerMask::from_bits(bits))),
        1 => any::<u8>().prop_map(|bits| Request::Disable(LayerMask::from_bits(bits))),
        3 => any_waypoints().prop_map(Request::Route),
    ]
}

fn any_status() -> impl Strategy<Value = CommandStatus> {
    prop_oneof![
        1 => Just(CommandStatus::Queued),
        1 => any::<u32>().prop_map(|frames| CommandStatus::Sent { frames }),
        1 => any::<(u16, u16)>().prop_map(|(acknowledged, total)| CommandStatus::Progress {
            acknowledged,
            total
        }),
        3 => prop::option::of(0_u32..4).prop_map(|digest| CommandStatus::Confirmed { digest }),
        1 => Just(CommandStatus::Refused(Outcome::BadValue)),
        1 => Just(CommandStatus::Failed(Failure::TimedOut)),
    ]
}

fn any_playback() -> impl Strategy<Value = Option<Playback>> {
    let seconds = || (0_u64..200_000).prop_map(Moment::from_secs);
    let playback = (
        any::<(bool, bool, f64, bool, Option<u64>)>(),
        (seconds(), seconds(), seconds()),
        prop::collection::vec(seconds(), 0..5),
        prop::option::of((seconds(), prop::option::of(seconds()))),
        prop::option::of((select(vec![Level::Info, Level::Warning]), any::<String>())),
    );
    let playback = playback.prop_map(
        |((is_live, paused, speed, is_partial, line), (at, from, until), markers, repeat, note)| {
            Playback {
                is_live,
                paused,
                speed,
                at,
                from,
                until,
                unix: line.map(Moment::from_millis),
                line,
                read_until: is_partial.then_some(at),
                is_partial,
                is_looking: is_partial,
                markers,
                repeat,
                note,
            }
        },
    );
    prop::option::of(playback)
}

fn any_key() -> impl Strategy<Value = KeyEvent> {
    let code = prop_oneof![
        4 => select(" prhWPD0123457dvOwuUSlCx:faHJKLt+-k<>,.gnNmoGbc?qynzTAie".chars().collect::<Vec<_>>()).prop_map(KeyCode::Char),
        1 => any::<char>().prop_map(KeyCode::Char),
        4 => select(vec![
            KeyCode::Up, KeyCode::Down, KeyCode::Left, KeyCode::Right, KeyCode::Enter,
            KeyCode::Esc, KeyCode::Tab, KeyCode::Backspace,
            KeyCode::PageUp, KeyCode::PageDown, KeyCode::F(2), KeyCode::F(3), KeyCode::F(4), KeyCode::F(8),
        ]),
    ];
    let kind = select(vec![
        KeyEventKind::Press,
        KeyEventKind::Press,
        KeyEventKind::Repeat,
        KeyEventKind::Release,
    ]);
    (code, 0_u8..4, kind).prop_map(|(code, held, kind)| {
        KeyEvent::new_with_kind(code, KeyModifiers::from_bits_truncate(held), kind)
    })
}

/// An event, or another moment on the screen.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly all are events")]
pub(crate) enum Happening {
    Event(Event),
    Moment(Option<Box<Playback>>),
}

/// Any event or moment, possible or not.
pub(crate) fn any_happening() -> impl Strategy<Value = Happening> {
    prop_oneof![
        30 => any_event().prop_map(Happening::Event),
        1 => any_playback().prop_map(|playback| Happening::Moment(playback.map(Box::new))),
    ]
}

fn any_own_line() -> impl Strategy<Value = OwnLine> {
    let roles = [
        None,
        Some(Role::X),
        Some(Role::Y),
        Some(Role::Heading),
        Some(Role::Battery),
        Some(Role::Mode),
        Some(Role::Bump),
        Some(Role::Text),
        Some(Role::Sequence),
    ];
    let value = prop_oneof![
        any::<f64>()
            .prop_filter("finite", |number| number.is_finite())
            .prop_map(Value::Number),
        (-99.0..99.0).prop_map(Value::Number),
        any::<String>().prop_map(|text| Value::Text(text.into())),
    ];
    let sample = (0_usize..80, value).prop_map(move |(n, value)| {
        let profile = Field {
            name: format!("field {n}"),
            unit: Some("漢字".to_owned()).filter(|_| n % 3 == 0),
            scale: 1.0,
            offset: 0.0,
            role: roles[n % roles.len()],
            limits: Limits::default(),
        };
        Sample {
            field: Arc::new(profile),
            value,
        }
    });
    let content = prop_oneof![
        8 => prop::collection::vec(sample, 0..9).prop_map(Content::Values),
        1 => Just(Content::Text),
        1 => Just(Content::Damaged),
    ];
    (any::<String>(), content).prop_map(|(text, content)| OwnLine { text, content })
}

fn any_answer() -> impl Strategy<Value = AlarmAnswer> {
    let answers = prop_oneof![
        Just(Answer::Acknowledged),
        (1..=SHELF_MAX.as_secs()).prop_map(Answer::Shelved),
        Just(Answer::Unshelved),
    ];
    let alarms = select(vec!["battery_low", "robot_silent", "unknown"]);
    (alarms, answers).prop_map(|(alarm, answer)| AlarmAnswer {
        alarm: alarm.to_owned(),
        answer,
        by: "pid 7".to_owned(),
    })
}

/// Any event, possible or not.
pub(crate) fn any_event() -> impl Strategy<Value = Event> {
    prop_oneof![
        8 => (any_body(), 0_u8..100, 0_u8..2).prop_map(|(body, sequence, boot)| {
            let ack = Ack { boot, ..Ack::default() };
            let line = Line { sequence, body, ack };
            Event::Line { line: Box::new(line), raw: line.encode() }
        }),
        1 => (any_body(), 0_u8..100).prop_map(|(body, sequence)| {
            let ack = Ack::default();
            Event::Repaired(Box::new(Line { sequence, body, ack }))
        }),
        3 => any_own_line().prop_map(Event::Own),
        1 => any_answer().prop_map(Event::AlarmAnswer),
        1 => (0_u8..100, 0_u8..8).prop_map(|(sequence, boot)| {
            Event::Ack(AckLine { sequence, ack: Ack { boot, ..Ack::default() }, listens: false })
        }),
        1 => any::<(u64, u64, u64)>().prop_map(|(lines, lines_lost, bytes)| {
            let (lines, lines_lost) = (lines >> 20, lines_lost >> 20);
            Event::Counters(Counters { lines, lines_lost, bytes, ..Counters::default() })
        }),
        1 => prop_oneof![
            Just(LinkEvent::Opened { name: "a long name of a far device".to_owned(), can_send: true }),
            Just(LinkEvent::Lost { reason: "it is gone".to_owned() }),
            Just(LinkEvent::Ended),
        ].prop_map(Event::Link),
        3 => (1_u32..6, any_status()).prop_map(|(id, status)| {
            Event::Command { id: CommandId(id), status }
        }),
        3 => (1_u32..6, any_request(), any::<Option<String>>()).prop_map(|(id, request, by)| {
            Event::Asked { id: CommandId(id), request, by }
        }),
        1 => any::<Option<String>>().prop_map(|problem| {
            Event::Recording(Recording { problem, tee: Some("a.txt".to_owned()), ..Recording::default() })
        }),
        1 => prop_oneof![
            Just(Reception::Lines),
            Just(Reception::Nothing),
            Just(Reception::Noise),
            Just(Reception::WrongRate(LineRate::Faster)),
        ].prop_map(|reception| Event::Reception { reception, since: Moment::from_secs(1) }),
        1 => any_waypoints().prop_map(|route| {
            Event::RouteLoaded { path: "r.txt".to_owned(), route: Ok(route) }
        }),
        1 => any::<[f64; 5]>().prop_map(|[a, b, c, d, radius_in]| {
            Event::Truth(Truth { walls: vec![[(a, b), (c, d)]], blocks: vec![[(a, c), (b, d)]], furniture: vec![[(b, c), (d, a)]], circles: vec![((c, b), radius_in)] })
        }),
        1 => any::<String>().prop_map(|text| Event::Notice(Notice::new(NoticeCode::Other, Level::Alarm, text))),
        8 => any_key().prop_map(Event::Key),
        1 => any::<String>().prop_map(Event::Paste),
        1 => any::<(u16, u16)>().prop_map(|(width, height)| Event::Resize { width, height }),
        1 => Just(Event::Tick),
    ]
}
