//! A realization with a closed form, as `docs/design/closed-forms.md` adds one, is one like any other.

use std::sync::Arc;

use leafwise::core::{PoissonSystem, RealizationData};
use leafwise_tests::library;
use leafwise_tests::realizations::{assert_dual_pair, assert_orders, assert_poisson_steps};
use leafwise_tests::systems::from_formulas;

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
        &[("x,y", "a*sin(z) + 2"), ("u,v", "-z^2"), ("x,v", "exp(-z)")],
        "(x^2 + y^2 + u^2 + v^2)/2 + x*u*z/5 + y^4/8 + cos(v)",
        &[("z", "z")],
    )
}

fn data(system: &PoissonSystem) -> Arc<dyn RealizationData> {
    Arc::new(form::realize(system).expect("it fits"))
}

/// The brackets of α and β at random x, p, ε; β(x, p) = α(x, −p) and the section to 8 roundings.
#[test]
fn its_maps_are_a_dual_pair() {
    let system = twisted();
    let domain = (-2.0..2.0, -3.0..3.0, 0.01..2.0);
    assert_dual_pair(&system, &data(&system), domain, 8.0);
}

/// Steps of εh = 0.1 from random x, of orders 2 to 8.
#[test]
fn its_steps_are_poisson_and_keep_the_casimir() {
    let system = twisted();
    assert_poisson_steps(&system, &data(&system), 0.2..1.5, 0.1);
}

/// The error after t = 1 falls with h to the power m.
#[test]
fn its_orders_are_those_of_the_generating_function() {
    let system = twisted();
    let orders = [
        (2, [16, 32, 64, 128]),
        (4, [16, 32, 64, 128]),
        (6, [8, 16, 32, 64]),
    ];
    let start = (&[0.5, -0.3, 0.8, 1.1, -0.6][..], 1.0);
    assert_orders(&system, &data(&system), start, &orders);
}

#[test]
fn a_tensor_that_does_not_fit_is_named() {
    let refusal = form::realize(&library("rigid-body").system).expect_err("a linear tensor");
    assert!(
        refusal.to_string().contains("whose brackets do not vanish"),
        "{refusal}"
    );
}

/// But for the part, which this program does not have.
#[test]
fn the_document_holds_the_same_lines() {
    let document = include_str!("../docs/design/closed-forms.md");
    let lines = |text: &'static str| text.lines().map(str::trim).collect::<Vec<_>>();
    let own = lines(include_str!("closed_form.rs"));
    let blocks = document.split("```rust\n").skip(1);
    let blocks: Vec<_> = blocks.filter_map(|rest| rest.split_once("```")).collect();
    assert_eq!(blocks.len(), 3);
    for (block, _) in [blocks[0], blocks[2]] {
        let block = lines(block);
        assert!(own.windows(block.len()).any(|lines| lines == block));
    }
}
