//! Pieces that repeat along a lattice.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use leafwise_core::lattice::{Cells, LatticeSource, PerAxis};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::algebra::{Generator, Symbol};
use leafwise_expression::syntax::AXES;
use leafwise_expression::{Expression, Polynomial, Ring};

use crate::field::variables;
use crate::piece::{Atom, Piece};
use crate::pieces::{atoms, summands};
use crate::probe::Probe;
use crate::tensor::Tensor;

/// A term of one site's share of H, with its name up to translation.
struct SiteAtom {
    key: String,
    atom: Atom,
}

/// H = Σ H_i with an exact flow of each H_i and each the same in every cell; `None` where the terms
/// of the cells do not combine so.
///
/// The terms of one cell are taken one after the other, each with all its translates. They are added to the first
/// piece that keeps an exact flow with them.
///
/// # Errors
/// Fails with [`BuildError::DoesNotFit`] with a term that has no exact flow even alone. Fails with
/// [`BuildError::Algebra`] where a formula is outside the algebra, and with the errors of
/// [`LatticeSource::densities`].
pub fn find_repeating_pieces(
    source: &dyn LatticeSource,
    cells: &Cells,
    system: &SystemFormulas,
    ring: &mut Ring,
) -> Result<Option<Vec<Piece>>, BuildError> {
    let (tensor, probe) = (Tensor::new(system, ring)?, Probe::of(system));
    let mut sites = Vec::with_capacity(cells.sites().length());
    for site in 0..cells.sites().length() {
        sites.push(site_atoms(
            source, cells, system, &tensor, &probe, ring, site,
        )?);
    }
    let mut pieces: Vec<Piece> = Vec::new();
    for (row, key) in units(cells, &sites) {
        let translates = sites.iter().skip(row).step_by(cells.period()).flatten();
        let unit: Vec<&Atom> = translates
            .filter(|site_atom| site_atom.key == key)
            .map(|site_atom| &site_atom.atom)
            .collect();
        if !place(ring, &probe, &mut pieces, &unit, system.dimension())? {
            return Ok(None);
        }
    }
    Ok(Some(pieces))
}

/// Number of cells that the flow of a piece looks away along each axis, or more than `most` where it is more. A
/// coordinate is moved by others, which are moved themselves by what stands as far from them, and so on. The middle of
/// the cells is looked at, whose field is that of every cell.
pub(super) fn looks(
    piece: &Piece,
    cells: &Cells,
    ring: &Ring,
    most: PerAxis<usize>,
) -> PerAxis<usize> {
    let rows = cells.rows();
    let (middle, offsets) = (rows.middle(), rows.offsets());
    let mut read_by: Vec<Vec<(usize, PerAxis<isize>)>> = vec![Vec::new(); offsets.len()];
    for (&moved, velocity) in piece.field() {
        let (row, cell) = rows.locate(cells.place(moved));
        if cell == middle {
            let places = variables(ring, velocity)
                .into_iter()
                .map(|v| rows.locate(cells.place(v)));
            read_by[row] = places
                .map(|(row, cell)| (row, rows.shift(middle, cell)))
                .collect();
        }
    }
    let mut farthest = [0; AXES];
    for start in 0..offsets.len() {
        let mut seen = BTreeSet::new();
        let mut open = vec![(start, [0_isize; AXES])];
        while let Some((row, shift)) = open.pop() {
            for (farthest, shift) in farthest.iter_mut().zip(shift) {
                *farthest = shift.unsigned_abs().max(*farthest);
            }
            if (0..AXES).any(|axis| farthest[axis] > most[axis]) {
                return farthest;
            }
            if seen.insert((row, shift)) {
                let further = read_by[row].iter().map(|(row, further)| {
                    (
                        *row,
                        std::array::from_fn(|axis| shift[axis] + further[axis]),
                    )
                });
                open.extend(further);
            }
        }
    }
    farthest
}

/// The rows and names of all terms: those of the middle cell first, in the order of its formulas;
/// then what stands at open ends alone.
fn units(cells: &Cells, sites: &[Vec<SiteAtom>]) -> Vec<(usize, String)> {
    let period = cells.period();
    let middle = cells.rows().middle() * period;
    let of_middle = |row: usize| sites.get(middle + row).map_or(&[][..], Vec::as_slice);
    let most = (0..period)
        .map(|row| of_middle(row).len())
        .max()
        .unwrap_or(0);
    let of_cell = (0..most).flat_map(|k| (0..period).map(move |row| (row, k)));
    let inner = of_cell.filter_map(|(row, k)| Some((row, &of_middle(row).get(k)?.key)));
    let all = sites.iter().enumerate();
    let others = all.flat_map(|(site, atoms)| atoms.iter().map(move |a| (site % period, &a.key)));
    let mut units: Vec<(usize, String)> = Vec::new();
    for (row, key) in inner.chain(others) {
        if !units.iter().any(|(r, k)| *r == row && k == key) {
            units.push((row, key.clone()));
        }
    }
    units
}

