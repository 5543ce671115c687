//! `export`: exports captures as tables, pictures, recordings and raw text.

pub(super) mod floor_map;
mod recorded;

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

use groundwave_captures::Session;
use groundwave_captures::words::counted;
use groundwave_mapping::DriveMap;
use groundwave_protocol::decoder::{Arrival, Received};
use groundwave_protocol::telemetry::Body;

use super::cli::{Export, ExportFormat};
use super::output::{Output, Target, targets};
use super::progress::Progress;
use super::{Exit, Fault, batch, input, say};
use crate::capture::decode::{DecodeError, Format, OwnColumns, decode};
use crate::capture::diagnosis;
use crate::capture::picture::Picture;
use crate::capture::runs::Label;
use crate::capture::track::Track;

/// Result of the export of a capture.
#[derive(Default)]
struct Made {
    /// A short description.
    what: String,
    /// Reason why the result is incomplete.
    problem: Option<Fault>,
    /// Mistakes in the robot's lines, in one clause.
    mistakes: Option<String>,
}

pub(super) fn run(options: &Export) -> Result<(), Fault> {
    let files = batch::files(&options.captures)?;
    let extension = match options.to {
        ExportFormat::Csv => "csv",
        ExportFormat::Jsonl => "jsonl",
        ExportFormat::Svg => "svg",
        ExportFormat::Png => "png",
        ExportFormat::Map => "yaml",
        ExportFormat::Mcap => "mcap",
        ExportFormat::Raw => "txt",
    };
    if options.to != ExportFormat::Mcap && (options.start.is_some() || options.anyway) {
        let problem = "--start and --anyway are for --to mcap; leave them out";
        return Err(Fault::new(Exit::Usage, problem));
    }
    let targets = targets(&files, &options.output, |_| Ok(extension.to_owned()))?;
    let seconds = if options.to == ExportFormat::Map {
        floor_map::seconds(&targets, &files)?
    } else {
        Vec::new()
    };
    batch::each(
        &files,
        options.captures.quiet,
        |index, progress| {
            let (path, target) = (&files[index], &targets[index]);
            match options.to {
                ExportFormat::Csv => table(path, progress, Format::Csv, target),
                ExportFormat::Jsonl => table(path, progress, Format::Jsonl, target),
                ExportFormat::Svg => picture(path, progress, target, |picture| {
                    Ok(picture.svg().into_bytes())
                }),
                ExportFormat::Png => picture(path, progress, target, Picture::png),
                ExportFormat::Map => floor_map::export(path, progress, target, &seconds[index]),
                ExportFormat::Mcap => recorded::to_mcap(options, path, progress, target),
                ExportFormat::Raw => recorded::to_raw(path, progress, target),
            }
        },
        |index, made| {
            if let Target::File(file, _) = &targets[index]
                && !options.captures.quiet
            {
                say(format_args!("{}: {}", file.display(), made.what));
            }
            if let Some(clause) = made.mistakes
                && !options.captures.quiet
            {
                let name = files[index].display();
                say(format_args!(
                    "{name}: mistakes of the robot: {clause}; `groundwave check` shows more"
                ));
            }
            made.problem.map_or(Ok(ControlFlow::Continue(())), Err)
        },
    )
}

fn table(
    path: &Path,
    progress: &Progress,
    format: Format<'_>,
    target: &Target,
) -> Result<Made, Fault> {
    let is_stdin = path == Path::new("-");
    let notes = if is_stdin {
        Vec::new()
    } else {
        let label = Label::of(path).map_err(|error| Fault::new(Exit::Failed, error))?;
        label.notes
    };
    // Only a file can be read twice: for its columns, and for its rows.
    let own_columns = if format == Format::Csv && path.is_file() {
        OwnColumns::of(&mut input::open_capture(path, progress)?, &notes)?
    } else {
        None
    };
    let format = own_columns.as_ref().map_or(format, Format::OwnCsv);
    let mut capture = input::open_capture(path, progress)?;
    let mut output = Output::create(target)?;
    let (mut lines, mut mistakes) = (0, None);
    let decoded = if is_stdin {
        decode(&mut capture, &notes, format, &mut EachLine(&mut output))
    } else {
        decode(&mut capture, &notes, format, &mut output)
    };
    let problem = match decoded {
        Ok(seen) if seen.lines == 0 => {
            return Err(Fault::no_lines(path, seen.bytes));
        }
        Ok(seen) => {
            lines = seen.lines;
            mistakes = diagnosis::clause(&seen.mistakes);
            None
        }
        Err(DecodeError::Output(error)) => return output.fault(&error).map(|()| Made::default()),
        // The readable part is written; report that a part is missing.
        Err(DecodeError::Capture(error)) => Some(Fault::from(error)),
    };
    output.finish()?;
    let what = match lines {
        0 => "only the readable part".to_owned(),
        lines => counted(lines, "line"),
    };
    Ok(Made {
        what,
        problem,
        mistakes,
    })
}

/// Flushes the output after each line, for a live stream.
struct EachLine<'a>(&'a mut Output);

impl Write for EachLine<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write_all(bytes)?;
        self.0.flush()?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

fn picture(
    path: &Path,
    progress: &Progress,
    target: &Target,
    draw: impl Fn(&Picture) -> Result<Vec<u8>, String>,
) -> Result<Made, Fault> {
    let mut capture = input::open_capture(path, progress)?;
    // Without its label a picture has no marks.
    let label = Label::of(path).unwrap_or_else(|error| {
        say(format_args!("{error}"));
        Label::default()
    });
    let marks = label.notes.into_iter().filter_map(|note| {
        let at = Duration::try_from_secs_f64(note.at_s?).ok()?;
        Some((at, note.text))
    });
    // The walls of a simulated world are known.
    let session = capture.session();
    let is_mapped = !session.is_some_and(|session| session.contains_key(Session::TRUTH));
    let mut map = DriveMap::default();
    let (mut track, _, problem) = Track::read_with(&mut capture, marks.collect(), |_, arrival| {
        if let Arrival::Line(Received::Line(line, _)) = arrival
            && let Body::State(state) = &line.body
            && is_mapped
        {
            map.take(state);
        }
    });
    track.obstacles_in = map.into_obstacles();
    let name = path.file_stem().unwrap_or_default().display().to_string();
    let picture = Picture::of_track(&name, label.name.as_deref(), &track, problem.as_ref());
    let problem = problem.map(Fault::from);
    let Some(picture) = picture else {
        return Err(problem.unwrap_or_else(|| {
            let name = path.display();
            let nothing =
                format!("{name}: no position in the capture, so there is nothing to draw");
            Fault::new(Exit::Usage, nothing)
        }));
    };
    let failed = |problem| Fault::new(Exit::Failed, format!("{}: {problem}", path.display()));
    let bytes = draw(&picture).map_err(failed)?;
    let mut output = Output::create(target)?;
    if let Err(error) = output.write_all(&bytes) {
        return output.fault(&error).map(|()| Made::default());
    }
    output.finish()?;
    let feet = track.distance_in / 12.0;
    Ok(Made {
        what: format!("path of {feet:.0} ft"),
        problem,
        mistakes: None,
    })
}
