//! Values and gradients of functions of sums, at points side by side.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Expression, Graph, Term, Workspace};
use leafwise_solver::two_sum;

use super::BodyShape;
use super::curve::CurveOfSites;
use super::function::{BodyFunction, BodySum, Weighted};
use super::matrix::{PairEntry, PairMatrix};
use super::pair_code::PairCode;
use super::site_code::SiteCode;
use super::tiles::Tiles;
use crate::error::BuildError;
use crate::observer::Observer;

/// The variables of a formula of a site: its coordinates, and J_ii of each matrix.
fn of_a_site(x: &[Term], diagonals: &[Term]) -> Vec<Term> {
    let coordinates = x.iter().chain(x).cloned();
    let entries = diagonals
        .iter()
        .flat_map(|own| std::iter::repeat_n(own.clone(), PairEntry::COUNT));
    coordinates.chain(entries).collect()
}

/// J_ii of each matrix, in rows of sites and points.
fn diagonals(shape: &BodyShape, points: usize) -> Vec<f64> {
    let of_matrix = |matrix: &PairMatrix| -> Vec<f64> {
        let own = (0..shape.sites).map(|i| matrix.entry(i, i));
        own.flat_map(|own| std::iter::repeat_n(own, points))
            .collect()
    };
    shape.matrices.iter().flat_map(of_matrix).collect()
}

/// The code of sums, and of functions of them.
#[derive(Debug)]
pub(super) struct SumsCode {
    pair: Option<Arc<PairCode>>,
    site: SiteCode,
    outer: SiteCode,
    sums: usize,
    outers: usize,
    shape: BodyShape,
}

impl SumsCode {
    /// Functions `outers` of these sums, which are their variables: their coefficients along a curve, order after order.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub(super) fn new(
        sums: &[&BodySum],
        outers: &[&Expression],
        curve: &CurveOfSites,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        let (shape, orders) = (curve.whole(), curve.order + 1);
        let rows = shape.families + shape.matrices.len();
        let site = SiteCode::new(rows, parameters, |graph, rows| {
            let (x, diagonals) = rows.split_at(shape.families);
            let mut inputs = curve.coordinates(graph, x);
            curve.add_resting(graph, &mut inputs, diagonals);
            let coefficients = curve.coefficients(graph, &inputs, |graph, inputs| {
                let (x, diagonals) = inputs.split_at(curve.shape.families);
                let x = of_a_site(x, diagonals);
                let of_site = |sum: &&BodySum| {
                    let variable = &mut |_: &mut _, at: usize| Ok(x[at].clone());
                    Ok(sum.site.evaluate_in(graph, variable)?)
                };
                sums.iter().map(of_site).collect()
            })?;
            Ok(coefficients.concat())
        })?;
        let outer = SiteCode::new(orders * sums.len(), parameters, |graph, totals| {
            let of_order = |order: usize| totals[order * sums.len()..][..sums.len()].to_vec();
            let totals: Vec<Vec<Term>> = (0..orders).map(of_order).collect();
            let coefficients = curve.coefficients(graph, &totals, |graph, totals| {
                let value = |outer: &&Expression| {
                    let variable = &mut |_: &mut _, at: usize| Ok(totals[at].clone());
                    Ok(outer.evaluate_in(graph, variable)?)
                };
                outers.iter().map(value).collect()
            })?;
            Ok(coefficients.concat())
        })?;
        Ok(Self {
            pair: PairCode::of_sums(sums, curve, parameters)?.map(Arc::new),
            site,
            outer,
            sums: orders * sums.len(),
            outers: orders * outers.len(),
            shape,
        })
    }

    /// The number of functions of the sums.
    pub(super) fn outers(&self) -> usize {
        self.outers
    }

    /// The code of several functions with all their sums.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub(super) fn of_functions(
        functions: &[BodyFunction],
        shape: &BodyShape,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        let sums: Vec<&BodySum> = functions.iter().flat_map(|f| &f.sums).collect();
        let mut first = 0;
        let outers = functions.iter().map(|function| {
            let own: Vec<usize> = (first..first + function.sums.len()).collect();
            first += own.len();
            function.outer.with_variables(&own)
        });
        let outers: Vec<Expression> = outers.collect();
        let outers: Vec<&Expression> = outers.iter().collect();
        Self::new(&sums, &outers, &CurveOfSites::point(shape), parameters)
    }
}

