//! Sizes of coordinates, which their changes are measured by.

use leafwise_scene::compose::ComposedRun;

/// The least size of each coordinate along a run.
///
/// The sites of a family have the largest size of all of them. A site at rest, far from a wave, moves by 1e-30 in a
/// step: no method has a digit of that, and no step is short enough. Variables whose names differ by a number alone, q1
/// and q2, share their largest size too, where they are 0 or of both signs along the run. What keeps one sign, such as
/// a population, has its own size at each state, however small that is.
pub(super) struct Sizes(Vec<f64>);

impl Sizes {
    /// Those along `states` of a run.
    pub fn of(run: &ComposedRun, states: &[Vec<f64>]) -> Self {
        let names = names(run);
        let kinds: Vec<Option<&str>> = (names.iter().enumerate())
            .map(|(at, name)| {
                let has_a_sign =
                    states.iter().all(|x| x[at] > 0.0) || states.iter().all(|x| x[at] < 0.0);
                match name.split_once('[') {
                    Some((family, _)) => Some(family),
                    None if has_a_sign => None,
                    None => Some(name.trim_end_matches(|c: char| c.is_ascii_digit())),
                }
            })
            .collect();
        let largest = |kind: Option<&str>| {
            let alike = (0..kinds.len()).filter(|at| kinds[*at] == kind);
            let values = alike.flat_map(|at| states.iter().map(move |x| x[at].abs()));
            kind.map_or(0.0, |_| values.fold(0.0, f64::max))
        };
        Self(kinds.iter().map(|kind| largest(*kind)).collect())
    }

    /// Relative difference of two increments from x, a = `whole` and b = `finer`: (max_i |a_i − b_i|/s_i) / (max_i
    /// |b_i|/s_i). Here s_i is the largest of the least size of coordinate i, |x_i|, |x_i + a_i| and |x_i + b_i|. A
    /// numerator of 64 ε or less, round-off of a state, counts as 0.
    pub fn difference(&self, x: &[f64], whole: &[f64], finer: &[f64]) -> f64 {
        let (mut apart, mut motion) = (0.0_f64, 0.0_f64);
        for (at, ((x, whole), finer)) in x.iter().zip(whole).zip(finer).enumerate() {
            let own = x.abs().max((x + whole).abs()).max((x + finer).abs());
            let size = self.0[at].max(own);
            if size > 0.0 {
                apart = apart.max((whole - finer).abs() / size);
                motion = motion.max(finer.abs() / size);
            }
        }
        // Round-off of a state is no motion.
        if apart > f64::EPSILON * 64.0 {
            apart / motion
        } else {
            0.0
        }
    }
}

/// The names of all coordinates that are stepped.
fn names(run: &ComposedRun) -> Vec<String> {
    match run.method.lattice() {
        Some(geometry) => (0..run.dimension()).map(|at| geometry.name(at)).collect(),
        None => run.system.variables().to_vec(),
    }
}
