//! Variables as keys of a scene: `x[i]`, `x[i+1]`, `y`.

use std::fmt;

use super::display::print_reference;
use super::error::{SyntaxError, SyntaxErrorKind};
use super::parser::Parser;
use super::scope::{Bound, Place, Scope};
use super::tree::{Anchor, Reference, Span};

/// A variable, or the member of a family at a fixed site or near an index.
///
/// ```
/// use leafwise_expression::syntax::{Boundary, Scope, VariablePattern};
///
/// let scope = Scope::new().with_family("x", 0, 4).with_boundary(Boundary::Open);
/// let (left, right) = VariablePattern::parse_pair("x[i],x[i+1]").expect("a pair");
/// assert_eq!(left.resolve(&scope, Some(("i", 3))), Ok(Some(3)));
/// assert_eq!(right.resolve(&scope, Some(("i", 3))), Ok(None));
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
        let pattern = |reference| Self {
            text: text.to_owned(),
            reference,
        };
        Ok((pattern(first), pattern(second)))
    }

    /// The name of the variable or family.
    pub fn name(&self) -> &str {
        self.reference.name.of(&self.text)
    }

    /// The name of the free index: `i` in `x[i+1]`, none in `x[3]`.
    pub fn index_name(&self) -> Option<&str> {
        self.reference.index().map(|span| span.of(&self.text))
    }

    /// The offset from the free index: 1 in `x[i+1]`. None without an index.
    pub fn offset(&self) -> Option<i64> {
        match self.reference.site?.anchor {
            Anchor::Name(_) => self.reference.site.map(|site| site.offset),
            Anchor::Start | Anchor::End => None,
        }
    }

    /// The place of the brackets' text, if any.
    pub(super) fn site(&self) -> Option<Span> {
        self.reference.site.map(|site| site.span)
    }

    /// Index of the variable in the state; `None` outside an open boundary.
    ///
    /// # Errors
    /// [`SyntaxError`] when the name is unknown or is a parameter or definition. Also when the
    /// index or its absence does not fit the name, or a fixed site does not exist.
    pub fn resolve(
        &self,
        scope: &Scope,
        index: Option<(&str, usize)>,
    ) -> Result<Option<usize>, SyntaxError> {
        let bound = index.map(|(name, value)| Bound {
            name,
            value,
            level: 0,
            outer: None,
        });
        match scope.place(&self.text, &self.reference, bound.as_ref())? {
            Place::Variable(index) => Ok(Some(index)),
            Place::Outside { .. } => Ok(None),
            Place::Parameter(_) | Place::Definition(_) => {
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
