//! A straight-line program as a function of the compiler's intermediate code.

use cranelift_codegen::ir::{
    AbiParam, Function as IrFunction, InstBuilder, MemFlagsData, SigRef, Signature, Type, Value,
    types,
};
use cranelift_codegen::isa::TargetIsa;
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};

use super::functions;
use crate::analytic::AnalyticFunction;
use crate::expression::Function;
use crate::kernel::code::{Code, Instruction};

const NUMBER: i64 = size_of::<f64>() as i64;

/// Writes `code` for `lanes` lanes as the body of `function`, of the signature `fn(*mut f64)`.
pub(super) fn emit(
    code: &Code,
    lanes: usize,
    analytic: &[AnalyticFunction],
    isa: &dyn TargetIsa,
    function: &mut IrFunction,
    builders: &mut FunctionBuilderContext,
) {
    function.signature = Signature::new(isa.default_call_conv());
    function
        .signature
        .params
        .push(AbiParam::new(isa.pointer_type()));
    let mut builder = FunctionBuilder::new(function, builders);
    let entry = builder.create_block();
    builder.append_block_params_for_function_params(entry);
    builder.switch_to_block(entry);
    let base = builder.block_params(entry)[0];
    let number = if lanes == 1 { types::F64 } else { types::F64X2 };
    let mut emitter = Emitter::new(builder, code, lanes, number, isa);
    emitter.analytic = analytic;
    if lanes <= 2 {
        emitter.body(base);
    } else {
        emitter.pairs(base);
    }
    emitter.builder.ins().return_(&[]);
    emitter.builder.seal_all_blocks();
    emitter.builder.finalize(isa.frontend_config());
}

struct Emitter<'a> {
    builder: FunctionBuilder<'a>,
    code: &'a Code,
    analytic: &'a [AnalyticFunction],
    lanes: usize,
    number: Type,
    pointer: Type,
    unary: SigRef,
    binary: SigRef,
    derivative: SigRef,
    /// Slots that hold inputs, coefficients or constants: never written.
    written: Vec<Option<Value>>,
    /// The last instruction that writes each output slot.
    final_write: Vec<usize>,
}

impl<'a> Emitter<'a> {
    fn new(
        mut builder: FunctionBuilder<'a>,
        code: &'a Code,
        lanes: usize,
        number: Type,
        isa: &dyn TargetIsa,
    ) -> Self {
        let pointer = isa.pointer_type();
        let mut signature = |parameters: &[Type]| {
            let mut signature = Signature::new(isa.default_call_conv());
            signature
                .params
                .extend(parameters.iter().map(|p| AbiParam::new(*p)));
            signature.returns.push(AbiParam::new(types::F64));
            builder.import_signature(signature)
        };
        let unary = signature(&[types::F64]);
        let binary = signature(&[types::F64, types::F64]);
        let derivative = signature(&[pointer, types::I32, types::F64]);
        let mut final_write = vec![usize::MAX; code.slots];
        let mut is_output = vec![false; code.slots];
        for &slot in &code.outputs {
            is_output[slot as usize] = true;
        }
        for (at, instruction) in code.instructions.iter().enumerate() {
            if is_output[instruction.output() as usize] {
                final_write[instruction.output() as usize] = at;
            }
        }
        Self {
            builder,
            code,
            analytic: &[],
            lanes,
            number,
            pointer,
            unary,
            binary,
            derivative,
            written: vec![None; code.slots],
            final_write,
        }
    }

