//! Nodes, each operation once, and the tiers that decide when each is computed.

use rustc_hash::FxHashMap;

use crate::analytic::AnalyticFunction;
use crate::arithmetic::AlgebraError;
use crate::expression::{Binary, Function, Side};
use crate::rational::Rational;
use crate::reach::{Reach, SumReach};
use crate::table::Lookup;

/// A node of a [`Graph`]; nodes are numbered so that operands come before their uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Node(pub(crate) u32);

impl Node {
    /// The node's number.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The two step sizes of a K-HJ map M_{ε,h}: kernel inputs that change less often than the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StepSize {
    /// The geometric parameter ε.
    Epsilon,
    /// The dynamic step h.
    H,
}

/// How often a node's value changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tier {
    /// Never: an exact number.
    Constant,
    /// With parameters or step sizes: computed by the coefficient kernel.
    Coefficient,
    /// With the state: computed by the step kernel.
    Step,
}

/// Operation that a node computes, with its operands.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// 1.
    One,
    /// π.
    Pi,
    /// The parameter with this index.
    Parameter(u32),
    /// ε or h.
    StepSize(StepSize),
    /// The kernel input with this index.
    Input(u32),
    /// Σ cᵢ nᵢ, at least two terms, sorted by node.
    Sum(Box<[(Rational, Node)]>),
    /// c·n for a node of the coefficient tier.
    Scale(Rational, Node),
    /// a·b, a ≤ b.
    Product(Node, Node),
    /// 1/a.
    Reciprocal(Node),
    /// f(a).
    Function(Function, Node),
    /// f⁽ᵏ⁾(a).
    Analytic(AnalyticFunction, u32, Node),
    /// a^b, b of the coefficient tier.
    Power(Node, Node),
    /// f(a, b).
    Binary(Binary, Node, Node),
    /// A table, or one of its derivatives, at a point.
    Lookup(Lookup, Box<[Node]>),
    /// v where c is of this side, 0 elsewhere, of c and v.
    Kept(Side, Node, Node),
}

/// A rational multiple of a node: the elements of straight-line code.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Term {
    /// The exact factor; 0 for the zero element.
    pub scale: Rational,
    /// The node it multiplies.
    pub node: Node,
}

impl Term {
    /// The node itself.
    pub fn of(node: Node) -> Self {
        Self {
            scale: Rational::one(),
            node,
        }
    }
}

/// Straight-line code under construction. Every operation is interned, so equal subexpressions are one node. Rational
/// factors are pulled out of products and sums, so that proportional subexpressions are one node too.
#[derive(Clone, Debug)]
pub struct Graph {
    operations: Vec<Operation>,
    tiers: Vec<Tier>,
    known: FxHashMap<Operation, Node>,
    pub(crate) derivatives: FxHashMap<(Node, u32), Term>,
    /// The inputs that each node depends on, of the first nodes: as far as derivatives were asked for.
    pub(super) reaches: Vec<Reach>,
    /// The same of the terms of each long sum that was differentiated.
    pub(super) sums: FxHashMap<Node, SumReach>,
    /// The most nodes before it refuses.
    pub(super) most: usize,
    pub(super) refusal: Option<AlgebraError>,
}

impl Default for Graph {
    fn default() -> Self {
        Self::new()
    }
}

impl Graph {
    /// The node 1.
    pub const ONE: Node = Node(0);

    /// A graph with the node 1 alone.
    pub fn new() -> Self {
        let mut known = FxHashMap::default();
        known.insert(Operation::One, Self::ONE);
        Self {
            operations: vec![Operation::One],
            tiers: vec![Tier::Constant],
            known,
            derivatives: FxHashMap::default(),
            reaches: Vec::new(),
            sums: FxHashMap::default(),
            most: usize::MAX,
            refusal: None,
        }
    }

    /// The same for at most `most` nodes: beyond, every node is 1 and
    /// [`refusal`](crate::Arithmetic::refusal) says so.
    pub fn limited(most: usize) -> Self {
        Self {
            most,
            ..Self::new()
        }
    }

