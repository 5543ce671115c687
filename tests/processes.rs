//! The program as users run it: processes, pseudo-terminals, signals and exit codes.
#![cfg(unix)]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::programs::{GROUNDWAVE, Running, Sim, Telling, expect, groundwave, scratch};
use crate::pty::OnTerminal;
use crate::streams;

#[test]
fn cat_sees_a_robot() {
    let sim = Sim::start(&[]);
    let mut cat = Command::new("cat")
        .arg(&sim.path)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(cat.stdout.take().unwrap()).lines();
    // The first line may be partial; the second is whole.
    let _ = lines.next();
    let line = lines.next().unwrap().unwrap();
    assert_eq!(line.trim_end_matches('\r').len(), 78, "{line}");
    cat.kill().unwrap();
    cat.wait().unwrap();
}

#[test]
fn commands_are_proven_or_refused_with_the_right_code() {
    let sim = Sim::start(&["--seed", "5"]);
    let (out, _) = expect(0, &["send", &sim.path, "mode", "reactive"]);
    assert!(out.starts_with("mode reactive: confirmed after"), "{out}");
    let (_, err) = expect(5, &["send", &sim.path, "param", "get", "warp-speed"]);
    assert!(err.contains("refused `param get warp-speed`"), "{err}");
    let (out, _) = expect(0, &["send", &sim.path, "goto", "-48", "12", "--json"]);
    assert!(
        out.lines()
            .last()
            .unwrap()
            .contains("\"status\":\"confirmed\""),
        "{out}"
    );
    let (out, _) = expect(0, &["send", &sim.path, "stop"]);
    assert!(out.starts_with("stop: confirmed after"), "{out}");
}

