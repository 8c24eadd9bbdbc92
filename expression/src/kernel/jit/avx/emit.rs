//! A planned program as bytes: `fn(slots, scratch, first, end, second) -> reached`, all `*mut f64`, in the System V
//! convention.
//!
//! The last three arguments are places of the array that it moves along, if any. From the first on it takes so many
//! places at a time until it is at the end, or where its results are not right. The second place moves with it.

use std::ops::Range;

use super::assembler::{Assembler, Gpr, Jump, Memory, Opcode, Operand, Width};
use crate::analytic::{AnalyticFunction, Member};
use crate::expression::Side;
use crate::kernel::code::Instruction;
use crate::kernel::distances::{Distance, Distances};
use crate::kernel::jit::functions;
use crate::kernel::jit::operation::{Action, Location, Operation, Source};
use crate::kernel::jit::program::Program;
use crate::kernel::jit::registers::{Plan, Step};

/// Bytes of a number.
const NUMBER: i32 = size_of::<f64>() as i32;

/// The scratch memory starts with −0 in as many lanes as there may be at a time. Two groups of so many lanes for the
/// operands of calls follow, and one of all bits but a number's sign. The program's own numbers and the places of the
/// plan come last.
const SIGNS: i32 = 0;
const FIRST_OPERAND: i32 = 32 * NUMBER;
const SECOND_OPERAND: i32 = 64 * NUMBER;
const MAGNITUDES: i32 = 96 * NUMBER;
const REST: i32 = 128 * NUMBER;

/// Pointers stand this far inside what they point to: short displacements reach both ways.
const INSIDE: i32 = 128;

/// The scratch memory that a program needs, as it is before the first run.
pub(in crate::kernel::jit) fn scratch(program: &Program, plan: &Plan, width: Width) -> Vec<f64> {
    let mut scratch = vec![-0.0; (REST / NUMBER) as usize];
    scratch[(MAGNITUDES / NUMBER) as usize..].fill(f64::from_bits(u64::MAX >> 1));
    let own = program.own.iter();
    scratch.extend(own.flat_map(|number| std::iter::repeat_n(*number, width.lanes())));
    scratch.resize(scratch.len() + plan.places * width.lanes(), -0.0);
    scratch
}

/// Where in that memory a row of the program's own numbers is.
pub(in crate::kernel::jit) fn own_row(row: u32, width: Width) -> Range<usize> {
    let start = (REST / NUMBER) as usize + row as usize * width.lanes();
    start..start + width.lanes()
}

/// The code of `program` for `lanes` lanes, `width` at a time; along an array if there are distances.
pub(in crate::kernel::jit) fn assemble(
    program: &Program,
    plan: &Plan,
    (lanes, width): (usize, Width),
    analytic: &[AnalyticFunction],
    distances: Option<&Distances>,
) -> Vec<u8> {
    let calls = program
        .operations
        .iter()
        .any(|operation| matches!(operation.action, Action::Call(_)));
    // A call leaves these as they are; an odd number of them aligns the stack for it.
    let kept = [Gpr::RBX, Gpr::RBP, Gpr::R12, Gpr::R13, Gpr::R14];
    let kept = &kept[..if distances.is_some() { 5 } else { 3 }];
    let [slots, scratch, end, first, second] = if calls {
        [Gpr::RBX, Gpr::RBP, Gpr::R12, Gpr::R13, Gpr::R14]
    } else {
        [Gpr::RDI, Gpr::RSI, Gpr::RCX, Gpr::RDX, Gpr::R8]
    };
    let mut emitter = Emitter {
        assembler: Assembler::default(),
        program,
        analytic,
        slot_bytes: lanes as i32 * NUMBER,
        width,
        slots,
        scratch,
        places: [first, second],
        inputs: distances.map_or(&[], |distances| &distances.inputs),
        registers: vec![None; width.registers()],
        homes: vec![None; program.operations.len()],
    };
    if calls {
        for &register in kept {
            emitter.assembler.push(register);
        }
    }
    let inside = |base, offset| Memory { base, offset };
    let assembler = &mut emitter.assembler;
    assembler.address(slots, inside(Gpr::RDI, INSIDE));
    assembler.address(scratch, inside(Gpr::RSI, REST + INSIDE));
    if distances.is_some() {
        assembler.address(first, inside(Gpr::RDX, 0));
        assembler.address(end, inside(Gpr::RCX, 0));
        assembler.address(second, inside(Gpr::R8, 0));
        emitter.sweep(plan, end);
    } else if lanes == width.lanes() {
        emitter.steps(plan);
    } else {
        let to_last = (lanes - width.lanes()) as i32 * NUMBER;
        assembler.address(end, inside(slots, to_last));
        emitter.groups(plan, end);
    }
    if width.lanes() > 2 {
        emitter.assembler.zero_upper();
    }
    if calls {
        for &register in kept.iter().rev() {
            emitter.assembler.pop(register);
        }
    }
    emitter.assembler.give_back();
    emitter.assembler.bytes
}

