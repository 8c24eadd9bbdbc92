//! Systems that plugins are not loaded on.

use std::fs::{File, Metadata};
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};

use libloading::Library;

use crate::error::Refusal;

pub(crate) fn identity(_: &Metadata) -> (u64, u64) {
    (0, 0)
}

pub(crate) fn state(_: &Metadata) -> (u64, u64, i128) {
    (0, 0, 0)
}

pub(crate) fn other_owner(_: &Metadata) -> Option<u32> {
    None
}

pub(crate) fn other_writers(_: &Metadata) -> Option<(&'static str, u32)> {
    None
}

pub(crate) fn has_raised_privileges() -> bool {
    true
}

pub(crate) fn signal(_: ExitStatus) -> Option<(i32, Option<&'static str>)> {
    None
}

pub(crate) fn own_group(_: &mut Command) {}

pub(crate) fn kill_group(child: &mut Child) {
    // A child that has ended already needs no end.
    drop(child.kill());
}

pub(crate) fn at_exit(_: extern "C" fn()) {}

pub(crate) fn end_now(_: &str) -> ! {
    std::process::exit(1)
}

pub(crate) fn own_output() -> io::Result<File> {
    Err(io::ErrorKind::Unsupported.into())
}

pub(crate) fn no_core_dumps() {}

pub(crate) fn static_data(_: *const ()) -> Option<Vec<u8>> {
    None
}

pub(crate) unsafe fn open(_: &Path) -> Result<Library, Refusal> {
    Err(Refusal::Platform)
}
