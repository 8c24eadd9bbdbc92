//! From a graph to a coefficient kernel and a step kernel.

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::code::{Code, Instruction, OperationCount};
use super::draft::Draft;
use super::execution::Compiled;
use crate::analytic::{AnalyticFunction, FunctionPair, Member};
use crate::expression::{Function, Side};
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
    /// Those of the two programs.
    operations: [OperationCount; 2],
    /// The slot of the step kernel's first output in a row of all outputs.
    pub(super) first_output: usize,
    /// Outputs that are computed in another slot than that of their row, with that slot.
    pub(super) strays: Vec<(u32, u32)>,
    /// The machine code of the coefficient kernel, and of the step kernel.
    pub(super) compiled_coefficients: Arc<Compiled>,
    pub(super) compiled: Arc<Compiled>,
    /// That of the step kernel along an array.
    pub(super) along: Option<Arc<Compiled>>,
}

impl Kernel {
    /// Compiles `outputs` of a graph over `parameters` parameters and `inputs` kernel inputs.
    pub fn compile(graph: &Graph, outputs: &[Term], parameters: usize, inputs: usize) -> Self {
        let coefficients = Coefficients::of(graph, outputs, parameters);
        Self::compile_with(graph, outputs, coefficients, inputs, None)
    }

    fn compile_with(
        graph: &Graph,
        outputs: &[Term],
        coefficients: Coefficients,
        inputs: usize,
        input_slots: Option<FxHashMap<u32, u32>>,
    ) -> Self {
        let Coefficients {
            parameters,
            nodes,
            code,
        } = coefficients;
        // Slots 0 .. inputs, then the coefficients.
        let uses = count_uses(graph, outputs);
        let mut step = Emitter::new(graph, &uses, Tier::Step, parameters, inputs + nodes.len());
        step.input_slots = input_slots;
        for (at, &node) in nodes.iter().enumerate() {
            step.places.insert(node, (inputs + at) as u32);
        }
        step.code.outputs = outputs.iter().map(|term| step.scaled(term)).collect();
        let step_code = step.code.finish();
        Self::new(parameters, [inputs, nodes.len()], code, step_code)
    }

    /// Both programs; the step kernel's slots begin with so many inputs and coefficients.
    pub(super) fn new(
        parameters: usize,
        [inputs, coefficients]: [usize; 2],
        coefficient_code: Code,
        step_code: Code,
    ) -> Self {
        let first_output = inputs + coefficients + step_code.constants.len();
        let rows = (first_output as u32..).zip(&step_code.outputs);
        let strays = rows
            .filter(|(row, slot)| row != *slot)
            .map(|(row, slot)| (row, *slot))
            .collect();
        Self {
            parameters,
            inputs,
            coefficients,
            operations: [coefficient_code.count(), step_code.count()],
            coefficient_code,
            step_code,
            first_output,
            strays,
            compiled_coefficients: Arc::default(),
            compiled: Arc::default(),
            along: None,
        }
    }

    /// Compiles `outputs` with only the graph inputs they read: input k of the kernel is the
    /// returned list's k-th graph input.
    pub fn compile_used(graph: &Graph, outputs: &[Term], parameters: usize) -> (Self, Vec<usize>) {
        let used = graph.inputs_read(outputs);
        (Self::compile_from(graph, outputs, parameters, &used), used)
    }

    /// Compiles `outputs` that read no graph inputs but those of `inputs`: input k of the kernel is the list's k-th.
    pub fn compile_from(
        graph: &Graph,
        outputs: &[Term],
        parameters: usize,
        inputs: &[usize],
    ) -> Self {
        let coefficients = Coefficients::of(graph, outputs, parameters);
        let slots = input_slots(inputs);
        Self::compile_with(graph, outputs, coefficients, inputs.len(), Some(slots))
    }

