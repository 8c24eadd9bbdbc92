//! Rigid bodies by hand: compositions of two rotations, many bodies at once.

use leafwise::composition::Scheme;
use leafwise::expression::elementary::sin_cos_lanes;

/// A composition, with the parts of a step that its rotations take.
pub struct Composition {
    /// Its name in a scene; `none` for Strang's product itself.
    pub name: &'static str,
    /// α_1, …, α_2s.
    parts: Vec<f64>,
    /// The steps it is measured at.
    pub time_steps: &'static [f64],
}

impl Composition {
    /// Strang's product and the compositions worth measuring.
    pub fn all() -> Vec<Self> {
        let steps: [(&str, &[f64]); 7] = [
            ("suzuki-4", &[0.1]),
            ("yoshida-6", &[0.3125, 0.25]),
            ("blanes-moan-6", &[0.5, 0.4, 0.08]),
            ("kahan-li-6", &[0.5, 0.25]),
            ("kahan-li-8", &[0.5, 0.4, 0.2]),
            ("suzuki-umeno-8", &[0.5, 0.16]),
            ("sofroniou-spaletta-10", &[0.625, 0.4]),
        ];
        let strang = Self {
            name: "none",
            parts: vec![0.5, 0.5],
            time_steps: &[0.1, 0.025],
        };
        let composed = steps.into_iter().filter_map(|(name, time_steps)| {
            let scheme = Scheme::all()
                .into_iter()
                .find(|scheme| scheme.info.name == name)?;
            Some(Self {
                name,
                parts: scheme.parts(),
                time_steps,
            })
        });
        std::iter::once(strang).chain(composed).collect()
    }
}

/// Steps W rigid bodies. Less a multiple of the Casimir, H is a sum of two squares, whose flows are
/// rotations about the second and the third axis; half rotations that meet are one.
pub fn rigid_bodies<const W: usize>(
    x: &mut [[f64; W]; 3],
    inertia: &[f64],
    composition: &Composition,
    time_step: f64,
    steps: u64,
) {
    let rates = [
        1.0 / inertia[1] - 1.0 / inertia[0],
        1.0 / inertia[2] - 1.0 / inertia[0],
    ];
    let (pairs, _) = composition.parts.as_chunks::<2>();
    let mut outer = pairs[0][0];
    for step in 0..steps {
        for (at, [there, back]) in pairs.iter().enumerate() {
            about_second(x, rates[0] * time_step * outer);
            about_third(x, rates[1] * time_step * (there + back));
            let is_last = step + 1 == steps && at + 1 == pairs.len();
            let next = pairs[(at + 1) % pairs.len()][0];
            outer = if is_last { *back } else { back + next };
        }
    }
    about_second(x, rates[0] * time_step * outer);
}

/// ẋ₁ = ω x₃, ẋ₃ = −ω x₁ with ω = a x₂.
fn about_second<const W: usize>(x: &mut [[f64; W]; 3], angle: f64) {
    let mut sine = x[1].map(|x| angle * x);
    let mut cosine = [0.0; W];
    sin_cos_lanes(&mut sine, &mut cosine);
    for w in 0..W {
        let (a, b) = (x[0][w], x[2][w]);
        x[0][w] = cosine[w] * a + sine[w] * b;
        x[2][w] = cosine[w] * b - sine[w] * a;
    }
}

/// ẋ₁ = −ω x₂, ẋ₂ = ω x₁ with ω = c x₃.
fn about_third<const W: usize>(x: &mut [[f64; W]; 3], angle: f64) {
    let mut sine = x[2].map(|x| angle * x);
    let mut cosine = [0.0; W];
    sin_cos_lanes(&mut sine, &mut cosine);
    for w in 0..W {
        let (a, b) = (x[0][w], x[1][w]);
        x[0][w] = cosine[w] * a - sine[w] * b;
        x[1][w] = cosine[w] * b + sine[w] * a;
    }
}
