//! A function of a lattice as a sum of one term a site.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::resolve::{Resolver, Stop};
use super::scope::Scope;
use super::tree::{Kind, Node, Span};
use crate::expression::Expression;
use crate::rational::Rational;

/// f = constant + Σ_i site(i), at one site.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    /// Part of f that does not depend on the state.
    pub constant: Expression,
    /// The terms of the sums at the site asked for; those that reach outside an open boundary are
    /// left out.
    pub site: Expression,
}

impl Formula {
    /// The site's share of a formula Σ_k c_k sum(i, body_k) + c. Such a formula is a combination of sums over sites,
    /// with coefficients that do not depend on the state.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::NotASumOverSites`] for any other form, and those of
    /// [`Formula::resolve`].
    pub fn density(&self, scope: &Scope, site: usize) -> Result<Density, SyntaxError> {
        let parts = Parts::of(self.root())?;
        let mut resolver = Resolver::new(self.source(), scope);
        let unboxed = |stop| match stop {
            Stop::Error(error) => *error,
            Stop::Outside { .. } => {
                SyntaxError::new(self.root().span, SyntaxErrorKind::NotASumOverSites)
            }
        };
        let mut constants = Vec::new();
        for (factors, node) in parts.constants {
            constants.push(resolver.scaled(&factors, node).map_err(unboxed)?);
        }
        let mut terms = Vec::new();
        for (factors, sum) in parts.sums {
            if let Some(body) = sum
                .at(self.source(), &mut resolver, site)
                .map_err(unboxed)?
            {
                let mut product = vec![body];
                for factor in &factors {
                    product.push(factor.resolve(&mut resolver).map_err(unboxed)?);
                }
                terms.push(Expression::Product(product));
            }
        }
        Ok(Density {
            constant: Expression::Sum(constants),
            site: Expression::Sum(terms),
        })
    }
}

impl Formula {
    /// The terms of the sums at one site that reach outside an open boundary and are left out, as they are written.
    ///
    /// # Errors
    /// As [`Formula::density`].
    pub fn left_out(&self, scope: &Scope, site: usize) -> Result<Vec<&str>, SyntaxError> {
        let parts = Parts::of(self.root())?;
        let mut resolver = Resolver::new(self.source(), scope);
        for (_, sum) in parts.sums {
            if let Err(Stop::Error(error)) = sum.at(self.source(), &mut resolver, site) {
                return Err(*error);
            }
        }
        let dropped = resolver.dropped.iter();
        Ok(dropped.map(|span| span.of(self.source())).collect())
    }
}

/// A sum over the sites of a lattice: `sum(i, …)` over those of a chain, `sum(i, j, …)` of a plane.
pub(super) struct SiteSum<'a> {
    /// Its indices in the order of the text.
    pub(super) indices: Vec<Span>,
    pub(super) body: &'a Node,
}

impl<'a> SiteSum<'a> {
    /// The sum of `indices` over `body`, with the indices of the sums that `body` is.
    fn of(index: Span, mut body: &'a Node) -> Self {
        let mut indices = vec![index];
        while let Kind::SumOver {
            index,
            above: None,
            body: inner,
        } = &body.kind
        {
            indices.push(*index);
            body = inner;
        }
        Self { indices, body }
    }

    /// Names of the indices in the order of the axes that the body counts by them.
    pub(super) fn names<'b>(&self, text: &'b str) -> Vec<&'b str> {
        let mut names: Vec<&str> = self.indices.iter().map(|span| span.of(text)).collect();
        names.sort_by_key(|name| {
            let mut axes = Vec::new();
            self.body.axes_of(text, name, &mut axes);
            axes.first().copied().unwrap_or(usize::MAX)
        });
        names
    }

    /// The summand at one site; `None` where it is outside.
    fn at(
        &self,
        text: &str,
        resolver: &mut Resolver<'_>,
        site: usize,
    ) -> Result<Option<Expression>, Stop> {
        let (names, scope) = (self.names(text), resolver.scope);
        let axes = scope.lengths().len();
        if names.len() != axes {
            let indices = names.len();
            let kind = match axes {
                0 | 1 => SyntaxErrorKind::SumInATemplate,
                _ => SyntaxErrorKind::SumOverAxes { axes, indices },
            };
            let [first, .., last] = &self.indices[..] else {
                let only = self.indices.first().copied().unwrap_or(self.body.span);
                return Err(SyntaxError::new(only, kind).into());
            };
            return Err(SyntaxError::new(first.to(*last), kind).into());
        }
        // The level of an outermost sum.
        let level = 1;
        scope.at_site(Some((&names, site)), level, &mut |bound| match bound {
            Some(bound) => resolver.inside(self.body, bound, level),
            None => Ok(None),
        })
    }
}

