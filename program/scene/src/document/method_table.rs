//! A `[method]` table as a value: to be built, written into a scene, or printed.

use std::fmt;

use leafwise_core::part::ParameterSetting;
use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::overrides::in_layout_of;

/// A part by name with the parameters that it is given.
#[derive(Clone, Debug, PartialEq)]
pub struct PartUse {
    /// The part's name, or `auto`.
    pub name: String,
    /// Parameters by name; the others keep their defaults.
    pub parameters: Vec<(String, ParameterSetting)>,
}

/// Parts that make a step: realization and dynamics, or a stepper.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodParts {
    /// Realization and dynamics.
    Pair {
        /// The geometric approximation.
        realization: PartUse,
        /// The dynamic one.
        dynamics: PartUse,
    },
    /// A stepper in their place.
    Stepper(PartUse),
}

/// A method without its step.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodTable {
    /// Parts that make a step.
    pub parts: MethodParts,
    /// A symmetric composition of it.
    pub composition: Option<PartUse>,
}

/// Why a scene's text could not be changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RewriteError {
    /// The text is not TOML.
    #[error("the scene is not TOML: {message}")]
    Syntax {
        /// Message of the TOML reader.
        message: String,
    },
    /// A table is missing, or is something else.
    #[error("the scene has no table [{table}]")]
    NoTable {
        /// Its name.
        table: &'static str,
    },
}

impl PartUse {
    /// A part with its default parameters.
    pub fn named(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            parameters: Vec::new(),
        }
    }

    /// The same with one more parameter.
    pub fn with(mut self, name: &str, value: impl Into<ParameterSetting>) -> Self {
        self.parameters.push((name.to_owned(), value.into()));
        self
    }

    /// The value of a parameter that is given.
    pub fn parameter(&self, name: &str) -> Option<&ParameterSetting> {
        let given = self.parameters.iter().find(|(known, _)| known == name);
        given.map(|(_, value)| value)
    }

    fn value(&self) -> Value {
        if self.parameters.is_empty() {
            return Value::from(self.name.as_str());
        }
        let mut table = InlineTable::new();
        table.insert("name", Value::from(self.name.as_str()));
        for (name, setting) in &self.parameters {
            table.insert(
                name,
                match setting {
                    ParameterSetting::Integer(value) => Value::from(*value),
                    ParameterSetting::Real(value) => real(*value),
                    ParameterSetting::Text(value) => Value::from(value.as_str()),
                },
            );
        }
        Value::InlineTable(table)
    }
}

/// The name and the values of the parameters: `karasev-truncated 6`.
impl fmt::Display for PartUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        for (_, value) in &self.parameters {
            match value {
                ParameterSetting::Real(value) => write!(f, " {value:e}")?,
                value => write!(f, " {value}")?,
            }
        }
        Ok(())
    }
}

impl fmt::Display for MethodTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(composition) = &self.composition {
            write!(f, "{composition} of ")?;
        }
        match &self.parts {
            MethodParts::Stepper(stepper) => stepper.fmt(f),
            MethodParts::Pair {
                realization,
                dynamics,
            } => write!(f, "{realization} + {dynamics}"),
        }
    }
}

impl MethodTable {
    /// Realization and dynamics.
    pub fn pair(realization: PartUse, dynamics: PartUse) -> Self {
        Self {
            parts: MethodParts::Pair {
                realization,
                dynamics,
            },
            composition: None,
        }
    }

    /// A stepper.
    pub fn stepper(stepper: PartUse) -> Self {
        Self {
            parts: MethodParts::Stepper(stepper),
            composition: None,
        }
    }

    /// A composition of this method.
    pub fn composed(mut self, composition: PartUse) -> Self {
        self.composition = Some(composition);
        self
    }

    /// The table as text, with its step.
    pub fn text(&self, time_step: f64) -> String {
        let mut rows: Vec<(&str, Value)> = self
            .entries()
            .into_iter()
            .filter_map(|(key, value)| Some((key, value?)))
            .collect();
        rows.push(("time-step", real(time_step)));
        let lines = rows
            .iter()
            .map(|(key, value)| format!("{key:11} = {value}\n"));
        lines.fold("[method]\n".to_owned(), |text, line| text + &line)
    }

