//! The alarm hook: runs the operator's command for each alarm event.
//!
//! A thread runs the command for one event after another, so a slow command delays neither the link nor the screen.

use std::io::{self, Write as _};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use tokio::sync::mpsc;

use crate::hint;

/// Maximum number of queued events.
const WAITING_MAX: usize = 64;

/// Maximum run time of the command for one event.
const TIME_MAX: Duration = Duration::from_secs(30);

/// Period of the checks whether the command has ended.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Runs a shell command for each event.
pub struct AlarmHook {
    events: SyncSender<String>,
    problems: mpsc::UnboundedReceiver<String>,
}

impl AlarmHook {
    /// Starts the thread for a command.
    ///
    /// # Errors
    /// If no thread can be started.
    pub fn start(command: &str) -> io::Result<Self> {
        Self::start_for(command, TIME_MAX)
    }

    fn start_for(command: &str, time_max: Duration) -> io::Result<Self> {
        let (events, queue) = sync_channel(WAITING_MAX);
        let (tell, problems) = mpsc::unbounded_channel();
        let command = command.to_owned();
        thread::Builder::new()
            .name("alarm hook".to_owned())
            .spawn(move || serve(&command, time_max, &queue, &tell))?;
        Ok(Self { events, problems })
    }

    /// Passes an event, one line of JSON. Never waits.
    ///
    /// # Errors
    /// If the command is so slow that too many events wait.
    pub fn pass(&self, event: String) -> Result<(), String> {
        match self.events.try_send(event) {
            Ok(()) => Ok(()),
            Err(TrySendError::Full(_)) => Err(format!(
                "{WAITING_MAX} events wait for the alarm hook, so this one is not passed to it"
            )),
            Err(TrySendError::Disconnected(_)) => Err("the alarm hook has ended".to_owned()),
        }
    }

    /// The next problem of the command. Cancel-safe.
    pub async fn next_problem(&mut self) -> String {
        match self.problems.recv().await {
            Some(problem) => problem,
            None => std::future::pending().await,
        }
    }
}

/// Runs the command for each event until the queue is closed.
fn serve(
    command: &str,
    time_max: Duration,
    queue: &Receiver<String>,
    tell: &mpsc::UnboundedSender<String>,
) {
    for event in queue {
        let problem = match run(command, time_max, &event) {
            Ok(Some(status)) if status.success() => continue,
            Ok(Some(status)) => format!("ended with {status}"),
            Ok(None) => format!("took longer than {} s and was ended", time_max.as_secs()),
            Err(error) => format!("failed: {}", hint::words(&error)),
        };
        // At the end of the session, the problem is not reported.
        let _ = tell.send(format!("alarm hook `{command}` {problem}"));
    }
}

/// Runs the command with an event on its standard input; returns `None` if it took too long.
fn run(command: &str, time_max: Duration, event: &str) -> io::Result<Option<ExitStatus>> {
    let mut child = shell(command)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    if let Some(mut input) = child.stdin.take() {
        // The command need not read its input.
        let _ = writeln!(input, "{event}");
    }
    let begun = Instant::now();
    while begun.elapsed() < time_max {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        thread::sleep(LOOK_EVERY);
    }
    end(&mut child);
    child.wait()?;
    Ok(None)
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

    #[tokio::test]
    async fn a_slow_command_delays_nothing_and_is_ended() {
        let mut hook = AlarmHook::start_for("cat; sleep 1000", Duration::ZERO).unwrap();
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