/// Adds a term and its translates to the first piece that keeps an exact flow with them, or to a new
/// one; whether there is such a piece.
fn place(
    ring: &mut Ring,
    probe: &Probe,
    pieces: &mut Vec<Piece>,
    unit: &[&Atom],
    dimension: usize,
) -> Result<bool, BuildError> {
    for at in 0..=pieces.len() {
        let mut piece = pieces
            .get(at)
            .cloned()
            .unwrap_or_else(|| Piece::empty(dimension));
        let mut fits = true;
        for atom in unit {
            fits = fits && piece.add(ring, probe, atom)?.is_ok();
        }
        if fits {
            match pieces.get_mut(at) {
                Some(place) => *place = piece,
                None => pieces.push(piece),
            }
            return Ok(true);
        }
    }
    Ok(false)
}

/// The terms of one site's share of H.
fn site_atoms(
    source: &dyn LatticeSource,
    cells: &Cells,
    system: &SystemFormulas,
    tensor: &Tensor,
    probe: &Probe,
    ring: &mut Ring,
    site: usize,
) -> Result<Vec<SiteAtom>, BuildError> {
    let densities = source.densities(cells.sites(), site)?;
    let mut found = Vec::new();
    for summand in densities
        .iter()
        .take(1)
        .flat_map(|d| site_summands(&d.site))
    {
        let f = summand.evaluate_in(ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)))?;
        for atom in atoms(system, ring, probe, tensor, f, &summand)? {
            let name = |variable: usize| {
                let (family, other) = cells.sites().locate(variable);
                format!("{family}@{:?}", cells.sites().shift(site, other))
            };
            let key = Key { ring, name: &name }.polynomial(&atom.hamiltonian);
            found.push(SiteAtom { key, atom });
        }
    }
    Ok(found)
}

/// The summands of a site's share: through sums, and through products of one sum with what does not
/// depend on the state.
fn site_summands(formula: &Expression) -> Vec<Expression> {
    match formula {
        Expression::Sum(terms) => terms.iter().flat_map(site_summands).collect(),
        Expression::Product(factors) => {
            let mut of_state = factors.iter().enumerate();
            let varies = |factor: &Expression| !factor.variables().is_empty();
            let (Some((at, inner)), None) = (
                of_state.find(|(_, factor)| varies(factor)),
                of_state.find(|(_, factor)| varies(factor)),
            ) else {
                return vec![formula.clone()];
            };
            let with = |term| {
                let mut product = factors.clone();
                product[at] = term;
                Expression::Product(product)
            };
            site_summands(inner).into_iter().map(with).collect()
        }
        other => summands(other),
    }
}

/// Polynomials as text that is the same for every translate.
struct Key<'a> {
    ring: &'a Ring,
    name: &'a dyn Fn(usize) -> String,
}

impl Key<'_> {
    fn polynomial(&self, f: &Polynomial) -> String {
        let terms = f.terms().iter().map(|(monomial, coefficient)| {
            let factors = monomial.factors().iter();
            let mut factors: Vec<String> = factors
                .map(|&(symbol, exponent)| format!("{}^{exponent}", self.symbol(symbol)))
                .collect();
            factors.sort_unstable();
            format!("{coefficient:?}*{}", factors.join("*"))
        });
        let mut terms: Vec<String> = terms.collect();
        terms.sort_unstable();
        terms.join("+")
    }

    fn symbol(&self, symbol: Symbol) -> String {
        let Some(generator) = self.ring.generator(symbol) else {
            return (self.name)(symbol as usize);
        };
        let mut text = match generator {
            Generator::Inverse(_) => "1/".to_owned(),
            Generator::Root(_, q) => format!("root{q}"),
            Generator::Power(_, exponent) => format!("power{exponent:?}"),
            Generator::Function(function, _) => function.to_string(),
            Generator::Binary(function, ..) => function.name().to_owned(),
            Generator::Lookup(lookup, _) => format!("{lookup:?}"),
            Generator::Kept(side, ..) => format!("kept{side:?}"),
        };
        for argument in generator.arguments() {
            let _ = write!(text, "({})", self.polynomial(argument));
        }
        text
    }
}
