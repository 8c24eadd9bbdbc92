//! Whoever integrates a problem from its start to its end, ours and others.

use std::cell::RefCell;
use std::collections::BTreeMap;

use leafwise::core::Walk;
use leafwise::core::diagnostics::TensorDefect;
use leafwise::scene::ComposedRun;
use leafwise_benches::composed;
use ode_solvers::dop_shared::OutputType;
use ode_solvers::{Dop853, SVector, System};

use crate::hand::dop853;
use crate::hand::gauss::{Gauss, MIDPOINT, gauss_4, gauss_6};
use crate::hand::splitting;
use crate::problems::Problem;

/// What a table says of a solution.
#[derive(Clone, Debug)]
pub struct Solution {
    /// x(T).
    pub state: Vec<f64>,
    /// Evaluations of the field, or of a kernel.
    pub evaluations: u64,
    /// Operations counted, of ours.
    pub operations: Option<u64>,
}

/// What a contestant is to be judged against and by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Other,
    /// Realization and Hamilton–Jacobi, or composed.
    HamiltonJacobi,
    /// A step map that stands in place of both.
    StepMap,
}

/// A method with one number that says how fine: steps, or eighths of a decade of tolerance.
pub trait Contestant {
    fn name(&self) -> String;
    fn kind(&self) -> Kind;
    /// The numbers that are tried, from coarse to fine.
    fn settings(&self) -> Vec<usize>;
    /// x(T), `None` where the method fails.
    fn solve(&self, setting: usize) -> Option<Solution>;
    /// A setting as a table shows it.
    fn tell(&self, setting: usize) -> String {
        setting.to_string()
    }
    /// The Casimir's relative drift over all steps and the relative tensor defect, of ours.
    fn structure(&self, setting: usize) -> Option<(f64, Option<f64>)> {
        let _ = setting;
        None
    }
}

/// Numbers of steps in geometric progression, eight an octave.
pub fn step_numbers(least: f64, most: f64) -> Vec<usize> {
    let mut numbers = Vec::new();
    let mut number = least;
    while number <= most {
        numbers.push(number.round() as usize);
        number *= libm::exp2(0.125);
    }
    numbers
}

/// Tolerances from 1e-3 to 1e-14, in eighths of a decade.
pub fn tolerances() -> Vec<usize> {
    (24..=112).collect()
}

/// A tolerance as a table shows it.
pub fn tell_tolerance(setting: usize) -> String {
    format!("{:.1e}", libm::pow(10.0, -(setting as f64) / 8.0))
}

/// DOP853 of the crate `ode_solvers`.
pub struct OdeSolvers<P>(pub std::marker::PhantomData<P>);

struct Field<P>(std::marker::PhantomData<P>);

impl<P: Problem> System<f64, SVector<f64, 3>> for Field<P> {
    #[inline(always)]
    fn system(&self, _time: f64, x: &SVector<f64, 3>, slope: &mut SVector<f64, 3>) {
        let value = P::field(&[x[0], x[1], x[2]]);
        *slope = SVector::from(value);
    }
}

impl<P: Problem> Contestant for OdeSolvers<P> {
    fn name(&self) -> String {
        "`ode_solvers` DOP853".to_owned()
    }

    fn kind(&self) -> Kind {
        Kind::Other
    }

    fn settings(&self) -> Vec<usize> {
        tolerances()
    }

    fn tell(&self, setting: usize) -> String {
        tell_tolerance(setting)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let tolerance = libm::pow(10.0, -(setting as f64) / 8.0);
        let field = Field::<P>(std::marker::PhantomData);
        let initial = SVector::from(P::INITIAL);
        let mut solver = Dop853::new(field, 0.0, P::TIME, P::TIME, initial, tolerance, tolerance);
        solver.set_output(OutputType::Sparse);
        let statistics = solver.integrate().ok()?;
        Some(Solution {
            state: solver.y_out().last()?.as_slice().to_vec(),
            evaluations: statistics.num_eval.into(),
            operations: None,
        })
    }
}

