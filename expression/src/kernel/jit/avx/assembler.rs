//! The few instructions of x86-64 that kernels need, as bytes (Intel 64 and IA-32 Architectures
//! Software Developer's Manual, volume 2: 2.3 for VEX, 2.7 for EVEX).

use crate::expression::Side;
use crate::vector::has_512_bits;

/// A register for addresses and whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gpr(u8);

impl Gpr {
    pub(super) const RAX: Self = Self(0);
    pub(super) const RCX: Self = Self(1);
    pub(super) const RDX: Self = Self(2);
    pub(super) const RBX: Self = Self(3);
    pub(super) const RBP: Self = Self(5);
    pub(super) const RSI: Self = Self(6);
    pub(super) const RDI: Self = Self(7);
    pub(super) const R8: Self = Self(8);
    pub(super) const R12: Self = Self(12);
    pub(super) const R13: Self = Self(13);
    pub(super) const R14: Self = Self(14);
}

/// How many numbers an instruction works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::kernel::jit) enum Width {
    /// One, in the lowest part of a register.
    One,
    /// Two, in 128 bits.
    Two,
    /// Four, in 256 bits.
    Four,
    /// Eight, in 512 bits: with these there are 32 registers.
    Eight,
    /// Sixteen, in two registers of eight that stand for one.
    Sixteen,
    /// Thirty-two, in four.
    ThirtyTwo,
}

impl Width {
    /// The number of numbers.
    pub(in crate::kernel::jit) fn lanes(self) -> usize {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
            Self::ThirtyTwo => 32,
        }
    }

    /// The widest that so many lanes fill on this machine, `None` without AVX.
    pub(in crate::kernel::jit) fn best(lanes: usize) -> Option<Self> {
        let available = [
            (Self::Eight, has_512_bits()),
            (Self::Four, is_x86_feature_detected!("avx")),
            (Self::Two, is_x86_feature_detected!("avx")),
            (Self::One, is_x86_feature_detected!("avx")),
        ];
        let fits = |&(width, is_available): &(Self, bool)| is_available && width.lanes() <= lanes;
        available.into_iter().find(fits).map(|(width, _)| width)
    }

    /// The widest for code that calls functions, which keep no registers: one register of lanes after
    /// the other would wait for each function in turn, several at once do not.
    pub(in crate::kernel::jit) fn with_calls(self, lanes: usize) -> Self {
        match self {
            Self::Eight if lanes >= 32 => Self::ThirtyTwo,
            Self::Eight if lanes >= 16 => Self::Sixteen,
            width => width,
        }
    }

    /// The same for code with formulas in the place of calls, whose results want registers. Flows of rigid bodies and
    /// of Lotka–Volterra systems are the fastest by sixteen, and by thirty-two slower than with calls.
    pub(in crate::kernel::jit) fn for_formulas(self) -> Self {
        match self {
            Self::ThirtyTwo => Self::Sixteen,
            width => width,
        }
    }

    /// How many of the machine's registers stand for one.
    fn parts(self) -> u8 {
        match self {
            Self::Sixteen => 2,
            Self::ThirtyTwo => 4,
            _ => 1,
        }
    }

    /// The number of registers.
    pub(in crate::kernel::jit) fn registers(self) -> usize {
        match self {
            Self::One | Self::Two | Self::Four => 16,
            Self::Eight => 32,
            Self::Sixteen => 16,
            Self::ThirtyTwo => 8,
        }
    }
}

/// A number in memory, `offset` bytes from where a register points: not RSP or R12.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Memory {
    pub(super) base: Gpr,
    pub(super) offset: i32,
}

/// The second operand of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operand {
    /// A register for numbers.
    Register(u8),
    /// Read from memory.
    Memory(Memory),
}

/// An operation of two operands, or of its second alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Opcode {
    SquareRoot = 0x51,
    Add = 0x58,
    Multiply = 0x59,
    Subtract = 0x5C,
    Divide = 0x5E,
    Load = 0x10,
    Store = 0x11,
    /// The bits of both, of whole registers.
    And = 0x54,
    /// The bits of both, exclusively or, of whole registers.
    ExclusiveOr = 0x57,
    /// The larger of both, the second where one is no number.
    Larger = 0x5F,
    /// The smaller of both, the second where one is no number.
    Smaller = 0x5D,
    /// target ← a·target + b, rounded once.
    TimesPlus = 0xA8,
    /// target ← b − a·target, rounded once.
    TimesFrom = 0xAC,
}

impl Opcode {
    /// Whether it works on whole registers, whatever is in them.
    fn is_of_bits(self) -> bool {
        matches!(self, Self::And | Self::ExclusiveOr)
    }