    /// The same for as many nodes as a kernel is compiled of, 2²⁰: more take seconds to form and
    /// milliseconds to evaluate.
    pub fn compilable() -> Self {
        Self::limited(1 << 20)
    }

    /// `result`, unless the limit was reached on the way to it.
    ///
    /// # Errors
    /// [`AlgebraError::CodeTooLong`].
    pub fn unless_refused<T>(&self, result: T) -> Result<T, AlgebraError> {
        match &self.refusal {
            None => Ok(result),
            Some(reason) => Err(reason.clone()),
        }
    }

    /// The kernel input with this index.
    pub fn input(&mut self, index: usize) -> Term {
        let index = u32::try_from(index).expect("fewer than 2^32 inputs");
        self.unit(Operation::Input(index), Tier::Step)
    }

    /// ε or h.
    pub fn step_size(&mut self, which: StepSize) -> Term {
        self.unit(Operation::StepSize(which), Tier::Coefficient)
    }

    /// The operation of a node.
    pub fn operation(&self, node: Node) -> &Operation {
        &self.operations[node.index()]
    }

    /// The nodes that a node's operation reads.
    pub fn operands(&self, node: Node) -> Vec<Node> {
        match self.operation(node) {
            Operation::One
            | Operation::Pi
            | Operation::Parameter(_)
            | Operation::StepSize(_)
            | Operation::Input(_) => Vec::new(),
            Operation::Sum(terms) => terms.iter().map(|t| t.1).collect(),
            Operation::Lookup(_, point) => point.to_vec(),
            Operation::Scale(_, a)
            | Operation::Reciprocal(a)
            | Operation::Function(_, a)
            | Operation::Analytic(_, _, a) => vec![*a],
            Operation::Product(a, b)
            | Operation::Power(a, b)
            | Operation::Binary(_, a, b)
            | Operation::Kept(_, a, b) => vec![*a, *b],
        }
    }

    /// The node of an operation that was asked for before.
    pub(crate) fn find(&self, operation: &Operation) -> Option<Node> {
        self.known.get(operation).copied()
    }

    /// When the node changes.
    pub fn tier(&self, node: Node) -> Tier {
        self.tiers[node.index()]
    }

    /// The number of nodes.
    pub fn len(&self) -> usize {
        self.operations.len()
    }

    /// Whether only the node 1 exists.
    pub fn is_empty(&self) -> bool {
        self.operations.len() == 1
    }

    pub(super) fn intern(&mut self, operation: Operation, tier: Tier) -> Node {
        if let Some((known, &node)) = self.known.get_key_value(&operation) {
            debug_assert!(
                are_one(known, &operation),
                "two functions are called by the name of {operation:?}"
            );
            return node;
        }
        if self.operations.len() >= self.most {
            self.refusal = Some(AlgebraError::CodeTooLong { most: self.most });
            return Self::ONE;
        }
        let node = Node(u32::try_from(self.operations.len()).expect("fewer than 2^32 nodes"));
        self.known.insert(operation.clone(), node);
        self.operations.push(operation);
        self.tiers.push(tier);
        node
    }

    pub(super) fn unit(&mut self, operation: Operation, tier: Tier) -> Term {
        Term {
            scale: Rational::one(),
            node: self.intern(operation, tier),
        }
    }

    pub(super) fn number(value: Rational) -> Term {
        Term {
            scale: value,
            node: Self::ONE,
        }
    }
}

/// Whether analytic functions of one name are one function, by their values.
fn are_one(known: &Operation, asked: &Operation) -> bool {
    match (known, asked) {
        (Operation::Analytic(f, order, _), Operation::Analytic(g, _, _)) => {
            [-1.25, 0.3, 2.0].iter().all(|at| {
                let [a, b] = [f, g].map(|function| function.derivative(*order, *at));
                a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
            })
        }
        _ => true,
    }
}
