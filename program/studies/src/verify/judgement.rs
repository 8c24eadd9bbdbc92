//! Judgements of declarations by measurements.

use serde::Serialize;

/// Whether a declaration is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// The measurement agrees.
    Met,
    /// It does not.
    NotMet,
    /// The measurement does not tell the declared order from the one below, or the formulas are too rough for it.
    Undecided,
    /// Nothing was declared, or the map offers nothing to measure it by.
    Open,
}

impl Judgement {
    /// The judgement of an order `declared` on formulas that bear no more than `smooth`.
    ///
    /// Orders hold for smooth formulas: a lower one that is seen on others breaks no declaration.
    pub(super) fn on_rough(self, declared: usize, smooth: Option<usize>) -> Self {
        match self {
            Self::NotMet if smooth.is_some_and(|smooth| smooth < declared) => Self::Undecided,
            judgement => judgement,
        }
    }
}
