//! The interpreter: every instruction on all lanes before the next.

use super::code::{Code, Instruction};

/// The lane counts with a specialized loop; any other count runs one lane at a time.
const WIDE: usize = 8;

/// Runs `code` on `slots`, slot s of lane w at `[s*lanes + w]`.
pub(super) fn run(code: &Code, slots: &mut [f64], lanes: usize) {
    match lanes {
        1 => run_lanes::<1>(code, slots.as_chunks_mut().0),
        WIDE => run_lanes::<WIDE>(code, slots.as_chunks_mut().0),
        _ => run_any(code, slots, lanes),
    }
}

fn run_lanes<const W: usize>(code: &Code, slots: &mut [[f64; W]]) {
    for instruction in &code.instructions {
        match *instruction {
            Instruction::Add { out, a, b } => {
                let (a, b) = (slots[a as usize], slots[b as usize]);
                slots[out as usize] = std::array::from_fn(|w| a[w] + b[w]);
            }
            Instruction::Subtract { out, a, b } => {
                let (a, b) = (slots[a as usize], slots[b as usize]);
                slots[out as usize] = std::array::from_fn(|w| a[w] - b[w]);
            }
            Instruction::Multiply { out, a, b } => {
                let (a, b) = (slots[a as usize], slots[b as usize]);
                slots[out as usize] = std::array::from_fn(|w| a[w] * b[w]);
            }
            Instruction::Divide { out, a, b } => {
                let (a, b) = (slots[a as usize], slots[b as usize]);
                slots[out as usize] = std::array::from_fn(|w| a[w] / b[w]);
            }
            Instruction::Negate { out, a } => {
                let a = slots[a as usize];
                slots[out as usize] = std::array::from_fn(|w| -a[w]);
            }
            Instruction::Apply { function, out, a } => {
                let a = slots[a as usize];
                slots[out as usize] = std::array::from_fn(|w| function.apply(a[w]));
            }
            Instruction::ApplyAnalytic {
                function,
                order,
                out,
                a,
            } => {
                let a = slots[a as usize];
                slots[out as usize] = std::array::from_fn(|w| function.derivative(order, a[w]));
            }
            Instruction::Power { out, a, b } => {
                let (a, b) = (slots[a as usize], slots[b as usize]);
                slots[out as usize] = std::array::from_fn(|w| libm::pow(a[w], b[w]));
            }
        }
    }
}

fn run_any(code: &Code, slots: &mut [f64], lanes: usize) {
    let mut single = vec![[0.0]; code.slots];
    for lane in 0..lanes {
        for (slot, value) in single.iter_mut().enumerate() {
            value[0] = slots[slot * lanes + lane];
        }
        run_lanes::<1>(code, &mut single);
        for (slot, value) in single.iter().enumerate() {
            slots[slot * lanes + lane] = value[0];
        }
    }
}
