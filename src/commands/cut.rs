//! `cut`: cuts a time range out of captures.

use std::ops::ControlFlow;
use std::path::Path;

use super::cli::Cut;
use super::output::{Output, Target, check_form, targets};
use super::{Exit, Fault, batch, input, say};
use crate::capture::cut::{CutError, Part, Window, cut_mcap, cut_raw};
use crate::capture::files;
use crate::capture::source::Form;
use crate::capture::when::When;

pub(super) fn run(options: &Cut) -> Result<(), Fault> {
    let window = Window {
        from: options.from,
        to: options.to,
    };
    check(window)?;
    let files = batch::files(&options.captures)?;
    let targets = targets(&files, &options.output, |path| {
        if files::is_own_name(path) {
            return Ok("cut.mcap".to_owned());
        }
        let extension = path.extension().unwrap_or_default();
        Ok(format!("cut.{}", extension.display())
            .trim_end_matches('.')
            .to_owned())
    })?;
    batch::each(
        &files,
        options.captures.quiet,
        |index, progress| {
            let (path, target) = (&files[index], &targets[index]);
            let source = input::open(path, progress)?;
            let (form, source) = input::detect_form(path, source)?;
            let hint = match form {
                Form::Mcap => "name it .mcap; `groundwave export --to raw` makes raw text of it",
                Form::Raw => "name it .txt; `groundwave export --to mcap` makes MCAP of it",
            };
            if options.output.output.is_some() || files::is_own_name(path) {
                check_form(target, form, hint)?;
            }
            let mut output = Output::create(target)?;
            let part = match form {
                Form::Mcap => cut_mcap(source, window, &mut output),
                Form::Raw => cut_raw(source, window, &mut output),
            };
            match part {
                Ok(part) if part.is_empty() => Err(nothing(path, &part)),
                Ok(part) => output.finish().map(|()| part),
                Err(CutError::Write(error)) => output.fault(&error).map(|()| Part::default()),
                Err(CutError::Read(error)) => Err(input::cannot_read(path, error)),
                Err(error @ CutError::NoWallTime) => {
                    let path = path.display();
                    Err(Fault::new(Exit::Usage, format!("{path}: {error}")))
                }
            }
        },
        |index, part| {
            if let Target::File(made, _) = &targets[index]
                && !options.captures.quiet
            {
                let (bytes, made) = (part.bytes, made.display());
                say(format_args!("{made}: {bytes} received bytes"));
            }
            match part.problem {
                Some(problem) => Err(input::not_whole(&files[index], &problem)),
                None => Ok(ControlFlow::Continue(())),
            }
        },
    )
}

/// The fault for an empty part.
fn nothing(path: &Path, part: &Part) -> Fault {
    if let Some(problem) = &part.problem {
        return input::not_whole(path, problem);
    }
    let seconds = part.whole.as_secs();
    let (minutes, seconds) = (seconds / 60, seconds % 60);
    let path = path.display();
    Fault::new(
        Exit::Usage,
        format!(
            "{path}: nothing recorded between --from and --to; the capture is {minutes}:{seconds:02} long"
        ),
    )
}

/// Refuses a part without a start and an end, or with the end first.
fn check(window: Window) -> Result<(), Fault> {
    let is_empty = match (window.from, window.to) {
        (None, None) => {
            let problem = "give --from, --to or both";
            return Err(Fault::new(Exit::Usage, problem));
        }
        (Some(When::Since(from)), Some(When::Since(to))) => from >= to,
        (Some(When::Wall(from)), Some(When::Wall(to))) => from >= to,
        _ => false,
    };
    if is_empty {
        let problem = "--from must be before --to";
        return Err(Fault::new(Exit::Usage, problem));
    }
    Ok(())
}
