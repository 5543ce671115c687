//! Files that a verb makes: named after captures, whole or not there at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use super::{Exit, Fault, cli};
use crate::capture::recover;
use crate::capture::source::Form;
use crate::io::files::beside;
use crate::io::signals;
use crate::remedy;

/// Where the result of a capture goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Standard output.
    Standard,
    /// A file, and whether it may be overwritten.
    File(PathBuf, bool),
}

/// Says where the result of each capture goes, before any work is done. `extension` comes in place of the
/// capture's own.
///
/// # Errors
/// When two results would have one name or one has a name of the recorder's, or a file is there that may not be overwritten.
pub(super) fn targets(
    files: &[PathBuf],
    options: &cli::Output,
    extension: impl Fn(&Path) -> Result<String, Fault>,
) -> Result<Vec<Target>, Fault> {
    let usage = |problem: String| Err(Fault::new(Exit::Usage, problem));
    if let Some(path) = &options.output
        && files.len() > 1
    {
        let path = path.display();
        return usage(format!(
            "{} captures cannot all go to {path}: say --output-dir",
            files.len()
        ));
    }
    if let Some(folder) = &options.output_dir {
        fs::create_dir_all(folder).map_err(|error| {
            let folder = folder.display();
            let remedy = match error.kind() {
                io::ErrorKind::AlreadyExists => {
                    "a file has that name; choose another one".to_owned()
                }
                _ => format!("{error}; choose a directory you may write to"),
            };
            Fault::new(Exit::Failed, format!("cannot make {folder}: {remedy}"))
        })?;
    }
    let mut targets: Vec<Target> = Vec::new();
    for file in files {
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
            if let Some(input) = files.iter().find(|input| is_same(input, path)) {
                let input = input.display();
                return usage(format!(
                    "{input} would be overwritten by what is made of it: choose another name"
                ));
            }
            if targets.contains(&target) {
                let path = path.display();
                return usage(format!("two captures would both become {path}"));
            }
            refuse(path, *force)?;
        }
        targets.push(target);
    }
    Ok(targets)
}

/// Refuses a name that says another form than the result has. `remedy` says what to do instead.
///
/// # Errors
/// When the name does.
pub(super) fn check_form(target: &Target, form: Form, remedy: &str) -> Result<(), Fault> {
    let Target::File(path, _) = target else {
        return Ok(());
    };
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let said = match extension.to_str() {
        Some("mcap") => Form::Mcap,
        Some("txt" | "raw" | "log") => Form::Raw,
        _ => return Ok(()),
    };
    if said == form {
        return Ok(());
    }
    let what = match form {
        Form::Raw => "raw text",
        Form::Mcap => "MCAP",
    };
    let path = path.display();
    Err(Fault::new(
        Exit::Usage,
        format!("{path} would be {what}, whatever its name says: {remedy}"),
    ))
}

/// Whether both names lead to one file.
fn is_same(one: &Path, other: &Path) -> bool {
    match (fs::canonicalize(one), fs::canonicalize(other)) {
        (Ok(one), Ok(other)) => one == other && one.is_file(),
        _ => false,
    }
}

/// Refuses a name that nothing can or may be written under.
fn refuse(path: &Path, force: bool) -> Result<(), Fault> {
    recover::refuse_own_name(path)?;
    if path.is_dir() || !force && is_in_the_way(path) {
        return Err(exists(path));
    }
    Ok(())
}

/// A pipe or a device can be written to as often as one likes.
fn is_in_the_way(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|about| about.is_file() || about.is_dir())
}

fn exists(path: &Path) -> Fault {
    let remedy = if path.is_dir() {
        "is a folder: name a file in it"
    } else {
        "exists: choose another name, or say --force to overwrite it"
    };
    Fault::new(Exit::Usage, format!("{} {remedy}", path.display()))
}

/// Writes a file at one stroke.
pub(super) fn write_file(path: &Path, text: &str, force: bool) -> Result<(), Fault> {
    refuse(path, force)?;
    let mut output = Output::create(&Target::File(path.to_owned(), force))?;
    match output.write_all(text.as_bytes()) {
        Ok(()) => output.finish(),
        Err(error) => output.fault(&error),
    }
}

/// A result under way. What is not finished leaves nothing behind.
pub(super) struct Output {
    writer: Option<BufWriter<Box<dyn Write + Send>>>,
    file: Option<Unfinished>,
}

/// A file that has not got its name yet.
struct Unfinished {
    path: PathBuf,
    made: PathBuf,
    force: bool,
}

/// Files that are to go when the program is told to leave.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

impl Unfinished {
    /// Creates the file, and not a moment before somebody would remove it.
    fn create(path: &Path, force: bool) -> io::Result<(File, Self)> {
        static LISTENS: Once = Once::new();
        LISTENS.call_once(|| signals::when_told_to_leave(remove_all));
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
        // Once it has its name it is gone from here.
        let _ = fs::remove_file(&self.made);
        all_unfinished().retain(|path| *path != self.made);
    }
}

fn all_unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Holds on to the list, so that nothing is begun any more.
fn remove_all() -> MutexGuard<'static, Vec<PathBuf>> {
    let unfinished = all_unfinished();
    for path in &*unfinished {
        // What is gone already is as good.
        let _ = fs::remove_file(path);
    }
    unfinished
}

impl Output {
    /// Begins.
    pub(super) fn create(target: &Target) -> Result<Self, Fault> {
        let (sink, file): (Box<dyn Write + Send>, _) = match target {
            Target::Standard => (Box::new(io::stdout()), None),
            Target::File(path, force) => {
                let is_device = fs::metadata(path).is_ok_and(|about| !about.is_file());
                let opened = if is_device {
                    File::options()
                        .write(true)
                        .open(path)
                        .map(|file| (file, None))
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

    /// Gives it its name, now that it is whole.
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
            // A link never overwrites what has appeared in the meantime; not every file system has links.
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

    /// An error of writing: a reader of standard output that has gone away is none.
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
    let problem = remedy::of_writing(error);
    Fault::new(Exit::Failed, format!("cannot write {path}: {problem}"))
}
