//! Where states leave the domain of a formula.

/// Of states side by side, those outside H's domain: their energies, of which `is_nan` tells, are no numbers, wherever coordinates
/// that are 0 move a little to either side. A logarithm at 0, an infinite value, is at the edge of it, where the motion may
/// be regular; the logarithm of a negative number is outside.
pub fn outside(
    state: &[f64],
    lanes: usize,
    mut is_nan: impl FnMut(&[f64], &mut Vec<bool>),
) -> Vec<bool> {
    let mut outside = vec![true; lanes];
    for tiny in [0.0, f64::MIN_POSITIVE, -f64::MIN_POSITIVE] {
        let moved = state.iter().map(|x| if *x == 0.0 { tiny } else { *x });
        let moved: Vec<f64> = moved.collect();
        let mut here = Vec::with_capacity(lanes);
        is_nan(&moved, &mut here);
        for (outside, here) in outside.iter_mut().zip(here) {
            *outside &= here;
        }
        if !outside.contains(&true) {
            break;
        }
    }
    outside
}
