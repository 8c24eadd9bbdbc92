//! Verdicts do not depend on the units of the coordinates.

use leafwise::core::diagnostics::{
    Defect, RealizationInstrument, TensorDefect, section_defect, self_adjointness_defect,
};
use leafwise::core::{
    MapProperties, PartParameters, Registry, SolverStatistics, StepError, StepMap, Stepper,
    Structure, Walk,
};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise::trade::tensor_defect;
use leafwise::verify::{Judgement, Problem};
use proptest::prelude::*;

use super::{Declares, measured};

const TIME_STEP: f64 = 0.125;

/// Exact flows have no chart to leave, and no norm of all coordinates.
const SPLITTING: &str = "stepper = \"splitting\"";

/// A system in coordinates c_i x_i, c_i = 10^k_i.
struct System {
    names: &'static [&'static str],
    /// {x_i, x_j} as a polynomial: coefficient and exponents.
    bracket: &'static [(usize, usize, f64, &'static [i32])],
    /// H as a polynomial.
    hamiltonian: &'static [(f64, &'static [i32])],
    initial: &'static [f64],
}

const RIGID_BODY: System = System {
    names: &["x", "y", "z"],
    bracket: &[
        (0, 1, -1.0, &[0, 0, 1]),
        (1, 2, -1.0, &[1, 0, 0]),
        (2, 0, -1.0, &[0, 1, 0]),
    ],
    hamiltonian: &[(0.5, &[2, 0, 0]), (0.625, &[0, 2, 0]), (0.375, &[0, 0, 2])],
    initial: &[1.0, 0.5, -0.75],
};

const OSCILLATORS: System = System {
    names: &["q", "Q", "p", "P"],
    bracket: &[(0, 2, 1.0, &[0, 0, 0, 0]), (1, 3, 1.0, &[0, 0, 0, 0])],
    hamiltonian: &[
        (0.5, &[0, 0, 2, 0]),
        (0.5, &[0, 0, 0, 2]),
        (0.5, &[2, 0, 0, 0]),
        (0.75, &[0, 2, 0, 0]),
        (0.25, &[2, 2, 0, 0]),
    ],
    // One coordinate at rest, one that moves.
    initial: &[1.0, 0.0, 0.5, 0.25],
};

const PREY: System = System {
    names: &["u", "v"],
    bracket: &[(0, 1, 1.0, &[1, 1])],
    hamiltonian: &[(1.0, &[1, 0]), (1.0, &[0, 1]), (0.25, &[1, 1])],
    initial: &[1.5, 0.7],
};

impl System {
    fn scene(&self, units: &[i32], tensor: f64) -> SceneDocument {
        let monomial = |coefficient: f64, unit: i32, exponents: &[i32]| {
            // x_i = c_i⁻¹ (c_i x_i).
            let own: i32 = exponents.iter().zip(units).map(|(e, k)| e * k).sum();
            let mut text = format!("{coefficient:?}*1e{}", unit - own);
            for (name, exponent) in self.names.iter().zip(exponents) {
                if *exponent != 0 {
                    text.push_str(&format!("*{name}^{exponent}"));
                }
            }
            text
        };
        let bracket: Vec<String> = self
            .bracket
            .iter()
            .map(|(i, j, coefficient, exponents)| {
                let (a, b) = (self.names[*i], self.names[*j]);
                let value = monomial(tensor * coefficient, units[*i] + units[*j], exponents);
                format!("\"{a},{b}\" = \"{value}\"")
            })
            .collect();
        let terms = self.hamiltonian.iter();
        let hamiltonian: Vec<String> = terms.map(|(c, e)| monomial(*c, 0, e)).collect();
        let initial = self.initial.iter().zip(units);
        let initial: Vec<f64> = initial
            .map(|(x, k)| decimal(&format!("{x:?}e{k}")))
            .collect();
        let text = format!(
            "[system]\nvariables = {:?}\nbracket = {{ {} }}\nhamiltonian = \"{}\"\n[method]\n\
             {SPLITTING}\ntime-step = {TIME_STEP:?}\n[run]\ninitial = {initial:?}\nsteps = 1\n",
            self.names,
            bracket.join(", "),
            hamiltonian.join(" + "),
        );
        SceneDocument::parse("units.toml", &text, &Registry::with_builtin()).expect("a scene")
    }
}

