//! Casimirs of any tensor: J ∇C = 0 is linear in the coefficients of C.

use leafwise_core::SystemFormulas;
use leafwise_expression::algebra::{Symbol, relations};
use leafwise_expression::{AlgebraError, Arithmetic, Expression, Function, Polynomial, Ring};

use crate::candidates::{monomials, symbols_of};
use crate::error::FindError;
use crate::potential::combination;

/// Products of terms that one search may form.
const MOST_PRODUCTS: u64 = 1 << 26;

/// Entries below this, relative to the largest, are 0 at a state of no special value.
const SINGULAR: f64 = 1e-9;

/// Letters that names of Casimirs begin with.
const LETTERS: [&str; 3] = ["C", "K", "casimir"];

/// Independent Casimirs of degree at most `degree`, at most d − rank Π of them, those of few terms first. They are polynomials in the
/// variables, the functions in the tensor, and ln x_i where {x_i, ·} has the factor x_i. Parameters occur to the first degree.
///
/// # Errors
/// [`FindError`] for an entry that the exact algebra cannot read, and past its limits.
pub fn casimirs_of(system: &SystemFormulas, degree: usize) -> Result<Vec<Expression>, FindError> {
    let d = system.dimension();
    let mut ring = Ring::limited(d, MOST_PRODUCTS);
    let x: Vec<Polynomial> = (0..d).map(|i| ring.variable(i)).collect();
    let mut entries = Vec::new();
    for entry in system.tensor().values() {
        entries.push(entry.evaluate_in(&mut ring, &mut |_, at| Ok(x[at].clone()))?);
    }
    let missing = corank(system);
    let mut symbols = symbols_of(&mut ring, &entries)?;
    for (i, variable) in x.iter().enumerate() {
        if has_factor(system, &entries, i) {
            symbols.extend(ring.apply(Function::Ln, variable)?.symbols());
        }
    }
    symbols.sort_unstable();
    symbols.dedup();
    let mut parameters: Vec<usize> = (system.tensor().values())
        .flat_map(Expression::parameters)
        .collect();
    parameters.sort_unstable();
    parameters.dedup();
    let mut found: Vec<Expression> = Vec::new();
    let mut gradients: Vec<Vec<f64>> = Vec::new();
    let with_parameters = [Vec::new(), parameters];
    for parameters in with_parameters
        .iter()
        .take(1 + usize::from(!with_parameters[1].is_empty()))
    {
        for degree in 1..=degree {
            if found.len() == missing {
                return Ok(found);
            }
            let functions = functions(&mut ring, &symbols, degree, parameters)?;
            for casimir in annihilated(system, &mut ring, &x, &functions)? {
                let formula = ring.formula(&casimir);
                let slopes = ring.gradient(&casimir)?;
                let values = parameter_values(system);
                let slopes = slopes
                    .iter()
                    .map(|slope| ring.formula(slope).evaluate(&point(d), &values));
                gradients.push(slopes.collect());
                match rank(gradients.clone()) == gradients.len() && found.len() < missing {
                    true => found.push(formula),
                    false => drop(gradients.pop()),
                }
            }
        }
    }
    Ok(found)
}

/// The same with names C, or C1, C2, …; of other letters where a variable or a parameter has such a name.
///
/// # Errors
/// As [`casimirs_of`].
pub fn named_casimirs_of(
    system: &SystemFormulas,
    degree: usize,
) -> Result<Vec<(String, String)>, FindError> {
    let found = casimirs_of(system, degree)?;
    let parameters: Vec<String> = (system.parameters().iter())
        .map(|parameter| parameter.name.clone())
        .collect();
    let named = |letter: &str| -> Vec<String> {
        match found.len() {
            1 => vec![letter.to_owned()],
            count => (1..=count).map(|at| format!("{letter}{at}")).collect(),
        }
    };
    let is_free = |names: &Vec<String>| {
        let taken = |name: &String| system.variables().contains(name) || parameters.contains(name);
        !names.iter().any(taken)
    };
    let mut all = LETTERS.map(named).into_iter();
    let names = all.find(is_free).unwrap_or_else(|| named("casimir"));
    let formulas = found
        .iter()
        .map(|casimir| casimir.written(system.variables(), &parameters));
    Ok(names.into_iter().zip(formulas).collect())
}

