//! The alarm hook: runs the operator's command for each alarm event.
//!
//! A thread runs the command for one event after another, so a slow command delays neither the link nor the screen.

use std::io::{self, Write as _};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use groundwave_captures::words::counted;
use tokio::sync::mpsc;

use crate::hint;

/// Maximum number of queued events.
const WAITING_MAX: usize = 64;

/// Maximum run time of the command for one event.
const TIME_MAX: Duration = Duration::from_secs(30);

/// Maximum total run time of the command for the queued events after the station begins to end; the command must not outlive the station.
const LAST_TIME_MAX: Duration = Duration::from_secs(1);

/// Period of the checks whether the command has ended.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Runs a shell command for each event. Dropping the hook passes the queued events for at most a second, then ends the running command and
/// says on standard error how many events were not passed.
pub struct AlarmHook {
    events: Option<SyncSender<String>>,
    problems: mpsc::UnboundedReceiver<String>,
    ending_since: Arc<OnceLock<Instant>>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for AlarmHook {
    fn drop(&mut self) {
        for problem in self.finish() {
            // Standard error may be closed.
            let _ = writeln!(io::stderr(), "{problem}");
        }
    }
}

impl AlarmHook {
    /// Starts the thread for a command.
    ///
    /// # Errors
    /// If no thread can be started.
    pub fn start(command: &str) -> io::Result<Self> {
        Self::start_for(command, TIME_MAX, LAST_TIME_MAX)
    }

    fn start_for(command: &str, time_max: Duration, last_time_max: Duration) -> io::Result<Self> {
        let (events, queue) = sync_channel(WAITING_MAX);
        let (tell, problems) = mpsc::unbounded_channel();
        let ending_since = Arc::new(OnceLock::new());
        let runner = Runner {
            command: command.to_owned(),
            time_max,
            last_time_max,
            ending_since: Arc::clone(&ending_since),
        };
        let thread = thread::Builder::new()
            .name("alarm hook".to_owned())
            .spawn(move || runner.serve(&queue, &tell))?;
        Ok(Self {
            events: Some(events),
            problems,
            ending_since,
            thread: Some(thread),
        })
    }

    /// Passes an event, one line of JSON. Never waits.
    ///
    /// # Errors
    /// If the command is so slow that too many events wait.
    pub fn pass(&self, event: String) -> Result<(), String> {
        match self.events.as_ref().map(|events| events.try_send(event)) {
            Some(Ok(())) => Ok(()),
            Some(Err(TrySendError::Full(_))) => Err(format!(
                "{WAITING_MAX} events wait for the alarm hook, so this one is not passed to it"
            )),
            Some(Err(TrySendError::Disconnected(_))) | None => {
                Err("the alarm hook has ended".to_owned())
            }
        }
    }

    /// Passes the queued events while there is time, and ends the thread; returns the problems not told yet.
    fn finish(&mut self) -> Vec<String> {
        self.ending_since.get_or_init(Instant::now);
        self.events = None;
        if let Some(thread) = self.thread.take() {
            // A panic has been reported.
            let _ = thread.join();
        }
        std::iter::from_fn(|| self.problems.try_recv().ok()).collect()
    }

    /// The next problem of the command. Cancel-safe.
    pub async fn next_problem(&mut self) -> String {
        match self.problems.recv().await {
            Some(problem) => problem,
            None => std::future::pending().await,
        }
    }
}

/// The command and its limits, owned by the thread.
struct Runner {
    command: String,
    time_max: Duration,
    last_time_max: Duration,
    /// Time at which the station began to end.
    ending_since: Arc<OnceLock<Instant>>,
}

impl Runner {
    /// Runs the command for each event until the queue is closed and empty, or the time after the end is over.
    fn serve(&self, queue: &Receiver<String>, tell: &mpsc::UnboundedSender<String>) {
        let mut not_passed = 0;
        for event in queue {
            if self.is_over() {
                not_passed += 1;
                continue;
            }
            let problem = match self.run(&event) {
                Ok(Some(status)) if status.success() => continue,
                Ok(Some(status)) => format!("ended with {status}"),
                Ok(None) if self.is_over() => {
                    "had not ended at the end of the session and was ended".to_owned()
                }
                Ok(None) => format!(
                    "took longer than {} s and was ended",
                    self.time_max.as_secs()
                ),
                Err(error) => format!("failed: {}", hint::words(&error)),
            };
            // The station may have panicked.
            let _ = tell.send(format!("alarm hook `{}` {problem}", self.command));
        }
        if not_passed > 0 {
            let events = counted(not_passed, "alarm event");
            let _ = tell.send(format!(
                "alarm hook `{}`: {events} not passed, because the session ended",
                self.command
            ));
        }
    }

    /// Whether the time after the end of the station is over.
    fn is_over(&self) -> bool {
        let since = self.ending_since.get();
        since.is_some_and(|since| since.elapsed() >= self.last_time_max)
    }

