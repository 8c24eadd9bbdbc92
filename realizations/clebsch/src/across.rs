//! The way from a z to the fibre of an x nearby, where blocks of DJ are orthogonal.

use std::ops::Range;

use leafwise_expression::Rational;

use crate::forms::Forms;

/// Blocks of forms, each moved by coordinates of its own: DJ is block triangular. The rows D_k of a diagonal block are
/// orthogonal, D_k D_lᵀ = c_k |z_N|² δ_kl with one set N of coordinates.
///
/// So δ with DJ δ = r is found block by block, without a matrix.
#[derive(Clone, Debug)]
pub struct Across {
    blocks: Vec<Block>,
}

#[derive(Clone, Debug)]
struct Block {
    /// N.
    norm: Vec<usize>,
    rows: Vec<Row>,
}

/// D_k of a diagonal block.
#[derive(Clone, Debug)]
struct Row {
    k: usize,
    /// c_k.
    c: f64,
    /// D_k has f z_b at a, for these (f, a, b).
    entries: Vec<(f64, usize, usize)>,
}

impl Across {
    /// The blocks of forms, their coordinates in groups that end at `groups` and at the last one; none where there are none.
    pub fn of(forms: &Forms, groups: &[usize]) -> Option<Self> {
        let n = forms.coordinates();
        let matrices: Vec<_> = (0..forms.count()).map(|k| forms.matrix(k)).collect();
        let mut open: Vec<usize> = (0..forms.count()).collect();
        let mut blocks = Vec::new();
        let mut from = 0;
        for end in groups.iter().copied().chain([n]) {
            // Forms that later coordinates do not move.
            let is_closed = |k: &usize| matrices[*k][end * n..].iter().all(Rational::is_zero);
            let closed: Vec<usize> = open.iter().copied().filter(is_closed).collect();
            open.retain(|k| !closed.contains(k));
            if !closed.is_empty() {
                blocks.push(Block::of(n, &matrices, &closed, from..end)?);
            }
            from = end;
        }
        open.is_empty().then_some(Self { blocks })
    }

    /// Whether all directions of x are alike: DJ DJᵀ is a multiple of the identity.
    pub fn is_round(&self) -> bool {
        let [block] = &self.blocks[..] else {
            return false;
        };
        let mut factors = block.rows.iter().map(|row| row.c);
        let first = factors.next();
        factors.all(|c| Some(c) == first)
    }

    /// Adds a δ with DJ δ = r to z; nothing in a block where z is 0.
    #[inline]
    pub fn add<const N: usize>(&self, forms: &Forms, rest: &[f64], z: &mut [f64]) {
        let mut delta = [0.0; N];
        for (place, block) in self.blocks.iter().enumerate() {
            let square: f64 = block.norm.iter().map(|a| z[*a] * z[*a]).sum();
            if square == 0.0 {
                continue;
            }
            for Row { k, c, entries } in &block.rows {
                let mut rest = rest[*k];
                if place > 0 {
                    for &(factor, a, b) in forms.products(*k) {
                        rest -= factor * (z[a] * delta[b] + delta[a] * z[b]);
                    }
                }
                let part = rest / (c * square);
                for &(factor, a, b) in entries {
                    delta[a] += part * (factor * z[b]);
                }
            }
        }
        for (z, delta) in z.iter_mut().zip(&delta) {
            *z += delta;
        }
    }
}

impl Block {
    fn of(
        n: usize,
        matrices: &[Vec<Rational>],
        forms: &[usize],
        columns: Range<usize>,
    ) -> Option<Self> {
        let zero = Rational::from_integer(0);
        let mut norm: Option<Vec<usize>> = None;
        let mut rows = Vec::new();
        for &k in forms {
            for &l in forms.iter().filter(|l| **l <= k) {
                // D_k D_lᵀ = zᵀ (Σ_a S_k e_a e_aᵀ S_l) z over these columns a.
                let (first, second) = (&matrices[k], &matrices[l]);
                let entry = |i: usize, j: usize| {
                    let mut sum = zero.clone();
                    for a in columns.clone() {
                        sum += &(&first[i * n + a] * &second[a * n + j]);
                    }
                    sum
                };
                let mut diagonal = Vec::new();
                for i in 0..n {
                    for j in 0..i {
                        if !(&entry(i, j) + &entry(j, i)).is_zero() {
                            return None;
                        }
                    }
                    diagonal.push(entry(i, i));
                }
                let support: Vec<usize> = (0..n).filter(|i| !diagonal[*i].is_zero()).collect();
                if k != l {
                    if !support.is_empty() {
                        return None;
                    }
                    continue;
                }
                let c = diagonal[*support.first()?].clone();
                let is_even = support.iter().all(|i| diagonal[*i] == c);
                if !is_even || norm.as_ref().is_some_and(|norm| *norm != support) {
                    return None;
                }
                norm = Some(support);
                let mut entries = Vec::new();
                for a in columns.clone() {
                    let own = (0..n).filter(|b| !first[a * n + b].is_zero());
                    entries.extend(own.map(|b| (first[a * n + b].to_f64(), a, b)));
                }
                let c = c.to_f64();
                rows.push(Row { k, c, entries });
            }
        }
        Some(Self { norm: norm?, rows })
    }
}