    /// Whether it is one product and one sum.
    fn is_fused(self) -> bool {
        matches!(self, Self::TimesPlus | Self::TimesFrom)
    }
}

/// Bytes of eight numbers.
const EIGHT: i32 = 64;

/// Whether the operation has its second operand alone.
fn has_one_operand(prefix: Prefix) -> bool {
    let own = [Opcode::SquareRoot, Opcode::Load, Opcode::Store].map(|opcode| opcode as u8);
    prefix.map == FIRST_MAP && (own.contains(&prefix.opcode) || prefix.opcode == COPY)
}

/// Of numbers with others, and the bits of its results, by registers and by flags.
const COMPARE: u8 = 0xC2;
const SIGNS_OF: u8 = 0x50;

/// Not below, or one is no number.
const NOT_BELOW: u8 = 5;

/// Above; not above. Neither where one is no number.
const ABOVE: u8 = 0x1E;
const NOT_ABOVE: u8 = 0x12;

/// Between registers.
const COPY: u8 = 0x28;

/// Results in the lanes of the mask 1, and 0 in the others.
const MASKED: u8 = 0x81;

/// The maps of opcodes: 0F, and 0F 38 of fused products.
const FIRST_MAP: u8 = 1;
const SECOND_MAP: u8 = 2;

/// Fields of an instruction's prefix, and the opcode.
#[derive(Clone, Copy)]
struct Prefix {
    /// 1 for packed numbers, 3 for a single one.
    kind: u8,
    map: u8,
    opcode: u8,
}

/// A place whose distance is not yet known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jump(usize);

/// Bytes of machine code.
#[derive(Debug, Default)]
pub(super) struct Assembler {
    pub(super) bytes: Vec<u8>,
}

impl Assembler {
    /// target ← a ∘ b; ← ∘ b where the operation has one operand, `a` being any register then.
    pub(super) fn compute(&mut self, width: Width, opcode: Opcode, target: u8, a: u8, b: Operand) {
        // Eight lanes have no operations on bits of numbers without an extension: those of whole numbers.
        let code = match (width, opcode) {
            (Width::Eight | Width::Sixteen | Width::ThirtyTwo, Opcode::And) => 0xDB,
            (Width::Eight | Width::Sixteen | Width::ThirtyTwo, Opcode::ExclusiveOr) => 0xEF,
            // Of a single number a fused product has an opcode of its own.
            (Width::One, fused) if fused.is_fused() => fused as u8 + 1,
            _ => opcode as u8,
        };
        let is_single = width == Width::One && !opcode.is_of_bits() && !opcode.is_fused();
        let prefix = Prefix {
            kind: if is_single { 3 } else { 1 },
            map: if opcode.is_fused() {
                SECOND_MAP
            } else {
                FIRST_MAP
            },
            opcode: code,
        };
        self.encode(width, prefix, target, a, b);
    }

    /// target ← memory.
    pub(super) fn load(&mut self, width: Width, target: u8, from: Memory) {
        self.move_memory(width, Opcode::Load, target, from);
    }

    /// memory ← source.
    pub(super) fn store(&mut self, width: Width, source: u8, to: Memory) {
        self.move_memory(width, Opcode::Store, source, to);
    }

    fn move_memory(&mut self, width: Width, opcode: Opcode, register: u8, memory: Memory) {
        let prefix = Prefix {
            kind: if width == Width::One { 3 } else { 1 },
            map: FIRST_MAP,
            opcode: opcode as u8,
        };
        self.encode(width, prefix, register, 0, Operand::Memory(memory));
    }

    /// target ← source, whole registers, of 128 bits at least.
    pub(super) fn copy(&mut self, width: Width, target: u8, source: u8) {
        // vmovapd
        let prefix = Prefix {
            kind: 1,
            map: FIRST_MAP,
            opcode: COPY,
        };
        self.encode(width, prefix, target, 0, Operand::Register(source));
    }

    /// target ← value where c is of this side of 0, else 0, in registers that are none of the target's; `zeros` are in
    /// memory.
    pub(super) fn keep(
        &mut self,
        width: Width,
        side: Side,
        target: u8,
        (c, value): (u8, u8),
        zeros: Memory,
    ) {
        let predicate = match side {
            Side::Above => ABOVE,
            Side::Below => NOT_ABOVE,
        };
        let compare = Prefix {
            kind: if width == Width::One { 3 } else { 1 },
            map: FIRST_MAP,
            opcode: COMPARE,
        };
        let zeros = Operand::Memory(zeros);
        if !matches!(width, Width::Eight | Width::Sixteen | Width::ThirtyTwo) {
            self.vex(width, compare, target, c, zeros);
            self.bytes.push(predicate);
            return self.compute(width, Opcode::And, target, target, Operand::Register(value));
        }
        let copy = Prefix {
            opcode: COPY,
            ..compare
        };
        for part in 0..width.parts() {
            let shift = part * width.registers() as u8;
            // Into the mask 1, which leaves 0 in the lanes that it does not have.
            self.evex(compare, 1, c + shift, zeros);
            self.bytes.push(predicate);
            let value = Operand::Register(value + shift);
            self.masked_evex(copy, (target + shift, MASKED), 0, value);
        }
    }

