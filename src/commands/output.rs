//! Output files, named after captures and written completely or not at all.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, OnceLock, PoisonError};

use super::{Exit, Fault, cli};
use crate::capture::files;
use crate::capture::source::Form;
use crate::hint;
use crate::io::files::beside;
use crate::io::signals;

/// Target of a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Standard output.
    Standard,
    /// A file, and whether it may be overwritten.
    File(PathBuf, bool),
}

/// The target for each capture, with `extension` in place of the capture's own.
///
/// # Errors
/// If two results would have the same name, or a file exists that must not be overwritten.
pub(super) fn targets(
    captures: &[PathBuf],
    options: &cli::Output,
    extension: impl Fn(&Path) -> Result<String, Fault>,
) -> Result<Vec<Target>, Fault> {
    let usage = |problem: String| Err(Fault::new(Exit::Usage, problem));
    if let Some(path) = &options.output
        && captures.len() > 1
    {
        let path = path.display();
        return usage(format!(
            "cannot write the results of {} captures to {path}; use --output-dir",
            captures.len()
        ));
    }
    if let Some(folder) = &options.output_dir {
        fs::create_dir_all(folder).map_err(|error| {
            let folder = folder.display();
            let hint = match error.kind() {
                io::ErrorKind::AlreadyExists => {
                    "a file with that name exists; choose another name".to_owned()
                }
                io::ErrorKind::NotFound => "choose a writable folder".to_owned(),
                _ => hint::of_writing(&error),
            };
            Fault::new(Exit::Failed, format!("cannot create {folder}: {hint}"))
        })?;
    }
    let mut targets: Vec<Target> = Vec::new();
    let mut taken = BTreeSet::new();
    for file in captures {
        let target = match &options.output {
            Some(path) if path == Path::new("-") => Target::Standard,
            Some(path) => Target::File(path.clone(), options.force),
            None if file == Path::new("-") => Target::Standard,
            None => {
                let mut path = file.with_extension(extension(file)?);
                if let (Some(folder), Some(name)) = (&options.output_dir, path.file_name()) {
                    path = folder.join(name);
                }
                Target::File(path, options.force)
            }
        };
        if let Target::File(path, force) = &target {
            if path.exists() {
                check_inputs(path, captures)?;
            }
            if !taken.insert(files::full_path(path)) {
                let path = path.display();
                return usage(format!(
                    "two captures would be written to {path}; use --output-dir or rename one"
                ));
            }
            refuse(path, *force)?;
        }
        targets.push(target);
    }
    Ok(targets)
}

/// The target of a second file of a result, named after the first one, `path`.
///
/// # Errors
/// If it exists and must not be overwritten.
pub(super) fn second(
    path: &Path,
    force: bool,
    extension: &str,
    captures: &[PathBuf],
) -> Result<Target, Fault> {
    let path = path.with_extension(extension);
    if path.exists() {
        check_inputs(&path, captures)?;
    }
    refuse(&path, force)?;
    Ok(Target::File(path, force))
}

/// Refuses a file name whose extension contradicts the format; `hint` is the suggestion in the message.
pub(super) fn check_form(target: &Target, form: Form, hint: &str) -> Result<(), Fault> {
    let Target::File(path, _) = target else {
        return Ok(());
    };
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let named = match extension.to_str() {
        Some("mcap") => Form::Mcap,
        Some("txt" | "raw" | "log") => Form::Raw,
        _ => return Ok(()),
    };
    if named == form {
        return Ok(());
    }
    let what = match form {
        Form::Raw => "raw text",
        Form::Mcap => "MCAP",
    };
    let path = path.display();
    Err(Fault::new(
        Exit::Usage,
        format!("{path}: the output is {what}, but the name says otherwise; {hint}"),
    ))
}

/// The configuration that the command has read, an input of every command.
static CONFIGURATION: OnceLock<PathBuf> = OnceLock::new();

/// Protects the configuration from every output that is checked later.
pub(super) fn protect_configuration(path: &Path) {
    CONFIGURATION.get_or_init(|| path.to_owned());
}

/// Refuses an output that is the same file as an input or the configuration, directly or by links, or has a reserved name.
pub(super) fn check_inputs(
    output: &Path,
    inputs: impl IntoIterator<Item = impl AsRef<Path>>,
) -> Result<(), Fault> {
    files::refuse_own_name(output)?;
    let is_input = |input: &PathBuf| files::is_same(input, output);
    let inputs = inputs.into_iter().map(|input| input.as_ref().to_owned());
    let Some(input) = inputs.chain(CONFIGURATION.get().cloned()).find(is_input) else {
        return Ok(());
    };
    let message = format!(
        "{} would be overwritten by its own result{}; choose another name",
        input.display(),
        if input == output {
            String::new()
        } else {
            format!(" {}", output.display())
        }
    );
    Err(Fault::new(Exit::Usage, message))
}

/// Refuses a path that cannot or must not be written.
fn refuse(path: &Path, force: bool) -> Result<(), Fault> {
    files::refuse_own_name(path)?;
    if path.is_dir() || !force && is_in_the_way(path) {
        return Err(exists(path));
    }
    Ok(())
}

