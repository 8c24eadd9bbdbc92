//! Symplectic leaves that are ellipsoids, as pictures show them.

use leafwise_report::Ellipsoid;
use leafwise_scene::compose::ComposedRun;

/// The symplectic leaf through the initial state, where a Casimir of a three-dimensional system makes it an ellipsoid.
/// Then C(x) = C(0) + Σ (a_i x_i² + b_i x_i) with a_i of one sign. The form is read off C at seven points and tested at
/// others.
pub(super) fn leaf(run: &ComposedRun) -> Option<Ellipsoid> {
    if run.dimension() != 3 {
        return None;
    }
    let mut invariants = run.invariants().ok()?;
    let mut start = vec![0.0; invariants.observables()];
    invariants.evaluate(&run.plan.initial, &mut start);
    let mut values = start.clone();
    (1..start.len()).find_map(|index| {
        let mut casimir = |x: [f64; 3]| {
            invariants.evaluate(&x, &mut values);
            values[index]
        };
        ellipsoid(&mut casimir, start[index], &run.plan.initial)
    })
}

fn ellipsoid(
    casimir: &mut dyn FnMut([f64; 3]) -> f64,
    level: f64,
    initial: &[f64],
) -> Option<Ellipsoid> {
    let origin = casimir([0.0; 3]);
    let (mut a, mut b) = ([0.0; 3], [0.0; 3]);
    for i in 0..3 {
        let mut unit = [0.0; 3];
        unit[i] = 1.0;
        let plus = casimir(unit) - origin;
        unit[i] = -1.0;
        let minus = casimir(unit) - origin;
        a[i] = (plus + minus) / 2.0;
        b[i] = (plus - minus) / 2.0;
    }
    let form = |x: &[f64; 3]| {
        (0..3)
            .map(|i| (a[i] * x[i] + b[i]) * x[i])
            .fold(origin, |sum, term| sum + term)
    };
    let probes = [
        [0.7, -1.3, 2.1],
        [-2.9, 0.4, 1.6],
        [initial[0], initial[1], initial[2]],
    ];
    let agrees = probes.iter().all(|x| {
        let (value, expected) = (casimir(*x), form(x));
        let size = (0..3)
            .map(|i| (a[i] * x[i] * x[i]).abs() + (b[i] * x[i]).abs())
            .sum::<f64>();
        (value - expected).abs() <= 1e-12 * (size + origin.abs())
    });
    let center = [0, 1, 2].map(|i| -b[i] / (2.0 * a[i]));
    let radius = level - form(&center);
    let semi_axes = [0, 1, 2].map(|i| libm::sqrt(radius / a[i]));
    let is_ellipsoid = semi_axes.iter().all(|axis| axis.is_finite() && *axis > 0.0);
    (agrees && is_ellipsoid).then_some(Ellipsoid { center, semi_axes })
}

#[cfg(test)]
mod tests {
    use super::ellipsoid;

    #[test]
    fn a_quadratic_casimir_gives_its_ellipsoid_and_others_give_none() {
        let start = [1.0, 3.0, 3.0];
        let mut sphere = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>();
        let leaf = ellipsoid(&mut sphere, 19.0, &start).expect("a sphere");
        assert_eq!(leaf.center, [0.0; 3]);
        assert!(
            leaf.semi_axes
                .iter()
                .all(|a| (a - libm::sqrt(19.0)).abs() < 1e-15)
        );
        let mut ratio = |x: [f64; 3]| x[0] * x[2] / x[1];
        assert_eq!(ellipsoid(&mut ratio, 1.0, &start), None);
        let mut saddle = |x: [f64; 3]| x[0] * x[0] + x[1] * x[1] - x[2] * x[2];
        assert_eq!(ellipsoid(&mut saddle, 1.0, &start), None);
        let mut mixed = |x: [f64; 3]| x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[0] * x[1];
        assert_eq!(ellipsoid(&mut mixed, 22.0, &start), None);
    }
}
