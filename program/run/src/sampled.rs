//! Method of a run that has ended, judged by its records: how energies were kept, formulas without a value.

use leafwise_core::solver::judge::larger;

use super::chaos::ChaosVerdict;
use super::drive::Session;
use super::error::RunError;
use super::outcome::RunReport;
use super::shadow::{Changes, ShadowVerdict};
use crate::advice::{Advice, EnergyError};
use leafwise_scene::compose::{ComposedRun, Observable};
use leafwise_walk::Indicator;

/// The most samples of a shadow energy, or of an indicator of chaos, that are looked at.
const MOST_SAMPLES: u64 = 50_000;

/// How the energy of the map's shadow was kept at the recorded states, where it is recorded.
pub(super) fn shadow(
    run: &ComposedRun,
    session: &Session<'_>,
    report: &RunReport,
) -> Result<Option<ShadowVerdict>, RunError> {
    let (Some(recorded), Some(energy)) = (run.plan.shadow, report.invariants.first()) else {
        return Ok(None);
    };
    let stride = usize::try_from(report.samples.div_ceil(MOST_SAMPLES)).unwrap_or(usize::MAX);
    let rows = session.samples().read(stride)?;
    let at = 1 + columns_of_states(session, run) + recorded.at;
    let values: Vec<f64> = rows.iter().filter_map(|row| row.get(at).copied()).collect();
    let Some(first) = values.first() else {
        return Ok(None);
    };
    let changes = values.iter().map(|value| (value - first).abs());
    let changes = Changes {
        energy: energy.maximum,
        shadow: changes.fold(0.0, larger),
        size: energy.initial.abs(),
        steps: report.steps,
    };
    let t = run.plan.epsilon * run.plan.h;
    Ok(Some(ShadowVerdict::new(recorded, changes, t)))
}

/// Whether the motion is regular or chaotic, where MEGNO is recorded.
pub(super) fn chaos(
    run: &ComposedRun,
    session: &Session<'_>,
    report: &RunReport,
) -> Result<Option<ChaosVerdict>, RunError> {
    let first = 1 + columns_of_states(session, run);
    let column = |which: Indicator| {
        let is_it = |observable: &Observable| {
            matches!(observable, Observable::Indicator { index, .. }
                if run.plan.indicators[*index] == which)
        };
        let at = run.plan.observables.iter().position(is_it);
        at.map(|at| first + at)
    };
    let Some(megno) = column(Indicator::Megno) else {
        return Ok(None);
    };
    let stride = usize::try_from(report.samples.div_ceil(MOST_SAMPLES)).unwrap_or(usize::MAX);
    let rows = session.samples().read(stride)?;
    let samples: Vec<(f64, f64)> = rows.iter().map(|row| (row[0], row[megno])).collect();
    let exponent = column(Indicator::Lyapunov(1)).zip(rows.last());
    let exponent = exponent.map(|(at, row)| row[at]);
    let verdict = ChaosVerdict::new(&samples, exponent);
    Ok(verdict.map(|verdict| verdict.of(run)))
}

/// An energy kept badly, judged along the run's orbit.
pub(super) fn energy_error(
    run: &ComposedRun,
    session: &Session<'_>,
    report: &RunReport,
) -> Option<Advice> {
    let energy = report.invariants.first()?;
    let error = EnergyError {
        parameters: &run.system.parameter_values(),
        initial: energy.initial,
        largest: energy.maximum,
        whose: "",
    };
    let is_notable = error.is_notable();
    is_notable
        .then(|| error.advice(run, &session.along()))
        .flatten()
}

/// The observables that have no finite value somewhere, each with the first time.
pub(super) fn first_undefined(
    run: &ComposedRun,
    session: &Session<'_>,
) -> Result<Vec<(String, f64)>, RunError> {
    let start = 1 + columns_of_states(session, run);
    let observables = &run.plan.observables;
    let times = session
        .samples()
        .first_undefined(start, observables.len())?;
    let named = observables.iter().zip(times);
    Ok(named
        .filter_map(|(observable, time)| Some((observable.name().to_owned(), time?)))
        .collect())
}

/// Columns of samples between the time and the observables.
pub(super) fn columns_of_states(session: &Session<'_>, run: &ComposedRun) -> usize {
    match session.has_states_in_samples() {
        true => run.plan.states.width(),
        false => 0,
    }
}
