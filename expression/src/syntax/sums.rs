//! A formula as a function of the sums in it.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::resolve::{Resolver, Stop};
use super::scope::Scope;
use super::tree::{Kind, Node, Span};
use crate::expression::Expression;

impl Formula {
    /// Sums S_1, S_2, … of a formula F(x, S_1, S_2, …) that stand in no other sum, in the order of the text.
    ///
    /// ```
    /// use leafwise_expression::syntax::Formula;
    ///
    /// let formula = Formula::parse("sum(i, z[i])^2/N - sum(i, z[i]*z[i+1])").expect("a formula");
    /// let sums = formula.outermost_sums();
    /// assert_eq!(sums.len(), 2);
    /// assert_eq!(sums[1].offsets_of_sums().expect("a sum over sites").len(), 1);
    /// ```
    pub fn outermost_sums(&self) -> Vec<Self> {
        let mut sums = Vec::new();
        outermost(self.root(), &mut sums);
        let alone = |sum: &Node| {
            self.clone()
                .rewritten(self.source().to_owned(), sum.clone())
        };
        sums.into_iter().map(alone).collect()
    }

    /// F of a formula F(x, S_1, S_2, …): its [outermost sums](Self::outermost_sums) are the variables from `first` on.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::NotASumOverSites`] for a derivative of a sum. Those of [`Formula::resolve`] outside of the sums.
    ///
    /// ```
    /// use leafwise_expression::syntax::{Formula, Scope};
    ///
    /// let scope = Scope::new().with_family("z", 0, 1000);
    /// let formula = Formula::parse("z[7]*sum(i, z[i])^2").expect("a formula");
    /// let outer = formula.outside_sums(&scope, 1000).expect("a function of a sum");
    /// assert_eq!(outer.variables().into_iter().collect::<Vec<_>>(), [7, 1000]);
    /// ```
    pub fn outside_sums(&self, scope: &Scope, first: usize) -> Result<Expression, SyntaxError> {
        let mut sums = Vec::new();
        outermost(self.root(), &mut sums);
        check_derivatives(self.root())?;
        let bodies = sums.into_iter().filter_map(Node::as_sum);
        let mut resolver = Resolver::new(self.source(), scope);
        resolver.sums = Some((first, bodies.map(|(_, body)| body).collect()));
        let outer = resolver.expression(self.root(), None);
        outer.map_err(|stop| match stop {
            Stop::Error(error) => *error,
            Stop::Outside { .. } => misfit(self.root()),
        })
    }
}

impl Node {
    /// The index and the body of a sum.
    pub(super) fn as_sum(&self) -> Option<(Span, &Node)> {
        match &self.kind {
            Kind::SumOver { index, body, .. } => Some((*index, body)),
            _ => None,
        }
    }
}

/// Collects sums that are in no other one, in the order of the text.
pub(super) fn outermost<'a>(node: &'a Node, sums: &mut Vec<&'a Node>) {
    match &node.kind {
        Kind::SumOver { .. } => sums.push(node),
        _ => {
            let children = node.kind.children();
            children.iter().for_each(|child| outermost(child, sums));
        }
    }
}

/// Refuses derivatives of sums: such a one goes into the sum.
fn check_derivatives(node: &Node) -> Result<(), SyntaxError> {
    match &node.kind {
        Kind::SumOver { .. } => Ok(()),
        Kind::Derivative(_) if node.has_sum() => Err(misfit(node)),
        _ => node.kind.children().iter().try_for_each(check_derivatives),
    }
}

fn misfit(node: &Node) -> SyntaxError {
    SyntaxError::new(node.span, SyntaxErrorKind::NotASumOverSites)
}