    /// The same of `all` outputs and of `some` that need nothing else: both have the coefficients of the first.
    pub fn compile_both(
        graph: &Graph,
        [all, some]: [&[Term]; 2],
        parameters: usize,
        inputs: &[usize],
    ) -> [Self; 2] {
        let coefficients = Coefficients::of(graph, all, parameters);
        [(all, coefficients.clone()), (some, coefficients)].map(|(outputs, coefficients)| {
            let slots = input_slots(inputs);
            Self::compile_with(graph, outputs, coefficients, inputs.len(), Some(slots))
        })
    }

    /// The number of outputs.
    pub fn outputs(&self) -> usize {
        self.step_code.outputs.len()
    }

    /// The number of parameters.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// The number of inputs that change with the state.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// The step kernel's program: slots 0 .. inputs, then the coefficients.
    pub fn step_code(&self) -> &Code {
        &self.step_code
    }

    /// The coefficient kernel's program: the parameters, then ε and h.
    pub fn coefficient_code(&self) -> &Code {
        &self.coefficient_code
    }

    /// Operations of one evaluation of the step kernel.
    pub fn step_operations(&self) -> OperationCount {
        self.operations[1]
    }

    /// Operations of the coefficient kernel, once for each choice of parameters and step sizes.
    pub fn coefficient_operations(&self) -> OperationCount {
        self.operations[0]
    }

    /// How many coefficients pass from the one kernel to the other.
    pub fn coefficients(&self) -> usize {
        self.coefficients
    }
}

/// The slot of each graph input.
fn input_slots(inputs: &[usize]) -> FxHashMap<u32, u32> {
    let slots = inputs.iter().enumerate();
    slots.map(|(k, &index)| (index as u32, k as u32)).collect()
}

/// Coefficient kernel: the nodes that depend on parameters, ε and h alone, and their code.
#[derive(Clone)]
struct Coefficients {
    parameters: usize,
    nodes: Vec<Node>,
    /// Slots 0 .. parameters, then ε and h.
    code: Code,
}

impl Coefficients {
    /// Those that outputs need.
    fn of(graph: &Graph, outputs: &[Term], parameters: usize) -> Self {
        let uses = count_uses(graph, outputs);
        let live: Vec<bool> = uses.iter().map(|count| *count > 0).collect();
        let nodes = imported_coefficients(graph, outputs, &live);
        let mut own = Emitter::new(graph, &uses, Tier::Coefficient, parameters, parameters + 2);
        for &node in &nodes {
            let slot = own.place(node);
            own.code.outputs.push(slot);
        }
        Self {
            parameters,
            nodes,
            code: own.code.by_kind().finish(),
        }
    }
}

/// How often each node is read, by live nodes and by outputs; 0 for dead ones.
fn count_uses(graph: &Graph, outputs: &[Term]) -> Vec<u32> {
    let mut uses = vec![0; graph.len()];
    for term in outputs.iter().filter(|term| !term.scale.is_zero()) {
        uses[term.node.index()] += 1;
    }
    for index in (0..graph.len()).rev() {
        if uses[index] > 0 {
            for operand in graph.operands(Node(index as u32)) {
                uses[operand.index()] += 1;
            }
        }
    }
    uses
}

/// The coefficients that state-dependent operations or outputs read, by number.
fn imported_coefficients(graph: &Graph, outputs: &[Term], live: &[bool]) -> Vec<Node> {
    let is_coefficient = |node: Node| graph.tier(node) == Tier::Coefficient;
    let mut imported: Vec<Node> = (0..graph.len() as u32)
        .map(Node)
        .filter(|n| live[n.index()] && graph.tier(*n) == Tier::Step)
        .flat_map(|n| graph.operands(n))
        .chain(
            outputs
                .iter()
                .filter(|t| !t.scale.is_zero())
                .map(|t| t.node),
        )
        .filter(|n| is_coefficient(*n))
        .collect();
    imported.sort_unstable();
    imported.dedup();
    imported
}