    fn encode(&mut self, width: Width, prefix: Prefix, target: u8, a: u8, b: Operand) {
        if !matches!(width, Width::Eight | Width::Sixteen | Width::ThirtyTwo) {
            return self.vex(width, prefix, target, a, b);
        }
        let registers = width.registers() as u8;
        for part in 0..width.parts() {
            let shift = part * registers;
            let b = match b {
                Operand::Register(register) => Operand::Register(register + shift),
                Operand::Memory(Memory { base, offset }) => Operand::Memory(Memory {
                    base,
                    offset: offset + i32::from(part) * EIGHT,
                }),
            };
            // An operation of one operand has the register 0 for the other, whichever part it is of.
            let a = if has_one_operand(prefix) {
                a
            } else {
                a + shift
            };
            self.evex(prefix, target + shift, a, b);
        }
    }

    fn vex(&mut self, width: Width, prefix: Prefix, target: u8, a: u8, b: Operand) {
        let long = u8::from(width == Width::Four);
        // Register numbers stand inverted.
        let tail = (!a & 15) << 3 | long << 2 | prefix.kind;
        let high_target = (!target >> 3 & 1) << 7;
        let high_b = match b {
            Operand::Register(register) => register >> 3 & 1,
            Operand::Memory(memory) => memory.base.0 >> 3 & 1,
        };
        if high_b == 0 && prefix.map == FIRST_MAP {
            self.bytes.extend([0xC5, high_target | tail]);
        } else {
            let wide = u8::from(prefix.map == SECOND_MAP) << 7;
            let high = high_target | 0x40 | (high_b ^ 1) << 5 | prefix.map;
            self.bytes.extend([0xC4, high, wide | tail]);
        }
        self.bytes.push(prefix.opcode);
        self.operand(target, b, 1);
    }

    fn evex(&mut self, prefix: Prefix, target: u8, a: u8, b: Operand) {
        self.masked_evex(prefix, (target, 0), a, b);
    }

    fn masked_evex(&mut self, prefix: Prefix, (target, mask): (u8, u8), a: u8, b: Operand) {
        let (low_b, high_b) = match b {
            Operand::Register(register) => (register >> 3 & 1, register >> 4 & 1),
            Operand::Memory(memory) => (memory.base.0 >> 3 & 1, 0),
        };
        let first = (!target >> 3 & 1) << 7
            | (high_b ^ 1) << 6
            | (low_b ^ 1) << 5
            | (!target >> 4 & 1) << 4
            | prefix.map;
        let second = 0x80 | (!a & 15) << 3 | 0x04 | prefix.kind;
        let third = 0x40 | (!a >> 4 & 1) << 3 | mask;
        self.bytes
            .extend([0x62, first, second, third, prefix.opcode]);
        self.operand(target, b, 64);
    }

    /// The operands' byte and the displacement, of which a short one counts `unit` bytes.
    fn operand(&mut self, target: u8, b: Operand, unit: i32) {
        let target = (target & 7) << 3;
        match b {
            Operand::Register(register) => self.bytes.push(0xC0 | target | register & 7),
            Operand::Memory(Memory { base, offset }) => {
                let short = (offset % unit == 0)
                    .then(|| i8::try_from(offset / unit).ok())
                    .flatten();
                match short {
                    Some(short) => {
                        self.bytes.extend([0x40 | target | base.0 & 7, short as u8]);
                    }
                    None => {
                        self.bytes.push(0x80 | target | base.0 & 7);
                        self.bytes.extend(offset.to_le_bytes());
                    }
                }
            }
        }
    }

    /// Marks that the upper halves of registers are not in use: before code that knows only 128 bits.
    pub(super) fn zero_upper(&mut self) {
        self.bytes.extend([0xC5, 0xF8, 0x77]);
    }

    pub(super) fn push(&mut self, register: Gpr) {
        self.whole(register, 0x50);
    }

    pub(super) fn pop(&mut self, register: Gpr) {
        self.whole(register, 0x58);
    }

