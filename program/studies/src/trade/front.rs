//! Which points are beaten by no other.

/// Marks the points (cost, error) that no other point beats: none costs as little and errs as
/// little, one of them less. Points without a cost or an error are on no front; an error below
/// `floor` counts as `floor`.
pub fn pareto_front(points: &[Option<(f64, f64)>], floor: f64) -> Vec<bool> {
    let mut order: Vec<(f64, f64, usize)> = points
        .iter()
        .enumerate()
        .filter_map(|(at, point)| {
            let (cost, error) = point.filter(|(c, e)| !c.is_nan() && !e.is_nan())?;
            Some((cost, error.max(floor), at))
        })
        .collect();
    order.sort_by(|a, b| {
        a.0.total_cmp(&b.0)
            .then(a.1.total_cmp(&b.1))
            .then(a.2.cmp(&b.2))
    });
    let mut front = vec![false; points.len()];
    let mut least = f64::INFINITY;
    for (_, error, at) in order {
        if error < least {
            least = error;
            front[at] = true;
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::pareto_front;

    #[test]
    fn the_front_is_what_no_point_beats() {
        let points = [
            Some((1.0, 1e-1)),
            Some((2.0, 1e-1)),
            Some((2.0, 1e-3)),
            Some((3.0, f64::NAN)),
            None,
            Some((4.0, 1e-9)),
            Some((5.0, 1e-10)),
            Some((0.5, 1.0)),
        ];
        let front = [true, false, true, false, false, true, false, true];
        assert_eq!(pareto_front(&points, 1e-8), front);
    }
}
