//! Parts of a registry that serve where another one is refused.

use crate::error::BuildError;
use crate::part::{Family, PartInfo, PartKind};
use crate::registry::Registry;
use crate::system::MotionClass;

impl Registry {
    /// The message of a refusal, with the parts of this registry that serve in place of the one refused.
    pub fn explain(&self, error: &BuildError) -> String {
        match self.instead(error) {
            Some(instead) => format!("{error}; {instead}"),
            None => error.to_string(),
        }
    }

    /// The parts of this registry that serve in place of the one refused, in words; `None` where the refusal asks
    /// for no other part, or there is none.
    pub fn instead(&self, error: &BuildError) -> Option<String> {
        let serving = |parts: Option<String>| {
            let parts = parts.as_deref().unwrap_or("no part of this program");
            Some(format!("what serves it: {parts}"))
        };
        match error {
            BuildError::NotOffered { .. } => serving(self.serving_numbers()),
            BuildError::Forces { .. } => serving(self.taking(MotionClass::OnLeaves)),
            BuildError::Friction { .. } => serving(self.taking(MotionClass::OffLeaves)),
            BuildError::TooManyVariables { .. } | BuildError::TooManyEquations { .. } => {
                let families = [Family::Splitting, Family::Explicit];
                let steppers = families.into_iter().flat_map(|family| self.family(family));
                listed("steppers that solve nothing: ", &names(steppers), ", ")
            }
            BuildError::NoFactors {
                is_self_adjoint, ..
            } => {
                let splitting = names(self.family(Family::Splitting));
                let composed = listed("compose ", &splitting, " or ").map(|text| text + " with it");
                let others = is_self_adjoint
                    .then(|| self.of_self_adjoint_maps())
                    .flatten();
                let ways: Vec<String> = composed.into_iter().chain(others).collect();
                (!ways.is_empty()).then(|| ways.join(", or "))
            }
            BuildError::LiftAlone { .. } => {
                let compared = self.compared(PartKind::Dynamics).into_iter();
                let stepping = compared.filter(|info| {
                    info.compared
                        .is_some_and(|compared| !compared.over_lifts.is_empty())
                });
                listed("dynamics that step there: ", &names(stepping), ", ")
            }
            _ => None,
        }
    }

    /// The parts that need no formulas of a system.
    fn serving_numbers(&self) -> Option<String> {
        let all = |kind: PartKind, between: &str| {
            let parts = self.parts().into_iter().filter(|info| info.kind == kind);
            let mut serving: Vec<(u32, String)> = parts
                .filter_map(|info| {
                    let serves = info.serves_numbers?;
                    let text = format!("{} {}", info.name, serves.limit);
                    Some((serves.rank, text.trim_end().to_owned()))
                })
                .collect();
            serving.sort();
            let texts: Vec<String> = serving.into_iter().map(|(_, text)| text).collect();
            listed("", &texts, between)
        };
        let realizations = all(PartKind::Realization, " or ");
        let dynamics = all(PartKind::Dynamics, " or with ");
        let pairs = realizations
            .zip(dynamics)
            .map(|(realizations, dynamics)| format!("{realizations} with {dynamics}"));
        let steppers =
            all(PartKind::Stepper, ", ").map(|steppers| format!("the steppers {steppers}"));
        either(pairs, steppers)
    }

    /// The parts that integrate a motion.
    fn taking(&self, motion: MotionClass) -> Option<String> {
        let all = |kind: PartKind| {
            let parts = self.parts().into_iter();
            names(parts.filter(|info| info.kind == kind && info.takes >= motion))
        };
        let dynamics = listed("the dynamics ", &all(PartKind::Dynamics), ", ");
        let steppers = listed("the steppers ", &all(PartKind::Stepper), ", ");
        let dynamics = dynamics.map(|text| match steppers {
            Some(_) => text + ", which keeps every Casimir",
            None => text,
        });
        either(dynamics, steppers)
    }

    /// The first compositions that ask nothing of a map but that it is self-adjoint.
    fn of_self_adjoint_maps(&self) -> Option<String> {
        let compared = self.compared(PartKind::Composition).into_iter();
        let others = compared.filter(|info| {
            let part = self.composition(info.name);
            part.is_ok_and(|part| part.factors.is_none())
        });
        let such_as = "take a composition of self-adjoint maps, such as ";
        listed(such_as, &names(others.take(EXAMPLES)), " or ")
    }
}

/// Parts that stand for all of their kind.
const EXAMPLES: usize = 2;

fn names(parts: impl IntoIterator<Item = &'static PartInfo>) -> Vec<String> {
    let names = parts.into_iter().map(|info| info.name.to_owned());
    names.collect()
}

/// A list behind a word, unless it is empty.
fn listed(word: &str, items: &[String], between: &str) -> Option<String> {
    (!items.is_empty()).then(|| format!("{word}{}", items.join(between)))
}

/// Both, or the one that there is.
fn either(one: Option<String>, other: Option<String>) -> Option<String> {
    match (one, other) {
        (Some(one), Some(other)) => Some(format!("{one}, and {other}")),
        (one, other) => one.or(other),
    }
}
