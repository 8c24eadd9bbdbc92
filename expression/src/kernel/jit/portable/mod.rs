//! Machine code by Cranelift, for machines that our own assembler does not know.
//!
//! On x86-64 it is compiled with `RUSTFLAGS="--cfg leafwise_portable"` alone, for its tests.

mod emit;

use std::sync::{Mutex, OnceLock, PoisonError};

use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::FunctionBuilderContext;
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{Linkage, Module, default_libcall_names};

use super::executable::{Executable, Written};
use super::program::Program;
use super::registers::Plan;
use crate::analytic::AnalyticFunction;

/// The largest program in operations: the compiler's time grows faster than they do.
const MOST_OPERATIONS: usize = 20_000;

/// Whether the compiler knows this machine.
pub(super) fn is_available() -> bool {
    host().is_some()
}

/// Writes the program into executable memory; `None` where it is too large, or the platform forbids it.
pub(super) fn write(
    program: &Program,
    lanes: usize,
    functions: &[AnalyticFunction],
) -> Option<Written> {
    if program.operations.len() > MOST_OPERATIONS {
        return None;
    }
    let mut memory = Memory::new(host()?);
    let plan = Plan::new(program, emit::REGISTERS);
    let (start, bytes) = memory.define(program, &plan, lanes, functions)?;
    memory.start = start.expose_provenance();
    Some(Written {
        memory: Box::new(memory),
        bytes,
        scratch: vec![-0.0; emit::scratch_len(&plan, lanes)],
        limits: Vec::new(),
    })
}

/// The compiler's memory.
struct Memory {
    module: Mutex<Option<JITModule>>,
    /// The function's address.
    start: usize,
}

impl Memory {
    fn new(isa: OwnedTargetIsa) -> Self {
        let module = JITModule::new(JITBuilder::with_isa(isa, default_libcall_names()));
        Self {
            module: Mutex::new(Some(module)),
            start: 0,
        }
    }

    /// The function's address and length.
    fn define(
        &mut self,
        program: &Program,
        plan: &Plan,
        lanes: usize,
        functions: &[AnalyticFunction],
    ) -> Option<(*const u8, usize)> {
        let module = self.module.get_mut();
        let module = module.unwrap_or_else(PoisonError::into_inner).as_mut()?;
        let mut context = module.make_context();
        let signature = emit::signature(module.isa());
        let id = module
            .declare_function("kernel", Linkage::Local, &signature)
            .ok()?;
        context.func.signature = signature;
        emit::emit(
            program,
            plan,
            lanes,
            functions,
            module.isa(),
            &mut context.func,
            &mut FunctionBuilderContext::new(),
        );
        module.define_function(id, &mut context).ok()?;
        let compiled = context.compiled_code();
        let bytes = compiled.map_or(0, |code| code.code_buffer().len());
        module.finalize_definitions().ok()?;
        Some((module.get_finalized_function(id), bytes))
    }
}

impl Executable for Memory {
    fn start(&self) -> *const u8 {
        std::ptr::with_exposed_provenance(self.start)
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        let module = self.module.get_mut();
        let module = module.unwrap_or_else(PoisonError::into_inner).take();
        if let Some(module) = module {
            // SAFETY: who calls the function owns this memory, and is gone.
            unsafe { module.free_memory() }
        }
    }
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
