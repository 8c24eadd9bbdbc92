//! The motion of one coordinate under a piece, found by its Lie series.

use std::collections::BTreeSet;

use leafwise_expression::algebra::{quotient, square_root};
use leafwise_expression::{AlgebraError, Arithmetic, Polynomial, Rational, Ring};

use crate::field::{Field, variables};
use crate::probe::{LONGEST, Probe};

/// A Lie series whose terms have more monomials than this is not going to end.
const MOST_MONOMIALS: usize = 256;

/// x_i(t) − x_i under ẋ = X(x), with D f = Σ_j X^j ∂_j f.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Σ_k tᵏ/k! v_k: the Lie series ends. v_1, v_2, …; none where x_i rests.
    Polynomial(Vec<Polynomial>),
    /// w (e^{tφ} − 1): v = Dx_i = φw, Dv = φv, Dφ = 0. Lotka–Volterra, with w = x_i.
    Exponential {
        /// w.
        base: Polynomial,
        /// φ.
        rate: Polynomial,
    },
    /// t v φ₁(tφ), the same where φ does not divide v.
    Affine {
        /// v.
        velocity: Polynomial,
        /// φ.
        rate: Polynomial,
    },
    /// w sin(ωt) + u (1 − cos ωt): v = Dx_i = ωw, a = Dv = ω²u, Da = −ω²v, Dω = 0. One rounded angle
    /// serves sine and cosine, so that rounding does not stretch: |x|² on so(3)* drifted by
    /// 2.5e-17 a step where sin(ωt)/ω was multiplied by v.
    Rotation {
        /// ω.
        frequency: Polynomial,
        /// w.
        sine: Polynomial,
        /// u.
        versine: Polynomial,
    },
    /// t v c₁(t²λ) + t² a c₂(t²λ): v = Dx_i, a = Dv, Da = −λv, Dλ = 0, where λ is no square or does
    /// not divide.
    Oscillation {
        /// v.
        velocity: Polynomial,
        /// a.
        acceleration: Polynomial,
        /// λ, the square of the frequency; negative for hyperbolic motions.
        square: Polynomial,
    },
}

/// A coordinate's motion and what it was concluded from.
#[derive(Clone, Debug)]
pub struct CoordinateFlow {
    /// The motion.
    pub motion: Motion,
    /// The variables whose velocity was read. The motion stays what it is when the field changes
    /// along other variables.
    pub reads: BTreeSet<usize>,
}

/// The motion of x_i under the field X. It is `None` where it is none of [`Motion`], or where it leaves its piece of X.
/// Exact algebra does not look for motions that the numbers at `probe` rule out.
///
/// # Errors
/// [`AlgebraError`] where a derivative does not exist.
pub fn coordinate_flow(
    ring: &mut Ring,
    probe: &Probe,
    field: &Field,
    index: usize,
) -> Result<Option<CoordinateFlow>, AlgebraError> {
    let mut reads = BTreeSet::from([index]);
    let mut series: Vec<Polynomial> = Vec::new();
    let mut next = field.get(&index).cloned().unwrap_or_else(Polynomial::zero);
    while !next.is_zero() {
        series.push(next);
        if let Some(motion) = closed_form(ring, field, &series, &mut reads)? {
            return within_piece(ring, field, &series, CoordinateFlow { motion, reads });
        }
        let last = &series[series.len() - 1];
        if rests(ring, field, last) {
            reads.extend(variables(ring, last));
            break;
        }
        if series.len() > LONGEST || last.terms().len() > MOST_MONOMIALS {
            return Ok(None);
        }
        if series.len() == 2 && probe.rules_out(ring, field, index) {
            return Ok(None);
        }
        next = lie_derivative(ring, field, last, &mut reads)?;
    }
    let motion = Motion::Polynomial(series.clone());
    within_piece(ring, field, &series, CoordinateFlow { motion, reads })
}

/// Whether no variable of f moves under the field: Df = 0, however long f is.
fn rests(ring: &Ring, field: &Field, f: &Polynomial) -> bool {
    let moves = |at: &usize| field.get(at).is_some_and(|velocity| !velocity.is_zero());
    !variables(ring, f).iter().any(moves)
}

/// The flow, unless a seam of its Lie series moves under it.
fn within_piece(
    ring: &mut Ring,
    field: &Field,
    series: &[Polynomial],
    mut flow: CoordinateFlow,
) -> Result<Option<CoordinateFlow>, AlgebraError> {
    let crossed = crossed_seam(ring, field, series, &mut flow.reads)?;
    Ok(crossed.is_none().then_some(flow))
}

/// The first seam of these terms that moves under the field, by the formula that decides of the piece.
pub(crate) fn crossed_seam(
    ring: &mut Ring,
    field: &Field,
    terms: &[Polynomial],
    reads: &mut BTreeSet<usize>,
) -> Result<Option<Polynomial>, AlgebraError> {
    for term in terms {
        for seam in ring.seams(term) {
            if !lie_derivative(ring, field, &seam, reads)?.is_zero() {
                return Ok(Some(seam));
            }
        }
    }
    Ok(None)
}

/// The closed form that the last term of a Lie series reveals: φ at the second, λ at the third.
fn closed_form(
    ring: &mut Ring,
    field: &Field,
    series: &[Polynomial],
    reads: &mut BTreeSet<usize>,
) -> Result<Option<Motion>, AlgebraError> {
    let (velocity, ratio) = match series {
        [velocity, acceleration] => (velocity, quotient(acceleration, velocity)),
        [velocity, _, third] => (velocity, quotient(third, velocity)),
        _ => return Ok(None),
    };
    let Some(ratio) = ratio else {
        return Ok(None);
    };
    if !lie_derivative(ring, field, &ratio, reads)?.is_zero() {
        return Ok(None);
    }
    Ok(Some(match series {
        [_, acceleration, _] => oscillation(velocity, acceleration, &ring.negate(&ratio)),
        _ => match quotient(velocity, &ratio) {
            Some(base) => Motion::Exponential { base, rate: ratio },
            None => Motion::Affine {
                velocity: velocity.clone(),
                rate: ratio,
            },
        },
    }))
}

fn oscillation(velocity: &Polynomial, acceleration: &Polynomial, square: &Polynomial) -> Motion {
    let rotation = || {
        let frequency = square_root(square)?;
        Some(Motion::Rotation {
            sine: quotient(velocity, &frequency)?,
            versine: quotient(acceleration, square)?,
            frequency,
        })
    };
    rotation().unwrap_or_else(|| Motion::Oscillation {
        velocity: velocity.clone(),
        acceleration: acceleration.clone(),
        square: square.clone(),
    })
}

/// D f = Σ_j X^j ∂_j f over the variables that f depends on, which are noted in `reads`.
pub(crate) fn lie_derivative(
    ring: &mut Ring,
    field: &Field,
    f: &Polynomial,
    reads: &mut BTreeSet<usize>,
) -> Result<Polynomial, AlgebraError> {
    let mut parts = Vec::new();
    for variable in variables(ring, f) {
        reads.insert(variable);
        if let Some(velocity) = field.get(&variable).filter(|v| !v.is_zero()) {
            let derivative = ring.derivative(f, variable)?;
            parts.push((Rational::one(), ring.multiply(velocity, &derivative)));
        }
    }
    Ok(ring.combine(&parts))
}