fn decimal(text: &str) -> f64 {
    text.parse().expect("a decimal")
}

const POISSON: &str =
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }";

fn composed(document: &SceneDocument) -> ComposedRun {
    compose(document, &Registry::with_builtin()).expect("the method fits")
}

/// A map followed by x_at ↦ x_at + 1e-3 x_at²/size: no Poisson map over a tensor that is constant, linear or
/// quadratic in x_at.
struct Stretched<'a> {
    map: &'a dyn StepMap,
    at: usize,
    size: f64,
}

const WRONG: f64 = 1e-3;

impl StepMap for Stretched<'_> {
    fn dimension(&self) -> usize {
        self.map.dimension()
    }
    fn properties(&self) -> MapProperties {
        self.map.properties()
    }
    fn describe(&self) -> String {
        "stretched".to_owned()
    }
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        assert_eq!(lanes, 1, "an instrument takes one");
        Box::new(StretchedStepper {
            stepper: self.map.stepper(lanes, parameters, epsilon, h),
            at: self.at,
            size: self.size,
            slope: 1.0,
        })
    }
}

struct StretchedStepper {
    stepper: Box<dyn Stepper>,
    at: usize,
    size: f64,
    slope: f64,
}

impl Stepper for StretchedStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        self.stepper.increment(x, low, increment, outcome);
        let ratio = (x[self.at] + increment[self.at]) / self.size;
        increment[self.at] += WRONG * ratio * ratio * self.size;
        self.slope = 1.0 + 2.0 * WRONG * ratio;
    }
    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let mut rows = self.stepper.tangent(lane)?;
        let d = libm::sqrt(rows.len() as f64) as usize;
        for entry in &mut rows[self.at * d..][..d] {
            *entry *= self.slope;
        }
        Some(rows)
    }
    fn restart(&mut self) {
        self.stepper.restart();
    }
    fn statistics(&self) -> SolverStatistics {
        self.stepper.statistics()
    }
    fn memory(&self) -> Vec<f64> {
        self.stepper.memory()
    }
    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        self.stepper.restore(memory)
    }
}

/// The relative tensor defect and the defect of self-adjointness of one step.
fn defects(run: &ComposedRun, map: &dyn StepMap, time_step: f64) -> [f64; 2] {
    let values = run.system.parameter_values();
    let x = &run.plan.initial;
    let mut instrument =
        TensorDefect::new(&run.system, map, &values, 1.0, time_step).expect("a tensor");
    let defect = instrument.measure(x).expect("a step with its tangent");
    let own = self_adjointness_defect(map, &values, 1.0, time_step, x).expect("two steps");
    [
        defect.relative().expect("a tensor that does not vanish"),
        own,
    ]
}

/// Φ(x).
fn end(run: &ComposedRun, map: &dyn StepMap, time_step: f64) -> Vec<f64> {
    let values = run.system.parameter_values();
    let mut walk = Walk::new(map, &values, 1.0, time_step, &run.plan.initial);
    walk.step().expect("a step");
    walk.state().to_vec()
}

