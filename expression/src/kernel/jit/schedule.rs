//! The order in which operations are issued.
//!
//! Depth first few results are alive at once, but each operation waits for the one before it, and a processor looks
//! about a hundred operations ahead. Among the next operations in that order those come first from which the longest
//! way leads to the end. They do as long as there are registers for the results that are alive. The source is Gibbons
//! and Muchnick, Efficient instruction scheduling for a pipelined architecture, SIGPLAN Notices 21 (1986).

use std::cmp::Reverse;

use super::operation::{Action, Operation, Source};

/// How far from the given order an operation may come early. Without a bound programs of thousands of operations, whose
/// results then live long, become slower.
const WINDOW: usize = 128;

/// How many sums, and how many others, begin in a cycle.
const AT_ONCE: usize = 2;

/// Cycles from the beginning of an operation to its result, about; functions are calls.
fn latency(action: Action) -> u64 {
    match action {
        Action::Negate | Action::And | Action::Magnitude | Action::Larger | Action::Smaller => 1,
        Action::Add | Action::Subtract | Action::Multiply => 3,
        // A comparison, and what is done with its result.
        Action::Keep(_) => 5,
        Action::TimesPlus | Action::TimesFrom => 4,
        Action::Divide => 13,
        Action::SquareRoot | Action::Call(_) => 40,
    }
}

/// `order`, in which operands come before what reads them, for `registers` registers.
pub(super) fn schedule(operations: &[Operation], order: &[usize], registers: usize) -> Vec<usize> {
    let mut schedule = Schedule::new(operations, order, registers);
    (0..order.len()).map(|_| order[schedule.issue()]).collect()
}

/// Operations by their places in the given order.
struct Schedule {
    nodes: Vec<Node>,
    registers: usize,
    /// The places before this one may be issued.
    end: usize,
    /// Those of them whose operands are issued.
    open: Vec<usize>,
    /// How many results are still to be read.
    alive: usize,
    cycle: u64,
    /// How many others, and how many sums, have begun in this cycle.
    begun: [usize; 2],
}

struct Node {
    latency: u64,
    is_sum: bool,
    /// The places of the operands, and of what reads the result.
    operands: Vec<usize>,
    readers: Vec<usize>,
    /// Cycles from the beginning to the program's end.
    way: u64,
    /// Operands that are not issued, readers that are not.
    waits: usize,
    unread: usize,
    /// When all operands are there.
    ready: u64,
}

impl Schedule {
    fn new(operations: &[Operation], order: &[usize], registers: usize) -> Self {
        let mut places = vec![usize::MAX; operations.len()];
        let mut nodes: Vec<Node> = Vec::with_capacity(order.len());
        for (place, &at) in order.iter().enumerate() {
            places[at] = place;
            let action = operations[at].action;
            let results = operations[at].sources().filter_map(|source| match source {
                Source::Result(result) => Some(places[result as usize]),
                Source::Slot(_) | Source::Own(_) => None,
            });
            let operands: Vec<usize> = results.collect();
            for &operand in &operands {
                nodes[operand].readers.push(place);
                nodes[operand].unread += 1;
            }
            nodes.push(Node {
                latency: latency(action),
                is_sum: matches!(action, Action::Add | Action::Subtract),
                waits: operands.len(),
                operands,
                readers: Vec::new(),
                way: 0,
                unread: 0,
                ready: 0,
            });
        }
        for place in (0..nodes.len()).rev() {
            let longest = nodes[place].readers.iter().map(|&reader| nodes[reader].way);
            nodes[place].way = nodes[place].latency + longest.max().unwrap_or(0);
        }
        let end = WINDOW.min(nodes.len());
        let open = (0..end).filter(|&place| nodes[place].waits == 0).collect();
        Self {
            nodes,
            registers,
            end,
            open,
            alive: 0,
            cycle: 0,
            begun: [0; 2],
        }
    }

    /// Issues the next operation; returns its place.
    fn issue(&mut self) -> usize {
        let chosen = self.choose();
        let place = self.open.swap_remove(chosen);
        self.wait_until(self.nodes[place].ready);
        self.begun[usize::from(self.nodes[place].is_sum)] += 1;
        self.alive = self.alive.saturating_add_signed(self.growth(place));
        let done = self.cycle + self.nodes[place].latency;
        for operand in std::mem::take(&mut self.nodes[place].operands) {
            self.nodes[operand].unread -= 1;
        }
        for reader in std::mem::take(&mut self.nodes[place].readers) {
            let node = &mut self.nodes[reader];
            node.waits -= 1;
            node.ready = node.ready.max(done);
            if node.waits == 0 && reader < self.end {
                self.open.push(reader);
            }
        }
        if let Some(node) = self.nodes.get(self.end) {
            if node.waits == 0 {
                self.open.push(self.end);
            }
            self.end += 1;
        }
        place
    }