    fn whole(&mut self, register: Gpr, opcode: u8) {
        if register.0 >= 8 {
            self.bytes.push(0x41);
        }
        self.bytes.push(opcode | register.0 & 7);
    }

    /// target ← source + offset.
    pub(super) fn address(&mut self, target: Gpr, source: Memory) {
        let Memory { base, offset } = source;
        let extension = 0x48 | (target.0 >> 3 & 1) << 2 | base.0 >> 3 & 1;
        let operands = 0x80 | (target.0 & 7) << 3 | base.0 & 7;
        self.bytes.extend([extension, 0x8D, operands]);
        self.bytes.extend(offset.to_le_bytes());
    }

    /// target ← a whole number of 64 bits.
    pub(super) fn constant(&mut self, target: Gpr, value: u64) {
        self.bytes.push(0x48 | target.0 >> 3 & 1);
        self.bytes.push(0xB8 | target.0 & 7);
        self.bytes.extend(value.to_le_bytes());
    }

    /// Calls the function that RAX points to.
    pub(super) fn call_rax(&mut self) {
        self.bytes.extend([0xFF, 0xD0]);
    }

    pub(super) fn give_back(&mut self) {
        self.bytes.push(0xC3);
    }

    /// register ← the smaller of register and limit, as addresses.
    pub(super) fn limit(&mut self, register: Gpr, limit: Gpr) {
        self.compare(register, limit);
        // cmova
        let extension = 0x48 | (register.0 >> 3 & 1) << 2 | limit.0 >> 3 & 1;
        let operands = 0xC0 | (register.0 & 7) << 3 | limit.0 & 7;
        self.bytes.extend([extension, 0x0F, 0x47, operands]);
    }

    fn compare(&mut self, a: Gpr, b: Gpr) {
        let extension = 0x48 | (b.0 >> 3 & 1) << 2 | a.0 >> 3 & 1;
        let operands = 0xC0 | (b.0 & 7) << 3 | a.0 & 7;
        self.bytes.extend([extension, 0x39, operands]);
    }

    /// Jumps on where a ≥ b, as addresses, to where [`Assembler::land`] says.
    pub(super) fn jump_unless_below(&mut self, a: Gpr, b: Gpr) -> Jump {
        self.compare(a, b);
        self.bytes.extend([0x0F, 0x83, 0, 0, 0, 0]);
        Jump(self.bytes.len())
    }

    /// Jumps on where one number of `register` is not below that in memory, to where [`Assembler::land`] says, once for
    /// each register that this one stands for. The numbers of the register `spare` are lost.
    pub(super) fn jump_unless_all_below(
        &mut self,
        width: Width,
        (register, spare): (u8, u8),
        bounds: Memory,
    ) -> Vec<Jump> {
        let compare = Prefix {
            kind: 1,
            map: FIRST_MAP,
            opcode: COMPARE,
        };
        let part = |part: u8| {
            let Memory { base, offset } = bounds;
            let offset = offset + i32::from(part) * EIGHT;
            let register = register + part * width.registers() as u8;
            (register, Operand::Memory(Memory { base, offset }))
        };
        let jump = |assembler: &mut Self| {
            assembler.bytes.extend([0x0F, 0x85, 0, 0, 0, 0]);
            Jump(assembler.bytes.len())
        };
        if matches!(width, Width::Eight | Width::Sixteen | Width::ThirtyTwo) {
            let parts = (0..width.parts()).map(part);
            return parts
                .map(|(register, bounds)| {
                    // Into the mask 1, whose bits kortestw looks at.
                    self.evex(compare, 1, register, bounds);
                    self.bytes.push(NOT_BELOW);
                    self.bytes.extend([0xC5, 0xF8, 0x98, 0xC9]);
                    jump(self)
                })
                .collect();
        }
        self.vex(width, compare, spare, register, Operand::Memory(bounds));
        self.bytes.push(NOT_BELOW);
        let signs = Prefix {
            opcode: SIGNS_OF,
            ..compare
        };
        self.vex(width, signs, Gpr::RAX.0, 0, Operand::Register(spare));
        self.bytes.extend([0x85, 0xC0]);
        vec![jump(self)]
    }

    /// The target of a jump is here.
    pub(super) fn land(&mut self, jump: Jump) {
        let distance = (self.bytes.len() - jump.0) as i32;
        self.bytes[jump.0 - 4..jump.0].copy_from_slice(&distance.to_le_bytes());
    }

    /// Jumps back to where the code was `target` bytes long.
    pub(super) fn jump_back(&mut self, target: usize) {
        self.bytes.push(0xE9);
        let distance = target as i64 - (self.bytes.len() as i64 + 4);
        self.bytes.extend((distance as i32).to_le_bytes());
    }
}
