//! The cost of a step from a scene against the same method as Rust of one dimension.

use std::hint::black_box;

use leafwise::core::Walk;
use leafwise_benches::{STEP_CASES, StepCase};

use crate::accuracy::ratio;
use crate::document::{Table, time};
use crate::hand::formulas::{
    HeavyTop2, HeavyTop4, HeavyTop8, LotkaVolterra2, LotkaVolterra4, LotkaVolterra8, RigidBody2,
    RigidBody4, RigidBody8,
};
use crate::hand::newton::{Formulas, Trajectory};
use crate::measure::{Run, interleaved};

const ROUNDS: usize = 41;

/// Steps in one sample.
const STEPS: usize = 200;

/// Steps before the first sample, over which the bits are compared.
const WARM_UP: usize = 2000;

/// What steps a trajectory a number of times.
type Steps = Box<dyn FnMut(usize) -> Vec<f64>>;

fn by_hand<F: Formulas<D> + 'static, const D: usize>(
    make: impl Fn(&[f64], f64, f64) -> F,
    case: &StepCase,
) -> Steps {
    let run = case.composed();
    let initial: [f64; D] = run
        .plan
        .initial
        .as_slice()
        .try_into()
        .expect("the dimension");
    let parameters = run.system.parameter_values();
    let formulas = make(&parameters, run.plan.epsilon, run.plan.h);
    let mut trajectory = Trajectory::new(formulas, initial);
    Box::new(move |steps| {
        for _ in 0..steps {
            assert!(trajectory.step(), "a solve");
        }
        trajectory.x.to_vec()
    })
}

/// Formulas take their parameters as an array.
macro_rules! hand {
    ($case:expr, $formulas:ident, $dimension:literal) => {
        by_hand::<_, $dimension>(
            |parameters, epsilon, h| {
                let parameters = parameters.try_into().expect("the parameters");
                $formulas::new(parameters, epsilon, h)
            },
            $case,
        )
    };
}

fn hand(case: &StepCase) -> Steps {
    match case.formulas {
        "RigidBody2" => hand!(case, RigidBody2, 3),
        "RigidBody4" => hand!(case, RigidBody4, 3),
        "RigidBody8" => hand!(case, RigidBody8, 3),
        "LotkaVolterra2" => hand!(case, LotkaVolterra2, 3),
        "LotkaVolterra4" => hand!(case, LotkaVolterra4, 3),
        "LotkaVolterra8" => hand!(case, LotkaVolterra8, 3),
        "HeavyTop2" => hand!(case, HeavyTop2, 6),
        "HeavyTop4" => hand!(case, HeavyTop4, 6),
        "HeavyTop8" => hand!(case, HeavyTop8, 6),
        other => panic!("no formulas of {other}"),
    }
}

fn ours(walk: &mut Walk, steps: usize) -> Vec<f64> {
    walk.advance(steps as u64).expect("steps");
    walk.state().to_vec()
}

/// The table of all cases.
pub fn table() -> String {
    let mut table = Table::new(&[
        "system",
        "realization",
        "m",
        "d",
        "by hand",
        "from a scene",
        "ratio",
        "evaluations a step",
        "operations a step",
    ]);
    for case in &STEP_CASES {
        let run = case.composed();
        let mut walk = run.walk();
        let mut baseline = hand(case);
        let bits = |state: Vec<f64>| -> Vec<u64> { state.iter().map(|x| x.to_bits()).collect() };
        assert_eq!(
            bits(ours(&mut walk, WARM_UP)),
            bits(baseline(WARM_UP)),
            "{}: other bits; write the formulas again by `-- formulas`",
            case.formulas
        );
        let statistics = walk.statistics();
        let mut runs: [Run<'_>; 2] = [
            Box::new(|| {
                black_box(ours(&mut walk, STEPS));
            }),
            Box::new(|| {
                black_box(baseline(STEPS));
            }),
        ];
        let times = interleaved(&mut runs, ROUNDS);
        drop(runs);
        let a_step = |at: usize| time(times.seconds(at).median / STEPS as f64);
        table.row(&[
            case.problem.0.to_owned(),
            case.realization.to_owned(),
            case.order.to_string(),
            run.dimension().to_string(),
            a_step(1),
            a_step(0),
            ratio(times.ratio(0, 1)),
            format!("{:.2}", statistics.evaluations_per_step()),
            statistics
                .operations_per_step()
                .map_or_else(String::new, |n| format!("{n:.0}")),
        ]);
    }
    table.finish()
}
