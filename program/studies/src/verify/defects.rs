//! Tensor defects of one step over a sequence of step sizes.

use leafwise_core::diagnostics::{Defect, TensorDefect};
use leafwise_core::{MapProperties, StepError, StepMap, Structure};

use super::floor::Floor;
use super::judgement::Judgement;
use super::order::MeasuredOrder;
use super::problem::Problem;

/// Tensor defects of one step, relative to the tensor.
pub(super) struct Defects {
    /// A defect for each step at which one could be measured, in units of the step's own round-off.
    points: Vec<(f64, StepDefect)>,
    /// n in tⁿ⁺¹.
    pub order: MeasuredOrder,
}

/// A relative defect.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepDefect {
    pub defect: f64,
    /// Largest part of the defect that may be the error of differences; 0 for an exact tangent.
    floor: f64,
}

impl StepDefect {
    /// Whether it can be told from what the differences may be wrong by.
    pub fn is_told(self) -> bool {
        self.floor == 0.0 || self.defect > 4.0 * self.floor
    }
}

/// Steps an eighth of an octave apart, from eight times the problem's down to a 64th of it.
const SIZES: u32 = 72;

/// No round-off of a defect is larger. Terms of charge over mass cancel in guiding centres in SI units, and put 4e-11 into it.
const CANCELLED: f64 = 1e-10;

/// Round-off of a relative defect, at least and at most.
const PLATEAU: [f64; 2] = [8.0 * f64::EPSILON, Defect::ROUND_OFF];

impl Defects {
    /// Measures one step at every size below the smallest that fails. Beyond it, if solves succeed at all, they are
    /// next to singular or on another branch, and their round-off is not that of a step. Nothing is measured after four
    /// defects at round-off, or at what differences leave. `only_step` is the length of the only step, where there is but one.
    pub fn measure(problem: &Problem, map: &dyn StepMap, only_step: Option<f64>) -> Self {
        let mut points = Vec::new();
        let mut of_order = Vec::new();
        let mut largest: Option<Defect> = None;
        let mut floor = Floor::new(PLATEAU[0], PLATEAU[1]);
        let mut untold = 0;
        let octaves =
            (0..SIZES).map(|k| problem.time_step * libm::exp2(3.0 - 0.125 * f64::from(k)));
        let sizes = match only_step {
            None => octaves.collect(),
            Some(_) => vec![problem.time_step],
        };
        for t in sizes {
            let Some((defect, measured)) = defect(problem, map, &problem.initial, t) else {
                points.clear();
                of_order.clear();
                largest = None;
                floor = Floor::new(PLATEAU[0], PLATEAU[1]);
                untold = 0;
                continue;
            };
            points.push((t, measured));
            untold = if measured.is_told() { 0 } else { untold + 1 };
            if measured.is_told() {
                floor.take(t, measured.defect);
                // In the units of the largest step, which are no smaller: round-off is no larger in them.
                let units = largest.get_or_insert_with(|| defect.clone());
                of_order.extend(defect.relative_in(units).map(|relative| (t, relative)));
            }
            if floor.touched() == 4 || untold == 4 {
                break;
            }
        }
        let told = || points.iter().filter(|(_, measured)| measured.is_told());
        let round_off = told().map(|p| p.1.floor).fold(floor.round_off, f64::max);
        let order = MeasuredOrder::of(&of_order, round_off, 1.0).of_one_step();
        Self { points, order }
    }

    /// Whether every defect is round-off, or what differences leave; `None` where none could be
    /// measured.
    pub fn is_round_off(&self) -> Option<bool> {
        let is_none = |m: &StepDefect| m.defect <= PLATEAU[1] || !m.is_told();
        (!self.points.is_empty()).then(|| self.points.iter().all(|(_, m)| is_none(m)))
    }

    /// The largest defect that is told from differences.
    fn largest(&self) -> f64 {
        let told = self.points.iter().filter(|(_, m)| m.is_told());
        told.fold(0.0, |largest, (_, m)| m.defect.max(largest))
    }

    /// Whether defects are those of a step that is no Poisson map: of order 1 or more in the step, or larger than any round-off.
    ///
    /// Where large terms cancel, as in a one-form of charge over mass, round-off is above [`PLATEAU`]. It does not fall with the
    /// step: no order of 1 fits it.
    fn are_told(&self) -> bool {
        let order = match (self.order.exponent, self.order.tolerance) {
            (Some(exponent), Some(tolerance)) => Some(exponent + tolerance),
            _ => self.order.at_least,
        };
        self.largest() > CANCELLED || order.is_some_and(|order| order >= 1.0)
    }

    /// Round-off of a defect on this problem: that of a sum of terms, or more where defects are round-off of cancelled ones.
    pub fn round_off(&self) -> f64 {
        match self.are_told() {
            true => PLATEAU[1],
            false => self.largest().max(PLATEAU[1]),
        }
    }

    /// The declared structure of a Poisson map against them. Round-off at every step is an exact structure, and better
    /// than any order.
    pub fn judge(&self, declared: MapProperties) -> Judgement {
        match (declared.structure, self.is_round_off()) {
            (_, None) | (Structure::Leaves | Structure::Contact | Structure::None, _) => {
                Judgement::Open
            }
            (_, Some(true)) => Judgement::Met,
            (Structure::Exact, Some(false)) if self.are_told() => Judgement::NotMet,
            (Structure::Exact, Some(false)) => Judgement::Undecided,
            (Structure::Order(n), Some(false)) => self.order.judge(n),
        }
    }
}

/// Tensor defect of one step of t from x, and its size relative to round-off. Differences measure it where the map
/// offers no tangent and declares a structure. Returns `None` where the step fails or there is nothing to measure by.
fn defect(problem: &Problem, map: &dyn StepMap, x: &[f64], t: f64) -> Option<(Defect, StepDefect)> {
    let values = problem.system.parameter_values();
    let mut instrument = TensorDefect::new(&problem.system, map, &values, 1.0, t).ok()?;
    let has_structure = map.properties().structure != Structure::None;
    let sampled = match problem.is_sampled() && has_structure {
        true => instrument.measure_sampled(x).ok()?,
        false => None,
    };
    let defect = match sampled {
        Some(defect) => defect,
        None => match instrument.measure(x) {
            Err(StepError::NoTangent) if has_structure => instrument.measure_by_differences(x),
            measured => measured,
        }
        .ok()?,
    };
    let measured = StepDefect {
        defect: defect.relative()?,
        floor: defect.relative_floor()?,
    };
    Some((defect, measured))
}

/// The relative defect of one step of t from x.
pub(super) fn step_defect(
    problem: &Problem,
    map: &dyn StepMap,
    x: &[f64],
    t: f64,
) -> Option<StepDefect> {
    defect(problem, map, x, t).map(|(_, measured)| measured)
}
