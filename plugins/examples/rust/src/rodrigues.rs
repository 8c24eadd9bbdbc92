//! T*SO(3) in modified Rodrigues parameters.

use leafwise_plugin_sdk::{ChartRealization, Create, Fail, Formula, HostSystem, Info, Part};

/// T*SO(3) in the chart R = exp(φ \[n\]×), p = 4 tan(φ/4) n of modified Rodrigues parameters:
///
/// α(x, p) = x − ½ x×p + ⅛ (p·x) p − (|p|²/16) x,  β(x, p) = α(x, −p).
///
/// From x·dp = ⟨α, vee(dR Rᵀ)⟩: along n, α is x times 1 + |p|²/16; across it, x times 1 − |p|²/16,
/// turned by −½ x×p. A polynomial: nothing to divide by, no series near p = 0.
pub struct Rodrigues;

/// The same for a host that takes formulas, with p scaled by ε.
const FORMULAS: &[Formula] = &[
    Formula::new(
        c"alpha.1",
        c"x1 - epsilon*(x2*p3 - x3*p2)/2 + epsilon^2*((x1*p1 + x2*p2 + x3*p3)*p1/8 - (p1^2 + p2^2 + p3^2)*x1/16)",
    ),
    Formula::new(
        c"alpha.2",
        c"x2 - epsilon*(x3*p1 - x1*p3)/2 + epsilon^2*((x1*p1 + x2*p2 + x3*p3)*p2/8 - (p1^2 + p2^2 + p3^2)*x2/16)",
    ),
    Formula::new(
        c"alpha.3",
        c"x3 - epsilon*(x1*p2 - x2*p1)/2 + epsilon^2*((x1*p1 + x2*p2 + x3*p3)*p3/8 - (p1^2 + p2^2 + p3^2)*x3/16)",
    ),
];

impl Part for Rodrigues {
    const INFO: Info = Info::new(
        c"example/so3-rodrigues",
        c"T*SO(3) in modified Rodrigues parameters: exact, polynomial",
    )
    .declares(c"exact")
    .domain(c"so(3)*; all p, rotations by less than a full turn a step")
    .reference(c"Schaub & Junkins, J. Astronautical Sci. 44 (1996) 1-19, for the parameters")
    .dimensions(3, 3)
    .formulas(FORMULAS)
    .exact()
    .cotangent_chart()
    .reversible();

    fn create(args: &Create<'_>) -> Result<Self, Fail> {
        check_tensor(&args.system()?)?;
        Ok(Self)
    }
}

/// Π(y) v = y × v for the basis of both arguments: both sides are linear in v, and a tensor that
/// agrees on e_i, on −2 e_i and at one point more is taken to be linear in y.
fn check_tensor(system: &HostSystem) -> Result<(), Fail> {
    let points = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [-2.0, 0.0, 0.0],
        [0.0, -2.0, 0.0],
        [0.0, 0.0, -2.0],
        [3.0, 5.0, -7.0],
    ];
    for y in points {
        for i in 0..3 {
            let mut v = [0.0; 3];
            v[i] = 1.0;
            let mut product = [0.0; 3];
            system.tensor(&y, &v, &mut product)?;
            if product != cross(&y, &v) {
                return Err(Fail::unsupported(format!(
                    "the tensor is not that of so(3)*: at {y:?}, Π(y)·e{} is {product:?} and y × e{0} is {:?}",
                    i + 1,
                    cross(&y, &v)
                )));
            }
        }
    }
    Ok(())
}

fn cross(a: &[f64], b: &[f64]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl ChartRealization for Rodrigues {
    const JACOBIAN: bool = true;

    fn dimension(&self) -> usize {
        3
    }

    fn parts(
        &mut self,
        epsilon: f64,
        x: &[f64],
        p: &[f64],
        even: &mut [f64],
        odd: &mut [f64],
    ) -> Result<(), Fail> {
        let turn = cross(x, p);
        let along = dot(p, x) * (epsilon * epsilon / 8.0);
        let square = dot(p, p) * (epsilon * epsilon / 16.0);
        for i in 0..3 {
            even[i] = along * p[i] - square * x[i];
            odd[i] = -0.5 * epsilon * turn[i];
        }
        Ok(())
    }

    fn jacobian(
        &mut self,
        epsilon: f64,
        x: &[f64],
        p: &[f64],
        even: &mut [f64],
        odd: &mut [f64],
    ) -> Result<(), Fail> {
        let eighth = epsilon * epsilon / 8.0;
        let half = 0.5 * epsilon;
        let (along, square) = (dot(p, x), dot(p, p));
        for i in 0..3 {
            for j in 0..3 {
                let diagonal = f64::from(u8::from(i == j));
                even[i * 6 + j] = eighth * (p[i] * p[j] - 0.5 * square * diagonal);
                even[i * 6 + 3 + j] = eighth * (along * diagonal + x[j] * p[i] - p[j] * x[i]);
                // x × p by x_j is e_j × p, by p_j it is x × e_j.
                let mut unit = [0.0; 3];
                unit[j] = 1.0;
                odd[i * 6 + j] = -half * cross(&unit, p)[i];
                odd[i * 6 + 3 + j] = -half * cross(x, &unit)[i];
            }
        }
        Ok(())
    }
}
