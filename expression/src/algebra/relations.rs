//! Linear relations with rational coefficients between elements of the ring.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use super::monomial::Monomial;
use super::polynomial::Polynomial;
use crate::rational::Rational;

/// The solutions c of a linear system over ℚ: `particular` + Σ tₖ `directions[k]`.
///
/// Directions are those of the reduced row echelon form: each has the entry 1 at a free unknown, where all others and the
/// particular solution have 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Solutions {
    /// One solution, of which every free unknown is 0.
    pub particular: Vec<Rational>,
    /// A basis of the solutions of the homogeneous system.
    pub directions: Vec<Vec<Rational>>,
}

/// Rows of a linear system over ℚ, reduced one by one.
///
/// Unknowns are numbered 0 … n−1, the right side is the column n. Rows are sparse.
#[derive(Clone, Debug, Default)]
pub struct Elimination {
    unknowns: usize,
    /// Rows by their pivots; the pivot's entry is 1. Entries behind a pivot may stand in columns of later pivots.
    rows: BTreeMap<usize, BTreeMap<usize, Rational>>,
    is_contradictory: bool,
}

impl Elimination {
    /// No equation yet between this many unknowns.
    pub fn new(unknowns: usize) -> Self {
        Self {
            unknowns,
            ..Self::default()
        }
    }

    /// Adds Σ cᵢ `row[i]` = `row[n]`; a repeated column counts the sum of its entries.
    pub fn add(&mut self, row: impl IntoIterator<Item = (usize, Rational)>) {
        let mut rest: BTreeMap<usize, Rational> = BTreeMap::new();
        for (column, entry) in row {
            accumulate(&mut rest, column, &entry);
        }
        let mut reduced: BTreeMap<usize, Rational> = BTreeMap::new();
        while let Some((column, entry)) = rest.pop_first() {
            match self.rows.get(&column) {
                None => drop(reduced.insert(column, entry)),
                Some(pivot) => {
                    for (&other, factor) in pivot.iter().skip(1) {
                        accumulate(&mut rest, other, &-(&entry * factor));
                    }
                }
            }
        }
        let Some((pivot, lead)) = reduced.first_key_value() else {
            return;
        };
        let pivot = *pivot;
        if pivot == self.unknowns {
            self.is_contradictory = true;
            return;
        }
        let unit = lead.recip();
        for entry in reduced.values_mut() {
            *entry = &*entry * &unit;
        }
        self.rows.insert(pivot, reduced);
    }

    /// The number of independent equations.
    pub fn rank(&self) -> usize {
        self.rows.len()
    }

    /// Every solution, `None` where equations contradict each other.
    pub fn solutions(&self) -> Option<Solutions> {
        if self.is_contradictory {
            return None;
        }
        // From the last pivot on, so that rows hold free unknowns alone.
        let mut full: BTreeMap<usize, BTreeMap<usize, Rational>> = BTreeMap::new();
        for (&pivot, row) in self.rows.iter().rev() {
            let mut reduced: BTreeMap<usize, Rational> = BTreeMap::new();
            for (&column, entry) in row.iter().skip(1) {
                match full.get(&column) {
                    None => accumulate(&mut reduced, column, entry),
                    Some(known) => {
                        for (&other, factor) in known {
                            accumulate(&mut reduced, other, &-(entry * factor));
                        }
                    }
                }
            }
            full.insert(pivot, reduced);
        }
        let zero = || vec![Rational::zero(); self.unknowns];
        let mut particular = zero();
        let free: Vec<usize> = (0..self.unknowns)
            .filter(|unknown| !full.contains_key(unknown))
            .collect();
        let place: FxHashMap<usize, usize> = free.iter().copied().zip(0..).collect();
        let mut directions: Vec<Vec<Rational>> = free.iter().map(|_| zero()).collect();
        for (direction, &unknown) in directions.iter_mut().zip(&free) {
            direction[unknown] = Rational::one();
        }
        for (&pivot, row) in &full {
            for (&column, entry) in row {
                match place.get(&column) {
                    Some(&at) => directions[at][pivot] = -entry,
                    None => particular[pivot] = entry.clone(),
                }
            }
        }
        Some(Solutions {
            particular,
            directions,
        })
    }
}

