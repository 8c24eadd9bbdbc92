//! One thing measured of a part.

use leafwise_core::StepError;
use leafwise_core::diagnostics::{IdentityCheck, Verdict};
use leafwise_scene::json::optional;
use serde::Serialize;

use crate::verify::{Judgement, MeasuredOrder, Problem};

/// One thing measured of a part on one problem.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// The problem that it was tried on; `itself` for a system.
    pub problem: String,
    /// Where the part's values come from, for a part with several ways: `expressions` or `numbers`.
    pub path: Option<&'static str>,
    /// Name of the quantity that was measured.
    pub quantity: String,
    /// Result of the measurement, in words.
    pub found: String,
    /// The number behind it.
    #[serde(serialize_with = "optional")]
    pub value: Option<f64>,
    /// The most that the number may be.
    #[serde(serialize_with = "optional")]
    pub bound: Option<f64>,
    /// Judgement of the part's declaration that follows from the result.
    pub judgement: Judgement,
}

/// On which problem and by which values something is measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    pub path: Option<&'static str>,
    pub problem: &'a str,
}

impl Place<'_> {
    fn finding(self, quantity: impl Into<String>, found: String, judgement: Judgement) -> Finding {
        Finding {
            path: self.path,
            problem: self.problem.to_owned(),
            quantity: quantity.into(),
            found,
            value: None,
            bound: None,
            judgement,
        }
    }

    /// A number that may not be larger than `bound`.
    pub fn at_most(self, quantity: impl Into<String>, value: f64, bound: f64) -> Finding {
        let judgement = if value <= bound {
            Judgement::Met
        } else {
            Judgement::NotMet
        };
        Finding {
            value: Some(value),
            bound: Some(bound),
            ..self.finding(
                quantity,
                format!("{value:.1e}, at most {bound:.1e}"),
                judgement,
            )
        }
    }

    /// A number relative to the state that is judged elsewhere.
    pub fn judged(self, quantity: impl Into<String>, value: f64, judgement: Judgement) -> Finding {
        let found = format!("{value:.1e} of the state");
        Finding {
            value: Some(value),
            ..self.finding(quantity, found, judgement)
        }
    }

    /// An identity of a system.
    pub fn identity(
        self,
        quantity: impl Into<String>,
        check: &IdentityCheck,
        variables: &[String],
    ) -> Finding {
        let floor = check.floor.map_or_else(String::new, |floor| {
            format!(" (by differences, accurate to {floor:.1e})")
        });
        let (found, judgement) = match check.verdict {
            Verdict::Proved => ("proved".to_owned(), Judgement::Met),
            Verdict::ByConstruction => ("by construction".to_owned(), Judgement::Met),
            Verdict::NumericallyZero => (
                format!("{:.1e} of its terms{floor}", check.residual),
                Judgement::Met,
            ),
            Verdict::Violated => {
                let worst = check.worst.iter().map(|i| variables[*i].as_str());
                let worst: Vec<&str> = worst.collect();
                let of = if worst.is_empty() { "" } else { " at " };
                let found = format!(
                    "violated by {:.1e} of its terms{of}{}{floor}",
                    check.residual,
                    worst.join(", ")
                );
                (found, Judgement::NotMet)
            }
            Verdict::Undecided => ("no finite value".to_owned(), Judgement::Undecided),
        };
        Finding {
            value: Some(check.residual),
            ..self.finding(quantity, found, judgement)
        }
    }

    /// An order against the one declared; `None` where what it is the order of is round-off.
    pub fn order(
        self,
        quantity: impl Into<String>,
        declared: &str,
        measured: Option<MeasuredOrder>,
        judgement: Judgement,
    ) -> Finding {
        let seen = measured.map(|order| (order.exponent, order.tolerance, order.at_least));
        let found = match seen {
            None => "round-off".to_owned(),
            Some((Some(exponent), Some(tolerance), _)) if tolerance < 1.0 => {
                format!("{exponent:.2} ±{tolerance:.2}")
            }
            Some((_, _, Some(slope))) => format!("at least {slope:.2}"),
            Some(_) => "too few errors between round-off and large steps".to_owned(),
        };
        Finding {
            value: measured.and_then(|order| order.exponent),
            ..self.finding(quantity, format!("{found}, declared {declared}"), judgement)
        }
    }

    /// Something that holds or does not.
    pub fn holds(self, quantity: impl Into<String>, broken: Option<String>) -> Finding {
        match broken {
            None => self.finding(quantity, "holds".to_owned(), Judgement::Met),
            Some(how) => self.finding(quantity, how, Judgement::NotMet),
        }
    }

    /// Something that could not be measured, and says nothing of the part.
    pub fn open(self, quantity: impl Into<String>, why: impl Into<String>) -> Finding {
        self.finding(quantity, why.into(), Judgement::Open)
    }

    /// Something that should have worked, unless the problem lies outside the part's domain.
    pub fn failed(self, quantity: impl Into<String>, error: &StepError) -> Finding {
        let judgement = match error {
            StepError::LeftChart { .. }
            | StepError::OutsideDomain { .. }
            | StepError::OtherBranch { .. } => Judgement::Open,
            _ => Judgement::NotMet,
        };
        self.finding(quantity, error.to_string(), judgement)
    }
}

impl Finding {
    /// Whether no declaration is broken.
    pub fn is_met(&self) -> bool {
        self.judgement != Judgement::NotMet
    }

    /// A part that serves no problem.
    pub(super) fn not_tried(path: Option<&'static str>, problems: &[Problem]) -> Self {
        let names: Vec<&str> = problems.iter().map(|p| p.name.as_str()).collect();
        let place = Place {
            path,
            problem: "none",
        };
        let instead = "offer a system that it is meant for in the same plugin, or measure it on a \
                       separate scene with `leafwise verify`";
        place.open(
            "problems",
            match names.as_slice() {
                [] => format!("formulas do not say for which system they are meant; {instead}"),
                names => format!("it serves none of {}; {instead}", names.join(", ")),
            },
        )
    }
}

/// The worst of one thing measured at several states.
pub(super) fn worst(found: impl IntoIterator<Item = Finding>) -> Option<Finding> {
    let rank = |finding: &Finding| match finding.judgement {
        Judgement::NotMet => 3,
        Judgement::Undecided => 1,
        Judgement::Open => 0,
        Judgement::Met => 2,
    };
    let excess = |finding: &Finding| {
        let value = finding.value.unwrap_or(0.0);
        finding.bound.map_or(value, |bound| value / bound)
    };
    let order = |a: &Finding, b: &Finding| {
        let by_rank = rank(a).cmp(&rank(b));
        // The first of equals.
        by_rank
            .then_with(|| excess(a).total_cmp(&excess(b)))
            .reverse()
    };
    found.into_iter().min_by(order)
}