/// The multiplications by constants that a sum takes: one for each size of factor but 1.
fn multiplications(terms: &[(Rational, Node)]) -> usize {
    let mut sizes: Vec<Rational> = terms
        .iter()
        .filter(|t| t.1 != Graph::ONE)
        .map(|t| t.0.abs())
        .collect();
    sizes.sort();
    sizes.dedup();
    sizes.iter().filter(|size| !size.is_one()).count()
}

/// The pair of functions that the operation is a member of.
fn pair_of(operation: &Operation) -> Option<(&'static FunctionPair, Member)> {
    match operation {
        Operation::Function(function, _) => function.pair(),
        Operation::Analytic(function, 0, _) => function.pair(),
        _ => None,
    }
}

/// Emits code for what is asked for, operands first.
struct Emitter<'a> {
    graph: &'a Graph,
    uses: &'a [u32],
    tier: Tier,
    parameters: usize,
    code: Draft,
    places: FxHashMap<Node, u32>,
    scaled: FxHashMap<(Node, u64), u32>,
    /// Numbers that keep others on a side of a slot's 0.
    seams: FxHashMap<(Side, u32), [u32; 3]>,
    /// The slot of each graph input, where that is not its number.
    input_slots: Option<FxHashMap<u32, u32>>,
}

impl<'a> Emitter<'a> {
    fn new(graph: &'a Graph, uses: &'a [u32], tier: Tier, parameters: usize, fixed: usize) -> Self {
        Self {
            graph,
            uses,
            tier,
            parameters,
            code: Draft::new(fixed),
            places: FxHashMap::default(),
            scaled: FxHashMap::default(),
            seams: FxHashMap::default(),
            input_slots: None,
        }
    }

    fn constant(&mut self, value: &Rational) -> u32 {
        self.code.number(value.to_f64())
    }

    fn push(&mut self, instruction: impl FnOnce(u32) -> Instruction) -> u32 {
        self.code.push(instruction)
    }

    /// The slot of a node, emitting it and its operands where it has none yet. Operands have
    /// smaller numbers; they are emitted in order so that deep graphs need no deep stack.
    fn place(&mut self, node: Node) -> u32 {
        if node == Graph::ONE {
            return self.code.number(1.0);
        }
        if let Some(&known) = self.places.get(&node) {
            return known;
        }
        let mut wanted = vec![node];
        let mut seen: FxHashSet<Node> = FxHashSet::from_iter([node, Graph::ONE]);
        let mut pending = vec![node];
        while let Some(next) = pending.pop() {
            for operand in self.graph.operands(next) {
                if !self.places.contains_key(&operand) && seen.insert(operand) {
                    wanted.push(operand);
                    pending.push(operand);
                }
            }
        }
        wanted.sort_unstable();
        for &part in &wanted {
            // A sum that one other sum reads may be spelled out there.
            if part == node || !self.is_inlined(part) {
                self.emit(part);
            }
        }
        self.places[&node]
    }

    /// Whether the node is a sum with a single reader of its own tier, which takes it apart.
    fn is_inlined(&self, node: Node) -> bool {
        self.uses[node.index()] == 1
            && self.graph.tier(node) == self.tier
            && matches!(self.graph.operation(node), Operation::Sum(_))
    }

    /// The slot that holds a whole term.
    fn scaled(&mut self, term: &Term) -> u32 {
        if term.scale.is_zero() || term.node == Graph::ONE {
            return self.constant(&term.scale);
        }
        let key = (term.node, term.scale.to_f64().to_bits());
        if let Some(&known) = self.scaled.get(&key) {
            return known;
        }
        let slot = if term.scale.is_one() {
            self.place(term.node)
        } else if self.is_inlined(term.node) {
            self.emit_sum(&[(term.scale.clone(), term.node)])
        } else {
            let a = self.place(term.node);
            if (-&term.scale).is_one() {
                self.push(|out| Instruction::Negate { out, a })
            } else {
                let b = self.constant(&term.scale);
                self.push(|out| Instruction::Multiply { out, a, b })
            }
        };
        self.scaled.insert(key, slot);
        slot
    }

