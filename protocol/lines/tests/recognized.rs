//! Recognition of lines of real programs, and of arbitrary bytes.

use groundwave_lines::{Content, FIELDS_MAX, OwnLine, Profile, Recognizer, Role, Value};
use proptest::prelude::*;

/// The lines of a text as words: `name=value unit`, `"text"` or `damaged`.
fn read(recognizer: &mut Recognizer, bytes: &[u8]) -> Vec<String> {
    bytes
        .split_inclusive(|byte| *byte == b'\n')
        .filter_map(|run| recognizer.take(run, false))
        .map(|line| words(&line))
        .collect()
}

fn words(line: &OwnLine) -> String {
    match &line.content {
        Content::Values(samples) => samples
            .iter()
            .map(|sample| {
                let unit = sample.field.unit.as_deref().unwrap_or_default();
                match &sample.value {
                    Value::Number(number) => format!("{}={number}{unit}", sample.field.name),
                    Value::Text(text) => format!("{}={text:?}", sample.field.name),
                }
            })
            .collect::<Vec<_>>()
            .join(" "),
        Content::Text => format!("{:?}", line.text),
        Content::Damaged => "damaged".to_owned(),
    }
}

fn guessed(text: &str) -> Vec<String> {
    read(&mut begun(), text.as_bytes())
}

/// A recognizer after the start of a line.
fn begun() -> Recognizer {
    let mut recognizer = Recognizer::default();
    recognizer.take(b"\n", false);
    recognizer
}

fn profile(text: &str) -> Recognizer {
    let profile: Profile = toml::from_str(text).expect("it is TOML");
    let mut recognizer = Recognizer::new(&profile).expect("it is right");
    recognizer.take(b"\n", false);
    recognizer
}

#[test]
fn pairs_are_recognized_at_once() {
    for (line, expected) in [
        ("temp:21.5,volt:11.9", "temp=21.5 volt=11.9"),
        ("temp=21.5 volt=11.9\r", "temp=21.5 volt=11.9"),
        (
            "Temperature: 21.5 C, Humidity: 40 %",
            "Temperature=21.5C Humidity=40%",
        ),
        ("motor speed: 3; left:-4.5e2", "motor speed=3 left=-450"),
        ("volt=11.9V\tmode=auto", "volt=11.9V mode=\"auto\""),
        ("temp: 21.5 C humidity: 40", "temp=21.5C humidity=40"),
        ("a: 1 b : 2", "a=1 b=2"),
        ("is_on:true,t:nan", "is_on=1"),
        (
            "{\"imu\":{\"yaw\":1.5,\"raw\":[1,2]},\"on\":true,\"mode\":\"auto\",\"x\":null}",
            "imu.raw.0=1 imu.raw.1=2 imu.yaw=1.5 mode=\"auto\" on=1",
        ),
    ] {
        assert_eq!(guessed(&format!("{line}\n")), [expected], "{line}");
    }
    for line in [
        "hello",
        "Error: no sensor",
        "12:30:05",
        "A00 04 +000.0",
        ":",
        "=",
        "x=",
        "1:2",
    ] {
        assert_eq!(
            guessed(&format!("{line}\n")),
            Vec::<String>::new(),
            "{line}"
        );
    }
}

/// Recognizes the examples in the README of <https://github.com/nesnes/teleplot>.
#[test]
fn teleplot_is_recognized() {
    let sent = ">myValue:1234\n>myValue:1627551892437:12.34e+2\n>speed:1234§km/h\n>motor_4_state:1627551892437:Off|t\n\
                >motor_4_state:Turned On|t\n>trajectory:12.3:45.67|xy\n>myValue:1627551892444:1;1627551892555:2§rad\n\
                >quiet:7|np\n>3D|cube:S:cube:P:1:1:1\n";
    let expected = [
        "myValue=1234",
        "myValue=1234",
        "speed=1234km/h",
        "motor_4_state=\"Off\"",
        "motor_4_state=\"Turned On\"",
        "trajectory.x=12.3 trajectory.y=45.67",
        "myValue=2",
        "quiet=7",
        "",
    ];
    assert_eq!(guessed(sent), expected);
    assert_eq!(
        read(&mut profile("form = \"teleplot\""), sent.as_bytes()),
        expected
    );
}

