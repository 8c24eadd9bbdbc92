//! The degree by pairs that are held out.

use crate::fit::Fitted;
use crate::squares::Squares;

/// Blocks of pairs that are held out in turn.
const FOLDS: usize = 5;

/// Root mean square of what a fit to four fifths of the pairs leaves of the others, each fifth in turn. Blocks are of consecutive pairs: neighbours on an orbit are held out together.
pub(crate) fn held_out(fitted: &Fitted, pairs: usize, ridge: f64) -> Option<f64> {
    let (mut sum, mut rows) = (0.0, 0);
    for fold in 0..FOLDS {
        let is_out = |pair: usize| pair * FOLDS / pairs == fold;
        let keeps: Vec<bool> = fitted.pair_of.iter().map(|k| !is_out(*k)).collect();
        let others: Vec<bool> = keeps.iter().map(|keeps| !keeps).collect();
        let of = |keeps: &[bool]| -> Vec<f64> {
            let right = fitted.right.iter().zip(keeps);
            right
                .filter(|(_, keeps)| **keeps)
                .map(|(b, _)| *b)
                .collect()
        };
        let squares = Squares::solve(
            &fitted.matrix.filtered(&keeps),
            &of(&keeps),
            ridge,
            fitted.tolerance,
        );
        let found = fitted.matrix.filtered(&others).times(&squares.solution);
        for (found, b) in found.iter().zip(of(&others)) {
            sum += (found - b) * (found - b);
            rows += 1;
        }
    }
    (rows > 0).then(|| libm::sqrt(sum / rows as f64))
}
