//! The program of an Arduino Mega 2560: built, written as a hex file, flashed.
//!
//! Needs what the checks of `avr` need, and avrdude to flash.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::mutants::copy_all;
use crate::{avr, capture, debian, root, run};

/// What the board's program is built from.
const SOURCES: [&str; 11] = [
    "Cargo.toml",
    "protocol/Cargo.toml",
    "protocol/src",
    "firmware/Cargo.toml",
    "firmware/src",
    "firmware/replay",
    "firmware/boards/probe/src",
    "firmware/boards/mega2560/src",
    "firmware/boards/mega2560/.cargo",
    "firmware/boards/mega2560/Cargo.toml",
    "firmware/boards/mega2560/Cargo.lock",
];

/// Builds the board's program with options, checks it and keeps it under a name.
pub(crate) fn build(name: &str, options: &[&str]) -> Result<PathBuf, String> {
    let board = root().join("firmware/boards/mega2560");
    debian::build_with(&board, options, &debian::boards())?;
    keep(&debian::boards(), name)
}

fn keep(target: &Path, name: &str) -> Result<PathBuf, String> {
    let built = target.join("avr-none/release/mega2560.elf");
    avr::check_program(&built)?;
    let kept = folder()?.join(format!("{name}.elf"));
    fs::copy(&built, &kept).map_err(|error| format!("{}: {error}", kept.display()))?;
    Ok(kept)
}

fn folder() -> Result<PathBuf, String> {
    let folder = root().join("target/mega2560");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(folder)
}

/// Address of the function that a panic calls, in hexadecimal.
pub(crate) fn panic_address(elf: &Path) -> Result<String, String> {
    let symbols = capture(Command::new("avr-nm").arg(elf))?;
    symbols
        .lines()
        .find(|line| line.ends_with("rust_begin_unwind"))
        .and_then(|line| line.split(' ').next())
        .map(str::to_owned)
        .ok_or_else(|| format!("{} has no panic handler", elf.display()))
}

fn write_hex(elf: &Path, name: &str) -> Result<PathBuf, String> {
    let hex = folder()?.join(format!("{name}.hex"));
    run(Command::new("avr-objcopy")
        .args(["-O", "ihex", "-R", ".eeprom"])
        .args([elf, &hex]))?;
    Ok(hex)
}

/// Builds the program with options and writes its hex file.
pub(crate) fn build_hex(options: &[&str]) -> Result<PathBuf, String> {
    write_hex(&build("robot", options)?, "robot")
}

/// Writes the hex file of a program that is built twice from nothing, in a copy in another folder and here: both must
/// be equal, with the names of their symbols, since an order may follow from those.
pub(crate) fn hex() -> Result<(), String> {
    let elsewhere = root().join("target/mega2560/elsewhere");
    // The first time there is none.
    let _ = fs::remove_dir_all(&elsewhere);
    for source in SOURCES {
        copy_all(&root().join(source), &elsewhere.join(source))?;
    }
    let build = |folder: &Path, name| {
        let board = folder.join("firmware/boards/mega2560");
        let _ = fs::remove_dir_all(board.join("target-hex"));
        debian::build_with(&board, &[], Path::new("target-hex"))?;
        keep(&board.join("target-hex"), name)
    };
    let copied = build(&elsewhere, "elsewhere")?;
    let robot = build(&root(), "robot")?;
    println!("{}", write_hex(&robot, "robot")?.display());
    let read = |elf: &Path| fs::read(elf).map_err(|error| format!("{}: {error}", elf.display()));
    if read(&copied)? == read(&robot)? {
        Ok(())
    } else {
        Err(format!(
            "the program depends on the folder where it is built: {} and {} differ",
            copied.display(),
            robot.display()
        ))
    }
}

/// Builds the program and writes it to a board: `mega2560 PORT [FEATURES]`.
pub(crate) fn flash(arguments: &[String]) -> Result<(), String> {
    let usage = "usage: cargo xtask flash mega2560 PORT [FEATURE,FEATURE,...]";
    let (port, features) = match arguments {
        [board, port] if board == "mega2560" => (port, None),
        [board, port, features] if board == "mega2560" => (port, Some(features.as_str())),
        _ => return Err(usage.to_owned()),
    };
    check_port(port)?;
    let known = known_features()?;
    for feature in features.into_iter().flat_map(|list| list.split(',')) {
        if !known.iter().any(|name| name == feature) {
            return Err(format!(
                "the Mega has no feature {feature:?}, only {}",
                known.join(", ")
            ));
        }
    }
    // Without a device, avrdude only tells its options.
    Command::new("avrdude").output().map_err(|error| {
        format!(
            "cannot start avrdude: {error}. Install it (`apt install avrdude`, `brew install avrdude`; on Windows add its folder in the Arduino IDE to PATH), then try again"
        )
    })?;
    let options = features.map(|features| ["--no-default-features", "--features", features]);
    let hex = build_hex(options.as_ref().map_or(&[], |options| &options[..]))?;
    let programmed = run(Command::new("avrdude")
        .args([
            "-p", "m2560", "-c", "wiring", "-b", "115200", "-D", "-P", port, "-U",
        ])
        .arg(format!("flash:w:{}:i", hex.display())));
    programmed.map_err(|error| {
        format!("{error}. Check that {port} is the Mega's USB port, and close other programs that hold it")
    })
}

/// Names in the board's `[features]`.
fn known_features() -> Result<Vec<String>, String> {
    let path = root().join("firmware/boards/mega2560/Cargo.toml");
    let manifest =
        fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let names = manifest
        .lines()
        .skip_while(|line| *line != "[features]")
        .skip(1)
        .take_while(|line| !line.starts_with('['))
        .filter_map(|line| line.split_once(" = "))
        .map(|(name, _)| name.to_owned())
        .filter(|name| name != "default");
    Ok(names.collect())
}

/// Outside Unix, ports are not files: there avrdude finds out.
fn check_port(port: &str) -> Result<(), String> {
    if cfg!(unix) && !Path::new(port).exists() {
        return Err(format!(
            "cannot flash {port}: there is no such port. Plug the Mega's USB in; `groundwave ports` lists the ports"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn flashing_an_unknown_part_names_those_that_there_are() {
        let arguments = ["mega2560", "/dev/null", "sonar,wheels"].map(str::to_owned);
        let error = flash(&arguments).unwrap_err();
        assert_eq!(
            error,
            "the Mega has no feature \"wheels\", only bumpers, infrared, sonar, photocells, edges, motion, beacon, lcd, \
             half-duplex"
        );
    }

    #[test]
    #[cfg(unix)]
    fn flashing_a_missing_board_says_what_to_do() {
        let arguments = ["mega2560", "/dev/no-such-port"].map(str::to_owned);
        let error = flash(&arguments).unwrap_err();
        assert!(
            error.contains("/dev/no-such-port") && error.contains("Plug"),
            "{error}"
        );
    }
}
