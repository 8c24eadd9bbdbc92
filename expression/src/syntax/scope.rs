//! The names a formula may use.

use rustc_hash::FxHashMap;

use super::error::{SyntaxError, SyntaxErrorKind};
use super::lexer::is_name;
use super::suggestion::{constant, nearest};
use super::tree::{Anchor, Reference, Span};
use super::vocabulary::{LENGTH, PI, is_reserved};
use crate::expression::Expression;

/// Meaning of a reference beyond the ends of a family.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Boundary {
    /// Sites count modulo the family's length.
    #[default]
    Periodic,
    /// There is nothing: a term that reaches outside is absent.
    Open,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Entry {
    Variable(usize),
    Family { offset: usize, length: usize },
    Parameter(usize),
    Definition(usize),
}

/// A formula with a name.
#[derive(Clone, Debug)]
pub(super) struct Definition {
    pub(super) formula: Expression,
    /// Whether it is a function of the parameters alone.
    pub(super) is_of_parameters: bool,
}

/// The names a formula may use, and what they stand for.
///
/// ```
/// use leafwise_expression::syntax::{Formula, Scope};
///
/// let scope = Scope::new().with_variables(&["x", "y"]).with_parameters(&["a"]);
/// let formula = Formula::parse("a*x^2 + y/3").expect("a formula");
/// let expression = formula.resolve(&scope, None).expect("known names").expect("no boundary");
/// assert_eq!(expression.evaluate(&[2.0, 6.0], &[0.5]), 4.0);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Scope {
    names: Vec<String>,
    entries: FxHashMap<String, Entry>,
    scalars: usize,
    parameters: usize,
    definitions: Vec<Definition>,
    longest: Option<usize>,
    shown_length: Option<usize>,
    boundary: Boundary,
}

impl Scope {
    /// A scope without names, with periodic boundaries.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds scalar variables; their indices in the state count on from 0 in the order given. Of
    /// two declarations of one name the later holds.
    pub fn with_variables<S: AsRef<str>>(mut self, names: &[S]) -> Self {
        for name in names {
            self.declare(name.as_ref(), Entry::Variable(self.scalars));
            self.scalars += 1;
        }
        self
    }

    /// Adds a scalar variable of this index in the state.
    pub fn with_variable(mut self, name: &str, index: usize) -> Self {
        self.declare(name, Entry::Variable(index));
        self
    }

    /// Adds the family `name[0]` … `name[length − 1]`, whose members have the indices `offset` …
    /// `offset + length − 1` in the state.
    pub fn with_family(mut self, name: &str, offset: usize, length: usize) -> Self {
        self.declare(name, Entry::Family { offset, length });
        self.longest = self.longest.max(Some(length));
        self
    }

    /// Adds parameters; their indices count on from 0 in the order given.
    pub fn with_parameters<S: AsRef<str>>(mut self, names: &[S]) -> Self {
        for name in names {
            self.declare(name.as_ref(), Entry::Parameter(self.parameters));
            self.parameters += 1;
        }
        self
    }

    /// Adds a name for a formula of the names that are there: whoever uses it shares it.
    pub fn with_definition(mut self, name: &str, formula: Expression) -> Self {
        self.declare(name, Entry::Definition(self.definitions.len()));
        self.definitions.push(Definition {
            is_of_parameters: formula.variables().is_empty(),
            formula: formula.shared(),
        });
        self
    }

    /// Sets what a reference beyond the ends of a family means; periodic unless told.
    pub fn with_boundary(mut self, boundary: Boundary) -> Self {
        self.boundary = boundary;
        self
    }

    /// Sets the value of `N` as a number; the length of the longest family unless told. Inside
    /// brackets `N` is always the length of the longest family of this scope, so that `x[N-1]`
    /// is its last member.
    pub fn with_length(mut self, length: usize) -> Self {
        self.shown_length = Some(length);
        self
    }

    /// Checks that `name` may be given to a variable, a family, a parameter, a definition or an index.
    ///
    /// # Errors
    /// `InvalidName` when it is not one name. Fails with `ReservedName` when it is `pi`, `N`, `sum` or the name of a
    /// function from `exp` to `atanh`. The span covers `name`.
    pub fn check_name(name: &str) -> Result<(), SyntaxError> {
        let span = Span {
            start: 0,
            end: name.len(),
        };
        let name = name.to_owned();
        if !is_name(&name) {
            return Err(SyntaxError::new(
                span,
                SyntaxErrorKind::InvalidName { name },
            ));
        }
        if is_reserved(&name) {
            return Err(SyntaxError::new(
                span,
                SyntaxErrorKind::ReservedName { name },
            ));
        }
        Ok(())
    }

    /// Whether a name is declared.
    pub fn has(&self, name: &str) -> bool {
        self.entries.contains_key(name)
    }

    fn declare(&mut self, name: &str, entry: Entry) {
        if self.entries.insert(name.to_owned(), entry).is_none() {
            self.names.push(name.to_owned());
        }
    }

