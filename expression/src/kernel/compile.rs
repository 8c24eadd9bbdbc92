//! From a graph to a coefficient kernel and a step kernel.

use rustc_hash::FxHashMap;

use super::allocate::reuse_slots;
use super::code::{Code, Instruction, OperationCount};
use crate::graph::{Graph, Node, Operation, StepSize, Term, Tier};
use crate::rational::Rational;

/// Two programs for one list of outputs.
///
/// The *coefficient kernel* computes what depends on parameters, ε and h alone, once for each
/// choice of them; the *step kernel* takes the state and those coefficients. Changing a parameter
/// or a step size recompiles nothing.
#[derive(Clone, Debug)]
pub struct Kernel {
    pub(super) parameters: usize,
    pub(super) inputs: usize,
    pub(super) coefficients: usize,
    pub(super) coefficient_code: Code,
    pub(super) step_code: Code,
}

impl Kernel {
    /// Compiles `outputs` of a graph over `parameters` parameters and `inputs` kernel inputs.
    pub fn compile(graph: &Graph, outputs: &[Term], parameters: usize, inputs: usize) -> Self {
        let live = live_nodes(graph, outputs);
        let imported = imported_coefficients(graph, outputs, &live);

        // Coefficient kernel: slots 0 .. parameters, then ε and h.
        let mut coefficient = Emitter::new(parameters + 2);
        for node in (0..graph.len() as u32).map(Node) {
            if live[node.index()] && graph.tier(node) == Tier::Coefficient {
                coefficient.emit_node(graph, node, parameters);
            }
        }
        coefficient.code.outputs =
            imported.iter().map(|node| coefficient.places[node]).collect();
        let coefficient_code = coefficient.finish();

        // Step kernel: slots 0 .. inputs, then the coefficients.
        let mut step = Emitter::new(inputs + imported.len());
        for (at, &node) in imported.iter().enumerate() {
            step.places.insert(node, (inputs + at) as u32);
        }
        for node in (0..graph.len() as u32).map(Node) {
            if live[node.index()] && graph.tier(node) == Tier::Step {
                step.emit_node(graph, node, parameters);
            }
        }
        step.code.outputs = outputs.iter().map(|term| step.scaled(term)).collect();
        let step_code = step.finish();
        Self {
            parameters,
            inputs,
            coefficients: imported.len(),
            coefficient_code,
            step_code,
        }
    }

    /// The number of outputs.
    pub fn outputs(&self) -> usize {
        self.step_code.outputs.len()
    }

    /// The number of inputs that change with the state.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Operations of one evaluation of the step kernel.
    pub fn step_operations(&self) -> OperationCount {
        self.step_code.count()
    }

    /// Operations of the coefficient kernel, once for each choice of parameters and step sizes.
    pub fn coefficient_operations(&self) -> OperationCount {
        self.coefficient_code.count()
    }

    /// How many coefficients pass from the one kernel to the other.
    pub fn coefficients(&self) -> usize {
        self.coefficients
    }
}

fn live_nodes(graph: &Graph, outputs: &[Term]) -> Vec<bool> {
    let mut live = vec![false; graph.len()];
    for term in outputs {
        if !term.scale.is_zero() {
            live[term.node.index()] = true;
        }
    }
    for index in (0..graph.len()).rev() {
        if live[index] {
            for operand in operands(graph, Node(index as u32)) {
                live[operand.index()] = true;
            }
        }
    }
    live
}

/// The coefficients that state-dependent operations or outputs read, by number.
fn imported_coefficients(graph: &Graph, outputs: &[Term], live: &[bool]) -> Vec<Node> {
    let is_coefficient = |node: Node| graph.tier(node) == Tier::Coefficient;
    let mut imported: Vec<Node> = (0..graph.len() as u32)
        .map(Node)
        .filter(|n| live[n.index()] && graph.tier(*n) == Tier::Step)
        .flat_map(|n| operands(graph, n))
        .chain(outputs.iter().filter(|t| !t.scale.is_zero()).map(|t| t.node))
        .filter(|n| is_coefficient(*n))
        .collect();
    imported.sort_unstable();
    imported.dedup();
    imported
}

fn operands(graph: &Graph, node: Node) -> Vec<Node> {
    match graph.operation(node) {
        Operation::One
        | Operation::Pi
        | Operation::Parameter(_)
        | Operation::StepSize(_)
        | Operation::Input(_) => Vec::new(),
        Operation::Sum(terms) => terms.iter().map(|t| t.1).collect(),
        Operation::Scale(_, a) | Operation::Reciprocal(a) | Operation::Function(_, a) => vec![*a],
        Operation::Product(a, b) | Operation::Power(a, b) => vec![*a, *b],
    }
}

struct Emitter {
    code: Code,
    fixed: usize,
    places: FxHashMap<Node, u32>,
    constants: FxHashMap<u64, u32>,
    outputs: FxHashMap<(Node, u64), u32>,
}

/// Constants are numbered from here until the number of temporaries is known.
const CONSTANT_BASE: u32 = 1 << 31;

impl Emitter {
    fn new(fixed: usize) -> Self {
        let code = Code { slots: fixed, ..Code::default() };
        Self {
            code,
            fixed,
            places: FxHashMap::default(),
            constants: FxHashMap::default(),
            outputs: FxHashMap::default(),
        }
    }

    fn constant(&mut self, value: &Rational) -> u32 {
        self.number(value.to_f64())
    }

    fn number(&mut self, value: f64) -> u32 {
        let next = CONSTANT_BASE + self.constants.len() as u32;
        *self.constants.entry(value.to_bits()).or_insert(next)
    }

