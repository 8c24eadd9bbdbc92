//! Orders by least squares, with the round-off plateau dropped.

/// A line fitted to log(error) over log(parameter).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// The fitted exponent.
    pub exponent: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// How many points lay above the plateau.
    pub points: usize,
}

/// Fits error ≈ c·parameter^exponent to points (parameter, error), dropping those at or under
/// `plateau`, the size of round-off in the error. `None` with fewer than three points left.
pub fn fit_slope(points: &[(f64, f64)], plateau: f64) -> Option<Slope> {
    let kept: Vec<(f64, f64)> = points
        .iter()
        .filter(|(p, e)| *e > plateau && e.is_finite() && *p > 0.0)
        .map(|(p, e)| (libm::log(*p), libm::log(*e)))
        .collect();
    if kept.len() < 3 {
        return None;
    }
    let count = kept.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| kept.iter().map(f).sum::<f64>() / count;
    let (centre, level) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = kept.iter().map(|p| (p.0 - centre) * (p.0 - centre)).sum();
    let exponent = kept
        .iter()
        .map(|p| (p.0 - centre) * (p.1 - level))
        .sum::<f64>()
        / spread;
    let misfit: f64 = kept
        .iter()
        .map(|p| {
            let residual = p.1 - level - exponent * (p.0 - centre);
            residual * residual
        })
        .sum();
    let standard_error = libm::sqrt(misfit / (count - 2.0) / spread);
    Some(Slope {
        exponent,
        standard_error,
        points: kept.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::fit_slope;

    #[test]
    fn a_power_law_above_its_plateau_has_its_exponent() {
        let points: Vec<_> = (1..12)
            .map(|k| libm::exp2(-f64::from(k)))
            .map(|h| (h, 3.0 * h * h * h + 1e-9))
            .collect();
        let slope = fit_slope(&points, 1e-7).expect("enough points");
        assert!((slope.exponent - 3.0).abs() < 0.01, "{slope:?}");
        assert!(fit_slope(&points, 1.0).is_none());
    }
}
