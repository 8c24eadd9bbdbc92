//! Names that stand for formulas, written out.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::parser::{Parsed, node};
use super::tree::{Anchor, Kind, Node, Reference, Site, Span};
use super::vectors::PART_LIMIT;

impl Formula {
    /// The formula with others in the places of their names. Errors of what is written out are told where its name stands.
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
            (*name, *formula, by)
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

struct Writer<'a> {
    /// Names, their formulas, and where the texts of these begin.
    named: Vec<(&'a str, &'a Formula, usize)>,
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
                let found = self.named.iter().find(|(own, ..)| *own == name);
                let Some((_, formula, by)) = found.filter(|_| !self.bound.contains(&name)) else {
                    return Ok(Box::new(of.clone()));
                };
                self.parts += formula.root().parts();
                if self.parts > PART_LIMIT {
                    let kind = SyntaxErrorKind::TooManyParts { limit: PART_LIMIT };
                    return Err(Box::new(SyntaxError::new(of.span, kind)));
                }
                moved(formula.root(), of.span, *by)
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

/// A formula's part at another place: it stands at `shown`, and its names so many bytes further on.
fn moved(of: &Node, shown: Span, by: usize) -> Parsed {
    let further = |span: Span| Span {
        start: span.start + by,
        end: span.end + by,
    };
    let mut kind = of.kind.with_parts(&mut |part| moved(part, shown, by))?;
    match &mut kind {
        Kind::Number { literal: name, .. } | Kind::Lookup(name, _) => *name = further(*name),
        Kind::SumOver { index, above, .. } => {
            (*index, *above) = (further(*index), above.map(further));
        }
        Kind::Reference(reference) => {
            let site = |site: &Site| Site {
                anchor: match site.anchor {
                    Anchor::Name(name) => Anchor::Name(further(name)),
                    anchor => anchor,
                },
                span: shown,
                ..*site
            };
            *reference = Reference {
                name: further(reference.name),
                shown,
                sites: reference.sites.iter().map(site).collect(),
            };
        }
        _ => {}
    }
    node(shown, kind)
}
