//! Executable memory that holds one compiled kernel.

use std::fmt;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Instant;

use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::FunctionBuilderContext;
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{Linkage, Module, default_libcall_names};

#[cfg(all(target_arch = "x86_64", not(windows)))]
use super::avx;
use super::portable;
use super::program::Program;
use super::registers::{Plan, is_call};
use crate::analytic::AnalyticFunction;
use crate::kernel::code::{Code, Instruction};

/// The largest program in bytes of slots: offsets have 31 bits.
const MOST_BYTES: usize = 1 << 30;

/// The largest program for Cranelift in operations: its time grows faster than they do.
const MOST_PORTABLE: usize = 20_000;

/// What writes machine code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Backend {
    /// Our own assembler, so many lanes an instruction.
    #[cfg(all(target_arch = "x86_64", not(windows)))]
    Avx(avx::Width),
    /// Cranelift.
    Portable,
}

impl Backend {
    /// The fastest for so many lanes on this machine.
    pub(super) fn best(lanes: usize) -> Self {
        #[cfg(all(target_arch = "x86_64", not(windows)))]
        if let Some(width) = avx::Width::best(lanes) {
            return Self::Avx(width);
        }
        let _ = lanes;
        Self::Portable
    }
}

/// `fn(slots, scratch)`.
type Entry = unsafe extern "C" fn(*mut f64, *mut f64);

/// The machine code of one program for one number of lanes.
pub(in crate::kernel) struct MachineCode {
    entry: Entry,
    slots: usize,
    scratch: usize,
    bytes: usize,
    seconds: f64,
    /// Owns the memory that `entry` points into; freed on drop.
    module: Mutex<Option<JITModule>>,
    /// The functions whose addresses stand in the code.
    _functions: Box<[AnalyticFunction]>,
}

impl MachineCode {
    /// Whether this machine has a compiler.
    pub(in crate::kernel) fn is_available() -> bool {
        host().is_some()
    }