    /// The body for lanes 0 and 1, 2 and 3, …; of an odd number the last pair overlaps the one
    /// before it and finds the same numbers again.
    fn pairs(&mut self, base: Value) {
        let body = self.builder.create_block();
        let done = self.builder.create_block();
        let here = self.builder.append_block_param(body, self.pointer);
        let last = self
            .builder
            .ins()
            .iadd_imm_s(base, (self.lanes as i64 - 2) * NUMBER);
        self.builder.ins().jump(body, &[base.into()]);
        self.builder.switch_to_block(body);
        self.body(here);
        let next = self.builder.ins().iadd_imm_s(here, 2 * NUMBER);
        let next = self.builder.ins().umin(next, last);
        let more = self.builder.ins().icmp(
            cranelift_codegen::ir::condcodes::IntCC::UnsignedLessThan,
            here,
            last,
        );
        self.builder
            .ins()
            .brif(more, body, &[next.into()], done, &[]);
        self.builder.switch_to_block(done);
    }

    fn body(&mut self, base: Value) {
        let mut analytic = self.analytic.iter();
        for at in 0..self.code.instructions.len() {
            let instruction = self.code.instructions[at];
            let [a, b] = instruction.operands();
            let x = self.read(base, a);
            let value = match instruction {
                Instruction::Add { .. } => {
                    let y = self.read(base, b);
                    self.builder.ins().fadd(x, y)
                }
                Instruction::Subtract { .. } => {
                    let y = self.read(base, b);
                    self.builder.ins().fsub(x, y)
                }
                Instruction::Multiply { .. } => {
                    let y = self.read(base, b);
                    self.builder.ins().fmul(x, y)
                }
                Instruction::Divide { .. } => {
                    let y = self.read(base, b);
                    self.builder.ins().fdiv(x, y)
                }
                Instruction::Negate { .. } => self.builder.ins().fneg(x),
                Instruction::Apply {
                    function: Function::Sqrt,
                    ..
                } => self.builder.ins().sqrt(x),
                Instruction::Apply { function, .. } => {
                    let entry = functions::elementary(function);
                    self.call(self.unary, entry, &[], &[x])
                }
                Instruction::ApplyAnalytic { order, .. } => {
                    let function = analytic.next().expect("one function an instruction");
                    let function = self
                        .builder
                        .ins()
                        .iconst(self.pointer, std::ptr::from_ref(function) as i64);
                    let order = self.builder.ins().iconst(types::I32, i64::from(order));
                    self.call(
                        self.derivative,
                        functions::analytic(),
                        &[function, order],
                        &[x],
                    )
                }
                Instruction::Power { .. } => {
                    let y = self.read(base, b);
                    self.call(self.binary, functions::power(), &[], &[x, y])
                }
            };
            let out = instruction.output() as usize;
            self.written[out] = Some(value);
            if self.final_write[out] == at {
                self.store(base, value, out as u32);
            }
        }
    }

    fn offset(&self, slot: u32) -> i32 {
        i32::try_from(i64::from(slot) * self.lanes as i64 * NUMBER).expect("a small kernel")
    }

    fn read(&mut self, base: Value, slot: u32) -> Value {
        if let Some(value) = self.written[slot as usize] {
            return value;
        }
        let offset = self.offset(slot);
        let flags = MemFlagsData::new().with_notrap();
        self.builder.ins().load(self.number, flags, base, offset)
    }

    fn store(&mut self, base: Value, value: Value, slot: u32) {
        let offset = self.offset(slot);
        let flags = MemFlagsData::new().with_notrap();
        self.builder.ins().store(flags, value, base, offset);
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
            let arguments = [first, numbers].concat();
            let call = self
                .builder
                .ins()
                .call_indirect(signature, entry, &arguments);
            return self.builder.inst_results(call)[0];
        }
        let mut result = None;
        for lane in 0..2 {
            let mut arguments = first.to_vec();
            for number in numbers {
                arguments.push(self.builder.ins().extractlane(*number, lane));
            }
            let call = self
                .builder
                .ins()
                .call_indirect(signature, entry, &arguments);
            let value = self.builder.inst_results(call)[0];
            result = Some(match result {
                None => self.builder.ins().scalar_to_vector(types::F64X2, value),
                Some(pair) => self.builder.ins().insertlane(pair, value, lane),
            });
        }
        result.expect("two lanes")
    }
}
