//! A function of a lattice as a function of sums over sites and over pairs of sites.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::resolve::{Resolver, Stop, inner_index};
use super::scope::Scope;
use super::sums::outermost;
use super::tree::{Anchor, Kind, Node, Reference, Span};
use crate::expression::Expression;
use crate::operators::{negated, quotient};

/// f = F(S_1, S_2, …) with S_k = Σ_i site_k(i) + Σ_{i<j} pair_k(i, j).
#[derive(Clone, Debug, PartialEq)]
pub struct PairSums {
    /// F, in which S_k is the variable `first` + k.
    pub outer: Expression,
    /// The variable that S_1 is.
    pub first: usize,
    /// The sums in the order of the text.
    pub sums: Vec<PairSum>,
}

/// Σ_i site(i) + Σ_{i<j} pair(i, j).
#[derive(Clone, Debug, PartialEq)]
pub struct PairSum {
    /// The term of a site, in the variables of site 0.
    pub site: Expression,
    /// The term of a pair, in the variables of site 0 in the place of i, and of site 1 in the place of j. Entries of the
    /// scope's matrices are the variables from `first` on, of each J_ii, J_ij, J_ji and J_jj; those of a site's term J_ii.
    pub pair: Expression,
}

impl Formula {
    /// Sums over sites and over pairs of a formula on a chain, and the function that it is of them. The code of one pair
    /// then serves all.
    ///
    /// A sum over all i and j has the pair f(i, j) + f(j, i), and f(i, i) at a site. The sums are the variables from
    /// `first` on.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::NotSumsOfPairs`] for sites at distances from an index or by their numbers, sums over three
    /// indices, and functions of an inner sum. Those of [`Formula::resolve`].
    ///
    /// ```
    /// use leafwise_expression::syntax::{Formula, Scope};
    ///
    /// let scope = Scope::new().with_family("q", 0, 100);
    /// let formula = Formula::parse("sum(i<j, (q[i] - q[j])^2)/N").expect("a formula");
    /// let sums = formula.pair_sums(&scope, 100).expect("a sum over pairs");
    /// assert_eq!(sums.sums[0].pair.evaluate(&[5.0, 2.0], &[]), 9.0);
    /// ```
    pub fn pair_sums(&self, scope: &Scope, first: usize) -> Result<PairSums, SyntaxError> {
        let text = self.source();
        let misfit = || SyntaxError::new(self.root().span, SyntaxErrorKind::NotSumsOfPairs);
        let stopped = |stop| match stop {
            Stop::Error(error) => *error,
            Stop::Outside { .. } => misfit(),
        };
        if scope.lengths().len() != 1 {
            return Err(misfit());
        }
        let mut sums = Vec::new();
        outermost(self.root(), &mut sums);
        let sums = sums.into_iter().filter_map(Node::as_sum);
        let sums: Vec<(Span, &Node)> = sums.collect();
        check_outside(self.root())?;
        let mut resolver = Resolver::new(text, scope);
        resolver.sums = Some((first, sums.iter().map(|(_, body)| *body).collect()));
        let outer = resolver.expression(self.root(), None).map_err(stopped)?;
        let sums = sums.into_iter().map(|(index, body)| {
            let mut resolver = Resolver::new(text, scope);
            resolver.entries_from = Some(first);
            let mut terms = SummandTerms {
                text,
                resolver,
                site: Vec::new(),
                pair: Vec::new(),
            };
            terms.split(body, index, &[])?;
            Ok(PairSum {
                site: Expression::Sum(terms.site),
                pair: Expression::Sum(terms.pair),
            })
        });
        let sums = sums.collect::<Result<_, Stop>>().map_err(stopped)?;
        Ok(PairSums { outer, first, sums })
    }
}

/// Refuses sites outside of sums: they are single ones.
fn check_outside(node: &Node) -> Result<(), SyntaxError> {
    match &node.kind {
        Kind::SumOver { .. } => Ok(()),
        Kind::Reference(reference) if !reference.sites.is_empty() => Err(misfit(node)),
        // A condition is resolved once for each side, a derivative goes into the sum.
        Kind::If(_) | Kind::Derivative(_) if node.has_sum() => Err(misfit(node)),
        _ => node.kind.children().iter().try_for_each(check_outside),
    }
}

fn misfit(node: &Node) -> SyntaxError {
    SyntaxError::new(node.span, SyntaxErrorKind::NotSumsOfPairs)
}

