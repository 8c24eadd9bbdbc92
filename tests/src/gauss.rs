//! An independent integrator of high order, as an oracle.
//!
//! Gauss collocation with six stages, order 12 (Hairer, Lubich, Wanner, *Geometric Numerical
//! Integration*, section II.1.3), on the compiled vector field alone: it shares neither the
//! realization nor the Hamilton–Jacobi series with the methods under test.

use leafwise_core::PoissonSystem;

const STAGES: usize = 6;

/// Most fixed-point iterations of one step; at contraction 1/4 a double is exhausted in 27.
const MOST_ITERATIONS: usize = 100;

/// The nodes c and weights b on [0, 1], and A_ij = ∫_0^{c_i} ℓ_j.
struct Tableau {
    b: [f64; STAGES],
    a: [[f64; STAGES]; STAGES],
}

/// P_s and its derivative by the three-term recurrence.
fn legendre(z: f64) -> (f64, f64) {
    let (mut below, mut value) = (1.0, z);
    for k in 2..=STAGES {
        let k = k as f64;
        (below, value) = (value, ((2.0 * k - 1.0) * z * value - (k - 1.0) * below) / k);
    }
    (value, STAGES as f64 * (z * value - below) / (z * z - 1.0))
}

impl Tableau {
    fn new() -> Self {
        let (mut c, mut b) = ([0.0; STAGES], [0.0; STAGES]);
        for i in 0..STAGES {
            let angle = std::f64::consts::PI * (i as f64 + 0.75) / (STAGES as f64 + 0.5);
            let mut z = -libm::cos(angle);
            for _ in 0..10 {
                let (value, slope) = legendre(z);
                z -= value / slope;
            }
            let (_, slope) = legendre(z);
            c[i] = 0.5 * (1.0 + z);
            b[i] = 1.0 / ((1.0 - z * z) * slope * slope);
        }
        let lagrange = |j: usize, at: f64| -> f64 {
            (0..STAGES)
                .filter(|k| *k != j)
                .map(|k| (at - c[k]) / (c[j] - c[k]))
                .product()
        };
        let mut a = [[0.0; STAGES]; STAGES];
        for i in 0..STAGES {
            for j in 0..STAGES {
                // The quadrature itself integrates a polynomial of degree s − 1 exactly.
                a[i][j] = c[i]
                    * (0..STAGES)
                        .map(|k| b[k] * lagrange(j, c[i] * c[k]))
                        .sum::<f64>();
            }
        }
        Self { b, a }
    }
}

/// x ↦ X_H(x).
fn vector_field(system: &PoissonSystem) -> impl FnMut(&[f64], &mut [f64]) {
    let formulas = system.expressions().expect("formulas");
    let kernel = formulas.vector_field_kernel();
    let kernel = kernel.expect("a vector field with code");
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &system.parameter_values(), &[1.0], &[1.0]);
    move |x, field| kernel.evaluate(&mut workspace, x, field)
}

/// The flow of ẋ = X_H(x) over `time` in `steps` steps, with a compensated update.
///
/// # Panics
/// When the vector field has no code or an iteration does not settle.
pub fn flow(system: &PoissonSystem, initial: &[f64], time: f64, steps: usize) -> Vec<f64> {
    let tableau = Tableau::new();
    let mut vector_field = vector_field(system);
    let d = initial.len();
    let step = time / steps as f64;
    let (mut x, mut low) = (initial.to_vec(), vec![0.0; d]);
    let mut fields = vec![vec![0.0; d]; STAGES];
    let mut stage = vec![0.0; d];
    for _ in 0..steps {
        let mut last = f64::INFINITY;
        for iteration in 0.. {
            assert!(
                iteration < MOST_ITERATIONS,
                "the stages of the oracle settle"
            );
            let mut change = 0.0_f64;
            for i in 0..STAGES {
                for k in 0..d {
                    let sum: f64 = (0..STAGES).map(|j| tableau.a[i][j] * fields[j][k]).sum();
                    stage[k] = x[k] + (low[k] + step * sum);
                }
                let mut field = vec![0.0; d];
                vector_field(&stage, &mut field);
                for k in 0..d {
                    change = change.max((field[k] - fields[i][k]).abs());
                }
                fields[i] = field;
            }
            if change >= last && iteration > 3 {
                break;
            }
            last = change;
            if change == 0.0 {
                break;
            }
        }
        for k in 0..d {
            let sum: f64 = (0..STAGES).map(|j| tableau.b[j] * fields[j][k]).sum();
            let change = low[k] + step * sum;
            let next = x[k] + change;
            low[k] = change - (next - x[k]);
            x[k] = next;
        }
    }
    x
}

/// x⁺ = x + h X_H((x + x⁺)/2), the rule with one stage, by fixed-point iteration on the vector field
/// alone.
///
/// # Panics
/// When the vector field has no code.
pub fn implicit_midpoint(system: &PoissonSystem, h: f64, x: &[f64]) -> Vec<f64> {
    let mut vector_field = vector_field(system);
    let (mut next, mut field) = (x.to_vec(), vec![0.0; x.len()]);
    for _ in 0..MOST_ITERATIONS {
        let middle: Vec<f64> = x.iter().zip(&next).map(|(a, b)| 0.5 * (a + b)).collect();
        vector_field(&middle, &mut field);
        next = x.iter().zip(&field).map(|(x, f)| x + h * f).collect();
    }
    next
}
