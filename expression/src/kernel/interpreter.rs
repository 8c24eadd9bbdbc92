//! The interpreter: every instruction on all lanes before the next.

use std::cell::Cell;

use super::code::{Code, Instruction};
use crate::analytic::{FunctionPair, Member};
use crate::expression::Side;
use crate::vector::{InstructionSet, Work};

/// Runs `code` on `slots`, slot s of lane w at `[s*lanes + w]`.
///
/// A lane's bits depend on nothing but its own numbers. The usual numbers of lanes have loops of
/// their own; others go by blocks. An instruction on 32 lanes costs about three times one on a
/// single lane.
pub(super) fn run(code: &Code, slots: &mut [f64], lanes: usize) {
    match lanes {
        1 => execute(code, Arrays::<1>(slots.as_chunks_mut().0)),
        2 => execute(code, Arrays::<2>(slots.as_chunks_mut().0)),
        _ if lanes < 64 => {
            InstructionSet::best_of_256_bits().run(Wide { code, slots, lanes });
        }
        _ => InstructionSet::best().run(Wide { code, slots, lanes }),
    }
}

struct Wide<'a> {
    code: &'a Code,
    slots: &'a mut [f64],
    lanes: usize,
}

impl Work for Wide<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { code, slots, lanes } = self;
        match lanes {
            4 => execute(code, Arrays::<4>(slots.as_chunks_mut().0)),
            8 => execute(code, Arrays::<8>(slots.as_chunks_mut().0)),
            16 => execute(code, Arrays::<16>(slots.as_chunks_mut().0)),
            32 => execute(code, Arrays::<32>(slots.as_chunks_mut().0)),
            _ if lanes.is_multiple_of(16) => execute(code, Blocks::<16>::of(slots, lanes)),
            _ if lanes.is_multiple_of(8) => execute(code, Blocks::<8>::of(slots, lanes)),
            _ if lanes.is_multiple_of(4) => execute(code, Blocks::<4>::of(slots, lanes)),
            _ => execute(code, Blocks::<1>::of(slots, lanes)),
        }
    }
}

/// The numbers a program works on, a slot at a time.
trait Slots {
    /// Whether there are too few lanes for functions on many numbers.
    const FEW: bool;
    /// out ← f(a, b), lane by lane.
    fn combine(&mut self, out: u32, operands: [u32; 2], f: impl Fn(f64, f64) -> f64);
    /// out ← a, changed by `f`.
    fn change(&mut self, out: u32, a: u32, f: impl FnOnce(&mut [f64]));
    /// `f` of two different slots.
    fn change_two(&mut self, first: u32, second: u32, f: impl FnOnce(&mut [f64], &mut [f64]));
}

#[inline(always)]
fn execute<S: Slots>(code: &Code, mut slots: S) {
    let mut rest = code.instructions.as_slice();
    while let Some((instruction, after)) = rest.split_first() {
        rest = after;
        if !S::FEW
            && let Some((pair, [first, second], a)) = both(instruction, after)
        {
            slots.change(first, a, |_| ());
            slots.change_two(first, second, pair.lanes);
            rest = &after[1..];
            continue;
        }
        match *instruction {
            Instruction::Add { out, a, b } => slots.combine(out, [a, b], |a, b| a + b),
            Instruction::Subtract { out, a, b } => slots.combine(out, [a, b], |a, b| a - b),
            Instruction::Multiply { out, a, b } => slots.combine(out, [a, b], |a, b| a * b),
            Instruction::Divide { out, a, b } => slots.combine(out, [a, b], |a, b| a / b),
            Instruction::Negate { out, a } => slots.combine(out, [a, a], |a, _| -a),
            Instruction::Magnitude { out, a } => slots.combine(out, [a, a], |a, _| a.abs()),
            Instruction::Larger { out, a, b } => {
                slots.combine(out, [a, b], |a, b| if a > b { a } else { b });
            }
            Instruction::Smaller { out, a, b } => {
                slots.combine(out, [a, b], |a, b| if a < b { a } else { b });
            }
            Instruction::Keep { side, out, a, b } => match side {
                Side::Above => slots.combine(out, [a, b], |c, v| if c > 0.0 { v } else { 0.0 }),
                Side::Below => slots.combine(out, [a, b], |c, v| if c <= 0.0 { v } else { 0.0 }),
            },
            Instruction::ApplyTwo {
                function,
                out,
                a,
                b,
            } => slots.combine(out, [a, b], |a, b| function.apply(a, b)),
            Instruction::Power { out, a, b } => slots.combine(out, [a, b], libm::pow),
            Instruction::Apply { function, out, a } => {
                if S::FEW {
                    slots.combine(out, [a, a], |a, _| function.apply(a));
                } else {
                    slots.change(out, a, |values| function.apply_lanes(values));
                }
            }
            Instruction::ApplyAnalytic {
                function,
                order,
                out,
                a,
            } => {
                if S::FEW {
                    slots.combine(out, [a, a], |a, _| function.derivative(order, a));
                } else {
                    slots.change(out, a, |values| function.derivative_lanes(order, values));
                }
            }
        }
    }
}

/// A pair of functions of one argument that follow each other, their results' slots and the
/// argument's: both are computed at once.
fn both(
    instruction: &Instruction,
    after: &[Instruction],
) -> Option<(&'static FunctionPair, [u32; 2], u32)> {
    let (pair, member) = instruction.pair()?;
    let (next, other) = after
        .first()
        .and_then(|next| Some((next, next.pair()?.1)))?;
    let (next_pair, _) = next.pair()?;
    let ([a, _], [same, _]) = (instruction.operands(), next.operands());
    let (out, second) = (instruction.output(), next.output());
    let are_two =
        member == Member::First && other == Member::Second && pair.names == next_pair.names;
    (are_two && same == a && out != a && second != out).then_some((pair, [out, second], a))
}

