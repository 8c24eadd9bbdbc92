//! A bracket as the text of a scene's `[system]` table.

use std::fmt::Write;

use leafwise_expression::Expression;

use crate::report::FoundBracket;

impl FoundBracket {
    /// A formula of this system as text that a scene reads.
    pub fn written(&self, formula: &Expression) -> String {
        let parameters = self.system.parameters().iter();
        let names: Vec<String> = parameters.map(|parameter| parameter.name.clone()).collect();
        formula.written(self.system.variables(), &names)
    }

    /// The entries that are not zero: names of two variables and the formula of their bracket.
    pub fn rows(&self) -> Vec<([&str; 2], String)> {
        let names = self.system.variables();
        let rows = self.entries.iter();
        rows.map(|(&(i, j), entry)| ([names[i].as_str(), names[j].as_str()], self.written(entry)))
            .collect()
    }

    /// The Casimirs: their names and formulas.
    pub fn named_casimirs(&self) -> Vec<(&str, String)> {
        let casimirs = self.system.casimirs().iter();
        casimirs
            .map(|casimir| (casimir.name.as_str(), self.written(&casimir.expression)))
            .collect()
    }

    /// The `[system]` table of a scene whose motion is that of the equations.
    pub fn fragment(&self) -> String {
        let variables: Vec<String> = self.system.variables().iter().map(|v| quoted(v)).collect();
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
        let parameters = self.system.parameters().iter();
        let parameters: Vec<(String, String)> = parameters
            .map(|parameter| (quoted(&parameter.name), format!("{:?}", parameter.value)))
            .collect();
        if !parameters.is_empty() {
            text.push_str(&line("parameters", parameters));
        }
        let rows = self.rows().into_iter();
        let rows = rows.map(|([x, y], entry)| (quoted(&format!("{x},{y}")), quoted(&entry)));
        text.push_str(&line("bracket", rows.collect()));
        text.push_str("convention  = \"{x,H}\"\n");
        let _ = writeln!(
            text,
            "hamiltonian = {}",
            quoted(&self.written(&self.hamiltonian))
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