fn accumulate(row: &mut BTreeMap<usize, Rational>, column: usize, entry: &Rational) {
    let sum = row.entry(column).or_insert_with(Rational::zero);
    *sum += entry;
    if sum.is_zero() {
        row.remove(&column);
    }
}

/// The equations Σ cₖ `columns[k]` = `right` between vectors of elements of the ring, one for each component, monomial of the state and
/// monomial of the parameters.
///
/// What solves them solves Σ cₖ columnsₖ = right identically. The reverse holds where monomials of the generators are linearly
/// independent. Components that a vector lacks are 0.
pub fn relations(columns: &[Vec<Polynomial>], right: &[Polynomial]) -> Elimination {
    type Place<'a> = (usize, &'a Monomial, &'a Monomial);
    let mut rows: FxHashMap<Place<'_>, usize> = FxHashMap::default();
    let mut equations: Vec<Vec<(usize, Rational)>> = Vec::new();
    let vectors = columns.iter().map(Vec::as_slice).chain([right]);
    for (column, vector) in vectors.enumerate() {
        for (component, element) in vector.iter().enumerate() {
            for (monomial, coefficient) in element.terms() {
                for (constant, number) in coefficient.terms() {
                    let row = *rows
                        .entry((component, monomial, constant))
                        .or_insert_with(|| {
                            equations.push(Vec::new());
                            equations.len() - 1
                        });
                    equations[row].push((column, number.clone()));
                }
            }
        }
    }
    // Short equations first: they decide unknowns without filling others.
    equations.sort_by_key(Vec::len);
    let mut elimination = Elimination::new(columns.len());
    for equation in equations {
        elimination.add(equation);
    }
    elimination
}

#[cfg(test)]
mod tests {
    use super::{Elimination, relations};
    use crate::{Arithmetic, Rational, Ring};

    /// Of x + y + z = 6, y − z = −1, 2x + 2y + 2z = 12 every solution, and none where 5 stands for 12.
    #[test]
    fn solutions_solve_and_contradictions_have_none() {
        let number = Rational::from_integer;
        let mut system = Elimination::new(3);
        let row = |entries: [i64; 4]| entries.map(number).into_iter().enumerate();
        system.add(row([1, 1, 1, 6]));
        system.add(row([0, 1, -1, -1]));
        system.add(row([2, 2, 2, 12]));
        assert_eq!(system.rank(), 2);
        let solutions = system.solutions().expect("no contradiction");
        assert_eq!(solutions.particular, [7, -1, 0].map(number));
        assert_eq!(solutions.directions, [[-2, 1, 1].map(number)]);
        system.add(row([2, 2, 2, 5]));
        assert_eq!(system.solutions(), None);
    }

    /// ∇(a x² + b xy + c y²) = (3y, 3x): a = c = 0, b = 3.
    #[test]
    fn a_potential_is_found_by_its_gradient() {
        let mut ring = Ring::new(2);
        let [x, y] = [0, 1].map(|i| ring.variable(i));
        let products = [(&x, &x), (&x, &y), (&y, &y)].map(|(a, b)| ring.multiply(a, b));
        let columns: Vec<_> = products
            .iter()
            .map(|f| ring.gradient(f).expect("polynomials"))
            .collect();
        let three = Rational::from_integer(3);
        let right = [ring.scale(&three, &y), ring.scale(&three, &x)];
        let solutions = relations(&columns, &right).solutions();
        let solutions = solutions.expect("a potential");
        let expected = [0, 3, 0].map(Rational::from_integer);
        assert_eq!(solutions.particular, expected);
        assert!(solutions.directions.is_empty());
        assert_eq!(
            relations(&columns, &[y, Ring::zero(&mut ring)]).solutions(),
            None
        );
    }
}
