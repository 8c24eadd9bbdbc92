//! A realization with a closed form, as `docs/design/closed-forms.md` adds one, is one like any other.

use std::sync::Arc;

use leafwise::core::{PoissonSystem, RealizationData};
use leafwise_realization_claims::realizations::{dual_pair_error, inversion_and_section_error};
use leafwise_realization_claims::steps::{is_even_order, measured_order, method, structure_error};
use leafwise_realization_claims::systems::{from_formulas, library};
use proptest::collection::vec;
use proptest::prelude::*;

mod form {
    use leafwise_core::{
        BuildError, ChartPoint, ClosedForm, ClosedRealization, PoissonSystem, SystemFormulas,
    };
    use leafwise_expression::{AlgebraError, Arithmetic, Rational};

    /// α_ε = x − ½ ε Π(x) p.
    #[derive(Clone, Debug)]
    pub struct Transverse {
        system: SystemFormulas,
    }

    impl ClosedForm for Transverse {
        fn dimension(&self) -> usize {
            self.system.dimension()
        }

        fn source<A: Arithmetic>(
            &self,
            algebra: &mut A,
            at: &ChartPoint<'_, A::Element>,
        ) -> Result<Vec<A::Element>, AlgebraError> {
            let rows = self.system.apply_tensor(algebra, at.x, at.p)?;
            let mut source = Vec::with_capacity(rows.len());
            for (x, row) in at.x.iter().zip(&rows) {
                let row = algebra.multiply(at.epsilon, row);
                source.push(
                    algebra.combine(&[(Rational::one(), x.clone()), (Rational::new(-1, 2), row)]),
                );
            }
            Ok(source)
        }
    }

    /// Refuses a tensor that does not fit: that is the form's own knowledge.
    pub fn realize(system: &PoissonSystem) -> Result<ClosedRealization<Transverse>, BuildError> {
        let system = system.formulas("transverse")?.clone();
        let tensor = system.tensor();
        for (&(i, j), entry) in tensor {
            let moves = |at: &usize| tensor.keys().any(|(a, b)| a == at || b == at);
            if let Some(at) = entry.variables().into_iter().find(moves) {
                let [x, y, z] = [i, j, at].map(|at| &system.variables()[at]);
                return Err(BuildError::DoesNotFit {
                    part: "transverse",
                    reason: format!("{{{x}, {y}}} depends on {z}, whose brackets do not vanish"),
                });
            }
        }
        ClosedRealization::new("transverse", Transverse { system })
    }
}

/// {x, y} = f(z) and a second pair over the same z; f is no polynomial.
fn twisted() -> PoissonSystem {
    from_formulas(
        &["x", "y", "z", "u", "v"],
        &[("a", 0.6)],
        &[
            ("x", "y", "a*sin(z) + 2"),
            ("u", "v", "-z^2"),
            ("x", "v", "exp(-z)"),
        ],
        "(x^2 + y^2 + u^2 + v^2)/2 + x*u*z/5 + y^4/8 + cos(v)",
        &["z"],
    )
}

fn data(system: &PoissonSystem) -> Arc<dyn RealizationData> {
    Arc::new(form::realize(system).expect("it fits"))
}

proptest! {
    #[test]
    fn its_maps_are_a_dual_pair(
        x in vec(-2.0..2.0_f64, 5),
        p in vec(-3.0..3.0_f64, 5),
        epsilon in 0.01..2.0_f64,
    ) {
        let system = twisted();
        let data = data(&system);
        let error = dual_pair_error(&system, &data, epsilon, &x, &p).expect("maps");
        prop_assert!(error <= 1e-13, "{error:e}");
        let error = inversion_and_section_error(&system, data.as_ref(), epsilon, &x, &p);
        prop_assert!(error.expect("maps") <= 4.0 * f64::EPSILON);
    }

    #[test]
    fn its_steps_are_poisson_and_keep_the_casimir(x in vec(0.2..1.5_f64, 5), half in 1..4_usize) {
        let system = twisted();
        let map = method(&system, &data(&system), 2 * half);
        let error = structure_error(&system, &map, 0.1, &x).expect("a step");
        prop_assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{error:?}");
    }
}

#[test]
fn its_orders_are_those_of_the_generating_function() {
    let system = twisted();
    let data = data(&system);
    let x = [0.5, -0.3, 0.8, 1.1, -0.6];
    for (order, steps) in [
        (2, [16, 32, 64, 128]),
        (4, [16, 32, 64, 128]),
        (6, [8, 16, 32, 64]),
    ] {
        let map = method(&system, &data, order);
        let slope = measured_order(&system, &map, &x, 1.0, &steps).expect("points");
        assert!(is_even_order(slope, order), "{order}: {slope:?}");
    }
}

#[test]
fn a_tensor_that_does_not_fit_is_named() {
    let refusal = form::realize(&library("rigid-body").system).expect_err("a linear tensor");
    assert!(
        refusal.to_string().contains("whose brackets do not vanish"),
        "{refusal}"
    );
}

#[test]
fn the_document_holds_the_same_lines() {
    let document = include_str!("../docs/design/closed-forms.md");
    let (_, rest) = document.split_once("```rust\n").expect("a block of code");
    let (block, _) = rest.split_once("```").expect("its end");
    let lines = |text: &'static str| text.lines().map(str::trim).collect::<Vec<_>>();
    let (block, own) = (lines(block), lines(include_str!("closed_form.rs")));
    assert!(own.windows(block.len()).any(|lines| lines == block));
}
