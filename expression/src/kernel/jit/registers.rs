//! Which numbers stand in registers: the one whose next use is farthest leaves first (Belady, A
//! study of replacement algorithms for a virtual-storage computer, IBM Systems J. 5 (1966)). Code along an array keeps
//! numbers that are the same at every place in registers that nothing else needs.

use std::cmp::Reverse;

use rustc_hash::FxHashMap;

use super::operation::{Action, Location, Operation, Source};
use super::program::Program;

/// Next step of the machine, an operation or a movement of a number.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// Loads a number that is in memory into a register.
    Load(Source),
    /// Computes the operation of this number. An operand without a register is read from memory.
    Operate(u32),
    /// Stores a result where the caller reads it.
    Output(u32),
    /// Stores a result in a place of the scratch memory.
    Spill(u32, u32),
    /// The number has no register any more.
    Forget(Source),
}

/// A program with every load and store.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// The steps in order.
    pub(super) steps: Vec<Step>,
    /// The places of scratch memory that spilled results take.
    pub(super) places: usize,
    /// The numbers that stand in registers from before the first place on.
    pub(super) resident: Vec<Source>,
}

/// Never read again.
const NEVER: usize = usize::MAX;

/// A store costs as much as so many loads; loads that a sum or product does itself are free.
const STORE: usize = 2;

impl Plan {
    /// The loads and stores of `program` on a machine with `registers` registers.
    pub(super) fn new(program: &Program, registers: usize) -> Self {
        Self::with_resident(program, registers, Vec::new()).0
    }

    /// The same of code that runs at one place after the other, whose slots from `inputs` on are the same at each. Those
    /// read most often stay in registers that are free throughout. A call would lose them.
    pub(super) fn along(program: &Program, registers: usize, inputs: usize) -> Self {
        let (plan, most) = Self::with_resident(program, registers, Vec::new());
        let calls = |operation: &Operation| matches!(operation.action, Action::Call(_));
        if most >= registers || program.operations.iter().any(calls) {
            return plan;
        }
        let mut reads: FxHashMap<Source, usize> = FxHashMap::default();
        let mut order = Vec::new();
        for source in program.operations.iter().flat_map(Operation::sources) {
            if matches!(source, Source::Slot(slot) if slot as usize >= inputs) {
                let count = reads.entry(source).or_insert(0);
                if *count == 0 {
                    order.push(source);
                }
                *count += 1;
            }
        }
        order.sort_by_key(|source| Reverse(reads[source]));
        order.truncate(registers - most);
        Self::with_resident(program, registers - order.len(), order).0
    }

    /// The plan with these numbers in registers beside the others, and how many of the others are ever in use.
    fn with_resident(program: &Program, registers: usize, resident: Vec<Source>) -> (Self, usize) {
        let mut planner = Planner {
            next: next_uses(program),
            homes: vec![None; program.operations.len()],
            held: Vec::with_capacity(registers),
            free: Vec::new(),
            plan: Self {
                resident,
                ..Self::default()
            },
            registers,
            most: 0,
        };
        for (at, operation) in program.operations.iter().enumerate() {
            planner.operate(at, operation);
        }
        (planner.plan, planner.most)
    }
}

/// For each operation, when its operands and its result are read next.
struct NextUses {
    operands: Vec<[usize; 3]>,
    result: Vec<usize>,
}

fn next_uses(program: &Program) -> NextUses {
    let count = program.operations.len();
    let mut operands = vec![[NEVER; 3]; count];
    let mut result = vec![NEVER; count];
    let mut slots = vec![NEVER; program.slots];
    for (at, operation) in program.operations.iter().enumerate().rev() {
        for (k, &operand) in operation.operands.iter().enumerate() {
            operands[at][k] = match operand {
                Source::Slot(slot) => slots[slot as usize],
                Source::Result(other) => result[other as usize],
                Source::Own(_) => NEVER,
            };
        }
        for &operand in &operation.operands {
            match operand {
                Source::Slot(slot) => slots[slot as usize] = at,
                Source::Result(other) => result[other as usize] = at,
                Source::Own(_) => {}
            }
        }
    }
    NextUses { operands, result }
}

/// A number in a register.
#[derive(Clone, Copy, Debug)]
struct Held {
    source: Source,
    next: usize,
}

struct Planner {
    next: NextUses,
    homes: Vec<Option<Location>>,
    held: Vec<Held>,
    free: Vec<u32>,
    plan: Plan,
    registers: usize,
    /// The most numbers that were held at once.
    most: usize,
}

