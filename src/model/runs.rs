//! The list of runs and the comparison of two, on the dashboard.

use std::path::Path;
use std::sync::Arc;

use super::ui::Then;
use super::{Facts, Overlay, Question, TextEntry, Ui};
use crate::event::{Effect, Remark};
use crate::figures::{Listed, Overlaid};

/// The runs overlay.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Runs {
    /// Files are being read; contains the text to show.
    Waits(String),
    /// The list of runs.
    Listed {
        list: Arc<Listed>,
        /// Index of the selected run.
        chosen: usize,
        /// Index of the first run of a comparison.
        first: Option<usize>,
    },
    /// Two runs over each other.
    Overlaid(Arc<Overlaid>),
    /// The files could not be read, for a reason.
    Failed(String),
}

impl Ui {
    /// Carries out `runs`, `runs FOLDER` and `compare A B`; `None` for other commands.
    ///
    /// # Errors
    /// If the arguments are wrong.
    pub(super) fn ask_for_runs(
        &mut self,
        facts: &Facts,
        line: &str,
    ) -> Result<Option<Vec<Effect>>, String> {
        let command = line.split_whitespace().next();
        if !matches!(command, Some("runs" | "compare")) {
            return Ok(None);
        }
        let mut words = shlex::split(line)
            .ok_or("a quote is not closed")?
            .into_iter()
            .skip(1);
        let (first, second, more) = (words.next(), words.next(), words.next());
        match (command, first, second, more) {
            (Some("runs"), None, ..) => Ok(Some(self.list_runs(self.folder_at_hand(facts)))),
            (Some("runs"), Some(folder), None, _) => Ok(Some(self.list_runs(folder))),
            (Some("runs"), ..) => {
                Err("`runs` takes one folder; quote a name with spaces".to_owned())
            }
            (_, Some(a), Some(b), None) => Ok(Some(self.compare_runs([a, b]))),
            _ => Err("`compare` takes two captures; quote a name with spaces".to_owned()),
        }
    }

    fn list_runs(&mut self, folder: String) -> Vec<Effect> {
        self.overlay = Overlay::Runs(Runs::Waits(format!("reading the captures in {folder}")));
        vec![Effect::ListRuns(folder)]
    }

    fn compare_runs(&mut self, captures: [String; 2]) -> Vec<Effect> {
        let [a, b] = &captures;
        self.behind = None;
        self.overlay = Overlay::Runs(Runs::Waits(format!("reading {a} and {b}")));
        vec![Effect::CompareRuns(captures)]
    }

    /// The replayed capture, else the current recording.
    pub(super) fn capture_at_hand<'a>(&'a self, facts: &'a Facts) -> Option<&'a String> {
        let recording = &facts.recording;
        let recorded = recording.mcap.as_ref().or(recording.tee.as_ref());
        self.config.capture.as_ref().or(recorded)
    }

    /// Folder of the replayed capture or the current recording.
    fn folder_at_hand(&self, facts: &Facts) -> String {
        let capture = self.capture_at_hand(facts).map(Path::new);
        let folder = capture.and_then(Path::parent).and_then(Path::to_str);
        let folder = folder.filter(|folder| !folder.is_empty());
        folder.unwrap_or(".").to_owned()
    }

    /// Labels the replayed run, or the current recording.
    pub(super) fn label(&mut self, facts: &Facts, remark: Remark, entry: TextEntry) -> Vec<Effect> {
        let Some(capture) = self.capture_at_hand(facts).cloned() else {
            let error =
                "nothing is recorded: <toggle-recording> begins a recording, with the last minutes";
            self.overlay = Overlay::Text(TextEntry {
                error: Some(self.with_keys(error)),
                ..entry
            });
            return Vec::new();
        };
        let shown = self.playback.as_ref().filter(|playback| playback.is_live);
        let ago = shown.map(crate::playback::Playback::behind);
        vec![Effect::Label {
            capture,
            remark,
            ago: ago.unwrap_or_default(),
        }]
    }

    /// Whether the overlay still waits for files.
    fn waits_for_runs(&self) -> bool {
        matches!(self.overlay, Overlay::Runs(Runs::Waits(_)))
    }

