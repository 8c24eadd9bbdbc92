//! Verdict on a run that records MEGNO: regular, chaotic, or not yet known.
//!
//! Ȳ tends to 2 on tori and to 0 where neighbours do not part (isochronous motion). Along chaotic motion it grows like λt/2.
//! Judged by the second half of a run, the motion is
//!
//! - regular, where Ȳ stays at or below 2.2 and changes by 0.2 at most. E-folding times below a quarter of the run would
//!   have shown.
//! - regular too, where forces make neighbours approach: Ȳ ends at −4 or less, and at 1.5 times or more of its negative
//!   value in the middle.
//! - chaotic, where Ȳ ends at 4 or more and at 1.5 times or more of its value in the middle.
//! - unstable in its place, where the motion is a flow on a leaf of two dimensions, which is not chaotic.
//! - not yet known elsewhere, and where fewer than 8 samples lie there.

use leafwise_scene::compose::ComposedRun;
use leafwise_scene::json::{double, optional};
use serde::Serialize;

/// Samples in the second half, at least.
const LEAST_SAMPLES: usize = 8;

/// The largest Ȳ of regular motion, and its largest change.
const REGULAR: f64 = 2.2;
const STEADY: f64 = 0.2;

/// The smallest Ȳ of chaotic motion at the end, and its smallest growth from the middle on; with the other sign, those of
/// neighbours that approach.
const CHAOTIC: f64 = 4.0;
const GROWTH: f64 = 1.5;

/// How a motion looks so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionKind {
    /// Neighbours part as on a torus, or not at all, or approach.
    Regular,
    /// Neighbours part exponentially.
    Chaotic,
    /// Neighbours part exponentially so far, in two dimensions, where a motion is not chaotic.
    Unstable,
    /// Neither yet.
    NotYetKnown,
}

/// Verdict of MEGNO on a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChaosVerdict {
    /// Regular, chaotic, unstable or not yet known.
    pub motion: MotionKind,
    /// Ȳ at the end.
    #[serde(serialize_with = "double")]
    pub megno: f64,
    /// 1/λ of chaotic motion, λ from `lyapunov` where that is recorded, else from the growth of Ȳ.
    #[serde(serialize_with = "optional", skip_serializing_if = "Option::is_none")]
    pub e_folding_time: Option<f64>,
    /// |t| at the end.
    #[serde(skip)]
    time: f64,
}

impl ChaosVerdict {
    /// Of samples (t, Ȳ), with the largest exponent at the end where it is recorded.
    pub(crate) fn new(samples: &[(f64, f64)], exponent: Option<f64>) -> Option<Self> {
        let &(end, megno) = samples.last()?;
        let is_late = |(time, _): &&(f64, f64)| time.abs() >= 0.5 * end.abs();
        let late: Vec<(f64, f64)> = samples.iter().filter(is_late).copied().collect();
        let &(middle, half) = late.first()?;
        let (least, most) = late.iter().fold((half, half), |(least, most), (_, value)| {
            (least.min(*value), most.max(*value))
        });
        let is_known = late.len() >= LEAST_SAMPLES && late.iter().all(|(_, y)| y.is_finite());
        let is_steady = most <= REGULAR && most - least <= STEADY;
        let is_falling = half < 0.0 && megno <= -CHAOTIC && megno <= GROWTH * half;
        let motion = if is_known && (is_steady || is_falling) {
            MotionKind::Regular
        } else if is_known && megno >= CHAOTIC && megno >= GROWTH * half {
            MotionKind::Chaotic
        } else {
            MotionKind::NotYetKnown
        };
        let grown = 2.0 * (megno - half) / (end - middle).abs();
        let e_folding_time = 1.0 / exponent.unwrap_or(grown);
        Some(Self {
            motion,
            megno,
            e_folding_time: (motion == MotionKind::Chaotic).then_some(e_folding_time),
            time: end.abs(),
        })
    }

    /// The same of a run's motion: in two dimensions unstable in the place of chaotic.
    #[must_use]
    pub fn of(self, run: &ComposedRun) -> Self {
        let is_unstable =
            self.motion == MotionKind::Chaotic && run.is_planar().is_ok_and(|planar| planar);
        match is_unstable {
            true => Self {
                motion: MotionKind::Unstable,
                e_folding_time: None,
                ..self
            },
            false => self,
        }
    }

    /// In a sentence.
    pub fn text(&self) -> String {
        let megno = format!("MEGNO {:.3}", self.megno);
        match (self.motion, self.e_folding_time) {
            (MotionKind::Chaotic, Some(time)) => {
                let time = rounded(time, 2);
                format!("chaotic, e-folding time {time}: {megno}, and growing")
            }
            (MotionKind::Unstable, _) => format!(
                "unstable: {megno}, and growing; neighbours diverge exponentially so far, but a motion in two dimensions is not chaotic"
            ),
            (MotionKind::Regular, _) if self.megno <= -CHAOTIC => {
                format!("regular: {megno}, and falling; neighbours approach")
            }
            (MotionKind::Regular, _) => format!(
                "regular: {megno}, and steady; an e-folding time below {} would have shown",
                rounded(0.25 * self.time, 1)
            ),
            _ => format!(
                "not yet known: {megno}; regular motion tends to 2 or stays below, chaotic motion grows; take more steps"
            ),
        }
    }
}

/// A number with so many digits behind the first.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.digits$e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::{ChaosVerdict, MotionKind};

    fn of(megno: impl Fn(f64) -> f64, count: usize) -> ChaosVerdict {
        let times = (0..=count).map(|k| 1000.0 * k as f64 / count as f64);
        let samples: Vec<(f64, f64)> = times.map(|t| (t, megno(t))).collect();
        ChaosVerdict::new(&samples, None).expect("samples")
    }

    #[test]
    fn tori_and_isochronous_motion_are_regular_and_linear_growth_is_chaotic() {
        assert_eq!(
            of(|t| 2.0 - 2.0 / (1.0 + t), 40).motion,
            MotionKind::Regular
        );
        assert_eq!(of(|t| 1.0 / (1.0 + t), 40).motion, MotionKind::Regular);
        let chaotic = of(|t| 0.05 * t, 40);
        assert_eq!(chaotic.motion, MotionKind::Chaotic);
        // Ȳ = λt/2.
        let time = chaotic.e_folding_time.expect("a time");
        assert!((time * 0.1 - 1.0).abs() < 1e-12, "{time}");
    }

    #[test]
    fn neighbours_that_approach_are_those_of_regular_motion() {
        let sink = of(|t| -0.05 * t, 40);
        assert_eq!(
            (sink.motion, sink.e_folding_time),
            (MotionKind::Regular, None)
        );
        assert_eq!(
            sink.text(),
            "regular: MEGNO -50.000, and falling; neighbours approach"
        );
    }

    #[test]
    fn what_is_neither_is_not_yet_known() {
        // On its way to 2, above 4 and not growing, too few samples, no samples.
        assert_eq!(of(|t| 0.002 * t, 40).motion, MotionKind::NotYetKnown);
        assert_eq!(of(|_| 5.0, 40).motion, MotionKind::NotYetKnown);
        // Falling from a positive value: neighbours have only begun to approach.
        assert_eq!(of(|t| 6.0 - 0.011 * t, 40).motion, MotionKind::NotYetKnown);
        assert_eq!(of(|_| 2.0, 4).motion, MotionKind::NotYetKnown);
        assert_eq!(of(|_| f64::NAN, 40).motion, MotionKind::NotYetKnown);
        assert_eq!(ChaosVerdict::new(&[], None), None);
    }
}
