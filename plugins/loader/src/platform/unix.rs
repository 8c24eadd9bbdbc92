//! Unix: permissions, identity of files, signals, `dlopen`.

use std::error::Error;
use std::fs::Metadata;
use std::os::unix::fs::MetadataExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus};

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

use crate::error::Refusal;

/// A file's identity: links to one file share it.
pub(crate) fn identity(metadata: &Metadata) -> (u64, u64) {
    (metadata.dev(), metadata.ino())
}

/// Who beside the owner may write, with the permission bits. In a folder with the sticky bit nobody
/// may replace what belongs to others.
pub(crate) fn other_writers(metadata: &Metadata) -> Option<(&'static str, u32)> {
    const STICKY: u32 = 0o1000;
    const GROUP: u32 = 0o020;
    const EVERYONE: u32 = 0o002;
    let mode = metadata.mode() & 0o7777;
    if metadata.is_dir() && mode & STICKY != 0 {
        return None;
    }
    match mode {
        _ if mode & EVERYONE != 0 => Some(("everyone", mode)),
        _ if mode & GROUP != 0 => Some(("its group", mode)),
        _ => None,
    }
}

/// Whether the program runs with more rights than its caller has (set-user-id, capabilities): what
/// the caller says in the environment is not to be trusted then.
pub(crate) fn has_raised_privileges() -> bool {
    // SAFETY: these calls take no pointers and cannot fail.
    let changed = unsafe { libc::getuid() != libc::geteuid() || libc::getgid() != libc::getegid() };
    #[cfg(target_os = "linux")]
    // SAFETY: as above.
    let changed = changed || unsafe { libc::getauxval(libc::AT_SECURE) } != 0;
    changed
}

/// The signal that ended a process, with its name.
pub(crate) fn signal(status: ExitStatus) -> Option<(i32, Option<&'static str>)> {
    let signal = status.signal()?;
    let name = match signal {
        libc::SIGABRT => Some("SIGABRT"),
        libc::SIGBUS => Some("SIGBUS"),
        libc::SIGFPE => Some("SIGFPE"),
        libc::SIGILL => Some("SIGILL"),
        libc::SIGKILL => Some("SIGKILL"),
        libc::SIGSEGV => Some("SIGSEGV"),
        libc::SIGTRAP => Some("SIGTRAP"),
        _ => None,
    };
    Some((signal, name))
}

/// Puts a process that will be started into a group of its own.
pub(crate) fn own_group(command: &mut Command) {
    command.process_group(0);
}

/// Ends a process and those it started.
pub(crate) fn kill_group(child: &mut Child) {
    if let Ok(group) = i32::try_from(child.id()) {
        // SAFETY: the call takes no pointers; the group is the one the child was put into, and the
        // child has not been waited for, so its id still stands for it.
        unsafe { libc::kill(-group, libc::SIGKILL) };
    }
}

/// No memory image is written when this process crashes.
pub(crate) fn no_core_dumps() {
    let none = libc::rlimit {
        rlim_cur: 0,
        rlim_max: 0,
    };
    // SAFETY: the pointer is to a live struct that the call only reads.
    unsafe { libc::setrlimit(libc::RLIMIT_CORE, &none) };
}

/// Opens a library for good: all its symbols are resolved now and are seen by nobody else, and it
/// stays in memory until the process ends.
///
/// # Safety
/// Opening a library runs its constructors: whoever asks for it trusts the file.
pub(crate) unsafe fn open(path: &Path) -> Result<Library, Refusal> {
    let flags = RTLD_NOW | RTLD_LOCAL | libc::RTLD_NODELETE;
    // SAFETY: passed on to the caller.
    unsafe { Library::open(Some(path), flags) }.map_err(|error| Refusal::Open {
        // libloading's own text says only that opening failed.
        message: error
            .source()
            .map_or_else(|| error.to_string(), ToString::to_string),
    })
}
