//! A bracket as the text of a scene's `[system]` table.

use leafwise_expression::Expression;

use crate::report::FoundBracket;

impl FoundBracket {
    /// A formula of this system as text that a scene reads.
    pub fn written(&self, formula: &Expression) -> String {
        self.system.written(formula)
    }

    /// The entries that are not zero: names of two variables and the formula of their bracket.
    pub fn rows(&self) -> Vec<([&str; 2], String)> {
        self.system.bracket_rows()
    }

    /// The Casimirs: their names and formulas.
    pub fn named_casimirs(&self) -> Vec<(&str, String)> {
        self.system.named_casimirs()
    }

    /// The `[system]` table of a scene whose motion is that of the equations.
    pub fn fragment(&self) -> String {
        self.system.fragment()
    }
}
