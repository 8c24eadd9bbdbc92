//! Time as a coordinate: the phase space of a scene extended by (t, e).
//!
//! Where H names the time, x' = {H(·, t), x} is the motion of K(x, t, e) = H(x, t) + e. The bracket of K is the direct
//! sum of the scene's and a canonical one of t and e: t' = 1, e' = −∂H/∂t. K is constant: it is the energy balance H −
//! ∫ ∂H/∂t dt (C. Lanczos, *The Variational Principles of Mechanics*, section VI.10). Both coordinates stand behind the
//! scene's own, and nothing outside shows them.
//!
//! A bracket that changes with time has no such sum: {e, {x, y}} = ∂{x, y}/∂t breaks the Jacobi identity. A one-form
//! that does has: ϑ + e dt is the action ∫ ϑ·dx − H dt, whose motion knows ∂ϑ/∂t; then e' = −∂H/∂t + ∂ϑ/∂t·x'.
//!
//! K = (H + e) g, with a pace g > 0, makes steps variable that stay Poisson maps. With e(0) = −H(x(0)), K = 0. Hence x
//! moves by dx/dτ = g {H, x} and t by dt/dτ = g. Equal steps of τ are then steps g·τ of t (K. Zare, V. Szebehely, *Time
//! transformations in the extended phase-space*, Celestial Mechanics 11 (1975); E. Hairer, *Variable time step
//! integration with symplectic methods*, Applied Numerical Mathematics 25 (1997)).

use leafwise_core::lattice::LatticeGeometry;
use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;
use leafwise_walk::Clock;
use thiserror::Error;

use super::Refusal;
use super::definitions;
use super::names::function;
use super::tensor::Entries;
use super::time::{TIME, declares_time, wants_time};
use crate::document::{Convention, Located, SceneDocument};

/// Name of e, the coordinate conjugate to the time, in messages: no name of a formula.
const ENERGY: &str = "-H";

/// The two coordinates behind a scene's own.
#[derive(Clone, Debug, PartialEq)]
pub struct Extension {
    /// Where t and e stand in a state: behind the scene's own coordinates and parameters of sites.
    pub clock: Clock,
    /// dt/dτ, where steps are of a fictitious time τ.
    pub pace: Option<PaceFormula>,
    /// H + e.
    energy: Expression,
}

/// g = dt/dτ, a positive function of the scene's coordinates and the time.
#[derive(Clone, Debug, PartialEq)]
pub struct PaceFormula {
    /// As the scene writes it.
    pub text: String,
    /// The function of the extended phase space.
    pub formula: Expression,
}

/// Why no paced motion begins at a state.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoStart {
    /// H has no finite value.
    #[error("the energy is {value:?} at the initial state")]
    Energy {
        /// H.
        value: f64,
    },
    /// The pace is not positive.
    #[error("the pace is {value:?} at the initial state, and must be positive")]
    Pace {
        /// g.
        value: f64,
    },
}

impl Extension {
    /// Extension by (t, e) of a scene whose Hamiltonian, one-form or forces name the time, or that has a pace; `None`
    /// for others. Formulas that may name the time are read in `scope`. This is given the name of the time and the
    /// definitions that name it.
    ///
    /// Then [`extend`](Self::extend) puts (t, e) behind the coordinates of the instantiated scene: K for H, an entry of
    /// the bracket, two names. A one-form or two-form is given its components by `Forms::extend`.
    ///
    /// # Errors
    /// A pace that is `auto` or cannot be read, and definitions that cannot be read.
    pub(super) fn of(
        document: &SceneDocument,
        lattice: &LatticeGeometry,
        scope: &mut Scope,
    ) -> Result<Option<Self>, Refusal> {
        if wants_time(document).is_none() {
            return Ok(None);
        }
        let clock = Clock::behind(document.system.dimension());
        let pace = &document.method.pace;
        if !declares_time(document) {
            *scope = definitions::scope(document, lattice, Some(clock.time))?;
        }
        Ok(Some(Self {
            clock,
            pace: pace
                .as_ref()
                .map(|text| read_pace(document, scope, text))
                .transpose()?,
            energy: Expression::Variable(clock.energy),
        }))
    }

