//! End of Karasev's series: the order from which all further terms vanish.
//!
//! Y_{k+1} is made of the hᵏ-coefficient of Π(Y) p. Of a polynomial tensor of degree r every term of it is a product of
//! at most r of Y_1, …, Y_k, whose numbers add up to k. Where Y_k = 0 for n < k ≤ rn + 1, one factor of every later
//! term vanishes, and the series ends at Y_n. So it does where a field acts on velocities and depends on positions
//! alone.

use leafwise_core::SystemFormulas;
use leafwise_expression::bounded::{Bounded, BoundedNumbers};
use leafwise_expression::{Arithmetic, Ring};

use crate::curve::KarasevCurve;

/// Products of terms that the degree of a tensor may take to be known.
const PRODUCTS: u64 = 1 << 14;

/// Beyond this order nothing is looked at.
const LAST: usize = 128;

/// Whether Y_k = 0 for all k > `order`, to round-off at points about the system's reference point. Parameters take
/// other values than the system's own, which may be 0.
pub(crate) fn is_whole(system: &SystemFormulas, order: usize) -> bool {
    match degree(system) {
        Some(0) => true,
        Some(degree) if degree * order < LAST => {
            let points = system.points();
            points
                .iter()
                .all(|x| ends_at(system, x, order, degree * order + 1))
        }
        _ => false,
    }
}

/// The degree of the tensor's entries; `None` where they are no polynomials.
fn degree(system: &SystemFormulas) -> Option<usize> {
    let entries = system.tensor().values();
    if entries.clone().all(|entry| entry.variables().is_empty()) {
        return Some(0);
    }
    let d = system.dimension();
    let mut ring = Ring::limited(d, PRODUCTS);
    let mut largest = 0;
    for entry in entries {
        let value = entry.evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)));
        let value = value.ok()?;
        for (monomial, _) in value.terms() {
            let mut degree = 0;
            for (symbol, exponent) in monomial.factors() {
                let is_power = (*symbol as usize) < d;
                degree += usize::try_from(*exponent).ok().filter(|_| is_power)?;
            }
            largest = largest.max(degree);
        }
    }
    ring.refusal().is_none().then_some(largest)
}

/// Whether Y_k has no digit at x, for a p of no special value, from k = `order` + 1 to `last`.
fn ends_at(system: &SystemFormulas, x: &[f64], order: usize, last: usize) -> bool {
    let mut phase = 0.25_f64;
    let mut next = || {
        phase = (phase + 0.618_033_988_749_894_9) % 1.0;
        Bounded::exact(0.5 + phase)
    };
    let parameters = system.parameter_values();
    let parameters = parameters.iter().map(|value| value + next().value);
    let mut numbers = BoundedNumbers {
        parameters: parameters.collect(),
    };
    let p: Vec<Bounded> = x.iter().map(|_| next()).collect();
    let zero = vec![Bounded::exact(0.0); x.len()];
    let x: Vec<Bounded> = x.iter().map(|x| Bounded::exact(*x)).collect();
    let Ok(mut curve) = KarasevCurve::new(system, &x) else {
        return false;
    };
    for k in 0..last {
        if curve
            .push(&mut numbers, if k == 0 { &p } else { &zero })
            .is_err()
        {
            return false;
        }
        let mut values = curve.last().iter().flatten();
        let is_zero = |value: &Bounded| value.value.abs() <= value.error && value.error.is_finite();
        if k + 1 > order && !values.all(is_zero) {
            return false;
        }
    }
    true
}