    fn emit(&mut self, node: Node) {
        if self.places.contains_key(&node) {
            return;
        }
        if let Some(first) = self.beside(node, Member::Second) {
            return self.emit(first);
        }
        let parameters = self.parameters as u32;
        let slot = match self.graph.operation(node).clone() {
            Operation::One => return,
            Operation::Pi => self.code.number(std::f64::consts::PI),
            Operation::Parameter(index) => index,
            Operation::Input(index) => match &self.input_slots {
                None => index,
                Some(slots) => slots[&index],
            },
            Operation::StepSize(StepSize::Epsilon) => parameters,
            Operation::StepSize(StepSize::H) => parameters + 1,
            Operation::Sum(terms) => self.emit_sum(&terms),
            Operation::Scale(scale, node) => self.scaled(&Term { scale, node }),
            Operation::Product(a, b) => {
                let (a, b) = (self.place(a), self.place(b));
                self.push(|out| Instruction::Multiply { out, a, b })
            }
            Operation::Reciprocal(b) => {
                let (a, b) = (self.code.number(1.0), self.place(b));
                self.push(|out| Instruction::Divide { out, a, b })
            }
            Operation::Function(function, a) => self.emit_function(function, a),
            Operation::Kept(side, c, v) => {
                let (c, v) = (self.place(c), self.place(v));
                self.emit_kept(side, c, v)
            }
            Operation::Analytic(function, order, a) => {
                let a = self.place(a);
                self.push(|out| Instruction::ApplyAnalytic {
                    function,
                    order,
                    out,
                    a,
                })
            }
            Operation::Power(a, b) => {
                let (a, b) = (self.place(a), self.place(b));
                self.push(|out| Instruction::Power { out, a, b })
            }
        };
        self.places.insert(node, slot);
        if let Some(second) = self.beside(node, Member::First) {
            self.emit(second);
        }
    }

    fn emit_function(&mut self, function: Function, a: Node) -> u32 {
        let a = self.place(a);
        match function {
            Function::Abs => self.push(|out| Instruction::Magnitude { out, a }),
            // Where a > 0, less where −a > 0.
            Function::Sign => {
                let one = self.code.number(1.0);
                let above = self.emit_kept(Side::Above, a, one);
                let opposite = self.push(|out| Instruction::Negate { out, a });
                let below = self.emit_kept(Side::Above, opposite, one);
                self.push(|out| Instruction::Subtract {
                    out,
                    a: above,
                    b: below,
                })
            }
            Function::Special(special, order) => self.push(|out| Instruction::ApplyAnalytic {
                function: special.analytic(),
                order: order.into(),
                out,
                a,
            }),
            _ => self.push(|out| Instruction::Apply { function, out, a }),
        }
    }

    /// v between −w and w, where w is ∞ on this side of c = 0 and 0 on the other. To it c − c is added, which is 0 unless c
    /// is no number. Of two of which one is no number the larger is the second: where v is not kept it may be none.
    fn emit_kept(&mut self, side: Side, c: u32, v: u32) -> u32 {
        let [width, opposite, nothing] = self.seam(side, c);
        let low = self.push(|out| Instruction::Larger {
            out,
            a: v,
            b: opposite,
        });
        let kept = self.push(|out| Instruction::Smaller {
            out,
            a: low,
            b: width,
        });
        self.push(|out| Instruction::Add {
            out,
            a: kept,
            b: nothing,
        })
    }

    /// The slots of w, −w and c − c.
    fn seam(&mut self, side: Side, c: u32) -> [u32; 3] {
        if let Some(&known) = self.seams.get(&(side, c)) {
            return known;
        }
        let seam = match side {
            // The larger of c and 0, over 0: ∞, or no number.
            Side::Above => {
                let b = self.code.number(0.0);
                let a = self.push(|out| Instruction::Larger { out, a: c, b });
                let a = self.push(|out| Instruction::Divide { out, a, b });
                let width = self.push(|out| Instruction::Larger { out, a, b });
                let a = width;
                let opposite = self.push(|out| Instruction::Negate { out, a });
                let (a, b) = (c, c);
                let nothing = self.push(|out| Instruction::Subtract { out, a, b });
                [width, opposite, nothing]
            }
            Side::Below => {
                let [b, _, nothing] = self.seam(Side::Above, c);
                let a = self.code.number(1.0);
                let width = self.push(|out| Instruction::Divide { out, a, b });
                let a = width;
                let opposite = self.push(|out| Instruction::Negate { out, a });
                [width, opposite, nothing]
            }
        };
        self.seams.insert((side, c), seam);
        seam
    }