/// DOP853 written by hand.
pub struct HandDop853<P>(pub std::marker::PhantomData<P>);

impl<P: Problem> Contestant for HandDop853<P> {
    fn name(&self) -> String {
        "DOP853 by hand".to_owned()
    }

    fn kind(&self) -> Kind {
        Kind::Other
    }

    fn settings(&self) -> Vec<usize> {
        tolerances()
    }

    fn tell(&self, setting: usize) -> String {
        tell_tolerance(setting)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let tolerance = libm::pow(10.0, -(setting as f64) / 8.0);
        let found = dop853::integrate(P::field, P::INITIAL, P::TIME, tolerance)?;
        Some(Solution {
            state: found.0.to_vec(),
            evaluations: found.1,
            operations: None,
        })
    }
}

/// A stepper of the program that takes a tolerance, in one step.
pub struct Adaptive<P> {
    stepper: &'static str,
    runs: RefCell<BTreeMap<usize, ComposedRun>>,
    problem: std::marker::PhantomData<P>,
}

impl<P> Adaptive<P> {
    /// By its name.
    pub fn new(stepper: &'static str) -> Self {
        Self {
            stepper,
            runs: RefCell::default(),
            problem: std::marker::PhantomData,
        }
    }
}

impl<P: Problem> Contestant for Adaptive<P> {
    fn name(&self) -> String {
        format!("`{}`", self.stepper)
    }

    fn kind(&self) -> Kind {
        Kind::Other
    }

    fn settings(&self) -> Vec<usize> {
        tolerances()
    }

    fn tell(&self, setting: usize) -> String {
        tell_tolerance(setting)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let mut runs = self.runs.borrow_mut();
        let run = runs.entry(setting).or_insert_with(|| {
            let tolerance = libm::pow(10.0, -(setting as f64) / 8.0);
            let name = self.stepper;
            let method = format!("stepper = {{ name = \"{name}\", tolerance = {tolerance:e} }}");
            composed(&scene::<P>(&method))
        });
        let parameters = run.system.parameter_values();
        let map = run.method.map();
        let mut walk = Walk::new(map, &parameters, 1.0, P::TIME, &P::INITIAL);
        walk.step().ok()?;
        let statistics = walk.statistics();
        Some(Solution {
            state: walk.state().to_vec(),
            evaluations: statistics.evaluations,
            operations: statistics.operations,
        })
    }
}

/// A scene of the problem by the lines of a `[method]` table.
fn scene<P: Problem>(method: &str) -> String {
    format!(
        "[system]\nlibrary = \"{}\"\n[method]\n{method}\ntime-step = 0.1\n[run]\ninitial = {:?}\nsteps = 1\n",
        P::LIBRARY,
        P::INITIAL
    )
}

/// A Gauss method written by hand.
pub struct HandGauss<P, const S: usize> {
    method: Gauss<S>,
    problem: std::marker::PhantomData<P>,
}

impl<P> HandGauss<P, 1> {
    /// The implicit midpoint rule.
    pub fn midpoint() -> Self {
        Self::of(MIDPOINT)
    }
}

impl<P> HandGauss<P, 2> {
    pub fn order_4() -> Self {
        Self::of(gauss_4())
    }
}

impl<P> HandGauss<P, 3> {
    pub fn order_6() -> Self {
        Self::of(gauss_6())
    }
}

impl<P, const S: usize> HandGauss<P, S> {
    fn of(method: Gauss<S>) -> Self {
        Self {
            method,
            problem: std::marker::PhantomData,
        }
    }
}

impl<P: Problem, const S: usize> Contestant for HandGauss<P, S> {
    fn name(&self) -> String {
        match S {
            1 => "implicit midpoint by hand".to_owned(),
            _ => format!("Gauss {} by hand", 2 * S),
        }
    }