    /// Every key that says what makes a step, with its value where it has one.
    fn entries(&self) -> [(&'static str, Option<Value>); 4] {
        let (realization, dynamics, stepper) = match &self.parts {
            MethodParts::Stepper(stepper) => (None, None, Some(stepper.value())),
            MethodParts::Pair {
                realization,
                dynamics,
            } => (Some(realization.value()), Some(dynamics.value()), None),
        };
        [
            ("realization", realization),
            ("dynamics", dynamics),
            ("stepper", stepper),
            ("composition", self.composition.as_ref().map(PartUse::value)),
        ]
    }

    /// A scene's text with this method and `steps` steps of `time_step`; comments, order and
    /// layout stay. A scene that gives `epsilon` and `h` keeps its ε; samples are kept as often in
    /// time as before.
    ///
    /// # Errors
    /// [`RewriteError`] for a text that is not a scene.
    pub fn write_into(
        &self,
        text: &str,
        time_step: f64,
        steps: u64,
    ) -> Result<String, RewriteError> {
        let mut document = text
            .parse::<DocumentMut>()
            .map_err(|error| RewriteError::Syntax {
                message: error.message().to_owned(),
            })?;
        let method = table(&mut document, "method")?;
        let is_paced = method.contains_key("pace");
        let order = self.write_parts(method);
        if method.contains_key("epsilon") && method.contains_key("h") {
            let epsilon = method.get("epsilon").and_then(number).unwrap_or(1.0);
            set(method, "h", real(time_step / epsilon));
        } else {
            set(method, "time-step", real(time_step));
        }
        if let Some(method) = document.get_mut("method").and_then(Item::as_table_mut) {
            restore_order(method, &order);
        }
        let run = table(&mut document, "run")?;
        let before = run.get("steps").and_then(Item::as_integer);
        // With a pace the time at the end may stand in their place; without one it may be no number of these steps.
        if !(is_paced && run.contains_key("until")) {
            run.remove("until");
            set(run, "steps", Value::from(steps as i64));
        }
        let record = run.get_mut("record").and_then(Item::as_table_like_mut);
        if let (Some(record), Some(before)) = (record, before.filter(|steps| *steps > 0))
            && let Some(every) = record.get("every").and_then(Item::as_integer)
        {
            let ratio = steps as f64 / before as f64;
            let every = libm::round(every as f64 * ratio).max(1.0);
            set(record, "every", Value::from(every as i64));
        }
        Ok(in_layout_of(text, document.to_string()))
    }

    /// Writes what makes a step; returns the keys in the order they are to stand in.
    fn write_parts(&self, method: &mut dyn TableLike) -> Vec<String> {
        let mut order: Vec<String> = method.iter().map(|(key, _)| key.to_owned()).collect();
        let mut comments = String::new();
        let mut place = None;
        for (key, value) in self.entries() {
            match value {
                Some(value) if method.contains_key(key) => set(method, key, value),
                Some(_) => {}
                None if key == "composition" && method.contains_key(key) => {
                    set(method, key, Value::from("none"));
                }
                None => {
                    let decor = method.key(key).map(|key| key.leaf_decor().clone());
                    let prefix = decor.and_then(|d| Some(d.prefix()?.as_str()?.to_owned()));
                    comments.push_str(&prefix.unwrap_or_default());
                    method.remove(key);
                    if let Some(at) = order.iter().position(|known| known == key) {
                        place = Some(place.unwrap_or(at).min(at));
                    }
                }
            }
        }
        order.retain(|key| method.contains_key(key));
        let steps = ["epsilon", "h", "time-step"];
        let before_step = order.iter().position(|key| steps.contains(&key.as_str()));
        let mut place = place
            .or(before_step)
            .unwrap_or(order.len())
            .min(order.len());
        for (key, value) in self.entries() {
            let Some(value) = value.filter(|_| !method.contains_key(key)) else {
                continue;
            };
            set(method, key, value);
            if let Some(mut key) = method.key_mut(key) {
                // Comments of the parts that went stay where they stood.
                key.leaf_decor_mut()
                    .set_prefix(std::mem::take(&mut comments));
            }
            order.insert(place, key.to_owned());
            place += 1;
        }
        order
    }
}

fn table<'a>(
    document: &'a mut DocumentMut,
    name: &'static str,
) -> Result<&'a mut dyn TableLike, RewriteError> {
    document
        .get_mut(name)
        .and_then(Item::as_table_like_mut)
        .ok_or(RewriteError::NoTable { table: name })
}

/// The shortest decimal that reads back to `value`, with an exponent where that is shorter.
fn real(value: f64) -> Value {
    let shortest = format!("{value:?}").parse();
    shortest.unwrap_or_else(|_| Value::from(value))
}

fn number(item: &Item) -> Option<f64> {
    item.as_float()
        .or_else(|| item.as_integer().map(|value| value as f64))
}