impl Planner {
    fn operate(&mut self, at: usize, operation: &Operation) {
        let next = self.next.operands[at];
        let used: Vec<(Source, usize)> = operation
            .sources()
            .map(|source| {
                let place = operation.operands.iter().position(|own| *own == source);
                (source, place.map_or(NEVER, |k| next[k]))
            })
            .collect();
        let operands = &used[..];
        let from_memory = self.read_from_memory(operation, next);
        for &(operand, _) in operands {
            if !from_memory.contains(&Some(operand)) && !self.is_held(operand) {
                self.make_room(at, operation.operands);
                self.plan.steps.push(Step::Load(operand));
                self.hold(operand, at);
            }
        }
        let is_call = matches!(operation.action, Action::Call(_)) && !operation.is_second;
        if is_call {
            self.store_all(operands);
        }
        self.plan.steps.push(Step::Operate(at as u32));
        for &(operand, next) in operands {
            if next == NEVER {
                self.release(operand);
            } else if let Some(held) = self.held.iter_mut().find(|held| held.source == operand) {
                held.next = next;
            }
        }
        if is_call {
            let forgotten = self.held.drain(..).map(|held| Step::Forget(held.source));
            self.plan.steps.extend(forgotten);
        }
        self.keep(at, operation.output);
    }

    /// The operands that the operation reads from memory while it computes, free of charge. That is either one of a
    /// sum or product, and the second one of a difference or quotient. Of two in memory it is the one that is read
    /// again later. A fused product reads one factor, which its result replaces, and its summand.
    fn read_from_memory(&self, operation: &Operation, next: [usize; 3]) -> [Option<Source>; 2] {
        let [a, b, c] = operation.operands;
        let in_memory = |source: Source| !self.is_held(source);
        let factor = match [in_memory(a), in_memory(b)] {
            _ if a == b => None,
            [true, true] if next[0] > next[1] => Some(a),
            [_, true] => Some(b),
            [true, false] => Some(a),
            [false, false] => None,
        };
        match operation.action {
            Action::Add | Action::Multiply => [factor, None],
            Action::TimesPlus | Action::TimesFrom => {
                let other = if factor == Some(a) { b } else { a };
                [factor, (in_memory(c) && c != other).then_some(c)]
            }
            Action::Subtract | Action::Divide | Action::And | Action::Larger | Action::Smaller
                if a != b =>
            {
                [in_memory(b).then_some(b), None]
            }
            _ => [None; 2],
        }
    }

    fn is_held(&self, source: Source) -> bool {
        self.plan.resident.contains(&source) || self.held.iter().any(|held| held.source == source)
    }

    fn hold(&mut self, source: Source, next: usize) {
        self.held.push(Held { source, next });
        self.most = self.most.max(self.held.len());
    }

    /// Whether the number can be read from memory.
    fn is_stored(&self, source: Source) -> bool {
        match source {
            Source::Slot(_) | Source::Own(_) => true,
            Source::Result(result) => self.homes[result as usize].is_some(),
        }
    }

    /// Frees a register where all are taken, but none of `wanted`.
    fn make_room(&mut self, at: usize, wanted: [Source; 3]) {
        if self.held.len() < self.registers {
            return;
        }
        let victim = (0..self.held.len())
            .filter(|&k| !wanted.contains(&self.held[k].source))
            .max_by_key(|&k| {
                let Held { source, next } = self.held[k];
                let distance = next.saturating_sub(at);
                distance.saturating_mul(if self.is_stored(source) { STORE } else { 1 })
            });
        if let Some(victim) = victim {
            let victim = self.held.swap_remove(victim).source;
            self.store(victim);
            self.plan.steps.push(Step::Forget(victim));
        }
    }

    fn store(&mut self, source: Source) {
        if let Source::Result(result) = source
            && self.homes[result as usize].is_none()
        {
            let place = self.free.pop().unwrap_or_else(|| {
                self.plan.places += 1;
                self.plan.places as u32 - 1
            });
            self.homes[result as usize] = Some(Location::Place(place));
            self.plan.steps.push(Step::Spill(result, place));
        }
    }

    /// Stores what a call would destroy, except what is not read after it.
    fn store_all(&mut self, operands: &[(Source, usize)]) {
        for k in 0..self.held.len() {
            let source = self.held[k].source;
            if !operands.contains(&(source, NEVER)) {
                self.store(source);
            }
        }
    }

    /// The number is not read again.
    fn release(&mut self, source: Source) {
        if let Some(k) = self.held.iter().position(|held| held.source == source) {
            self.held.swap_remove(k);
            self.plan.steps.push(Step::Forget(source));
        }
        if let Source::Result(result) = source
            && let Some(Location::Place(place)) = self.homes[result as usize]
        {
            self.free.push(place);
        }
    }

    /// The result stays in a register if it is read again, and is stored if it is an output.
    fn keep(&mut self, at: usize, output: Option<Location>) {
        let source = Source::Result(at as u32);
        if output.is_some() {
            self.homes[at] = output;
            self.plan.steps.push(Step::Output(at as u32));
        }
        if self.next.result[at] == NEVER {
            self.plan.steps.push(Step::Forget(source));
        } else {
            self.make_room(at, [source; 3]);
            self.hold(source, self.next.result[at]);
        }
    }
}
