//! How far a template looks from the site of its index.

use std::ops::RangeInclusive;

use super::density::Parts;
use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::pattern::VariablePattern;
use super::tree::{Anchor, Kind, Node};

/// The offsets from its index at which a template names members of families: of `x[i-1]*x[i+2]` from −1 to 2.
pub type Offsets = RangeInclusive<i64>;

impl Formula {
    /// The offsets of each of the sums over sites in a formula that is a combination of these. It is taken apart as by
    /// [`Formula::density`].
    ///
    /// # Errors
    /// [`SyntaxErrorKind::NotASumOverSites`] for a formula that is no such combination, and those of
    /// [`Formula::offsets_from`].
    ///
    /// ```
    /// use leafwise_expression::syntax::Formula;
    ///
    /// let formula = Formula::parse("sum(i, p[i]^2/2) + sum(i, q[i-1]*q[i+2])").expect("a formula");
    /// assert_eq!(formula.offsets_of_sums().expect("sums over sites"), [0..=0, -1..=2]);
    /// ```
    pub fn offsets_of_sums(&self) -> Result<Vec<Offsets>, SyntaxError> {
        let mut found = Vec::new();
        for (_, index, body) in Parts::of(self.root())?.sums {
            found.extend(self.offsets_in(index.of(self.text()), body)?);
        }
        Ok(found)
    }

    /// The offsets from a free index, as of an entry of a bracket. Returns `None` where the formula names no member of
    /// a family.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::SumInATemplate`] for a sum, [`SyntaxErrorKind::SiteInATemplate`] for a member by its number.
    /// These couple sites however far they are from each other.
    pub fn offsets_from(&self, index: &str) -> Result<Option<Offsets>, SyntaxError> {
        self.offsets_in(index, self.root())
    }

    /// The offsets from `index` of what `node` names, `None` where it names nothing.
    fn offsets_in(&self, index: &str, node: &Node) -> Result<Option<Offsets>, SyntaxError> {
        let refused = |kind| Err(SyntaxError::new(node.span, kind));
        match &node.kind {
            Kind::SumOver { .. } => return refused(SyntaxErrorKind::SumInATemplate),
            Kind::Reference(reference) => {
                let Some(site) = reference.site else {
                    return Ok(None);
                };
                return match site.anchor {
                    Anchor::Name(name) if name.of(self.text()) == index => {
                        Ok(Some(site.offset..=site.offset))
                    }
                    Anchor::Name(_) => refused(SyntaxErrorKind::SumInATemplate),
                    Anchor::Start | Anchor::End => refused(SyntaxErrorKind::SiteInATemplate {
                        name: node.span.of(self.text()).to_owned(),
                    }),
                };
            }
            _ => {}
        }
        let mut all: Option<Offsets> = None;
        for child in node.kind.children() {
            let own = self.offsets_in(index, child)?;
            all = match (all, own) {
                (Some(all), Some(own)) => Some(joined(&all, &own)),
                (all, own) => all.or(own),
            };
        }
        Ok(all)
    }
}

impl VariablePattern {
    /// The offset from its index; `None` for a single variable.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::SiteInATemplate`] for a member of a family by its number.
    pub fn offsets(&self) -> Result<Option<Offsets>, SyntaxError> {
        match (self.offset(), self.site()) {
            (Some(offset), _) => Ok(Some(offset..=offset)),
            (None, None) => Ok(None),
            (None, Some(span)) => {
                let name = self.to_string();
                Err(SyntaxError::new(
                    span,
                    SyntaxErrorKind::SiteInATemplate { name },
                ))
            }
        }
    }
}

/// The offsets of two things together.
pub fn joined(a: &Offsets, b: &Offsets) -> Offsets {
    *a.start().min(b.start())..=*a.end().max(b.end())
}
