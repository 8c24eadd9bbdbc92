//! What a run records: the energy, Casimirs, or any formula of the state.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};

use super::Refusal;
use super::names::{function, refusal};
use super::time::TIME;
use crate::document::{Located, SceneDocument, nearest};

/// One recorded quantity.
#[derive(Clone, Debug)]
pub enum Observable {
    /// An invariant by its place: 0 is the energy, k the k-th Casimir.
    Invariant {
        /// Its name.
        name: String,
        /// Its place.
        index: usize,
    },
    /// A formula of the state, named by its text.
    Formula {
        /// The text.
        name: String,
        /// The function.
        expression: Expression,
    },
    /// A coordinate of a long lattice by its place.
    Coordinate {
        /// Its name.
        name: String,
        /// Its place.
        index: usize,
    },
}

impl Observable {
    /// The heading of its column.
    pub fn name(&self) -> &str {
        match self {
            Self::Invariant { name, .. }
            | Self::Formula { name, .. }
            | Self::Coordinate { name, .. } => name,
        }
    }
}

/// The observables the scene asks for; with the lattice's true lengths in `lattice` where `scope` is that
/// of a shorter one.
pub(super) fn observables(
    document: &SceneDocument,
    scope: &Scope,
    lattice: Option<&LatticeGeometry>,
) -> Result<Vec<Observable>, Refusal> {
    let mut known = vec!["energy"];
    known.extend(
        document
            .system
            .casimirs
            .iter()
            .map(|(name, _)| name.value.as_str()),
    );
    known.extend(document.system.constraints.iter().map(|c| c.value.as_str()));
    let mut chosen: Vec<Observable> = Vec::new();
    for asked in &document.run.record.observables {
        let heading = asked.heading();
        if chosen.iter().any(|observable| observable.name() == heading) {
            let place = asked.name.as_ref().unwrap_or(&asked.formula).place();
            return Err(Box::new(document.diagnostic(
                &place,
                format!("`{heading}` is recorded twice"),
                "again",
                Some("remove one of them, or give it another name".to_owned()),
            )));
        }
        let formula = &asked.formula;
        let name = heading.to_owned();
        let coordinate = lattice.and_then(|lattice| coordinate(lattice, &formula.value));
        chosen.push(match known.iter().position(|name| *name == formula.value) {
            Some(index) => Observable::Invariant { name, index },
            None => match coordinate {
                Some(index) => Observable::Coordinate { name, index },
                None => Observable::Formula {
                    name,
                    expression: expression(document, scope, formula, &known)?,
                },
            },
        });
    }
    Ok(chosen)
}

/// The coordinate that a text such as `q[500]` names.
pub(super) fn coordinate(lattice: &LatticeGeometry, text: &str) -> Option<usize> {
    let (family, rest) = text.trim().split_once('[')?;
    let site: usize = rest.strip_suffix(']')?.trim().parse().ok()?;
    let at = lattice
        .families
        .iter()
        .position(|(name, _)| name == family.trim())?;
    (site < lattice.families[at].1).then(|| lattice.offsets()[at] + site)
}

fn expression(
    document: &SceneDocument,
    scope: &Scope,
    asked: &Located<String>,
    known: &[&str],
) -> Result<Expression, Refusal> {
    let resolved =
        Formula::parse(&asked.value).and_then(|parsed| parsed.resolve(scope, None).map(drop));
    if let Err(error) = resolved {
        let is_name = asked
            .value
            .chars()
            .all(|c| c.is_alphanumeric() || "_-'".contains(c));
        if !is_name || asked.value == TIME {
            return Err(refusal(document, asked, &error));
        }
        let help = match nearest(&asked.value, known.iter().copied()) {
            Some(name) => format!("did you mean `{name}`?"),
            None => format!("record {}, or a formula of the variables", known.join(", ")),
        };
        return Err(Box::new(document.diagnostic(
            &document.place_in_formula(asked, 0..asked.value.len()),
            format!("unknown observable `{}`", asked.value),
            "neither an invariant nor a formula of the variables",
            Some(help),
        )));
    }
    function(document, scope, asked)
}
