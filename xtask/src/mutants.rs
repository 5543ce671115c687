//! Breaks a copy of the protocol in one place at a time; a named test must then fail, for the right reason.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A single change.
struct Mutant {
    name: &'static str,
    /// Path below `protocol/src`.
    file: &'static str,
    /// Text to replace; must occur exactly once in the file.
    from: &'static str,
    to: &'static str,
    /// Module and function of the integration test.
    test: &'static str,
    /// Text that the failure must contain.
    finds: &'static str,
}

const ONCE: &str = "broken: each command executes at most once";
const EPOCH: &str = "broken: nothing of a stale epoch executes";
const WHOLE: &str = "broken: the active list is one that was sent, whole";
const SAME_LIFE: &str = "broken: a command reported as done was done in the same life";
const STOPPED: &str = "broken: nothing sent before a STOP executes after it";
const TAKEN: &str = " bits [";

const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "epoch off: the boot is not in the key",
        file: "command/mod.rs",
        from: "| (boot as u32 & 7) << 13",
        to: "| (boot as u32 & 0) << 13",
        test: "search::reboots",
        finds: EPOCH,
    },
    Mutant {
        name: "the session is not in the key",
        file: "command/mod.rs",
        from: "| (session as u32 & 7) << 10",
        to: "| (session as u32 & 0) << 10",
        test: "search::orders",
        finds: EPOCH,
    },
    Mutant {
        name: "a sequence of one bit",
        file: "arq/farm.rs",
        from: "command.sequence == (self.sequence + 1) & 0x3F",
        to: "command.sequence & 1 == (self.sequence + 1) & 1",
        test: "search::orders",
        finds: ONCE,
    },
    Mutant {
        name: "digest off: any staged list is activated",
        file: "arq/lists.rs",
        from: "if digest(self.bank(bank, count).iter()) != wanted {",
        to: "if digest(self.bank(bank, count).iter()) != wanted && false {",
        test: "search::two_stations_with_the_same_owner",
        finds: WHOLE,
    },
    Mutant {
        name: "STOP keeps the session",
        file: "arq/farm.rs",
        from: "self.begin_session(None);",
        to: "",
        test: "search::stop",
        finds: STOPPED,
    },
    Mutant {
        name: "late lines are taken for news",
        file: "arq/fop/late.rs",
        from: "ahead > AHEAD_MAX",
        to: "ahead > SEQUENCE_MODULUS",
        test: "search::orders",
        finds: SAME_LIFE,
    },
    Mutant {
        name: "a closed session confirms a STOP",
        file: "arq/fop/hearing.rs",
        from: "if ack.detail != (Detail::Stopped { receipt }) ||",
        to: "if ack.detail != (Detail::Stopped { receipt }) && !matches!(ack.detail, Detail::Idle { owner: 0, .. }) ||",
        test: "faults::a_restart_proves_no_stop",
        finds: "right: Stop",
    },
    Mutant {
        name: "the receipt of another operator confirms a STOP",
        file: "arq/fop/hearing.rs",
        from: "if ack.detail != (Detail::Stopped { receipt }) ||",
        to: "if !matches!((ack.detail, receipt), (Detail::Stopped { .. }, _)) ||",
        test: "search::stop_by_two_operators",
        finds: "broken: a confirmed STOP was taken after its request",
    },
    Mutant {
        name: "a request of another era opens a session",
        file: "arq/farm.rs",
        from: "open.era.is_none_or(|era| era == self.era)",
        to: "open.era.is_none_or(|_| true)",
        test: "replay::no_frame_of_a_day_executes_again",
        finds: "cycle ",
    },
    Mutant {
        name: "STOP begins anew at each press",
        file: "arq/fop.rs",
        from: "            stopping.is_renewed |= stopping.has_left;\n            return;\n",
        to: "            stopping.is_renewed |= stopping.has_left;\n",
        test: "faults::repeated_stops_do_not_delay_the_first",
        finds: "panicked",
    },
    Mutant {
        name: "CRC weakened: all but one term of its polynomial are gone",
        file: "crc.rs",
        from: "const POLYNOMIAL: u32 = 0x7B_01BD;",
        to: "const POLYNOMIAL: u32 = 0x00_0001;",
        test: "decoder::every_flip_of_one_or_two_bits_is_rejected",
        finds: TAKEN,
    },
    Mutant {
        name: "CRC weakened: one of its characters is not looked at",
        file: "telemetry/mod.rs",
        from: "checksum == crc::update(crc::DOWNLINK_INIT, content)",
        to: "(checksum ^ crc::update(crc::DOWNLINK_INIT, content)) & 0x3_FFFF == 0",
        test: "decoder::every_flip_of_one_or_two_bits_is_rejected",
        finds: TAKEN,
    },
];

