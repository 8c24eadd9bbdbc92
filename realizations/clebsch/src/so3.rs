//! The part `clebsch`: so(3)*.

use std::sync::Arc;

use leafwise_core::lift::{End, Lift};
use leafwise_core::part::{PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    BuildError, LiftedRealization, PoissonSystem, RealizationData, StepError, SystemFormulas,
};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Expression, Graph, Polynomial, Ring, Term};
use leafwise_so3::tensor::RotationTensor;

use crate::hopf::{change, grown, image, image_of, pull_back, section, slopes_of};

static INFO: PartInfo = PartInfo {
    name: "clebsch",
    summary: "Hopf's map of C^2 as coordinates of constant brackets, for so(3)*",
    declares: "exact; self-adjoint",
    domain: "{x1,x2} = -a x3 cyclic with constant a of either sign, with the dynamics `collective`; all points",
    literature: "R. McLachlan, K. Modin, O. Verdier, Collective symplectic integrators, Nonlinearity 27 (2014); \
                 J. E. Marsden, A. Weinstein, Coadjoint orbits, vortices, and Clebsch variables for incompressible \
                 fluids, Physica D 7 (1983)",
    ..PartInfo::of(PartKind::Realization)
};

/// J: (ℝ⁴, {q_a, p_b} = −λδ_ab) → so(3)*.
///
/// The motion of z is that of H − μ|x|², which moves x alike: with μ in the middle of the extreme coefficients of the
/// x_i² in H the turn along fibres is slow.
#[derive(Clone, Debug)]
pub struct So3Clebsch {
    tensor: RotationTensor,
}

/// A base point is taken over from the step before where J of it is within this part of |x|.
const NEAR: f64 = 1e-8;

impl So3Clebsch {
    /// The coordinates of a system's tensor.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] when the tensor is not a constant multiple of that of so(3)*.
    pub fn realize(system: &PoissonSystem) -> Result<LiftedRealization, BuildError> {
        let tensor = RotationTensor::new(INFO.name, system)?;
        Ok(LiftedRealization::new(INFO.name, 3, Self { tensor }))
    }
}

impl Lift for So3Clebsch {
    fn dimension(&self) -> usize {
        4
    }

    fn base_dimension(&self) -> usize {
        4
    }

    fn follows(&self) -> bool {
        true
    }

    /// The z that the step before has come to, moved to the fibre of x across the fibres: DJ DJᵀ = |z|²/4. A section
    /// where there is none.
    fn place(
        &self,
        x: &[f64],
        low: &[f64],
        before: Option<End<'_>>,
        base: &mut [f64],
    ) -> Result<(), StepError> {
        let size = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        if let Some(End { z, base: from }) = before {
            for (base, (z, from)) in base.iter_mut().zip(z.iter().zip(from)) {
                *base = from + z;
            }
            let found = image_of(base);
            let rest: [f64; 3] = std::array::from_fn(|i| (x[i] - found[i]) + low[i]);
            let square: f64 = base.iter().map(|z| z * z).sum();
            if square > 0.0 && rest.iter().all(|rest| rest.abs() <= NEAR * size) {
                let slopes = slopes_of(base);
                for (a, z) in base.iter_mut().enumerate() {
                    let moved: f64 = (0..3).map(|i| slopes[i][a] * rest[i]).sum();
                    *z += 4.0 * moved / square;
                }
                return Ok(());
            }
        }
        base.copy_from_slice(&section(x));
        Ok(())
    }

    /// A change of z by |z| is one of x by |x|.
    fn sizes(&self, base: &[f64], sizes: &mut [f64]) {
        sizes.fill(base.iter().fold(0.0_f64, |most, z| most.max(z.abs())));
    }