    fn push(&mut self, instruction: impl FnOnce(u32) -> Instruction) -> u32 {
        let out = self.code.slots as u32;
        self.code.slots += 1;
        self.code.instructions.push(instruction(out));
        out
    }

    fn place(&mut self, node: Node) -> u32 {
        if node == Graph::ONE { self.number(1.0) } else { self.places[&node] }
    }

    /// The slot that holds a whole term.
    fn scaled(&mut self, term: &Term) -> u32 {
        if term.scale.is_zero() || term.node == Graph::ONE {
            return self.constant(&term.scale);
        }
        let key = (term.node, term.scale.to_f64().to_bits());
        if let Some(&known) = self.outputs.get(&key) {
            return known;
        }
        let a = self.place(term.node);
        let slot = if term.scale.is_one() {
            a
        } else if (-&term.scale).is_one() {
            self.push(|out| Instruction::Negate { out, a })
        } else {
            let b = self.constant(&term.scale);
            self.push(|out| Instruction::Multiply { out, a, b })
        };
        self.outputs.insert(key, slot);
        slot
    }

    fn emit_node(&mut self, graph: &Graph, node: Node, parameters: usize) {
        let slot = match graph.operation(node) {
            Operation::One => return,
            Operation::Pi => self.number(std::f64::consts::PI),
            Operation::Parameter(index) => *index,
            Operation::StepSize(StepSize::Epsilon) => parameters as u32,
            Operation::StepSize(StepSize::H) => parameters as u32 + 1,
            Operation::Input(index) => *index,
            Operation::Sum(terms) => self.emit_sum(terms),
            Operation::Scale(scale, a) => {
                self.scaled(&Term { scale: scale.clone(), node: *a })
            }
            Operation::Product(a, b) => {
                let (a, b) = (self.place(*a), self.place(*b));
                self.push(|out| Instruction::Multiply { out, a, b })
            }
            Operation::Reciprocal(b) => {
                let (a, b) = (self.number(1.0), self.place(*b));
                self.push(|out| Instruction::Divide { out, a, b })
            }
            Operation::Function(function, a) => {
                let a = self.place(*a);
                self.push(|out| Instruction::Apply { function: *function, out, a })
            }
            Operation::Power(a, b) => {
                let (a, b) = (self.place(*a), self.place(*b));
                self.push(|out| Instruction::Power { out, a, b })
            }
        };
        self.places.insert(node, slot);
    }

    /// Σ cᵢ nᵢ: terms with the same |c| are added before they are multiplied.
    fn emit_sum(&mut self, terms: &[(Rational, Node)]) -> u32 {
        let mut groups: Vec<(Rational, Vec<(bool, Node)>)> = Vec::new();
        for (scale, node) in terms {
            let (size, negative) = (scale.abs(), scale.is_negative());
            // The constant term is one number, not a product with 1.
            let grouped = groups.iter_mut().find(|g| g.0 == size && *node != Graph::ONE);
            match grouped {
                Some(group) => group.1.push((negative, *node)),
                None => groups.push((size, vec![(negative, *node)])),
            }
        }
        let mut parts: Vec<(bool, u32)> = Vec::new();
        for (size, members) in groups {
            if members[0].1 == Graph::ONE {
                let number = self.constant(&size);
                parts.push((members[0].0, number));
            } else if size.is_one() {
                for (negative, node) in members {
                    parts.push((negative, self.place(node)));
                }
            } else {
                let members: Vec<_> =
                    members.into_iter().map(|(sign, node)| (sign, self.place(node))).collect();
                let (negative, a) = self.add_up(&members);
                let b = self.constant(&size);
                parts.push((negative, self.push(|out| Instruction::Multiply { out, a, b })));
            }
        }
        let (negative, a) = self.add_up(&parts);
        if negative { self.push(|out| Instruction::Negate { out, a }) } else { a }
    }

    /// ± the signed sum of slots: the returned flag says whether the sum was negated.
    fn add_up(&mut self, parts: &[(bool, u32)]) -> (bool, u32) {
        let all_negative = parts.iter().all(|p| p.0);
        let first = if all_negative { 0 } else { parts.iter().position(|p| !p.0).unwrap_or(0) };
        let mut sum = parts[first].1;
        for (at, &(negative, b)) in parts.iter().enumerate() {
            if at != first {
                let a = sum;
                sum = if negative == all_negative {
                    self.push(|out| Instruction::Add { out, a, b })
                } else {
                    self.push(|out| Instruction::Subtract { out, a, b })
                };
            }
        }
        (all_negative, sum)
    }

    /// Places the constants behind the fixed slots and reuses the temporaries.
    fn finish(self) -> Code {
        let fixed = self.fixed as u32;
        let constants = self.constants.len() as u32;
        let name = |slot: u32| {
            if slot >= CONSTANT_BASE {
                fixed + (slot - CONSTANT_BASE)
            } else if slot >= fixed {
                slot + constants
            } else {
                slot
            }
        };
        let mut values: Vec<(u32, f64)> = self
            .constants
            .iter()
            .map(|(&bits, &slot)| (name(slot), f64::from_bits(bits)))
            .collect();
        values.sort_unstable_by_key(|v| v.0);
        let code = Code {
            instructions: self.code.instructions.iter().map(|i| i.renamed(name)).collect(),
            constants: values,
            outputs: self.code.outputs.iter().map(|&slot| name(slot)).collect(),
            slots: self.code.slots + constants as usize,
        };
        reuse_slots(code, (fixed + constants) as usize)
    }
}