/// Whether the path is an existing file or folder; pipes and devices can be written to again.
fn is_in_the_way(path: &Path) -> bool {
    // A link that leads nowhere is there, too.
    fs::metadata(path).map_or_else(
        |_| fs::symlink_metadata(path).is_ok(),
        |about| about.is_file() || about.is_dir(),
    )
}

fn exists(path: &Path) -> Fault {
    let hint = if path.is_dir() {
        "is a folder; name a file in it"
    } else {
        "exists; choose another name, or use --force to overwrite it"
    };
    Fault::new(Exit::Usage, format!("{} {hint}", path.display()))
}

/// Writes two complete files that belong together. Neither has its name before both are written.
pub(super) fn write_pair(pair: [(&Target, &[u8]); 2]) -> Result<(), Fault> {
    let mut outputs = Vec::new();
    for (target, bytes) in pair {
        let mut output = Output::create(target)?;
        if let Err(error) = output.write_all(bytes).and_then(|()| output.flush()) {
            return output.fault(&error);
        }
        outputs.push(output);
    }
    outputs.into_iter().try_for_each(Output::finish)
}

/// Writes a complete file, made from the inputs.
pub(super) fn write_file(
    path: &Path,
    text: &str,
    force: bool,
    inputs: &[&Path],
) -> Result<(), Fault> {
    check_inputs(path, inputs)?;
    refuse(path, force)?;
    let mut output = Output::create(&Target::File(path.to_owned(), force))?;
    match output.write_all(text.as_bytes()) {
        Ok(()) => output.finish(),
        Err(error) => output.fault(&error),
    }
}

/// An output in progress. If it is not finished, no file remains.
pub(super) struct Output {
    writer: Option<BufWriter<Box<dyn Write + Send>>>,
    file: Option<Unfinished>,
}

/// A file that still has its temporary name.
struct Unfinished {
    path: PathBuf,
    made: PathBuf,
    force: bool,
}

/// Temporary files, removed when a signal ends the program.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

impl Unfinished {
    /// Creates the file, registered for removal by the signal handler.
    fn create(path: &Path, force: bool) -> io::Result<(File, Self)> {
        static LISTENS: Once = Once::new();
        LISTENS.call_once(|| signals::on_leave(remove_all));
        let made = beside(path);
        let mut unfinished = all_unfinished();
        let file = File::create_new(&made)?;
        unfinished.push(made.clone());
        let path = path.to_owned();
        Ok((file, Self { path, made, force }))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        // After the rename there is nothing to remove.
        let _ = fs::remove_file(&self.made);
        all_unfinished().retain(|path| *path != self.made);
    }
}

fn all_unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files; while the returned guard is held, no new ones are created.
fn remove_all() -> MutexGuard<'static, Vec<PathBuf>> {
    let unfinished = all_unfinished();
    for path in &*unfinished {
        // The file may no longer exist.
        let _ = fs::remove_file(path);
    }
    unfinished
}

impl Output {
    /// Opens the target.
    pub(super) fn create(target: &Target) -> Result<Self, Fault> {
        let (sink, file): (Box<dyn Write + Send>, _) = match target {
            Target::Standard => (Box::new(io::stdout()), None),
            Target::File(path, force) => {
                let is_device = fs::metadata(path).is_ok_and(|about| !about.is_file());
                let opened = if is_device {
                    files::open_to_write(File::options().write(true), path).map(|file| (file, None))
                } else {
                    Unfinished::create(path, *force).map(|(file, made)| (file, Some(made)))
                };
                let (file, unfinished) = opened.map_err(|error| cannot_write(path, &error))?;
                (Box::new(file), unfinished)
            }
        };
        Ok(Self {
            writer: Some(BufWriter::with_capacity(1 << 16, sink)),
            file,
        })
    }

    /// Completes the file and gives it its name.
    pub(super) fn finish(mut self) -> Result<(), Fault> {
        let flushed = self.flush();
        let Some(file) = self.file.take() else {
            return flushed.or_else(|error| Fault::output(&error));
        };
        self.writer = None;
        let named = flushed.and_then(|()| {
            if file.force {
                return fs::rename(&file.made, &file.path);
            }
            // A link never overwrites a new file; not every file system has links.
            match fs::hard_link(&file.made, &file.path) {
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                    if fs::exists(&file.path)? {
                        return Err(io::ErrorKind::AlreadyExists.into());
                    }
                    fs::rename(&file.made, &file.path)
                }
                linked => linked,
            }
        });
        named.map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => exists(&file.path),
            _ => cannot_write(&file.path, &error),
        })
    }

    /// The fault for a write error; a closed pipe is not an error.
    pub(super) fn fault(self, error: &io::Error) -> Result<(), Fault> {
        match &self.file {
            None => Fault::output(error),
            Some(file) => Err(cannot_write(&file.path, error)),
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.writer {
            Some(writer) => writer.write(bytes),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

fn cannot_write(path: &Path, error: &io::Error) -> Fault {
    let path = path.display();
    let problem = hint::of_writing(error);
    Fault::new(Exit::Failed, format!("cannot write {path}: {problem}"))
}
