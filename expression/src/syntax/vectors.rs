//! Formulas with vectors, written out in their components.
//!
//! A scene gives names to vectors: `s` with the components `s.x`, `s.y` and `s.z`. In a formula vectors are added, scaled, summed and
//! divided by numbers. Numbers come of them by `dot(a, b)` and `norm(a)`, and another vector by `cross(a, b)`.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::parser::{Parsed, list, node};
use super::tree::{Kind, Node, Reference, Span};
use super::vocabulary::{CROSS, DOT, NORM, VECTOR_FUNCTIONS};
use crate::expression::Function;

/// The most parts of a formula that calls of functions of vectors, products and quotients are written out in, together.
pub const PART_LIMIT: usize = 1 << 18;

/// A vector that formulas may name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vector {
    /// Its name.
    pub name: String,
    /// The names of its components, variables or families.
    pub components: Vec<String>,
}

impl Formula {
    /// The formula in the components of these vectors; itself where it has none.
    ///
    /// # Errors
    /// [`SyntaxError`] where a vector stands for a number, or a number for a vector, where two have other numbers of components, and of
    /// [`DEPTH_LIMIT`](super::DEPTH_LIMIT) and [`PART_LIMIT`].
    pub fn in_components(self, vectors: &[Vector]) -> Result<Self, SyntaxError> {
        let mut expander = Expander {
            text: self.source().to_owned(),
            vectors,
            places: Vec::new(),
            parts: 0,
        };
        if !expander.has_vectors(self.root()) {
            return Ok(self);
        }
        let root = expander.number(self.root()).map_err(|error| *error)?;
        Ok(self.rewritten(expander.text, *root))
    }

    /// The formulas of the components of a vector; `None` for a number.
    ///
    /// # Errors
    /// Those of [`Formula::in_components`].
    pub fn components(&self, vectors: &[Vector]) -> Result<Option<Vec<Self>>, SyntaxError> {
        let mut expander = Expander {
            text: self.source().to_owned(),
            vectors,
            places: Vec::new(),
            parts: 0,
        };
        if !expander.is_vector(self.root()) {
            return Ok(None);
        }
        let parts = expander.components(self.root()).map_err(|error| *error)?;
        let text = expander.text;
        let formula = |root| self.clone().rewritten(text.clone(), root);
        Ok(Some(parts.into_iter().map(formula).collect()))
    }
}

struct Expander<'a> {
    /// The text, and behind it the names of components that occur.
    text: String,
    vectors: &'a [Vector],
    /// The components whose names stand there: the vector, the component, and the place.
    places: Vec<(usize, usize, Span)>,
    /// Parts that were made where others are repeated.
    parts: usize,
}