    /// Where the next operation is among the open ones.
    fn choose(&mut self) -> usize {
        loop {
            let open = || self.open.iter().copied().enumerate();
            let fits = |place: usize| self.alive < self.registers || self.growth(place) <= 0;
            let begins = |place: usize| {
                let Node { ready, is_sum, .. } = self.nodes[place];
                ready <= self.cycle && self.begun[usize::from(is_sum)] < AT_ONCE
            };
            let longest = |place: usize| (self.nodes[place].way, Reverse(place));
            let now = open().filter(|&(_, place)| fits(place) && begins(place));
            if let Some((at, _)) = now.max_by_key(|&(_, place)| longest(place)) {
                return at;
            }
            let later = open().filter(|&(_, place)| fits(place));
            let cycles = later.map(|(_, place)| self.nodes[place].ready.max(self.cycle + 1));
            let Some(cycle) = cycles.min() else {
                // Whatever is next takes a register that is not there.
                let least =
                    open().min_by_key(|&(_, place)| (self.growth(place), Reverse(longest(place))));
                return least.map_or(0, |(at, _)| at);
            };
            self.wait_until(cycle);
        }
    }

    fn wait_until(&mut self, cycle: u64) {
        if cycle > self.cycle {
            self.cycle = cycle;
            self.begun = [0; 2];
        }
    }

    /// How many more results are alive behind an operation that was not issued than before it.
    fn growth(&self, place: usize) -> isize {
        let node = &self.nodes[place];
        let operands = node.operands.iter();
        let last = operands.filter(|&&operand| self.nodes[operand].unread == 1);
        isize::from(node.unread > 0) - last.count() as isize
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Action, Operation, Source, WINDOW, schedule};

    fn product(operands: [Option<usize>; 2]) -> Operation {
        let source = |operand: Option<usize>| match operand {
            Some(result) => Source::Result(result as u32),
            None => Source::Slot(0),
        };
        let [a, b] = operands.map(source);
        Operation::new(Action::Multiply, [a, b, b])
    }

    proptest! {
        /// Every operation is issued once, behind its operands, and none far before its turn.
        #[test]
        fn operands_come_first(
            choices in prop::collection::vec((0_usize..1000, 0_usize..1000), 1..400),
            registers in 0_usize..40,
        ) {
            let operand = |at: usize, choice: usize| (!choice.is_multiple_of(3) && at > 0).then(|| at - 1 - choice % at.min(50));
            let numbered = choices.iter().enumerate();
            let operations: Vec<Operation> = numbered
                .map(|(at, (a, b))| product([operand(at, *a), operand(at, *b)]))
                .collect();
            let order: Vec<usize> = (0..operations.len()).collect();
            let issued = schedule(&operations, &order, registers);
            let mut turn = vec![usize::MAX; operations.len()];
            for (k, &at) in issued.iter().enumerate() {
                prop_assert_eq!(turn[at], usize::MAX);
                prop_assert!(at < k + WINDOW);
                for source in operations[at].operands {
                    if let Source::Result(result) = source {
                        prop_assert!(turn[result as usize] < k);
                    }
                }
                turn[at] = k;
            }
            prop_assert_eq!(issued.len(), operations.len());
        }
    }

    /// Two products begin in a cycle and take three: of six chains none waits for itself, where there are registers.
    #[test]
    fn chains_take_turns() {
        let (chains, length) = (6_usize, 12_usize);
        let operations: Vec<Operation> = (0..chains * length)
            .map(|at| product([(!at.is_multiple_of(length)).then(|| at - 1), None]))
            .collect();
        let order: Vec<usize> = (0..operations.len()).collect();
        let issued = schedule(&operations, &order, chains);
        for (turn, at) in issued.iter().enumerate() {
            assert_eq!(at / length, turn % chains, "{issued:?}");
        }
        let one_register = schedule(&operations, &order, 1);
        assert_eq!(one_register, order);
    }
}
