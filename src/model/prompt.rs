//! The prompt: commands, file names and times.

use groundwave_captures::words::counted;
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::Mode;

use super::keys::Action;
use super::parameters::save_parameters;
use super::ui::{Question, Then};
use super::{Facts, Overlay, Purpose, TextEntry, Ui};
use crate::event::{Effect, FileKind, Level, Moment, SaveProblem, remark_from_words, unquoted};
use crate::request::Request;

/// Page of the help with the commands: the last.
const HELP_OF_COMMANDS: i32 = -1;

impl Ui {
    pub(super) fn submit(&mut self, facts: &Facts, now: Moment, entry: TextEntry) -> Vec<Effect> {
        let text = entry.text.trim();
        self.overlay = Overlay::None;
        if !text.is_empty() {
            self.typed.keep(entry.purpose, text);
        } else if entry.purpose != Purpose::Mark {
            return Vec::new();
        }
        match entry.purpose {
            Purpose::Mark => return self.set_mark(facts, now, text),
            Purpose::Moment => return self.submit_moment(entry),
            Purpose::Search => {
                self.submit_search(facts, entry);
                return Vec::new();
            }
            Purpose::Command | Purpose::RouteFile | Purpose::SaveRoute => {}
        }
        let named = match entry.purpose {
            Purpose::SaveRoute => Ok(Some(self.save_route(unquoted(text)))),
            Purpose::RouteFile => Ok(Some(Effect::LoadRoute(unquoted(text)))),
            _ => match route_file(text).filter(|(file, _)| !are_points(file)) {
                Some((file, _)) => Ok(Some(Effect::LoadRoute(unquoted(file)))),
                None => Self::name_parameter_file(facts, text),
            },
        };
        if !matches!(named, Ok(None)) {
            // The prompt stays open until the file is read or written, so that the operator can correct the name.
            let (effect, error) = match named {
                Ok(effect) => (effect, None),
                Err(error) => (None, Some(error)),
            };
            self.overlay = Overlay::Text(TextEntry {
                waits: effect.is_some(),
                error,
                ..entry
            });
            return effect.into_iter().collect();
        }
        let words: Vec<&str> = text.split_whitespace().collect();
        let attended = self.attend(facts, now, &words);
        let waits = self.begin_wait(now, &words);
        let planned = self.plan(facts, &words);
        let asked = match remark_from_words(&words) {
            _ if attended.is_some() => attended.transpose(),
            _ if planned.is_some() => planned.transpose(),
            _ if waits.is_some() => waits.map(|begun| begun.map(|()| Vec::new())).transpose(),
            Some(Ok(remark)) => return self.label(facts, remark, entry),
            Some(Err(error)) => Err(error),
            None => self.ask_for_runs(facts, text),
        };
        match asked {
            Ok(Some(effects)) => return effects,
            Ok(None) => {}
            Err(error) => {
                self.overlay = Overlay::Text(TextEntry {
                    error: Some(error),
                    ..entry
                });
                return Vec::new();
            }
        }
        match (
            Request::all_from_words_or_own(&words, &self.config.own_commands),
            &words[..],
        ) {
            (Ok(requests), _) => requests
                .into_iter()
                .flat_map(|request| self.ask_or_send(request))
                .collect(),
            (Err(_), ["param"]) => self.open_parameters(facts),
            (Err(_), ["advise"]) => self.accept_suggestion(facts, now),
            (Err(_), ["quit" | "q"]) => vec![Effect::Quit],
            (Err(_), ["help"]) => {
                self.open_help(HELP_OF_COMMANDS);
                Vec::new()
            }
            (Err(error), _) => {
                let error = match words[..] {
                    ["route", _, ..] => POINTS_FOR_A_FILE.to_owned(),
                    _ => error.to_string(),
                };
                self.overlay = Overlay::Text(TextEntry {
                    error: Some(error),
                    ..entry
                });
                Vec::new()
            }
        }
    }

