//! Instructions in the order of their kinds, of code that runs once in a while.
//!
//! An interpreter goes from an instruction to the code of the next one's kind. Where that was not there before a processor
//! foresees another of the same kind, and loses a dozen cycles with each that is not.

use std::collections::VecDeque;
use std::mem::{Discriminant, discriminant};

use super::code::Instruction;

/// So many instructions are ordered at a time, that results stay near.
const NEAR: usize = 1024;

/// Instructions of one kind after each other, as far as operands allow. Result k stands in slot `first` + k.
pub(super) fn by_kind(instructions: &mut [Instruction], mut first: usize) {
    for part in instructions.chunks_mut(NEAR) {
        order(part, first);
        first += part.len();
    }
}

fn order(instructions: &mut [Instruction], first: usize) {
    let made_here = |slot: u32| {
        let at = (slot as usize).checked_sub(first)?;
        (at < instructions.len()).then_some(at)
    };
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); instructions.len()];
    let mut missing = vec![0_usize; instructions.len()];
    for (at, instruction) in instructions.iter().enumerate() {
        for operand in instruction.operands().into_iter().filter_map(made_here) {
            readers[operand].push(at);
            missing[at] += 1;
        }
    }
    let mut ready = Ready::default();
    for at in (0..instructions.len()).filter(|at| missing[*at] == 0) {
        ready.add(&instructions[at], at);
    }
    let mut ordered = Vec::with_capacity(instructions.len());
    while let Some(kind) = ready.most() {
        while let Some(next) = ready.take(kind) {
            ordered.push(instructions[next]);
            for &reader in &readers[next] {
                missing[reader] -= 1;
                if missing[reader] == 0 {
                    ready.add(&instructions[reader], reader);
                }
            }
        }
    }
    instructions.copy_from_slice(&ordered);
}

/// Instructions whose operands are there, by their kinds, in the order in which they became so.
#[derive(Default)]
struct Ready(Vec<(Discriminant<Instruction>, VecDeque<usize>)>);

impl Ready {
    fn add(&mut self, instruction: &Instruction, at: usize) {
        let kind = discriminant(instruction);
        match self.0.iter_mut().find(|(own, _)| *own == kind) {
            Some((_, waiting)) => waiting.push_back(at),
            None => self.0.push((kind, VecDeque::from([at]))),
        }
    }

    /// The place of the kind of which there are most; `None` where there are none.
    fn most(&self) -> Option<usize> {
        let kinds = (0..self.0.len()).filter(|kind| !self.0[*kind].1.is_empty());
        kinds.max_by_key(|kind| self.0[*kind].1.len())
    }

    fn take(&mut self, kind: usize) -> Option<usize> {
        self.0[kind].1.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use std::mem::discriminant;

    use proptest::prelude::*;

    use crate::kernel::code::{Code, Instruction};
    use crate::kernel::draft::Draft;
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