/// d − rank Π at a state of no special value: how many independent Casimirs there are about it.
pub fn corank(system: &SystemFormulas) -> usize {
    system.dimension() - rank(tensor_at(system))
}

/// Whether {x_i, ·} has the factor x_i, and is not zero.
fn has_factor(system: &SystemFormulas, entries: &[Polynomial], i: usize) -> bool {
    let pairs = system.tensor().keys().zip(entries);
    let row = pairs.filter(|((a, b), entry)| (*a == i || *b == i) && !entry.is_zero());
    let terms = row.flat_map(|(_, entry)| entry.terms());
    let least = terms.map(|(m, _)| m.exponent(i as Symbol)).min();
    least.is_some_and(|least| least >= 1)
}

/// Monomials, each times 1 and times every one of these parameters.
fn functions(
    ring: &mut Ring,
    symbols: &[Symbol],
    degree: usize,
    parameters: &[usize],
) -> Result<Vec<Polynomial>, FindError> {
    let plain = monomials(ring, symbols, degree)?;
    let mut functions = plain.clone();
    for &parameter in parameters {
        let factor = ring.parameter(parameter);
        for function in &plain {
            functions.push(ring.multiply(&factor, function));
        }
    }
    Ok(functions)
}

/// Combinations C of functions with Π ∇C = 0, fewest terms first.
fn annihilated(
    system: &SystemFormulas,
    ring: &mut Ring,
    x: &[Polynomial],
    functions: &[Polynomial],
) -> Result<Vec<Polynomial>, AlgebraError> {
    let mut columns = Vec::with_capacity(functions.len());
    for function in functions {
        let gradient = ring.gradient(function)?;
        columns.push(system.apply_tensor(ring, x, &gradient)?);
    }
    let solutions = relations(&columns, &[]).solutions();
    let directions = solutions.map_or_else(Vec::new, |s| s.directions);
    let mut found: Vec<Polynomial> = (directions.iter())
        .map(|direction| combination(ring, direction, functions))
        .collect();
    found.sort_by_key(|f| f.terms().len());
    Ok(found)
}

/// A state of no special value.
fn point(d: usize) -> Vec<f64> {
    let coordinates = (1..=d).map(|i| 0.5 + (i as f64 * 0.618_033_988_749_894_9) % 1.0);
    coordinates.collect()
}

fn parameter_values(system: &SystemFormulas) -> Vec<f64> {
    system.parameter_values()
}

/// Π at that state.
fn tensor_at(system: &SystemFormulas) -> Vec<Vec<f64>> {
    let d = system.dimension();
    let values = system.parameter_values();
    let mut rows = vec![vec![0.0; d]; d];
    for (&(i, j), entry) in system.tensor() {
        let value = entry.evaluate(&point(d), &values);
        rows[i][j] = value;
        rows[j][i] = -value;
    }
    rows
}

/// The rank to `SINGULAR`, by complete pivots.
fn rank(mut rows: Vec<Vec<f64>>) -> usize {
    let columns = rows.first().map_or(0, Vec::len);
    let largest = rows
        .iter()
        .flatten()
        .fold(0.0_f64, |most, v| most.max(v.abs()));
    let mut rank = 0;
    while rank < rows.len().min(columns) {
        let places = (rank..rows.len()).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let Some((i, j)) =
            places.max_by(|&(i, j), &(k, l)| rows[i][j].abs().total_cmp(&rows[k][l].abs()))
        else {
            break;
        };
        if rows[i][j].abs() <= SINGULAR * largest {
            break;
        }
        rows.swap(rank, i);
        let lead = rows[rank].clone();
        for row in rows.iter_mut().skip(rank + 1) {
            let factor = row[j] / lead[j];
            for (entry, above) in row.iter_mut().zip(&lead) {
                *entry -= factor * above;
            }
            row[j] = 0.0;
        }
        rank += 1;
    }
    rank
}
