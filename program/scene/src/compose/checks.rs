//! The Jacobi identity and the Casimirs of a scene, and whether its functions, where it has no formulas, are those of one system.

use leafwise_core::diagnostics::{
    IdentityCheck, Inconsistency, Verdict, check_casimir, check_jacobi, find_inconsistency,
};
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};

use super::Refusal;
use crate::document::{BracketSpec, SceneDocument};

/// Results of the checks of a scene's tensor and Casimirs, near its initial state.
#[derive(Clone, Debug)]
pub struct SceneChecks {
    /// The Jacobi identity; the worst entry is a triple of coordinates.
    pub jacobi: IdentityCheck,
    /// Π ∇C = 0 for each Casimir in order.
    pub casimirs: Vec<CasimirCheck>,
    /// Why the values of a system of numbers are those of no Poisson system, if they are not.
    pub inconsistency: Option<Inconsistency>,
}

/// One Casimir's check.
#[derive(Clone, Debug)]
pub struct CasimirCheck {
    /// Its name.
    pub name: String,
    /// The worst entry is the row of Π ∇C.
    pub check: IdentityCheck,
}

impl SceneChecks {
    /// Checks a system at its parameters' values near a state.
    ///
    /// # Errors
    /// [`BuildError`] where a formula has no derivative.
    pub fn of(system: &PoissonSystem, near: &[f64]) -> Result<Self, BuildError> {
        let parameters = system.parameter_values();
        let inconsistency = find_inconsistency(system, &parameters, near);
        let jacobi = check_jacobi(system, &parameters, near)?;
        let names = system.casimir_names();
        let mut casimirs = Vec::with_capacity(names.len());
        for (index, name) in names.into_iter().enumerate() {
            let check = check_casimir(system, index, &parameters, near)?;
            casimirs.push(CasimirCheck {
                name: name.to_owned(),
                check,
            });
        }
        Ok(Self {
            jacobi,
            casimirs,
            inconsistency,
        })
    }

    /// Whether nothing was found violated.
    pub fn pass(&self) -> bool {
        self.inconsistency.is_none()
            && self.jacobi.verdict != Verdict::Violated
            && self.false_casimir().is_none()
    }

    fn false_casimir(&self) -> Option<usize> {
        self.casimirs
            .iter()
            .position(|casimir| casimir.check.verdict == Verdict::Violated)
    }

