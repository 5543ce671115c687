//! Makes the files of a release: archives and Debian packages with the program, its manual pages and completions, the
//! Arduino Mega's program, and their checksums.
//!
//! Needs the tools of the steps `avr`, `linux` and `windows`, and `zip`, `dpkg-deb`; the check also needs `debootstrap` and root. Times, order
//! and owners are fixed and paths of this machine are removed, so that two runs of one commit give the same bytes.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cross::{self, ARM, WINDOWS, X86};
use crate::{capture, licences, mega, root, run};

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Targets, and Debian's names of their architectures.
const TARGETS: [(&str, Option<&str>); 3] =
    [(X86, Some("amd64")), (ARM, Some("arm64")), (WINDOWS, None)];

/// The Arduino Mega's programs, each with its build options.
const MEGA_PROGRAMS: [(&str, &[&str]); 2] = [
    ("mega2560.hex", &[]),
    ("mega2560-half-duplex.hex", &["--features", "half-duplex"]),
];

/// Places of the parts in a Debian package.
const PLACES: [(&str, &str); 8] = [
    ("groundwave", "usr/bin/groundwave"),
    ("man", "usr/share/man/man1"),
    (
        "completions/groundwave.bash",
        "usr/share/bash-completion/completions/groundwave",
    ),
    (
        "completions/groundwave.zsh",
        "usr/share/zsh/vendor-completions/_groundwave",
    ),
    (
        "completions/groundwave.fish",
        "usr/share/fish/vendor_completions.d/groundwave.fish",
    ),
    (
        "60-groundwave.rules",
        "usr/lib/udev/rules.d/60-groundwave.rules",
    ),
    (
        "groundwave@.service",
        "usr/lib/systemd/user/groundwave@.service",
    ),
    ("LICENSES", "usr/share/doc/groundwave/copyright"),
];

/// Makes all files twice, compares the checksums, and installs the Debian packages in a new Debian system.
pub(crate) fn check() -> Result<(), String> {
    make()?;
    let sums = folder().join("SHA256SUMS");
    let first = read(&sums)?;
    for (target, _) in TARGETS {
        cross::forget_release(target)?;
    }
    make()?;
    let second = read(&sums)?;
    if first != second {
        return Err(format!(
            "two runs gave different files:\n{first}and\n{second}"
        ));
    }
    let packages = TARGETS
        .iter()
        .filter_map(|(_, architecture)| *architecture)
        .map(|architecture| folder().join(package_name(architecture)));
    run(Command::new("python3")
        .arg("tests/systems/debian.py")
        .args(packages))
}

/// Makes all files in `target/dist`.
pub(crate) fn make() -> Result<(), String> {
    let changes = capture(Command::new("git").args(["status", "--porcelain"]))?;
    if !changes.is_empty() {
        return Err(format!(
            "a release has the files of a commit; commit or discard first:\n{changes}"
        ));
    }
    let dist = folder();
    let _ = fs::remove_dir_all(&dist);
    create(&dist)?;
    let epoch = capture(Command::new("git").args(["log", "-1", "--format=%ct"]))?;
    let epoch = epoch.trim();
    let source = source(&dist, epoch)?;
    super::cargo(&["build", "--locked", "--all-features", "--bin", "groundwave"])?;
    for (target, debian) in TARGETS {
        let stage = dist.join(format!("groundwave-{VERSION}-{target}"));
        stage_files(&stage, target)?;
        settle(&stage, epoch)?;
        if target == WINDOWS {
            zip(&stage)?;
        } else {
            tar(&stage, epoch)?;
        }
        if let Some(architecture) = debian {
            package(&dist, &stage, architecture, epoch)?;
        }
        fs::remove_dir_all(&stage).map_err(|error| format!("{}: {error}", stage.display()))?;
    }
    // Packages of other distributors contain the address of a release.
    if let Ok(url) = env::var("GROUNDWAVE_URL") {
        let sum = capture(Command::new("sha256sum").arg(&source))?;
        let sum = sum.split_whitespace().next().unwrap_or_default();
        for (template, name) in [("formula.rb", "groundwave.rb"), ("PKGBUILD", "PKGBUILD")] {
            let text = read(&root().join("xtask/dist").join(template))?;
            let text = text
                .replace("@URL@", url.trim_end_matches('/'))
                .replace("@VERSION@", VERSION)
                .replace("@SHA256@", sum);
            write(&dist.join(name), &text)?;
        }
    }
    let sums = capture(
        Command::new("sh")
            .current_dir(&dist)
            .args(["-c", "LC_ALL=C; export LC_ALL; sha256sum *"]),
    )?;
    print!("{sums}");
    write(&dist.join("SHA256SUMS"), &sums)
}

fn folder() -> PathBuf {
    root().join("target/dist")
}

fn package_name(architecture: &str) -> String {
    format!("groundwave_{VERSION}_{architecture}.deb")
}

/// The committed source, as an archive.
fn source(dist: &Path, epoch: &str) -> Result<PathBuf, String> {
    let archive = dist.join(format!("groundwave-{VERSION}.tar.gz"));
    run(Command::new("git")
        .args(["archive", "--format=tar.gz"])
        .arg(format!("--prefix=groundwave-{VERSION}/"))
        .arg(format!("--mtime=@{epoch}"))
        .arg("--output")
        .args([archive.as_os_str(), "HEAD".as_ref()]))?;
    Ok(archive)
}