    /// The error that what is called at the start of `span` is a name of this scope.
    pub(super) fn check_call(&self, text: &str, name: &str, span: Span) -> Result<(), SyntaxError> {
        if !self.has(name) {
            return Ok(());
        }
        let end = (span.start + name.len()).min(text.len());
        let kind = SyntaxErrorKind::NameAndFunction {
            name: name.to_owned(),
        };
        Err(SyntaxError::new(
            Span {
                start: span.start,
                end,
            },
            kind,
        ))
    }

    pub(super) fn definition(&self, index: usize) -> &Definition {
        &self.definitions[index]
    }

    /// `N` as a number.
    pub(super) fn shown_length(&self) -> Option<usize> {
        self.shown_length.or(self.longest)
    }

    /// The length of the longest family.
    pub(super) fn longest(&self) -> Option<usize> {
        self.longest
    }

    /// Entry of the scope under the name at `span` of `text`.
    pub(super) fn entry(&self, text: &str, span: Span) -> Result<Entry, SyntaxError> {
        let name = span.of(text);
        self.entries.get(name).copied().ok_or_else(|| {
            let known = self.names.iter().map(String::as_str).chain([PI, LENGTH]);
            let kind = SyntaxErrorKind::UnknownName {
                name: name.to_owned(),
            };
            SyntaxError::new(span, kind).suggesting(constant(name).or_else(|| nearest(name, known)))
        })
    }
}

/// An index with its value, and the ones around it.
#[derive(Clone, Copy)]
pub(super) struct Bound<'a> {
    pub(super) name: &'a str,
    pub(super) value: usize,
    /// 0 for the index that the caller gives, and one more for each sum.
    pub(super) level: usize,
    pub(super) outer: Option<&'a Bound<'a>>,
}

/// The binding of `name` in `bound`.
pub(super) fn find<'a>(bound: Option<&'a Bound<'a>>, name: &str) -> Option<&'a Bound<'a>> {
    std::iter::successors(bound, |inner| inner.outer).find(|index| index.name == name)
}

/// Target of a reference.
pub(super) enum Place {
    /// The state variable of this index.
    Variable(usize),
    /// The parameter of this index.
    Parameter(usize),
    /// The definition of this index.
    Definition(usize),
    /// Beyond an open boundary; the index of this level leads there.
    Outside { level: usize },
}

impl Scope {
    /// Target of `reference`, whose name is not an index.
    pub(super) fn place(
        &self,
        text: &str,
        reference: &Reference,
        bound: Option<&Bound<'_>>,
    ) -> Result<Place, SyntaxError> {
        let name = || reference.name.of(text).to_owned();
        let (entry, site) = (self.entry(text, reference.name)?, reference.site);
        let (offset, length, site) = match (entry, site) {
            (Entry::Variable(index), None) => return Ok(Place::Variable(index)),
            (Entry::Parameter(index), None) => return Ok(Place::Parameter(index)),
            (Entry::Definition(index), None) => return Ok(Place::Definition(index)),
            (Entry::Family { offset, length }, Some(site)) => (offset, length, site),
            (Entry::Variable(_) | Entry::Parameter(_) | Entry::Definition(_), Some(site)) => {
                let kind = SyntaxErrorKind::NotAFamily { name: name() };
                return Err(SyntaxError::new(reference.name.to(site.span), kind));
            }
            (Entry::Family { .. }, None) => {
                let kind = SyntaxErrorKind::IndexMissing { name: name() };
                return Err(SyntaxError::new(reference.name, kind));
            }
        };
        let (base, level) = match site.anchor {
            Anchor::Start => (0, None),
            Anchor::End => (self.longest.unwrap_or(length), None),
            Anchor::Name(span) => {
                let index = find(bound, span.of(text)).ok_or_else(|| unknown(text, span, bound))?;
                (index.value, Some(index.level))
            }
        };
        let position = (base as i64).saturating_add(site.offset);
        if let Ok(inside) = usize::try_from(position)
            && inside < length
        {
            return Ok(Place::Variable(offset + inside));
        }
        match (level, self.boundary) {
            (Some(_), Boundary::Periodic) if length > 0 => Ok(Place::Variable(
                offset + position.rem_euclid(length as i64) as usize,
            )),
            (Some(level), _) => Ok(Place::Outside { level }),
            (None, _) => {
                let kind = SyntaxErrorKind::IndexOutOfRange {
                    name: name(),
                    position,
                    length,
                };
                Err(SyntaxError::new(site.span, kind))
            }
        }
    }
}

/// The error that the index name at `span` is not bound.
fn unknown(text: &str, span: Span, bound: Option<&Bound<'_>>) -> SyntaxError {
    let name = span.of(text);
    let known = std::iter::successors(bound, |inner| inner.outer).map(|index| index.name);
    // Index names are single letters: any bound one is what must have been meant.
    let suggestion = nearest(name, known.clone()).or_else(|| known.clone().next());
    let kind = SyntaxErrorKind::UnknownIndex {
        name: name.to_owned(),
    };
    SyntaxError::new(span, kind).suggesting(suggestion)
}
