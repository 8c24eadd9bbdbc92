//! The ways to write a bracket, each to entries {x_i, x_j} with i < j.

use leafwise_core::lattice::LatticeGeometry;
use std::collections::BTreeMap;

use leafwise_expression::syntax::{At, Scope, VariablePattern};
use leafwise_expression::{Arithmetic, Expression, Rational, Ring};

use super::Refusal;
use super::geometry::moving;
use super::keys::pair;
use super::lie_algebra;
use super::names::{algebra_refusal, exact, parse, refusal, sites_of};
use super::sum::summands;
use crate::document::{BracketSpec, Convention, LieAlgebraSpec, Located, Number, SceneDocument};

/// {x_i, x_j} for i < j, as the scene's author wrote them.
pub(super) type Entries = BTreeMap<(usize, usize), Expression>;

/// The entries of the scene's bracket with its families as long as those of `lattice`.
pub(super) fn entries(
    document: &SceneDocument,
    scope: &Scope,
    names: &[String],
    lattice: &LatticeGeometry,
) -> Result<Entries, Refusal> {
    // Parameters of sites stand behind the coordinates and commute with all.
    let coordinates = &names[..moving(document, lattice)];
    match &document.system.bracket.value {
        BracketSpec::Entries(written) | BracketSpec::Contact(written) => {
            let table = Antisymmetric {
                noun: "a bracket",
                name: |a, b| format!("{{{a}, {b}}}"),
            };
            table.entries(document, scope, names, written)
        }
        // Made of its form once the state is known about which the system moves.
        BracketSpec::OneForm(_) | BracketSpec::TwoForm(_) => Ok(Entries::new()),
        BracketSpec::LieAlgebra(spec) if document.system.vectors.is_empty() => {
            lie_algebra::entries(document, spec, coordinates)
        }
        BracketSpec::LieAlgebra(spec) => at_every_site(document, spec, lattice),
        BracketSpec::LogCanonical(rows) => log_canonical(document, rows, coordinates),
        BracketSpec::MagneticField(field) => {
            magnetic_field(document, scope, field, coordinates.len())
        }
        BracketSpec::Sum(_) => sum(document, lattice),
    }
}

/// The linear bracket of an algebra at every site of the families of vectors.
fn at_every_site(
    document: &SceneDocument,
    spec: &LieAlgebraSpec,
    lattice: &LatticeGeometry,
) -> Result<Entries, Refusal> {
    let system = &document.system;
    let is_scalar = |name: &&&Located<String>| {
        let mut vectors = system.vectors.iter();
        !vectors.any(|vector| vector.name.value == name.value)
    };
    let declared = system.declared();
    if let Some(scalar) = declared.iter().find(is_scalar) {
        return Err(Box::new(
            document.diagnostic(
                &scalar.place(),
                format!(
                    "a Lie algebra at every site needs vectors, and `{}` is not a vector",
                    scalar.value
                ),
                "no vector",
                Some(
                    "write a direct sum: bracket = { sum = [ … ] }, with a summand for the vectors"
                        .to_owned(),
                ),
            ),
        ));
    }
    let mut all = Entries::new();
    let mut start = 0;
    let mut families = lattice.families.iter();
    for vector in &system.vectors {
        let components: Vec<String> = vector.components.iter().map(|c| c.value.clone()).collect();
        let at_site = lie_algebra::entries(document, spec, &components)?;
        // The components of a family have one length.
        let own = families.by_ref().take(components.len());
        let length = own.last().map_or(0, |family| family.1);
        for site in 0..length {
            let places: Vec<usize> = (0..components.len())
                .map(|c| start + c * length + site)
                .collect();
            let entries = at_site.iter();
            all.extend(
                entries.map(|((i, j), entry)| {
                    ((places[*i], places[*j]), entry.with_variables(&places))
                }),
            );
        }
        start += components.len() * length;
    }
    Ok(all)
}

/// The entries of all summands but those that are made of forms.
fn sum(document: &SceneDocument, lattice: &LatticeGeometry) -> Result<Entries, Refusal> {
    let mut sum = Entries::new();
    for summand in summands(document, lattice)? {
        if summand.is_formed() {
            continue;
        }
        let (names, lattice) = (&summand.names, &summand.lattice);
        let own = entries(&summand.document, &summand.scope, names, lattice)?;
        let places = &summand.places;
        for ((i, j), entry) in own {
            let (i, j, entry) = (places[i], places[j], entry.with_variables(places));
            match i < j {
                true => sum.insert((i, j), entry),
                false => sum.insert((j, i), Expression::Negate(Box::new(entry))),
            };
        }
    }
    Ok(sum)
}

