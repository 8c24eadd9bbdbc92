//! Forces beside dH: a one-form by its formulas, damping, and friction.

use leafwise_core::PoissonSystem;
use leafwise_core::lattice::LatticeGeometry;
use leafwise_core::system::{Damping, Forces, Metric};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{AXES, Scope};
use nalgebra::{DMatrix, SymmetricEigen};

use super::Refusal;
use super::domain::OutOfDomain;
use super::keys::variable;
use super::names::{check_code, function, parse, refusal, sites_of};
use super::torque::{add_torque, check_torque};
use crate::document::{ByCoordinate, ComponentsSpec, Located, MetricSpec, SceneDocument};

/// Bound on round-off, relative to the largest entry: a negative or asymmetric part below it is so by round-off.
const ROUND_OFF: f64 = 1e-12;

/// Forces of a scene on its own coordinates, whose names are `moving`. The others of the `dimension` coordinates feel
/// none: parameters of sites, the time and its energy.
///
/// # Errors
/// The first formula that cannot be read. Lists of another length than `moving`.
pub(super) fn forces(
    document: &SceneDocument,
    scope: &Scope,
    moving: &[String],
    dimension: usize,
) -> Result<Forces, Refusal> {
    let spec = &document.system.forces;
    let read = |list: &[Located<String>]| -> Result<Vec<Expression>, Refusal> {
        let mut formulas = Vec::with_capacity(dimension);
        for formula in list {
            formulas.push(function(document, scope, formula)?);
        }
        formulas.resize(dimension, 0.into());
        Ok(formulas)
    };
    let by_name = |entries: &ByCoordinate| -> Result<Vec<Expression>, Refusal> {
        let mut formulas = vec![0.into(); dimension];
        by_coordinate(document, scope, entries, &mut formulas[..moving.len()])?;
        Ok(formulas)
    };
    let components = |spec: &Option<Located<ComponentsSpec>>, key: &str, of: &str| {
        let Some(components) = spec else {
            return Ok(Vec::new());
        };
        match &components.value {
            ComponentsSpec::All(list) => {
                check_count(document, components, list.len(), moving, key, of)?;
                read(list)
            }
            ComponentsSpec::Named(entries) => by_name(entries),
        }
    };
    let of = "a formula for each, and 0 where there is none, or a table of them by coordinates; a force F on a momentum is -F \
              for its coordinate";
    let mut one_form = components(&spec.one_form, "forces", of)?;
    let of = "a formula for each, and 0 where there is none, or a table of them by coordinates: it is added to x' unchanged";
    let friction = components(&spec.friction, "friction", of)?;
    if let Some(torque) = &spec.torque {
        add_torque(document, scope, torque, moving, &mut one_form, dimension)?;
    }
    let damping = match &spec.damping {
        None => None,
        Some(damping) => {
            let metric = match &damping.metric {
                None => Metric::identity(moving.len(), dimension),
                Some(metric) => {
                    let of = "an entry of the diagonal for each, or a row of entries for each";
                    let check =
                        |count: usize| check_count(document, metric, count, moving, "metric", of);
                    match &metric.value {
                        MetricSpec::Diagonal(entries) => {
                            check(entries.len())?;
                            Metric::Diagonal(read(entries)?)
                        }
                        MetricSpec::Named(entries) => Metric::Diagonal(by_name(entries)?),
                        MetricSpec::Rows(rows) => {
                            check(rows.len())?;
                            rows.iter().try_for_each(|row| check(row.len()))?;
                            let mut read: Vec<_> =
                                rows.iter().map(|row| read(row)).collect::<Result<_, _>>()?;
                            read.resize(dimension, vec![0.into(); dimension]);
                            Metric::Full(read)
                        }
                    }
                }
            };
            Some(Damping {
                rate: function(document, scope, &damping.rate)?,
                metric,
            })
        }
    };
    Ok(Forces {
        one_form,
        damping,
        friction,
    })
}

