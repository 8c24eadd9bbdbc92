//! A point over a state, by least squares, where no section is known.

use crate::forms::Forms;

/// Random starts for each choice of signs.
const STARTS: usize = 8;

/// Steps from a start.
const STEPS: usize = 200;

/// Residuals below this part of the sizes of their summands are round-off.
const KNOWN: f64 = 1e-14;

/// Writes a z with x = ½ Σ σ zᵀS z over its copies, with signs where there is room for them; whether one was found.
///
/// Levenberg and Marquardt's method from some starts, first with all signs +, then with one − and so on.
pub fn over(forms: &Forms, x: &[f64], z: &mut [f64], signs: &mut [f64]) -> bool {
    z.fill(0.0);
    signs.fill(1.0);
    let size = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if size == 0.0 {
        return true;
    }
    let mut state = 1_u64;
    for minus in 0..=signs.len() {
        for (a, sign) in signs.iter_mut().rev().enumerate() {
            *sign = if a < minus { -1.0 } else { 1.0 };
        }
        for _ in 0..STARTS {
            for z in z.iter_mut() {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                let uniform = (state >> 11) as f64 / (1_u64 << 53) as f64;
                *z = libm::sqrt(size) * (2.0 * uniform - 1.0);
            }
            if descend(forms, x, z, signs) {
                return true;
            }
        }
    }
    false
}

/// Moves z to where the residual is round-off; whether it came there.
fn descend(forms: &Forms, x: &[f64], z: &mut [f64], signs: &[f64]) -> bool {
    let (d, n) = (x.len(), z.len());
    let mut damping = 1e-3;
    let (mut rest, mut is_known) = residual(forms, x, z, signs);
    let mut polished = 0;
    for _ in 0..STEPS {
        if is_known {
            polished += 1;
            damping = 0.0;
            if polished > 2 {
                return true;
            }
        }
        let mut rows = vec![vec![0.0; n]; d];
        let v = forms.coordinates();
        for (a, copy) in z.chunks_exact(v).enumerate() {
            let sign = signs.get(a).copied().unwrap_or(1.0);
            for (k, row) in rows.iter_mut().enumerate() {
                forms.add_slopes(k, sign, copy, &mut row[a * v..][..v]);
            }
        }
        let mut gram = vec![vec![0.0; d]; d];
        for i in 0..d {
            for j in 0..d {
                gram[i][j] = rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum();
            }
        }
        let trace: f64 = (0..d).map(|i| gram[i][i]).sum();
        for (i, row) in gram.iter_mut().enumerate() {
            row[i] += damping * trace / d as f64 + f64::MIN_POSITIVE;
        }
        let Some(factors) = solved(gram, rest.clone()) else {
            return is_known;
        };
        let mut moved = z.to_vec();
        for (row, factor) in rows.iter().zip(&factors) {
            for (z, slope) in moved.iter_mut().zip(row) {
                *z += factor * slope;
            }
        }
        let (next, is_next_known) = residual(forms, x, &moved, signs);
        let square = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
        if square(&next) < square(&rest) {
            z.copy_from_slice(&moved);
            (rest, is_known) = (next, is_next_known);
            damping *= 0.2;
        } else if is_known {
            return true;
        } else {
            damping = if damping == 0.0 { 1e-12 } else { 4.0 * damping };
            if damping > 1e6 {
                return false;
            }
        }
    }
    is_known
}

/// x − J(z), and whether that is round-off.
fn residual(forms: &Forms, x: &[f64], z: &[f64], signs: &[f64]) -> (Vec<f64>, bool) {
    let d = x.len();
    let (mut image, mut sizes) = (vec![0.0; d], vec![0.0; d]);
    for (a, copy) in z.chunks_exact(forms.coordinates()).enumerate() {
        let sign = signs.get(a).copied().unwrap_or(1.0);
        forms.add_image(sign, copy, &mut image, &mut sizes);
    }
    let most = sizes
        .iter()
        .chain(x)
        .fold(0.0_f64, |most, v| most.max(v.abs()));
    let rest: Vec<f64> = x.iter().zip(&image).map(|(x, image)| x - image).collect();
    let is_known = rest.iter().all(|rest| rest.abs() <= KNOWN * most);
    (rest, is_known)
}

/// G⁻¹ r by elimination; `None` where G is singular.
fn solved(mut gram: Vec<Vec<f64>>, mut r: Vec<f64>) -> Option<Vec<f64>> {
    let d = r.len();
    for k in 0..d {
        let pivot = (k..d).max_by(|a, b| gram[*a][k].abs().total_cmp(&gram[*b][k].abs()))?;
        gram.swap(k, pivot);
        r.swap(k, pivot);
        if gram[k][k] == 0.0 || !gram[k][k].is_finite() {
            return None;
        }
        for i in k + 1..d {
            let factor = gram[i][k] / gram[k][k];
            if factor == 0.0 {
                continue;
            }
            for j in k..d {
                gram[i][j] -= factor * gram[k][j];
            }
            r[i] -= factor * r[k];
        }
    }
    for k in (0..d).rev() {
        for j in k + 1..d {
            r[k] -= gram[k][j] * r[j];
        }
        r[k] /= gram[k][k];
    }
    Some(r)
}
