//! Scales that corrections are judged against.

use super::Block;
use super::masks::{Row, select};
use crate::elimination::{Rows, dimension};
use crate::judge::{
    Doubles, ROUND_OFF, at_least, at_most, larger, relative, scale_beside, settled,
};

/// Over so many components at most a motion is followed to where it reaches.
const MOST_HANDS: usize = 8;

impl<const W: usize, const D: usize, V: Rows<W>, M: Rows<W>> Block<W, D, V, M> {
    /// Corrections in place of residuals, and what they are judged against.
    #[inline(always)]
    pub(super) fn correct(
        &mut self,
        y: &[Row<W>],
        correction: &mut [Row<W>],
        increment: &[Row<W>],
        active: &[bool; W],
    ) {
        let d = dimension::<D>(self.dimension);
        let (x, y) = (&self.x.as_ref()[..d], &y[..d]);
        let (correction, increment) = (&mut correction[..d], &increment[..d]);
        let (slope, scale) = (&self.slope.as_ref()[..d * d], &mut self.scale.as_mut()[..d]);
        self.factors.solve::<D>(correction);
        let (allowed, smallest, reached) = (
            &mut self.allowed.as_mut()[..d],
            &mut self.smallest.as_mut()[..d],
            &mut self.reached.as_mut()[..d],
        );
        // A component may be the round-off of what the others put into it, Σ_j |D − 1|_ij |y_j|. Its increment may be far larger
        // than itself where the iterate is far off: beside it every correction is small. It counts as far as two iterates agree
        // on it.
        for i in 0..d {
            let mut reach = [0.0_f64; W];
            for j in 0..d {
                for w in 0..W {
                    reach[w] += slope[i * d + j][w] * (y[j][w].abs() + correction[j][w].abs());
                }
            }
            let mut judged = [0.0; W];
            for w in 0..W {
                let change = increment[i][w].abs();
                if active[w] {
                    let (known, least) = (&mut allowed[i][w], &mut smallest[i][w]);
                    let has_begun = *least < f64::INFINITY;
                    *least = at_most(*least, change);
                    if has_begun {
                        *known = at_least(*known, *least);
                    }
                }
                let beside = [&x[i][w], &change, &allowed[i][w], &reach[w]];
                judged[w] = scale_beside(&mut Doubles, beside);
            }
            select(active, &mut scale[i], &judged);
            reached[i] = reach;
        }
        for w in 0..W {
            if active[w] && self.lanes[w].is_anchor_far {
                self.take_back(w);
            }
        }
    }

    /// Takes from a lane's scales what D⁻¹ takes back of the round-off that components put into one another.
    #[cold]
    fn take_back(&mut self, w: usize) {
        let d = dimension::<D>(self.dimension);
        let (slope, reached) = (self.slope.as_ref(), self.reached.as_ref());
        for i in 0..d {
            let own = reached[i][w];
            let again = (0..d).map(|j| slope[i * d + j][w] * reached[j][w]).sum();
            self.scale.as_mut()[i][w] -= own - settled(own, again);
        }
    }

    /// Size of a lane's correction, each component beside Σ_k |D − 1|ᵏ s. The sum is what the scales s of all that
    /// are settled and that it is coupled with, at first hand and at later ones, put into it. One that begins to move
    /// at a high order in the step has the size of that motion.
    #[cold]
    pub(super) fn size_in_all(
        [correction, scale, slope]: [&[Row<W>]; 3],
        w: usize,
        [reached, next]: [&mut Vec<f64>; 2],
    ) -> f64 {
        let d = scale.len();
        let settled = |i: usize| match relative(correction[i][w], scale[i][w]) <= ROUND_OFF {
            true => scale[i][w],
            false => 0.0,
        };
        for (i, reached) in reached.iter_mut().enumerate() {
            *reached = settled(i);
        }
        for _ in 0..d.min(MOST_HANDS) {
            for (i, next) in next.iter_mut().enumerate() {
                let others = (0..d).map(|j| slope[i * d + j][w] * reached[j]);
                *next = settled(i) + others.sum::<f64>();
            }
            reached.copy_from_slice(next);
        }
        let sizes = correction.iter().zip(&*reached);
        sizes.fold(0.0, |size, (correction, whole)| {
            larger(size, relative(correction[w], *whole))
        })
    }
}
