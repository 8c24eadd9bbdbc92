//! A figure as it was measured, beside what the paper says of it.

use leafwise_report::Panel;

use super::paper::{Claim, PaperFigure};

/// A figure of the paper, measured.
#[derive(Clone, Debug)]
pub struct Reproduced {
    /// Figure as the paper prints it: number, setting and claims.
    pub paper: &'static PaperFigure,
    /// The curves.
    pub panels: Vec<Panel>,
    /// One for each of the paper's statements, in its order.
    pub findings: Vec<Finding>,
    /// A scene that runs it.
    pub scene: Option<String>,
}

/// Measurement of one statement of the paper, judged against the printed number and against theory.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The statement.
    pub claim: &'static Claim,
    /// Result of the measurement, in words.
    pub measured: String,
    /// The number in it.
    pub value: Option<f64>,
    /// How far it may lie from the true one.
    pub tolerance: Option<f64>,
    /// Explanation by theory, with the reason why ours and the printed number differ where they do.
    pub explanation: String,
    /// Whether ours agrees with the paper's; `None` where the paper prints nothing to compare.
    pub agrees: Option<bool>,
    /// Whether ours is what theory says.
    pub holds: bool,
}

impl Finding {
    /// Whether it agrees with the paper and with theory, in words.
    pub fn verdict(&self) -> &'static str {
        match (self.agrees, self.holds) {
            (_, false) => "against theory",
            (Some(true), true) => "agrees",
            (Some(false), true) => "differs",
            (None, true) => "not printed",
        }
    }
}

impl Reproduced {
    /// Whether everything measured is what theory says.
    pub fn holds(&self) -> bool {
        self.findings.iter().all(|finding| finding.holds)
    }
}
