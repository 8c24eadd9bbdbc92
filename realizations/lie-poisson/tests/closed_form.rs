//! The closed form in code beside the partial fractions in numbers.

use crate::common::{ALGEBRAS, algebra};
use leafwise_core::{Evaluator, RealizationData, StepError, realization_evaluator};
use leafwise_karasev::CollocatedKarasev;
use leafwise_lie_poisson::LiePoisson;
use leafwise_lie_poisson::evaluator::LiePoissonEvaluator;
use leafwise_lie_poisson::structure::StructureConstants;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use proptest::collection::vec;
use proptest::prelude::*;

/// The one of [`ALGEBRAS`] with four roots.
const WITHOUT_CODE: &str = "so5";

#[test]
fn algebras_with_at_most_two_roots_a_coordinate_have_code() {
    for name in ALGEBRAS {
        let realization = LiePoisson::new(&algebra(name)).expect("a linear tensor");
        assert_eq!(
            realization.abilities().code().is_some(),
            name != WITHOUT_CODE,
            "{name}"
        );
    }
}

/// Offset and increment of the ends, and their tangents.
fn values(evaluator: &mut dyn Evaluator, z: &[f64]) -> Result<[Vec<f64>; 2], StepError> {
    let d = z.len() / 2;
    let (mut ends, mut tangents) = (vec![0.0; 3 * d], vec![0.0; 4 * d * d]);
    evaluator.values(z, &mut ends)?;
    evaluator.jacobians(z, &mut tangents)?;
    Ok([ends.split_off(d), tangents])
}

proptest! {
    /// Two evaluations that share the structure constants alone. At 0.9 of the chart's radius a
    /// double pole has the relative condition 2·0.81/(1 − 0.81) < 9 and its slope one of 13; 32 are
    /// the roundings of W, of a dozen fractions and of six doublings. Where eigenvalues are large and
    /// real, summands are of the size of ‖Z‖‖x‖.
    #[test]
    fn code_and_numbers_agree(
        name in proptest::sample::select(
            ALGEBRAS.into_iter().filter(|name| *name != WITHOUT_CODE).collect::<Vec<_>>(),
        ),
        x in vec(-2.0..2.0_f64, 6),
        p in vec(-6.0..6.0_f64, 6),
        scale in 0.0..1.0_f64,
    ) {
        let system = algebra(name);
        let d = system.dimension();
        let parameters = system.parameter_values();
        let realization = LiePoisson::new(&system).expect("a linear tensor");
        let structure = StructureConstants::new(system.expressions().expect("formulas")).expect("a linear tensor");
        let mut code = realization_evaluator(&realization, &parameters, 1.0).expect("code");
        let mut numbers = LiePoissonEvaluator::new(structure.at(&parameters), 1.0);
        let full = [&x[..d], &p[..d]].concat();
        let scale = match values(&mut numbers, &full) {
            Err(StepError::LeftChart { ratio }) => 0.9 * scale / ratio,
            _ => scale,
        };
        let p: Vec<f64> = p[..d].iter().map(|p| scale * p).collect();
        let z = [&x[..d], &p[..]].concat();
        let expected = values(&mut numbers, &z).expect("inside");
        let found = values(code.as_mut(), &z).expect("inside");
        let norm = largest(p.iter().copied()) * d as f64;
        let summand = largest(x.iter().copied()) * (1.0 + norm);
        for i in 0..2 {
            let size = largest(expected[i].iter().copied()).max(summand);
            let bound = [9.0, 13.0][i] * 32.0 * UNIT_ROUNDOFF * size;
            let error = distance(&found[i], &expected[i]);
            prop_assert!(error <= bound, "{name}: {error:e} > {bound:e}");
        }
    }
}

/// The Hessian of λ·α beside that of the collocated curve, differentiated through its equations: a
/// dozen nodes represent it to round-off while |Im λ(Z)| stays below 2π/3.
#[test]
fn second_derivatives_are_those_of_the_curve() {
    for name in ALGEBRAS {
        let system = algebra(name);
        let d = system.dimension();
        let parameters = system.parameter_values();
        let numbers = |k: f64, scale: f64| -> Vec<f64> {
            (0..d)
                .map(|i| scale * libm::sin(1.0 + k * i as f64))
                .collect()
        };
        let z = [numbers(2.3, 1.0), numbers(1.7, 0.5)].concat();
        let covector = numbers(3.1, 1.0);
        let formulas = system.expressions().expect("formulas");
        let structure = StructureConstants::new(formulas).expect("a linear tensor");
        let collocated = CollocatedKarasev::new(&system, Some(12)).expect("code");
        let mut evaluators: [Box<dyn Evaluator>; 2] = [
            Box::new(LiePoissonEvaluator::new(structure.at(&parameters), 0.9)),
            realization_evaluator(&collocated, &parameters, 0.9).expect("numbers"),
        ];
        let hessians = evaluators.each_mut().map(|evaluator| {
            let mut hessian = vec![0.0; 4 * d * d];
            evaluator
                .hessian(&z, &covector, &mut hessian)
                .expect("second derivatives");
            hessian
        });
        let size = largest(hessians[0].iter().copied());
        let error = distance(&hessians[0], &hessians[1]) / size;
        assert!(
            error <= 64.0 * d as f64 * UNIT_ROUNDOFF,
            "{name}: {error:e}"
        );
    }
}