/// Slots of W lanes each.
struct Arrays<'a, const W: usize>(&'a mut [[f64; W]]);

impl<const W: usize> Slots for Arrays<'_, W> {
    const FEW: bool = W < 4;

    #[inline(always)]
    fn combine(&mut self, out: u32, [a, b]: [u32; 2], f: impl Fn(f64, f64) -> f64) {
        let (a, b) = (self.0[a as usize], self.0[b as usize]);
        self.0[out as usize] = std::array::from_fn(|w| f(a[w], b[w]));
    }

    #[inline(always)]
    fn change(&mut self, out: u32, a: u32, f: impl FnOnce(&mut [f64])) {
        self.0[out as usize] = self.0[a as usize];
        f(&mut self.0[out as usize]);
    }

    #[inline(always)]
    fn change_two(&mut self, first: u32, second: u32, f: impl FnOnce(&mut [f64], &mut [f64])) {
        let [first, second] = disjoint(self.0, [first, second], 1);
        f(first.as_flattened_mut(), second.as_flattened_mut());
    }
}

/// Slots of any number of blocks of W lanes.
struct Blocks<'a, const W: usize> {
    blocks: &'a mut [[f64; W]],
    each: usize,
}

impl<'a, const W: usize> Blocks<'a, W> {
    fn of(slots: &'a mut [f64], lanes: usize) -> Self {
        Self {
            blocks: slots.as_chunks_mut().0,
            each: lanes / W,
        }
    }
}

impl<const W: usize> Slots for Blocks<'_, W> {
    const FEW: bool = false;

    #[inline(always)]
    fn combine(&mut self, out: u32, [a, b]: [u32; 2], f: impl Fn(f64, f64) -> f64) {
        // `out` may be one of the operands: a block is read before it is written.
        let cells = Cell::from_mut(&mut *self.blocks).as_slice_of_cells();
        let slot = |slot: u32| &cells[slot as usize * self.each..][..self.each];
        for ((out, a), b) in slot(out).iter().zip(slot(a)).zip(slot(b)) {
            let (a, b) = (a.get(), b.get());
            out.set(std::array::from_fn(|w| f(a[w], b[w])));
        }
    }

    #[inline(always)]
    fn change(&mut self, out: u32, a: u32, f: impl FnOnce(&mut [f64])) {
        let start = a as usize * self.each;
        let out = out as usize * self.each;
        self.blocks.copy_within(start..start + self.each, out);
        f(self.blocks[out..][..self.each].as_flattened_mut());
    }

    #[inline(always)]
    fn change_two(&mut self, first: u32, second: u32, f: impl FnOnce(&mut [f64], &mut [f64])) {
        let [first, second] = disjoint(self.blocks, [first, second], self.each);
        f(first.as_flattened_mut(), second.as_flattened_mut());
    }
}

/// Two different slots of `each` blocks.
fn disjoint<const W: usize>(
    blocks: &mut [[f64; W]],
    slots: [u32; 2],
    each: usize,
) -> [&mut [[f64; W]]; 2] {
    let ranges = slots.map(|slot| slot as usize * each..(slot as usize + 1) * each);
    blocks
        .get_disjoint_mut(ranges)
        .expect("two results stand in two slots")
}

#[cfg(test)]
mod tests {
    use crate::arithmetic::Arithmetic;
    use crate::expression::Function;
    use crate::graph::{Graph, Term};
    use crate::kernel::{Instruction, Kernel};

    /// sin x, x cos x and cos y, whatever is asked for first: sin x and cos x follow each other.
    #[test]
    fn a_sine_and_a_cosine_of_one_argument_are_neighbours() {
        for first in [Function::Sin, Function::Cos] {
            let mut graph = Graph::new();
            let (x, y) = (graph.input(0), graph.input(1));
            let second = if first == Function::Sin {
                Function::Cos
            } else {
                Function::Sin
            };
            let a = graph.apply(first, &x).expect("code");
            let product = graph.multiply(&a, &y);
            let other = graph.apply(Function::Cos, &y).expect("code");
            let b = graph.apply(second, &x).expect("code");
            let outputs: Vec<Term> = vec![product, other, graph.multiply(&b, &x)];
            let kernel = Kernel::compile(&graph, &outputs, 0, 2);
            let functions: Vec<(usize, Function, u32)> = kernel
                .step_code
                .instructions
                .iter()
                .enumerate()
                .filter_map(|(at, instruction)| match *instruction {
                    Instruction::Apply { function, a, .. } => Some((at, function, a)),
                    _ => None,
                })
                .collect();
            assert_eq!(functions.len(), 3);
            let sine = functions
                .iter()
                .position(|f| f.1 == Function::Sin)
                .expect("a sine");
            let (at, _, argument) = functions[sine];
            assert_eq!(functions[sine + 1], (at + 1, Function::Cos, argument));
            let values = |lanes: usize| {
                let mut workspace = kernel.workspace(lanes);
                let sizes = vec![1.0; lanes];
                kernel.prepare(&mut workspace, &[], &sizes, &sizes);
                let mut values = vec![0.0; 3 * lanes];
                let inputs = [vec![0.7; lanes], vec![-2.4; lanes]].concat();
                kernel.evaluate(&mut workspace, &inputs, &mut values);
                values
            };
            let alone = values(1);
            for lanes in [3, 8, 12, 32, 64, 80] {
                let together = values(lanes);
                for (lane, value) in together.iter().enumerate() {
                    assert_eq!(*value, alone[lane / lanes]);
                }
            }
        }
    }
}
