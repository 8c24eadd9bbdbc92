//! Gauss methods by fixed-point iteration; one stage is the implicit midpoint rule.

/// a_ij and b_i of the Gauss method with S stages (Hairer, Lubich, Wanner, *Geometric Numerical
/// Integration*, section II.1.3), and the stage slopes one step later from those of this one: the
/// collocation polynomial's derivative continued.
pub struct Gauss<const S: usize> {
    a: [[f64; S]; S],
    b: [f64; S],
    next: [[f64; S]; S],
}

/// The implicit midpoint rule.
pub const MIDPOINT: Gauss<1> = Gauss {
    a: [[0.5]],
    b: [1.0],
    next: [[1.0]],
};

const ROOT_3: f64 = 1.732_050_807_568_877_2;
const ROOT_15: f64 = 3.872_983_346_207_417;

/// Order 4.
pub fn gauss_4() -> Gauss<2> {
    let c = [0.5 - ROOT_3 / 6.0, 0.5 + ROOT_3 / 6.0];
    Gauss {
        a: [[0.25, 0.25 - ROOT_3 / 6.0], [0.25 + ROOT_3 / 6.0, 0.25]],
        b: [0.5, 0.5],
        next: continued(c),
    }
}

/// Order 6.
pub fn gauss_6() -> Gauss<3> {
    let r = ROOT_15;
    let c = [0.5 - r / 10.0, 0.5, 0.5 + r / 10.0];
    Gauss {
        a: [
            [5.0 / 36.0, 2.0 / 9.0 - r / 15.0, 5.0 / 36.0 - r / 30.0],
            [5.0 / 36.0 + r / 24.0, 2.0 / 9.0, 5.0 / 36.0 - r / 24.0],
            [5.0 / 36.0 + r / 30.0, 2.0 / 9.0 + r / 15.0, 5.0 / 36.0],
        ],
        b: [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0],
        next: continued(c),
    }
}

/// The Lagrange polynomials of the nodes c at c + 1.
fn continued<const S: usize>(c: [f64; S]) -> [[f64; S]; S] {
    let mut next = [[1.0; S]; S];
    for i in 0..S {
        for j in 0..S {
            for k in (0..S).filter(|k| *k != j) {
                next[i][j] *= (c[i] + 1.0 - c[k]) / (c[j] - c[k]);
            }
        }
    }
    next
}

impl<const S: usize> Gauss<S> {
    /// The state after `steps` steps of size `h`, and the evaluations of the field. The iteration
    /// ends where corrections are round-off or stop shrinking.
    #[inline(always)]
    pub fn integrate<const D: usize>(
        &self,
        field: impl Fn(&[f64; D]) -> [f64; D],
        mut x: [f64; D],
        h: f64,
        steps: usize,
    ) -> ([f64; D], u64) {
        let mut slopes = [field(&x); S];
        let mut evaluations = 1;
        let mut low = [0.0; D];
        for _ in 0..steps {
            let earlier = slopes;
            for i in 0..S {
                for c in 0..D {
                    slopes[i][c] = (0..S).map(|j| self.next[i][j] * earlier[j][c]).sum();
                }
            }
            let mut last = f64::INFINITY;
            for _ in 0..100 {
                let mut size = 0.0_f64;
                let before = slopes;
                for i in 0..S {
                    let mut stage = x;
                    for c in 0..D {
                        let sum: f64 = (0..S).map(|j| self.a[i][j] * before[j][c]).sum();
                        stage[c] += h * sum;
                    }
                    slopes[i] = field(&stage);
                    for c in 0..D {
                        size = size.max((slopes[i][c] - before[i][c]).abs());
                    }
                }
                evaluations += S as u64;
                let scale = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                if h * size <= 0.5 * f64::EPSILON * scale || size >= last {
                    break;
                }
                last = size;
            }
            for c in 0..D {
                let sum: f64 = (0..S).map(|j| self.b[j] * slopes[j][c]).sum();
                let change = h * sum + low[c];
                let new = x[c] + change;
                low[c] = change - (new - x[c]);
                x[c] = new;
            }
        }
        (x, evaluations)
    }
}