/// Sums at so many points, for fixed parameters.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    code: Arc<SumsCode>,
    points: usize,
    tiles: Option<Tiles>,
    site: Workspace,
    outer: Workspace,
    /// J_ii of each matrix, in rows of sites and points.
    diagonals: Vec<f64>,
    /// Shares of the sites in each sum, and the sums: each in a row over the points.
    shares: Vec<f64>,
    totals: Vec<f64>,
}

impl Sums {
    pub(super) fn new(code: &Arc<SumsCode>, points: usize, parameters: &[f64]) -> Self {
        let shape = &code.shape;
        let tiles = |pair| Tiles::new(pair, shape, points, parameters);
        Self {
            points,
            tiles: code.pair.as_ref().map(tiles),
            site: code.site.workspace(parameters),
            outer: code.outer.workspace(parameters),
            diagonals: diagonals(shape, points),
            shares: vec![0.0; code.sums * shape.sites * points],
            totals: vec![0.0; code.sums * points],
            code: Arc::clone(code),
        }
    }

    /// The functions of the sums at points x, each in a row over the points.
    pub(super) fn evaluate(&mut self, x: &[f64], out: &mut [f64]) {
        let (code, points) = (&self.code, self.points);
        let places = code.shape.sites * points;
        let shares = &mut self.shares;
        let (diagonals, families) = (&self.diagonals, code.shape.families);
        let row = |at: usize| match at < families {
            true => &x[at * places..][..places],
            false => &diagonals[(at - families) * places..][..places],
        };
        code.site
            .evaluate(&mut self.site, places, row, |sum, place, values| {
                shares[sum * places + place..][..values.len()].copy_from_slice(values);
            });
        if let Some(tiles) = &mut self.tiles {
            tiles.add(x, &[], shares);
        }
        for (sum, total) in self.totals.iter_mut().enumerate() {
            let (sum, point) = (sum / points, sum % points);
            let own = shares[sum * places..][..places].iter();
            // The energy of many sites is compared to round-off.
            let (mut high, mut low) = (0.0, 0.0);
            for share in own.skip(point).step_by(points) {
                let (next, rest) = two_sum(high, *share);
                high = next;
                low += rest;
            }
            *total = if high.is_finite() { high + low } else { high };
        }
        let totals = &self.totals;
        let row = |at: usize| &totals[at * points..][..points];
        code.outer
            .evaluate(&mut self.outer, points, row, |outer, place, values| {
                out[outer * points + place..][..values.len()].copy_from_slice(values);
            });
    }
}

/// The results of `write` at a site as code: of its coordinates, what pairs give to the gradient, weights of sums, and J_ii
/// of each matrix, one after the other.
///
/// # Errors
/// [`BuildError::Algebra`] where a formula or derivative has no code; those of `write`.
pub(super) fn at_a_site(
    weighted: &Weighted<'_>,
    shape: &BodyShape,
    by: &[usize],
    graph: &mut Graph,
    inputs: &[Term],
    write: impl FnOnce(&mut Graph, &[Term], &[Term]) -> Result<Vec<(usize, Term)>, BuildError>,
) -> Result<Vec<(usize, Term)>, BuildError> {
    let (x, rest) = inputs.split_at(shape.families);
    let (of_pairs, rest) = rest.split_at(shape.families);
    let (weights, diagonals) = rest.split_at(weighted.of_sums().len());
    let variables = of_a_site(x, diagonals);
    let total = weighted.total(graph, |sum| &sum.site, &variables, weights)?;
    let own = graph.gradient(&total, shape.families)?;
    let mut gradient = vec![graph.zero(); shape.families];
    for family in by {
        gradient[*family] = graph.add(&own[*family], &of_pairs[*family]);
    }
    write(graph, x, &gradient)
}

