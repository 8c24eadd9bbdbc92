//! A system as the text of a scene's `[system]` table.

use std::fmt::Write;

use leafwise_expression::Expression;

use super::{Convention, SystemFormulas};

impl SystemFormulas {
    /// A formula of this system as text that a scene reads.
    pub fn written(&self, formula: &Expression) -> String {
        let parameters = self.parameters().iter();
        let names: Vec<String> = parameters.map(|parameter| parameter.name.clone()).collect();
        formula.written(self.variables(), &names)
    }

    /// The entries of the tensor that are not zero, as its author wrote them: names of two variables and the formula of their bracket.
    pub fn bracket_rows(&self) -> Vec<([&str; 2], String)> {
        let names = self.variables();
        let rows = self.tensor().iter();
        rows.map(|(&(i, j), entry)| {
            let written = match (self.convention(), entry) {
                (Convention::HamiltonianFirst, entry) => self.written(entry),
                (Convention::HamiltonianSecond, Expression::Negate(entry)) => self.written(entry),
                (Convention::HamiltonianSecond, entry) => {
                    self.written(&Expression::Negate(Box::new(entry.clone())))
                }
            };
            ([names[i].as_str(), names[j].as_str()], written)
        })
        .collect()
    }

    /// The Casimirs: their names and formulas.
    pub fn named_casimirs(&self) -> Vec<(&str, String)> {
        let casimirs = self.casimirs().iter();
        casimirs
            .map(|casimir| (casimir.name.as_str(), self.written(&casimir.expression)))
            .collect()
    }

    /// The `[system]` table of a scene that is this system, its tensor by entries.
    pub fn fragment(&self) -> String {
        let variables: Vec<String> = self.variables().iter().map(|v| quoted(v)).collect();
        let mut text = format!("[system]\nvariables   = [{}]\n", variables.join(", "));
        let line = |name: &str, entries: Vec<(String, String)>| {
            let entries = entries
                .iter()
                .map(|(key, value)| format!("{key} = {value}"));
            format!(
                "{name:11} = {{ {} }}\n",
                entries.collect::<Vec<_>>().join(", ")
            )
        };
        let parameters = self.parameters().iter();
        let parameters: Vec<(String, String)> = parameters
            .map(|parameter| (quoted(&parameter.name), format!("{:?}", parameter.value)))
            .collect();
        if !parameters.is_empty() {
            text.push_str(&line("parameters", parameters));
        }
        let rows = self.bracket_rows().into_iter();
        let rows = rows.map(|([x, y], entry)| (quoted(&format!("{x},{y}")), quoted(&entry)));
        text.push_str(&line("bracket", rows.collect()));
        let convention = match self.convention() {
            Convention::HamiltonianFirst => "{H,x}",
            Convention::HamiltonianSecond => "{x,H}",
        };
        let _ = writeln!(text, "convention  = \"{convention}\"");
        let _ = writeln!(
            text,
            "hamiltonian = {}",
            quoted(&self.written(self.hamiltonian()))
        );
        let casimirs = self.named_casimirs().into_iter();
        let casimirs: Vec<(String, String)> = casimirs
            .map(|(name, formula)| (quoted(name), quoted(&formula)))
            .collect();
        if !casimirs.is_empty() {
            text.push_str(&line("casimirs", casimirs));
        }
        text
    }
}

/// A string of TOML; names and formulas have neither quotes nor backslashes nor line ends.
fn quoted(text: &str) -> String {
    format!("\"{text}\"")
}
