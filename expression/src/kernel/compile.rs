//! From a graph to a coefficient kernel and a step kernel.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::code::{Code, OperationCount};
use super::emit::Emitter;
use super::execution::Compiled;
use crate::graph::{Graph, Node, Term, Tier};

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
