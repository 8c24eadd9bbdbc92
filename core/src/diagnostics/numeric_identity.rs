//! Jacobi's identity and Casimirs of systems of numbers, sampled near a state.
//!
//! Derivatives are the system's own; where it offers none they are differences, and the check says how
//! far those can tell.

use super::differences::jacobian_by_differences;
use super::round_off::sizes;
use super::verdict::{IdentityCheck, ROUND_OFF, Verdict, sample_states};
use crate::error::StepError;
use crate::system::numbers::{Derivatives, OpaqueSystem, SystemEvaluator};

/// The largest dimension in which a violation is traced to a triple of coordinates.
const TRACED: usize = 16;

/// {a, {b, c}} + {b, {c, a}} + {c, {a, b}} = 0 for linear functions a, b, c with coefficients of the
/// size that makes every coordinate count alike.
pub(super) fn jacobi(system: &OpaqueSystem, parameters: &[f64], near: &[f64]) -> IdentityCheck {
    let d = near.len();
    let mut bracket = Bracket::new(system, parameters, d);
    let mut check = Check::new(near, !bracket.derivatives.tensor);
    for (sample, state) in sample_states(near).iter().enumerate() {
        let sizes = sizes(state);
        let covectors = [0, 1, 2].map(|which| covector(&sizes, 3 * sample + which));
        if let Ok(terms) = bracket.jacobiator(state, covectors.each_ref().map(Vec::as_slice)) {
            check.take(&terms, state, Vec::new);
        }
    }
    let violated = check.finish();
    if violated.verdict != Verdict::Violated || d > TRACED {
        return violated;
    }
    let mut traced = Check::new(near, !bracket.derivatives.tensor);
    let state = violated.at.clone();
    let unit = |i: usize| (0..d).map(|k| f64::from(u8::from(k == i))).collect();
    let units: Vec<Vec<f64>> = (0..d).map(unit).collect();
    for (i, j, k) in
        (0..d).flat_map(|i| (i + 1..d).flat_map(move |j| (j + 1..d).map(move |k| (i, j, k))))
    {
        if let Ok(terms) = bracket.jacobiator(&state, [&units[i], &units[j], &units[k]]) {
            traced.take(&terms, &state, || vec![i, j, k]);
        }
    }
    match traced.finish() {
        traced if traced.verdict == Verdict::Violated => traced,
        _ => violated,
    }
}

/// Π ∇C = 0 for the Casimir with this index.
pub(super) fn casimir(
    system: &OpaqueSystem,
    index: usize,
    parameters: &[f64],
    near: &[f64],
) -> IdentityCheck {
    let (d, count) = (near.len(), system.casimirs.len());
    let mut evaluator = system.numbers.evaluator_on_trial(parameters);
    let is_exact = system.numbers.derivatives.casimirs;
    let mut check = Check::new(near, !is_exact);
    for state in sample_states(near) {
        let gradient = if is_exact {
            let mut all = vec![0.0; count * d];
            let own = |all: Vec<f64>| (all[index * d..][..d].to_vec(), vec![0.0; d]);
            evaluator
                .casimir_gradients(&state, &mut all)
                .map(|()| own(all))
        } else {
            let mut values = vec![0.0; count];
            let slope = jacobian_by_differences(&state, 1, |at, out| {
                evaluator.casimirs(at, &mut values)?;
                out[0] = values[index];
                Ok(())
            });
            slope.map(|s| (s.jacobian.as_slice().to_vec(), s.error.as_slice().to_vec()))
        };
        let Ok((gradient, error)) = gradient else {
            continue;
        };
        if let Ok(rows) = rows(evaluator.as_mut(), &state, &gradient, &error) {
            let worst = rows.worst;
            check.take(&rows.terms, &state, || vec![worst]);
        }
    }
    check.finish()
}

/// Terms of an identity at a state: their sum, their size, and the error that differences may add.
struct Terms {
    sum: f64,
    size: f64,
    error: f64,
}

/// The worst row of Π ∇C, each in units of its coordinate.
struct Rows {
    terms: Terms,
    worst: usize,
}

/// (Π ∇C)_i, and beside it its scale, the largest |Σ_j ±Π_ij ∂_j C| over choices of signs. Choice k takes the sign of j
/// from bit k of j: any two j differ in a bit, so some choice adds two terms that cancel in (Π ∇C)_i.
fn rows(
    evaluator: &mut dyn SystemEvaluator,
    state: &[f64],
    gradient: &[f64],
    error: &[f64],
) -> Result<Rows, StepError> {
    let d = state.len();
    let sizes = sizes(state);
    let mut image = vec![0.0; d];
    let mut largest = |evaluator: &mut dyn SystemEvaluator, v: &[f64]| {
        evaluator.tensor(state, v, &mut image)?;
        let rows = image.iter().zip(&sizes).map(|(r, s)| r.abs() / s);
        let (worst, size) =
            rows.enumerate().fold(
                (0, 0.0),
                |worst, row| {
                    if row.1 <= worst.1 { worst } else { row }
                },
            );
        Ok::<_, StepError>((worst, size))
    };
    let (worst, sum) = largest(evaluator, gradient)?;
    let (mut size, mut noise) = (sum, 0.0_f64);
    for bit in 0..usize::BITS - d.leading_zeros() {
        let signed = |values: &[f64]| -> Vec<f64> {
            let sign = |j: usize| if j >> bit & 1 == 0 { 1.0 } else { -1.0 };
            values
                .iter()
                .enumerate()
                .map(|(j, v)| sign(j) * v)
                .collect()
        };
        size = size.max(largest(evaluator, &signed(gradient))?.1);
        noise = noise.max(largest(evaluator, &signed(error))?.1);
    }
    Ok(Rows {
        terms: Terms {
            sum,
            size,
            error: 2.0 * noise,
        },
        worst,
    })
}