/// Recognizes the forms of `ArduinoSerialPlotterProtocol.md` in <https://github.com/arduino/Arduino>.
#[test]
fn the_arduino_plotter_is_recognized() {
    for (sent, expected) in [
        ("10\n11\n12\n", vec!["c1=11", "c1=12"]),
        ("1\t2\t\n3\t4\t\n", vec!["c1=3 c2=4"]),
        ("label0:\tlabel1:\n1\t2\n", vec!["label0=1 label1=2"]),
        ("var1:,var2:,var3:\n1,2,3\n", vec!["var1=1 var2=2 var3=3"]),
        (
            "Variable_1:512,Variable_2:500\n",
            vec!["Variable_1=512 Variable_2=500"],
        ),
        ("a:0.10, b:-1.00, c:2.00, \n", vec!["a=0.1 b=-1 c=2"]),
    ] {
        assert_eq!(guessed(sent), expected, "{sent:?}");
        let mut first_too = profile("form = \"arduino-plotter\"");
        assert_eq!(
            read(&mut first_too, sent.as_bytes()).last(),
            expected.last().map(|s| (*s).to_owned()).as_ref()
        );
    }
}

/// Recognizes columns as in the logger of <https://github.com/sparkfun/OpenLog_Artemis> and in spreadsheets.
#[test]
fn csv_is_recognized() {
    for (sent, expected) in [
        (
            "rtcDate,rtcTime,aX,aY\n01/02/2000,12:30:05.50,-12.5,996.1\n",
            vec!["rtcDate=\"01/02/2000\" rtcTime=\"12:30:05.50\" aX=-12.5 aY=996.1"],
        ),
        ("time (ms),temp [C]\n5,21.5\n", vec!["time=5ms temp=21.5C"]),
        ("1;2,5\n2;3,5\n", vec!["c1=2 c2=3.5"]),
        ("12:30:01,5\n12:30:02,6\n", vec!["c1=\"12:30:02\" c2=6"]),
        ("a,b\n1,2\n3,,\n", vec!["a=1 b=2", "a=3"]),
        ("name,v\n\"x, y\",4\n", vec!["name=\"x, y\" v=4"]),
    ] {
        assert_eq!(guessed(sent), expected, "{sent:?}");
    }
    let mut configured = profile(
        "form = \"csv\"\nfields = [{ name = \"x\", unit = \"cm\", role = \"x\" }, { name = \"batt\", unit = \"mV\", scale = 10, \
         offset = 5, role = \"battery\", limits = { low = 6800 } }]",
    );
    let lines = read(&mut configured, b"x,batt\n1.5,700\nbooting\n1,2,3\n");
    assert_eq!(lines, ["x=1.5cm batt=7005mV", "\"booting\"", "\"1,2,3\""]);
    let batt = configured
        .fields()
        .find(|field| field.name == "batt")
        .unwrap();
    assert!((batt.standard(7005.0) - 7.005).abs() < 1e-9);
}

