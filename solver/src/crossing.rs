//! Where a step crosses a zero of a denominator: a pole of the equations of motion, or none.
//!
//! On the straight way from x to x + Δ a denominator D vanishes at x + zΔ. Let f(δ) be a component of the field at
//! x + (z ± δ)Δ. A pole of order p has f ~ δ^(−p), so f(2^(−k−10))/f(2^(−k)) → 2^(10p). Components that have no pole
//! there stay bounded, such as those of sin(q)/q, q/√(q²) or (1 − cos q)/q². The force |q|^(−1/2) of |q|^(1/2) has
//! the ratio 2⁵. The flow crosses in both cases. The ratio's limit is 2^(20/3), its numerator is taken less its
//! rounding error and its denominator with it, so that rounding makes no pole.

use leafwise_expression::bounded::{Bounded, BoundedNumbers};
use leafwise_expression::{Graph, Term};

/// The distances δ.
const DISTANCES: [f64; 4] = [
    1.0 / (1_u64 << 10) as f64,
    1.0 / (1_u64 << 20) as f64,
    1.0 / (1_u64 << 30) as f64,
    1.0 / (1_u64 << 40) as f64,
];

/// 2^(20/3), the growth from one distance to the next of δ^(−2/3).
const GROWTH: f64 = 101.6;

/// Halvings that bring the zero below 2⁻⁵² of the step.
const HALVINGS: usize = 52;

/// Parts of a step at which denominators are looked at: those affine in x change their sign once at most.
pub fn looks(graph: &Graph, denominators: &[Term]) -> &'static [f64] {
    match graph.is_affine(denominators) {
        true => &[0.0, 1.0],
        false => &[0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0],
    }
}

/// A step within which a denominator changes its sign.
pub struct Crossing<'a> {
    /// The code of field and denominator, over inputs x.
    pub graph: &'a Graph,
    /// ẋ, d terms.
    pub field: &'a [Term],
    /// The denominator.
    pub denominator: &'a Term,
    /// Values of the parameters.
    pub parameters: Vec<f64>,
    /// x.
    pub start: Vec<f64>,
    /// Δ.
    pub increment: Vec<f64>,
}

impl Crossing<'_> {
    /// Whether the field has a pole where the denominator changes its sign between two parts of the step.
    pub fn is_pole(&self, between: (f64, f64)) -> bool {
        let zero = self.zero(between);
        let side = |sign: f64| DISTANCES.map(|distance| self.field_at(zero + sign * distance));
        let (left, right) = (side(-1.0), side(1.0));
        let pairs = 0..DISTANCES.len() - 1;
        pairs.into_iter().any(|pair| {
            (0..self.field.len()).any(|at| {
                let grows =
                    |side: &[Vec<Bounded>]| grows(side[pair].get(at), side[pair + 1].get(at));
                match (grows(&left), grows(&right)) {
                    (Some(left), Some(right)) => left && right,
                    (left, right) => left.or(right) == Some(true),
                }
            })
        })
    }

    fn zero(&self, (mut low, mut high): (f64, f64)) -> f64 {
        let is_negative = |part: f64| {
            let values = self.values(std::slice::from_ref(self.denominator), part);
            values.first().is_some_and(|value| value.value < 0.0)
        };
        let at_low = is_negative(low);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match is_negative(middle) == at_low {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }

    fn field_at(&self, part: f64) -> Vec<Bounded> {
        self.values(self.field, part)
    }

    /// Empty where a formula has no value.
    fn values(&self, terms: &[Term], part: f64) -> Vec<Bounded> {
        let way = self.start.iter().zip(&self.increment);
        let x: Vec<f64> = way.map(|(x, change)| x + part * change).collect();
        let parameters = self.parameters.clone();
        BoundedNumbers { parameters }
            .values(self.graph, terms, &x)
            .unwrap_or_default()
    }
}

/// Whether a component grows like a pole from one distance to the next; `None` where a side has no value.
fn grows(far: Option<&Bounded>, near: Option<&Bounded>) -> Option<bool> {
    let (far, near) = (far?, near?);
    if near.value.is_infinite() {
        return Some(true);
    }
    let most = far.value.abs() + far.error;
    let least = near.value.abs() - near.error;
    (most.is_finite() && least.is_finite()).then_some(least > GROWTH * most)
}
