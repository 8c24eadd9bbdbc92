//! `leafwise plugin check`: the process that waits for the one that measures.
//!
//! A library may end, crash or stop the process that calls it at any moment: what was measured counts
//! where that process says that it came to its end.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use leafwise::plugins::Refusal;

use crate::arguments::PluginCheckArguments;
use crate::console::Console;
use crate::failure::Failure;
use crate::plugins::own_program;

/// Beginning of the last line that the measuring process writes, before its exit code.
const COMPLETED: &str = "leafwise-plugin-check: ";

/// A part is measured within seconds; what says nothing for so long hangs.
const SILENCE: Duration = Duration::from_secs(600);

/// The last line of the process that measures.
pub fn completed(code: u8) -> String {
    format!("{COMPLETED}{code}")
}

/// Measures in a process of its own, whose lines are passed on; returns its exit code.
///
/// # Errors
/// [`Failure::Plugin`] where that process did not come to its end.
pub fn execute(
    arguments: &PluginCheckArguments,
    given: &[OsString],
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let refused = |refusal: Refusal| Failure::plugin(refusal.of(&arguments.path), None);
    let mut child = start(own_program(), given).map_err(|refusal| refused(*refusal))?;
    let lines = child.stdout.take().map(lines_of);
    let mut kept = Vec::new();
    let mut code = None;
    let mut is_silent = false;
    while let Some(lines) = &lines {
        match lines.recv_timeout(SILENCE) {
            Ok(line) => match line.strip_prefix(COMPLETED) {
                Some(own) => code = own.parse::<u8>().ok(),
                None if arguments.json => kept.push(line),
                None => console.result(&line),
            },
            Err(error) => {
                is_silent = error == std::sync::mpsc::RecvTimeoutError::Timeout;
                break;
            }
        }
    }
    if is_silent {
        // A process that has ended meanwhile needs no end.
        drop(child.kill());
    }
    let ended = child.wait();
    if let Some(code) = code {
        if !kept.is_empty() {
            console.verbatim(&kept.join("\n"));
        }
        return Ok(code);
    }
    Err(refused(Refusal::NotMeasured {
        how: how(is_silent, ended.ok()),
    }))
}

/// The same command in a process that measures.
fn start(
    (own, arguments): (PathBuf, Vec<OsString>),
    given: &[OsString],
) -> Result<Child, Box<Refusal>> {
    Command::new(&own)
        .args(arguments)
        .arg("--measures-here")
        .args(given.iter().skip(1))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| {
            Box::new(Refusal::ProbeNotStarted {
                message: format!("{}: {error}", own.display()),
            })
        })
}

/// The lines of a pipe, each as soon as it is there.
fn lines_of(pipe: impl std::io::Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        for line in BufReader::new(pipe).split(b'\n').map_while(Result::ok) {
            if sender
                .send(String::from_utf8_lossy(&line).into_owned())
                .is_err()
            {
                return;
            }
        }
    });
    receiver
}

fn how(is_silent: bool, status: Option<ExitStatus>) -> String {
    match status {
        _ if is_silent => format!("said nothing for {} s", SILENCE.as_secs()),
        Some(status) => format!("ended with {status}"),
        None => "ended".to_owned(),
    }
}
