//! Symmetric compositions of Strang's product of exact flows, flows that meet being one.

/// Exact flows of pieces of a Hamiltonian.
pub trait Flows {
    /// The state.
    type State: ?Sized;
    /// How many pieces.
    const PIECES: usize;
    /// Moves `x` along the flow of a piece.
    fn flow(piece: usize, x: &mut Self::State, time: f64);
}

/// `steps` times the composition of φ⁰_{γh/2} φ¹_{γh/2} … φᵖ_{γh} … φ¹_{γh/2} φ⁰_{γh/2} over the
/// `coefficients` γ. The outermost flows of neighbours are one flow, from one step to the next too.
#[inline(always)]
pub fn integrate<F: Flows>(coefficients: &[f64], x: &mut F::State, h: f64, steps: usize) {
    let last = F::PIECES - 1;
    let count = coefficients.len();
    F::flow(0, x, 0.5 * coefficients[0] * h);
    for step in 1..=steps {
        for at in 0..count {
            let gamma = coefficients[at];
            for piece in 1..last {
                F::flow(piece, x, 0.5 * gamma * h);
            }
            F::flow(last, x, gamma * h);
            for piece in (1..last).rev() {
                F::flow(piece, x, 0.5 * gamma * h);
            }
            let next = match coefficients.get(at + 1) {
                Some(next) => *next,
                None if step < steps => coefficients[0],
                None => 0.0,
            };
            F::flow(0, x, 0.5 * (gamma + next) * h);
        }
    }
}

/// The rotation of the plane (a, b) by `angle`, with the functions of the platform.
#[inline(always)]
pub fn rotate(a: &mut f64, b: &mut f64, angle: f64) {
    let (sine, cosine) = angle.sin_cos();
    (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
}

/// eˣ.
#[inline(always)]
#[expect(
    clippy::disallowed_methods,
    reason = "a baseline takes the functions of the platform"
)]
pub fn exponential(x: f64) -> f64 {
    x.exp()
}
