//! Time as a coordinate: the phase space of a scene extended by (t, e).
//!
//! Where H names the time, x' = {H(·, t), x} is the motion of K(x, t, e) = H(x, t) + e under the direct sum of the scene's
//! bracket and a canonical one of t and e: t' = 1, e' = −∂H/∂t, and K, the energy balance H − ∫ ∂H/∂t dt, is constant
//! (C. Lanczos, *The Variational Principles of Mechanics*, section VI.10). Both coordinates stand behind the scene's own,
//! and nothing outside shows them.
//!
//! A bracket that changes with time has no such sum: {e, {x, y}} = ∂{x, y}/∂t breaks the Jacobi identity.

use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};

use super::Refusal;
use super::lattice::DENSE_LIMIT;
use super::tensor::Entries;
use crate::document::{Convention, InitialSpec, Located, Place, SceneDocument};

/// What formulas call the time.
pub(super) const TIME: &str = "t";

/// What messages call the coordinate conjugate to the time: no name of a formula.
const ENERGY: &str = "-H";

/// The two coordinates behind a scene's own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extension {
    /// d, the number of the scene's own coordinates: t is x_d, e is x_{d+1}, counted from 0.
    pub coordinates: usize,
}

impl Extension {
    /// The extension that a scene asks for.
    ///
    /// # Errors
    /// A lattice too long to be written out.
    pub(super) fn of(document: &SceneDocument) -> Result<Option<Self>, Refusal> {
        let hamiltonian = &document.system.hamiltonian;
        if !names_time(document, hamiltonian) {
            return Ok(None);
        }
        let coordinates = document.system.dimension();
        if !document.system.families.is_empty() && coordinates > DENSE_LIMIT {
            return Err(Box::new(document.diagnostic(
                &document.place_in_formula(hamiltonian, 0..hamiltonian.value.len()),
                format!(
                    "a Hamiltonian that names the time t is not offered on a lattice of more than {DENSE_LIMIT} \
                     coordinates, and this one has {coordinates}: every site moves t's energy"
                ),
                "names t",
                Some("shorten the lattice".to_owned()),
            )));
        }
        Ok(Some(Self { coordinates }))
    }

    /// The scene's names and the time.
    pub(super) fn scope(&self, scope: Scope) -> Scope {
        scope.with_variable(TIME, self.coordinates)
    }

    /// Names, bracket and Hamiltonian of the extended phase space.
    pub(super) fn extend(
        &self,
        convention: Convention,
        names: &mut Vec<String>,
        bracket: &mut Entries,
        hamiltonian: &mut Expression,
    ) {
        let (t, e) = (self.coordinates, self.coordinates + 1);
        names.extend([TIME.to_owned(), ENERGY.to_owned()]);
        // t' = 1 under x' = {K, x} asks for {e, t} = 1, under x' = {x, K} for {t, e} = 1.
        let one = Expression::from(1);
        let entry = match convention {
            Convention::HamiltonFirst => Expression::Negate(Box::new(one)),
            Convention::HamiltonSecond => one,
        };
        bracket.insert((t, e), entry);
        let own = std::mem::replace(hamiltonian, Expression::Variable(e));
        *hamiltonian = Expression::Sum(vec![own, Expression::Variable(e)]);
    }

    /// A state of the extended phase space at t = 0.
    pub fn state(&self, own: &[f64]) -> Vec<f64> {
        let mut state = own.to_vec();
        state.extend([0.0, 0.0]);
        state
    }
}

/// Whether a formula names the time, which no declared name hides.
fn names_time(document: &SceneDocument, formula: &Located<String>) -> bool {
    !declares_time(document)
        && Formula::parse(&formula.value).is_ok_and(|parsed| parsed.references().contains(TIME))
}

fn declares_time(document: &SceneDocument) -> bool {
    let system = &document.system;
    let variables = system.variables.iter();
    let families = system.families.iter().map(|(name, _)| name);
    let parameters = system.parameters.iter().map(|(name, _)| name);
    let mut declared = variables.chain(families).chain(parameters);
    declared.any(|name| name.value == TIME)
}

/// What is wrong with a formula that names the time and may not, with what to try.
pub(super) fn about_time(
    document: &SceneDocument,
    formula: &Located<String>,
) -> Option<(String, String)> {
    let system = &document.system;
    let is = |other: &Located<String>| other.place() == formula.place();
    let within = |whole: &Place| {
        let (outer, inner) = (&whole.span, &formula.span);
        whole.source == formula.source && outer.start <= inner.start && inner.end <= outer.end
    };
    let told = |message: &str, help: &str| Some((message.to_owned(), help.to_owned()));
    if system.casimirs.iter().any(|(_, casimir)| is(casimir)) {
        return told(
            "a Casimir cannot name the time t: it would move with it",
            "a function of t and of Casimirs may stand in run.record.observables",
        );
    }
    if within(&system.bracket.place()) {
        return told(
            "the bracket cannot name the time t: a motion keeps a bracket only where it does not change, and with t as \
             a coordinate the Jacobi identity fails",
            "a factor f(t) of the whole bracket belongs into the Hamiltonian; a magnetic field that changes comes with \
             an electric one: write positions and canonical momenta, with the vector potential A(x, t) in H",
        );
    }
    if let InitialSpec::Fields(fields) = &document.run.initial.value
        && fields.iter().any(|(_, field)| is(field))
    {
        return told(
            "the initial state cannot name the time t: every run begins at t = 0",
            "begin later by another phase, as in cos(omega*t + phase) with a parameter",
        );
    }
    told(
        "the Hamiltonian does not name the time t, and no other formula may",
        "the first column of samples.csv is t",
    )
}
