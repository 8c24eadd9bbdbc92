//! Where the numbers of a run's steps come from.

use leafwise_core::PartKind;
use leafwise_expression::Execution;

use super::part_choice::PartChoice;
use super::run::ComposedRun;

/// Formulas that are compiled, and functions that are called.
const EXPRESSIONS: &str = "expressions";
const NUMBERS: &str = "numbers";

impl ComposedRun {
    /// Where the values of a part come from: `expressions` or `numbers`. What is built in works on what
    /// the system gives.
    pub fn path_of(&self, choice: &PartChoice) -> &'static str {
        choice.path.unwrap_or(self.system.path())
    }

    /// How a step is computed, for the manifest: from expressions, from numbers, or from which parts
    /// each; then how these meet, and what runs the compiled code.
    pub fn path(&self) -> String {
        let mut by_calls = Vec::new();
        let mut compiled = Vec::new();
        let parts = self.plan.parts.iter();
        let parts = parts.filter(|choice| choice.kind != PartKind::Composition);
        let parts = parts.map(|choice| (choice.kind, self.path_of(choice)));
        for (kind, path) in std::iter::once((PartKind::System, self.system.path())).chain(parts) {
            if path == NUMBERS {
                by_calls.push(kind.noun());
            } else {
                compiled.push(kind.noun());
            }
        }
        let meeting = self.method.path();
        let execution = Execution::default_of_process().describe();
        if compiled.is_empty() {
            format!("{NUMBERS}, by calls; {meeting}")
        } else if by_calls.is_empty() {
            format!("{EXPRESSIONS}, compiled to straight-line code; {meeting}; {execution}")
        } else {
            format!(
                "{NUMBERS}, by calls: {}; {EXPRESSIONS}, compiled to straight-line code: {}; \
                 {meeting}; {execution}",
                by_calls.join(", "),
                compiled.join(", ")
            )
        }
    }
}
