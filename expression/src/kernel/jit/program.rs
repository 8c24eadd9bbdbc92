//! A program in single assignment, in the order in which it is carried out.

use std::cmp::Reverse;

use rustc_hash::FxHashMap;

use super::assignment::{Arguments, Assignment, Limit};
use super::operation::{Action, Location, Operation, Source};
use super::schedule::schedule;
use crate::analytic::Member;
use crate::kernel::code::Code;
use crate::kernel::distances::{Distance, Distances};

/// Operations that read earlier results and slots.
#[derive(Clone, Debug, Default)]
pub(super) struct Program {
    /// The operations in order.
    pub(super) operations: Vec<Operation>,
    /// The number of slots of the code.
    pub(super) slots: usize,
    /// Numbers that stand in the scratch memory before it runs, each in a row over the lanes.
    pub(super) own: Vec<f64>,
    /// Limits of the sizes that it serves: results are those of the code where no limit is passed.
    pub(super) limits: Vec<Limit>,
    /// The outputs of the code.
    outputs: Vec<Source>,
    /// Numbers written into the array once the operations are done, each with its distance.
    pub(super) copies: Vec<(Source, Distance)>,
}

impl Program {
    /// The operations of `code` that its outputs need, for a machine with so many registers. Depth first a result is
    /// computed where it is first read, of two operands the one first that keeps more results alive. The source is
    /// Sethi and Ullman, The generation of optimal code for arithmetic expressions, J. ACM 17 (1970). From that order
    /// [`schedule`] goes on. Two functions of a pair are brought together where `by_pairs` says so.
    pub(super) fn new(code: &Code, arguments: Arguments, registers: usize, by_pairs: bool) -> Self {
        let Assignment {
            operations,
            own,
            limits,
            outputs,
        } = Assignment::new(code, arguments);
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
                let first = pending.len();
                let results = operations[at].sources().filter_map(Source::result);
                pending.extend(results.map(|result| (result, false)));
                pending[first..].sort_by_key(|(result, _)| needs[*result]);
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
            read @ (Source::Slot(_) | Source::Own(_)) => read,
        };
        let operations = (0..)
            .zip(&order)
            .map(|(place, &at): (u32, _)| {
                let mut operation = operations[at].clone();
                operation.is_second = seconds[at];
                operation.operands = if operation.is_second {
                    [Source::Result(place - 1); 3]
                } else {
                    operation.operands.map(renamed)
                };
                operation
            })
            .collect();
        Self {
            operations,
            slots: code.slots,
            own,
            limits,
            outputs: outputs.into_iter().map(renamed).collect(),
            copies: Vec::new(),
        }
    }

    /// The same along an array, where an output is written as soon as it is computed. It is written at the end where
    /// an input that it replaces is still to be read, or the results may turn out to be wrong.
    pub(super) fn along(mut self, distances: &Distances) -> Self {
        let mut last_reads = vec![0; distances.inputs.len()];
        for (at, operation) in self.operations.iter().enumerate() {
            for operand in operation.operands {
                if let Source::Slot(slot) = operand
                    && let Some(last) = last_reads.get_mut(slot as usize)
                {
                    *last = at;
                }
            }
        }
        for (&source, &distance) in self.outputs.iter().zip(&distances.outputs) {
            let is_read_later = |at: usize| {
                let mut inputs = distances.inputs.iter().zip(&last_reads);
                inputs.any(|(input, last)| *input == distance && *last > at)
            };
            match source.result() {
                Some(at)
                    if self.limits.is_empty()
                        && !is_read_later(at)
                        && !matches!(self.operations[at].output, Some(Location::Array(_))) =>
                {
                    self.operations[at].output = Some(Location::Array(distance));
                }
                _ => self.copies.push((source, distance)),
            }
        }
        self
    }
}

/// Brings two functions of one argument together, which cost little more than one of them; returns
/// which operations are the second of two.
fn join_pairs(operations: &[Operation], order: &mut Vec<usize>) -> Vec<bool> {
    let mut firsts: FxHashMap<(Source, [&str; 2]), (usize, Member)> = FxHashMap::default();
    let mut followers = vec![None; operations.len()];
    let mut are_second = vec![false; operations.len()];
    for &at in order.iter() {
        let Action::Call(instruction) = operations[at].action else {
            continue;
        };
        let Some((pair, member)) = instruction.pair() else {
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
        let mut of_operands: Vec<u32> = operation
            .sources()
            .filter_map(Source::result)
            .map(|result| needs[result])
            .collect();
        // While one is computed, those that need more stand in registers.
        of_operands.sort_unstable_by_key(|needs| Reverse(*needs));
        let most = (0..).zip(&of_operands).map(|(held, needs)| held + needs);
        needs.push(most.max().unwrap_or(0).max(1));
    }
    needs
}
