//! Long series reduced to what a picture can show, extremes kept.

/// The largest value of each of `bins` equal stretches of the horizontal axis, at its place.
/// A value that is not finite outranks every finite one.
pub(super) fn maxima(points: &[(f64, f64)], bins: usize) -> Vec<(f64, f64)> {
    reduce(points, bins, |bin, kept| {
        let rank = |value: f64| {
            if value.is_finite() {
                value
            } else {
                f64::INFINITY
            }
        };
        kept.extend(
            bin.iter()
                .copied()
                .max_by(|a, b| rank(a.1).total_cmp(&rank(b.1))),
        );
    })
}

/// First, smallest, largest and last value of each of `bins` equal stretches, in order.
pub(super) fn envelope(points: &[(f64, f64)], bins: usize) -> Vec<(f64, f64)> {
    reduce(points, bins, |bin, kept| {
        let indices = 0..bin.len();
        let least = indices
            .clone()
            .min_by(|&a, &b| bin[a].1.total_cmp(&bin[b].1));
        let greatest = indices.max_by(|&a, &b| bin[a].1.total_cmp(&bin[b].1));
        let mut chosen: Vec<_> = [Some(0), least, greatest, bin.len().checked_sub(1)]
            .into_iter()
            .flatten()
            .collect();
        chosen.sort_unstable();
        chosen.dedup();
        kept.extend(chosen.into_iter().map(|index| bin[index]));
    })
}

/// The mean of each of `bins` equal stretches, at its first place.
pub(super) fn means(points: &[(f64, f64)], bins: usize) -> Vec<(f64, f64)> {
    reduce(points, bins, |bin, kept| {
        let sum: f64 = bin.iter().map(|point| point.1).sum();
        kept.push((bin[0].0, sum / bin.len() as f64));
    })
}

/// Applies `keep` to runs of points whose first coordinates fall into one bin of [0, 1].
fn reduce(
    points: &[(f64, f64)],
    bins: usize,
    keep: impl Fn(&[(f64, f64)], &mut Vec<(f64, f64)>),
) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    let bin_of = |x: f64| (x * bins as f64) as usize;
    for run in points.chunk_by(|a, b| bin_of(a.0) == bin_of(b.0)) {
        keep(run, &mut kept);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimation_keeps_every_extreme() {
        let spike = 777;
        let points: Vec<_> = (0..100_000)
            .map(|k| {
                (
                    k as f64 / 1e5,
                    if k == spike { 9.0 } else { (k % 3) as f64 },
                )
            })
            .collect();
        for kept in [maxima(&points, 300), envelope(&points, 300)] {
            assert!(kept.len() <= 4 * 301);
            assert!(kept.contains(&points[spike]));
        }
        let mut broken = points;
        broken[5].1 = f64::NAN;
        assert!(maxima(&broken, 300)[0].1.is_nan());
    }
}