pub(crate) fn check() -> Result<(), String> {
    let copy = super::root().join("target/mutants");
    fill(&copy)?;
    for test in tests() {
        let output = run(&copy, test)?;
        if !output.status.success() {
            return Err(format!("{test:?} fails unbroken:\n{}", text(&output)));
        }
    }
    for mutant in MUTANTS {
        let path = copy.join("protocol/src").join(mutant.file);
        let good = read(&path)?;
        let places = good.matches(mutant.from).count();
        if places != 1 {
            return Err(format!(
                "{}: `{}` occurs {places} times in protocol/src/{}, expected once; change it in \
                 xtask/src/mutants.rs",
                mutant.name, mutant.from, mutant.file
            ));
        }
        write(&path, &good.replacen(mutant.from, mutant.to, 1))?;
        let output = run(&copy, mutant.test);
        write(&path, &good)?;
        judge(mutant, &output?)?;
        println!("found: {}", mutant.name);
    }
    Ok(())
}

/// All tests of the table, without repetition.
fn tests() -> Vec<&'static str> {
    let mut tests: Vec<_> = MUTANTS.iter().map(|mutant| mutant.test).collect();
    tests.sort_unstable();
    tests.dedup();
    tests
}

fn judge(mutant: &Mutant, output: &Output) -> Result<(), String> {
    let (name, test) = (mutant.name, mutant.test);
    let said = text(output);
    if output.status.success() {
        Err(format!("{name}: {test} passes, expected a failure"))
    } else if said.contains(mutant.finds) {
        Ok(())
    } else {
        let wanted = mutant.finds;
        Err(format!(
            "{name}: {test} fails without saying `{wanted}`:\n{said}"
        ))
    }
}

/// Creates a separate workspace with the protocol. Built libraries are shared with the main workspace.
fn fill(copy: &Path) -> Result<(), String> {
    let root = super::root();
    let from = root.join("protocol");
    // Otherwise, old sources of an earlier run would be compiled.
    let to = copy.join("protocol");
    if to.exists() {
        fs::remove_dir_all(&to).map_err(|error| trouble("cannot remove", &to, &error))?;
    }
    fs::create_dir_all(&to).map_err(|error| trouble("cannot create", &to, &error))?;
    for part in [
        "Cargo.toml",
        "SPEC.md",
        "src",
        "tests",
        "examples",
        "vectors",
    ] {
        copy_all(&from.join(part), &to.join(part))?;
    }
    let manifest = read(&root.join("Cargo.toml"))?;
    let (_, workspace) = manifest
        .split_once("[workspace]")
        .ok_or("Cargo.toml has no [workspace]")?;
    let (workspace, package) = workspace
        .split_once("[package]")
        .ok_or("Cargo.toml has no [package]")?;
    let profiles = package
        .split_once("[profile.")
        .map_or("", |(_, profiles)| profiles);
    let lines = workspace.lines().filter(|line| {
        // Entries about members that are not copied.
        !["members", "exclude", "groundwave-", "sr04-"]
            .iter()
            .any(|word| line.starts_with(word))
    });
    let workspace: Vec<&str> = lines.collect();
    let manifest = format!(
        "[workspace]\nmembers = [\"protocol\"]\n{}\n[profile.{profiles}",
        workspace.join("\n")
    );
    write(&copy.join("Cargo.toml"), &manifest)?;
    copy_all(&root.join("Cargo.lock"), &copy.join("Cargo.lock"))
}

/// Copies a file or a folder with all it contains.
pub(crate) fn copy_all(from: &Path, to: &Path) -> Result<(), String> {
    if from.is_dir() {
        fs::create_dir_all(to).map_err(|error| trouble("cannot create", to, &error))?;
        let entries = fs::read_dir(from).map_err(|error| trouble("cannot list", from, &error))?;
        for entry in entries {
            let entry = entry.map_err(|error| trouble("cannot list", from, &error))?;
            copy_all(&entry.path(), &to.join(entry.file_name()))?;
        }
        Ok(())
    } else {
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder).map_err(|error| trouble("cannot create", folder, &error))?;
        }
        fs::copy(from, to)
            .map(|_| ())
            .map_err(|error| trouble("cannot copy", from, &error))
    }
}

fn run(copy: &Path, test: &str) -> Result<Output, String> {
    let mut command = Command::new(super::cargo_path());
    command
        .args([
            "test",
            "--offline",
            "-p",
            "groundwave-protocol",
            "--test",
            "protocol",
            "--",
            "--exact",
            test,
        ])
        .current_dir(copy)
        .env("CARGO_TARGET_DIR", super::root().join("target"))
        .env("RUST_BACKTRACE", "0");
    command
        .output()
        .map_err(|error| format!("cannot start {command:?}: {error}"))
}

fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr]
        .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
        .concat()
}

fn read(path: &PathBuf) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| trouble("cannot read", path, &error))
}

fn write(path: &Path, content: &str) -> Result<(), String> {
    fs::write(path, content).map_err(|error| trouble("cannot write", path, &error))
}

fn trouble(what: &str, path: &Path, error: &std::io::Error) -> String {
    format!("{what} {}: {error}", path.display())
}
