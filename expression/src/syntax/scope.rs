//! The names a formula may use.

use rustc_hash::FxHashMap;

use super::bound::{At, Bound, bind};
use super::error::{SyntaxError, SyntaxErrorKind};
use super::lexer::is_name;
use super::matrices::Matrix;
use super::parser::AXES;
use super::suggestion::{constant, nearest};
use super::tree::{Node, Reference, Span};
use super::vocabulary::{LENGTH, PI, SUM, is_reserved};
use crate::expression::Expression;
use crate::table::TableFunction;

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
    /// Members along as many axes as have a length, the last axis fastest.
    Family {
        offset: usize,
        shape: Shape,
    },
    Parameter(usize),
    Definition(usize),
    Table(usize),
    Matrix(usize),
}

/// Lengths of a family along its axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    lengths: [usize; AXES],
    axes: usize,
}

impl Shape {
    /// The lengths, one an axis; of more than [`AXES`] the first.
    fn of(lengths: &[usize]) -> Self {
        let axes = lengths.len().min(AXES);
        let mut own = [1; AXES];
        own[..axes].copy_from_slice(&lengths[..axes]);
        Self { lengths: own, axes }
    }

    /// One length an axis.
    pub(super) fn lengths(&self) -> &[usize] {
        &self.lengths[..self.axes]
    }
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
    pub(super) tables: Vec<TableFunction>,
    pub(super) matrices: Vec<Matrix>,
    /// The lengths of the longest family, one an axis.
    longest: Option<Shape>,
    shown_length: Option<usize>,
    pub(super) boundaries: [Boundary; AXES],
    /// The lengths of the rings that families stand for along each axis; 0 for their own.
    pub(super) rings: [usize; AXES],
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
    pub fn with_family(self, name: &str, offset: usize, length: usize) -> Self {
        self.with_lattice(name, offset, &[length])
    }