fn exponents() -> impl Strategy<Value = Vec<i32>> {
    prop::collection::vec(-30..=30, 4)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    /// A map that is wrong by 1e-3 in one coordinate is found, and the right one is round-off, in any units.
    /// Units may change the order of the pieces, and with it the map, but not the size of what is wrong.
    #[test]
    fn a_wrong_map_is_found_in_any_units(units in exponents()) {
        for system in [&RIGID_BODY, &OSCILLATORS, &PREY] {
            let run = |units: &[i32]| composed(&system.scene(units, 1.0));
            let (usual, scaled) = (run(&[0; 4]), run(&units));
            let right = defects(&scaled, scaled.method.map(), TIME_STEP);
            prop_assert!(right.iter().all(|d| *d <= Defect::ROUND_OFF), "{right:?} {units:?}");
            for at in 0..system.names.len() {
                let found = |run: &ComposedRun| {
                    let map = run.method.map();
                    let size = end(run, map, TIME_STEP)[at].abs();
                    defects(run, &Stretched { map, at, size }, TIME_STEP)
                };
                let (expected, found) = (found(&usual), found(&scaled));
                for (expected, found) in expected.into_iter().zip(found) {
                    prop_assert!(expected > 1e-3 * WRONG, "{at}: {expected:e}");
                    prop_assert!(found > 0.5 * expected && found < 2.0 * expected, "{at}: {found:e}, {expected:e}");
                }
            }
        }
    }

    /// The same of realizations: one of a tensor that is wrong by 1e-3.
    #[test]
    fn a_realization_of_a_wrong_tensor_is_found_in_any_units(units in exponents()) {
        for (system, exact) in [(&OSCILLATORS, "constant"), (&PREY, "log-canonical")] {
            let run = |tensor: f64| composed(&system.scene(&units, tensor));
            let (right, wrong) = (run(1.0), run(1.0 + WRONG));
            let part = Registry::with_builtin().realization(exact).expect("built in");
            let x = &right.plan.initial;
            // A tenth of what moves each end by its own size.
            let momentum = |(i, x): (usize, &f64)| if *x == 0.0 { 0.0 } else { 0.1 * (1.0 + i as f64) / x };
            let p: Vec<f64> = x.iter().enumerate().map(momentum).collect();
            let errors = |of: &ComposedRun| {
                let realization = part.build(&of.system, &PartParameters::new()).expect("it fits");
                let section = section_defect(realization.as_ref(), &[], 1.0, x).expect("maps");
                assert!(section.expect("a value") <= 64.0 * f64::EPSILON);
                let instrument = RealizationInstrument::new(&right.system, &realization, &[]);
                let found = instrument.expect("maps").measure(1.0, x, &p).expect("a point");
                [found.relative.source, found.relative.target, found.relative.dual_pair]
            };
            let found = errors(&right);
            prop_assert!(found.iter().all(|e| *e <= 256.0 * f64::EPSILON), "{found:?}");
            let found = errors(&wrong);
            prop_assert!(found[0] > 0.01 * WRONG && found[1] > 0.01 * WRONG, "{found:?}");
        }
    }
}

/// An electron in an anharmonic trap, in kilograms, metres and seconds.
fn electron(bracket: &str, method: &str) -> SceneDocument {
    let text = format!(
        "[system]\nvariables = [\"q\", \"p\"]\nparameters = {{ m = 9.109e-31, w = 1e15, a = 1e-9 }}\n\
         bracket = {{ \"q,p\" = \"{bracket}\" }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"p^2/(2*m) + m*w^2*(q^2/2 + q^4/(4*a^2))\"\n\
         [method]\n{method}\ntime-step = 2e-16\n[run]\ninitial = [1e-9, 3e-25]\nsteps = 100\n"
    );
    SceneDocument::parse("electron.toml", &text, &Registry::with_builtin()).expect("a scene")
}

/// The fourth-order Runge–Kutta method loses (ωt)⁶/72 of the area a step, here some 1e-6.
#[test]
fn a_map_that_is_falsely_declared_exact_is_caught_in_si_units() {
    let document = electron("1", "stepper = \"rk4\"");
    let problem = Problem::of_scene(&document).expect("a problem");
    let run = composed(&document);
    let Ok(map) = Registry::with_builtin()
        .stepper("rk4")
        .and_then(|part| part.build(&run.system, &PartParameters::new()))
    else {
        panic!("rk4 is built in");
    };
    let truth = map.properties();
    let structure = Structure::Exact;
    let found = measured(
        &problem,
        &Declares(map, MapProperties { structure, ..truth }),
    );
    assert_eq!(found.judgements[1], Judgement::NotMet, "{found:?}");
    assert!(
        found.tensor_defect.is_some_and(|defect| defect > 1e-8),
        "{found:?}"
    );
    let poisson = electron("1", POISSON);
    let found = measured(&problem, composed(&poisson).method.map());
    assert_eq!(found.judgements, [Judgement::Met; 3], "{found:?}");
}

/// Truncated to order 1 over {q, p} = 1 + (q/a)²: `compare` calls a run Poisson by this number.
#[test]
fn a_truncated_realization_is_no_poisson_map_in_si_units() {
    let method = "realization = { name = \"karasev-truncated\", order = 1 }\n\
                  dynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let run = composed(&electron("1 + (q/a)^2", method));
    let defect = tensor_defect(&run, 2e-16, &[&run.plan.initial]).expect("a tangent");
    assert!(defect > 1e-5, "{defect:e}");
}