    /// Why a run of this scene, which begins `near` a state, is refused, if it is. With `allow_non_poisson` neither a tensor
    /// that violates the Jacobi identity nor, then, its Casimirs are refused; functions of no Poisson system always are.
    pub fn refusal(
        &self,
        document: &SceneDocument,
        (system, near): (&PoissonSystem, &[f64]),
        allow_non_poisson: bool,
    ) -> Option<Refusal> {
        let names = |indices: &[usize]| {
            if indices.is_empty() {
                return "linear functions of all coordinates".to_owned();
            }
            let names: Vec<&str> = indices
                .iter()
                .map(|i| system.variables()[*i].as_str())
                .collect();
            names.join(", ")
        };
        let name_of = |i: usize| system.variables()[i].as_str();
        if let Some(found) = &self.inconsistency {
            return Some(Box::new(document.diagnostic(
                &document.system.bracket.place(),
                found.told(system.variables()),
                "not the functions of one Poisson system",
                Some(found.advice().to_owned()),
            )));
        }
        if self.jacobi.verdict == Verdict::Violated {
            if allow_non_poisson {
                return None;
            }
            let fails = format!(
                "the Jacobi identity fails for {}, where {} of its terms is left",
                names(&self.jacobi.worst),
                part(self.jacobi.residual)
            );
            // In space the sum for the three velocities is div B, and all others vanish.
            let (message, label, what) = match document.system.bracket.value {
                BracketSpec::MagneticField(_) => (
                    format!(
                        "the divergence of the magnetic field, dBx/dx + dBy/dy + dBz/dz, is not zero: {fails}"
                    ),
                    "has a divergence",
                    "its components",
                ),
                _ => (
                    format!("the bracket is not Poisson: {fails}"),
                    "violates the Jacobi identity",
                    "the bracket",
                ),
            };
            let help =
                format!("correct {what}, or pass --allow-non-poisson to integrate it anyway");
            let place = &document.system.bracket.place();
            return Some(Box::new(document.diagnostic(
                place,
                message,
                label,
                Some(help),
            )));
        }
        let index = self.false_casimir()?;
        // Constraints come after the Casimirs, and are named by their text.
        let declared = document.system.casimirs.iter();
        let declared = declared.map(|(name, formula)| (name, formula));
        let constraints = document.system.constraints.iter().map(|text| (text, text));
        let (name, formula) = declared.chain(constraints).nth(index)?;
        let check = &self.casimirs[index].check;
        let slip = system
            .expressions()
            .filter(|_| matches!(document.system.bracket.value, BracketSpec::Entries(_)))
            .and_then(|formulas| slip(formulas, index, near));
        let entries = match slip {
            Some([i, j]) => format!(
                "change the sign of {{{}, {}}} in the bracket, which makes it one",
                name_of(i),
                name_of(j)
            ),
            None => format!("correct the bracket's entries with {}", names(&check.worst)),
        };
        Some(Box::new(document.diagnostic(
            &document.place_in_formula(formula, 0..formula.value.len()),
            format!(
                "`{}` is not a Casimir: its bracket with {} does not vanish, {} of its terms is left",
                name.value,
                names(&check.worst),
                part(check.residual)
            ),
            "not conserved by every Hamiltonian",
            Some(format!(
                "correct it, or {entries}, or move it to run.record.observables = [\"{}\"] to watch it only",
                formula.value
            )),
        )))
    }
}

/// A residual relative to the sizes of what is summed, in words.
fn part(residual: f64) -> String {
    match residual >= 0.005 {
        true => format!("{:.0} % of the size", 100.0 * residual),
        false => format!("{residual:.1e} of the size"),
    }
}

/// The entry of the tensor by whose other sign a Casimir would be one, if there is one alone.
fn slip(formulas: &SystemFormulas, casimir: usize, near: &[f64]) -> Option<[usize; 2]> {
    const SHIFT: f64 = 1e-5;
    const ROUND_OFF: f64 = 1e-6;
    let parameters = formulas.parameter_values();
    let casimir = &formulas.casimirs().get(casimir)?.expression;
    let mut fits: Vec<[usize; 2]> = formulas.tensor().keys().map(|&(i, j)| [i, j]).collect();
    // Two states of no special place.
    for seed in [0.3, 1.7] {
        let moved = near.iter().zip(1_u32..);
        let state: Vec<f64> = moved
            .map(|(x, at)| x + 0.5 * libm::sin(seed + f64::from(at)))
            .collect();
        let slope = |at: usize| {
            let value = |shift: f64| {
                let mut state = state.clone();
                state[at] += shift;
                casimir.evaluate(&state, &parameters)
            };
            (value(SHIFT) - value(-SHIFT)) / (2.0 * SHIFT)
        };
        let slopes: Vec<f64> = (0..state.len()).map(slope).collect();
        let (mut sums, mut sizes) = (vec![0.0; state.len()], vec![0.0; state.len()]);
        let mut terms = Vec::new();
        for (&(i, j), entry) in formulas.tensor() {
            let value = entry.evaluate(&state, &parameters);
            for (row, term) in [(i, value * slopes[j]), (j, -value * slopes[i])] {
                sums[row] += term;
                sizes[row] += term.abs();
                terms.push(([i, j], row, term));
            }
        }
        fits.retain(|entry| {
            let mut sums = sums.clone();
            let own = terms.iter().filter(|(of, ..)| of == entry);
            own.for_each(|(_, row, term)| sums[*row] -= 2.0 * term);
            let mut rows = sums.iter().zip(&sizes);
            rows.all(|(sum, size)| sum.abs() <= ROUND_OFF * size)
        });
    }
    match fits.as_slice() {
        [only] => Some(*only),
        _ => None,
    }
}
