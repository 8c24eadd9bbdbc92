//! The Casimirs by which drawn states go onto the symplectic leaf of their center.

use leafwise_core::Evaluator;
use leafwise_core::runge_kutta::SmoothMap;
use leafwise_scene::compose::{ComposedRun, Refusal};
use leafwise_scene::document::{EnsembleSection, Located, SceneDocument};

/// The corank of Π at a point, and how many of the declared Casimirs are independent there; `None` where
/// they have no value.
fn ranks(run: &ComposedRun, invariants: &SmoothMap, x: &[f64]) -> Option<(usize, usize)> {
    let d = x.len();
    let parameters = run.system.parameter_values();
    let numbers = run.system.numbers().ok()?;
    let mut numbers = numbers.evaluator(&parameters);
    let mut tensor = vec![0.0; d * d];
    for (k, column) in tensor.chunks_exact_mut(d).enumerate() {
        let mut unit = vec![0.0; d];
        unit[k] = 1.0;
        numbers.tensor(x, &unit, column).ok()?;
    }
    let mut map = invariants.evaluator(&parameters, 1.0, 1.0);
    let mut rows = vec![0.0; invariants.outputs() * d];
    let mut values = vec![0.0; invariants.outputs()];
    map.values(x, &mut values).ok()?;
    map.jacobians(x, &mut rows).ok()?;
    Some((d - rank(tensor, d), rank(rows.split_off(d), d)))
}

/// Entries below this part of what they were formed from are round-off.
const ROUND_OFF: f64 = 1e-11;

/// Rank of a matrix with rows of `width` numbers, whatever the units of its rows and columns. Both are scaled to 1,
/// then eliminated with the largest entry that is left as pivot.
fn rank(mut matrix: Vec<f64>, width: usize) -> usize {
    let height = matrix.len() / width;
    for _ in 0..4 {
        for row in matrix.chunks_exact_mut(width) {
            let most = row.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            if most > 0.0 {
                row.iter_mut().for_each(|value| *value /= most);
            }
        }
        for column in 0..width {
            let entries = (0..height).map(|row| matrix[row * width + column].abs());
            let most = entries.fold(0.0, f64::max);
            if most > 0.0 {
                (0..height).for_each(|row| matrix[row * width + column] /= most);
            }
        }
    }
    let mut rows: Vec<Vec<f64>> = matrix.chunks_exact(width).map(<[f64]>::to_vec).collect();
    let mut rank = 0;
    while !rows.is_empty() {
        let entries = rows.iter().enumerate().flat_map(|(i, row)| {
            let entries = row.iter().enumerate();
            entries.map(move |(j, value)| (value.abs(), i, j))
        });
        let largest = entries.fold(
            (0.0, 0, 0),
            |most, entry| if entry.0 > most.0 { entry } else { most },
        );
        let (size, i, j) = largest;
        if size <= ROUND_OFF {
            break;
        }
        let pivot = rows.swap_remove(i);
        for row in &mut rows {
            let factor = row[j] / pivot[j];
            row.iter_mut()
                .zip(&pivot)
                .for_each(|(value, p)| *value -= factor * p);
            row[j] = 0.0;
        }
        rank += 1;
    }
    rank
}

/// Energy and Casimirs of a system whose members are drawn on leaves.
///
/// # Errors
/// Casimirs that do not fix the leaf through `center`; a system or lattice without their gradients.
pub(super) fn leaves(
    document: &SceneDocument,
    ensemble: &EnsembleSection,
    run: &ComposedRun,
    center: &[f64],
) -> Result<SmoothMap, Refusal> {
    let place = ensemble.initial.as_ref().map(Located::place);
    let refuse = |message: String| {
        let place = place.as_ref().unwrap_or(&ensemble.place);
        let help =
            "declare the missing Casimirs, draw from a ball, or start on another leaf".to_owned();
        Box::new(document.diagnostic(place, message, "here", Some(help)))
    };
    if run.method.lattice().is_some() {
        let place = place.as_ref().unwrap_or(&ensemble.place);
        return Err(Box::new(document.diagnostic(
            place,
            "on a lattice of this length every site has a separate leaf, and moving onto them is not supported: \
             Newton's method along the Casimirs' gradients solves for only a few Casimirs",
            "on the leaf",
            Some("draw from a ball, or give the members' states by a file".to_owned()),
        )));
    }
    let map = run
        .system
        .invariants_map()
        .map_err(|error| refuse(error.to_string()))?;
    if map.has_jacobian() && map.outputs() > 1 {
        let ranks = ranks(run, &map, center);
        if let Some((corank, independent)) = ranks.filter(|(corank, own)| corank > own) {
            return Err(refuse(format!(
                "the leaf through the center has {corank} equations, the corank of the tensor there, and \
                 {independent} independent Casimirs are declared: their common level set is larger than the leaf"
            )));
        }
        return Ok(map);
    }
    Err(refuse(
        "the way onto a leaf needs the Casimirs' gradients, and this system offers none".to_owned(),
    ))
}
