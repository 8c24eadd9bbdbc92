//! Executable memory that holds one compiled kernel.

use std::fmt;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Instant;

use cranelift_codegen::Context;
use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::FunctionBuilderContext;
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{Linkage, Module, default_libcall_names};

use super::emit::emit;
use super::program::Program;
use super::registers::Plan;
use crate::analytic::AnalyticFunction;
use crate::kernel::code::{Code, Instruction};

/// How many registers for numbers a plan uses: all but what the compiler may want for itself.
const REGISTERS: usize = if cfg!(target_arch = "aarch64") {
    30
} else {
    15
};

/// The machine code of one program for one number of lanes.
pub(in crate::kernel) struct MachineCode {
    entry: unsafe extern "C" fn(*mut f64),
    slots: usize,
    bytes: usize,
    seconds: f64,
    /// Owns the memory that `entry` points into; freed on drop.
    module: Mutex<Option<JITModule>>,
    /// The functions whose addresses stand in the code.
    _functions: Box<[AnalyticFunction]>,
}

impl MachineCode {
    /// Compiles `code` for `lanes` lanes; `None` where the platform cannot or forbids it.
    pub(in crate::kernel) fn compile(code: &Code, lanes: usize) -> Option<Self> {
        let start = Instant::now();
        let functions: Box<[AnalyticFunction]> = code
            .instructions
            .iter()
            .filter_map(|instruction| match instruction {
                Instruction::ApplyAnalytic { function, .. } => Some(*function),
                _ => None,
            })
            .collect();
        let isa = host()?;
        let mut module = JITModule::new(JITBuilder::with_isa(isa, default_libcall_names()));
        let mut context = module.make_context();
        let mut builders = FunctionBuilderContext::new();
        let program = Program::new(code);
        let plan = Plan::new(&program, REGISTERS);
        emit(
            &program,
            &plan,
            lanes,
            &functions,
            module.isa(),
            &mut context.func,
            &mut builders,
        );
        let entry = link(&mut module, &mut context);
        let bytes = context
            .compiled_code()
            .map_or(0, |compiled| compiled.code_buffer().len());
        let machine = |module, entry| Self {
            entry,
            slots: code.slots * lanes,
            bytes,
            seconds: start.elapsed().as_secs_f64(),
            module: Mutex::new(Some(module)),
            _functions: functions,
        };
        match entry {
            Some(address) => {
                // SAFETY: `emit` writes a function of this signature in the platform's C convention.
                let entry = unsafe {
                    std::mem::transmute::<*const u8, unsafe extern "C" fn(*mut f64)>(address)
                };
                Some(machine(module, entry))
            }
            None => {
                // SAFETY: no function of the module was finalized, so none can be called.
                unsafe { module.free_memory() };
                None
            }
        }
    }

    /// Runs the program on `slots`, slot s of lane w at `[s*lanes + w]`.
    ///
    /// # Panics
    /// When `slots` has another length than the code was compiled for.
    pub(in crate::kernel) fn run(&self, slots: &mut [f64]) {
        assert_eq!(slots.len(), self.slots, "the slots of another kernel");
        // SAFETY: the code reads and writes the `self.slots` numbers from its argument on, and its
        // memory lives as long as `self`.
        unsafe { (self.entry)(slots.as_mut_ptr()) }
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

/// Compiles the function of `context` into executable memory and returns its address.
fn link(module: &mut JITModule, context: &mut Context) -> Option<*const u8> {
    let signature = &context.func.signature;
    let id = module
        .declare_function("kernel", Linkage::Local, signature)
        .ok()?;
    module.define_function(id, context).ok()?;
    module.finalize_definitions().ok()?;
    Some(module.get_finalized_function(id))
}

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
