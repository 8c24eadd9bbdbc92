//! Shadow energies as numbers: of Strang's product of shears, from products with the Jacobian of the field.

use std::sync::Arc;

use crate::observer::Observer;
use crate::system::OpaqueSystem;

/// Maker of H̃ of a map, of the parameters and of the step t = εh.
pub type MakeShadowEnergy = dyn Fn(&[f64], f64) -> Observer + Send + Sync;

/// Shadow energy of Strang's product of two shears, up to order t⁴.
///
/// ```text
/// H̃ = H − t²/24 D_A²H + t²/12 D_B²H.
/// H̃ = H + t²/12 pᵀ∇²V p/m² − t²/24 |∇V|²/m   with A = V(q), B = |p|²/2m.
/// ```
///
/// The product is φ^A_{t/2} ∘ φ^B_t ∘ φ^A_{t/2}, of shears x + tX(x).
/// D_A²H = X_Aᵀ ∇²H X_A is the second derivative of H along X_A.
/// Source: B. Leimkuhler, S. Reich, *Simulating Hamiltonian dynamics*, Cambridge 2004, section 5.2.
///
/// A gradient and two products with the Jacobian are a few loops over pairs. Brackets written out are sums over triples.
/// `None` where the system offers no such products, or where it has no two shears.
pub fn shadow_of_shears(
    system: &OpaqueSystem,
    [outer, inner]: [usize; 2],
) -> Option<Arc<MakeShadowEnergy>> {
    let numbers = system.numbers.clone();
    let tangent = numbers.field_tangent()?;
    let shears = [outer, inner].map(|at| numbers.shears().get(at).cloned());
    let [Some(outer), Some(inner)] = shears else {
        return None;
    };
    let d = system.variables.len();
    Some(Arc::new(move |parameters, t| {
        let mut evaluator = numbers.evaluator(parameters);
        let mut fields = [&outer, &inner].map(|shear| shear.evaluator(parameters, 1));
        let [mut along, _] = tangent(parameters);
        let [mut gradient, mut changed] = [vec![0.0; d], vec![0.0; d]];
        let mut point = vec![0.0; 2 * d];
        let weights = [-t * t / 24.0, t * t / 12.0];
        Observer::new(1, move |state, values| {
            let mut value = || {
                let mut energy = [0.0];
                evaluator.hamiltonian(state, &mut energy).ok()?;
                evaluator.gradient(state, &mut gradient).ok()?;
                let [energy] = energy;
                let mut total = energy;
                for (field, weight) in fields.iter_mut().zip(weights) {
                    let (x, velocity) = point.split_at_mut(d);
                    x.copy_from_slice(state);
                    field.values(state, velocity).ok()?;
                    along.values(&point, &mut changed).ok()?;
                    // −Π∇²H X_A times ∂H is X_Aᵀ ∇²H X_A with the other sign.
                    let pairs = gradient.iter().zip(&changed);
                    total -= weight * pairs.map(|(slope, change)| slope * change).sum::<f64>();
                }
                Some(total)
            };
            values[0] = value().unwrap_or(f64::NAN);
        })
    }))
}
