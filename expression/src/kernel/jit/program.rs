//! A program in single assignment, in the order in which it is carried out.

use rustc_hash::FxHashMap;

use super::operation::{Operation, Source};
use super::schedule::schedule;
use crate::analytic::Member;
use crate::kernel::code::Code;

/// Operations that read earlier results and slots.
#[derive(Clone, Debug, Default)]
pub(super) struct Program {
    /// The operations in order.
    pub(super) operations: Vec<Operation>,
    /// The number of slots of the code.
    pub(super) slots: usize,
}

impl Program {
    /// The operations of `code` that its outputs need, for a machine with so many registers. Depth first a result is
    /// computed where it is first read, of two operands the one first that keeps more results alive (Sethi and Ullman,
    /// The generation of optimal code for arithmetic expressions, J. ACM 17 (1970)); from there [`schedule`] goes on.
    /// Two functions of a pair are brought together where `by_pairs` says so.
    pub(super) fn new(code: &Code, registers: usize, by_pairs: bool) -> Self {
        let operations = single_assignment(code);
        let needs = registers_needed(&operations);
        let mut order = Vec::with_capacity(operations.len());
        let mut is_done = vec![false; operations.len()];
        let roots = (0..operations.len()).filter(|&at| operations[at].output.is_some());
        let mut pending = Vec::new();
        for root in roots {
            pending.push((root, false));
            while let Some((at, operands_are_done)) = pending.pop() {
                if is_done[at] {
                    continue;
                }
                if operands_are_done {
                    is_done[at] = true;
                    order.push(at);
                    continue;
                }
                pending.push((at, true));
                let [a, b] = operations[at].operands;
                let mut operands = [Some(a), (a != b).then_some(b)].map(|operand| match operand {
                    Some(Source::Result(result)) => Some(result as usize),
                    _ => None,
                });
                operands.sort_by_key(|operand| operand.map(|result| needs[result]));
                pending.extend(operands.into_iter().flatten().map(|result| (result, false)));
            }
        }
        let mut order = schedule(&operations, &order, registers);
        let seconds = if by_pairs {
            join_pairs(&operations, &mut order)
        } else {
            vec![false; operations.len()]
        };
        let mut names = vec![0; operations.len()];
        for (name, &at) in order.iter().enumerate() {
            names[at] = name as u32;
        }
        let renamed = |source: Source| match source {
            Source::Result(result) => Source::Result(names[result as usize]),
            slot @ Source::Slot(_) => slot,
        };
        let operations = (0..)
            .zip(&order)
            .map(|(place, &at): (u32, _)| {
                let mut operation = operations[at].clone();
                operation.is_second = seconds[at];
                operation.operands = if operation.is_second {
                    [Source::Result(place - 1); 2]
                } else {
                    operation.operands.map(renamed)
                };
                operation
            })
            .collect();
        Self {
            operations,
            slots: code.slots,
        }
    }
}

/// The code with its slots resolved: each operation has a result of its own.
fn single_assignment(code: &Code) -> Vec<Operation> {
    let mut current: Vec<Source> = (0..code.slots as u32).map(Source::Slot).collect();
    let mut operations = Vec::with_capacity(code.instructions.len());
    for (at, &instruction) in code.instructions.iter().enumerate() {
        operations.push(Operation {
            instruction,
            operands: instruction.operands().map(|slot| current[slot as usize]),
            output: None,
            is_second: false,
        });
        current[instruction.output() as usize] = Source::Result(at as u32);
    }
    for &slot in &code.outputs {
        if let Source::Result(result) = current[slot as usize] {
            operations[result as usize].output = Some(slot);
        }
    }
    operations
}

/// Brings two functions of one argument together, which cost little more than one of them; returns
/// which operations are the second of two.
fn join_pairs(operations: &[Operation], order: &mut Vec<usize>) -> Vec<bool> {
    let mut firsts: FxHashMap<(Source, [&str; 2]), (usize, Member)> = FxHashMap::default();
    let mut followers = vec![None; operations.len()];
    let mut are_second = vec![false; operations.len()];
    for &at in order.iter() {
        let Some((pair, member)) = operations[at].instruction.pair() else {
            continue;
        };
        let key = (operations[at].operands[0], pair.names);
        match firsts.get(&key) {
            Some((first, other)) if *other != member && followers[*first].is_none() => {
                followers[*first] = Some(at);
                are_second[at] = true;
            }
            Some(_) => {}
            None => {
                firsts.insert(key, (at, member));
            }
        }
    }
    let kept = order.iter().filter(|at| !are_second[**at]);
    *order = kept
        .flat_map(|&at| [Some(at), followers[at]])
        .flatten()
        .collect();
    are_second
}

/// How many results are alive at once while an operation's tree of operands is computed, as if
/// none were shared.
fn registers_needed(operations: &[Operation]) -> Vec<u32> {
    let mut needs: Vec<u32> = Vec::with_capacity(operations.len());
    for operation in operations {
        let [a, b] = operation.operands.map(|operand| match operand {
            Source::Slot(_) => 0,
            Source::Result(result) => needs[result as usize],
        });
        let is_one = operation.operands[0] == operation.operands[1];
        let both = if a == b && !is_one { a + 1 } else { a.max(b) };
        needs.push(both.max(1));
    }
    needs
}