    /// Takes a route as the draft; with `--go`, sends it and makes the robot prowl.
    pub(super) fn take_route(
        &mut self,
        path: &str,
        route: Result<Vec<Waypoint>, String>,
    ) -> Vec<Effect> {
        let waypoints = match route {
            Ok(waypoints) => waypoints,
            Err(error) => {
                self.warn(&error);
                self.end_waiting(Some(&error));
                return Vec::new();
            }
        };
        let goes = matches!(&self.overlay, Overlay::Text(entry) if entry.waits && entry.goes());
        let mut text = format!(
            "{path}: {} drafted",
            counted(waypoints.len() as u64, "waypoint")
        );
        if !goes {
            text += &self.with_keys("; <send-draft> sends them");
        }
        self.note(Level::Info, text);
        self.map.take_draft(&waypoints);
        self.show_selected();
        self.end_waiting(None);
        if !goes {
            return Vec::new();
        }
        let mut effects = self.send_draft();
        if effects.is_empty() {
            return effects;
        }
        effects.push(Effect::Send(Request::Mode(Mode::Prowl)));
        self.ask_from_the_past(Action::SendDraft, effects)
    }

    /// Takes the result of writing a file; asks before an existing one is overwritten.
    pub(super) fn take_saved(
        &mut self,
        facts: &Facts,
        kind: FileKind,
        path: &str,
        saved: &Result<(), SaveProblem>,
    ) {
        match saved {
            Ok(()) => {
                let (count, thing) = match kind {
                    FileKind::Route => (self.map.draft.waypoints().len(), "waypoint"),
                    FileKind::Parameters => (facts.parameters.heard().len(), "parameter"),
                };
                let counted = counted(count as u64, thing);
                self.note(Level::Info, format!("{path}: {counted} saved"));
                self.end_waiting(None);
            }
            Err(SaveProblem::Exists) => {
                let (thing, mut effect) = match kind {
                    FileKind::Route => ("the draft", self.save_route(path.to_owned())),
                    FileKind::Parameters => (
                        "the robot's parameters",
                        save_parameters(facts, path.to_owned()),
                    ),
                };
                if let Effect::Save { overwrite, .. } = &mut effect {
                    *overwrite = true;
                }
                self.overlay = Overlay::Question(Question {
                    text: format!("{path} exists. Overwrite it with {thing}?"),
                    then: Then::Save(effect),
                });
            }
            Err(SaveProblem::Failed(problem)) => {
                self.tell_editor(problem);
                self.end_waiting(Some(problem));
                self.note(Level::Warning, problem.as_str());
            }
        }
    }

    /// Closes the prompt that waits for a file, or shows its error.
    pub(super) fn end_waiting(&mut self, error: Option<&str>) {
        match (&mut self.overlay, error) {
            (Overlay::Text(entry), Some(error)) if entry.waits => {
                entry.error = Some(error.to_owned());
                entry.waits = false;
            }
            (Overlay::Text(entry), None) if entry.waits => self.overlay = Overlay::None,
            _ => {}
        }
    }
}

/// The remedy when a route's points are typed instead of a file's name.
const POINTS_FOR_A_FILE: &str =
    "`route` takes a file with X,Y in each line; `goto 40 20` drives to one point";

/// Whether a text is points, such as `40,20 60,40`, and no name of a file.
fn are_points(text: &str) -> bool {
    let is_point = |word: &str| {
        word.split_once(',')
            .is_some_and(|(x, y)| x.parse::<i16>().is_ok() && y.parse::<i16>().is_ok())
    };
    text.split_whitespace().all(is_point) && !text.is_empty()
}

/// The file of `route FILE`, and whether `--go` follows; `None` for other commands.
fn route_file(command: &str) -> Option<(&str, bool)> {
    let file = command.trim().strip_prefix("route ")?.trim();
    let before = file.strip_suffix("--go");
    let before = before.filter(|file| file.ends_with(char::is_whitespace));
    Some(before.map_or((file, false), |file| (file.trim_end(), true)))
}

impl TextEntry {
    /// Whether the robot drives the route at once.
    fn goes(&self) -> bool {
        let is_command = self.purpose == Purpose::Command;
        is_command && route_file(&self.text).is_some_and(|(_, goes)| goes)
    }
}
