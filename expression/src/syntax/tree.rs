//! The tree of a formula before its names are resolved.

use super::composite::{Composite, Relation};
use crate::expression::Function;
use crate::rational::Rational;

/// A byte range of the formula's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) start: usize,
    pub(super) end: usize,
}

impl Span {
    pub(super) fn to(self, last: Span) -> Span {
        Span {
            start: self.start,
            end: last.end,
        }
    }

    pub(super) fn of(self, text: &str) -> &str {
        &text[self.start..self.end]
    }
}

/// Origin from which an index is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    /// The first member: `x[3]`.
    Start,
    /// The length of the longest family: `x[N-1]`.
    End,
    /// The index whose name stands at this place: `x[i+1]`.
    Name(Span),
}

/// One of the sites between the brackets of `x[...]`: of `x[i+1,j]` the one along axis 0 or along axis 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Site {
    pub(super) anchor: Anchor,
    pub(super) offset: i64,
    pub(super) span: Span,
}

/// A variable by its name, with a site along each axis when it belongs to a family.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Reference {
    pub(super) name: Span,
    /// Where it is written: the name, or that of a vector it is a component of.
    pub(super) shown: Span,
    pub(super) sites: Vec<Site>,
}

impl Reference {
    /// The names of the indices in the brackets, one an axis, empty along an axis where a number stands; none where
    /// there is no index.
    pub(super) fn index_names<'a>(&self, text: &'a str) -> Vec<&'a str> {
        let names = self.sites.iter().map(|site| match site.anchor {
            Anchor::Name(span) => span.of(text),
            Anchor::Start | Anchor::End => "",
        });
        let names: Vec<&str> = names.collect();
        match names.iter().all(|name| name.is_empty()) {
            true => Vec::new(),
            false => names,
        }
    }

    /// The place of all that stands between the brackets, if any does.
    pub(super) fn bracket(&self) -> Option<Span> {
        Some(self.sites.first()?.span.to(self.sites.last()?.span))
    }

    /// The place of name and sites.
    pub(super) fn span(&self) -> Span {
        self.bracket()
            .map_or(self.shown, |bracket| self.shown.to(bracket))
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) span: Span,
    /// The number of levels below this one.
    pub(super) height: usize,
    pub(super) kind: Kind,
}

impl Node {
    pub(super) fn has_sum(&self) -> bool {
        matches!(self.kind, Kind::SumOver { .. }) || self.kind.children().iter().any(Self::has_sum)
    }

    /// How many nodes it has, with itself.
    pub(super) fn parts(&self) -> usize {
        let below = self.kind.children().iter().map(|child| child.parts());
        1 + below.sum::<usize>()
    }

    /// The axes along which members of families are counted by `index`, in the order of the text.
    pub(super) fn axes_of(&self, text: &str, index: &str, axes: &mut Vec<usize>) {
        if let Kind::Reference(reference) = &self.kind {
            let sites = reference.sites.iter().enumerate();
            axes.extend(sites.filter_map(|(axis, site)| match site.anchor {
                Anchor::Name(span) if span.of(text) == index => Some(axis),
                _ => None,
            }));
        }
        for child in self.kind.children() {
            child.axes_of(text, index, axes);
        }
    }

    pub(super) fn depends_on_sites(&self) -> bool {
        matches!(&self.kind, Kind::Reference(reference) if !reference.sites.is_empty())
            || self.kind.children().iter().any(Self::depends_on_sites)
    }

    /// Whether the formula has the same value at every site.
    pub(super) fn is_constant(&self) -> bool {
        !self.has_sum() && !self.depends_on_sites()
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    Number {
        exact: Rational,
        rounded: f64,
        literal: Span,
    },
    Pi,
    Length,
    Reference(Reference),
    Call(Function, Box<Node>),
    /// A table of the scene by its name, or a function that there is none of.
    Lookup(Span, Vec<Node>),
    /// A function that is a formula of its arguments.
    Composite(Composite, Vec<Node>),
    /// A condition, the value where it holds, and that elsewhere.
    If(Box<[Node; 3]>),
    Compare(Relation, Box<[Node; 2]>),
    /// Conditions that all hold.
    And(Vec<Node>),
    /// Conditions of which one holds.
    Or(Vec<Node>),
    /// A condition that does not hold.
    Not(Box<Node>),
    /// A formula, and the variable or parameter by which it is differentiated.
    Derivative(Box<[Node; 2]>),
    SumOver {
        index: Span,
        /// An index around it that it is greater than: the inner sum of `sum(i<j, …)`.
        above: Option<Span>,
        body: Box<Node>,
    },
    Sum(Vec<Node>),
    Product(Vec<Node>),
    Negate(Box<Node>),
    Quotient(Box<[Node; 2]>),
    Power(Box<[Node; 2]>),
}

impl Kind {
    /// The same with other parts.
    pub(super) fn with_parts<E>(
        &self,
        one: &mut impl FnMut(&Node) -> Result<Box<Node>, E>,
    ) -> Result<Kind, E> {
        let mut list = |parts: &[Node]| -> Result<Vec<Node>, E> {
            parts.iter().map(|part| Ok(*one(part)?)).collect()
        };
        Ok(match self {
            Kind::Number { .. } | Kind::Pi | Kind::Length | Kind::Reference(_) => self.clone(),
            Kind::Sum(parts) => Kind::Sum(list(parts)?),
            Kind::Product(parts) => Kind::Product(list(parts)?),
            Kind::Composite(composite, parts) => Kind::Composite(*composite, list(parts)?),
            Kind::Lookup(name, parts) => Kind::Lookup(*name, list(parts)?),
            Kind::And(parts) => Kind::And(list(parts)?),
            Kind::Or(parts) => Kind::Or(list(parts)?),
            Kind::Call(function, part) => Kind::Call(*function, one(part)?),
            Kind::Negate(part) => Kind::Negate(one(part)?),
            Kind::Not(part) => Kind::Not(one(part)?),
            Kind::SumOver { index, above, body } => Kind::SumOver {
                index: *index,
                above: *above,
                body: one(body)?,
            },
            Kind::Quotient(pair) => Kind::Quotient(Box::new([*one(&pair[0])?, *one(&pair[1])?])),
            Kind::Power(pair) => Kind::Power(Box::new([*one(&pair[0])?, *one(&pair[1])?])),
            Kind::Compare(relation, pair) => {
                Kind::Compare(*relation, Box::new([*one(&pair[0])?, *one(&pair[1])?]))
            }
            Kind::Derivative(pair) => {
                Kind::Derivative(Box::new([*one(&pair[0])?, *one(&pair[1])?]))
            }
            Kind::If(parts) => {
                let [c, a, b] = &**parts;
                Kind::If(Box::new([*one(c)?, *one(a)?, *one(b)?]))
            }
        })
    }

    pub(super) fn children(&self) -> &[Node] {
        match self {
            Kind::Number { .. } | Kind::Pi | Kind::Length | Kind::Reference(_) => &[],
            Kind::Call(_, child)
            | Kind::Negate(child)
            | Kind::Not(child)
            | Kind::SumOver { body: child, .. } => std::slice::from_ref(child),
            Kind::Sum(children)
            | Kind::Product(children)
            | Kind::Composite(_, children)
            | Kind::Lookup(_, children)
            | Kind::And(children)
            | Kind::Or(children) => children,
            Kind::Quotient(pair)
            | Kind::Power(pair)
            | Kind::Compare(_, pair)
            | Kind::Derivative(pair) => pair.as_slice(),
            Kind::If(parts) => parts.as_slice(),
        }
    }
}
