//! Splittings in loops by the exact flows of pairs that share no site: vortices in the plane and on a sphere.

use leafwise::core::Structure;
use leafwise::core::gradient::{Plan, Trajectory};
use leafwise_tests::scenes::end;

use super::in_loops;

const ORDER_8: &str = "stepper = \"splitting\"\ncomposition = \"suzuki-umeno-8\"";
const GAUSS: &str = "stepper = { name = \"gauss\", stages = 4 }";

/// Vortices of unlike circulations, of either sign, on a sphere of radius 2, in a field that turns them about z.
fn on_a_sphere(sites: usize, method: &str, time_step: f64, steps: usize) -> String {
    format!(
        "[system]\nfamilies = {{ r = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }} }}\n\
         parameters = {{ w = 0.1, R = 2, \"g[i]\" = \"1 + 1.5*sin(i)\" }}\nconvention = \"{{x,H}}\"\n\
         bracket = {{ \"r.x[i],r.y[i]\" = \"r.z[i]/(R*g[i])\", \"r.y[i],r.z[i]\" = \"r.x[i]/(R*g[i])\", \"r.z[i],r.x[i]\" = \"r.y[i]/(R*g[i])\" }}\n\
         hamiltonian = \"w*sum(i, g[i]*r.z[i]) - sum(i<j, g[i]*g[j]*ln(R^2 - dot(r[i], r[j])))/(4*pi)\"\n\
         [method]\n{method}\ntime-step = {time_step:e}\n[run]\nsteps = {steps}\n[run.initial]\n\
         \"r.x[i]\" = \"2*sqrt(1 - (1 - (2*i + 1)/N)^2)*cos(2.4*i)\"\n\
         \"r.y[i]\" = \"2*sqrt(1 - (1 - (2*i + 1)/N)^2)*sin(2.4*i)\"\n\"r.z[i]\" = \"2 - 2*(2*i + 1)/N\"\n"
    )
}