/// A table of the entries of an antisymmetric matrix, and what messages call it and them.
pub(super) struct Antisymmetric {
    pub noun: &'static str,
    pub name: fn(&str, &str) -> String,
}

impl Antisymmetric {
    /// The entries for i < j with the families as long as those of the scope.
    pub fn entries(
        &self,
        document: &SceneDocument,
        scope: &Scope,
        names: &[String],
        written: &[(Located<String>, Located<String>)],
    ) -> Result<Entries, Refusal> {
        let mut collector = Collector {
            of: self,
            document,
            names,
            known: BTreeMap::new(),
            ring: Ring::new(names.len()),
        };
        for (key, formula) in written {
            collector.template(scope, key, formula)?;
        }
        let known = collector.known.into_iter();
        Ok(known.map(|(at, (entry, _))| (at, entry)).collect())
    }
}

/// The names of the indices of a pair, one an axis: those of the first of them, and along axes where it has a number those of
/// the other.
fn joined<'a>(mut first: Vec<&'a str>, other: Vec<&'a str>) -> Vec<&'a str> {
    if first.is_empty() {
        return other;
    }
    for (name, other) in first.iter_mut().zip(other) {
        if name.is_empty() {
            *name = other;
        }
    }
    first
}

struct Collector<'a> {
    of: &'a Antisymmetric,
    document: &'a SceneDocument,
    names: &'a [String],
    known: BTreeMap<(usize, usize), (Expression, &'a Located<String>)>,
    ring: Ring,
}

impl<'a> Collector<'a> {
    /// The entries of one key, at every site where it has an index.
    fn template(
        &mut self,
        scope: &Scope,
        key: &'a Located<String>,
        formula: &'a Located<String>,
    ) -> Result<(), Refusal> {
        let (left, right) = pair(self.document, key)?;
        let parsed = parse(self.document, formula)?;
        let names = joined(left.index_names(), right.index_names());
        let sites: Vec<Option<At<'_>>> = match names.is_empty() {
            true => vec![None],
            false => sites_of(self.document, scope, key, &names)?
                .into_iter()
                .map(|site| Some((&names[..], site)))
                .collect(),
        };
        for site in sites {
            let resolve = |pattern: &VariablePattern| {
                pattern
                    .resolve(scope, site)
                    .map_err(|error| refusal(self.document, key, &error))
            };
            let (Some(i), Some(j)) = (resolve(&left)?, resolve(&right)?) else {
                continue;
            };
            let entry = parsed
                .resolve(scope, site)
                .map_err(|error| refusal(self.document, formula, &error))?;
            if let Some(entry) = entry {
                self.insert(i, j, entry, key, formula)?;
            }
        }
        Ok(())
    }

    fn insert(
        &mut self,
        i: usize,
        j: usize,
        entry: Expression,
        key: &'a Located<String>,
        formula: &'a Located<String>,
    ) -> Result<(), Refusal> {
        let (document, names) = (self.document, self.names);
        let in_ring = |ring: &mut Ring, entry: &Expression| {
            entry
                .evaluate_in(ring, &mut |ring, at| Ok(ring.variable(at)))
                .map_err(|error| algebra_refusal(document, formula, &error))
        };
        let value = in_ring(&mut self.ring, &entry)?;
        if i == j {
            if self.ring.is_zero(&value) {
                return Ok(());
            }
            return Err(Box::new(document.diagnostic(
                &document.place_in_formula(key, 0..key.value.len()),
                format!("{} is not zero", (self.of.name)(&names[i], &names[i])),
                format!("{} is antisymmetric", self.of.noun),
                Some("remove this entry: it vanishes by antisymmetry".into()),
            )));
        }
        let (at, entry) = if i < j {
            ((i, j), entry)
        } else {
            ((j, i), Expression::Negate(Box::new(entry)))
        };
        let Some((earlier, earlier_key)) = self.known.get(&at) else {
            self.known.insert(at, (entry, key));
            return Ok(());
        };
        let (a, b) = (
            in_ring(&mut self.ring, earlier)?,
            in_ring(&mut self.ring, &entry)?,
        );
        let difference = self.ring.subtract(&a, &b);
        if self.ring.is_zero(&difference) {
            return Ok(());
        }
        let pair = (self.of.name)(&names[at.0], &names[at.1]);
        let (message, help) = if earlier_key.value == key.value {
            (
                format!("`{}` gives two different values for {pair}", key.value),
                "on so short a ring the entry meets itself: make the family longer".to_owned(),
            )
        } else {
            (
                format!(
                    "`{}` and `{}` contradict each other about {pair}",
                    earlier_key.value, key.value
                ),
                "write each pair once: antisymmetry fills in the other".to_owned(),
            )
        };
        Err(Box::new(document.diagnostic(
            &document.place_in_formula(key, 0..key.value.len()),
            message,
            format!("contradicts `{}`", earlier_key.value),
            Some(help),
        )))
    }
}

