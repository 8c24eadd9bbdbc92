//! The trial in a child process: a library that crashes or hangs does so there.
//!
//! - `child`: what that process does;
//! - `cache`: files that passed before.

mod cache;
mod child;

use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::error::Refusal;
use crate::platform;
pub(crate) use cache::ProbeCache;
pub use child::run_probe;

/// The mark that stands before the report on the child's standard output, where libraries may write too.
const MARK: &str = "leafwise-plugin-probe:";

/// The time that opening and trying a library may take.
pub const TIME_LIMIT: Duration = Duration::from_secs(20);

/// How the child process is started: the program itself with a hidden command, or
/// `leafwise-plugin-probe` for programs that cannot start themselves again. The library's path is
/// added as the last argument; the process calls [`run_probe`] with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbeCommand {
    /// The executable.
    pub program: PathBuf,
    /// Its arguments before the path.
    pub arguments: Vec<OsString>,
    /// How long it may take.
    pub time_limit: Duration,
}

impl ProbeCommand {
    /// A command with the usual time limit.
    pub fn new(program: impl Into<PathBuf>, arguments: impl IntoIterator<Item = OsString>) -> Self {
        Self {
            program: program.into(),
            arguments: arguments.into_iter().collect(),
            time_limit: TIME_LIMIT,
        }
    }

    /// Tries a library in a child process.
    ///
    /// # Errors
    /// What the child found wrong, or how it ended without a word.
    pub fn try_library(&self, path: &Path) -> Result<(), Refusal> {
        let not_started = |error: std::io::Error| Refusal::ProbeNotStarted {
            message: format!("{}: {error}", self.program.display()),
        };
        let mut command = Command::new(&self.program);
        command
            .args(&self.arguments)
            .arg(path)
            // What a panic says is worth more than where it was.
            .env("RUST_BACKTRACE", "0")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        platform::own_group(&mut command);
        let mut child = command.spawn().map_err(not_started)?;
        let report = child
            .stdout
            .take()
            .map(|out| read_in_thread(out, send_reports));
        let output = child
            .stderr
            .take()
            .map(|err| read_in_thread(err, send_last_lines));
        let Some(status) = wait(&mut child, self.time_limit).map_err(not_started)? else {
            platform::kill_group(&mut child);
            child.wait().map_err(not_started)?;
            return Err(Refusal::ProbeTimedOut {
                seconds: self.time_limit.as_secs_f64(),
            });
        };
        let report = report.and_then(|report| received(&report));
        if let Some(report) = report {
            return report;
        }
        let output = output
            .and_then(|output| received(&output))
            .unwrap_or_default();
        Err(died(status, output))
    }
}

/// Waits for the end of the child, `None` where the time is over.
fn wait(child: &mut Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let end = Instant::now() + limit;
    let mut pause = Duration::from_millis(1);
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if Instant::now() >= end {
            return Ok(None);
        }
        thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(20));
    }
}

/// Reads a pipe to its end beside the waiting, so that the child never blocks on it. Nobody waits any
/// more where the receiver is gone.
fn read_in_thread<T: Send + 'static>(
    pipe: impl Read + Send + 'static,
    read: impl FnOnce(Box<dyn BufRead>, &Sender<T>) + Send + 'static,
) -> Receiver<T> {
    let (sender, receiver) = channel();
    thread::spawn(move || read(Box::new(BufReader::new(pipe)), &sender));
    receiver
}

/// The last that a reader found, once the child has ended. A process that the library started may hold
/// the pipe open for ever: its end is not waited for.
fn received<T>(receiver: &Receiver<T>) -> Option<T> {
    let first = receiver.recv_timeout(Duration::from_secs(2)).ok()?;
    Some(receiver.try_iter().last().unwrap_or(first))
}

/// The reports among what the child and the library write, each as soon as its line is there.
fn send_reports(pipe: Box<dyn BufRead>, sender: &Sender<Result<(), Refusal>>) {
    for line in pipe.split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line);
        if let Some((_, json)) = line.split_once(MARK)
            && let Ok(refusal) = serde_json::from_str::<Option<Refusal>>(json)
        {
            drop(sender.send(refusal.map_or(Ok(()), Err)));
        }
    }
}

/// The end of what was written to standard error, for messages.
fn send_last_lines(pipe: Box<dyn BufRead>, sender: &Sender<String>) {
    const MOST: usize = 400;
    let mut kept = Vec::new();
    for line in pipe.split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line).trim().to_owned();
        if !line.is_empty() {
            kept.push(line);
        }
        if kept.len() > 3 {
            kept.remove(0);
        }
    }
    let text = kept.join(" | ");
    drop(sender.send(text.chars().take(MOST).collect()));
}

fn died(status: ExitStatus, output: String) -> Refusal {
    match platform::signal(status) {
        Some((signal, name)) => Refusal::ProbeKilled {
            signal,
            name: name.map(str::to_owned),
            output,
        },
        None => Refusal::ProbeExited {
            code: status.code().unwrap_or(-1),
            output,
        },
    }
}
