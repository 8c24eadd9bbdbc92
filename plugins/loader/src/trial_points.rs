//! States and momenta that parts are tried at.

/// States that most domains contain: positive, all different, not too large.
pub(crate) fn states(d: usize) -> Vec<Vec<f64>> {
    [(0.75, 0.25), (1.125, -0.0625), (0.875, 0.125)]
        .into_iter()
        .map(|(first, step)| {
            let at = |i: usize| first + step * (i % 8) as f64 + (i / 8) as f64 / 64.0;
            (0..d).map(at).collect()
        })
        .collect()
}

/// Small momenta, one for each state.
pub(crate) fn momenta(d: usize) -> Vec<Vec<f64>> {
    [0.02, -0.03, 0.01]
        .into_iter()
        .map(|size| {
            (0..d)
                .map(|i| size * (1.0 - 0.3 * (i % 5) as f64))
                .collect()
        })
        .collect()
}
