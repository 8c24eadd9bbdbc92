//! The initial state.

use leafwise_expression::syntax::{Formula, Scope, VariablePattern};

use super::Refusal;
use super::definitions::scope;
use super::names::{parse, refusal};
use crate::document::{InitialSpec, Located, SceneDocument};

/// The initial state of the scene: one number for each coordinate.
pub(super) fn initial_state(document: &SceneDocument) -> Result<Vec<f64>, Refusal> {
    let system = &document.system;
    let dimension = system.dimension();
    match &document.run.initial.value {
        InitialSpec::Vector(numbers) => {
            if numbers.len() != dimension {
                return Err(Box::new(document.diagnostic(
                    &document.run.initial.place(),
                    format!(
                        "initial has {} entries, and the state has {dimension} coordinates",
                        numbers.len()
                    ),
                    format!("expected {dimension} numbers"),
                    None,
                )));
            }
            Ok(numbers.iter().map(|number| number.value.value).collect())
        }
        InitialSpec::Fields(fields) => {
            let lengths: Vec<usize> = system.families.iter().map(|(_, l)| l.value).collect();
            let parameters: Vec<f64> = system
                .parameters
                .iter()
                .map(|(_, value)| value.value.value)
                .collect();
            let mut state = State {
                document,
                scope: scope(document, &lengths, None)?,
                parameters,
                values: vec![0.0; dimension],
                is_given: vec![false; dimension],
            };
            // Templates first: a single site then overrides the field, whatever their order.
            for wants_index in [true, false] {
                for (key, formula) in fields {
                    let pattern = VariablePattern::parse_one(&key.value)
                        .map_err(|error| refusal(document, key, &error))?;
                    if pattern.index_name().is_some() == wants_index {
                        state.assign(key, &pattern, formula, &parse(document, formula)?)?;
                    }
                }
            }
            state.finish()
        }
    }
}

struct State<'a> {
    document: &'a SceneDocument,
    scope: Scope,
    parameters: Vec<f64>,
    values: Vec<f64>,
    is_given: Vec<bool>,
}

impl State<'_> {
    fn assign(
        &mut self,
        key: &Located<String>,
        pattern: &VariablePattern,
        formula: &Located<String>,
        parsed: &Formula,
    ) -> Result<(), Refusal> {
        let length = self
            .document
            .system
            .families
            .iter()
            .find(|(name, _)| name.value == pattern.name())
            .map_or(1, |(_, length)| length.value);
        let sites = if pattern.index_name().is_some() {
            length
        } else {
            1
        };
        for i in 0..sites {
            let index = pattern.index_name().map(|name| (name, i));
            let at = pattern
                .resolve(&self.scope, index)
                .map_err(|error| refusal(self.document, key, &error))?;
            let Some(at) = at else { continue };
            let value = parsed
                .value(&self.scope, &self.parameters, index)
                .map_err(|error| refusal(self.document, formula, &error))?;
            if !value.is_finite() {
                return Err(self.not_finite(formula, at, index, value));
            }
            self.values[at] = value;
            self.is_given[at] = true;
        }
        Ok(())
    }

    fn not_finite(
        &self,
        formula: &Located<String>,
        at: usize,
        index: Option<(&str, usize)>,
        value: f64,
    ) -> Refusal {
        let name = self.name(at);
        let written = if value.is_nan() {
            "not a number"
        } else {
            "infinite"
        };
        let site = index.map_or_else(String::new, |(index, i)| format!(" at {index} = {i}"));
        Box::new(
            self.document.diagnostic(
                &self
                    .document
                    .place_in_formula(formula, 0..formula.value.len()),
                format!("the initial value of {name} is {written}"),
                format!("outside the formula's domain{site}"),
                Some("a logarithm or root of a negative number, or a division by zero".to_owned()),
            ),
        )
    }

    fn name(&self, at: usize) -> String {
        let system = &self.document.system;
        if let Some(name) = system.variables.get(at) {
            return name.value.clone();
        }
        let mut site = at - system.variables.len();
        for (name, length) in &system.families {
            if site < length.value {
                return format!("{}[{site}]", name.value);
            }
            site -= length.value;
        }
        format!("coordinate {at}")
    }

    fn finish(self) -> Result<Vec<f64>, Refusal> {
        match self.is_given.iter().position(|given| !given) {
            None => Ok(self.values),
            Some(at) => Err(Box::new(self.document.diagnostic(
                &self.document.run.initial.place(),
                format!("initial gives no value for {}", self.name(at)),
                "incomplete",
                Some("give every variable and family, as in \"x[i]\" = \"1 + i/N\"".to_owned()),
            ))),
        }
    }
}