impl Expander<'_> {
    fn has_vectors(&self, node: &Node) -> bool {
        let own = match &node.kind {
            Kind::Reference(reference) => self.vector_of(reference).is_some(),
            Kind::Lookup(name, _) => VECTOR_FUNCTIONS.contains(&name.of(&self.text)),
            _ => false,
        };
        own || node
            .kind
            .children()
            .iter()
            .any(|child| self.has_vectors(child))
    }

    fn vector_of(&self, reference: &Reference) -> Option<usize> {
        let name = reference.name.of(&self.text);
        self.vectors.iter().position(|vector| vector.name == name)
    }

    /// Whether a node is a vector, by what stands first in it.
    fn is_vector(&self, of: &Node) -> bool {
        match &of.kind {
            Kind::Reference(reference) => self.vector_of(reference).is_some(),
            Kind::Lookup(name, _) => name.of(&self.text) == CROSS,
            Kind::Negate(part) | Kind::SumOver { body: part, .. } => self.is_vector(part),
            Kind::Sum(terms) => self.is_vector(&terms[0]),
            Kind::Quotient(pair) => self.is_vector(&pair[0]),
            Kind::Product(factors) => factors.iter().any(|factor| self.is_vector(factor)),
            _ => false,
        }
    }

    /// The number that a node is, written out in components.
    fn number(&mut self, of: &Node) -> Parsed {
        match &of.kind {
            Kind::Reference(reference) if self.vector_of(reference).is_some() => {
                Err(self.no_number(of))
            }
            Kind::Lookup(name, arguments) if VECTOR_FUNCTIONS.contains(&name.of(&self.text)) => {
                let called = name.of(&self.text).to_owned();
                let count = if called == NORM { 1 } else { 2 };
                if arguments.len() != count {
                    let kind = SyntaxErrorKind::VectorArguments {
                        name: called,
                        count,
                    };
                    return Err(Box::new(SyntaxError::new(of.span, kind)));
                }
                if called == CROSS {
                    return Err(self.no_number(of));
                }
                let first = self.components(&arguments[0])?;
                if called == DOT {
                    let second = self.components(&arguments[1])?;
                    check_alike(of.span, &first, &second)?;
                    self.count(of.span, first.iter().chain(&second))?;
                    return dot(of.span, first, second);
                }
                self.count(of.span, first.iter().chain(&first))?;
                let square = dot(of.span, first.clone(), first)?;
                node(of.span, Kind::Call(Function::Sqrt, square))
            }
            Kind::Product(factors) if factors.iter().filter(|f| self.is_vector(f)).count() > 1 => {
                let kind = SyntaxErrorKind::TwoVectors;
                Err(Box::new(SyntaxError::new(of.span, kind)))
            }
            _ => {
                let kind = of.kind.with_parts(&mut |part| self.number(part))?;
                node(of.span, kind)
            }
        }
    }

    /// The components of a node that must be a vector.
    fn components(&mut self, of: &Node) -> Result<Vec<Node>, Box<SyntaxError>> {
        if let Some(components) = self.vector(of)? {
            return Ok(components);
        }
        let text = of.span.of(&self.text).to_owned();
        let names = self.vectors.iter().map(|vector| vector.name.clone());
        let kind = SyntaxErrorKind::NoVector {
            text,
            vectors: names.collect(),
        };
        Err(Box::new(SyntaxError::new(of.span, kind)))
    }

    /// The components of a vector; `None` for a number.
    fn vector(&mut self, of: &Node) -> Result<Option<Vec<Node>>, Box<SyntaxError>> {
        let made = match &of.kind {
            Kind::Reference(reference) => match self.vector_of(reference) {
                Some(vector) => self.of_reference(of.span, reference, vector)?,
                None => return Ok(None),
            },
            Kind::Lookup(name, arguments) if name.of(&self.text) == CROSS => {
                let [a, b] = &arguments[..] else {
                    let (name, count) = (CROSS.to_owned(), 2);
                    let kind = SyntaxErrorKind::VectorArguments { name, count };
                    return Err(Box::new(SyntaxError::new(of.span, kind)));
                };
                let (a, b) = (self.components(a)?, self.components(b)?);
                check_alike(of.span, &a, &b)?;
                self.count(of.span, a.iter().chain(&b).chain(&a).chain(&b))?;
                cross(of.span, &a, &b)?
            }
            Kind::Negate(operand) => {
                let Some(parts) = self.vector(operand)? else {
                    return Ok(None);
                };
                each(parts, |part| node(of.span, Kind::Negate(Box::new(part))))?
            }
            Kind::Sum(terms) => {
                let Some(first) = self.vector(&terms[0])? else {
                    return Ok(None);
                };
                let mut sums: Vec<Vec<Node>> = first.into_iter().map(|part| vec![part]).collect();
                for term in &terms[1..] {
                    let parts = self.components(term)?;
                    if parts.len() != sums.len() {
                        return Err(unlike(of.span, sums.len(), parts.len()));
                    }
                    for (sum, part) in sums.iter_mut().zip(parts) {
                        sum.push(part);
                    }
                }
                let sums = sums
                    .into_iter()
                    .map(|sum| Ok(*node(of.span, Kind::Sum(sum))?));
                sums.collect::<Result<_, Box<SyntaxError>>>()?
            }
            Kind::Product(factors) => return self.scaled(of.span, factors),
            Kind::Quotient(pair) => {
                let Some(parts) = self.vector(&pair[0])? else {
                    return Ok(None);
                };
                let below = self.number(&pair[1])?;
                self.count(of.span, parts.iter().map(|_| &*below))?;
                each(parts, |part| {
                    node(of.span, Kind::Quotient(Box::new([part, (*below).clone()])))
                })?
            }
            Kind::SumOver { index, above, body } => {
                let Some(parts) = self.vector(body)? else {
                    return Ok(None);
                };
                let (index, above) = (*index, *above);
                each(parts, |part| {
                    let body = Box::new(part);
                    node(of.span, Kind::SumOver { index, above, body })
                })?
            }
            _ => return Ok(None),
        };
        Ok(Some(made))
    }

    /// A product with one vector among its factors.
    fn scaled(
        &mut self,
        span: Span,
        factors: &[Node],
    ) -> Result<Option<Vec<Node>>, Box<SyntaxError>> {
        if !factors.iter().any(|factor| self.is_vector(factor)) {
            return Ok(None);
        }
        let (mut numbers, mut found) = (Vec::new(), None);
        for (at, factor) in factors.iter().enumerate() {
            match self.is_vector(factor) {
                false => numbers.push(self.number(factor)?),
                true if found.is_some() => {
                    return Err(Box::new(SyntaxError::new(
                        span,
                        SyntaxErrorKind::TwoVectors,
                    )));
                }
                true => found = Some((at, self.components(factor)?)),
            }
        }
        let Some((at, parts)) = found else {
            return Ok(None);
        };
        for number in &numbers {
            self.count(span, parts.iter().map(|_| &**number))?;
        }
        let scaled = each(parts, |part| {
            let mut product: Vec<Node> = numbers.iter().map(|number| (**number).clone()).collect();
            product.insert(at, part);
            list(product, Kind::Product)
        });
        scaled.map(Some)
    }

    /// The components of a vector by its name.
    fn of_reference(
        &mut self,
        span: Span,
        reference: &Reference,
        vector: usize,
    ) -> Result<Vec<Node>, Box<SyntaxError>> {
        let count = self.vectors[vector].components.len();
        let component = |component: usize| {
            let name = self.place(vector, component);
            let own = Reference {
                name,
                ..reference.clone()
            };
            Ok(*node(span, Kind::Reference(own))?)
        };
        (0..count).map(component).collect()
    }

    /// Where the name of a component stands behind the text.
    fn place(&mut self, vector: usize, component: usize) -> Span {
        let is_meant = |place: &&(usize, usize, Span)| (place.0, place.1) == (vector, component);
        if let Some((.., span)) = self.places.iter().find(is_meant) {
            return *span;
        }
        let start = self.text.len();
        self.text
            .push_str(&self.vectors[vector].components[component]);
        let end = self.text.len();
        let span = Span { start, end };
        self.places.push((vector, component, span));
        span
    }

    /// Counts the parts of nodes before they are written at their places.
    fn count<'n>(
        &mut self,
        span: Span,
        nodes: impl Iterator<Item = &'n Node>,
    ) -> Result<(), Box<SyntaxError>> {
        self.parts = nodes.fold(self.parts, |parts, node| parts + node.parts());
        match self.parts <= PART_LIMIT {
            true => Ok(()),
            false => {
                let kind = SyntaxErrorKind::TooManyParts { limit: PART_LIMIT };
                Err(Box::new(SyntaxError::new(span, kind)))
            }
        }
    }

    fn no_number(&self, of: &Node) -> Box<SyntaxError> {
        let text = of.span.of(&self.text).to_owned();
        let components = match &of.kind {
            Kind::Reference(reference) => self.vector_of(reference),
            _ => None,
        };
        let components = components.map_or_else(Vec::new, |at| self.vectors[at].components.clone());
        let kind = SyntaxErrorKind::VectorAsNumber { text, components };
        Box::new(SyntaxError::new(of.span, kind))
    }
}