    /// Names, bracket and Hamiltonian of the extended phase space in the place of the scene's own.
    pub(super) fn extend(
        &mut self,
        convention: Convention,
        names: &mut Vec<String>,
        bracket: &mut Entries,
        hamiltonian: &mut Expression,
    ) {
        let Clock { time: t, energy: e } = self.clock;
        names.extend([TIME.to_owned(), ENERGY.to_owned()]);
        // t' = 1 under x' = {K, x} needs {e, t} = 1, under x' = {x, K} for {t, e} = 1.
        let one = Expression::from(1);
        let entry = match convention {
            Convention::HamiltonFirst => Expression::Negate(Box::new(one)),
            Convention::HamiltonSecond => one,
        };
        bracket.insert((t, e), entry);
        self.energy = Expression::Sum(vec![hamiltonian.clone(), Expression::Variable(e)]);
        *hamiltonian = match &self.pace {
            None => self.energy.clone(),
            Some(pace) => Expression::Product(vec![self.energy.clone(), pace.formula.clone()]),
        };
    }

    /// State of the extended phase space at t = 0. Beside a pace, K = 0 there.
    ///
    /// # Errors
    /// A pace that is not positive there, and an energy that is not finite.
    pub(super) fn state(
        &self,
        document: &SceneDocument,
        own: &[f64],
        parameters: &[f64],
    ) -> Result<Vec<f64>, Refusal> {
        let mut state = own.to_vec();
        state.extend([0.0, 0.0]);
        let Some(pace) = &document.method.pace else {
            return Ok(state);
        };
        let Err(error) = self.begin(&mut state, parameters) else {
            return Ok(state);
        };
        let (formula, help) = match error {
            NoStart::Energy { .. } => (
                &document.system.hamiltonian,
                "check `initial`: no ln or root of a negative number, no division by zero",
            ),
            NoStart::Pace { .. } => (
                pace,
                "write a formula that is positive along the motion, as \"(q1^2 + q2^2)^0.75\"",
            ),
        };
        Err(Box::new(document.diagnostic(
            &document.place_in_formula(formula, 0..formula.value.len()),
            error.to_string(),
            "at the initial state",
            Some(help.to_owned()),
        )))
    }

    /// Beside a pace gives e its value at the beginning, −H(x, 0), so that K = 0 there; nothing else.
    ///
    /// # Errors
    /// [`NoStart`].
    pub fn begin(&self, state: &mut [f64], parameters: &[f64]) -> Result<(), NoStart> {
        let Some(pace) = &self.pace else {
            return Ok(());
        };
        let e = self.clock.energy;
        state[e] = 0.0;
        let energy = self.energy.evaluate(state, parameters);
        if !energy.is_finite() {
            return Err(NoStart::Energy { value: energy });
        }
        state[e] = -energy;
        let value = pace.formula.evaluate(state, parameters);
        match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(NoStart::Pace { value }),
        }
    }

    /// H + e, whose motion is that of the time itself.
    pub fn energy(&self) -> &Expression {
        &self.energy
    }
}

/// The pace's formula; none is chosen by itself.
fn read_pace(
    document: &SceneDocument,
    scope: &Scope,
    text: &Located<String>,
) -> Result<PaceFormula, Refusal> {
    if text.value.trim() == "auto" {
        return Err(Box::new(document.diagnostic(
            &document.place_in_formula(text, 0..text.value.len()),
            "a pace is never chosen automatically: one from the derivatives of the motion makes a step several times as expensive as a formula by hand",
            "not a formula",
            Some(
                "write a positive formula, as \"(q1^2 + q2^2)^0.75\" for a body about a centre at q = 0".to_owned(),
            ),
        )));
    }
    Ok(PaceFormula {
        text: text.value.clone(),
        formula: function(document, scope, text)?,
    })
}