/// The code of linear functions of a gradient, site by site.
#[derive(Debug)]
pub(super) struct SlopesCode {
    weights: Option<Arc<SumsCode>>,
    pair: Option<Arc<PairCode>>,
    site: SiteCode,
    /// The family of each result of the code of a site.
    families: Vec<usize>,
    shape: BodyShape,
    work: u64,
}

impl SlopesCode {
    /// Results for families at one site, which `write` makes of the coordinates and the gradient by the families `by`.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or derivative has no code; those of `write`.
    pub(super) fn new(
        function: &BodyFunction,
        shape: &BodyShape,
        by: &[usize],
        parameters: usize,
        write: impl FnOnce(&mut Graph, &[Term], &[Term]) -> Result<Vec<(usize, Term)>, BuildError>,
    ) -> Result<Self, BuildError> {
        Self::along(
            function,
            (&CurveOfSites::point(shape), 0),
            by,
            parameters,
            write,
        )
    }

    /// The last coefficient of such results along a curve. Coefficients of the gradient that they need are those from an
    /// order on.
    ///
    /// # Errors
    /// As [`new`](Self::new), and where a function has no series.
    pub(super) fn along(
        function: &BodyFunction,
        (curve, from): (&CurveOfSites, usize),
        by: &[usize],
        parameters: usize,
        write: impl FnOnce(&mut Graph, &[Term], &[Term]) -> Result<Vec<(usize, Term)>, BuildError>,
    ) -> Result<Self, BuildError> {
        let (shape, orders) = (curve.whole(), curve.order + 1);
        let weighted = Weighted::of(function)?;
        let of_sums = weighted.of_sums();
        let weights = match of_sums.is_empty() {
            true => None,
            false => {
                let sums: Vec<&BodySum> = function.sums.iter().collect();
                Some(Arc::new(SumsCode::new(&sums, &of_sums, curve, parameters)?))
            }
        };
        let pair = PairCode::of_gradient((function, &weighted), (curve, from), by, parameters)?;
        let mut families = Vec::new();
        let rows = 2 * shape.families + orders * of_sums.len() + shape.matrices.len();
        let site = SiteCode::new(rows, parameters, |graph, rows| {
            let (x, rest) = rows.split_at(shape.families);
            let (of_pairs, rest) = rest.split_at(shape.families);
            let (weights, diagonals) = rest.split_at(orders * of_sums.len());
            let mut inputs = curve.coordinates(graph, x);
            for (order, own) in inputs.iter_mut().enumerate() {
                let count = curve.shape.families;
                own.extend_from_slice(&of_pairs[order * count..][..count]);
                let count = of_sums.len();
                own.extend_from_slice(&weights[order * count..][..count]);
            }
            curve.add_resting(graph, &mut inputs, diagonals);
            let mut coefficients = curve.coefficients(graph, &inputs, |graph, inputs| {
                let results = at_a_site(&weighted, &curve.shape, by, graph, inputs, write)?;
                let (own, terms) = results.into_iter().unzip();
                families = own;
                Ok(terms)
            })?;
            Ok(coefficients.pop().unwrap_or_default())
        })?;
        let of_pair = pair
            .as_ref()
            .map_or(0, |pair| pair.kernel.step_operations().work());
        let pairs = shape.sites * (shape.sites - 1) / 2;
        Ok(Self {
            weights,
            pair: pair.map(Arc::new),
            work: site.work() * shape.sites as u64 + of_pair * pairs as u64,
            site,
            families,
            shape,
        })
    }

    /// The operations of one evaluation at one point.
    pub(super) fn work(&self) -> u64 {
        self.work
    }
}

