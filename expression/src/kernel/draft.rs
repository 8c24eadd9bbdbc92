//! Code while it is written.

use std::collections::VecDeque;
use std::mem::{Discriminant, discriminant};

use rustc_hash::FxHashMap;

use super::allocate::reuse_slots;
use super::code::{Code, Instruction};

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

/// Instructions that are ordered by their kinds at a time.
const NEAR: usize = 1024;

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

    /// The same with instructions of one kind after each other, as far as their operands allow: what runs once is decoded
    /// from an instruction to the next, and a processor foresees that the next one is of the same kind. So many at a time
    /// as have results that stay near.
    pub(super) fn by_kind(mut self) -> Self {
        let mut first = self.fixed;
        for part in self.instructions.chunks_mut(NEAR) {
            order_by_kind(part, first);
            first += part.len();
        }
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

/// Orders instructions, whose results stand in the slots from `first` on, by their kinds.
fn order_by_kind(instructions: &mut [Instruction], first: usize) {
    // The instruction that makes each slot, and those that wait for each.
    let maker = |slot: u32| {
        let made = (slot as usize).checked_sub(first)?;
        (made < instructions.len()).then_some(made)
    };
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); instructions.len()];
    let mut missing = vec![0_usize; instructions.len()];
    for (at, instruction) in instructions.iter().enumerate() {
        for made in instruction.operands().into_iter().filter_map(maker) {
            readers[made].push(at);
            missing[at] += 1;
        }
    }
    let mut ready: Vec<(Discriminant<Instruction>, VecDeque<usize>)> = Vec::new();
    let offer = |ready: &mut Vec<(_, VecDeque<usize>)>, at: usize| {
        let kind = discriminant(&instructions[at]);
        match ready.iter_mut().find(|(own, _)| *own == kind) {
            Some((_, waiting)) => waiting.push_back(at),
            None => ready.push((kind, VecDeque::from([at]))),
        }
    };
    (0..instructions.len())
        .filter(|at| missing[*at] == 0)
        .for_each(|at| offer(&mut ready, at));
    let mut ordered = Vec::with_capacity(instructions.len());
    while let Some(most) = (0..ready.len()).max_by_key(|at| ready[*at].1.len()) {
        let Some(mut next) = ready[most].1.pop_front() else {
            break;
        };
        loop {
            ordered.push(instructions[next]);
            for reader in &readers[next] {
                missing[*reader] -= 1;
                if missing[*reader] == 0 {
                    offer(&mut ready, *reader);
                }
            }
            match ready[most].1.pop_front() {
                Some(more) => next = more,
                None => break,
            }
        }
    }
    instructions.copy_from_slice(&ordered);
}

#[cfg(test)]
mod tests {
    use std::mem::discriminant;

    use proptest::prelude::*;

    use super::Draft;
    use crate::kernel::code::{Code, Instruction};
    use crate::kernel::interpreter::run;

    /// Sums, quotients and signs of three inputs and each other, everything an output.
    fn drafted(choices: &[(u8, usize, usize)]) -> Draft {
        let mut draft = Draft::new(3);
        let mut slots = vec![0, 1, 2, draft.number(0.75)];
        for &(kind, a, b) in choices {
            let [a, b] = [a, b].map(|at| slots[at % slots.len()]);
            slots.push(draft.push(|out| match kind % 4 {
                0 => Instruction::Add { out, a, b },
                1 => Instruction::Multiply { out, a, b },
                2 => Instruction::Divide { out, a, b },
                _ => Instruction::Negate { out, a },
            }));
        }
        draft.outputs = slots;
        draft
    }

    fn values(code: &Code) -> Vec<u64> {
        let mut slots = vec![0.0; code.slots];
        slots[..3].copy_from_slice(&[1.5, -0.3, 0.7]);
        for &(slot, value) in &code.constants {
            slots[slot as usize] = value;
        }
        run(code, &mut slots, 1);
        let outputs = code.outputs.iter();
        outputs
            .map(|slot| slots[*slot as usize].to_bits())
            .collect()
    }

    fn changes(code: &Code) -> usize {
        let pairs = code.instructions.windows(2);
        pairs
            .filter(|two| discriminant(&two[0]) != discriminant(&two[1]))
            .count()
    }

    proptest! {
        /// In the order of their kinds instructions make the same bits.
        #[test]
        fn an_order_by_kinds_changes_no_bit(choices in prop::collection::vec(any::<(u8, usize, usize)>(), 0..6000)) {
            let written = drafted(&choices).finish();
            let ordered = drafted(&choices).by_kind().finish();
            prop_assert_eq!(written.count(), ordered.count());
            prop_assert_eq!(values(&written), values(&ordered));
        }
    }

    /// Of three kinds, all over the inputs: the kind changes twice.
    #[test]
    fn instructions_of_one_kind_follow_each_other() {
        let choices: Vec<(u8, usize, usize)> = (0..300)
            .map(|at| ((at % 3) as u8, at % 4, at / 3 % 4))
            .collect();
        let written = changes(&drafted(&choices).finish());
        let ordered = changes(&drafted(&choices).by_kind().finish());
        assert_eq!([written, ordered], [299, 2]);
    }
}