    fn kind(&self) -> Kind {
        Kind::Other
    }

    fn settings(&self) -> Vec<usize> {
        step_numbers(2.0 * P::TIME, 1e5 * P::TIME / S as f64)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let h = P::TIME / setting as f64;
        let (state, evaluations) = self.method.integrate(P::field, P::INITIAL, h, setting);
        Some(Solution {
            state: state.to_vec(),
            evaluations,
            operations: None,
        })
    }
}

/// A composition of flows written by hand.
pub struct HandSplitting<P> {
    pub scheme: &'static str,
    /// α_1, …, α_2s.
    pub parts: Vec<f64>,
    pub problem: std::marker::PhantomData<P>,
}

impl<P: Problem> Contestant for HandSplitting<P> {
    fn name(&self) -> String {
        format!("splitting by hand, {}", self.scheme)
    }

    fn kind(&self) -> Kind {
        Kind::Other
    }

    fn settings(&self) -> Vec<usize> {
        let stages = 0.5 * self.parts.len() as f64;
        step_numbers(P::TIME, 1e4 * P::TIME / stages)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let h = P::TIME / setting as f64;
        let mut state = P::INITIAL;
        splitting::integrate::<P>(&self.parts, &mut state, h, setting);
        Some(Solution {
            state: state.to_vec(),
            evaluations: (self.parts.len() / 2 * setting) as u64,
            operations: None,
        })
    }
}

/// A `[method]` table of a scene.
pub struct Ours<P> {
    name: String,
    kind: Kind,
    run: ComposedRun,
    most_steps: f64,
    problem: std::marker::PhantomData<P>,
}

impl<P: Problem> Ours<P> {
    /// Composed of the lines of a `[method]` table.
    pub fn new(name: String, kind: Kind, method: &str, most_steps: f64) -> Self {
        Self {
            name,
            kind,
            run: composed(&scene::<P>(method)),
            most_steps,
            problem: std::marker::PhantomData,
        }
    }

    fn walk(&self, steps: usize) -> Walk {
        let parameters = self.run.system.parameter_values();
        let time_step = P::TIME / steps as f64;
        Walk::new(
            self.run.method.map(),
            &parameters,
            1.0,
            time_step,
            &P::INITIAL,
        )
    }
}

impl<P: Problem> Contestant for Ours<P> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn kind(&self) -> Kind {
        self.kind
    }

    fn settings(&self) -> Vec<usize> {
        step_numbers(0.5 * P::TIME, self.most_steps)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let mut walk = self.walk(setting);
        walk.advance(setting as u64).ok()?;
        let statistics = walk.statistics();
        Some(Solution {
            state: walk.state().to_vec(),
            evaluations: statistics.evaluations,
            operations: statistics.operations,
        })
    }

    /// The Casimir relative to its largest summand on the orbit; the defect at every 37th state of the orbit.
    fn structure(&self, setting: usize) -> Option<(f64, Option<f64>)> {
        let mut walk = self.walk(setting);
        let parameters = self.run.system.parameter_values();
        let time_step = P::TIME / setting as f64;
        let map = self.run.method.map();
        let mut instrument =
            TensorDefect::new(&self.run.system, map, &parameters, 1.0, time_step).ok()?;
        let (initial, mut size) = P::casimir(&P::INITIAL);
        let (mut drift, mut defect) = (0.0_f64, Some(0.0_f64));
        for step in 0..setting {
            if step % 37 == 0 {
                let here = instrument.measure(walk.state()).ok();
                let here = here.and_then(|defect| defect.relative());
                defect = defect.zip(here).map(|(a, b)| a.max(b));
            }
            walk.step().ok()?;
            let (value, summand) = P::casimir(walk.state());
            drift = drift.max((value - initial).abs());
            size = size.max(summand);
        }
        Some((drift / size, defect))
    }
}