struct Emitter<'a> {
    assembler: Assembler,
    program: &'a Program,
    analytic: &'a [AnalyticFunction],
    slot_bytes: i32,
    width: Width,
    /// [`INSIDE`] the first slot of the lanes at work.
    slots: Gpr,
    /// [`INSIDE`] the program's own numbers in the scratch memory.
    scratch: Gpr,
    /// The two places of the array for the first lane.
    places: [Gpr; 2],
    /// How far from them the inputs stand, which the first slots are in the place of.
    inputs: &'a [Distance],
    registers: Vec<Option<Source>>,
    homes: Vec<Option<Location>>,
}

impl Emitter<'_> {
    /// The steps for the first lanes, the next ones, …; where they do not divide evenly the last
    /// group overlaps the one before it and finds the same numbers again.
    fn groups(&mut self, plan: &Plan, last: Gpr) {
        let start = self.assembler.bytes.len();
        self.steps(plan);
        let done = self.assembler.jump_unless_below(self.slots, last);
        let next = Memory {
            base: self.slots,
            offset: self.width.lanes() as i32 * NUMBER,
        };
        self.assembler.address(self.slots, next);
        self.assembler.limit(self.slots, last);
        self.assembler.jump_back(start);
        self.assembler.land(done);
    }

    /// The steps for the first places, the next ones, …, until the end, or where a limit is passed: then nothing was
    /// written for these places. Tells where that is.
    fn sweep(&mut self, plan: &Plan, end: Gpr) {
        let registers = self.width.registers() - plan.resident.len();
        for (register, &source) in (registers..).zip(&plan.resident) {
            let from = self.memory(source);
            self.assembler.load(self.width, register as u8, from);
            self.registers[register] = Some(source);
        }
        let start = self.assembler.bytes.len();
        self.steps(plan);
        let (program, width) = (self.program, self.width);
        let mut exits: Vec<Jump> = Vec::new();
        for limit in &program.limits {
            let [size, bounds] =
                [limit.row, limit.bound_row].map(|row| self.address(Location::Own(row)));
            self.assembler.load(width, 0, size);
            let jumps = self.assembler.jump_unless_all_below(width, (0, 1), bounds);
            exits.extend(jumps);
        }
        // No other register is in use any more: as many copies as there are registers are on their way at once.
        let registers = 0..registers as u8;
        for (&(source, distance), register) in program.copies.iter().zip(registers.cycle()) {
            let [from, to] = [self.memory(source), self.address(Location::Array(distance))];
            self.assembler.load(width, register, from);
            self.assembler.store(width, register, to);
        }
        let assembler = &mut self.assembler;
        for place in self.places {
            let next = Memory {
                base: place,
                offset: width.lanes() as i32 * NUMBER,
            };
            assembler.address(place, next);
        }
        let [first, _] = self.places;
        exits.push(assembler.jump_unless_below(first, end));
        assembler.jump_back(start);
        for exit in exits {
            assembler.land(exit);
        }
        let reached = Memory {
            base: first,
            offset: 0,
        };
        assembler.address(Gpr::RAX, reached);
    }

    fn steps(&mut self, plan: &Plan) {
        for &step in &plan.steps {
            match step {
                Step::Load(source) => {
                    let from = self.memory(source);
                    let register = self.take(source);
                    self.assembler.load(self.width, register, from);
                }
                Step::Operate(at) => {
                    self.operate(at, &self.program.operations[at as usize]);
                }
                Step::Output(at) => {
                    let location = self.program.operations[at as usize].output;
                    self.store(at, location.expect("an output has a location"));
                }
                Step::Spill(at, place) => self.store(at, Location::Place(place)),
                Step::Forget(source) => {
                    if let Some(register) = self.find(source) {
                        self.registers[register as usize] = None;
                    }
                }
            }
        }
    }

    fn find(&self, source: Source) -> Option<u8> {
        let register = self.registers.iter().position(|r| *r == Some(source))?;
        Some(register as u8)
    }

    /// The lowest free register, which has the shortest instructions; the plan leaves one.
    fn take(&mut self, source: Source) -> u8 {
        let free = self.registers.iter().position(Option::is_none);
        let register = free.expect("a plan leaves a register free");
        self.registers[register] = Some(source);
        register as u8
    }

    /// Where a number that has no register stands.
    fn memory(&self, source: Source) -> Memory {
        match source {
            Source::Slot(slot) => self.address(match self.inputs.get(slot as usize) {
                Some(&distance) => Location::Array(distance),
                None => Location::Slot(slot),
            }),
            Source::Own(row) => self.address(Location::Own(row)),
            Source::Result(result) => {
                let home = self.homes[result as usize];
                self.address(home.expect("a result without a register is stored"))
            }
        }
    }

    fn address(&self, home: Location) -> Memory {
        let row_bytes = self.width.lanes() as i32 * NUMBER;
        let (base, offset) = match home {
            Location::Array(distance) => {
                let [first, second] = self.places;
                return Memory {
                    base: match distance {
                        Distance::First(_) => first,
                        Distance::Second(_) => second,
                    },
                    offset: distance.numbers() as i32 * NUMBER,
                };
            }
            Location::Slot(slot) => (self.slots, slot as i32 * self.slot_bytes),
            Location::Own(row) => (self.scratch, row as i32 * row_bytes),
            Location::Place(place) => {
                let row = self.program.own.len() as i32 + place as i32;
                (self.scratch, row * row_bytes)
            }
        };
        Memory {
            base,
            offset: offset - INSIDE,
        }
    }

    /// A place at the start of the scratch memory.
    fn header(&self, place: i32) -> Memory {
        Memory {
            base: self.scratch,
            offset: place - REST - INSIDE,
        }
    }

    fn store(&mut self, at: u32, home: Location) {
        let register = self.find(Source::Result(at));
        let register = register.expect("what is stored is in a register");
        self.homes[at as usize] = Some(home);
        let to = self.address(home);
        self.assembler.store(self.width, register, to);
    }

    fn operand(&self, source: Source) -> Operand {
        match self.find(source) {
            Some(register) => Operand::Register(register),
            None => Operand::Memory(self.memory(source)),
        }
    }

    fn operate(&mut self, at: u32, operation: &Operation) {
        let [a, b, c] = operation.operands;
        // The first operand is a register; of two, the second has a shorter code if it is a low one. The second factor
        // of a fused product is a register.
        let is_swapped = operation.action.commutes()
            && match (self.find(a), self.find(b)) {
                (Some(_), None) => operation.action.is_fused(),
                (None, Some(_)) => !operation.action.is_fused(),
                (Some(first), Some(second)) => first < second,
                (None, None) => false,
            };
        let (a, b) = if is_swapped { (b, a) } else { (a, b) };
        let opcode = match operation.action {
            Action::Add => Opcode::Add,
            Action::Subtract => Opcode::Subtract,
            Action::Multiply => Opcode::Multiply,
            Action::Divide => Opcode::Divide,
            Action::Negate => Opcode::ExclusiveOr,
            Action::SquareRoot => Opcode::SquareRoot,
            Action::And | Action::Magnitude => Opcode::And,
            Action::Larger => Opcode::Larger,
            Action::Smaller => Opcode::Smaller,
            Action::TimesPlus => return self.fuse(at, Opcode::TimesPlus, [a, b, c]),
            Action::TimesFrom => return self.fuse(at, Opcode::TimesFrom, [a, b, c]),
            Action::Keep(side) => return self.keep(at, side, [a, b]),
            Action::Call(instruction) => return self.call(at, operation, &instruction),
        };
        let first = self.find(a).expect("a plan loads the first operand");
        let second = match operation.action {
            Action::Negate => Operand::Memory(self.header(SIGNS)),
            Action::Magnitude => Operand::Memory(self.header(MAGNITUDES)),
            _ => self.operand(b),
        };
        // A root of several numbers has one operand alone.
        let first = match opcode {
            Opcode::SquareRoot if self.width != Width::One => 0,
            _ => first,
        };
        let target = self.take(Source::Result(at));
        self.assembler
            .compute(self.width, opcode, target, first, second);
    }

    /// A fused product, which replaces its first factor.
    fn fuse(&mut self, at: u32, opcode: Opcode, [a, b, c]: [Source; 3]) {
        let [first, summand] = [a, c].map(|source| self.operand(source));
        let factor = self.find(b).expect("a plan loads a factor");
        let target = self.take(Source::Result(at));
        match first {
            Operand::Register(register) => self.assembler.copy(self.width, target, register),
            Operand::Memory(memory) => self.assembler.load(self.width, target, memory),
        }
        self.assembler
            .compute(self.width, opcode, target, factor, summand);
    }

    /// A number on one side of another's 0.
    fn keep(&mut self, at: u32, side: Side, [c, value]: [Source; 2]) {
        let [c, value] = [c, value].map(|source| {
            let register = self.find(source);
            register.expect("a plan loads both")
        });
        // −0 is as good as 0.
        let zeros = self.header(SIGNS);
        let target = self.take(Source::Result(at));
        self.assembler
            .keep(self.width, side, target, (c, value), zeros);
    }

    /// Calls a function, which keeps no registers; the plan has stored what is read later. The second of a pair
    /// of functions is the second result of the call of the first.
    fn call(&mut self, at: u32, operation: &Operation, instruction: &Instruction) {
        if !operation.is_second {
            let [a, b, _] = operation.operands.map(|operand| {
                self.find(operand)
                    .expect("a plan loads the operands of calls")
            });
            let entry = if self.width == Width::One {
                self.pass_registers(at, instruction, a, b)
            } else {
                self.pass_memory(at, instruction, a, b)
            };
            self.assembler.constant(Gpr::RAX, entry as u64);
            self.assembler.call_rax();
            self.registers.fill(None);
        }
        let is_of_two = operation.is_second || self.is_first(at);
        let pair = instruction.pair().filter(|_| is_of_two);
        let member = pair.map_or(Member::First, |(_, member)| member);
        let result = Source::Result(at);
        if self.width == Width::One {
            self.registers[member as usize] = Some(result);
        } else {
            let values = self.header(match member {
                Member::First => FIRST_OPERAND,
                Member::Second => SECOND_OPERAND,
            });
            let target = self.take(result);
            self.assembler.load(self.width, target, values);
        }
    }

    /// Whether the next operation is the second of a pair of functions.
    fn is_first(&self, at: u32) -> bool {
        let next = self.program.operations.get(at as usize + 1);
        next.is_some_and(|next| next.is_second)
    }

    /// Passes the operands in the first registers; the results come there too.
    fn pass_registers(&mut self, at: u32, instruction: &Instruction, a: u8, b: u8) -> usize {
        let pair = instruction.pair();
        let pair = pair.filter(|_| self.is_first(at));
        let assembler = &mut self.assembler;
        if let Some((pair, _)) = pair {
            assembler.copy(Width::Two, 0, a);
            assembler.constant(Gpr::RDI, std::ptr::from_ref(pair) as u64);
            return functions::pair();
        }
        match *instruction {
            Instruction::Power { .. } | Instruction::ApplyTwo { .. } => {
                let spare = (2..5).find(|r| *r != a && *r != b).unwrap_or(5);
                assembler.copy(Width::Two, spare, b);
                assembler.copy(Width::Two, 0, a);
                assembler.copy(Width::Two, 1, spare);
                functions::of_two(instruction)
            }
            Instruction::ApplyAnalytic {
                function, order, ..
            } => {
                assembler.copy(Width::Two, 0, a);
                assembler.constant(Gpr::RDI, address(self.analytic, function));
                assembler.constant(Gpr::RSI, u64::from(order));
                functions::analytic()
            }
            Instruction::Apply { function, .. } => {
                assembler.copy(Width::Two, 0, a);
                functions::elementary(function)
            }
            _ => unreachable!("no other instruction is a call"),
        }
    }

    /// Passes the operands in memory: the results come in their place.
    fn pass_memory(&mut self, at: u32, instruction: &Instruction, a: u8, b: u8) -> usize {
        let pair = instruction.pair();
        let pair = pair.filter(|_| self.is_first(at));
        let [first, second] = [FIRST_OPERAND, SECOND_OPERAND].map(|place| self.header(place));
        let count = self.width.lanes() as u64;
        let assembler = &mut self.assembler;
        if let Some((pair, _)) = pair {
            assembler.constant(Gpr::RDI, std::ptr::from_ref(pair) as u64);
            assembler.address(Gpr::RSI, first);
            assembler.address(Gpr::RDX, second);
            assembler.store(self.width, a, first);
            assembler.constant(Gpr::RCX, count);
            if self.width.lanes() > 2 {
                assembler.zero_upper();
            }
            return functions::pair_lanes();
        }
        assembler.store(self.width, a, first);
        let entry = match *instruction {
            Instruction::Power { .. } | Instruction::ApplyTwo { .. } => {
                assembler.store(self.width, b, second);
                assembler.address(Gpr::RDI, first);
                assembler.address(Gpr::RSI, second);
                assembler.constant(Gpr::RDX, count);
                functions::of_two_lanes(instruction)
            }
            Instruction::ApplyAnalytic {
                function, order, ..
            } => {
                assembler.constant(Gpr::RDI, address(self.analytic, function));
                assembler.constant(Gpr::RSI, u64::from(order));
                assembler.address(Gpr::RDX, first);
                assembler.constant(Gpr::RCX, count);
                functions::analytic_lanes()
            }
            Instruction::Apply { function, .. } => {
                assembler.address(Gpr::RDI, first);
                assembler.constant(Gpr::RSI, count);
                functions::elementary_lanes(function)
            }
            _ => unreachable!("no other instruction is a call"),
        };
        if self.width.lanes() > 2 {
            assembler.zero_upper();
        }
        entry
    }
}

/// The address of a function among those that live as long as the code.
fn address(analytic: &[AnalyticFunction], function: AnalyticFunction) -> u64 {
    let known = analytic.iter().find(|known| **known == function);
    std::ptr::from_ref(known.expect("every function of the code")) as u64
}
