//! From pairs to a generating function.

use std::sync::Arc;

use leafwise_core::dynamics::Correction;
use leafwise_core::formulas::FormulaDynamics;
use leafwise_core::part::Dimensions;
use leafwise_core::{Accuracy, Method, PoissonSystem, RealizationData};

use crate::basis::{Basis, BasisAxis, BasisDegree};
use crate::error::LearnError;
use crate::fit::{FitSetting, Fitted, fit, values_at};
use crate::geometry::Geometry;
use crate::learned::{LearnAdvice, Learned, LearnedFunction};
use crate::motion::Orbits;
use crate::pairs::StatePairs;
use crate::validation::held_out;

/// The highest degree.
const MOST_DEGREE: usize = 24;

/// The highest degree, and the most functions, that are tried where no degree is given.
const TRIED_DEGREE: usize = 8;
pub(crate) const TRIED_FUNCTIONS: usize = 200;

/// A lower degree is taken where it leaves at most so many times the least.
const AS_GOOD: f64 = 1.1;

/// States at which the error of H is averaged, and rows of which the leverage is looked at.
const MOST_STATES: usize = 400;

/// A residual off the leaves this many times that along them is no noise.
const OFF: f64 = 10.0;

/// H whose velocities are uncertain by more than this part of them is told to be so.
const COARSE: f64 = 1e-3;

/// Leaves are told apart to this part of the motion.
const LEAVES: f64 = 1e-6;

/// A smaller part of the motion is left by any good fit.
const UNEXPLAINED: f64 = 0.1;

/// Steps of the learned map that miss the pairs by so many times the residual have lost digits.
const LOST: f64 = 10.0;

/// Options of learning: the basis, its degree, and how pairs are met.
#[derive(Clone, Debug)]
pub struct LearnOptions {
    /// Functions of each variable.
    pub axes: Vec<BasisAxis>,
    /// The degree; chosen by pairs that are held out where there is none.
    pub degree: Option<BasisDegree>,
    /// λ of the penalty λ² Σ_j ‖A_j‖² c_j².
    pub ridge: f64,
    /// Whether both states of a pair have errors of one size. Then the states are corrected too: total least squares.
    pub has_noise: bool,
    /// Whether H is found from orbits of the learned map. Otherwise Ŝ/h stands in its place.
    pub finds_hamiltonian: bool,
}

