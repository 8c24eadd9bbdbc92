//! A planned program as a function of the compiler's intermediate code, for any machine it knows:
//! `fn(slots, scratch, first, end) -> reached`, one number or two an instruction. The arguments `first` and `end` and
//! the result mean nothing: the function moves along no array.

use cranelift_codegen::ir::condcodes::{FloatCC, IntCC};
use cranelift_codegen::ir::{
    AbiParam, Function as IrFunction, InstBuilder, MemFlagsData, SigRef, Signature, Type, Value,
    types,
};
use cranelift_codegen::isa::TargetIsa;
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};

use crate::analytic::AnalyticFunction;
use crate::expression::Side;
use crate::kernel::code::Instruction;
use crate::kernel::jit::functions;
use crate::kernel::jit::operation::{Action, Location, Operation, Source};
use crate::kernel::jit::program::Program;
use crate::kernel::jit::registers::{Plan, Step};

const NUMBER: i64 = size_of::<f64>() as i64;

const NEITHER: &str = "programs for arguments near 0 and along arrays are of the other backend";

/// How many registers for numbers a plan may use: all but what the compiler wants for itself.
pub(super) const REGISTERS: usize = if cfg!(target_arch = "aarch64") {
    30
} else {
    15
};

/// How many numbers of scratch memory a plan needs.
pub(super) fn scratch_len(plan: &Plan, lanes: usize) -> usize {
    plan.places * lanes.min(2)
}

/// `fn(*mut f64, *mut f64, *mut f64, *mut f64) -> *mut f64` in the platform's C convention.
pub(super) fn signature(isa: &dyn TargetIsa) -> Signature {
    let mut signature = Signature::new(isa.default_call_conv());
    let pointer = AbiParam::new(isa.pointer_type());
    signature.params.extend([pointer; 4]);
    signature.returns.push(pointer);
    signature
}

/// Writes `program` for `lanes` lanes as the body of `function`, of that signature.
pub(super) fn emit(
    program: &Program,
    plan: &Plan,
    lanes: usize,
    analytic: &[AnalyticFunction],
    isa: &dyn TargetIsa,
    function: &mut IrFunction,
    builders: &mut FunctionBuilderContext,
) {
    let pointer = isa.pointer_type();
    let mut builder = FunctionBuilder::new(function, builders);
    let entry = builder.create_block();
    builder.append_block_params_for_function_params(entry);
    builder.switch_to_block(entry);
    let [slots, scratch] = [0, 1].map(|k| builder.block_params(entry)[k]);
    let number = match lanes {
        1 => types::F64,
        _ => types::F64X2,
    };
    let signatures = Signatures::new(&mut builder, isa);
    let mut emitter = Emitter {
        builder,
        program,
        plan,
        analytic,
        lanes,
        number,
        pointer,
        slots,
        scratch,
        signatures,
        slot_values: vec![None; program.slots],
        results: vec![None; program.operations.len()],
        homes: vec![None; program.operations.len()],
    };
    if lanes <= 2 {
        emitter.steps();
    } else {
        emitter.pairs();
    }
    emitter.builder.ins().return_(&[slots]);
    emitter.builder.seal_all_blocks();
    emitter.builder.finalize(isa.frontend_config());
}

/// The signatures of the functions that are called.
struct Signatures {
    unary: SigRef,
    binary: SigRef,
    derivative: SigRef,
}

impl Signatures {
    fn new(builder: &mut FunctionBuilder<'_>, isa: &dyn TargetIsa) -> Self {
        let mut import = |parameters: &[Type]| {
            let mut signature = Signature::new(isa.default_call_conv());
            let parameters = parameters.iter().map(|p| AbiParam::new(*p));
            signature.params.extend(parameters);
            signature.returns.push(AbiParam::new(types::F64));
            builder.import_signature(signature)
        };
        Self {
            unary: import(&[types::F64]),
            binary: import(&[types::F64, types::F64]),
            derivative: import(&[isa.pointer_type(), types::I32, types::F64]),
        }
    }
}

