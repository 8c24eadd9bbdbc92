//! Code of a graph's operations, operands first.

use rustc_hash::{FxHashMap, FxHashSet};

use super::code::Instruction;
use super::draft::Draft;
use super::lookups::LookupSlots;
use crate::analytic::{AnalyticFunction, FunctionPair, Member};
use crate::expression::{Function, Side};
use crate::graph::{Graph, Node, Operation, StepSize, Term, Tier};
use crate::rational::Rational;

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
pub(super) struct Emitter<'a> {
    graph: &'a Graph,
    uses: &'a [u32],
    tier: Tier,
    parameters: usize,
    pub(super) code: Draft,
    pub(super) places: FxHashMap<Node, u32>,
    scaled: FxHashMap<(Node, u64), u32>,
    /// Slots with 0 where another is a number.
    nothings: FxHashMap<u32, u32>,
    lookups: LookupSlots,
    /// The slot of each graph input, where that is not its number.
    pub(super) input_slots: Option<FxHashMap<u32, u32>>,
}

impl<'a> Emitter<'a> {
    pub(super) fn new(
        graph: &'a Graph,
        uses: &'a [u32],
        tier: Tier,
        parameters: usize,
        fixed: usize,
    ) -> Self {
        Self {
            graph,
            uses,
            tier,
            parameters,
            code: Draft::new(fixed),
            places: FxHashMap::default(),
            scaled: FxHashMap::default(),
            nothings: FxHashMap::default(),
            lookups: LookupSlots::default(),
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
    pub(super) fn place(&mut self, node: Node) -> u32 {
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
    pub(super) fn scaled(&mut self, term: &Term) -> u32 {
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
            Operation::Binary(function, a, b) => {
                let (a, b) = (self.place(a), self.place(b));
                self.push(|out| Instruction::ApplyTwo {
                    function,
                    out,
                    a,
                    b,
                })
            }
            Operation::Lookup(lookup, point) => {
                let point: Vec<u32> = point.iter().map(|at| self.place(*at)).collect();
                self.lookups.emit(&mut self.code, lookup, &point)
            }
            Operation::Kept(side, c, v) => {
                let (c, v) = (self.place(c), self.place(v));
                self.emit_kept(side, c, v)
            }
            Operation::Analytic(function, 0, a) if function.is_held() => self.place(a),
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

    /// v where c is of this side, 0 on the other, no number where c is none. What is not kept is never read: it may be
    /// no number.
    fn emit_kept(&mut self, side: Side, c: u32, v: u32) -> u32 {
        let kept = self.push(|out| Instruction::Keep {
            side,
            out,
            a: c,
            b: v,
        });
        let nothing = self.nothing(c);
        self.push(|out| Instruction::Add {
            out,
            a: kept,
            b: nothing,
        })
    }

    /// The slot of 0 where c is a number, else of none: the smaller of 0 and |c|, which is the second where one is no number.
    fn nothing(&mut self, c: u32) -> u32 {
        if let Some(&known) = self.nothings.get(&c) {
            return known;
        }
        let size = self.push(|out| Instruction::Magnitude { out, a: c });
        let zero = self.code.number(0.0);
        let nothing = self.push(|out| Instruction::Smaller {
            out,
            a: zero,
            b: size,
        });
        self.nothings.insert(c, nothing);
        nothing
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
            } else if let [(negative, node)] = members[..] {
                parts.push((negative, self.multiple(node, &size)));
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

    /// The slot of a node times a number, which other sums may take with the other sign.
    fn multiple(&mut self, node: Node, size: &Rational) -> u32 {
        let key = (node, size.to_f64().to_bits());
        if let Some(&known) = self.scaled.get(&key) {
            return known;
        }
        let (a, b) = (self.place(node), self.constant(size));
        let slot = self.push(|out| Instruction::Multiply { out, a, b });
        self.scaled.insert(key, slot);
        slot
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