#[test]
fn wait_opens_a_port_as_soon_as_it_is_there() {
    let folder = scratch("wait-for-port");
    let port = folder.join("robot");
    let sim = Sim::start(&[]);
    let mut send = Command::new(GROUNDWAVE)
        .args(["send", port.to_str().unwrap(), "stop", "--wait"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = String::new();
    BufReader::new(send.stderr.take().unwrap())
        .read_line(&mut told)
        .unwrap();
    assert!(
        told.contains("waiting for") && told.contains("not there yet"),
        "{told}"
    );
    std::os::unix::fs::symlink(&sim.path, &port).unwrap();
    let ended = send.wait_with_output().unwrap();
    let out = String::from_utf8(ended.stdout).unwrap();
    assert!(ended.status.success(), "{out}");
    assert!(out.starts_with("stop: confirmed after"), "{out}");
}

#[test]
fn wait_ends_with_its_limit_and_at_once_for_a_file_that_is_not_a_port() {
    for verb in ["record", "check", "watch"] {
        let headless = if verb == "watch" {
            &["--headless"][..]
        } else {
            &[]
        };
        let words = [&[verb, "/dev/nowhere", "--wait=1ms"], headless].concat();
        let (_, err) = expect(4, &words);
        assert!(err.contains("no such device"), "{verb}: {err}");
    }
    let folder = scratch("wait-for-file");
    let file = folder.join("notes.txt");
    fs::write(&file, "no port\n").unwrap();
    let (_, err) = expect(4, &["send", file.to_str().unwrap(), "stop", "--wait"]);
    assert!(err.contains("not a serial device"), "{err}");
    expect(2, &["send", "--via", "/tmp/no.sock", "stop", "--wait"]);
}

#[test]
fn bad_input_is_refused_before_the_link_is_touched() {
    let folder = scratch("bad-input");
    let route = folder.join("route.txt");
    fs::write(&route, "1,2\n3,four\n").unwrap();
    let (_, err) = expect(
        2,
        &["send", "/dev/nowhere", "route", route.to_str().unwrap()],
    );
    assert!(err.contains("route.txt:2:3: `four`"), "{err}");
    let (_, err) = expect(2, &["send", "/dev/nowhere", "fly"]);
    assert!(err.contains("unknown command `fly`"), "{err}");
    expect(2, &["send", "/dev/nowhere"]);
    expect(6, &["send", "-", "stop"]);
    expect(6, &["send", "/dev/nowhere", "stop", "--no-uplink"]);
    let (_, err) = expect(4, &["send", "/dev/nowhere", "stop"]);
    assert!(
        err.contains("no such device") && err.contains("groundwave ports"),
        "{err}"
    );
    let (_, err) = expect(2, &["sim", "--world", "atlantis"]);
    assert!(err.contains("atlantis"), "{err}");
    let (_, err) = expect(2, &["sim", "--channel", "ber=2"]);
    assert!(err.contains("ber"), "{err}");
}

#[test]
fn a_silent_port_is_not_confirmed() {
    // The other side of this pipe is never opened.
    let sim = Sim::start(&["--channel", "out=0s..10000s"]);
    let (_, err) = expect(3, &["send", &sim.path, "mode", "prowl", "--timeout", "1s"]);
    assert!(
        err.contains("not confirmed within 1.0 s") && err.contains("nothing was received"),
        "{err}"
    );
}

#[test]
fn a_script_stops_at_the_first_command_that_fails() {
    let folder = scratch("script");
    let sim = Sim::start(&[]);
    let script = folder.join("evening.txt");
    fs::write(
        &script,
        "mode reactive # sit still\n\nparam get warp-speed\nmode prowl\n",
    )
    .unwrap();
    let output = groundwave(&["send", &sim.path, "-f", script.to_str().unwrap()]);
    let out = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(5), "{out}");
    assert!(
        out.contains("mode reactive: confirmed") && !out.contains("mode prowl"),
        "{out}"
    );
}

#[test]
fn the_dashboard_obeys_keys_and_restores_the_terminal() {
    let sim = Sim::start(&["--seed", "2"]);
    let mut watch = OnTerminal::start(GROUNDWAVE, &["watch", &sim.path], 120, 40);
    watch.wait_for("the motors' holder in words", |text| {
        text.contains("the motors: ")
    });
    assert!(watch.is_alternate());
    watch.type_keys(" ");
    watch.wait_for("STOP in the ledger and confirmed", |text| {
        text.lines()
            .any(|line| line.contains("stop") && line.contains("confirmed"))
    });
    watch.type_keys("mp");
    watch.wait_for("prowl acknowledged", |text| {
        text.lines()
            .any(|line| line.contains("mode prowl") && line.contains("confirmed"))
    });
    watch.resize(80, 24);
    watch.wait_for("a small screen", |text| {
        text.lines().count() <= 24 && text.contains("newest <1 s")
    });
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
    assert!(!watch.is_alternate());
}

#[test]
fn a_robot_that_goes_and_comes_back_needs_no_key() {
    let folder = scratch("back");
    let link = folder.join("radio");
    let link = link.to_str().unwrap();
    let sim = Sim::start(&["--pty", link]);
    let mut watch = OnTerminal::start(GROUNDWAVE, &["watch", link], 120, 40);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    sim.end();
    watch.wait_for("the loss", |text| text.to_lowercase().contains("lost"));
    let _sim = Sim::start(&["--pty", link]);
    watch.wait_for("lines again, and that it is another life", |text| {
        let status = text.lines().next().unwrap_or_default();
        status.contains("newest <1 s") && text.contains("the robot restarted")
    });
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
}

/// The boot counter in every line repeats after eight boots, so a killed simulator must save its count.
#[test]
fn a_robot_behind_a_steady_name_counts_its_boots() {
    let folder = scratch("boots");
    let link = folder.join("radio");
    for _ in 0..3 {
        drop(Sim::start(&["--pty", link.to_str().unwrap()]));
    }
    let remembered = fs::read_to_string(folder.join(".radio.eeprom")).unwrap();
    assert_eq!(remembered, "boots=3\n");
}

/// Nothing is ever written to this pipe; a read would block forever.
#[test]
fn a_route_from_a_pipe_that_is_silent_stops_nothing() {
    let folder = scratch("silent");
    let pipe = folder.join("pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let mut watch = OnTerminal::start(GROUNDWAVE, &["watch", "sim"], 120, 40);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    watch.type_keys(&format!("r{}\r", pipe.display()));
    watch.wait_for("what is wrong", |text| text.contains("choose a file"));
    // The prompt stays so that the name can be corrected; in it, STOP is Ctrl-S.
    watch.type_keys("\x13");
    watch.wait_for("STOP", |text| text.contains("stop: confirmed"));
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
}

#[test]
fn a_port_in_use_is_called_busy() {
    let sim = Sim::start(&[]);
    let mut watch = OnTerminal::start(GROUNDWAVE, &["watch", &sim.path], 80, 24);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    let (_, err) = expect(4, &["send", &sim.path, "stop"]);
    assert!(
        err.contains("busy") && err.contains("another program holds it"),
        "{err}"
    );
}

#[test]
fn a_signal_ends_the_dashboard_in_good_order() {
    let folder = scratch("signal");
    let sim = Sim::start(&[]);
    let capture = folder.join("run.mcap");
    let arguments = ["watch", &sim.path, "--record", capture.to_str().unwrap()];
    let mut watch = OnTerminal::start(GROUNDWAVE, &arguments, 80, 24);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    let pid = watch.child.process_id().unwrap();
    assert!(
        Command::new("kill")
            .arg(pid.to_string())
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(watch.wait(), 0);
    assert!(!watch.is_alternate());
    let (info, _) = expect(0, &["info", capture.to_str().unwrap()]);
    assert!(info.contains("lines"), "{info}");
}

/// The child process of the next test: sets up the terminal and panics.
#[test]
fn panics_on_a_terminal_when_asked() {
    if std::env::var_os("GROUNDWAVE_TEST_PANIC").is_some() {
        let _screen = groundwave::io::terminal::Screen::take(false).unwrap();
        panic!("this is the panic that was asked for");
    }
}

#[test]
fn a_panic_restores_the_terminal_and_shows_its_message() {
    let me = std::env::current_exe().unwrap();
    let arguments = [
        "GROUNDWAVE_TEST_PANIC=1",
        me.to_str().unwrap(),
        "--exact",
        "processes::panics_on_a_terminal_when_asked",
        "--nocapture",
    ];
    let mut child = OnTerminal::start("env", &arguments, 100, 30);
    assert_ne!(child.wait(), 0);
    assert!(!child.is_alternate());
    assert!(
        child
            .text()
            .contains("this is the panic that was asked for"),
        "{}",
        child.text()
    );
}

#[test]
fn recordings_hold_every_byte_and_refuse_to_be_overwritten() {
    let folder = scratch("record");
    let raw = folder.join("raw.txt");
    let raw = raw.to_str().unwrap();
    let sim = Sim::start(&[
        "--listen",
        "127.0.0.1:0",
        "--time-factor",
        "20",
        "--channel",
        "ber=1e-3",
    ]);
    expect(
        0,
        &[
            "record",
            &sim.path,
            "-o",
            raw,
            "--duration",
            "2s",
            "--quiet",
        ],
    );
    let bytes = fs::read(raw).unwrap();
    assert!(bytes.len() > 1000, "{}", bytes.len());
    let (_, err) = expect(2, &["record", &sim.path, "-o", raw, "--duration", "1s"]);
    assert!(err.contains("exists") && err.contains("--force"), "{err}");
    assert_eq!(fs::read(raw).unwrap(), bytes);
    let (jsonl, _) = expect(0, &["export", "-o", "-", raw, "--to", "jsonl"]);
    assert!(jsonl.lines().count() > 10, "{jsonl}");
    let (csv, _) = expect(0, &["export", "-o", "-", raw, "--to", "csv"]);
    assert_eq!(csv.lines().count(), jsonl.lines().count() + 1);
}

#[test]
fn a_reader_that_stops_early_is_not_an_error() {
    let folder = scratch("pipe");
    let raw = folder.join("raw.txt");
    let sim = Sim::start(&["--listen", "127.0.0.1:0", "--time-factor", "100"]);
    expect(
        0,
        &[
            "record",
            &sim.path,
            "-o",
            raw.to_str().unwrap(),
            "--duration",
            "2s",
            "--quiet",
        ],
    );
    let mut decode = Command::new(GROUNDWAVE)
        .args(["export", "-o", "-", raw.to_str().unwrap(), "--to", "jsonl"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0; 1];
    decode
        .stdout
        .take()
        .unwrap()
        .read_exact(&mut first)
        .unwrap();
    let output = decode.wait_with_output().unwrap();
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn headless_watch_speaks_json() {
    let sim = Sim::start(&[]);
    let mut watch = Command::new(GROUNDWAVE)
        .args(["watch", &sim.path, "--headless", "--no-uplink"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(watch.stdout.take().unwrap()).lines();
    let mut kinds = Vec::new();
    for line in lines.take(4) {
        let value: serde_json::Value = serde_json::from_str(&line.unwrap()).unwrap();
        kinds.push(value["event"].as_str().unwrap().to_owned());
    }
    assert_eq!(kinds[0], "link");
    assert!(kinds.contains(&"line".to_owned()), "{kinds:?}");
    watch.kill().unwrap();
    watch.wait().unwrap();
}

/// A hook that neither reads nor ends, and keeps starting processes, delays neither the lines nor the end.
#[cfg(unix)]
#[test]
fn an_endless_alarm_hook_does_not_delay_the_link() {
    let folder = scratch("endless-hook");
    let (config, marker) = (folder.join("config.toml"), folder.join("begun"));
    // It ends with the marker, so that the test leaves nothing behind.
    let text = format!(
        "[limits]\nbattery_low_dv = 250\nbattery_for_s = 0\n[alarms]\nrun = \"M={}; echo > $M; while test -e $M; do sleep 1 & sleep 0.05; done\"\n",
        marker.display()
    );
    fs::write(&config, text).unwrap();
    let config = config.to_str().unwrap();
    let mut watch = Telling::start(&["--config", config, "watch", "sim", "--headless"]);
    let is_line = |event: &serde_json::Value| event["event"] == "line";
    watch.wait_for("a line with the hook under way", |event| {
        is_line(event) && marker.exists()
    });
    for _ in 0..20 {
        watch.wait_for_new("a line", is_line);
    }
    let failed = |event: &serde_json::Value| event["code"] == "alarm-hook";
    assert!(!watch.said.iter().any(failed), "{:?}", watch.said);
    let pid = watch.process.0.id().to_string();
    let signal = Command::new("kill").args(["-INT", &pid]).status().unwrap();
    assert!(signal.success() && watch.process.0.wait().unwrap().success());
    fs::remove_dir_all(folder).unwrap();
}

/// The command gets each event of an alarm, and its failure is reported.
#[cfg(unix)]
#[test]
fn the_alarm_hook_gets_each_event() {
    let folder = scratch("alarm-hook");
    let (config, told) = (folder.join("config.toml"), folder.join("told.json"));
    let text = format!(
        "[limits]\nbattery_low_dv = 250\nbattery_for_s = 0\n[alarms]\nrun = \"cat >> {} && false\"\n",
        told.display()
    );
    fs::write(&config, text).unwrap();
    let sim = Sim::start(&[]);
    let config = config.to_str().unwrap();
    let mut watch = Telling::start(&["--config", config, "watch", &sim.path, "--headless"]);
    watch.wait_for("the failure", |event| event["code"] == "alarm-hook");
    let told = fs::read_to_string(&told).unwrap();
    let event: serde_json::Value = serde_json::from_str(told.lines().next().unwrap()).unwrap();
    assert_eq!(event["code"], "battery_low", "{event}");
    assert_eq!(event["status"], "begun");
    assert_eq!(event["limit"], 25.0);
    assert_eq!(event["link"], *sim.path);
    assert!(event["time"].as_str().unwrap().ends_with('Z'), "{event}");
    // Both are UTC in the same form.
    let (begin, time) = (event["begin"].as_str().unwrap(), &event["time"]);
    assert!(begin <= time.as_str().unwrap(), "{event}");
}

#[test]
fn headless_watch_reports_alarms() {
    let config = scratch("headless-alarms").join("config.toml");
    fs::write(
        &config,
        "[limits]\nbattery_low_dv = 250\nbattery_for_s = 0\n",
    )
    .unwrap();
    let sim = Sim::start(&[]);
    let config = config.to_str().unwrap();
    let mut watch = Telling::start(&["--config", config, "watch", &sim.path, "--headless"]);
    let low = watch.wait_for("the low battery", |event| event["code"] == "battery_low");
    assert_eq!(low["event"], "alarm");
    assert_eq!(low["status"], "begun");
    assert_eq!(low["severity"], "alarm");
    assert_eq!((&low["limit"], &low["unit"]), (&25.0.into(), &"V".into()));
    assert!(low["value"].as_f64().unwrap() < 25.0, "{low}");
    sim.end();
    let lost = watch.wait_for("the lost link", |event| event["code"] == "link_lost");
    assert_eq!(lost["status"], "begun");
    assert_eq!(lost["value"], serde_json::Value::Null);
}

#[test]
fn a_capture_plays_in_the_dashboard_to_its_end() {
    for capture in ["captures/house-clean.txt", "captures/demo-commands.mcap"] {
        let mut replay =
            OnTerminal::start(GROUNDWAVE, &["replay", capture, "--speed", "100"], 120, 40);
        replay.wait_for("the robot", |text| text.contains("the motors: "));
        replay.wait_for("the end", |text| text.contains("session ended"));
        replay.type_keys("q");
        assert_eq!(replay.wait(), 0, "{capture}");
    }
}

/// The station continues to read its link, and a signal ends it.
#[test]
fn an_unread_standard_output_stalls_only_the_printing() {
    let folder = scratch("unread");
    let path = folder.join("link");
    let listener = UnixListener::bind(&path).unwrap();
    let watch = Command::new(GROUNDWAVE)
        .args(["watch", &format!("unix:{}", path.display()), "--headless"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut watch = Running(watch);
    let (mut link, _) = listener.accept().unwrap();
    link.set_write_timeout(Some(Duration::from_mins(1)))
        .unwrap();
    // More than all pipes and queues on the way hold.
    for _ in 0..300 {
        link.write_all(&streams::clean(100)).unwrap();
    }
    let pid = watch.0.id().to_string();
    let sent = Command::new("kill").args(["-TERM", &pid]).status().unwrap();
    assert!(sent.success());
    let mut said = String::new();
    let stderr = watch.0.stderr.take();
    stderr.unwrap().read_to_string(&mut said).unwrap();
    assert!(said.contains("lines not printed"), "{said}");
    assert_eq!(watch.0.wait().unwrap().code(), Some(0));
}

/// A pipe without a reader delays the end; another signal ends the wait.
#[test]
fn a_second_signal_does_not_wait_for_a_recording() {
    for signal in ["-INT", "-TERM"] {
        let folder = scratch("second-signal");
        let (path, fifo) = (folder.join("link"), folder.join("fifo"));
        let made = Command::new("mkfifo").arg(&fifo).status().unwrap();
        assert!(made.success());
        let held = fs::File::options().read(true).write(true).open(&fifo);
        let _held = held.unwrap();
        let listener = UnixListener::bind(&path).unwrap();
        let link = format!("unix:{}", path.display());
        let record = Command::new(GROUNDWAVE)
            .args(["record", &link, "--append", "-o"])
            .arg(&fifo)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut record = Running(record);
        let (mut link, _) = listener.accept().unwrap();
        link.set_write_timeout(Some(Duration::from_mins(1)))
            .unwrap();
        for _ in 0..300 {
            link.write_all(&streams::clean(100)).unwrap();
        }
        let pid = record.0.id().to_string();
        while record.0.try_wait().unwrap().is_none() {
            let _ = Command::new("kill").args([signal, &pid]).status();
        }
        let mut said = String::new();
        let stderr = record.0.stderr.take();
        stderr.unwrap().read_to_string(&mut said).unwrap();
        assert!(
            said.contains("left before the recording was finished"),
            "{signal}: {said}"
        );
    }
}

#[test]
fn a_pipe_can_be_watched_and_is_never_written_to() {
    let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures/house-clean.txt");
    let shell = format!(
        "cat {} | {GROUNDWAVE} watch - --headless | tail -n 1",
        capture.display()
    );
    let output = Command::new("sh").args(["-c", &shell]).output().unwrap();
    let last: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(last["state"], "ended", "{last}");
}

/// This terminal answers no queries; the dashboard must send none.
#[test]
fn a_suspended_dashboard_comes_back() {
    let sim = Sim::start(&[]);
    let mut watch = OnTerminal::start(GROUNDWAVE, &["watch", &sim.path], 100, 30);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    watch.type_keys("\x1a");
    watch.wait_for_terminal("the terminal given back", |screen| {
        !screen.alternate_screen()
    });
    watch.wait_until_stopped();
    let pid = watch.child.process_id().unwrap().to_string();
    let resume = Command::new("kill").args(["-CONT", &pid]).status().unwrap();
    assert!(resume.success());
    watch.wait_for_terminal("the dashboard again", |screen| {
        screen.alternate_screen() && screen.contents().contains("newest <1 s")
    });
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
}

/// A closed ssh session: the terminal no longer exists, and the recording is finished.
#[test]
fn a_closed_terminal_finishes_the_recording() {
    let folder = scratch("closed");
    let sim = Sim::start(&[]);
    let capture = folder.join("run.mcap");
    let arguments = ["watch", &sim.path, "--record", capture.to_str().unwrap()];
    let mut watch = OnTerminal::start(GROUNDWAVE, &arguments, 80, 24);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    assert_eq!(watch.close(), 0, "nobody is left to read an error");
    assert!(
        capture.exists(),
        "{:?}",
        fs::read_dir(&folder).unwrap().collect::<Vec<_>>()
    );
    expect(0, &["info", capture.to_str().unwrap()]);
}

/// A recording of the demo contains the configuration, like a robot's recording.
#[test]
fn a_demo_is_recorded_as_it_is_configured() {
    let folder = scratch("demo-configured");
    let config = folder.join("config.toml");
    let text = "[recording]\nrotate = \"90m\"\n";
    fs::write(&config, text).unwrap();
    let recording = folder.join("evening.mcap");
    let [config, name] = [&config, &recording].map(|path| path.to_str().unwrap());
    let arguments = ["--config", config, "demo", "--record", name];
    let mut demo = OnTerminal::start(GROUNDWAVE, &arguments, 120, 40);
    demo.wait_for("the robot", |text| text.contains("newest <1 s"));
    demo.type_keys("q");
    assert_eq!(demo.wait(), 0);
    let bytes = fs::read(&recording).unwrap();
    let holds = |wanted: &str| {
        bytes
            .windows(wanted.len())
            .any(|part| part == wanted.as_bytes())
    };
    assert!(holds(text), "the configuration is attached");
}
