//! Numbers that are known on surfaces, between them and beyond the last one.

/// The degree of the polynomials that are blended between surfaces.
const DEGREE: usize = 5;

/// The width in s of the surfaces that the continuation beyond the last one is made of, and where it becomes constant.
const CONTINUED: f64 = 0.3;

/// Largest s of the tables: where a step looks beyond the edge, s = 1.
pub(super) const LARGEST: f64 = 1.2;

/// Places between two surfaces at which the tables are looked at, the second surface with them.
const PLACES: usize = 4;

/// Surfaces by their s.
#[derive(Clone, Debug)]
pub(super) struct Surfaces {
    s: Vec<f64>,
    /// Of all surfaces, and of those that are not the axis.
    weights: [Vec<f64>; 2],
    /// The surfaces of the continuation, the last one first.
    outer: Vec<usize>,
}

/// Parts of the numbers on the surfaces whose sum is the number at one s.
pub(super) struct Parts(Vec<f64>);

impl Surfaces {
    /// Of rising s.
    pub(super) fn new(s: &[f64]) -> Self {
        let mut outer = Vec::new();
        let last = s[s.len() - 1];
        for step in 0..=DEGREE {
            let wanted = last - CONTINUED * step as f64 / DEGREE as f64;
            let nearest = |a: &usize, b: &usize| {
                let [a, b] = [a, b].map(|at| (s[*at] - wanted).abs());
                a.total_cmp(&b)
            };
            // The axis has no number of what is divided by √s.
            let nearest = (0..s.len()).filter(|at| s[*at] > 0.0).min_by(nearest);
            outer.extend(nearest.filter(|at| !outer.contains(at)));
        }
        let off_axis: Vec<f64> = s.iter().copied().filter(|s| *s > 0.0).collect();
        Self {
            s: s.to_vec(),
            weights: [blended(s), blended(&off_axis)],
            outer,
        }
    }

    /// The surfaces' s.
    pub(super) fn s(&self) -> &[f64] {
        &self.s
    }

    /// Places from the axis to the end of the tables, some between each two surfaces.
    pub(super) fn places(&self) -> Vec<f64> {
        let inner = self.s.iter().copied().filter(|s| *s > 0.0);
        let ends: Vec<f64> = std::iter::once(0.0).chain(inner).chain([LARGEST]).collect();
        let between = ends.windows(2).flat_map(|pair| {
            let of = |place: usize| place as f64 / PLACES as f64;
            let (from, to) = (pair[0], pair[1]);
            (1..=PLACES).map(move |place| from + (to - from) * of(place))
        });
        std::iter::once(0.0).chain(between).collect()
    }

    /// Where an s lies among the surfaces, in words.
    pub(super) fn place(&self, s: f64) -> String {
        let (first, last) = (self.s[0], self.s[self.s.len() - 1]);
        if s < first {
            return format!("before the first surface, s = {first}");
        }
        if s > last {
            return format!("beyond the last surface, s = {last}");
        }
        let above = self.s.partition_point(|own| *own < s).max(1);
        format!(
            "between the surfaces s = {} and {}",
            self.s[above - 1],
            self.s[above]
        )
    }

    /// A smooth function of s by its numbers on the surfaces.
    pub(super) fn between(&self, numbers: &[f64], s: f64) -> f64 {
        self.parts(false, s).of(numbers)
    }

    /// A function divided by s^power, both smooth, by the function's numbers on the surfaces; the axis has no say.
    pub(super) fn between_over(&self, numbers: &[f64], power: f64, s: f64) -> f64 {
        let divided: Vec<f64> = (self.s.iter().zip(numbers))
            .map(|(own, number)| match *own > 0.0 {
                true => number / libm::pow(*own, power),
                false => 0.0,
            })
            .collect();
        self.parts(true, s).of(&divided)
    }

    /// The parts at s, that of the axis 0 where it has no say.
    ///
    /// Between surfaces they are the rational ones without poles (M. Floater, K. Hormann, Numer. Math. 107, 315, 2007), of order 6.
    /// Beyond the last they are those of a polynomial, of a distance that stays below [`CONTINUED`] and has the true one's
    /// first three derivatives.
    pub(super) fn parts(&self, is_off_axis: bool, s: f64) -> Parts {
        let mut parts = vec![0.0; self.s.len()];
        let last = self.s[self.s.len() - 1];
        if s > last {
            let part = (s - last) / CONTINUED;
            let distance = (s - last) / libm::sqrt(libm::sqrt(1.0 + part * part * part * part));
            for &at in &self.outer {
                let others = self.outer.iter().filter(|other| **other != at);
                parts[at] = others.fold(1.0, |product, &other| {
                    product * (last + distance - self.s[other]) / (self.s[at] - self.s[other])
                });
            }
            return Parts(parts);
        }
        let first = usize::from(is_off_axis && self.s[0] == 0.0);
        if let Some(at) = (first..self.s.len()).find(|at| self.s[*at] == s) {
            parts[at] = 1.0;
            return Parts(parts);
        }
        let weights = &self.weights[usize::from(is_off_axis)];
        let mut sum = 0.0;
        for (at, weight) in (first..self.s.len()).zip(weights) {
            parts[at] = weight / (s - self.s[at]);
            sum += parts[at];
        }
        parts.iter_mut().for_each(|part| *part /= sum);
        Parts(parts)
    }
}

impl Parts {
    /// The number at s.
    pub(super) fn of(&self, numbers: &[f64]) -> f64 {
        self.0
            .iter()
            .zip(numbers)
            .map(|(part, number)| part * number)
            .sum()
    }

    /// The parts, surface after surface.
    pub(super) fn each(&self) -> &[f64] {
        &self.0
    }
}

/// Weights of Floater and Hormann's interpolant.
fn blended(nodes: &[f64]) -> Vec<f64> {
    let count = nodes.len();
    let degree = DEGREE.min(count - 1);
    let weight = |at: usize| {
        let from = at.saturating_sub(degree);
        let to = at.min(count - 1 - degree);
        let of = |first: usize| {
            let others = (first..=first + degree).filter(|other| *other != at);
            let product: f64 = others
                .map(|other| 1.0 / (nodes[at] - nodes[other]))
                .product();
            if first.is_multiple_of(2) {
                product
            } else {
                -product
            }
        };
        (from..=to).map(of).sum()
    };
    (0..count).map(weight).collect()
}