    /// Node of the other function of a pair of which `node` is this member, where the other is still to be emitted.
    /// Two functions of one argument follow each other, so that they can be computed together.
    fn beside(&self, node: Node, member: Member) -> Option<Node> {
        let (pair, own) = pair_of(self.graph.operation(node))?;
        let argument = self.graph.operands(node)[0];
        if own != member {
            return None;
        }
        let other = match (self.graph.operation(node), member.other()) {
            (Operation::Function(..), Member::First) => {
                Operation::Function(Function::Sin, argument)
            }
            (Operation::Function(..), Member::Second) => {
                Operation::Function(Function::Cos, argument)
            }
            (_, other) => {
                let name = pair.names[other as usize];
                Operation::Analytic(AnalyticFunction::named(name), 0, argument)
            }
        };
        let found = self.graph.find(&other)?;
        let is_wanted = self.uses[found.index()] > 0 && !self.places.contains_key(&found);
        is_wanted.then_some(found)
    }

    /// Takes apart the sums that only this one reads, where that costs no multiplication. Every constant is then
    /// rounded once, as an exact product of the rational factors on its way.
    fn spell_out(&self, terms: &[(Rational, Node)]) -> Vec<(Rational, Node)> {
        let mut spelled = Vec::with_capacity(terms.len());
        for (scale, node) in terms {
            match self.graph.operation(*node) {
                Operation::Sum(inner) if self.is_inlined(*node) => {
                    let inner = self.spell_out(inner);
                    let scaled: Vec<_> = inner.iter().map(|(c, n)| (c * scale, *n)).collect();
                    let outside = usize::from(!scale.abs().is_one());
                    if multiplications(&scaled) <= multiplications(&inner) + outside {
                        spelled.extend(scaled);
                        continue;
                    }
                    spelled.push((scale.clone(), *node));
                }
                _ => spelled.push((scale.clone(), *node)),
            }
        }
        spelled
    }

    /// Σ cᵢ nᵢ: terms with the same |c| are added before they are multiplied.
    fn emit_sum(&mut self, terms: &[(Rational, Node)]) -> u32 {
        let terms = self.spell_out(terms);
        let mut groups: Vec<(Rational, Vec<(bool, Node)>)> = Vec::new();
        for (scale, node) in &terms {
            let (size, negative) = (scale.abs(), scale.is_negative());
            // The constant term is one number, not a product with 1.
            let grouped = groups
                .iter_mut()
                .find(|g| g.0 == size && *node != Graph::ONE && g.1[0].1 != Graph::ONE);
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
                let members: Vec<_> = members
                    .into_iter()
                    .map(|(sign, node)| (sign, self.place(node)))
                    .collect();
                let (negative, a) = self.add_up(&members);
                let b = self.constant(&size);
                parts.push((
                    negative,
                    self.push(|out| Instruction::Multiply { out, a, b }),
                ));
            }
        }
        let (negative, a) = self.add_up(&parts);
        if negative {
            self.push(|out| Instruction::Negate { out, a })
        } else {
            a
        }
    }

    /// ± the signed sum of slots: the returned flag says whether the sum was negated.
    fn add_up(&mut self, parts: &[(bool, u32)]) -> (bool, u32) {
        let all_negative = parts.iter().all(|p| p.0);
        let first = if all_negative {
            0
        } else {
            parts.iter().position(|p| !p.0).unwrap_or(0)
        };
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
}