fn stage_files(stage: &Path, target: &str) -> Result<(), String> {
    let suffix = if target == WINDOWS { ".exe" } else { "" };
    let program = cross::release(target, suffix)?;
    create(stage)?;
    copy(&program, &stage.join(format!("groundwave{suffix}")))?;
    // The pages and completions are the same on every machine.
    let host = root().join("target/debug/groundwave");
    run(Command::new(&host).arg("man").arg(stage.join("man")))?;
    create(&stage.join("completions"))?;
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let text = capture(Command::new(&host).args(["completions", shell]))?;
        write(
            &stage.join(format!("completions/groundwave.{shell}")),
            &text,
        )?;
    }
    let folder = root();
    for name in ["README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&folder.join(name), &stage.join(name))?;
    }
    run(Command::new("cp")
        .arg("-r")
        .arg(folder.join("protocol/c"))
        .arg(stage.join("c")))?;
    copy(&folder.join("protocol/SPEC.md"), &stage.join("c/SPEC.md"))?;
    for (name, options) in MEGA_PROGRAMS {
        copy(&mega::build_hex(options)?, &stage.join(name))?;
    }
    if target != WINDOWS {
        for name in ["60-groundwave.rules", "groundwave@.service"] {
            copy(&folder.join("xtask/dist").join(name), &stage.join(name))?;
        }
    }
    write(&stage.join("LICENSES"), &licence_texts(target)?)
}

/// The licences of the program, of everything linked into it, and of what the Mega's program is linked with.
fn licence_texts(target: &str) -> Result<String, String> {
    let mut files = vec![
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "captures/src/picture/font/LICENSE.txt",
        "/usr/share/doc/avr-libc/copyright",
    ];
    if target != WINDOWS {
        files.push("/usr/share/doc/musl-dev/copyright");
    }
    let mut texts = vec![];
    for name in files {
        texts.push(read(&root().join(name))?);
    }
    texts.push(licences::notices(target)?);
    Ok(texts.join("\n---\n\n"))
}

/// Gives every file the commit's time and the permissions of an installed file.
fn settle(folder: &Path, epoch: &str) -> Result<(), String> {
    run(Command::new("chmod")
        .args(["-R", "u=rwX,go=rX"])
        .arg(folder))?;
    run(Command::new("find")
        .arg(folder)
        .args(["-exec", "touch", "--no-dereference", "--date"])
        .arg(format!("@{epoch}"))
        .args(["{}", "+"]))
}

fn tar(stage: &Path, epoch: &str) -> Result<(), String> {
    let (folder, name) = parts(stage);
    let archive = format!("{name}.tar.gz");
    run(Command::new("tar")
        .current_dir(folder)
        .args(["--sort=name", "--owner=0", "--group=0", "--numeric-owner"])
        .arg(format!("--mtime=@{epoch}"))
        .args(["--use-compress-program", "gzip -9n", "-cf", &archive, &name]))
}

fn zip(stage: &Path) -> Result<(), String> {
    let (folder, name) = parts(stage);
    // The order of the files determines the bytes.
    let command =
        format!("find {name} -type f | LC_ALL=C sort | TZ=UTC zip -X -q -9 {name}.zip -@");
    run(Command::new("sh")
        .current_dir(folder)
        .args(["-c", &command]))
}

fn package(dist: &Path, stage: &Path, architecture: &str, epoch: &str) -> Result<(), String> {
    let debian = dist.join("debian");
    for (part, place) in PLACES {
        let place = debian.join(place);
        create(place.parent().unwrap_or(&debian))?;
        run(Command::new("cp")
            .arg("-rT")
            .arg(stage.join(part))
            .arg(&place))?;
    }
    run(Command::new("find")
        .arg(debian.join("usr/share/man"))
        .args(["-type", "f", "-exec", "gzip", "-9n", "{}", "+"]))?;
    let size_kib = capture(
        Command::new("du")
            .args(["-sk", "--apparent-size"])
            .arg(&debian),
    )?;
    let size_kib = size_kib.split_whitespace().next().unwrap_or("0");
    create(&debian.join("DEBIAN"))?;
    write(
        &debian.join("DEBIAN/control"),
        &format!(
            "Package: groundwave\nVersion: {VERSION}\nArchitecture: {architecture}\nSection: science\nPriority: optional\n\
             Maintainer: Groundwave <groundwave@localhost>\nInstalled-Size: {size_kib}\n\
             Description: ground station for a small robot\n \
             A live dashboard in the terminal, a recorder, and commands that the robot confirms, over a slow serial radio.\n"
        ),
    )?;
    settle(&debian, epoch)?;
    run(Command::new("dpkg-deb")
        .env("SOURCE_DATE_EPOCH", epoch)
        .args(["--root-owner-group", "--build"])
        .arg(&debian)
        .arg(dist.join(package_name(architecture))))?;
    fs::remove_dir_all(&debian).map_err(|error| format!("{}: {error}", debian.display()))
}

fn parts(path: &Path) -> (&Path, String) {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    (path.parent().unwrap_or(path), name)
}

fn create(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot create {}: {error}", folder.display()))
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    fs::copy(from, to).map(drop).map_err(|error| {
        format!(
            "cannot copy {} to {}: {error}",
            from.display(),
            to.display()
        )
    })
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("cannot read {}: {error}", path.display()))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    fs::write(path, text).map_err(|error| format!("cannot write {}: {error}", path.display()))
}
