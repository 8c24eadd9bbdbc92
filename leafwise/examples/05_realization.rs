//! A realization of your own as a part: one closed form, and scenes can name it.
//!
//! For {x, y} = f(z) the map α = x − ½ ε Π(x) p, with β = α at −p, is exact. Code, lattices and the
//! series of the generating function follow from it; `docs/design/closed-forms.md` says how.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use std::sync::Arc;

use leafwise::core::diagnostics::TensorDefect;
use leafwise::core::part::{PartInfo, PartKind};
use leafwise::core::registry::RealizationPart;
use leafwise::core::{
    BuildError, ChartPoint, ClosedForm, ClosedRealization, Origin, SystemFormulas,
};
use leafwise::expression::{AlgebraError, Arithmetic, Rational};
use leafwise::prelude::*;

#[derive(Clone, Debug)]
struct Transverse(SystemFormulas);

impl ClosedForm for Transverse {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn source<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        let mut source = self.0.apply_tensor(algebra, at.x, at.p)?;
        for (moved, x) in source.iter_mut().zip(at.x) {
            let by = algebra.multiply(at.epsilon, moved);
            *moved = algebra.combine(&[(Rational::one(), x.clone()), (Rational::new(-1, 2), by)]);
        }
        Ok(source)
    }
}

static INFO: PartInfo = PartInfo {
    name: "transverse",
    summary: "x -+ (1/2) epsilon Pi(x) p, for {x, y} = f(z)",
    ..PartInfo::of(PartKind::Realization)
};

fn realize(system: &PoissonSystem) -> Result<ClosedRealization<Transverse>, BuildError> {
    let formulas = system.formulas(INFO.name)?.clone();
    for (pair, f) in formulas.tensor() {
        if *pair != (0, 1) || f.variables().iter().any(|at| *at < 2) {
            let reason = "it is not {x, y} = f(z)".to_owned();
            return Err(BuildError::DoesNotFit {
                part: INFO.name,
                reason,
            });
        }
    }
    ClosedRealization::new(INFO.name, Transverse(formulas))
}

const SCENE: &str = r#"
    system = { variables = ["x", "y", "z"], bracket = { "x,y" = "2 + sin(z)" }, hamiltonian = "x^2 + y^4 + x*z" }
    method = { realization = "transverse", dynamics = "hamilton-jacobi", time-step = 0.05 }
    run    = { initial = [1, 0.5, 0.3], steps = 200 }
"#;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut registry = Registry::with_builtin();
    let part = RealizationPart::new(&INFO, |system, _| Ok(Arc::new(realize(system)?)));
    registry.register(part.into(), Origin::built_in("example", "0.1.0"))?;

    let document = SceneDocument::parse("transverse", SCENE, &registry)?;
    let run = compose(&document, &registry)?;
    let mut instrument = TensorDefect::new(&run.system, run.method.map(), &[], 1.0, 0.05)?;
    let defect = instrument.measure(&run.plan.initial)?.norm;
    println!("DΦ Π DΦᵀ − Π∘Φ of one step is {defect:.1e}");
    assert!(defect < 1e-14);
    Ok(())
}