    /// q̇ = λ∂K/∂p, ṗ = −λ∂K/∂q for K = (H − μ|x|²)∘J.
    fn field(
        &self,
        system: &SystemFormulas,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let pairs = base.iter().zip(z);
        let z: Vec<Term> = pairs.map(|(base, z)| graph.add(base, z)).collect();
        let x = image(graph, &z);
        let slower = slower_on_fibres(system)?;
        let w = slower.as_ref().unwrap_or(system).gradient_at(graph, &x)?;
        let slopes = pull_back(graph, &z, &w);
        let mut ring = Ring::new(3);
        let factor = self.tensor.factor(&mut ring)?;
        let one = graph.one();
        let factor = lift(graph, &ring, &[vec![(one, factor)]], &[])?.remove(0);
        let [q, p] = [&slopes[..2], &slopes[2..]];
        let mut field: Vec<Term> = p
            .iter()
            .map(|slope| graph.multiply(&factor, slope))
            .collect();
        for slope in q {
            let product = graph.multiply(&factor, slope);
            field.push(graph.negate(&product));
        }
        Ok(field)
    }

    fn increment(
        &self,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        Ok(change(graph, base, z))
    }

    /// DJᵀ(DJ DJᵀ)⁻¹ = 4DJᵀ/|z|².
    fn slopes_of_base(&self, base: &[f64], slopes: &mut [f64]) {
        let square: f64 = base.iter().map(|z| z * z).sum();
        let rows = slopes_of(base);
        for (a, out) in slopes.chunks_exact_mut(3).enumerate() {
            for (i, out) in out.iter_mut().enumerate() {
                *out = 4.0 * rows[i][a] / square;
            }
        }
    }

    /// |x|² is constant along the motion and along a Gauss method's steps but for rounding, whose mean would show: what it
    /// adds, at most some 1e-16 of |x|², is taken off along x.
    fn hold(&self, x: &[f64], low: &[f64], increment: &mut [f64]) {
        let square: f64 = x.iter().map(|x| x * x).sum();
        if square > 0.0 {
            let part = 0.5 * grown(x, low, increment) / square;
            for (change, x) in increment.iter_mut().zip(x) {
                *change -= part * (x + *change);
            }
        }
    }
}

/// The system of H − μ|x|² with μ the mean of the smallest and the largest coefficient of an x_i² in H, at the parameters'
/// values; `None` where H is no polynomial or μ is 0.
fn slower_on_fibres(system: &SystemFormulas) -> Result<Option<SystemFormulas>, BuildError> {
    let mut ring = Ring::new(3);
    let hamiltonian = system.hamiltonian();
    let polynomial =
        hamiltonian.evaluate_in(&mut ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)));
    let Ok(polynomial) = polynomial else {
        return Ok(None);
    };
    let values = system.parameter_values();
    let mut found: Vec<(f64, Polynomial)> = Vec::new();
    let mut spin = Polynomial::zero();
    for i in 0..3 {
        let x = ring.variable(i);
        let square = ring.multiply(&x, &x);
        let [(monomial, _)] = square.terms() else {
            return Ok(None);
        };
        let own = polynomial.terms().iter().find(|(m, _)| m == monomial);
        let own = own.map_or_else(Polynomial::zero, |(_, c)| Polynomial::constant(c.clone()));
        let value = match own.as_constant() {
            None => 0.0,
            Some(c) => ring.coefficient_formula(&c).evaluate(&[], &values),
        };
        found.push((value, own));
        spin = ring.add(&spin, &square);
    }
    if !found.iter().all(|(value, _)| value.is_finite()) {
        return Ok(None);
    }
    found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let ends = ring.add(&found[0].1, &found[2].1);
    let mean = ring.scale(&leafwise_expression::Rational::new(1, 2), &ends);
    if mean.is_zero() {
        return Ok(None);
    }
    let taken = ring.multiply(&mean, &spin);
    let rest = ring.subtract(&polynomial, &taken);
    if ring.refusal().is_some() {
        return Ok(None);
    }
    let rest: Expression = ring.formula(&rest);
    Ok(Some(system.with_hamiltonian(rest)?))
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(So3Clebsch::realize(system)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
