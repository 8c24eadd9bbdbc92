//! When a kernel is compiled to machine code, and what was.

use std::fmt;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use super::MachineCode;
use super::code::Code;
use super::distances::{Distances, Passes};

/// How kernels run. The results have the same bits either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Execution {
    /// By the interpreter.
    Interpreted,
    /// By machine code from the first evaluation on, where the platform has a compiler.
    Compiled,
    /// By the interpreter until machine code would have paid for its compilation.
    #[default]
    Adaptive,
}

static DEFAULT: AtomicU8 = AtomicU8::new(Execution::Adaptive as u8);

impl Execution {
    /// Execution that [`Kernel::workspace`](super::Kernel::workspace) takes, in the whole process.
    pub fn default_of_process() -> Self {
        match DEFAULT.load(Ordering::Relaxed) {
            0 => Self::Interpreted,
            1 => Self::Compiled,
            _ => Self::Adaptive,
        }
    }

    /// Name of the execution on this machine, for reports: interpreter, machine code, or one and
    /// then the other.
    pub fn describe(self) -> &'static str {
        match self {
            _ if !MachineCode::is_available() => "interpreter",
            Self::Interpreted => "interpreter",
            Self::Compiled => "machine code",
            Self::Adaptive => "interpreter, then machine code",
        }
    }

    /// Sets what [`Kernel::workspace`](super::Kernel::workspace) takes from now on.
    pub fn set_default_of_process(self) {
        DEFAULT.store(self as u8, Ordering::Relaxed);
    }
}

/// A workspace reports its evaluations at most this many at a time.
pub(super) const REPORT: u8 = 64;

/// Machine code of one kernel, for each number of lanes.
#[derive(Debug, Default)]
pub(super) struct Compiled {
    entries: Mutex<Vec<Entry>>,
    /// Of code along an array.
    distances: Option<Distances>,
}

#[derive(Debug)]
struct Entry {
    lanes: usize,
    evaluations: u64,
    /// `None` before a compilation was tried, `Some(None)` where it failed.
    machine: Option<Option<Arc<MachineCode>>>,
}

impl Compiled {
    /// Nothing yet, of code along an array.
    pub(super) fn along(distances: Distances) -> Self {
        Self {
            distances: Some(distances),
            ..Self::default()
        }
    }

    /// Whether there is code along an array, and its inputs and outputs [fit](Distances::fit).
    pub(super) fn fits(&self, passes: &Passes, length: usize) -> bool {
        let distances = self.distances.as_ref();
        distances.is_some_and(|distances| distances.fit(passes, length))
    }

    /// Machine code for `lanes` lanes if there is any, compiling it where `now` asks for it.
    pub(super) fn get(&self, code: &Code, lanes: usize, now: bool) -> Option<Arc<MachineCode>> {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let entry = find(&mut entries, lanes);
        if now {
            entry.compile(code, self.distances.as_ref());
        }
        entry.machine.clone().flatten()
    }

    /// Machine code for `lanes` lanes of what runs once in a while, where that is wanted or pays.
    pub(super) fn once(
        &self,
        code: &Code,
        lanes: usize,
        execution: Execution,
    ) -> Option<Arc<MachineCode>> {
        match execution {
            Execution::Interpreted => None,
            Execution::Compiled => self.get(code, lanes, true),
            Execution::Adaptive => self.report(code, lanes, 1),
        }
    }

    /// Counts so many evaluations of `lanes` lanes; returns machine code once it pays. While
    /// another thread compiles, this one goes on without.
    pub(super) fn report(
        &self,
        code: &Code,
        lanes: usize,
        evaluations: u32,
    ) -> Option<Arc<MachineCode>> {
        let mut entries = match self.entries.try_lock() {
            Ok(entries) => entries,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return None,
        };
        let entry = find(&mut entries, lanes);
        entry.evaluations += u64::from(evaluations);
        if entry.evaluations >= MachineCode::evaluations_to_pay(lanes) {
            entry.compile(code, self.distances.as_ref());
        }
        entry.machine.clone().flatten()
    }

    /// Sizes and compilation times of the machine code, for each number of lanes that has some.
    pub(super) fn describe(&self) -> Vec<MachineCodeSize> {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries
            .iter()
            .filter_map(|entry| {
                let machine = entry.machine.as_ref()?.as_ref()?;
                Some(MachineCodeSize {
                    lanes: entry.lanes,
                    bytes: machine.bytes(),
                    seconds: machine.seconds(),
                })
            })
            .collect()
    }
}

fn find(entries: &mut Vec<Entry>, lanes: usize) -> &mut Entry {
    let at = entries.iter().position(|entry| entry.lanes == lanes);
    let at = at.unwrap_or_else(|| {
        entries.push(Entry {
            lanes,
            evaluations: 0,
            machine: None,
        });
        entries.len() - 1
    });
    &mut entries[at]
}

impl Entry {
    fn compile(&mut self, code: &Code, distances: Option<&Distances>) {
        self.machine
            .get_or_insert_with(|| MachineCode::compile(code, self.lanes, distances).map(Arc::new));
    }
}

/// The machine code of a kernel for one number of lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineCodeSize {
    /// The number of lanes.
    pub lanes: usize,
    /// The length of the code.
    pub bytes: usize,
    /// How long the compilation took.
    pub seconds: f64,
}

impl fmt::Display for MachineCodeSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { lanes, bytes, .. } = self;
        match lanes {
            1 => write!(f, "{bytes} bytes for one lane"),
            _ => write!(f, "{bytes} bytes for {lanes} lanes"),
        }
    }
}