/// Sets a value, keeping comment and spaces around the one it replaces; a new key's equals sign
/// stands under the others'.
fn set(table: &mut dyn TableLike, key: &str, mut value: Value) {
    if let Some(Item::Value(old)) = table.get_mut(key) {
        *value.decor_mut() = old.decor().clone();
        *old = value;
        return;
    }
    let column = table
        .iter()
        .filter_map(|(key, _)| {
            let suffix = table.key(key)?.leaf_decor().suffix()?.as_str()?;
            Some(key.len() + suffix.len())
        })
        .max();
    table.insert(key, Item::Value(value));
    if let (Some(column), Some(mut written)) = (column, table.key_mut(key)) {
        let gap = column.saturating_sub(key.len()).max(1);
        written.leaf_decor_mut().set_suffix(" ".repeat(gap));
    }
}

/// Moves the keys of `order` to their places; the others stand behind them.
fn restore_order(table: &mut Table, order: &[String]) {
    let place = |key: &str| order.iter().position(|known| known == key);
    let rank = |key: &str| place(key).unwrap_or(order.len());
    table.sort_values_by(|a, _, b, _| rank(a.get()).cmp(&rank(b.get())));
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "# A scene.\n[system]\nlibrary = \"rigid-body\"\n\n[method]\n\
        # The geometry.\nrealization = { name = \"karasev-truncated\", order = 6 } # six\n\
        dynamics    = \"hamilton-jacobi\"\n\n# The step.\nepsilon     = 0.1\nh           = 2.0\n\n\
        [run]\ninitial = [1, 3, 3]\nsteps   = 1000 # long\nrecord  = { every = 10 }\n";

    #[test]
    fn a_method_is_written_into_a_scene_and_comments_stay() {
        let method = MethodTable::pair(
            PartUse::named("so3-cayley"),
            PartUse::named("hamilton-jacobi").with("order", 8),
        )
        .composed(PartUse::named("suzuki-4"));
        let written = method.write_into(SCENE, 0.4, 500).expect("a scene");
        let expected = SCENE
            .replace(
                "{ name = \"karasev-truncated\", order = 6 }",
                "\"so3-cayley\"",
            )
            .replace(
                "\"hamilton-jacobi\"\n",
                "{ name = \"hamilton-jacobi\", order = 8 }\ncomposition = \"suzuki-4\"\n",
            )
            .replace("2.0", "4.0")
            .replace("1000 #", "500 #")
            .replace("every = 10", "every = 5");
        assert_eq!(written, expected);
    }

    #[test]
    fn a_stepper_takes_the_place_and_the_comments_of_the_parts() {
        let method = MethodTable::stepper(PartUse::named("dop853").with("tolerance", 1e-9));
        let written = method.write_into(SCENE, 0.25, 800).expect("a scene");
        let pair = "realization = { name = \"karasev-truncated\", order = 6 } # six\n\
                    dynamics    = \"hamilton-jacobi\"\n";
        assert!(SCENE.contains(pair));
        let expected = SCENE
            .replace(
                pair,
                "stepper     = { name = \"dop853\", tolerance = 1e-9 }\n",
            )
            .replace("2.0", "2.5")
            .replace("1000 #", "800 #")
            .replace("every = 10", "every = 8");
        assert_eq!(written, expected);
        let back = MethodTable::pair(PartUse::named("auto"), PartUse::named("auto"));
        let again = back.write_into(&written, 0.2, 1000).expect("a scene");
        assert!(
            again.contains("# The geometry.\nrealization = \"auto\"\ndynamics    = \"auto\"\n")
        );
    }

    #[test]
    fn the_table_reads_as_it_is_pasted() {
        let method = MethodTable::stepper(PartUse::named("gauss").with("stages", 3));
        assert_eq!(
            method.text(0.5),
            "[method]\nstepper     = { name = \"gauss\", stages = 3 }\ntime-step   = 0.5\n"
        );
        assert_eq!(method.to_string(), "gauss 3");
    }

    #[test]
    fn line_ends_and_a_byte_order_mark_stay() {
        let method = MethodTable::stepper(PartUse::named("dop853"));
        let windows = |text: &str| format!("\u{feff}{}", text.replace('\n', "\r\n"));
        let written = method.write_into(&windows(SCENE), 0.25, 800);
        let plain = method.write_into(SCENE, 0.25, 800).expect("a scene");
        assert_eq!(written.expect("a scene"), windows(&plain));
    }

    #[test]
    fn what_is_no_scene_is_refused() {
        let method = MethodTable::stepper(PartUse::named("rk4"));
        let refused = |text: &str| method.write_into(text, 1.0, 1).expect_err("no scene");
        assert!(matches!(refused("a ="), RewriteError::Syntax { .. }));
        assert_eq!(refused("a = 1"), RewriteError::NoTable { table: "method" });
        assert_eq!(refused("[method]"), RewriteError::NoTable { table: "run" });
    }
}