/// Recognizes the example of Wikipedia's article "NMEA 0183", and a position 2 m further.
#[test]
fn a_gps_receiver_is_recognized() {
    let sent = "$GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,*76\r\n\
                $GPGSA,A,3,10,07,05,02,29,04,08,13,,,,,1.72,1.03,1.38*0A\r\n\
                $GPRMC,092751.000,A,5321.6812,N,00630.3372,W,0.06,31.66,280511,,,A*47\r\n\
                $GPRMC,092751.000,A,5321.6812,N,00630.3372,W,0.07,31.66,280511,,,A*47\r\n";
    let mut recognizer = Recognizer::default();
    let lines = read(&mut recognizer, sent.as_bytes());
    assert!(lines[0].starts_with("latitude=53.36"), "{lines:?}");
    assert!(
        lines[0].ends_with("x=0m y=0m altitude=61.7m satellites=8 hdop=1.03"),
        "{lines:?}"
    );
    assert_eq!(lines[1], "pdop=1.72 vdop=1.38");
    assert!(
        lines[2].contains("y=1.85") && lines[2].contains("speed=0.06"),
        "{lines:?}"
    );
    let role = |name: &str| {
        recognizer
            .fields()
            .find(|field| field.name == name)
            .unwrap()
            .role
    };
    assert_eq!(
        (role("x"), role("course")),
        (Some(Role::X), Some(Role::Heading))
    );
    let sentences = profile("form = \"nmea\"");
    let lines = read(&mut { sentences }, sent.as_bytes());
    assert!(
        lines[3].starts_with("\"$GPRMC"),
        "a wrong checksum is no value: {lines:?}"
    );
}

#[test]
fn patterns_and_checksums_follow_the_profile() {
    let mut pattern = profile("form = \"regex\"\npattern = '^T(?<temp>[-0-9.]+) (?<mode>\\w+)$'");
    assert_eq!(
        read(&mut pattern, b"T-4.5 auto\nT x\n"),
        ["temp=-4.5 mode=\"auto\"", "\"T x\""]
    );
    let mut sums = profile("form = \"pairs\"\nchecksum = \"xor\"");
    let sum = b"a:1".iter().fold(0, |sum, byte| sum ^ byte);
    let sent = format!("a:1*{sum:02X}\na:2*{sum:02X}\na:3\n");
    assert_eq!(
        read(&mut sums, sent.as_bytes()),
        ["a=1", "damaged", "damaged"]
    );
}

