//! Results: the learned function, how well it meets the pairs, and where it may be used.

use std::fmt;

use leafwise_core::{Method, Walk};

use crate::basis::Basis;
use crate::fit::{SMALL, corrected, rows_at};
use crate::geometry::Geometry;
use crate::squares::Squares;

/// A row is of another kind than those of the pairs beyond this part of its largest entry.
const STRANGE: f64 = 1e-3;

/// A function of the basis with its coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedFunction {
    /// The function.
    pub formula: String,
    /// Its coefficient in Ŝ/h.
    pub generating: f64,
    /// Its coefficient in H.
    pub hamiltonian: f64,
    /// The standard error of `generating`, from the residuals. Functions of which the pairs tell nothing have none.
    pub generating_error: f64,
    /// The error of `hamiltonian`: the same, and the bound of how far H is found from orbits of the learned map.
    pub error: f64,
    /// Whether the pairs determine the coefficient; 0 stands in its place otherwise.
    pub is_determined: bool,
}

/// Something to know about what was learned.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LearnAdvice {
    /// Pairs that stand more than once.
    Duplicates {
        /// How many were left out.
        count: usize,
    },
    /// A realization that is Poisson to an order only.
    NotExact {
        /// Its description.
        realization: String,
    },
    /// A motion that no generating function of the basis makes.
    Unexplained {
        /// Root mean square of the residual, relative to the motion.
        part: f64,
    },
    /// Pairs whose ends lie on different leaves.
    OffLeaf {
        /// Root mean square of x' − x off the leaves.
        off: f64,
        /// Of the residual along them.
        along: f64,
    },
    /// Functions that no pair tells of, and that are no Casimirs.
    Undetermined {
        /// How many at least.
        count: usize,
    },
    /// Points y that still moved in the last sweep.
    NotConverged {
        /// Sweeps made.
        sweeps: usize,
        /// Root mean square of Φ(x) − x'.
        one_step: f64,
    },
    /// States of the pairs from which no step of the learned map is found.
    Failed {
        /// How many.
        count: usize,
    },
    /// Steps that miss the pairs by more than the fit does.
    Rounding {
        /// Root mean square of Φ(x) − x'.
        one_step: f64,
        /// Root mean square of the fit's residual.
        residual: f64,
    },
    /// Pairs so far apart in time that orbits of the learned map tell H roughly.
    Coarse {
        /// The part of the velocity that is uncertain.
        part: f64,
    },
    /// Too few steps succeed for H: Ŝ/h stands in its place.
    NotRecovered,
}

impl fmt::Display for LearnAdvice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Duplicates { count } => write!(f, "{count} of the pairs occur twice and are counted once"),
            Self::NotExact { realization } => write!(
                f,
                "{realization} is not an exact realization: the learned map is Poisson to its order, not to round-off; name an exact one if there is one"
            ),
            Self::Unexplained { part } => write!(
                f,
                "{:.0} % of the motion is not fitted: the data follow another bracket, or the degree is too low. A wrong sign or time step only scales H",
                100.0 * part
            ),
            Self::OffLeaf { off, along } => write!(
                f,
                "the pairs leave their leaves by {off:.1e} a step, and miss the learned map along them by {along:.1e}: no Hamiltonian of this bracket does that; \
                 look for another bracket, or for forces in the data"
            ),
            Self::Undetermined { count } => write!(
                f,
                "{count} functions are not determined by these pairs and stay 0, such as functions of the leaf where all pairs lie on one leaf: give \
                 pairs from elsewhere, or stay near these"
            ),
            Self::NotConverged { sweeps, one_step } => write!(
                f,
                "the points of the pairs still moved after {sweeps} solves, and steps of the learned map miss the pairs by {one_step:.1e}: pairs of one orbit or one leaf hold \
                 too little information for this degree, or the time between the states is long; give pairs from elsewhere, lower the degree, or penalize coefficients by a ridge"
            ),
            Self::Failed { count } => write!(
                f,
                "from {count} of the states the learned map finds no step: lower the degree, or give pairs that are closer in time"
            ),
            Self::Rounding { one_step, residual } => write!(
                f,
                "steps of the learned map miss the pairs by {one_step:.1e}, and the fit by {residual:.1e}: its formula loses digits; shift and scale the variables, or \
                 lower the degree"
            ),
            Self::Coarse { part } => write!(
                f,
                "H is known to {part:.1e} of its size only: take pairs closer in time; steps of the learned map do not depend on it"
            ),
            Self::NotRecovered => f.write_str(
                "H is not recovered, since too few orbits of the learned map succeed: S/h is given instead, which differs from H by h^2",
            ),
        }
    }
}