/// Linear functions of a gradient at so many points, for fixed parameters.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    code: Arc<SlopesCode>,
    points: usize,
    weights: Option<Sums>,
    tiles: Option<Tiles>,
    site: Workspace,
    /// ∂p summed over pairs, rows of sites and points; the weights, in rows over points and over sites and points.
    of_pairs: Vec<f64>,
    of_points: Vec<f64>,
    spread: Vec<f64>,
    /// J_ii of each matrix, in rows of sites and points.
    diagonals: Vec<f64>,
}

impl Slopes {
    pub(super) fn new(code: &Arc<SlopesCode>, points: usize, parameters: &[f64]) -> Self {
        let shape = &code.shape;
        let weights = code.weights.as_ref();
        let count = weights.map_or(0, |weights| weights.outers);
        let places = shape.sites * points;
        let tiles = |pair| Tiles::new(pair, shape, points, parameters);
        Self {
            points,
            weights: weights.map(|weights| Sums::new(weights, points, parameters)),
            tiles: code.pair.as_ref().map(tiles),
            site: code.site.workspace(parameters),
            of_pairs: vec![0.0; shape.families * places],
            of_points: vec![0.0; count * points],
            spread: vec![0.0; count * places],
            diagonals: diagonals(shape, points),
            code: Arc::clone(code),
        }
    }

    /// The results at points x; families without one have 0.
    pub(super) fn evaluate(&mut self, x: &[f64], out: &mut [f64]) {
        let (code, points) = (&self.code, self.points);
        let places = code.shape.sites * points;
        if let Some(weights) = &mut self.weights {
            weights.evaluate(x, &mut self.of_points);
            let rows = self.spread.chunks_exact_mut(places);
            for (row, own) in rows.zip(self.of_points.chunks_exact(points)) {
                row.chunks_exact_mut(points)
                    .for_each(|to| to.copy_from_slice(own));
            }
        }
        if let Some(tiles) = &mut self.tiles {
            self.of_pairs.fill(0.0);
            tiles.add(x, &self.of_points, &mut self.of_pairs);
        }
        let (of_pairs, spread) = (&self.of_pairs, &self.spread);
        let diagonals = self.diagonals.chunks_exact(places);
        let row = |at: usize| {
            let (x, of_pairs) = (x.chunks_exact(places), of_pairs.chunks_exact(places));
            let rows = x.chain(of_pairs).chain(spread.chunks_exact(places));
            rows.chain(diagonals.clone()).nth(at).unwrap_or(&[])
        };
        out.fill(0.0);
        code.site
            .evaluate(&mut self.site, places, row, |result, place, values| {
                let start = code.families[result] * places + place;
                out[start..][..values.len()].copy_from_slice(values);
            });
    }
}

/// Functions of sums over sites and pairs, evaluated in a loop over pairs.
#[derive(Clone, Debug)]
pub struct BodyObservables {
    sums: Sums,
}

impl BodyObservables {
    /// Compiles functions for values of the parameters.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn new(
        functions: &[BodyFunction],
        shape: &BodyShape,
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let code = SumsCode::of_functions(functions, shape, parameters.len())?;
        Ok(Self {
            sums: Sums::new(&Arc::new(code), 1, parameters),
        })
    }

    /// The same at other values of the parameters.
    #[must_use]
    pub fn at(&self, parameters: &[f64]) -> Self {
        Self {
            sums: Sums::new(&self.sums.code, 1, parameters),
        }
    }

    /// The number of functions.
    pub fn observables(&self) -> usize {
        self.sums.code.outers
    }

    /// Writes their values at a state.
    pub fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        self.sums.evaluate(state, values);
    }
}

impl From<BodyObservables> for Observer {
    fn from(mut own: BodyObservables) -> Self {
        Self::new(own.observables(), move |state, values| {
            own.evaluate(state, values);
        })
    }
}