/// A factor in front of a sum.
#[derive(Clone, Copy)]
pub(super) enum Factor<'a> {
    Minus,
    Times(&'a Node),
    Over(&'a Node),
}

impl Factor<'_> {
    fn resolve(self, resolver: &mut Resolver<'_>) -> Result<Expression, Stop> {
        match self {
            Factor::Minus => Ok(Expression::Constant(-Rational::one())),
            Factor::Times(node) => resolver.expression(node, None),
            Factor::Over(node) => {
                let below = resolver.expression(node, None)?;
                let one = Expression::Constant(Rational::one());
                Ok(Expression::Quotient(Box::new(one), Box::new(below)))
            }
        }
    }
}

/// A combination of sums over sites.
#[derive(Default)]
pub(super) struct Parts<'a> {
    /// Each sum with its factors.
    pub(super) sums: Vec<(Vec<Factor<'a>>, SiteSum<'a>)>,
    constants: Vec<(Vec<Factor<'a>>, &'a Node)>,
    misfit: Option<Span>,
}

impl<'a> Parts<'a> {
    /// The sums that a formula is combined of.
    pub(super) fn of(root: &'a Node) -> Result<Self, SyntaxError> {
        let mut parts = Self::default();
        split(root, Vec::new(), &mut parts);
        match parts.misfit {
            Some(span) => Err(SyntaxError::new(span, SyntaxErrorKind::NotASumOverSites)),
            None => Ok(parts),
        }
    }
}

fn split<'a>(node: &'a Node, factors: Vec<Factor<'a>>, parts: &mut Parts<'a>) {
    let with = |factor| {
        let mut longer = factors.clone();
        longer.push(factor);
        longer
    };
    match &node.kind {
        _ if !node.has_sum() => {
            if node.depends_on_sites() {
                parts.misfit.get_or_insert(node.span);
            }
            parts.constants.push((factors, node));
        }
        Kind::SumOver { index, body, .. } => {
            parts.sums.push((factors, SiteSum::of(*index, body)));
        }
        Kind::Sum(terms) => terms
            .iter()
            .for_each(|term| split(term, factors.clone(), parts)),
        Kind::Negate(inner) => split(inner, with(Factor::Minus), parts),
        Kind::Quotient(pair) if pair[1].is_constant() => {
            split(&pair[0], with(Factor::Over(&pair[1])), parts);
        }
        Kind::Product(members) => {
            let sums = members.iter().filter(|member| member.has_sum()).count();
            let others = members.iter().filter(|member| !member.has_sum());
            if sums != 1 || others.clone().any(|other| !other.is_constant()) {
                parts.misfit.get_or_insert(node.span);
                return;
            }
            let mut longer = factors;
            longer.extend(others.map(Factor::Times));
            if let Some(sum) = members.iter().find(|member| member.has_sum()) {
                split(sum, longer, parts);
            }
        }
        _ => {
            parts.misfit.get_or_insert(node.span);
        }
    }
}

impl Resolver<'_> {
    fn scaled(&mut self, factors: &[Factor<'_>], node: &Node) -> Result<Expression, Stop> {
        let mut product = vec![self.expression(node, None)?];
        for factor in factors {
            product.push(factor.resolve(self)?);
        }
        Ok(Expression::Product(product))
    }
}