/// Learns Ŝ of the map over a realization that leads from each pair's first state to its second in one step of ε and h.
///
/// The Hamiltonian of the system is not looked at.
///
/// # Errors
/// [`LearnError`] for pairs that determine nothing, and where the realization has no chart.
pub fn learn(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    (epsilon, h): (f64, f64),
    pairs: &StatePairs,
    options: &LearnOptions,
) -> Result<Learned, LearnError> {
    let formulas = system.formulas("learning")?;
    system.without_forces("learning")?;
    let (names, d) = (formulas.variables(), formulas.dimension());
    if pairs.dimension() != d || options.axes.len() != d {
        return Err(LearnError::Shape {
            dimension: d,
            found: 2 * pairs.len() * pairs.dimension(),
        });
    }
    if !(options.ridge.is_finite() && options.ridge >= 0.0) {
        return Err(LearnError::Ridge {
            ridge: options.ridge,
        });
    }
    let setting = FitSetting {
        h,
        ridge: options.ridge,
        has_noise: options.has_noise,
    };
    let mut geometry = Geometry::new(system, realization.as_ref(), epsilon)?;
    let ranges = pairs.ranges();
    let mut fitted_at = |degree: &BasisDegree| -> Result<(Basis, Fitted), LearnError> {
        let basis = Basis::new(&options.axes, &ranges, degree)?;
        let fitted = fit(&mut geometry, pairs, &basis, names, setting)?;
        Ok((basis, fitted))
    };
    let mut degrees = Vec::new();
    let (degree, basis, fitted) = match &options.degree {
        Some(degree) => {
            checked(degree, d)?;
            let (basis, fitted) = fitted_at(degree)?;
            (degree.total(), basis, fitted)
        }
        None => {
            let mut tried = Vec::new();
            for degree in 1..=TRIED_DEGREE {
                let is_first = tried.is_empty();
                let total = BasisDegree::Total(degree);
                let functions = Basis::new(&options.axes, &ranges, &total)?.len();
                if functions > TRIED_FUNCTIONS && !is_first {
                    break;
                }
                let (basis, fitted) = match fitted_at(&total) {
                    Ok(found) => found,
                    Err(LearnError::TooFew { .. }) if !is_first => break,
                    // Casimirs alone, or a motion that no lower degree follows.
                    Err(LearnError::Singular | LearnError::Outside { .. })
                        if degree < TRIED_DEGREE =>
                    {
                        continue;
                    }
                    Err(error) => return Err(error),
                };
                if fitted.right.len() < 2 * functions && !is_first {
                    break;
                }
                if let Some(score) = held_out(&fitted, pairs.len(), options.ridge) {
                    degrees.push((degree, score));
                }
                tried.push((degree, basis, fitted));
            }
            let least = degrees
                .iter()
                .fold(f64::INFINITY, |least, d| least.min(d.1));
            // Below round-off all are as good.
            let floor = f64::EPSILON * 16.0 * largest(pairs);
            let chosen = degrees
                .iter()
                .find(|(_, score)| *score <= AS_GOOD * least + floor);
            let chosen = chosen.map_or(0, |(degree, _)| *degree);
            let at = tried.iter().position(|own| own.0 == chosen).unwrap_or(0);
            if tried.is_empty() {
                return Err(LearnError::Singular);
            }
            tried.swap_remove(at)
        }
    };
    let squares = &fitted.squares;
    let generating = &squares.solution;
    let method = method_of(system, realization, &basis, generating)?;
    let orbits = Orbits::of(
        &method,
        system,
        pairs,
        (epsilon, h),
        options.finds_hamiltonian,
    );
    let kept: Vec<usize> = squares.kept().to_vec();
    let recovered = match options.finds_hamiltonian {
        true => orbits.hamiltonian(
            &mut geometry,
            &basis,
            names,
            (&kept, pairs.len(), fitted.tolerance),
            epsilon,
            setting,
        )?,
        false => None,
    };
    let mut advice = Vec::new();
    if pairs.duplicates() > 0 {
        advice.push(LearnAdvice::Duplicates {
            count: pairs.duplicates(),
        });
    }
    if realization.accuracy() != Accuracy::Exact {
        advice.push(LearnAdvice::NotExact {
            realization: realization.describe(),
        });
    }
    if fitted.residual > UNEXPLAINED * fitted.motion {
        advice.push(LearnAdvice::Unexplained {
            part: fitted.residual / fitted.motion,
        });
    }
    let rounding = f64::EPSILON * 16.0 * largest(pairs);
    if let Some(off) = fitted.off_leaf
        && off > OFF * fitted.residual + rounding
        && off > LEAVES * fitted.motion
        && fitted.has_settled
    {
        advice.push(LearnAdvice::OffLeaf {
            off,
            along: fitted.residual,
        });
    }
    if orbits.failed > 0 {
        advice.push(LearnAdvice::Failed {
            count: orbits.failed,
        });
    }
    let left = libm::hypot(fitted.residual, fitted.off_leaf.unwrap_or(0.0));
    if let Some(one_step) = orbits.one_step
        && !options.has_noise
        && one_step > LOST * (left + rounding)
    {
        advice.push(match fitted.has_settled {
            true => LearnAdvice::Rounding {
                one_step,
                residual: left,
            },
            false => LearnAdvice::NotConverged {
                sweeps: fitted.sweeps,
                one_step,
            },
        });
    }
    match &recovered {
        Some(own) if own.unresolved > COARSE => advice.push(LearnAdvice::Coarse {
            part: own.unresolved,
        }),
        Some(_) => {}
        None if options.finds_hamiltonian => advice.push(LearnAdvice::NotRecovered),
        None => {}
    }
    // The ridge pulls Ŝ, and once more H from its orbits.
    let bias = squares.ridge_bias();
    let uncertainty = match &recovered {
        Some(own) => {
            let sum = own.uncertainty.iter().zip(&bias).map(|(u, b)| u + b);
            squares.least(&sum.collect::<Vec<_>>())
        }
        None => bias.clone(),
    };
    let hamiltonian = match &recovered {
        Some(own) => &squares.least(&own.coefficients),
        None => generating,
    };
    let t = epsilon * h;
    let further: Vec<f64> = generating
        .iter()
        .zip(hamiltonian)
        .map(|(s, h)| (s - h) / (t * t))
        .collect();
    let deviations = squares.deviations();
    let noise = libm::sqrt(fitted.noise);
    let functions = (0..basis.len()).map(|j| LearnedFunction {
        formula: basis.name(j, names),
        generating: basis.unscaled(j, generating[j]),
        hamiltonian: basis.unscaled(j, hamiltonian[j]),
        generating_error: basis.unscaled(j, libm::hypot(noise * deviations[j], bias[j])),
        error: basis.unscaled(j, libm::hypot(noise * deviations[j], uncertainty[j])),
        is_determined: kept.contains(&j),
    });
    let mut learned = Learned {
        degree,
        degrees,
        functions: functions.collect(),
        pairs: pairs.len(),
        equations: fitted.right.len(),
        determined: squares.rank,
        motion: fitted.motion,
        residual: fitted.residual,
        noise,
        off_leaf: fitted.off_leaf,
        one_step: orbits.one_step,
        step_error: libm::hypot(
            noise * libm::sqrt(squares.rank as f64 / fitted.right.len() as f64),
            root_mean_square(&fitted.matrix.times(&bias)),
        ),
        energy_error: energy_error(&basis, &fitted, &uncertainty, pairs, names)?,
        hamiltonian_error: recovered.as_ref().map(|own| own.error),
        hamiltonian: basis.written(hamiltonian, names),
        further: match further.iter().all(|c| *c == 0.0) {
            true => None,
            false => Some(basis.written(&further, names)),
        },
        largest_leverage: largest_leverage(&fitted, pairs),
        advice,
        basis,
        geometry,
        squares: fitted.squares,
        h,
        method,
        parameters: system.parameter_values(),
        epsilon,
    };
    let undetermined = learned.undetermined(&ranges);
    if undetermined > 0 {
        learned.advice.push(LearnAdvice::Undetermined {
            count: undetermined,
        });
    }
    Ok(learned)
}

