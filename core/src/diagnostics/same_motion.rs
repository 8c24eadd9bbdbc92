//! Does a function move a system as its Hamiltonian does?

use leafwise_expression::{Arithmetic, Expression, Graph, Polynomial, Rational, Ring, Term};

use super::identity::entry;
use crate::system::SystemFormulas;

/// Products of terms that forming Π ∇(S − H) may take: seconds.
const PRODUCTS: u64 = 1 << 22;

/// Motion that a function S generates otherwise than H.
pub(crate) struct OtherMotion {
    /// S − H.
    pub difference: Expression,
    /// A coordinate with {S − H, x_i} ≠ 0.
    pub coordinate: usize,
}

/// Compares the motions by S and by H: returns S − H and a coordinate that it moves, where S − H is no Casimir. A
/// coordinate moves where {S − H, x_i} is not 0 in the normal form of the exact ring, however small. The form must
/// also be more than the rounding of its own terms at points about the system's reference point. Functions of which
/// the ring knows no relation, as sin 2x and sin x cos x, are alike to round-off. Returns `None` too where the
/// algebra cannot tell.
pub(crate) fn other_motion(system: &SystemFormulas, s: &Expression) -> Option<OtherMotion> {
    let d = system.dimension();
    let mut ring = Ring::limited(d, PRODUCTS);
    let x: Vec<Polynomial> = (0..d).map(|i| ring.variable(i)).collect();
    let formed = |formula: &Expression, ring: &mut Ring| {
        let value = formula.evaluate_in(ring, &mut |_, at| Ok(x[at].clone()));
        value.ok()
    };
    let (own, energy) = (
        formed(s, &mut ring)?,
        formed(system.hamiltonian(), &mut ring)?,
    );
    let one = Rational::one();
    let difference = ring.combine(&[(one.clone(), own), (-one.clone(), energy)]);
    let gradient = ring.gradient(&difference).ok()?;
    for coordinate in 0..d {
        let mut terms = Vec::new();
        for (j, slope) in gradient.iter().enumerate() {
            if slope.is_zero() {
                continue;
            }
            if let Some(entry) = entry(system, &mut ring, &x, coordinate, j).ok()? {
                terms.push((one.clone(), ring.multiply(&entry, slope)));
            }
        }
        let rate = ring.combine(&terms);
        if ring.refusal().is_some() {
            return None;
        }
        if !rate.is_zero() && !is_round_off(system, &ring.formula(&rate))? {
            let difference = ring.formula(&difference);
            return Some(OtherMotion {
                difference,
                coordinate,
            });
        }
    }
    None
}

/// Whether a formula is 0 to the round-off of its terms near the system's reference point.
fn is_round_off(system: &SystemFormulas, formula: &Expression) -> Option<bool> {
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
    let value = formula.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()));
    Some(system.are_zero(&graph, &[value.ok()?]))
}
