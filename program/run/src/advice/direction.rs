//! Hamilton's equations that run backwards in time.

use leafwise_core::Evaluator;
use leafwise_core::runge_kutta::SmoothMap;
use leafwise_core::system::Convention;
use leafwise_expression::Expression;
use leafwise_scene::compose::ComposedRun;
use leafwise_scene::document::SceneDocument;

use super::{Advice, AdviceKind, LARGEST};

/// A position q and its momentum p with q' = −∂H/∂p: the bracket's sign is that of the other convention. Their names
/// tell which is which, as q and p, x and px or x and v do. Of other names, where the scene names no convention, H tells it, as
/// a square of the momentum and none of the position.
pub(super) fn advice(document: &SceneDocument, run: &ComposedRun) -> Option<Advice> {
    let system = run.system.expressions()?;
    let names = system.variables();
    let by_name = (0..names.len()).filter_map(|q| Some((q, partner(&names[q], names)?)));
    let parameters = system.parameter_values();
    // Π_qp in ẋ = −Π ∇H: Hamilton's equations have −1.
    let is_reversed = |(q, p): &(usize, usize)| {
        let entry = system.tensor().get(&(*q.min(p), *q.max(p)));
        let value = entry.map_or(0.0, |entry| entry.evaluate(&run.near, &parameters));
        if q < p { value > 0.0 } else { value < 0.0 }
    };
    let mut found: Vec<(usize, usize)> = by_name.collect();
    if !document.system.tells_sign && document.system.library.is_none() {
        let named: Vec<usize> = found.iter().flat_map(|(q, p)| [*q, *p]).collect();
        let by_energy = by_energy(run).unwrap_or_default().into_iter();
        found.extend(by_energy.filter(|(q, p)| !named.contains(q) && !named.contains(p)));
    }
    let (q, p) = found.into_iter().find(is_reversed)?;
    let (sign, convention, other, definition) = match system.convention() {
        Convention::HamiltonianFirst => ("positive", "{H, x}", "{x,H}", "{p, q}"),
        Convention::HamiltonianSecond => ("negative", "{x, H}", "{H,x}", "{q, p}"),
    };
    let (q, p) = (&names[q], &names[p]);
    Some(Advice {
        kind: AdviceKind::BackwardTime,
        message: format!(
            "{q}' is minus the derivative of H by {p}, so that Hamilton's equations run backwards in time: \
             {{{q}, {p}}} is {sign}, and x' = {convention} needs {definition} = 1"
        ),
        change: format!("convention = \"{other}\""),
    })
}

/// The momentum or velocity that a position's name asks for: `p1` of `q1`, `px` or `vx` of `x`, `v` of `q` and `x`.
fn partner(name: &str, names: &[String]) -> Option<usize> {
    let of = |letter: char| {
        let stem = name.strip_prefix('q').or_else(|| name.strip_prefix('x'));
        let replaced = stem.map(|rest| format!("{letter}{rest}"));
        replaced.into_iter().chain([format!("{letter}{name}")])
    };
    let mut candidates = of('p').chain(of('v'));
    candidates.find_map(|wanted| names.iter().position(|known| *known == wanted))
}

/// Coordinates of each canonical pair, a constant bracket beside no other, of which H is a square of one alone: that is the
/// momentum.
fn by_energy(run: &ComposedRun) -> Option<Vec<(usize, usize)>> {
    let system = run
        .system
        .expressions()
        .filter(|_| run.near.len() <= LARGEST)?;
    let gradient = run.system.gradient_values().ok()?;
    let tensor = system.tensor();
    let own = |i: usize| run.plan.layout.own().contains(&i);
    let is_alone = |i: usize| tensor.keys().filter(|(a, b)| *a == i || *b == i).count() == 1;
    let is_constant = |entry: &Expression| entry.variables().is_empty();
    let pairs = tensor.iter().filter(|((a, b), entry)| {
        is_constant(entry) && is_alone(*a) && is_alone(*b) && own(*a) && own(*b)
    });
    let mut found = Vec::new();
    for (a, b) in pairs.map(|(pair, _)| *pair) {
        match (is_square(run, &gradient, a)?, is_square(run, &gradient, b)?) {
            (false, true) => found.push((a, b)),
            (true, false) => found.push((b, a)),
            _ => {}
        }
    }
    Some(found)
}

/// Whether ∂²H/∂x_i² is positive and the same along the line of x_i through the initial state.
fn is_square(run: &ComposedRun, gradient: &SmoothMap, i: usize) -> Option<bool> {
    const ALIKE: f64 = 1e-9;
    let parameters = run.system.parameter_values();
    let mut gradient = gradient.evaluator(&parameters, 1.0, 1.0);
    let near = &run.near;
    let mut slopes = vec![0.0; near.len()];
    let mut slope = |moved: f64| {
        let mut x = near.clone();
        x[i] += moved;
        gradient.values(&x, &mut slopes).ok()?;
        Some(slopes[i])
    };
    let unit = near[i].abs().max(1.0);
    let at_rest = slope(0.0)?;
    let curvatures = [-1.0, -0.5, 0.5, 1.0, 2.0].map(|part| {
        let moved = part * unit;
        slope(moved).map(|slope| (slope - at_rest) / moved)
    });
    let first = curvatures[0]?;
    let is_alike = |curvature: &Option<f64>| {
        curvature.is_some_and(|curvature| (curvature - first).abs() <= ALIKE * first)
    };
    Some(first > 0.0 && curvatures.iter().all(is_alike))
}