/// The same in the plane, with weights of pairs.
fn in_the_plane(sites: usize, method: &str, time_step: f64, steps: usize) -> String {
    format!(
        "[system]\nfamilies = {{ x = {sites}, y = {sites} }}\nconvention = \"{{x,H}}\"\n\
         parameters = {{ w = 1.5, \"g[i]\" = \"1 + 1.5*sin(i)\", \"W[i,j]\" = \"1 + 0.2*cos(i*j)\" }}\n\
         bracket = {{ \"x[i],y[i]\" = \"1/g[i]\" }}\n\
         hamiltonian = \"-w*sum(i<j, W[i,j]*g[i]*g[j]*ln((x[i] - x[j])^2 + (y[i] - y[j])^2))/(4*pi)\"\n\
         [method]\n{method}\ntime-step = {time_step:e}\n[run]\nsteps = {steps}\n[run.initial]\n\
         \"x[i]\" = \"sqrt(i + 1)*cos(2.4*i)\"\n\"y[i]\" = \"sqrt(i + 1)*sin(2.4*i)\"\n"
    )
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// The motion is that of Gauss' method of order 8: of an odd and of an even number of sites, with terms of one site and numbers
/// of pairs beside. Both are off by powers of the step alone, of size 1e-11 here, as half the step says.
#[test]
fn rounds_of_pairs_have_the_motion_of_gauss_method() {
    for sites in [17, 20] {
        for system in [on_a_sphere, in_the_plane] {
            let ends = [(GAUSS, 0.02, 50), (ORDER_8, 0.02, 50), (ORDER_8, 0.01, 100)];
            let [exact, once, half] = ends.map(|(method, time_step, steps)| {
                let run = in_loops(&system(sites, method, time_step, steps));
                end(&run)
            });
            let errors = [&once, &half].map(|end| distance(end, &exact));
            assert!(
                errors[0] <= 1e-9 && errors[1] <= 1e-11,
                "{sites}: {errors:?}"
            );
        }
    }
    let run = in_loops(&on_a_sphere(20, ORDER_8, 0.02, 1));
    assert_eq!(run.method.map().properties().structure, Structure::Exact);
}

/// A ring of N equal vortices at colatitude θ on a sphere of radius R turns at (N − 1)Γ cos θ/(4πR² sin² θ) (Polvani, Dritschel,
/// J. Fluid Mech. 255 (1993)). Lengths and ΣΓr are kept to round-off, a few units of each of N − 1 turns of a vortex in 15 stages.
#[test]
fn rings_on_a_sphere_turn_at_their_rate() {
    for (sites, angle, steps) in [(16, 0.02, 20), (33, 0.01, 20), (100, 0.004, 10)] {
        let n = sites as f64;
        let (theta, radius) = (0.8, 2.0);
        let (sin, cos) = (libm::sin(theta), libm::cos(theta));
        let rate = (n - 1.0) * cos / (4.0 * std::f64::consts::PI * radius * radius * sin * sin);
        let run = in_loops(&format!(
            "[system]\nlibrary = \"vortices-on-sphere\"\nfamilies = {{ r = {sites} }}\nparameters = {{ R = {radius} }}\n\
             [method]\n{ORDER_8}\ntime-step = {:e}\n[run]\nsteps = {steps}\n[run.initial]\n\
             \"r.x[i]\" = \"{}*cos(2*pi*i/N)\"\n\"r.y[i]\" = \"{}*sin(2*pi*i/N)\"\n\"r.z[i]\" = {}\n",
            angle / rate,
            radius * sin,
            radius * sin,
            radius * cos
        ));
        let x = end(&run);
        let rows: Vec<&[f64]> = x.chunks(sites).take(3).collect();
        let kept = n * 16.0 * f64::EPSILON * 30.0 * f64::from(steps) * angle.max(0.1);
        let sums = [rows[0], rows[1]].map(|row| row.iter().sum::<f64>() / n);
        assert!(
            sums.iter().all(|sum| sum.abs() <= kept),
            "{sites}: {sums:?}"
        );
        let turned = angle * f64::from(steps);
        for i in 0..sites {
            let length: f64 = rows.iter().map(|row| row[i] * row[i]).sum();
            assert!(
                (length - radius * radius).abs() <= kept,
                "{sites}: {length}"
            );
            let at = 2.0 * std::f64::consts::PI * i as f64 / n + turned;
            let expected = [radius * sin * libm::cos(at), radius * sin * libm::sin(at)];
            for (row, expected) in rows.iter().zip(expected) {
                // The ring is unstable: round-off grows by less than e^{nφ/4} as in the plane. The step's own error is of order 8
                // in the angle of the nearest pair, n times that of the ring.
                let allowed = kept * libm::exp(n * turned / 4.0) + 1e-10 * turned;
                let found = row[i];
                assert!(
                    (found - expected).abs() <= allowed,
                    "{sites} {i}: {found} {expected} {allowed:e}"
                );
            }
        }
    }
}

const PLAN: Plan = Plan { steps: 5, every: 5 };

/// Gradients by the initial state, by circulations, which stand behind it, and by parameters of all are those of differences of
/// order 6 of whole runs, and transposes of tangents.
#[test]
fn derivatives_of_rounds_are_those_of_differences() {
    let method = "stepper = \"splitting\"\ncomposition = \"suzuki-4\"";
    for system in [on_a_sphere, in_the_plane] {
        let run = in_loops(&system(17, method, 0.05, 5));
        let parameters = run.system.parameter_values();
        let initial = &run.plan.initial;
        let at = |parameters: &[f64], initial: &[f64]| -> (f64, Vec<f64>) {
            let at = trajectory(&run, parameters);
            let reached = at.run(initial, PLAN).expect("a run");
            let weights = (0..reached.samples.len()).map(|i| libm::sin(1.0 + 0.7 * i as f64));
            let weights: Vec<f64> = weights.collect();
            let value = reached.samples.iter().zip(&weights);
            (value.map(|(x, w)| x * w).sum(), weights)
        };
        let own = trajectory(&run, &parameters);
        let reached = own.run(initial, PLAN).expect("a run");
        let (_, weights) = at(&parameters, initial);
        let pulled = own.pull(initial, &reached, &weights, PLAN, (true, None));
        let pulled = pulled.expect("a gradient");
        let difference = |value: &dyn Fn(f64) -> f64, size: f64| {
            let delta = 1e-3 * size.abs().max(0.05);
            let slope = |delta: f64| (value(delta) - value(-delta)) / (2.0 * delta);
            (64.0 * slope(delta) - 20.0 * slope(2.0 * delta) + slope(4.0 * delta)) / 45.0
        };
        for k in [0, 5, 20, initial.len() - 17, initial.len() - 3] {
            let value = |delta: f64| {
                let mut point = initial.clone();
                point[k] += delta;
                at(&parameters, &point).0
            };
            let (expected, found) = (difference(&value, initial[k]), pulled.initial[k]);
            let allowed = 1e-7 * (1.0 + expected.abs());
            assert!(
                (found - expected).abs() <= allowed,
                "{k}: {found} {expected}"
            );
        }
        let value = |delta: f64| {
            let mut point = parameters.to_vec();
            point[0] += delta;
            at(&point, initial).0
        };
        let (expected, found) = (difference(&value, parameters[0]), pulled.parameters[0]);
        assert!(
            (found - expected).abs() <= 1e-7 * (1.0 + expected.abs()),
            "{found} {expected}"
        );
        let direction: Vec<f64> = (0..initial.len())
            .map(|i| libm::cos(0.3 * i as f64))
            .collect();
        let pushed = own.push(initial, (&direction, &[]), PLAN);
        let tangents = pushed.expect("tangents").tangents;
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let sides = [
            product(&weights, &tangents),
            product(&pulled.initial, &direction),
        ];
        assert!(
            (sides[0] - sides[1]).abs() <= 1e-11 * (1.0 + sides[0].abs()),
            "{sides:?}"
        );
    }
}

fn trajectory<'a>(run: &'a leafwise::scene::ComposedRun, parameters: &'a [f64]) -> Trajectory<'a> {
    Trajectory {
        map: run.method.map(),
        parameters,
        epsilon: run.plan.epsilon,
        h: run.plan.h,
        goes_on: &|| true,
    }
}

/// Two hundred vortices compose as twenty do, from the formulas of one pair.
#[test]
fn hundreds_of_vortices_are_split_by_the_flow_of_one_pair() {
    let run = in_loops(&in_the_plane(200, "stepper = \"splitting\"", 1e-3, 1));
    assert_eq!(run.method.map().pieces(), 199);
}
