//! The search for the multiples of a step.

use super::NAME;
use super::lane::{Begin, FIRST_CHANGE, LARGEST_SECANT, LaneOfEnergy, MOST_ROUNDINGS};
use super::line::Line;
use crate::error::StepError;

/// Steps of Newton's method in several multiples, at most, and halvings of one.
const MOST_NEWTON: usize = 40;
const MOST_HALVINGS: u32 = 12;

/// A unit of each multiple whose Casimir has a size.
fn axes(units: &[f64]) -> Vec<Vec<f64>> {
    let axis = |c: usize| {
        let mut axis = vec![0.0; units.len()];
        axis[c] = units[c];
        axis
    };
    (0..units.len())
        .filter(|c| units[*c] > 0.0)
        .map(axis)
        .collect()
}

impl LaneOfEnergy {
    /// Multiples at which the energy's error is 0, the nearest to the last one of one Casimir. Of several Casimirs they are the
    /// nearest to 0, else to the last ones, else a multiple of one alone.
    pub(super) fn search(
        &mut self,
        (units, least): (&[f64], f64),
        begin: Begin<'_>,
        increment: &mut [f64],
    ) -> Result<(), StepError> {
        let last = self.multiples().to_vec();
        self.signs = [false; 2];
        let from = match units.len() {
            1 => last.clone(),
            several => vec![0.0; several],
        };
        let error = self.attempt(&from, begin, increment)?;
        if error.abs() <= least {
            return Ok(());
        }
        let most = MOST_ROUNDINGS * least;
        let axes = axes(units);
        let mut best = error.abs();
        if axes.len() > 1 {
            for start in [&from, &last] {
                let found = self.by_newton((start, &axes), least, begin, increment);
                let Some((multiples, error)) = found else {
                    continue;
                };
                if error.abs() <= most {
                    return self.attempt(&multiples, begin, increment).map(|_| ());
                }
                best = best.min(error.abs());
            }
        }
        for direction in axes {
            let mut line = Line {
                of: self,
                from: &from,
                direction: &direction,
                least,
                begin,
                increment,
            };
            let found = line.search(error);
            if found.error.abs() <= most {
                let multiples = line.multiples(found.change);
                return self.attempt(&multiples, begin, increment).map(|_| ());
            }
            best = best.min(found.error.abs());
        }
        if best <= most {
            return self.attempt(&from, begin, increment).map(|_| ());
        }
        Err(self.no_root(best))
    }

    /// Newton's method in all multiples at once. Of the changes that take the linear error away it makes the least, no longer than
    /// [`LARGEST_SECANT`] units, halved until the error falls. Slopes are differences at first, then secants of rank one while
    /// these halve the error (C. Broyden, Math. Comp. 19 (1965)).
    fn by_newton(
        &mut self,
        (start, axes): (&[f64], &[Vec<f64>]),
        least: f64,
        begin: Begin<'_>,
        increment: &mut [f64],
    ) -> Option<(Vec<f64>, f64)> {
        let mut here = start.to_vec();
        let mut error = self.attempt(&here, begin, increment).ok()?;
        let mut slopes = self.slopes((&here, axes), error, begin, increment)?;
        let mut are_new = true;
        let unit = |axis: &Vec<f64>| axis.iter().sum::<f64>();
        let squares: Vec<f64> = axes.iter().map(|axis| unit(axis) * unit(axis)).collect();
        for _ in 0..MOST_NEWTON {
            if error.abs() <= least {
                break;
            }
            // Along the slopes by the multiples themselves, which have the least norm.
            let along = slopes.iter().zip(&squares);
            let along: Vec<f64> = along.map(|(slope, square)| slope / square).collect();
            let square: f64 = slopes.iter().zip(&along).map(|(slope, a)| slope * a).sum();
            let size = along.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
            let size = size * (error / square).abs();
            let part = -error / square * (LARGEST_SECANT / size).min(1.0);
            let change: Vec<f64> = along.iter().map(|a| part * a).collect();
            let next = if square > 0.0 && part.is_finite() {
                self.halved((&here, axes), &change, error, begin, increment)
            } else {
                None
            };
            let Some((multiples, other, part)) = next else {
                if are_new {
                    break;
                }
                slopes = self.slopes((&here, axes), error, begin, increment)?;
                are_new = true;
                continue;
            };
            are_new = other.abs() > 0.5 * error.abs();
            if are_new {
                slopes = self.slopes((&multiples, axes), other, begin, increment)?;
            } else {
                let made: Vec<f64> = change.iter().map(|change| part * change).collect();
                let square: f64 = made.iter().map(|made| made * made).sum();
                let along: f64 = slopes
                    .iter()
                    .zip(&made)
                    .map(|(slope, made)| slope * made)
                    .sum();
                let off = (other - error - along) / square;
                slopes
                    .iter_mut()
                    .zip(&made)
                    .for_each(|(slope, made)| *slope += off * made);
            }
            (here, error) = (multiples, other);
        }
        Some((here, error))
    }

    /// The first of a change, its half, its quarter, … with a smaller error: the multiples there, the error, and the part.
    fn halved(
        &mut self,
        (here, axes): (&[f64], &[Vec<f64>]),
        change: &[f64],
        error: f64,
        begin: Begin<'_>,
        increment: &mut [f64],
    ) -> Option<(Vec<f64>, f64, f64)> {
        (0..MOST_HALVINGS).find_map(|halving| {
            let part = libm::exp2(-f64::from(halving));
            let mut multiples = here.to_vec();
            for (axis, change) in axes.iter().zip(change) {
                let pairs = multiples.iter_mut().zip(axis);
                pairs.for_each(|(multiple, unit)| *multiple += part * change * unit);
            }
            let other = self.attempt(&multiples, begin, increment).ok()?;
            (other.abs() < error.abs()).then_some((multiples, other, part))
        })
    }

    /// The slopes of the energy along units of the multiples, by differences. One along which no step is made counts as none.
    fn slopes(
        &mut self,
        (from, axes): (&[f64], &[Vec<f64>]),
        error: f64,
        begin: Begin<'_>,
        increment: &mut [f64],
    ) -> Option<Vec<f64>> {
        let slope = |axis: &Vec<f64>| {
            let pairs = from.iter().zip(axis);
            let there: Vec<f64> = pairs
                .map(|(multiple, unit)| multiple + FIRST_CHANGE * unit)
                .collect();
            let changed = self.attempt(&there, begin, increment);
            changed.map_or(0.0, |changed| (changed - error) / FIRST_CHANGE)
        };
        let slopes: Vec<f64> = axes.iter().map(slope).collect();
        slopes.iter().any(|slope| *slope != 0.0).then_some(slopes)
    }

    fn no_root(&self, best: f64) -> StepError {
        let why = match self.signs {
            [true, true] => "the search between errors of both signs did not converge",
            _ => "H(x_{k+1}) - H(x_0) has the same sign for all that were tried",
        };
        StepError::Part {
            part: NAME.to_owned(),
            message: format!(
                "no multiple of the Casimirs keeps the energy in this step: {why}. The smallest error is {best:.1e}, of H(x_0) = \
                 {:.6}. Some orbits have such states, and steps of another length have others; end the run earlier, or leave `energy` \
                 out",
                self.target
            ),
        }
    }
}