fn each(
    parts: Vec<Node>,
    mut make: impl FnMut(Node) -> Parsed,
) -> Result<Vec<Node>, Box<SyntaxError>> {
    parts.into_iter().map(|part| Ok(*make(part)?)).collect()
}

/// Σ a_i b_i.
fn dot(span: Span, a: Vec<Node>, b: Vec<Node>) -> Parsed {
    let products = a.into_iter().zip(b);
    let products = products.map(|(a, b)| Ok(*node(span, Kind::Product(vec![a, b]))?));
    let products: Vec<Node> = products.collect::<Result<_, Box<SyntaxError>>>()?;
    node(span, Kind::Sum(products))
}

/// a_j b_k − a_k b_j.
fn cross(span: Span, a: &[Node], b: &[Node]) -> Result<Vec<Node>, Box<SyntaxError>> {
    let (&[_, _, _], &[_, _, _]) = (&a, &b) else {
        let kind = SyntaxErrorKind::NoCrossProduct { found: a.len() };
        return Err(Box::new(SyntaxError::new(span, kind)));
    };
    let component = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let product = |p: &Node, q: &Node| node(span, Kind::Product(vec![p.clone(), q.clone()]));
        let taken = node(span, Kind::Negate(product(&a[k], &b[j])?))?;
        Ok(*node(
            span,
            Kind::Sum(vec![*product(&a[j], &b[k])?, *taken]),
        )?)
    };
    (0..3).map(component).collect()
}

fn check_alike(span: Span, a: &[Node], b: &[Node]) -> Result<(), Box<SyntaxError>> {
    match a.len() == b.len() {
        true => Ok(()),
        false => Err(unlike(span, a.len(), b.len())),
    }
}

fn unlike(span: Span, first: usize, second: usize) -> Box<SyntaxError> {
    let kind = SyntaxErrorKind::UnlikeVectors { first, second };
    Box::new(SyntaxError::new(span, kind))
}
