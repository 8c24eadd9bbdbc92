//! Names that stand for formulas, written out.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::parser::{Parsed, node};
use super::tree::{Anchor, Kind, Node, Reference, Site, Span};
use super::vectors::PART_LIMIT;

impl Formula {
    /// The formula with others in the places of their names. Errors of what is written out are told where its name stands. Their
    /// sums get indices of their own, `i in M` for the `i` of M, whatever the indices around.
    ///
    /// # Errors
    /// [`SyntaxError`] of [`DEPTH_LIMIT`](super::DEPTH_LIMIT) and [`PART_LIMIT`].
    pub fn written_out(self, named: &[(&str, &Self)]) -> Result<Self, SyntaxError> {
        let names = self.references();
        let named: Vec<_> = named
            .iter()
            .filter(|(name, _)| names.contains(*name))
            .collect();
        if named.is_empty() {
            return Ok(self);
        }
        let mut text = self.source().to_owned();
        let named = named.into_iter().map(|(name, formula)| {
            let by = text.len();
            text.push_str(formula.source());
            let mut indices = Vec::new();
            own_indices(formula, formula.root(), &mut indices);
            let fresh = indices.into_iter().map(|index| {
                let start = text.len();
                // No name has a blank: nothing else is called so.
                text.push_str(&format!("{index} in {name}"));
                let end = text.len();
                (index, Span { start, end })
            });
            NamedFormula {
                name,
                fresh: fresh.collect(),
                formula,
                by,
            }
        });
        let mut writer = Writer {
            named: named.collect(),
            text: self.source(),
            bound: Vec::new(),
            parts: 0,
        };
        let root = writer.write(self.root()).map_err(|error| *error)?;
        Ok(self.rewritten(text, *root))
    }
}

/// A formula that a name stands for.
struct NamedFormula<'a> {
    name: &'a str,
    formula: &'a Formula,
    /// Where its text begins.
    by: usize,
    /// The indices of its sums, and what they are called where it is written out.
    fresh: Vec<(&'a str, Span)>,
}

/// The names of the indices of all sums.
fn own_indices<'a>(formula: &'a Formula, node: &Node, found: &mut Vec<&'a str>) {
    if let Some((index, _)) = node.as_sum() {
        let name = index.of(formula.source());
        if !found.contains(&name) {
            found.push(name);
        }
    }
    let children = node.kind.children().iter();
    children.for_each(|child| own_indices(formula, child, found));
}

struct Writer<'a> {
    named: Vec<NamedFormula<'a>>,
    text: &'a str,
    /// Indices of sums around.
    bound: Vec<&'a str>,
    parts: usize,
}

impl Writer<'_> {
    fn write(&mut self, of: &Node) -> Parsed {
        match &of.kind {
            Kind::Reference(reference) if reference.sites.is_empty() => {
                let name = reference.name.of(self.text);
                let found = self.named.iter().find(|own| own.name == name);
                let Some(definition) = found.filter(|_| !self.bound.contains(&name)) else {
                    return Ok(Box::new(of.clone()));
                };
                self.parts += definition.formula.root().parts();
                if self.parts > PART_LIMIT {
                    let kind = SyntaxErrorKind::TooManyParts { limit: PART_LIMIT };
                    return Err(Box::new(SyntaxError::new(of.span, kind)));
                }
                definition.moved(definition.formula.root(), of.span, &[])
            }
            // The name by which it is differentiated stays one.
            Kind::Derivative(pair) => {
                let of_it = *self.write(&pair[0])?;
                node(
                    of.span,
                    Kind::Derivative(Box::new([of_it, pair[1].clone()])),
                )
            }
            Kind::SumOver { index, .. } => {
                self.bound.push(index.of(self.text));
                let kind = of.kind.with_parts(&mut |part| self.write(part));
                self.bound.pop();
                node(of.span, kind?)
            }
            kind => {
                let kind = kind.with_parts(&mut |part| self.write(part))?;
                node(of.span, kind)
            }
        }
    }
}

impl NamedFormula<'_> {
    /// A part of the formula at another place, within the sums over the indices `bound`. It stands at `shown`, and its names so
    /// many bytes further on.
    fn moved(&self, of: &Node, shown: Span, bound: &[&str]) -> Parsed {
        let text = self.formula.source();
        let further = |span: Span| Span {
            start: span.start + self.by,
            end: span.end + self.by,
        };
        let index = |span: Span| {
            let mut fresh = self.fresh.iter();
            match fresh.find(|(name, _)| *name == span.of(text)) {
                Some((name, own)) if bound.contains(name) => *own,
                _ => further(span),
            }
        };
        let mut inside = bound.to_vec();
        inside.extend(of.as_sum().map(|(index, _)| index.of(text)));
        let mut kind = (of.kind).with_parts(&mut |part| self.moved(part, shown, &inside))?;
        match &mut kind {
            Kind::Number { literal: name, .. } | Kind::Lookup(name, _) => *name = further(*name),
            Kind::SumOver {
                index: own, above, ..
            } => {
                let mut fresh = self.fresh.iter();
                let found = fresh.find(|(name, _)| *name == own.of(text));
                *own = found.map_or_else(|| further(*own), |(_, fresh)| *fresh);
                *above = above.map(index);
            }
            Kind::Reference(reference) => {
                let site = |site: &Site| Site {
                    anchor: match site.anchor {
                        Anchor::Name(name) => Anchor::Name(index(name)),
                        anchor => anchor,
                    },
                    span: shown,
                    ..*site
                };
                *reference = Reference {
                    name: match reference.sites.is_empty() {
                        true => index(reference.name),
                        false => further(reference.name),
                    },
                    shown,
                    sites: reference.sites.iter().map(site).collect(),
                };
            }
            _ => {}
        }
        node(shown, kind)
    }
}
