//! Slots are reused once their last reader has run, so that a kernel's working set stays small.

use super::code::{Code, Instruction};

/// Renames the temporaries of `code` (slots from `fixed` on) so that dead ones are reused. Output k
/// stands in slot `fixed` + k, unless it is an input, a constant or an earlier output too.
pub(super) fn reuse_slots(code: Code, fixed: usize) -> Code {
    let mut last_use = vec![0_usize; code.slots];
    for (at, instruction) in code.instructions.iter().enumerate() {
        for operand in instruction.operands() {
            last_use[operand as usize] = at;
        }
    }
    for &output in &code.outputs {
        last_use[output as usize] = usize::MAX;
    }
    let mut names: Vec<u32> = (0..code.slots as u32).collect();
    let mut free: Vec<u32> = Vec::new();
    let mut slots = (fixed + code.outputs.len()) as u32;
    let mut places: Vec<Option<u32>> = vec![None; code.slots];
    for (k, &output) in code.outputs.iter().enumerate() {
        if output as usize >= fixed {
            places[output as usize].get_or_insert((fixed + k) as u32);
        }
    }
    let mut instructions: Vec<Instruction> = Vec::with_capacity(code.instructions.len());
    for (at, instruction) in code.instructions.into_iter().enumerate() {
        let [a, b] = instruction.operands();
        let out = instruction.output();
        // Operands that die here free their slots before the result takes one.
        for (first, operand) in [(true, a), (a != b, b)] {
            if first && operand as usize >= fixed && last_use[operand as usize] == at {
                free.push(names[operand as usize]);
            }
        }
        names[out as usize] = places[out as usize].unwrap_or_else(|| {
            free.pop().unwrap_or_else(|| {
                slots += 1;
                slots - 1
            })
        });
        // A renamed operand keeps its name although its slot may be the result's.
        instructions.push(instruction.renamed(|slot| names[slot as usize]));
    }
    let outputs = code
        .outputs
        .iter()
        .map(|&slot| names[slot as usize])
        .collect();
    Code {
        instructions,
        constants: code.constants,
        outputs,
        slots: slots as usize,
    }
}
