//! Tensor defects of one step over a sequence of step sizes.

use leafwise_core::StepMap;
use leafwise_core::diagnostics::TensorDefect;

use super::floor::Floor;
use super::judgement::ROUND_OFF;
use super::order::MeasuredOrder;
use super::problem::Problem;

/// Tensor defects of one step, relative to the tensor.
pub(super) struct Defects {
    /// (t, defect).
    pub points: Vec<(f64, f64)>,
    /// n in tⁿ⁺¹.
    pub order: MeasuredOrder,
}

/// Steps an eighth of an octave apart, from eight times the problem's down to a 64th of it.
const SIZES: u32 = 72;

/// Round-off of a relative defect, at least and at most.
const PLATEAU: [f64; 2] = [8.0 * f64::EPSILON, ROUND_OFF * f64::EPSILON];

impl Defects {
    /// One step at every size; sizes that fail are left out, and nothing is measured after four
    /// defects at round-off.
    pub fn measure(problem: &Problem, map: &dyn StepMap) -> Self {
        let mut points = Vec::new();
        let mut floor = Floor::new(PLATEAU[0], PLATEAU[1]);
        for k in 0..SIZES {
            let t = problem.time_step * libm::exp2(3.0 - 0.125 * f64::from(k));
            let Some(defect) = defect(problem, map, t) else {
                continue;
            };
            points.push((t, defect));
            floor.take(t, defect);
            if floor.touched() == 4 {
                break;
            }
        }
        let order = MeasuredOrder::of(&points, floor.round_off, 1.0).of_one_step();
        Self { points, order }
    }

    /// Whether every defect is round-off; `None` where none could be measured.
    pub fn is_round_off(&self) -> Option<bool> {
        let worst = self.points.iter().map(|p| p.1).fold(0.0, f64::max);
        (!self.points.is_empty()).then_some(worst <= PLATEAU[1])
    }
}

/// The relative defect of one step of t; `None` where the step fails or the map offers no tangent.
pub(super) fn defect(problem: &Problem, map: &dyn StepMap, t: f64) -> Option<f64> {
    let values = problem.system.parameter_values();
    let mut instrument = TensorDefect::new(&problem.system, map, &values, 1.0, t).ok()?;
    instrument.measure(&problem.initial).ok()?.relative()
}