#[test]
fn mistakes_in_profiles_are_named() {
    for (text, expected) in [
        ("form = \"regex\"", "needs a pattern"),
        ("form = \"csv\"\npattern = 'x'", "goes with form"),
        ("form = \"regex\"\npattern = '(?<a'", "pattern: "),
        ("form = \"regex\"\npattern = 'a'", "no named group"),
        (
            "form = \"regex\"\npattern = '(?<a>\\w{1000}{1000})'",
            "size limit",
        ),
        (
            "form = \"regex\"\npattern = '(?<a>x)'\nfields = [{ name = \"b\" }]",
            "no group for field \"b\"",
        ),
        (
            "form = \"csv\"\nfields = [{ name = \"x\", role = \"x\" }]",
            "role x needs a unit: in, ft, mm, cm, m",
        ),
        (
            "form = \"csv\"\nfields = [{ name = \"x\", role = \"x\", unit = \"km\" }]",
            "unknown unit \"km\" for role x",
        ),
        (
            "form = \"csv\"\nfields = [{ name = \"x\" }, { name = \"x\" }]",
            "two fields are called \"x\"",
        ),
        (
            "form = \"csv\"\nfields = [{ name = \"x\", scale = 0 }]",
            "scale must be",
        ),
        (
            "form = \"csv\"\nfields = [{ name = \"x\", limits = { low = 3, high = 2 } }]",
            "is not below",
        ),
        (
            "form = \"csv\"\nfields = [{ name = \"\" }]",
            "needs 1 to 32",
        ),
    ] {
        let profile: Profile = toml::from_str(text).unwrap();
        let error = profile.check().expect_err(text).to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn lines_of_groundwave_end_the_guessing() {
    let mut recognizer = Recognizer::default();
    assert_eq!(recognizer.take(b"A00...\n", true), None);
    assert_eq!(
        read(&mut recognizer, b"temp:3\ntemp:4\n"),
        Vec::<String>::new()
    );
    let mut configured = profile("form = \"pairs\"");
    assert_eq!(configured.take(b"A00...\n", true), None);
    assert_eq!(read(&mut configured, b"temp:3\n"), ["temp=3"]);
}

#[test]
fn text_is_shown_once_it_is_clear_that_it_is_the_robots() {
    assert_eq!(
        guessed("one\ntwo\nthree\nfour\n"),
        ["\"three\"", "\"four\""]
    );
    assert_eq!(
        guessed("boot\ntemp:3\nlow battery\n\x07\n"),
        ["temp=3", "\"low battery\"", "damaged"]
    );
}

#[test]
fn a_line_without_its_start_names_no_field() {
    let mut recognizer = Recognizer::default();
    assert_eq!(read(&mut recognizer, b"mp:20\ntemp:21\n"), ["temp=21"]);
    recognizer.reopen();
    assert_eq!(
        read(&mut recognizer, b"temp:22\n"),
        ["temp=22"],
        "it is known"
    );
    recognizer.interrupt();
    assert_eq!(read(&mut recognizer, b"temp:2\ntemp:23\n"), ["temp=23"]);
    recognizer.reopen();
    assert_eq!(read(&mut recognizer, b"p:22\n{\"a\":1}\n"), ["a=1"]);
}

#[test]
fn memory_is_bounded() {
    let mut recognizer = begun();
    for n in 0..1000 {
        read(&mut recognizer, format!("n{n}:1\n").as_bytes());
    }
    assert_eq!(recognizer.fields().count(), FIELDS_MAX);
    assert_eq!(recognizer.left_out(), 1000 - FIELDS_MAX as u64);
    assert_eq!(
        read(&mut recognizer, &vec![b'a'; 100_000]),
        Vec::<String>::new()
    );
    assert_eq!(read(&mut recognizer, b"\nn0:2\n"), ["damaged", "n0=2"]);
}

/// Bytes that look like lines more often than by chance.
fn lines() -> impl Strategy<Value = Vec<u8>> {
    let part = prop_oneof![
        prop::sample::select(vec![
            "temp:", "=", ",", ";", "\t", " ", "\n", "\r\n", ">", "§", "|xy", "|t", "{\"a\":",
            "[1,", "}", "$GPGGA,", "$GPRMC,", "*", "1.5", "-", "1e309", "nan", "é", "\"", "0", ":",
            "A00",
        ])
        .prop_map(|text| text.as_bytes().to_vec()),
        prop::collection::vec(any::<u8>(), 0..6),
    ];
    prop::collection::vec(part, 0..80).prop_map(|parts| parts.concat())
}

proptest! {
    /// No bytes cause a panic, the result does not depend on how they are split, and all numbers are finite.
    #[test]
    fn any_bytes_are_taken(bytes in lines(), form in 0_usize..8, at in 0_usize..200) {
        let forms = ["auto", "csv", "pairs", "json", "regex", "nmea", "teleplot", "arduino-plotter"];
        let pattern = if form == 4 { "pattern = '(?<a>.*?)[,:](?<b>.*)'" } else { "" };
        let whole = profile(&format!("form = \"{}\"\n{pattern}", forms[form]));
        for mut recognizer in [whole, Recognizer::default()] {
            let mut split = recognizer.clone();
            let lines = read(&mut recognizer, &bytes);
            let at = at.min(bytes.len());
            let mut again = read(&mut split, &bytes[..at]);
            again.extend(read(&mut split, &bytes[at..]));
            prop_assert_eq!(&lines, &again);
            prop_assert!(recognizer.fields().count() <= FIELDS_MAX);
        }
    }

    /// No pattern causes a panic or hangs.
    #[test]
    fn any_pattern_is_taken_or_refused(pattern in "[a-z(?<>)*+{}0-9|.\\\\]{0,30}", line in "[a-z0-9]{0,200}") {
        let profile = Profile { form: groundwave_lines::Form::Regex, pattern: Some(pattern), ..Profile::default() };
        if let Ok(mut recognizer) = Recognizer::new(&profile) {
            read(&mut recognizer, format!("{line}\n").as_bytes());
        }
    }
}