struct Emitter<'a> {
    builder: FunctionBuilder<'a>,
    program: &'a Program,
    plan: &'a Plan,
    analytic: &'a [AnalyticFunction],
    lanes: usize,
    /// One lane or two.
    number: Type,
    pointer: Type,
    /// The first number of slot 0.
    slots: Value,
    /// The first place of the scratch memory.
    scratch: Value,
    signatures: Signatures,
    /// The registers that hold slots.
    slot_values: Vec<Option<Value>>,
    /// The registers that hold results.
    results: Vec<Option<Value>>,
    homes: Vec<Option<Location>>,
}

impl Emitter<'_> {
    /// The steps for lanes 0 and 1, 2 and 3, …; of an odd number the last pair overlaps the one
    /// before it and finds the same numbers again.
    fn pairs(&mut self) {
        let body = self.builder.create_block();
        let done = self.builder.create_block();
        let here = self.builder.append_block_param(body, self.pointer);
        let to_last = (self.lanes as i64 - 2) * NUMBER;
        let last = self.builder.ins().iadd_imm_s(self.slots, to_last);
        self.builder.ins().jump(body, &[self.slots.into()]);
        self.builder.switch_to_block(body);
        self.slots = here;
        self.steps();
        let next = self.builder.ins().iadd_imm_s(here, 2 * NUMBER);
        let next = self.builder.ins().umin(next, last);
        let more = self.builder.ins().icmp(IntCC::UnsignedLessThan, here, last);
        self.builder
            .ins()
            .brif(more, body, &[next.into()], done, &[]);
        self.builder.switch_to_block(done);
    }

    fn steps(&mut self) {
        let plan = self.plan;
        for &step in &plan.steps {
            match step {
                Step::Load(source) => {
                    let value = self.load(source);
                    *self.register(source) = Some(value);
                }
                Step::Operate(at) => {
                    let value = self.operate(&self.program.operations[at as usize]);
                    self.results[at as usize] = Some(value);
                }
                Step::Output(at) => {
                    let location = self.program.operations[at as usize].output;
                    self.store(at, location.expect("an output has a location"));
                }
                Step::Spill(at, place) => self.store(at, Location::Place(place)),
                Step::Forget(source) => *self.register(source) = None,
            }
        }
    }

    fn register(&mut self, source: Source) -> &mut Option<Value> {
        match source {
            Source::Slot(slot) => &mut self.slot_values[slot as usize],
            Source::Result(result) => &mut self.results[result as usize],
            Source::Own(_) => unreachable!("{NEITHER}"),
        }
    }

    fn operate(&mut self, operation: &Operation) -> Value {
        let [a, b, _] = operation.operands;
        let instruction = match operation.action {
            Action::Add => {
                let (x, y) = (self.read(a), self.read(b));
                return self.builder.ins().fadd(x, y);
            }
            Action::Subtract => {
                let (x, y) = (self.read(a), self.read(b));
                return self.builder.ins().fsub(x, y);
            }
            Action::Multiply => {
                let (x, y) = (self.read(a), self.read(b));
                return self.builder.ins().fmul(x, y);
            }
            Action::Divide => {
                let (x, y) = (self.read(a), self.read(b));
                return self.builder.ins().fdiv(x, y);
            }
            Action::Negate => {
                let x = self.read(a);
                return self.builder.ins().fneg(x);
            }
            Action::SquareRoot => {
                let x = self.read(a);
                return self.builder.ins().sqrt(x);
            }
            Action::Magnitude => {
                let x = self.read(a);
                return self.builder.ins().fabs(x);
            }
            Action::Larger | Action::Smaller => {
                let (x, y) = (self.read(a), self.read(b));
                let (large, small) = match operation.action {
                    Action::Larger => (x, y),
                    _ => (y, x),
                };
                let is_first = self.builder.ins().fcmp(FloatCC::GreaterThan, large, small);
                return self.select(is_first, x, y);
            }
            Action::Keep(side) => {
                let (c, value) = (self.read(a), self.read(b));
                let ty = self.builder.func.dfg.value_type(value);
                let mut zero = self.builder.ins().f64const(0.0);
                if ty.is_vector() {
                    zero = self.builder.ins().splat(ty, zero);
                }
                let condition = match side {
                    Side::Above => FloatCC::GreaterThan,
                    Side::Below => FloatCC::LessThanOrEqual,
                };
                let is_kept = self.builder.ins().fcmp(condition, c, zero);
                return self.select(is_kept, value, zero);
            }
            Action::TimesPlus | Action::TimesFrom | Action::And => {
                unreachable!("{NEITHER}")
            }
            Action::Call(instruction) => instruction,
        };
        match instruction {
            Instruction::Apply { function, .. } => {
                let x = self.read(a);
                let entry = functions::elementary(function);
                self.call(self.signatures.unary, entry, &[], &[x])
            }
            Instruction::ApplyAnalytic {
                function, order, ..
            } => {
                let x = self.read(a);
                let function = self
                    .analytic
                    .iter()
                    .find(|known| **known == function)
                    .expect("every function of the code");
                let address = std::ptr::from_ref(function) as i64;
                let function = self.builder.ins().iconst(self.pointer, address);
                let order = self.builder.ins().iconst(types::I32, i64::from(order));
                let entry = functions::analytic();
                self.call(self.signatures.derivative, entry, &[function, order], &[x])
            }
            Instruction::Power { .. } | Instruction::ApplyTwo { .. } => {
                let (x, y) = (self.read(a), self.read(b));
                let entry = functions::of_two(&instruction);
                self.call(self.signatures.binary, entry, &[], &[x, y])
            }
            _ => unreachable!("no other instruction is a call"),
        }
    }

    /// x where the condition holds, else y, lane by lane.
    fn select(&mut self, condition: Value, x: Value, y: Value) -> Value {
        let ty = self.builder.func.dfg.value_type(x);
        if !ty.is_vector() {
            return self.builder.ins().select(condition, x, y);
        }
        let flags = MemFlagsData::new();
        let mask = self.builder.ins().bitcast(ty, flags, condition);
        self.builder.ins().bitselect(mask, x, y)
    }

    /// The number in its register, or read from memory for this use alone.
    fn read(&mut self, source: Source) -> Value {
        match *self.register(source) {
            Some(value) => value,
            None => self.load(source),
        }
    }

    fn load(&mut self, source: Source) -> Value {
        let home = match source {
            Source::Slot(slot) => Location::Slot(slot),
            Source::Result(result) => {
                self.homes[result as usize].expect("a result without a register is stored")
            }
            Source::Own(_) => unreachable!("{NEITHER}"),
        };
        let (base, offset) = self.address(home);
        let flags = MemFlagsData::new().with_notrap();
        self.builder.ins().load(self.number, flags, base, offset)
    }

    fn store(&mut self, at: u32, home: Location) {
        let value = self.results[at as usize].expect("what is stored is in a register");
        self.homes[at as usize] = Some(home);
        let (base, offset) = self.address(home);
        let flags = MemFlagsData::new().with_notrap();
        self.builder.ins().store(flags, value, base, offset);
    }

    fn address(&self, home: Location) -> (Value, i32) {
        let (base, bytes) = match home {
            Location::Slot(slot) => (self.slots, i64::from(slot) * self.lanes as i64 * NUMBER),
            Location::Place(place) => (
                self.scratch,
                i64::from(place) * i64::from(self.number.bytes()),
            ),
            Location::Own(_) | Location::Array(_) => unreachable!("{NEITHER}"),
        };
        (
            base,
            i32::try_from(bytes).expect("a program of limited size"),
        )
    }

    /// A call for each lane.
    fn call(
        &mut self,
        signature: SigRef,
        entry: usize,
        first: &[Value],
        numbers: &[Value],
    ) -> Value {
        let entry = self.builder.ins().iconst(self.pointer, entry as i64);
        if self.number == types::F64 {
            return self.call_once(signature, entry, &[first, numbers].concat());
        }
        let lane_of = |emitter: &mut Self, lane: u8| {
            let mut arguments = first.to_vec();
            for &number in numbers {
                arguments.push(emitter.builder.ins().extractlane(number, lane));
            }
            emitter.call_once(signature, entry, &arguments)
        };
        let values = [lane_of(self, 0), lane_of(self, 1)];
        let pair = self.builder.ins().scalar_to_vector(types::F64X2, values[0]);
        self.builder.ins().insertlane(pair, values[1], 1)
    }

    fn call_once(&mut self, signature: SigRef, entry: Value, arguments: &[Value]) -> Value {
        let call = self
            .builder
            .ins()
            .call_indirect(signature, entry, arguments);
        self.builder.inst_results(call)[0]
    }
}
