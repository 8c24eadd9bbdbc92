//! Questions to a composed run: its coordinates, walk, functions and motion.

use std::borrow::Cow;

use leafwise_core::system::{Forces, SystemObservables};
use leafwise_core::{BuildError, MotionClass, PoissonSystem, Structure, SystemFormulas, Walk};
use leafwise_expression::Expression;
use leafwise_walk::{Direction, Section};

use super::Refusal;
use super::events::section_of;
use super::extended::PaceFormula;
use super::run::ComposedRun;
use crate::document::SceneDocument;

impl ComposedRun {
    /// The dimension of the state that is stepped, that of a long lattice at its true length.
    pub fn dimension(&self) -> usize {
        self.method.map().dimension()
    }

    /// The scene's own coordinates of a state that is stepped: all but parameters of sites, the time and its energy.
    pub fn own<'a>(&self, state: &'a [f64]) -> &'a [f64] {
        &state[self.plan.layout.own()]
    }

    /// Whether the state that is stepped holds more than the scene's own coordinates.
    pub fn is_extended(&self) -> bool {
        !self.plan.layout.beside().is_empty()
    }

    /// A surface of its scene, `left = right`, beside the one that it may have itself.
    ///
    /// # Errors
    /// Those of [`section_of`].
    pub fn section(
        &self,
        document: &SceneDocument,
        text: &str,
        direction: Direction,
    ) -> Result<Section, Refusal> {
        let parameters = self.system.parameter_values();
        let is_long = self.method.lattice().is_some();
        let start = (self.plan.initial.as_slice(), parameters.as_slice());
        section_of(document, is_long, start, text, direction)
    }

    /// Where t stands in a state, where steps are of a fictitious time τ.
    pub fn time_place(&self) -> Option<usize> {
        self.pace()?;
        self.plan.layout.clock().map(|clock| clock.time)
    }

    /// e at an initial state, from which H + e is measured, where steps are of a fictitious time τ.
    pub fn origin(&self, initial: &[f64]) -> Option<f64> {
        self.pace()?;
        self.plan.layout.clock().map(|clock| initial[clock.energy])
    }

    /// dt/dτ, where steps are of a fictitious time τ.
    pub fn pace(&self) -> Option<&PaceFormula> {
        self.extension.as_ref()?.pace.as_ref()
    }

    /// A walk at the scene's initial state, with its parameters and step sizes.
    pub fn walk(&self) -> Walk {
        let parameters = self.system.parameter_values();
        let plan = &self.plan;
        Walk::new(
            self.method.map(),
            &parameters,
            plan.epsilon,
            plan.h,
            &plan.initial,
        )
    }

    /// Functions of the state at the parameters' values, compiled once for this run and its copies at other values.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn observables(&self, formulas: &[&Expression]) -> Result<SystemObservables, BuildError> {
        self.functions.observables(&self.system, formulas)
    }

    /// The system whose steps are of the time itself, where those of this run are of another.
    pub fn in_time(&self) -> Result<Cow<'_, PoissonSystem>, BuildError> {
        let paced = self.extension.as_ref().filter(|_| self.pace().is_some());
        Ok(match (paced, self.system.expressions()) {
            (Some(extension), Some(formulas)) => {
                let in_time = formulas.with_hamiltonian(extension.energy().clone())?;
                Cow::Owned(in_time.into())
            }
            _ => Cow::Borrowed(&self.system),
        })
    }

    /// Forces of the system, or of one site of many bodies; `None` for another system of numbers.
    pub fn forces(&self) -> Option<&Forces> {
        let formulas = self.system.expressions().or(self.site.as_ref());
        formulas.map(SystemFormulas::forces)
    }

    /// Forces and friction by their keys, in the words of an advice: `take system.forces and system.friction out`.
    pub fn without_forces(&self) -> String {
        format!("take {} out", self.force_keys.join(" and "))
    }

    /// Work of forces, of friction, of noise and of contact motions: how they change the energy and the Casimirs, in words. What steps that keep
    /// the energy are. `None` elsewhere.
    pub fn work_of_forces(&self) -> Option<String> {
        if self.keeps_energy {
            return Some(
                "kept to round-off by multiples of Casimirs, others in each step: the whole is not a Poisson map"
                    .to_owned(),
            );
        }
        if self.contact.is_some() {
            return Some("changes as in every contact motion: dH/dt = -H dH/ds".to_owned());
        }
        let forces = self.forces()?;
        if forces.motion() == MotionClass::OffLeaves {
            let has_forces = !forces.one_form.is_empty() || forces.damping.is_some();
            let energy = match (self.method.noise().is_some(), has_forces) {
                (false, false) => "changes by the friction: dH/dt = <dH, friction>",
                (false, true) => {
                    "changes by the forces and the friction: dH/dt = -<forces, {H, x}> + <dH, friction>"
                }
                (true, false) => "changes by the noise and the friction",
                (true, true) => "changes by the noise, the forces and the friction",
            };
            let map = match self.system.casimir_names().is_empty() {
                true => "no Poisson map: the friction changes the tensor",
                false => {
                    "no Poisson map: the Casimirs change by the friction, dC/dt = <dC, friction>"
                }
            };
            return Some(format!("{energy}; {map}"));
        }
        let energy = match (forces.one_form.is_empty(), &forces.damping) {
            (true, None) if self.method.noise().is_some() => "changes by the noise",
            (false, _) | (_, Some(_)) if self.method.noise().is_some() => {
                "changes by the noise and the forces"
            }
            (true, None) => return None,
            (true, Some(damping)) if damping.rate.variables().is_empty() => {
                "falls by the damping: dH/dt = -rate <g v, v> with v = {H, x}"
            }
            (true, Some(_)) => "changes by the damping: dH/dt = -rate <g v, v> with v = {H, x}",
            (false, _) => "changes by the forces: dH/dt = -<forces, {H, x}>",
        };
        let has_casimirs = !self.system.casimir_names().is_empty();
        let casimirs = match self.method.map().properties().structure {
            _ if !has_casimirs => "",
            Structure::Leaves | Structure::Exact => "; Casimirs are kept to round-off",
            _ => "; these steps keep Casimirs to an order alone",
        };
        Some(format!("{energy}{casimirs}"))
    }

    /// The names of the scene's own coordinates.
    pub fn names(&self) -> Vec<String> {
        match self.method.lattice() {
            None => {
                let mut names = self.system.variables().to_vec();
                names.truncate(self.plan.layout.coordinates());
                names
            }
            Some(geometry) => (self.plan.layout.own())
                .map(|coordinate| geometry.name(coordinate))
                .collect(),
        }
    }
}
