//! Variables as keys of a scene: `x[i]`, `x[i+1]`, `y`.

use std::fmt;

use super::bound::{At, Bound};
use super::display::print_reference;
use super::error::{SyntaxError, SyntaxErrorKind};
use super::parser::Parser;
use super::place::Place;
use super::scope::Scope;
use super::tree::Reference;

/// A variable, or the member of a family at a fixed site or near an index.
///
/// ```
/// use leafwise_expression::syntax::{Boundary, Scope, VariablePattern};
///
/// let scope = Scope::new().with_family("x", 0, 4).with_boundary(Boundary::Open);
/// let (left, right) = VariablePattern::parse_pair("x[i],x[i+1]").expect("a pair");
/// assert_eq!(left.resolve(&scope, Some((&["i"], 3))), Ok(Some(3)));
/// assert_eq!(right.resolve(&scope, Some((&["i"], 3))), Ok(None));
/// ```
#[derive(Clone, Debug)]
pub struct VariablePattern {
    text: String,
    reference: Reference,
}

impl VariablePattern {
    /// Parses one variable, such as `y`, `x[i]`, `x[i-2]`, `x[0]` or `x[N-1]`.
    ///
    /// # Errors
    /// [`SyntaxError`] when the text is something else.
    pub fn parse_one(text: &str) -> Result<Self, SyntaxError> {
        let reference = Parser::new(text)
            .and_then(Parser::single)
            .map_err(|error| *error)?;
        Ok(Self {
            text: text.to_owned(),
            reference,
        })
    }

    /// Parses two variables with a comma between, such as `x[i],x[i+1]`. The spans of later
    /// errors refer to the text of the pair.
    ///
    /// # Errors
    /// [`SyntaxError`] when the text is something else.
    pub fn parse_pair(text: &str) -> Result<(Self, Self), SyntaxError> {
        let (first, second) = Parser::new(text)
            .and_then(Parser::pair)
            .map_err(|error| *error)?;
        let pattern = |reference: Reference| Self {
            text: text.to_owned(),
            reference,
        };
        Ok((pattern(first), pattern(second)))
    }

    /// The name of the variable or family.
    pub fn name(&self) -> &str {
        self.reference.name.of(&self.text)
    }

    /// The names of the free indices, one an axis: `i` in `x[i+1]`, `i` and `j` in `x[i,j]`, an empty name and `j` in
    /// `x[1,j]`, none in `x[3]`.
    pub fn index_names(&self) -> Vec<&str> {
        self.reference.index_names(&self.text)
    }

    /// How many sites stand between its brackets.
    pub fn axes(&self) -> usize {
        self.reference.sites.len()
    }

    /// Whether a site is at a distance from its index, as in `x[i+1]`.
    pub fn is_shifted(&self) -> bool {
        self.reference.sites.iter().any(|site| site.offset != 0)
    }

    /// The same text as another member.
    pub(super) fn at(self, reference: Reference) -> Self {
        Self { reference, ..self }
    }

    /// The variable or member as it is written.
    pub(super) fn reference(&self) -> (&str, &Reference) {
        (&self.text, &self.reference)
    }

    /// Index of the variable in the state; `None` outside an open boundary.
    ///
    /// # Errors
    /// [`SyntaxError`] when the name is unknown or is a parameter or definition. Also when the
    /// index or its absence does not fit the name, or a fixed site does not exist.
    pub fn resolve(
        &self,
        scope: &Scope,
        index: Option<At<'_>>,
    ) -> Result<Option<usize>, SyntaxError> {
        let mut place = |bound: Option<&Bound<'_>>| scope.place(&self.text, &self.reference, bound);
        match scope.at_site(index, 0, &mut place)? {
            Place::Variable(index) => Ok(Some(index)),
            Place::Outside { .. } => Ok(None),
            Place::Parameter(_) | Place::Definition(_) | Place::Entry { .. } => {
                let kind = SyntaxErrorKind::NotAVariable {
                    name: self.name().to_owned(),
                };
                Err(SyntaxError::new(self.reference.name, kind))
            }
        }
    }
}

impl fmt::Display for VariablePattern {
    /// The variable in a uniform spelling.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        print_reference(&self.text, &self.reference, formatter)
    }
}