    /// Runs the command with an event on its standard input; returns `None` if the command took too long.
    fn run(&self, event: &str) -> io::Result<Option<ExitStatus>> {
        let mut child = shell(&self.command)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()?;
        if let Some(mut input) = child.stdin.take() {
            // The command need not read it.
            let _ = writeln!(input, "{event}");
        }
        let begun = Instant::now();
        while begun.elapsed() < self.time_max {
            if let Some(status) = child.try_wait()? {
                return Ok(Some(status));
            }
            if self.is_over() {
                break;
            }
            thread::sleep(LOOK_EVERY);
        }
        end(&mut child);
        child.wait()?;
        Ok(None)
    }
}

/// The command in a separate process group: keys of the terminal do not reach it, and its children end with it.
#[cfg(unix)]
fn shell(command: &str) -> Command {
    use std::os::unix::process::CommandExt as _;
    let mut shell = Command::new("sh");
    shell.args(["-c", command]).process_group(0);
    shell
}

#[cfg(not(unix))]
fn shell(command: &str) -> Command {
    let mut shell = Command::new("cmd");
    shell.args(["/C", command]);
    shell
}

#[cfg(unix)]
fn end(child: &mut Child) {
    use rustix::process::{Pid, Signal, kill_process_group};
    // The command may just have ended.
    let _ = kill_process_group(Pid::from_child(child), Signal::KILL);
}

#[cfg(not(unix))]
fn end(child: &mut Child) {
    // The command may just have ended.
    let _ = child.kill();
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[tokio::test]
    async fn each_event_is_on_the_standard_input_of_the_command() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("told");
        // The last event fails, which shows that all events have been passed.
        let command = format!("read -r line; echo \"$line\" >> {path:?}; test \"$line\" != c");
        let mut hook = AlarmHook::start(&command).unwrap();
        for event in ["a", "b", "c"] {
            hook.pass(event.to_owned()).unwrap();
        }
        let problem = hook.next_problem().await;
        assert!(problem.ends_with("ended with exit status: 1"), "{problem}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "a\nb\nc\n");
    }

    #[test]
    fn queued_events_are_passed_at_the_end_of_the_session() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("told");
        let command = format!("cat >> {path:?}");
        // A busy machine may need longer than the usual second.
        let mut hook = AlarmHook::start_for(&command, TIME_MAX, TIME_MAX).unwrap();
        for event in ["a", "b", "c"] {
            hook.pass(event.to_owned()).unwrap();
        }
        assert_eq!(hook.finish(), Vec::<String>::new());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "a\nb\nc\n");
    }

    #[test]
    fn a_command_that_hangs_does_not_outlive_the_program() {
        use rustix::process::{Pid, test_kill_process_group};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pid");
        // Built into the shell: a program that is just ending would stay in the process group.
        let command = format!("echo $$ > {path:?}; exec sleep 1000");
        let mut hook = AlarmHook::start_for(&command, TIME_MAX, Duration::ZERO).unwrap();
        hook.pass("a".to_owned()).unwrap();
        let pid = loop {
            let text = std::fs::read_to_string(&path).unwrap_or_default();
            if let Some(pid) = text.strip_suffix('\n') {
                break pid.parse().unwrap();
            }
            thread::yield_now();
        };
        for event in ["b", "c"] {
            hook.pass(event.to_owned()).unwrap();
        }
        let problems = hook.finish();
        let ended = "had not ended at the end of the session and was ended";
        assert!(problems[0].ends_with(ended), "{problems:?}");
        let lost = ": 2 alarm events not passed, because the session ended";
        assert!(problems[1].ends_with(lost), "{problems:?}");
        assert_eq!(problems.len(), 2);
        assert!(test_kill_process_group(Pid::from_raw(pid).unwrap()).is_err());
    }

    #[test]
    fn the_configuration_says_how_long_a_command_may_take() {
        let said = format!("It may take {} s;", TIME_MAX.as_secs());
        let template = include_str!("../commands/config/default.toml");
        assert!(template.contains(&said), "{said}");
    }

    #[tokio::test]
    async fn a_slow_command_delays_nothing_and_is_ended() {
        let mut hook =
            AlarmHook::start_for("cat; sleep 1000", Duration::ZERO, Duration::ZERO).unwrap();
        hook.pass("x".repeat(1000)).unwrap();
        let problem = hook.next_problem().await;
        assert!(
            problem.ends_with("took longer than 0 s and was ended"),
            "{problem}"
        );
        // It ends with the tests.
        let endless = "while kill -0 $PPID 2> /dev/null; do sleep 0.1; done";
        let endless = AlarmHook::start(endless).unwrap();
        let full = (0..=WAITING_MAX + 1).find_map(|_| endless.pass(String::new()).err());
        assert!(full.is_some_and(|words| words.starts_with("64 events wait")));
    }
}