    /// Shows the list; the replayed run is selected, or the newest run that is finished.
    pub(super) fn take_runs(&mut self, facts: &Facts, runs: Result<Arc<Listed>, String>) -> bool {
        let waits = self.waits_for_runs();
        if waits {
            let recording = &facts.recording;
            let is_recorded = |capture: &String| {
                let mut recorded = [&recording.mcap, &recording.tee].into_iter().flatten();
                recorded.any(|own| is_same_file(own, capture))
            };
            let replayed = self.config.capture.as_ref();
            let is_replayed =
                |capture: &String| replayed.is_some_and(|own| is_same_file(own, capture));
            self.overlay = Overlay::Runs(match runs {
                Ok(list) => Runs::Listed {
                    chosen: (list.runs.iter())
                        .position(|run| is_replayed(&run.capture))
                        .or_else(|| {
                            let mut runs = list.runs.iter();
                            runs.rposition(|run| !is_recorded(&run.capture))
                        })
                        .unwrap_or_default(),
                    list,
                    first: None,
                },
                Err(error) => Runs::Failed(error),
            });
        }
        waits
    }

    pub(super) fn take_overlaid(&mut self, overlaid: Result<Arc<Overlaid>, String>) -> bool {
        let waits = self.waits_for_runs();
        if waits {
            self.overlay = Overlay::Runs(match overlaid {
                Ok(overlaid) => Runs::Overlaid(overlaid),
                Err(error) => Runs::Failed(error),
            });
        }
        waits
    }

    /// Closes the overlay; a comparison from the list returns to the list.
    pub(super) fn put_away(&mut self) {
        let behind = self.behind.take();
        let is_comparison =
            matches!(&self.overlay, Overlay::Runs(runs) if !matches!(runs, Runs::Listed { .. }));
        let behind = behind.filter(|_| is_comparison);
        self.overlay = behind.map_or(Overlay::None, Overlay::Runs);
    }

    /// Replays the selected run; asks first if that ends a live session.
    pub(super) fn replay_run(&mut self) -> Vec<Effect> {
        let Overlay::Runs(Runs::Listed { list, chosen, .. }) = &self.overlay else {
            return Vec::new();
        };
        let Some(run) = list.runs.get(*chosen) else {
            return Vec::new();
        };
        let capture = run.capture.clone();
        if self.is_replay() {
            return vec![Effect::Replay(capture)];
        }
        self.overlay = Overlay::Question(Question {
            text: format!(
                "Leave this session and replay {capture}? Its recording ends; a real robot continues, a simulated one ends with it."
            ),
            then: Then::Replay(capture),
        });
        Vec::new()
    }

    /// Takes the selected run as the first of a comparison; or as the second, and compares them.
    pub(super) fn pick_run(&mut self) -> Vec<Effect> {
        let Overlay::Runs(Runs::Listed {
            list,
            chosen,
            first,
        }) = &mut self.overlay
        else {
            return Vec::new();
        };
        let name = |place: usize| list.runs.get(place).map(|run| run.capture.clone());
        match first.take() {
            None if !list.runs.is_empty() => *first = Some(*chosen),
            Some(earlier) if earlier != *chosen => {
                if let (Some(a), Some(b)) = (name(earlier), name(*chosen)) {
                    let behind = Runs::Listed {
                        list: Arc::clone(list),
                        chosen: *chosen,
                        first: None,
                    };
                    let effects = self.compare_runs([a, b]);
                    self.behind = Some(behind);
                    return effects;
                }
            }
            // Picking the same run again deselects it.
            None | Some(_) => {}
        }
        Vec::new()
    }
}

impl Runs {
    /// Moves the selection.
    pub(super) fn choose(&mut self, steps: i8) {
        if let Self::Listed { list, chosen, .. } = self {
            let last = list.runs.len().saturating_sub(1);
            *chosen = chosen.saturating_add_signed(steps.into()).min(last);
        }
    }
}

/// Whether two names are those of one file, with a folder or without.
fn is_same_file(a: &str, b: &str) -> bool {
    Path::new(a).file_name() == Path::new(b).file_name()
}
