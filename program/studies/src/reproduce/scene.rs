//! The scenes behind the figures.

use leafwise_core::Registry;
use leafwise_core::solver::judge::larger;
use leafwise_scene::{ComposedRun, SceneDocument, compose};

use super::error::ReproduceError;

/// K-HJ of order 2 over the truncated realization, from (1, 3, 3).
pub(super) struct FigureScene {
    /// The library's system.
    pub system: &'static str,
    /// n.
    pub order: i64,
    /// ε.
    pub epsilon: f64,
    /// h.
    pub h: f64,
    /// The number of steps.
    pub steps: u64,
}

impl FigureScene {
    /// The scene's text.
    pub fn text(&self) -> String {
        format!(
            "[system]\nlibrary = \"{}\"\n\n[method]\n\
             realization = {{ name = \"karasev-truncated\", order = {} }}\n\
             dynamics    = {{ name = \"hamilton-jacobi\", order = 2 }}\n\
             epsilon     = {:?}\nh           = {:?}\n\n[run]\n{}",
            self.system,
            self.order,
            self.epsilon,
            self.h,
            run_table(self.steps)
        )
    }
}

/// The `[run]` table's content: from (1, 3, 3), every step kept.
pub(super) fn run_table(steps: u64) -> String {
    format!("initial = [1, 3, 3]\nsteps   = {steps}\n")
}

/// A scene's text, ready to run.
pub(super) fn composed(text: &str, registry: &Registry) -> Result<ComposedRun, ReproduceError> {
    let document = SceneDocument::parse("figure", text, registry)?;
    compose(&document, registry).map_err(ReproduceError::Refused)
}

/// Energy and Casimir over a run.
pub(super) struct History {
    /// Time, H − H(0), C − C(0) after every step, the start included.
    pub rows: Vec<(f64, f64, f64)>,
    /// H(0) and C(0).
    pub initial: (f64, f64),
    /// The states that were asked for, with their times.
    pub states: Vec<(f64, Vec<f64>)>,
}

impl History {
    /// Runs a scene of one Casimir until its end, or as long as `goes_on`.
    pub fn of(
        run: &ComposedRun,
        figure: usize,
        goes_on: impl Fn(&[f64]) -> bool,
    ) -> Result<Self, ReproduceError> {
        let mut observer = run.invariants()?;
        let mut walk = run.walk();
        let mut values = vec![0.0; observer.observables()];
        observer.evaluate(walk.state(), &mut values);
        let initial = (values[0], values[1]);
        let mut history = Self {
            rows: vec![(0.0, 0.0, 0.0)],
            initial,
            states: vec![(0.0, walk.state().to_vec())],
        };
        let ended = walk.watch_until(run.plan.steps, |walk| {
            if !goes_on(walk.state()) {
                return Some(());
            }
            observer.evaluate(walk.state(), &mut values);
            history
                .rows
                .push((walk.time(), values[0] - initial.0, values[1] - initial.1));
            history.states.push((walk.time(), walk.state().to_vec()));
            None
        });
        ended.map_err(|error| ReproduceError::Step {
            figure,
            step: walk.steps() + 1,
            error,
        })?;
        Ok(history)
    }

    /// The largest deviations of energy and Casimir.
    pub fn largest(&self) -> (f64, f64) {
        largest(&self.rows)
    }

    /// The energy's largest deviation over the last tenth of the run over that of the first.
    pub fn energy_growth(&self) -> f64 {
        let tenth = (self.rows.len() / 10).max(1);
        largest(&self.rows[self.rows.len() - tenth..]).0 / largest(&self.rows[..tenth]).0
    }

    /// C − C(0) over time.
    pub fn casimir(&self) -> Vec<(f64, f64)> {
        self.rows.iter().map(|row| (row.0, row.2)).collect()
    }

    /// H − H(0) over time.
    pub fn energy(&self) -> Vec<(f64, f64)> {
        self.rows.iter().map(|row| (row.0, row.1)).collect()
    }
}

/// Keeps a NaN: a value that is lost is not a small deviation.
fn largest(rows: &[(f64, f64, f64)]) -> (f64, f64) {
    rows.iter().fold((0.0, 0.0), |(h, c), row| {
        (larger(h, row.1.abs()), larger(c, row.2.abs()))
    })
}