/// {a, {b, c}} of linear functions.
struct Bracket {
    evaluator: Box<dyn SystemEvaluator>,
    derivatives: Derivatives,
    images: [Vec<f64>; 3],
    slope: Vec<f64>,
    point: Vec<f64>,
}

impl Bracket {
    fn new(system: &OpaqueSystem, parameters: &[f64], d: usize) -> Self {
        Self {
            evaluator: system.numbers.evaluator_on_trial(parameters),
            derivatives: system.numbers.derivatives,
            images: [vec![0.0; d], vec![0.0; d], vec![0.0; d]],
            slope: vec![0.0; d],
            point: vec![0.0; d],
        }
    }

    /// {a, {b, c}} = −b·D(Πc)(Πa) and its cyclic permutations.
    fn jacobiator(&mut self, state: &[f64], covectors: [&[f64]; 3]) -> Result<Terms, StepError> {
        for (covector, image) in covectors.iter().zip(&mut self.images) {
            self.evaluator.tensor(state, covector, image)?;
        }
        let mut terms = Terms {
            sum: 0.0,
            size: 0.0,
            error: 0.0,
        };
        for (a, b, c) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let (term, error) = self.term(state, covectors[b], covectors[c], a)?;
            terms.sum += term;
            terms.size += term.abs();
            terms.error += error;
        }
        terms.sum = terms.sum.abs();
        Ok(terms)
    }

    /// b·D(Πc)w for w an image, and its error.
    fn term(
        &mut self,
        state: &[f64],
        b: &[f64],
        c: &[f64],
        image: usize,
    ) -> Result<(f64, f64), StepError> {
        let direction = &self.images[image];
        let along = |values: &[f64]| b.iter().zip(values).map(|(b, v)| b * v).sum::<f64>();
        if self.derivatives.tensor {
            self.evaluator
                .tensor_tangent(state, c, direction, &mut self.slope)?;
            return Ok((along(&self.slope), 0.0));
        }
        // The longest way along w on which every coordinate moves by its own size at most.
        let reach = sizes(state)
            .iter()
            .zip(direction)
            .filter(|(_, w)| **w != 0.0)
            .map(|(size, w)| size / w.abs())
            .fold(f64::INFINITY, f64::min);
        if !reach.is_finite() {
            return Ok((0.0, 0.0));
        }
        let (evaluator, point, slope) = (&mut self.evaluator, &mut self.point, &mut self.slope);
        let found = jacobian_by_differences(&[0.0], 1, |at, out| {
            for (i, place) in point.iter_mut().enumerate() {
                *place = state[i] + at[0] * reach * direction[i];
            }
            evaluator.tensor(point, c, slope)?;
            out[0] = along(slope);
            Ok(())
        })?;
        Ok((found.jacobian[0] / reach, found.error[0] / reach))
    }
}

/// Deterministic coefficients between ½ and 1 in units of 1/size, of either sign.
pub(super) fn covector(sizes: &[f64], seed: usize) -> Vec<f64> {
    let mut phase = 0.5 + 0.754_877_666_246_692_7 * seed as f64;
    let mut next = move || {
        phase = (phase + 0.618_033_988_749_894_9) % 1.0;
        if phase < 0.5 { phase - 1.0 } else { phase }
    };
    sizes.iter().map(|size| next() / size).collect()
}

/// The worst sample so far.
struct Check {
    check: IdentityCheck,
    floor: f64,
}

impl Check {
    fn new(near: &[f64], by_differences: bool) -> Self {
        Self {
            check: IdentityCheck {
                verdict: Verdict::Undecided,
                residual: 0.0,
                worst: Vec::new(),
                at: near.to_vec(),
                floor: by_differences.then_some(0.0),
            },
            floor: 0.0,
        }
    }

    /// Terms that differences cannot tell from zero are zero.
    fn take(&mut self, terms: &Terms, state: &[f64], worst: impl FnOnce() -> Vec<usize>) {
        if !(terms.sum + terms.size + terms.error).is_finite() {
            return;
        }
        if self.check.verdict == Verdict::Undecided {
            self.check.verdict = Verdict::NumericallyZero;
        }
        if terms.size <= 4.0 * terms.error || terms.size == 0.0 {
            return;
        }
        let (residual, floor) = (terms.sum / terms.size, terms.error / terms.size);
        self.floor = self.floor.max(floor);
        if residual > ROUND_OFF.max(floor) {
            self.check.verdict = Verdict::Violated;
        }
        if residual > self.check.residual {
            self.check.residual = residual;
            self.check.worst = worst();
            self.check.at = state.to_vec();
        }
    }

    fn finish(mut self) -> IdentityCheck {
        self.check.floor = self.check.floor.map(|_| self.floor);
        self.check
    }
}