/// Writes formulas at the places of their coordinates among those that move, `"p[i]"` at every site; a single site overrides
/// what stands for all.
///
/// # Errors
/// A key that names no coordinate that moves, and a formula that cannot be read.
fn by_coordinate(
    document: &SceneDocument,
    scope: &Scope,
    entries: &ByCoordinate,
    formulas: &mut [Expression],
) -> Result<(), Refusal> {
    for_each_coordinate(document, scope, entries, |key, place, formula| {
        let own = formulas.get_mut(place).ok_or_else(|| {
            let message = format!(
                "`{}` is constant, and no force acts on it",
                key.value.trim()
            );
            Box::new(document.diagnostic(&key.place(), message, "no coordinate that moves", None))
        })?;
        *own = formula;
        Ok(())
    })
}

/// Calls `take` with the key, the place and the formula of every coordinate that is named: those with an index first, site after
/// site, then single ones.
///
/// # Errors
/// What cannot be read, and those of `take`.
pub(super) fn for_each_coordinate(
    document: &SceneDocument,
    scope: &Scope,
    entries: &ByCoordinate,
    mut take: impl FnMut(&Located<String>, usize, Expression) -> Result<(), Refusal>,
) -> Result<(), Refusal> {
    for indices in (0..=AXES).rev() {
        for (key, formula) in entries {
            let pattern = variable(document, key)?;
            let names = pattern.index_names();
            if names.iter().filter(|name| !name.is_empty()).count() != indices {
                continue;
            }
            let parsed = parse(document, formula)?;
            let is_template = indices > 0;
            let sites = match is_template {
                true => sites_of(document, scope, key, &names)?,
                false => vec![0],
            };
            let mut is_first = true;
            for site in sites {
                let index = is_template.then_some((&names[..], site));
                let place = pattern
                    .resolve(scope, index)
                    .map_err(|error| refusal(document, key, &error))?;
                let value = parsed
                    .resolve_summand(scope, index)
                    .map_err(|error| refusal(document, formula, &error))?;
                let Some(place) = place else { continue };
                // The code of one site is that of all; at an open end there is less.
                if let Some(value) = &value
                    && std::mem::take(&mut is_first)
                {
                    check_code(document, formula, value)?;
                }
                take(key, place, value.unwrap_or_else(|| 0.into()))?;
            }
        }
    }
    Ok(())
}

/// Refuses a metric by coordinates that is negative, or not finite, at a site of a long lattice in its initial state.
///
/// # Errors
/// The first such site, its formula's key underlined in the scene.
pub(super) fn check_metric_of_sites(
    document: &SceneDocument,
    scope: &Scope,
    (initial, parameters): (&[f64], &[f64]),
    geometry: &LatticeGeometry,
) -> Result<(), Refusal> {
    let damping = document.system.forces.damping.as_ref();
    let metric = damping.and_then(|damping| damping.metric.as_ref());
    let Some(MetricSpec::Named(entries)) = metric.map(|metric| &metric.value) else {
        return Ok(());
    };
    for_each_coordinate(document, scope, entries, |key, place, formula| {
        let value = formula.evaluate(initial, parameters);
        if value >= 0.0 && value.is_finite() {
            return Ok(());
        }
        let coordinate = geometry.name(place);
        let message = format!(
            "the metric of the damping is {value:?} at {coordinate} in the initial state, and must be finite and not negative"
        );
        let help =
            "write a metric that is not negative at any site, or the one-form itself as `forces`";
        Err(Box::new(document.diagnostic(
            &key.place(),
            message,
            "feeds energy there",
            Some(help.to_owned()),
        )))
    })
}

fn check_count<T>(
    document: &SceneDocument,
    list: &Located<T>,
    count: usize,
    moving: &[String],
    key: &str,
    of: &str,
) -> Result<(), Refusal> {
    if count == moving.len() {
        return Ok(());
    }
    let named = match moving {
        [.., last] if moving.len() > 6 => format!("{}, …, {last}", moving[..3].join(", ")),
        all => all.join(", "),
    };
    Err(Box::new(document.diagnostic(
        &list.place(),
        format!(
            "`{key}` has {count} entries where there are {} coordinates: {named}",
            moving.len()
        ),
        "another length",
        Some(of.to_owned()),
    )))
}

