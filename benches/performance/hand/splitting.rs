//! Symmetric compositions of exact flows, flows that meet being one.

/// Exact flows of pieces of a Hamiltonian.
pub trait Flows {
    /// The state.
    type State: ?Sized;
    /// How many pieces.
    const PIECES: usize;
    /// Moves `x` along the flow of a piece.
    fn flow(piece: usize, x: &mut Self::State, time: f64);
}

/// `steps` times the composition of φ⁰ φ¹ … φᵖ over α_1 h, φᵖ … φ¹ φ⁰ over α_2 h, and so on in turn, an even number of
/// `parts` α. Flows of one piece that meet are one flow, from one step to the next too.
#[inline(always)]
pub fn integrate<F: Flows>(parts: &[f64], x: &mut F::State, h: f64, steps: usize) {
    let last = F::PIECES - 1;
    F::flow(0, x, parts[0] * h);
    for step in 1..=steps {
        for at in (0..parts.len()).step_by(2) {
            let [there, back] = [parts[at], parts[at + 1]];
            for piece in 1..last {
                F::flow(piece, x, there * h);
            }
            F::flow(last, x, (there + back) * h);
            for piece in (1..last).rev() {
                F::flow(piece, x, back * h);
            }
            let next = match parts.get(at + 2) {
                Some(next) => *next,
                None if step < steps => parts[0],
                None => 0.0,
            };
            F::flow(0, x, (back + next) * h);
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