fn integer(value: i64) -> Expression {
    Expression::Constant(Rational::from_integer(value))
}

/// {x_i, x_j} = a_ij x_i x_j.
fn log_canonical(
    document: &SceneDocument,
    rows: &[Vec<Located<Number>>],
    names: &[String],
) -> Result<Entries, Refusal> {
    if rows.len() != names.len() {
        return Err(Box::new(document.diagnostic(
            &document.system.bracket.place(),
            format!(
                "the matrix has {} rows for {} variables",
                rows.len(),
                names.len()
            ),
            "one row for each variable",
            None,
        )));
    }
    let mut entries = Entries::new();
    for i in 0..rows.len() {
        for j in 0..=i {
            let (below, above) = (exact(document, &rows[i][j])?, exact(document, &rows[j][i])?);
            if !(&below + &above).is_zero() {
                let help = if i == j {
                    "the diagonal of an antisymmetric matrix is zero".to_owned()
                } else {
                    format!(
                        "its mirror image, row {} column {}, is {}",
                        j + 1,
                        i + 1,
                        rows[j][i].value.literal
                    )
                };
                return Err(Box::new(document.diagnostic(
                    &rows[i][j].place(),
                    "the matrix of a log-canonical bracket is antisymmetric, and this one is not",
                    format!("row {}, column {}", i + 1, j + 1),
                    Some(help),
                )));
            }
            if i != j && !above.is_zero() {
                let product = vec![
                    Expression::Constant(above),
                    Expression::Variable(j),
                    Expression::Variable(i),
                ];
                entries.insert((j, i), Expression::Product(product));
            }
        }
    }
    Ok(entries)
}

/// {x_i, v_j} = s δ_ij, {v_1, v_2} = s B_3 and cyclic, for positions x, then velocities v. In the plane,
/// {v_1, v_2} = s B. The sign is s = −1 for ẋ = {H, x} and s = +1 for ẋ = {x, H}. Under both conventions H = v²/2 +
/// V(x) moves by x' = v, v' = v × B − ∇V.
fn magnetic_field(
    document: &SceneDocument,
    scope: &Scope,
    field: &[Located<String>],
    dimension: usize,
) -> Result<Entries, Refusal> {
    let places: &[(usize, usize)] = match (field.len(), dimension) {
        (3, 6) => &[(4, 5), (5, 3), (3, 4)],
        (1, 4) => &[(2, 3)],
        _ => {
            return Err(Box::new(document.diagnostic(
                &document.system.bracket.place(),
                format!("{} field components do not fit {dimension} variables", field.len()),
                "magnetic field",
                Some(
                    "in space: [\"Bx\", \"By\", \"Bz\"] over x, y, z, vx, vy, vz; in the plane: [\"B\"] over \
                     x, y, vx, vy; with H = v^2/2 it means x' = v, v' = v × B"
                        .to_owned(),
                ),
            )));
        }
    };
    let is_reversed = document.system.convention == Convention::HamiltonFirst;
    let signed = |value: Expression, is_negative: bool| match is_negative {
        true => Expression::Negate(Box::new(value)),
        false => value,
    };
    let mut entries = Entries::new();
    for i in 0..dimension / 2 {
        let canonical = integer(if is_reversed { -1 } else { 1 });
        entries.insert((i, i + dimension / 2), canonical);
    }
    for (component, &(i, j)) in field.iter().zip(places) {
        let formula = parse(document, component)?;
        let value = formula
            .resolve(scope, None)
            .map_err(|error| refusal(document, component, &error))?
            .unwrap_or_else(|| integer(0));
        entries.insert((i.min(j), i.max(j)), signed(value, (i > j) != is_reversed));
    }
    Ok(entries)
}
