//! The settings that methods are tried at.

use super::candidate::{Candidate, Knob, Setting};
use super::error::TradeError;

/// A sequence of settings, each finer than the one before.
#[derive(Clone, Debug, PartialEq)]
pub enum Grid {
    /// first·ratioᵏ steps, rounded.
    Geometric {
        /// The fewest steps.
        first: f64,
        /// The ratio of neighbours.
        ratio: f64,
        /// How many.
        count: usize,
    },
    /// These numbers of steps.
    List(Vec<u64>),
    /// 10^(−first − k/per_decade), with a fixed number of steps.
    Tolerances {
        /// The exponent of the largest.
        first: f64,
        /// How many a factor of ten.
        per_decade: f64,
        /// How many.
        count: usize,
        /// The steps within which the method chooses its own.
        steps: u64,
    },
}

/// The coarsest step of the grid is this many times the scene's.
const COARSEST: f64 = 16.0;

/// The steps within which an adaptive method chooses its own are this many times the scene's.
const ADAPTIVE: f64 = 64.0;

/// Settings of the default grid: the finest step is the coarsest over 2¹⁵.
const COUNT: usize = 31;

impl Grid {
    /// The grid on which a method is compared: a ratio of √2 between neighbours, the scene's own
    /// number of steps among them; tolerances from 10⁻² to 10⁻¹⁴, two a decade.
    pub fn standard(candidate: &Candidate, steps: u64) -> Self {
        match candidate.knob {
            Knob::Steps => Self::Geometric {
                first: steps as f64 / COARSEST,
                ratio: std::f64::consts::SQRT_2,
                count: COUNT,
            },
            Knob::Tolerance => Self::Tolerances {
                first: 2.0,
                per_decade: 2.0,
                count: 25,
                steps: libm::ceil(steps as f64 / ADAPTIVE).max(1.0) as u64,
            },
        }
    }

    /// Grid of a reference solution. Steps are halved from twice the scene's on; tolerances are lowered tenfold from
    /// 10⁻¹¹ on, as far as the method takes them. Within the scene's steps an adaptive method chooses its own: it does
    /// not step over anything that it looks at in each of them.
    pub(super) fn of_reference(candidate: &Candidate, steps: u64) -> Self {
        match candidate.knob {
            Knob::Steps => Self::Geometric {
                first: 0.5 * steps as f64,
                ratio: 2.0,
                count: usize::MAX,
            },
            Knob::Tolerance => Self::Tolerances {
                first: 11.0,
                per_decade: 1.0,
                count: 6,
                steps: steps.max(1),
            },
        }
    }

    /// Reads `100,200,400`, or `100..6400` for a ratio of √2 between the ends.
    ///
    /// # Errors
    /// [`TradeError::Steps`] with what is wrong.
    pub fn parse(text: &str) -> Result<Self, TradeError> {
        let wrong = |reason: &str| TradeError::Steps {
            text: text.to_owned(),
            reason: reason.to_owned(),
        };
        let number = |text: &str| match text.trim().parse::<u64>() {
            Ok(0) | Err(_) => Err(wrong(
                "write whole numbers of steps, from 1 on, as 100,200,400 or from 100..6400",
            )),
            Ok(steps) => Ok(steps),
        };
        let Some((first, last)) = text.split_once("..") else {
            let list: Result<Vec<u64>, _> = text.split(',').map(number).collect();
            let mut list = list?;
            list.sort_unstable();
            list.dedup();
            return Ok(Self::List(list));
        };
        let (first, last) = (number(first)?, number(last)?);
        if first > last {
            return Err(wrong("the first number is the smaller one"));
        }
        let halves = 2.0 * libm::log2(last as f64 / first as f64);
        Ok(Self::Geometric {
            first: first as f64,
            ratio: std::f64::consts::SQRT_2,
            // The last is reached where the ends are powers of √2 apart.
            count: libm::floor(halves + 1e-9) as usize + 1,
        })
    }

    /// The k-th setting, `None` behind the last.
    pub fn setting(&self, k: usize) -> Option<Setting> {
        match self {
            Self::Geometric {
                first,
                ratio,
                count,
            } => (k < *count).then(|| Setting {
                steps: libm::round(first * libm::pow(*ratio, k as f64)).max(1.0) as u64,
                tolerance: None,
            }),
            Self::List(list) => list.get(k).map(|&steps| Setting {
                steps,
                tolerance: None,
            }),
            Self::Tolerances {
                first,
                per_decade,
                count,
                steps,
            } => (k < *count).then(|| Setting {
                steps: *steps,
                tolerance: Some(tolerance(first + k as f64 / per_decade)),
            }),
        }
    }

    /// All settings, without repetitions.
    pub fn settings(&self) -> Vec<Setting> {
        let mut settings: Vec<Setting> = (0..).map_while(|k| self.setting(k)).collect();
        settings.dedup();
        settings
    }
}

/// 10^(−exponent) with two digits.
pub(super) fn tolerance(exponent: f64) -> f64 {
    let value = libm::pow(10.0, -exponent);
    format!("{value:.1e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(grid: &Grid) -> Vec<u64> {
        grid.settings().iter().map(|s| s.steps).collect()
    }

    #[test]
    fn steps_are_read_as_lists_and_as_ranges() {
        let grid = |text| Grid::parse(text).expect("a list");
        assert_eq!(steps(&grid("400, 100,200,100")), [100, 200, 400]);
        assert_eq!(steps(&grid("100..400")), [100, 141, 200, 283, 400]);
        assert_eq!(steps(&grid("1..3")), [1, 2, 3]);
        assert_eq!(steps(&grid("7..7")), [7]);
        for text in ["", "0", "4..2", "a..b", "-3", "1.5"] {
            assert!(Grid::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn tolerances_have_two_digits() {
        let grid = Grid::Tolerances {
            first: 2.0,
            per_decade: 2.0,
            count: 3,
            steps: 5,
        };
        let tolerances: Vec<_> = grid.settings().iter().map(|s| s.tolerance).collect();
        assert_eq!(tolerances, [Some(1e-2), Some(3.2e-3), Some(1e-3)]);
    }
}
