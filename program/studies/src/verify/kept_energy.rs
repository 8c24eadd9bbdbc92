//! How well a map keeps its shadow energy.
//!
//! The shadow energy H̃ = H + t^m F_{m+1} + t^{m+2} F_{m+3} + … has a self-adjoint map of order m as its flow. The
//! terms cut behind F_{m+1} change by O(t^{m+2}) over a fixed time. The coefficient of that change is the difference of
//! F_{m+3} between the ends of that time. Over a realization of order n no H̃ is kept to more than order 2⌊n/2⌋ + 2.

use leafwise_core::system::SystemObservables;
use leafwise_core::{MapProperties, StepMap, Structure, Walk};
use leafwise_expression::Expression;
use serde::Serialize;

use super::convergence::{LARGEST_ERROR, ROUND_OFF, STEPS};
use super::floor::Floor;
use super::judgement::Judgement;
use super::order::MeasuredOrder;
use super::problem::Problem;

/// The order to which a map keeps H + t^m F_{m+1}.
#[derive(Clone, Debug, Serialize)]
pub struct KeptEnergy {
    /// m + 2, or less over a realization that is not exact.
    pub declared: usize,
    /// Measured order.
    pub order: MeasuredOrder,
    /// Judgement of the declared order by the measured one.
    pub judgement: Judgement,
}

/// Products of terms that F_{m+1} may take: milliseconds.
const PRODUCTS: u64 = 1 << 14;

/// How far behind the declared order its first term is looked for.
const BEHIND: usize = 3;

/// The longest formula of F_{m+1} that is evaluated at every step.
const LONGEST: usize = 4096;

impl KeptEnergy {
    /// Runs a map over `horizon` at a sequence of steps; `None` where F_{m+1} has no short formula.
    pub(super) fn measure(problem: &Problem, map: &dyn StepMap, horizon: f64) -> Option<Self> {
        let properties = map.properties();
        let values = problem.system.parameter_values();
        let first = FirstTerm::of(problem, map)?;
        let formulas = [&first.energy, &first.term];
        let mut observables = SystemObservables::new(&problem.system, &formulas, &values).ok()?;
        let mut at = |state: &[f64], power: f64| {
            let mut value = [0.0; 2];
            observables.evaluate(state, &mut value);
            (value[0] + power * value[1], value[0].abs())
        };
        let mut changes = Vec::new();
        let mut floor = Floor::new(ROUND_OFF[0], ROUND_OFF[1]);
        for steps in STEPS {
            let t = horizon / f64::from(steps);
            let power = (0..first.order_of_map).fold(1.0, |power, _| power * t);
            let mut walk = Walk::new(map, &values, 1.0, t, &problem.initial);
            if walk.advance(u64::from(steps)).is_err() {
                continue;
            }
            let ((start, size), (end, _)) = (at(&problem.initial, power), at(walk.state(), power));
            if size == 0.0 {
                return None;
            }
            let change = (end - start).abs() / size;
            floor.take(t, change);
            if change < LARGEST_ERROR {
                changes.push((t, change));
            }
            if floor.touched() >= 2 {
                break;
            }
        }
        let noise = 4.0 * floor.round_off;
        let order = MeasuredOrder::of(&changes, floor.round_off, 2.0);
        let declared = declared(properties, first.order_of_map);
        let is_round_off =
            !changes.is_empty() && changes.iter().all(|(_, change)| *change <= noise);
        let judgement = if is_round_off {
            Judgement::Met
        } else {
            order
                .judge(declared)
                .on_rough(declared, problem.smooth_order())
        };
        Some(Self {
            declared,
            order,
            judgement,
        })
    }
}

/// The order to which a map of order m keeps H̃ cut behind its first term.
fn declared(properties: MapProperties, m: usize) -> usize {
    match properties.structure {
        Structure::Order(n) => (m + 2).min(2 * (n / 2) + 2),
        _ => m + 2,
    }
}

/// H and F_{m+1}.
struct FirstTerm {
    order_of_map: usize,
    energy: Expression,
    term: Expression,
}

impl FirstTerm {
    fn of(problem: &Problem, map: &dyn StepMap) -> Option<Self> {
        let properties = map.properties();
        let formulas = problem.system.expressions()?;
        if properties.self_adjoint != Some(true) {
            return None;
        }
        (1..=BEHIND).step_by(2).find_map(|behind| {
            let last = properties.order + behind;
            let shadow = map.shadow(formulas, last, PRODUCTS).ok()??;
            let first = shadow.terms().into_iter().find(|k| *k > 1)?;
            Some(Self {
                order_of_map: first - 1,
                energy: shadow.formula(1, LONGEST)?,
                term: shadow.formula(first, LONGEST)?,
            })
        })
    }
}
