//! Unix: permissions, identity of files, signals, `dlopen`.

use std::error::Error;
use std::fs::{File, Metadata};
use std::io;
use std::os::fd::AsFd;
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

/// The same with the time when anything of the file was last changed, its names included.
pub(crate) fn state(metadata: &Metadata) -> (u64, u64, i128) {
    let seconds = i128::from(metadata.ctime());
    let changed = seconds * 1_000_000_000 + i128::from(metadata.ctime_nsec());
    (metadata.dev(), metadata.ino(), changed)
}

/// The owner, where that is neither root nor the user whose rights this program has.
pub(crate) fn other_owner(metadata: &Metadata) -> Option<u32> {
    // SAFETY: the call takes no pointers and cannot fail.
    let own = unsafe { libc::geteuid() };
    let owner = metadata.uid();
    (owner != 0 && owner != own).then_some(owner)
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

/// Has a function called when the process ends in an orderly way.
pub(crate) fn at_exit(function: extern "C" fn()) {
    // SAFETY: the function belongs to this program, which is in memory until the process ends. Where
    // there is no room for it, nothing is guarded.
    unsafe { libc::atexit(function) };
}

/// Writes a text to standard error and ends the process with code 1, whatever else was to be done.
pub(crate) fn end_now(text: &str) -> ! {
    // SAFETY: the bytes are those of a live text; the second call does not return.
    unsafe {
        libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len());
        libc::_exit(1)
    }
}

/// A handle of what standard output is, and standard error in its place from now on.
pub(crate) fn own_output() -> io::Result<File> {
    let own = io::stdout().as_fd().try_clone_to_owned()?;
    // SAFETY: the call takes no pointers; both descriptors are those of the standard streams.
    if unsafe { libc::dup2(libc::STDERR_FILENO, libc::STDOUT_FILENO) } < 0 {
        return Err(io::Error::last_os_error());
    }
    Ok(File::from(own))
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

/// Opens a library for good: all its symbols are resolved now and are seen by nobody else. It stays in memory until the
/// process ends.
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

/// The bytes that the library with this address may change: its variables, also those that are zero at first. The
/// result is `None` where there are too many of them, or the system does not say where they are.
#[cfg(target_os = "linux")]
pub(crate) fn static_data(address: *const ()) -> Option<Vec<u8>> {
    /// More are not copied.
    const MOST: usize = 1 << 26;
    struct Search {
        address: usize,
        found: Option<Vec<u8>>,
    }
    /// # Safety
    /// `info` describes a library that stays in memory; `data` is a `Search`.
    unsafe extern "C" fn visit(
        info: *mut libc::dl_phdr_info,
        _: libc::size_t,
        data: *mut libc::c_void,
    ) -> libc::c_int {
        // SAFETY: passed on to the caller; the list has as many entries as it says.
        let (search, base, headers) = unsafe {
            let info = &*info;
            let headers = std::slice::from_raw_parts(info.dlpi_phdr, info.dlpi_phnum.into());
            (
                &mut *data.cast::<Search>(),
                info.dlpi_addr as usize,
                headers,
            )
        };
        let loaded = || {
            headers
                .iter()
                .filter(|header| header.p_type == libc::PT_LOAD)
        };
        let start = |header: &libc::Elf64_Phdr| base.wrapping_add(header.p_vaddr as usize);
        let holds = |header: &libc::Elf64_Phdr| {
            (start(header)..start(header) + header.p_memsz as usize).contains(&search.address)
        };
        if !loaded().any(holds) {
            return 0;
        }
        let writable = || loaded().filter(|header| header.p_flags & libc::PF_W != 0);
        if writable()
            .map(|header| header.p_memsz as usize)
            .sum::<usize>()
            <= MOST
        {
            let mut bytes = Vec::new();
            for header in writable() {
                let from = std::ptr::with_exposed_provenance::<u8>(start(header));
                // SAFETY: a segment of a library that is never closed; no call into it is under way.
                let segment = unsafe { std::slice::from_raw_parts(from, header.p_memsz as usize) };
                bytes.extend_from_slice(segment);
            }
            search.found = Some(bytes);
        }
        1
    }
    let mut search = Search {
        address: address.addr(),
        found: None,
    };
    // SAFETY: the function takes what it is given here.
    unsafe { libc::dl_iterate_phdr(Some(visit), (&raw mut search).cast()) };
    search.found
}

/// As there is no way to ask.
#[cfg(not(target_os = "linux"))]
pub(crate) fn static_data(_: *const ()) -> Option<Vec<u8>> {
    None
}
