//! One compiled kernel.

use std::fmt;
use std::time::Instant;

#[cfg(all(target_arch = "x86_64", not(windows)))]
use super::avx;
use super::executable::{Executable, Written};
#[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
use super::portable;
use super::program::Program;
#[cfg(all(target_arch = "x86_64", not(windows)))]
use super::registers::is_call;
use crate::analytic::AnalyticFunction;
use crate::kernel::code::{Code, Instruction};

/// The largest program in bytes of slots: offsets have 31 bits.
const MOST_BYTES: usize = 1 << 30;

/// What writes machine code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Backend {
    /// Our own assembler, so many lanes an instruction.
    #[cfg(all(target_arch = "x86_64", not(windows)))]
    Avx(avx::Width),
    /// Cranelift.
    #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
    Portable,
}

impl Backend {
    /// The fastest for so many lanes on this machine, `None` where none serves it.
    pub(super) fn best(lanes: usize) -> Option<Self> {
        #[cfg(all(target_arch = "x86_64", not(windows)))]
        if let Some(width) = avx::Width::best(lanes) {
            return Some(Self::Avx(width));
        }
        let _ = lanes;
        #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
        if portable::is_available() {
            return Some(Self::Portable);
        }
        None
    }

    /// How many numbers it holds in registers.
    fn registers(self) -> usize {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(width) => width.registers() - 1,
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => 15,
        }
    }

    /// Whether it calls two functions of a pair at once.
    fn calls_pairs(self) -> bool {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(_) => true,
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => false,
        }
    }

    fn write(
        self,
        program: &Program,
        lanes: usize,
        functions: &[AnalyticFunction],
    ) -> Option<Written> {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(width) => avx::write(program, lanes, width, functions),
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => portable::write(program, lanes, functions),
        }
    }
}

/// `fn(slots, scratch)`.
type Entry = unsafe extern "C" fn(*mut f64, *mut f64);

/// The machine code of one program for one number of lanes.
pub(crate) struct MachineCode {
    entry: Entry,
    slots: usize,
    scratch: usize,
    bytes: usize,
    seconds: f64,
    /// What `entry` points into.
    _memory: Box<dyn Executable>,
    /// The functions whose addresses stand in the code.
    _functions: Box<[AnalyticFunction]>,
}

impl MachineCode {
    /// Whether this machine has a compiler.
    pub(crate) fn is_available() -> bool {
        Backend::best(1).is_some()
    }

    /// Compiles `code` for `lanes` lanes; `None` where the platform cannot or forbids it.
    pub(crate) fn compile(code: &Code, lanes: usize) -> Option<Self> {
        let backend = match Backend::best(lanes)? {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Backend::Avx(width) if code.instructions.iter().any(is_call) => {
                Backend::Avx(width.with_calls(lanes))
            }
            backend => backend,
        };
        Self::compile_by(backend, code, lanes)
    }

    /// After how many evaluations the code has saved the time that it took to compile, for programs
    /// of any size: both grow with the number of operations.
    pub(crate) fn evaluations_to_pay(lanes: usize) -> u64 {
        match Backend::best(lanes) {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Some(Backend::Avx(_)) => 256,
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Some(Backend::Portable) => 4096,
            None => u64::MAX,
        }
    }

    /// The same by a given backend.
    pub(super) fn compile_by(backend: Backend, code: &Code, lanes: usize) -> Option<Self> {
        let start = Instant::now();
        let slots = code.slots.checked_mul(lanes)?;
        if slots * size_of::<f64>() > MOST_BYTES {
            return None;
        }
        let functions: Box<[AnalyticFunction]> = code
            .instructions
            .iter()
            .filter_map(|instruction| match instruction {
                Instruction::ApplyAnalytic { function, .. } => Some(*function),
                _ => None,
            })
            .collect();
        let Written {
            memory,
            bytes,
            scratch,
        } = backend.write(
            &Program::new(code, backend.registers(), backend.calls_pairs()),
            lanes,
            &functions,
        )?;
        #[cfg(test)]
        if REFUSES.get() {
            return None;
        }
        // SAFETY: every backend writes a function of this signature in the platform's C convention.
        let entry = unsafe { std::mem::transmute::<*const u8, Entry>(memory.start()) };
        Some(Self {
            entry,
            slots,
            scratch,
            bytes,
            seconds: start.elapsed().as_secs_f64(),
            _memory: memory,
            _functions: functions,
        })
    }

    /// How many numbers of scratch memory [`MachineCode::run`] needs, all −0 at first.
    pub(crate) fn scratch(&self) -> usize {
        self.scratch
    }

    /// Runs the program on `slots`, slot s of lane w at `[s*lanes + w]`.
    ///
    /// # Panics
    /// When `slots` or `scratch` has another length than the code was compiled for.
    pub(crate) fn run(&self, slots: &mut [f64], scratch: &mut [f64]) {
        assert!(
            slots.len() == self.slots && scratch.len() == self.scratch,
            "the memory of another kernel"
        );
        // SAFETY: the code reads and writes the `self.slots` numbers from its first argument on and
        // the `self.scratch` numbers from its second one on; its memory lives as long as `self`.
        unsafe { (self.entry)(slots.as_mut_ptr(), scratch.as_mut_ptr()) }
    }

    /// The length of the code.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }

    /// How long the compilation took.
    pub(crate) fn seconds(&self) -> f64 {
        self.seconds
    }
}

impl fmt::Debug for MachineCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MachineCode")
            .field("bytes", &self.bytes)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
thread_local! {
    /// Makes this thread's compilations fail where memory becomes executable, which a platform may forbid.
    pub(super) static REFUSES: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}
