//! Why a plugin is refused.

use std::path::PathBuf;

use leafwise_plugin_abi::{LW_ABI_MAJOR, LW_ABI_MINOR, LW_ENTRY_SYMBOL_STEM};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::smoke_failure::SmokeFailure;

/// A plugin that was refused: nothing of it is registered, and nothing of it will be called.
#[derive(Clone, Debug, PartialEq, Error, Serialize, Deserialize)]
#[error("plugin {}: {refusal}", plugin.display())]
pub struct PluginError {
    /// The file, or the name it was asked for by.
    pub plugin: PathBuf,
    /// Why.
    #[source]
    pub refusal: Refusal,
}

/// Causes of a [`PluginError`], in the order in which they are looked for.
///
/// They cross from the probe's process to the program's as JSON, so every field is plain data.
#[derive(Clone, Debug, PartialEq, Error, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Refusal {
    /// Loading is switched off.
    #[error("plugins are switched off (--no-plugins, or LEAFWISE_NO_PLUGINS is set)")]
    SwitchedOff,
    /// This system has no loader that these checks are written for.
    #[error("plugins are loaded on Unix systems only")]
    Platform,
    /// No such file.
    #[error("there is no such file")]
    NoSuchFile,
    /// A name without a folder that no folder of the search path holds.
    #[error(
        "no folder of the search path holds it: {}; {}give a path with a `/`, or set \
         LEAFWISE_PLUGIN_PATH",
        list(.searched),
        if *.is_here { "a file of that name is in this folder, which is not searched: " } else { "" }
    )]
    NotFound {
        /// The folders, in the order searched.
        searched: Vec<PathBuf>,
        /// Whether the path, taken from the scene's folder, leads to something.
        is_here: bool,
    },
    /// The file cannot be read.
    #[error("the file cannot be read: {message}")]
    Unreadable {
        /// The system's words.
        message: String,
    },
    /// A folder, a device, a pipe.
    #[error("it is not a regular file")]
    NotAFile,
    /// Someone other than its owner could replace it.
    #[error(
        "{} is writable by {who} (mode {mode:04o}), who could run code as you: \
         chmod go-w it, or move the plugin", place.display()
    )]
    WritableByOthers {
        /// The file, or a folder above it.
        place: PathBuf,
        /// Its permission bits.
        mode: u32,
        /// `its group`, `everyone`.
        who: String,
    },
    /// Another user could replace it.
    #[error(
        "{} belongs to another user (uid {owner}), who may replace it and so run code as you: chown \
         it, or copy the plugin to a folder of your own", place.display()
    )]
    OwnedByOther {
        /// The file, a folder above it, or a link on the way to it.
        place: PathBuf,
        /// Its owner.
        owner: u32,
    },
    /// Not a shared library at all.
    #[error(
        "not a shared library ({})",
        if first.is_empty() { "the file is empty".to_owned() }
        else { format!("first bytes {first:02x?}") }
    )]
    NotALibrary {
        /// The file's first bytes.
        first: Vec<u8>,
    },
    /// An object file or a program.
    #[error("an object file or a program, and not a shared library; link it with -shared")]
    NotShared,
    /// A shared library for another kind of machine.
    #[error("a library for {found}, and this program is one for {host}; build it for this machine")]
    Machine {
        /// The machine that the file is for.
        found: String,
        /// The machine that the program is for.
        host: String,
    },
    /// Another file than the one that was meant.
    #[error("its sha256 is {found}, and {expected} is required")]
    Hash {
        /// The hash given by the scene or the side file.
        expected: String,
        /// The file's hash.
        found: String,
    },
    /// A file that was written or replaced while it was being loaded.
    #[error("it was changed while it was being loaded; try again")]
    Changed,
    /// A side file that says something else than can be read.
    #[error("the side file {} cannot be used: {message}", file.display())]
    SideFile {
        /// The side file.
        file: PathBuf,
        /// The problem: why the side file cannot be used.
        message: String,
    },
    /// The probe's process could not be started.
    #[error("probe: the child process could not be started: {message}")]
    ProbeNotStarted {
        /// The system's words.
        message: String,
    },
    /// Opening or calling the library killed the process that tried it.
    #[error(
        "probe: child killed by signal {signal}{}; the library is damaged or crashes when it is \
         loaded{}", named(.name), said(.output)
    )]
    ProbeKilled {
        /// The signal's number.
        signal: i32,
        /// Its name.
        name: Option<String>,
        /// The last lines the child wrote to standard error.
        output: String,
    },
    /// The library ended the process that tried it.
    #[error("probe: child ended with exit code {code} and no report{}", said(.output))]
    ProbeExited {
        /// The exit code.
        code: i32,
        /// The last lines the child wrote to standard error.
        output: String,
    },
    /// Opening or calling the library took too long.
    #[error("probe: no report within {seconds} s: the library hangs when it is loaded or called")]
    ProbeTimedOut {
        /// The time limit.
        seconds: f64,
    },
    /// Measuring the library ended or stopped the process that did.
    #[error(
        "the process that measured it {how}, before it was done: a call into the library does not \
         return"
    )]
    NotMeasured {
        /// How that process ended.
        how: String,
    },
    /// The system's loader refuses the library.
    #[error("it cannot be opened: {message}")]
    Open {
        /// The loader's words: an unresolved symbol, a missing dependency.
        message: String,
    },
    /// The library's constructors changed how this thread rounds.
    #[error(
        "floating-point environment changed when it was {when} (control word {before:#06x} -> \
         {after:#06x}{}); build it without -Ofast and -ffast-math",
        if *flushes { ": subnormal numbers become 0" } else { "" }
    )]
    FloatingPoint {
        /// `opened`, or what was called.
        when: String,
        /// The control word before.
        before: u64,
        /// The control word after.
        after: u64,
        /// Whether subnormal results became 0.
        flushes: bool,
    },
    /// No entry function of this version.
    #[error(
        "no entry point {LW_ENTRY_SYMBOL_STEM}{LW_ABI_MAJOR}{}", offer(.offers)
    )]
    NoEntryPoint {
        /// The major versions for which it has one.
        offers: Vec<u32>,
    },
    /// The entry function returned NULL.
    #[error("entry returned NULL")]
    NullEntry,
    /// A pointer that cannot point to what it should.
    #[error("{what} is not aligned")]
    Misaligned {
        /// The struct or list that the pointer should point to.
        what: String,
    },
    /// The entry does not begin with the magic bytes.
    #[error("bad magic {found:02x?}, expected the letters LEAFWISE")]
    BadMagic {
        /// The first eight bytes of the entry.
        found: [u8; 8],
    },
    /// Another version of the interface.
    #[error(
        "plugin ABI {major}.{minor}, host supports {LW_ABI_MAJOR}.0 to \
         {LW_ABI_MAJOR}.{LW_ABI_MINOR}"
    )]
    Abi {
        /// The major version.
        major: u16,
        /// The lowest minor version that the plugin needs.
        minor: u16,
    },
    /// A struct of an impossible size.
    #[error(
        "{what}: struct_size {found} is impossible; it is a multiple of 8 and at least {least}"
    )]
    StructSize {
        /// The struct.
        what: String,
        /// The size it states.
        found: u32,
        /// The smallest size with the fields that every version has.
        least: u32,
    },
    /// Another floating-point type.
    #[error("its real numbers have {found} bytes, the host's 8")]
    RealBytes {
        /// The size it states.
        found: u32,
    },
    /// A list that is missing or has an impossible length.
    #[error("{what}: {problem}")]
    List {
        /// The list.
        what: String,
        /// The problem with the list: it is NULL, too long, or has a NULL entry.
        problem: String,
    },
    /// A string that is missing, endless or not UTF-8.
    #[error("{what} {problem}")]
    Text {
        /// The string.
        what: String,
        /// `is NULL`, `has no end within 4096 bytes`, …
        problem: String,
    },
    /// An id that is not `vendor/name`, or of another vendor.
    #[error("part id `{id}`: {problem}")]
    Id {
        /// The id.
        id: String,
        /// The problem with the id.
        problem: String,
    },
    /// A function that its kind of part cannot do without.
    #[error("part {part}: required function `{function}` is NULL")]
    MissingFunction {
        /// The part.
        part: String,
        /// The function.
        function: String,
    },
    /// A declaration that contradicts itself or the interface.
    #[error("part {part}: {problem}")]
    Declaration {
        /// The part.
        part: String,
        /// The contradiction, in words.
        problem: String,
    },
    /// A formula that cannot be used.
    #[error("part {part}: formula `{key}`: {problem}")]
    Formula {
        /// The part.
        part: String,
        /// The formula's key.
        key: String,
        /// The problem with the formula, and its place.
        problem: String,
    },
    /// Two parts of the plugin with one id.
    #[error("it offers two parts called `{id}`")]
    TwoOfOneId {
        /// The id.
        id: String,
    },
    /// A part that breaks the contract when it is tried.
    #[error("part {part}: {failure}")]
    Smoke {
        /// The part.
        part: String,
        /// How.
        failure: SmokeFailure,
    },
    /// An id that another part has.
    #[error("{message}")]
    Duplicate {
        /// The id.
        id: String,
        /// Where the part comes from that has it already.
        taken_by: String,
        /// The registry's words.
        message: String,
    },
}

impl Refusal {
    /// The error of this plugin.
    pub fn of(self, plugin: impl Into<PathBuf>) -> PluginError {
        PluginError {
            plugin: plugin.into(),
            refusal: self,
        }
    }
}

fn list(folders: &[PathBuf]) -> String {
    if folders.is_empty() {
        return "there is none".to_owned();
    }
    let shown: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
    shown.join(", ")
}

fn named(name: &Option<String>) -> String {
    name.as_ref()
        .map_or_else(String::new, |name| format!(" ({name})"))
}

fn said(output: &str) -> String {
    if output.is_empty() {
        String::new()
    } else {
        format!("; it wrote: {output}")
    }
}

fn offer(versions: &[u32]) -> String {
    if versions.is_empty() {
        return ": not a Leafwise plugin".to_owned();
    }
    let shown: Vec<String> = versions.iter().map(|v| format!("v{v}")).collect();
    format!(" (it offers {})", shown.join(", "))
}