/// Refuses a torque without an attitude, and damping whose rate is negative, or whose metric is asymmetric or indefinite at the initial state: it would not damp. A
/// rate that depends on the state may have either sign: it is feedback.
///
/// # Errors
/// What is wrong, underlined in the scene.
pub(super) fn check_forces(
    document: &SceneDocument,
    system: &PoissonSystem,
    initial: &[f64],
) -> Result<(), Refusal> {
    check_torque(document, system, initial)?;
    let damping = system
        .expressions()
        .and_then(|f| f.forces().damping.as_ref());
    let (Some(damping), Some(spec)) = (damping, &document.system.forces.damping) else {
        return Ok(());
    };
    let refuse = |formula: &Located<String>, message: String, help: &str| {
        Err(Box::new(document.diagnostic(
            &document.place_in_formula(formula, 0..formula.value.len()),
            message,
            "at the initial state",
            Some(help.to_owned()),
        )))
    };
    let parameters = system.parameter_values();
    let rate = damping.rate.evaluate(initial, &parameters);
    let is_feedback = !damping.rate.variables().is_empty();
    if !rate.is_finite() || rate < 0.0 && !is_feedback {
        return refuse(
            &spec.rate,
            OutOfDomain::Rate(rate).to_string(),
            "a negative rate feeds energy; one that depends on the state may have either sign, as in \"k*(H - 2)\"",
        );
    }
    let (Some(metric), Some(place)) = (&spec.metric, spec.metric.as_ref().map(Located::place))
    else {
        return Ok(());
    };
    let formulas = metric.value.formulas();
    let at = |x: &[f64]| -> DMatrix<f64> {
        let value = |g: &Expression| g.evaluate(x, &parameters);
        match &damping.metric {
            // A diagonal is judged entry by entry.
            Metric::Diagonal(entries) => {
                let least = entries.iter().map(value).fold(0.0, f64::min);
                let most = entries.iter().map(|entry| value(entry).abs());
                let most = most.fold(0.0, |most, size| {
                    if size > most || size.is_nan() {
                        size
                    } else {
                        most
                    }
                });
                DMatrix::from_diagonal(&vec![least, most].into())
            }
            Metric::Full(rows) => {
                DMatrix::from_fn(rows.len(), rows.len(), |i, j| value(&rows[i][j]))
            }
        }
    };
    // A second state, so that entries do not agree by chance.
    let elsewhere: Vec<f64> = (initial.iter().enumerate())
        .map(|(i, x)| x + 0.1 * (1.0 + x.abs()) * libm::sin(1.0 + i as f64))
        .collect();
    for (x, is_initial) in [(initial, true), (&elsewhere[..], false)] {
        let metric = at(x);
        let moving = match &damping.metric {
            Metric::Diagonal(_) => 0,
            Metric::Full(_) => document.system.coordinates(),
        };
        let size = metric.amax();
        if !size.is_finite() {
            if is_initial {
                return Err(Box::new(document.diagnostic(
                    &place,
                    "the metric of the damping is not finite at the initial state",
                    "here",
                    None,
                )));
            }
            continue;
        }
        for i in 0..moving {
            for j in 0..i {
                let (one, other) = (metric[(i, j)], metric[(j, i)]);
                if (one - other).abs() > ROUND_OFF * size {
                    let formula = formulas[i * moving + j];
                    return refuse(
                        formula,
                        format!(
                            "the metric of the damping is not symmetric: entry {} of row {} is {one:?}, and entry {} of row {} {other:?}",
                            j + 1,
                            i + 1,
                            i + 1,
                            j + 1
                        ),
                        "write the same formula in both places; a part that is not symmetric belongs in `forces`",
                    );
                }
            }
        }
        let least = SymmetricEigen::new(metric).eigenvalues.min();
        if is_initial && least < -ROUND_OFF * size {
            return Err(Box::new(document.diagnostic(
                &place,
                format!(
                    "the metric of the damping has the eigenvalue {least:.3e} at the initial state, and must have no negative one"
                ),
                "feeds energy in that direction",
                Some("write a positive semidefinite metric, or the one-form itself as `forces`".to_owned()),
            )));
        }
    }
    Ok(())
}