/// A factor of a term, or what divides it.
#[derive(Clone, Copy)]
enum Beside<'a> {
    Minus,
    Times(&'a Node),
    Over(&'a Node),
}

/// The terms of a sum over i.
struct SummandTerms<'a> {
    text: &'a str,
    resolver: Resolver<'a>,
    site: Vec<Expression>,
    pair: Vec<Expression>,
}

impl<'a> SummandTerms<'a> {
    /// Takes a summand apart: terms with an inner sum are of pairs, others of sites.
    fn split(&mut self, node: &'a Node, i: Span, beside: &[Beside<'a>]) -> Result<(), Stop> {
        let with = |factor| [beside, &[factor]].concat();
        match &node.kind {
            _ if !node.has_sum() => {
                let term = self.term(node, [i, i], [0, 0], beside)?;
                self.site.push(term);
                Ok(())
            }
            Kind::Sum(terms) => {
                let mut terms = terms.iter();
                terms.try_for_each(|term| self.split(term, i, beside))
            }
            Kind::Negate(inner) => self.split(inner, i, &with(Beside::Minus)),
            Kind::Quotient(pair) if !pair[1].has_sum() => {
                self.split(&pair[0], i, &with(Beside::Over(&pair[1])))
            }
            Kind::Product(members) => {
                let mut longer = beside.to_vec();
                let others = members.iter().filter(|member| !member.has_sum());
                longer.extend(others.map(Beside::Times));
                let mut sums = members.iter().filter(|member| member.has_sum());
                match (sums.next(), sums.next()) {
                    (Some(sum), None) => self.split(sum, i, &longer),
                    _ => Err(misfit(node).into()),
                }
            }
            Kind::SumOver { index, above, body } if !body.has_sum() => {
                let of_pair = self.term(body, [i, *index], [0, 1], beside)?;
                self.pair.push(of_pair);
                if above.is_none() {
                    let reversed = self.term(body, [i, *index], [1, 0], beside)?;
                    let itself = self.term(body, [i, *index], [0, 0], beside)?;
                    self.pair.push(reversed);
                    self.site.push(itself);
                }
                Ok(())
            }
            _ => Err(misfit(node).into()),
        }
    }

    /// A term with what stands beside it, its indices at these sites.
    fn term(
        &mut self,
        node: &'a Node,
        indices: [Span; 2],
        sites: [usize; 2],
        beside: &[Beside<'a>],
    ) -> Result<Expression, Stop> {
        let mut term = self.at(node, indices, sites)?;
        for factor in beside {
            term = match factor {
                Beside::Minus => negated(term),
                Beside::Times(node) => {
                    Expression::Product(vec![self.at(node, indices, sites)?, term])
                }
                Beside::Over(node) => quotient(term, self.at(node, indices, sites)?),
            };
        }
        Ok(term)
    }

    fn at(
        &mut self,
        node: &Node,
        [i, j]: [Span; 2],
        sites: [usize; 2],
    ) -> Result<Expression, Stop> {
        let names = [i, j].map(|span| span.of(self.text));
        if i != j && names[0] == names[1] {
            let name = names[0].to_owned();
            return Err(SyntaxError::new(j, SyntaxErrorKind::DuplicateIndex { name }).into());
        }
        check_sites(self.text, node, &names)?;
        let mut outer = inner_index(self.text, i, None)?;
        outer.value = sites[0];
        if names[0] == names[1] {
            return self.resolver.expression(node, Some(&outer));
        }
        let mut inner = inner_index(self.text, j, Some(&outer))?;
        inner.value = sites[1];
        self.resolver.expression(node, Some(&inner))
    }
}

/// Refuses members of families that are not at one of these indices.
fn check_sites(text: &str, node: &Node, names: &[&str]) -> Result<(), SyntaxError> {
    let is_at = |reference: &Reference| {
        let mut sites = reference.sites.iter();
        sites.all(|site| match site.anchor {
            Anchor::Name(name) => site.offset == 0 && names.contains(&name.of(text)),
            Anchor::Start | Anchor::End => false,
        })
    };
    match &node.kind {
        Kind::Reference(reference) if !is_at(reference) => Err(misfit(node)),
        _ => {
            let mut children = node.kind.children().iter();
            children.try_for_each(|child| check_sites(text, child, names))
        }
    }
}