    /// Adds the family `name[0,0]`, `name[0,1]`, … of 1 to [`AXES`] axes of these lengths. The member `name[i,j]` has
    /// the index `offset + i·lengths[1] + j` in the state.
    pub fn with_lattice(mut self, name: &str, offset: usize, lengths: &[usize]) -> Self {
        let shape = Shape::of(lengths);
        self.declare(name, Entry::Family { offset, shape });
        let longest = self.longest.get_or_insert(shape);
        longest.axes = longest.axes.max(shape.axes);
        for (longest, own) in longest.lengths.iter_mut().zip(shape.lengths) {
            *longest = own.max(*longest);
        }
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
    pub fn with_boundary(self, boundary: Boundary) -> Self {
        self.with_boundaries(&[boundary; AXES])
    }

    /// The same along each axis; periodic along those that are not told.
    pub fn with_boundaries(mut self, boundaries: &[Boundary]) -> Self {
        for (own, boundary) in self.boundaries.iter_mut().zip(boundaries) {
            *own = *boundary;
        }
        self
    }

    /// Sets the value of `N` as a number; the length of the longest family unless told. Inside
    /// brackets `N` is always the length of the longest family of this scope, so that `x[N-1]`
    /// is its last member.
    pub fn with_length(mut self, length: usize) -> Self {
        self.shown_length = Some(length);
        self
    }

    /// Sets the lengths along the axes of a lattice that the families of this scope are a short piece of. On a ring an offset reaches up to
    /// half of that length; up to half of the family's own unless told.
    pub fn with_rings(mut self, lengths: &[usize]) -> Self {
        for (own, length) in self.rings.iter_mut().zip(lengths) {
            *own = *length;
        }
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

    pub(super) fn entry_of(&self, name: &str) -> Option<Entry> {
        self.entries.get(name).copied()
    }

    pub(super) fn declare(&mut self, name: &str, entry: Entry) {
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
    ///
    /// # Errors
    /// [`SyntaxErrorKind::LengthUnknown`] without a family, [`SyntaxErrorKind::LengthOfAxes`] on a lattice of several
    /// axes.
    pub(super) fn shown_length(&self, span: Span) -> Result<usize, SyntaxError> {
        let unknown = SyntaxErrorKind::LengthUnknown { name: LENGTH };
        let several = SyntaxErrorKind::LengthOfAxes;
        match (self.longest.as_ref().map(Shape::lengths), self.shown_length) {
            (Some([_, _, ..]), _) => Err(SyntaxError::new(span, several)),
            (_, Some(length)) => Ok(length),
            (Some([length]), None) => Ok(*length),
            _ => Err(SyntaxError::new(span, unknown)),
        }
    }

    /// The lengths of the longest family, one an axis; none where there is no family.
    pub fn lengths(&self) -> &[usize] {
        self.longest.as_ref().map_or(&[], Shape::lengths)
    }

    /// How many values an index takes: the length of the axis along which `body` first counts by it. On a chain that
    /// is the chain's length, whatever it counts.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::LengthUnknown`] without a family. On a lattice of several axes
    /// [`SyntaxErrorKind::AxisUnknown`] for an index of no axis, [`SyntaxErrorKind::AxesOfLengths`] for one of axes with
    /// different lengths.
    pub(super) fn values_of(
        &self,
        text: &str,
        (index, above): (Span, Option<Span>),
        body: &Node,
    ) -> Result<usize, SyntaxError> {
        let lengths = self.lengths();
        match lengths {
            [] => {
                let kind = SyntaxErrorKind::LengthUnknown { name: SUM };
                return Err(SyntaxError::new(index, kind));
            }
            [length] => return Ok(*length),
            _ => {}
        }
        let mut axes = Vec::new();
        body.axes_of(text, index.of(text), &mut axes);
        // Of i < j both count along the same axis.
        let mut others = Vec::new();
        if let Some(above) = above {
            body.axes_of(text, above.of(text), &mut others);
        }
        let name = || index.of(text).to_owned();
        let refuse = |kind| Err(SyntaxError::new(index, kind));
        if let Some(above) = above
            && others.iter().any(|axis| !axes.contains(axis))
        {
            let lower = above.of(text).to_owned();
            return refuse(SyntaxErrorKind::AxesApart {
                lower,
                name: name(),
            });
        }
        let mut own = axes.iter().filter_map(|axis| lengths.get(*axis).copied());
        let Some(first) = own.next() else {
            return refuse(SyntaxErrorKind::AxisUnknown { name: name() });
        };
        match own.find(|length| *length != first) {
            None => Ok(first),
            Some(other) => refuse(SyntaxErrorKind::AxesOfLengths {
                name: name(),
                lengths: [first, other],
            }),
        }
    }

    /// The coordinates of a site counted in a row, the last axis fastest.
    fn coordinates(&self, site: usize) -> [usize; AXES] {
        let mut coordinates = [0; AXES];
        let mut rest = site;
        let lengths = self.lengths();
        for (axis, length) in lengths.iter().enumerate().rev() {
            coordinates[axis] = match axis {
                0 => rest,
                _ => rest % length.max(&1),
            };
            rest /= (*length).max(1);
        }
        coordinates
    }

    /// The sites that a template with these indices, one an axis or empty, stands for: every value of each index, and
    /// along the other axes 0.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::RepeatedIndex`] where one index counts along two axes. The span covers nothing.
    pub fn sites_of(&self, names: &[&str]) -> Result<Vec<usize>, SyntaxError> {
        let nowhere = Span { start: 0, end: 0 };
        for (axis, name) in names.iter().enumerate() {
            if !name.is_empty() && names[..axis].contains(name) {
                let name = (*name).to_owned();
                let kind = SyntaxErrorKind::RepeatedIndex { name };
                return Err(SyntaxError::new(nowhere, kind));
            }
        }
        let lengths = self.lengths();
        let sites = lengths.iter().product();
        let is_first = |site: &usize| {
            let coordinates = self.coordinates(*site);
            let fixed =
                (0..lengths.len()).filter(|axis| names.get(*axis).is_none_or(|n| n.is_empty()));
            fixed.into_iter().all(|axis| coordinates[axis] == 0)
        };
        Ok((0..sites).filter(is_first).collect())
    }

    /// A site by the values of its indices: `i = 3`, or `i = 3, j = 0`.
    pub fn named_site(&self, (names, site): At<'_>) -> String {
        let values = names.iter().zip(self.coordinates(site));
        let values = values.filter(|(name, _)| !name.is_empty());
        let values: Vec<String> = values
            .map(|(name, value)| format!("{name} = {value}"))
            .collect();
        values.join(", ")
    }

    /// Calls `then` with the indices of a caller bound to a site, inside `outer`, all of one level.
    pub(super) fn at_site<R>(
        &self,
        here: Option<At<'_>>,
        level: usize,
        then: &mut dyn FnMut(Option<&Bound<'_>>) -> R,
    ) -> R {
        let Some((names, site)) = here else {
            return then(None);
        };
        let coordinates = self.coordinates(site);
        let mut values = [(0, 0); AXES];
        for (axis, value) in values.iter_mut().enumerate() {
            *value = (
                coordinates[axis],
                self.lengths().get(axis).copied().unwrap_or(1),
            );
        }
        bind(names, &values, level, None, then)
    }

    /// Entry of the scope under the name of a reference.
    pub(super) fn entry(&self, text: &str, reference: &Reference) -> Result<Entry, SyntaxError> {
        let (name, span) = (reference.name.of(text), reference.shown);
        self.entries.get(name).copied().ok_or_else(|| {
            let known = self.names.iter().map(String::as_str).chain([PI, LENGTH]);
            let kind = SyntaxErrorKind::UnknownName {
                name: name.to_owned(),
            };
            SyntaxError::new(span, kind).suggesting(constant(name).or_else(|| nearest(name, known)))
        })
    }
}
