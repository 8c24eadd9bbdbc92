//! How far a template looks from the site of its indices.

use std::ops::RangeInclusive;

use super::density::Parts;
use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::parser::AXES;
use super::pattern::VariablePattern;
use super::tree::{Anchor, Kind, Node, Reference, Span};

/// The offsets from its indices at which a template names members of families, one range an axis. Of `x[i-1]*x[i+2]`
/// it is −1 to 2 along axis 0; axes that nothing names have 0 to 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Offsets([RangeInclusive<i64>; AXES]);

impl Offsets {
    /// The site itself.
    pub fn here() -> Self {
        Self(std::array::from_fn(|_| 0..=0))
    }

    /// The offsets of two things together.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|axis| {
            let (a, b) = (&self.0[axis], &other.0[axis]);
            *a.start().min(b.start())..=*a.end().max(b.end())
        }))
    }

    /// One range an axis.
    pub fn axes(&self) -> &[RangeInclusive<i64>; AXES] {
        &self.0
    }
}

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
    /// let formula = Formula::parse("sum(i, j, p[i,j]^2/2 + q[i-1,j]*q[i+2,j+1])").expect("a formula");
    /// let offsets = formula.offsets_of_sums().expect("a sum over sites");
    /// assert_eq!(offsets[0].axes()[..2], [-1..=2, 0..=1]);
    /// ```
    pub fn offsets_of_sums(&self) -> Result<Vec<Offsets>, SyntaxError> {
        let mut found = Vec::new();
        for (_, sum) in Parts::of(self.root())?.sums {
            found.extend(self.offsets_in(&sum.names(self.source()), sum.body)?);
        }
        Ok(found)
    }

    /// The offsets from free indices, one an axis, as of an entry of a bracket. Returns `None` where the formula names
    /// no member of a family.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::SumInATemplate`] for a sum, [`SyntaxErrorKind::SiteInATemplate`] for a member by its number.
    /// These couple sites however far they are from each other.
    pub fn offsets_from(&self, indices: &[&str]) -> Result<Option<Offsets>, SyntaxError> {
        self.offsets_in(indices, self.root())
    }

    /// Whether it names a member of a family at an offset from an index, as `x[i+1]` does and `x[i]`, `x[j]` and `x[3]`
    /// do not.
    ///
    /// ```
    /// use leafwise_expression::syntax::Formula;
    ///
    /// let pairs = Formula::parse("sum(i<j, 1/(x[i] - x[j])^2)").expect("a formula");
    /// let chain = Formula::parse("sum(i, (x[i+1] - x[i])^2)").expect("a formula");
    /// assert!(!pairs.names_neighbours() && chain.names_neighbours());
    /// ```
    pub fn names_neighbours(&self) -> bool {
        has_neighbours(self.root())
    }

    /// The offsets from `indices` of what `node` names, `None` where it names nothing.
    fn offsets_in(&self, indices: &[&str], node: &Node) -> Result<Option<Offsets>, SyntaxError> {
        match &node.kind {
            Kind::SumOver { .. } => {
                let kind = SyntaxErrorKind::SumInATemplate;
                return Err(SyntaxError::new(node.span, kind));
            }
            Kind::Reference(reference) => {
                return offsets(self.source(), reference, node.span, indices);
            }
            _ => {}
        }
        let mut all: Option<Offsets> = None;
        for child in node.kind.children() {
            let own = self.offsets_in(indices, child)?;
            all = match (all, own) {
                (Some(all), Some(own)) => Some(all.joined(&own)),
                (all, own) => all.or(own),
            };
        }
        Ok(all)
    }
}

/// Whether a member of a family stands below this node at an offset from an index.
fn has_neighbours(node: &Node) -> bool {
    let is_beside = |reference: &Reference| {
        let mut sites = reference.sites.iter();
        sites.any(|site| matches!(site.anchor, Anchor::Name(_)) && site.offset != 0)
    };
    matches!(&node.kind, Kind::Reference(reference) if is_beside(reference))
        || node.kind.children().iter().any(has_neighbours)
}

impl VariablePattern {
    /// The offsets from these indices, one an axis; `None` for a single variable.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::SiteInATemplate`] for a member of a family by its number, [`SyntaxErrorKind::SumInATemplate`]
    /// for one by other indices or in another order.
    pub fn offsets_from(&self, indices: &[&str]) -> Result<Option<Offsets>, SyntaxError> {
        let (text, reference) = self.reference();
        let place = reference.bracket().unwrap_or(reference.name);
        offsets(text, reference, place, indices)
    }
}

/// The offsets of a member of a family from indices, one an axis; `None` for a single variable.
fn offsets(
    text: &str,
    reference: &Reference,
    place: Span,
    indices: &[&str],
) -> Result<Option<Offsets>, SyntaxError> {
    if reference.sites.is_empty() {
        return Ok(None);
    }
    let has_index = !reference.index_names(text).is_empty();
    let is_repeated = (1..indices.len()).any(|axis| indices[..axis].contains(&indices[axis]));
    if has_index && (reference.sites.len() != indices.len() || is_repeated) {
        return Err(SyntaxError::new(place, SyntaxErrorKind::SumInATemplate));
    }
    let mut own = Offsets::here();
    for (axis, (site, range)) in reference.sites.iter().zip(&mut own.0).enumerate() {
        let kind = match site.anchor {
            Anchor::Name(name) if indices.get(axis) == Some(&name.of(text)) => {
                *range = site.offset..=site.offset;
                continue;
            }
            Anchor::Name(_) => SyntaxErrorKind::SumInATemplate,
            Anchor::Start | Anchor::End => SyntaxErrorKind::SiteInATemplate {
                name: reference.span().of(text).to_owned() + closing(text, reference),
            },
        };
        return Err(SyntaxError::new(place, kind));
    }
    Ok(Some(own))
}

/// The bracket behind the sites of a member of a family, where the text goes on so far.
fn closing(text: &str, reference: &Reference) -> &'static str {
    let end = reference.span().end;
    match text[end..].trim_start().starts_with(']') {
        true => "]",
        false => "",
    }
}