/// The map with the generating function Ŝ = h Σ c f.
fn method_of(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    basis: &Basis,
    coefficients: &[f64],
) -> Result<Method, LearnError> {
    let hamiltonian = basis.formula(coefficients);
    let formulas = system.formulas("learning")?;
    let learned = formulas.with_hamiltonian(hamiltonian.clone())?.into();
    let dynamics = FormulaDynamics {
        name: "learned",
        order: 2,
        self_adjoint: Some(true),
        correction: Correction::Bisection,
        dimensions: Dimensions {
            least: 1,
            most: None,
        },
        coefficients: vec![hamiltonian],
    };
    Ok(Method::compose(
        &learned,
        Arc::clone(realization),
        Arc::new(dynamics),
    )?)
}

/// The error of H(x) less its mean, over the pairs.
fn energy_error(
    basis: &Basis,
    fitted: &Fitted,
    uncertainty: &[f64],
    pairs: &StatePairs,
    names: &[String],
) -> Result<f64, LearnError> {
    let every = pairs.len().div_ceil(MOST_STATES);
    let mut rows = Vec::new();
    for k in (0..pairs.len()).step_by(every) {
        let values = values_at(basis, pairs.before(k), names, pairs.number(k))?.0;
        rows.push((values, pairs.weight(k)));
    }
    let total: f64 = rows.iter().map(|row| row.1).sum();
    let mut mean = vec![0.0; basis.len()];
    for (row, weight) in &rows {
        mean.iter_mut()
            .zip(row)
            .for_each(|(mean, f)| *mean += f * weight / total);
    }
    let mut sum = 0.0;
    for (row, weight) in &rows {
        let centred: Vec<f64> = row.iter().zip(&mean).map(|(f, mean)| f - mean).collect();
        let variance = fitted.squares.variance(&fitted.squares.least(&centred));
        let found = centred.iter().zip(uncertainty);
        let found: f64 = found.map(|(f, c)| f * c).sum();
        sum += weight * (fitted.noise * variance + found * found);
    }
    Ok(libm::sqrt(sum / total))
}

/// The largest leverage of the pairs' own rows, without their weights: those of any other state have none.
fn largest_leverage(fitted: &Fitted, pairs: &StatePairs) -> f64 {
    let rows = fitted.right.len();
    let every = rows.div_ceil(MOST_STATES);
    let leverages = (0..rows).step_by(every).map(|at| {
        let row: Vec<f64> = (0..fitted.matrix.len())
            .map(|j| fitted.matrix.column(j)[at])
            .collect();
        fitted.squares.variance(&row) / pairs.weight(fitted.pair_of[at])
    });
    leverages.fold(0.0, f64::max)
}

fn root_mean_square(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|v| v * v).sum();
    libm::sqrt(sum / values.len().max(1) as f64)
}

/// A degree of 1 or more, and a number for each variable.
pub(crate) fn checked(degree: &BasisDegree, d: usize) -> Result<(), LearnError> {
    let largest = match degree {
        BasisDegree::Total(degree) => *degree,
        BasisDegree::Each(degrees) => degrees.iter().copied().max().unwrap_or(0),
    };
    if let BasisDegree::Each(degrees) = degree
        && degrees.len() != d
    {
        return Err(LearnError::Degrees {
            found: degrees.len(),
            variables: d,
        });
    }
    match (1..=MOST_DEGREE).contains(&largest) {
        true => Ok(()),
        false => Err(LearnError::Degree {
            degree: largest,
            most: MOST_DEGREE,
        }),
    }
}

fn largest(pairs: &StatePairs) -> f64 {
    let ranges = pairs.ranges();
    let ends = ranges.iter().flat_map(|(least, most)| [*least, *most]);
    ends.fold(0.0, |largest, x| largest.max(x.abs()))
}