    /// Compiles `code` for `lanes` lanes; `None` where the platform cannot or forbids it.
    pub(in crate::kernel) fn compile(code: &Code, lanes: usize) -> Option<Self> {
        let backend = match Backend::best(lanes) {
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
    pub(in crate::kernel) fn evaluations_to_pay(lanes: usize) -> u64 {
        match Backend::best(lanes) {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Backend::Avx(_) => 256,
            Backend::Portable => 4096,
        }
    }

    /// The same by a given backend.
    pub(super) fn compile_by(backend: Backend, code: &Code, lanes: usize) -> Option<Self> {
        let start = Instant::now();
        let slots = code.slots.checked_mul(lanes)?;
        if slots * size_of::<f64>() > MOST_BYTES
            || backend == Backend::Portable && code.instructions.len() > MOST_PORTABLE
        {
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
        let program = Program::new(code);
        let isa = host()?;
        let mut module = JITModule::new(JITBuilder::with_isa(isa, default_libcall_names()));
        let written = write(&mut module, backend, &program, lanes, &functions);
        let Some(Written {
            address,
            bytes,
            scratch,
        }) = written
        else {
            // SAFETY: no function of the module is known to anyone.
            unsafe { module.free_memory() };
            return None;
        };
        // SAFETY: every backend writes a function of this signature in the platform's C convention.
        let entry = unsafe { std::mem::transmute::<*const u8, Entry>(address) };
        Some(Self {
            entry,
            slots,
            scratch,
            bytes,
            seconds: start.elapsed().as_secs_f64(),
            module: Mutex::new(Some(module)),
            _functions: functions,
        })
    }

    /// How many numbers of scratch memory [`MachineCode::run`] needs, all −0 at first.
    pub(in crate::kernel) fn scratch(&self) -> usize {
        self.scratch
    }

    /// Runs the program on `slots`, slot s of lane w at `[s*lanes + w]`.
    ///
    /// # Panics
    /// When `slots` or `scratch` has another length than the code was compiled for.
    pub(in crate::kernel) fn run(&self, slots: &mut [f64], scratch: &mut [f64]) {
        assert_eq!(
            (slots.len(), scratch.len()),
            (self.slots, self.scratch),
            "the memory of another kernel"
        );
        // SAFETY: the code reads and writes the `self.slots` numbers from its first argument on and
        // the `self.scratch` numbers from its second one on; its memory lives as long as `self`.
        unsafe { (self.entry)(slots.as_mut_ptr(), scratch.as_mut_ptr()) }
    }

    /// The length of the code.
    pub(in crate::kernel) fn bytes(&self) -> usize {
        self.bytes
    }

    /// How long the compilation took.
    pub(in crate::kernel) fn seconds(&self) -> f64 {
        self.seconds
    }
}

impl Drop for MachineCode {
    fn drop(&mut self) {
        let module = self
            .module
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(module) = module {
            // SAFETY: `entry` is private and called only through a reference to `self`, of which
            // there is none any more.
            unsafe { module.free_memory() }
        }
    }
}

impl fmt::Debug for MachineCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MachineCode")
            .field("bytes", &self.bytes)
            .finish_non_exhaustive()
    }
}

/// A function in executable memory.
struct Written {
    address: *const u8,
    bytes: usize,
    scratch: usize,
}

/// Writes the program into executable memory.
fn write(
    module: &mut JITModule,
    backend: Backend,
    program: &Program,
    lanes: usize,
    functions: &[AnalyticFunction],
) -> Option<Written> {
    let mut context = module.make_context();
    let signature = portable::signature(module.isa());
    let id = module
        .declare_function("kernel", Linkage::Local, &signature)
        .ok()?;
    let (bytes, scratch) = match backend {
        #[cfg(all(target_arch = "x86_64", not(windows)))]
        Backend::Avx(width) => {
            let plan = Plan::new(program, width.registers() - 1);
            let bytes = avx::assemble(program, &plan, lanes, width, functions);
            module
                .define_function_bytes(id, CACHE_LINE, &bytes, &[])
                .ok()?;
            (bytes.len(), avx::scratch_len(&plan, width))
        }
        Backend::Portable => {
            let plan = Plan::new(program, portable::REGISTERS);
            context.func.signature = signature;
            portable::emit(
                program,
                &plan,
                lanes,
                functions,
                module.isa(),
                &mut context.func,
                &mut FunctionBuilderContext::new(),
            );
            module.define_function(id, &mut context).ok()?;
            let bytes = context
                .compiled_code()
                .map_or(0, |code| code.code_buffer().len());
            (bytes, portable::scratch_len(&plan, lanes))
        }
    };
    #[cfg(test)]
    if REFUSES.get() {
        return None;
    }
    module.finalize_definitions().ok()?;
    Some(Written {
        address: module.get_finalized_function(id),
        bytes,
        scratch,
    })
}

#[cfg(test)]
thread_local! {
    /// Makes this thread's compilations fail where memory becomes executable, which a platform may forbid.
    pub(super) static REFUSES: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Where code starts.
const CACHE_LINE: u64 = 64;

/// The compiler for this machine, `None` where there is none.
fn host() -> Option<OwnedTargetIsa> {
    static HOST: OnceLock<Option<OwnedTargetIsa>> = OnceLock::new();
    HOST.get_or_init(|| {
        let mut flags = settings::builder();
        for (name, value) in [
            ("opt_level", "none"),
            ("regalloc_algorithm", "backtracking"),
            ("enable_verifier", "false"),
            ("enable_alias_analysis", "false"),
            ("unwind_info", "false"),
            ("probestack_strategy", "inline"),
            ("use_colocated_libcalls", "false"),
            ("is_pic", "false"),
        ] {
            flags.set(name, value).ok()?;
        }
        let builder = cranelift_native::builder().ok()?;
        builder.finish(settings::Flags::new(flags)).ok()
    })
    .clone()
}
