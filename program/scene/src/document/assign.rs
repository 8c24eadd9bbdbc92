//! Values that no part of a method is made of, set in a scene that was read.

use toml_edit::Value;

use super::field::FieldSpec;
use super::located::{Located, Number};
use super::method::StepSpec;
use super::run::InitialSpec;
use super::scene::SceneDocument;

impl SceneDocument {
    /// Sets a parameter, the step, the number of steps or the initial state as `--set key=value` would. The text and
    /// every place are left as they are. Returns `false`, with nothing changed, for other keys, and for values that the
    /// reader has to judge.
    pub fn assign(&mut self, key: &str, value: &str) -> bool {
        self.try_assign(key, value).is_some()
    }

    fn try_assign(&mut self, key: &str, value: &str) -> Option<()> {
        // A time at the end is another number of other steps.
        let is_of_steps = [
            "method.time-step",
            "method.epsilon",
            "method.h",
            "run.steps",
        ];
        if self.run.comes_to.is_some() && is_of_steps.contains(&key) {
            return None;
        }
        if let Some(name) = key.strip_prefix("system.parameters.") {
            return self.assign_parameter(name, number(value)?);
        }
        if let Some(name) = key.strip_prefix("run.initial.") {
            return self.assign_field(name, value);
        }
        match key {
            "method.time-step" => {
                let step = nonzero(value)?;
                let place = match &self.method.step {
                    StepSpec::TimeStep(old) => old.place(),
                    StepSpec::Factors { h, .. } => h.place(),
                };
                self.method.step = StepSpec::TimeStep(Located::new(step, place));
            }
            "method.epsilon" | "method.h" => {
                let factor = nonzero(value)?;
                let StepSpec::Factors { epsilon, h } = &mut self.method.step else {
                    return None;
                };
                let (own, other) = match key {
                    "method.epsilon" => (epsilon, &*h),
                    _ => (h, &*epsilon),
                };
                let product = factor.value * other.value.value;
                if !product.is_finite() || product == 0.0 {
                    return None;
                }
                own.value = factor;
            }
            "run.steps" if self.run.until.is_none() => {
                let whole = value.trim().parse::<Value>().ok()?.as_integer()?;
                self.run.steps.value = u64::try_from(whole).ok()?;
            }
            "run.initial" => self.assign_initial(value)?,
            _ => return None,
        }
        Some(())
    }

    fn assign_parameter(&mut self, name: &str, number: Number) -> Option<()> {
        if self.system.numbers.is_some() {
            return None;
        }
        let mut declared = self.system.parameters.iter_mut();
        let (_, entry) = declared.find(|(known, _)| known.value == name)?;
        entry.value = number;
        Some(())
    }

    fn assign_field(&mut self, name: &str, value: &str) -> Option<()> {
        let InitialSpec::Fields(fields) = &mut self.run.initial.value else {
            return None;
        };
        let mut given = fields.iter_mut();
        let (_, field) = given.find(|(known, _)| known.value == name)?;
        let FieldSpec::Formula(formula) = field else {
            return None;
        };
        formula.value = number(value)?.literal;
        Some(())
    }

    fn assign_initial(&mut self, value: &str) -> Option<()> {
        let given: Value = value.trim().parse().ok()?;
        let place = self.run.initial.place();
        let numbers = given.as_array()?.iter().map(|entry| {
            let text = entry.to_string();
            let number = number(&text)?;
            Some(Located::new(number, place.clone()))
        });
        let numbers: Vec<_> = numbers.collect::<Option<_>>()?;
        if numbers.len() != self.system.coordinates() {
            return None;
        }
        self.run.initial.value = InitialSpec::Vector(numbers);
        Some(())
    }
}

/// A finite number that TOML writes with decimals.
fn number(value: &str) -> Option<Number> {
    let text = value.trim();
    let is_number = matches!(
        text.parse::<Value>(),
        Ok(Value::Integer(_) | Value::Float(_))
    );
    let literal = text.replace('_', "");
    let value = literal.parse::<f64>().ok()?;
    (is_number && value.is_finite()).then_some(Number { literal, value })
}

fn nonzero(value: &str) -> Option<Number> {
    number(value).filter(|number| number.value != 0.0)
}