/// A generating function Ŝ with ends that meet the pairs, and the Hamiltonian whose flow its map is.
pub struct Learned {
    /// D.
    pub degree: usize,
    /// Degrees that were tried, each with the root mean square of what is left of pairs that were held out.
    pub degrees: Vec<(usize, f64)>,
    /// The functions of the basis.
    pub functions: Vec<LearnedFunction>,
    /// Pairs of a weight above 0, each counted once.
    pub pairs: usize,
    /// Equations: the rank of Π for each pair.
    pub equations: usize,
    /// Coefficients that they determine; Casimirs are not determined.
    pub determined: usize,
    /// Root mean square of a coordinate of x' − x. This and the others over pairs are means by their weights.
    pub motion: f64,
    /// Root mean square of what is left of it along a direction of a leaf.
    pub residual: f64,
    /// The same over the degrees of freedom: the standard deviation of a difference x' − x of mean weight.
    pub noise: f64,
    /// Root mean square of x' − x along a direction off the leaves; `None` where there is none.
    pub off_leaf: Option<f64>,
    /// Root mean square of a coordinate of Φ(x) − x' over the pairs; `None` where no step succeeds.
    pub one_step: Option<f64>,
    /// The standard error of a step along a direction of a leaf, over the pairs.
    pub step_error: f64,
    /// The error of H less its mean, over the pairs: the standard error, and the bound of how far H is found from orbits.
    pub energy_error: f64,
    /// Part of ẋ that differences in time and the basis leave; `None` where H is not recovered.
    pub hamiltonian_error: Option<f64>,
    /// H.
    pub hamiltonian: String,
    /// (Ŝ/h − H)/(εh)², the term S_3 beside S_1 = H; `None` where it is 0.
    pub further: Option<String>,
    /// The largest leverage of a pair; above it the learned map extrapolates.
    pub largest_leverage: f64,
    /// Things to know.
    pub advice: Vec<LearnAdvice>,
    pub(crate) basis: Basis,
    pub(crate) geometry: Geometry,
    pub(crate) squares: Squares,
    pub(crate) h: f64,
    pub(crate) method: Method,
    pub(crate) parameters: Vec<f64>,
    pub(crate) epsilon: f64,
}

impl Learned {
    /// The learned map, at the step of the pairs.
    pub fn method(&self) -> &Method {
        &self.method
    }

    /// Parameters of the system, as values of the map.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// The leverage of a state: the variance of a step from it, in units of the noise, along the worst direction of its leaf. It is infinite
    /// outside of the basis's domain and where a step depends on what no pair tells.
    ///
    /// It is taken at the point y of the learned step, as those of the pairs are; at x itself where no step is found.
    pub fn leverage(&mut self, x: &[f64]) -> f64 {
        let mut walk = Walk::new(&self.method, &self.parameters, self.epsilon, self.h, x);
        match walk.step() {
            Ok(()) => self.leverage_between(x, walk.state()),
            Err(_) => self.leverage_at(x),
        }
    }

    /// The leverage of a state whose step leads to this next one.
    pub fn leverage_between(&mut self, x: &[f64], next: &[f64]) -> f64 {
        let mean: Vec<f64> = (x.iter().zip(next))
            .map(|(a, b)| a / 2.0 + b / 2.0)
            .collect();
        let largest = mean.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let point = corrected(
            &mut self.geometry,
            &self.basis,
            (&mean, &mean),
            &self.squares.solution,
            (self.h, SMALL * largest),
        );
        match point {
            Ok((y, _)) => self.leverage_at(&y),
            Err(_) => self.leverage_at(x),
        }
    }

    /// The variance of the rows at a point y, in units of the noise.
    fn leverage_at(&mut self, y: &[f64]) -> f64 {
        let Some((_, slopes)) = self.basis.values(y) else {
            return f64::INFINITY;
        };
        let Ok(tensor) = self.geometry.tensor(y) else {
            return f64::INFINITY;
        };
        let rows = rows_at(&tensor, &slopes, self.h);
        let mut most = 0.0_f64;
        for row in rows.row_iter() {
            let row: Vec<f64> = row.iter().copied().collect();
            if self.squares.strangeness(&row) > STRANGE {
                return f64::INFINITY;
            }
            most = most.max(self.squares.variance(&row));
        }
        most
    }

    /// The standard error of a step from a state along the worst direction of its leaf.
    pub fn step_error_at(&mut self, x: &[f64]) -> f64 {
        self.noise * libm::sqrt(self.leverage(x))
    }

    /// Functions without a coefficient that would move some state in these ranges. The others are Casimirs.
    pub(crate) fn undetermined(&mut self, ranges: &[(f64, f64)]) -> usize {
        let missing = self.functions.len() - self.determined;
        if missing == 0 {
            return 0;
        }
        // Off the diagonals of the box, where no coordinate is special.
        let part = |i: usize, by: f64| (by + (i + 1) as f64 * 0.618_033_988_749_894_9) % 1.0;
        let is_strange = (0..3).any(|at| {
            let x = ranges.iter().enumerate();
            let x: Vec<f64> = x
                .map(|(i, (least, most))| least + (most - least) * part(i, 0.3 * f64::from(at)))
                .collect();
            self.leverage_at(&x) == f64::INFINITY
        });
        if is_strange { missing } else { 0 }
    }
}
