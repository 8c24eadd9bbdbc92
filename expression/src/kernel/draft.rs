//! Code while it is written.

use rustc_hash::FxHashMap;

use super::allocate::reuse_slots;
use super::code::{Code, Instruction};
use super::kinds::by_kind;

/// Code whose every result has a slot of its own, until it is finished.
pub(super) struct Draft {
    instructions: Vec<Instruction>,
    /// The slots of the results.
    pub(super) outputs: Vec<u32>,
    slots: usize,
    /// The first slots, of inputs and coefficients.
    fixed: usize,
    /// The slots of numbers, by their bits.
    numbers: FxHashMap<u64, u32>,
}

/// Numbers stand in slots from here on until it is known how many there are.
const NUMBERS: u32 = 1 << 31;

impl Draft {
    /// Nothing yet, over so many slots that stand before the first instruction.
    pub(super) fn new(fixed: usize) -> Self {
        Self {
            instructions: Vec::new(),
            outputs: Vec::new(),
            slots: fixed,
            fixed,
            numbers: FxHashMap::default(),
        }
    }

    /// How many slots stand before the first instruction.
    pub(super) fn fixed(&self) -> usize {
        self.fixed
    }

    /// The slot of a number.
    pub(super) fn number(&mut self, value: f64) -> u32 {
        let next = NUMBERS + self.numbers.len() as u32;
        *self.numbers.entry(value.to_bits()).or_insert(next)
    }

    /// The slot of an instruction's result.
    pub(super) fn push(&mut self, instruction: impl FnOnce(u32) -> Instruction) -> u32 {
        let out = self.slots as u32;
        self.slots += 1;
        self.instructions.push(instruction(out));
        out
    }

    /// The instructions of other code, whose first slots are those of `given`; returns the slots of its outputs.
    pub(super) fn append(&mut self, code: &Code, given: &[u32]) -> Vec<u32> {
        let mut names = vec![0; code.slots];
        names[..given.len()].copy_from_slice(given);
        for &(slot, value) in &code.constants {
            names[slot as usize] = self.number(value);
        }
        for instruction in &code.instructions {
            let [a, b] = instruction.operands().map(|slot| names[slot as usize]);
            let out = self.push(|out| instruction.over(out, [a, b]));
            names[instruction.output() as usize] = out;
        }
        let outputs = code.outputs.iter();
        outputs.map(|slot| names[*slot as usize]).collect()
    }

    /// The same with instructions of one kind after each other, as far as their operands allow.
    pub(super) fn by_kind(mut self) -> Self {
        by_kind(&mut self.instructions, self.fixed);
        self
    }

    /// The code: numbers behind the fixed slots, slots of temporaries used again.
    pub(super) fn finish(self) -> Code {
        let (fixed, numbers) = (self.fixed as u32, self.numbers.len() as u32);
        let name = |slot: u32| {
            if slot >= NUMBERS {
                fixed + (slot - NUMBERS)
            } else if slot >= fixed {
                slot + numbers
            } else {
                slot
            }
        };
        let constants = self.numbers.iter();
        let constants = constants.map(|(&bits, &slot)| (name(slot), f64::from_bits(bits)));
        let mut constants: Vec<(u32, f64)> = constants.collect();
        constants.sort_unstable_by_key(|(slot, _)| *slot);
        let instructions = self.instructions.iter();
        let code = Code {
            instructions: instructions.map(|i| i.renamed(name)).collect(),
            constants,
            outputs: self.outputs.iter().map(|slot| name(*slot)).collect(),
            slots: self.slots + numbers as usize,
        };
        reuse_slots(code, (fixed + numbers) as usize)
    }
}
