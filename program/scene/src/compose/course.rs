//! Course of a run's walks, and the functions of the state that they look at.

use std::sync::Arc;

use leafwise_core::system::{LeafDirections, SystemInvariants};
use leafwise_core::{BuildError, Observer, SystemFormulas};
use leafwise_expression::Expression;
use leafwise_walk::{Begins, Course, Event, Indicator, Indicators, Pace, StateFunctions};

use super::body_columns::BodyColumns;
use super::contact::Contact;
use super::extended::Extension;
use super::lattice_functions::{LatticeFunctions, RecordedColumn, of_coordinates};
use super::observables::{Observable, RecordedFormula};
use super::run::ComposedRun;
use super::spin_temperature::spin_temperature;
use super::stepping::Stepping;

impl ComposedRun {
    /// The energy, then each Casimir, as functions of the state; the energy is the balance H − ∫ ∂H/∂t dt.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn invariants(&self) -> Result<Observer, BuildError> {
        let functions = self.invariant_functions()?;
        let mut values = functions.values(1, &self.system.parameter_values())?;
        if let Some(origin) = self.origin(&self.plan.initial) {
            values.measure_from(&[origin]);
        }
        Ok(values.into())
    }

    /// The energy, H + e where there is a pace, then each Casimir.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn invariant_functions(&self) -> Result<StateFunctions, BuildError> {
        if let Stepping::Lattice(lattice) = &self.method {
            return Ok(of_lattice(&lattice.invariants));
        }
        let Some(formulas) = self.system.expressions() else {
            let system = self.system.clone();
            let count = 1 + system.casimir_names().len();
            return Ok(StateFunctions::each(count, move |parameters| {
                Ok(SystemInvariants::new(&system, parameters)?.into())
            }));
        };
        let energy = self.energy_of(formulas);
        let casimirs = formulas.casimirs().iter();
        let casimirs = casimirs.map(|casimir| &casimir.expression);
        let all: Vec<_> = std::iter::once(energy).chain(casimirs).collect();
        Ok(self.observables(&all)?.into())
    }

    /// H as the scene has it, H + e where there is a pace.
    fn energy_of<'a>(&'a self, formulas: &'a SystemFormulas) -> &'a Expression {
        let paced = self.extension.as_ref().filter(|_| self.pace().is_some());
        let energy = paced.map_or(formulas.hamiltonian(), Extension::energy);
        self.contact.as_ref().map_or(energy, Contact::energy)
    }

    /// The formulas of the state that the scene records.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn recorded_functions(&self) -> Result<StateFunctions, BuildError> {
        if let Stepping::Lattice(lattice) = &self.method {
            return Ok(of_lattice(&lattice.formulas));
        }
        let observables = self.plan.observables.iter();
        let formulas = observables.filter_map(|observable| match observable {
            Observable::Invariant { .. }
            | Observable::Coordinate { .. }
            | Observable::Indicator { .. } => None,
            Observable::Formula { formula, .. } => Some(formula.clone()),
        });
        self.functions_of(formulas.collect())
    }

    /// Functions of the state, those of sums evaluated in loops.
    fn functions_of(
        &self,
        mut formulas: Vec<RecordedFormula>,
    ) -> Result<StateFunctions, BuildError> {
        for formula in &mut formulas {
            match (&formula, self.system.expressions()) {
                (RecordedFormula::SpinTemperature, Some(system)) => {
                    let temperature = spin_temperature(system, self.energy_of(system))?;
                    *formula = RecordedFormula::Written(temperature);
                }
                (RecordedFormula::SpinTemperature | RecordedFormula::OfSites, _) => {
                    return Err(BuildError::Lattice {
                        message: "sums over sites are recorded of a lattice alone".to_owned(),
                    });
                }
                _ => {}
            }
        }
        let written = formulas.iter().filter_map(|formula| match formula {
            RecordedFormula::Written(expression) => Some(expression),
            _ => None,
        });
        let written = self.observables(&written.collect::<Vec<_>>())?;
        match BodyColumns::of(&self.system, &formulas, written.clone())? {
            None => Ok(written.into()),
            Some(columns) => Ok(StateFunctions::each(formulas.len(), move |parameters| {
                Ok(columns.at(parameters).into())
            })),
        }
    }

    /// The formulas and coordinates that the scene records, in their order.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn recorded_columns(&self) -> Result<StateFunctions, BuildError> {
        let observables = self.plan.observables.iter();
        let recorded = observables.filter(|observable| {
            matches!(
                observable,
                Observable::Formula { .. } | Observable::Coordinate { .. }
            )
        });
        let Stepping::Lattice(lattice) = &self.method else {
            let formulas = recorded.map(|observable| match observable {
                Observable::Coordinate { index, .. } => {
                    RecordedFormula::Written(Expression::Variable(*index))
                }
                Observable::Formula { formula, .. } => formula.clone(),
                Observable::Invariant { .. } | Observable::Indicator { .. } => {
                    RecordedFormula::Written(0.into())
                }
            });
            return self.functions_of(formulas.collect());
        };
        let mut formulas = 0..lattice.formulas.observables();
        let column = |observable: &Observable| match observable {
            Observable::Coordinate { index, .. } => RecordedColumn::Coordinate(*index),
            _ => RecordedColumn::Formula(formulas.next().unwrap_or_default()),
        };
        let columns: Vec<RecordedColumn> = recorded.map(column).collect();
        let functions = lattice.formulas.clone();
        Ok(StateFunctions::each(columns.len(), move |parameters| {
            Ok(functions.at(parameters).beside(&columns))
        }))
    }

    /// The course of its walks, with these events beside the scene's own section, which comes first.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn course(&self, events: &[Event]) -> Result<Course, BuildError> {
        let plan = &self.plan;
        let code = |formulas: &[Expression]| -> Result<StateFunctions, BuildError> {
            let formulas: Vec<&Expression> = formulas.iter().collect();
            match self.method.lattice() {
                Some(_) => of_coordinates(&formulas, &self.system.parameter_values()),
                None => Ok(self.observables(&formulas)?.into()),
            }
        };
        let stop = plan.events.stop.clone().map(|stop| {
            let difference = code(&stop.formulas())?;
            Ok::<_, BuildError>((stop, difference))
        });
        let section = plan.events.section.iter().map(|section| Event {
            section: section.clone(),
            act: plan.events.act.clone(),
            last: None,
        });
        let events = section.chain(events.iter().cloned()).map(|event| {
            let functions = code(&event.formulas())?;
            Ok::<_, BuildError>((event, functions))
        });
        let pace = match (self.pace(), &self.extension) {
            (Some(pace), Some(extension)) => Some(Pace {
                text: pace.text.clone(),
                clock: extension.clock,
                watched: self
                    .observables(&[&pace.formula, extension.energy()])?
                    .into(),
                system: self.system.clone(),
                names: self.names(),
            }),
            _ => None,
        };
        Ok(Course {
            epsilon: plan.epsilon,
            h: plan.h,
            steps: plan.steps,
            until: plan.until,
            samples: plan.samples.clone(),
            pace,
            stop: stop.transpose()?,
            events: events.collect::<Result<_, _>>()?,
            invariants: self.invariant_functions()?,
            invariants_every: plan.drift_every,
            indicators: self.indicators(),
        })
    }

    /// The indicators that its walks follow, where any are recorded.
    fn indicators(&self) -> Option<Indicators> {
        let which = self.plan.indicators.clone();
        let count = Indicators::vectors_of(&which);
        if count == 0 {
            return None;
        }
        let begins = self.begins(&which);
        Some(Indicators {
            which,
            directions: match begins {
                Begins::InLeaf => self.leaf_directions(count),
                Begins::Anywhere => self.tensor_columns(),
            },
            begins,
            // e moves others by its part of K = (H + e) g alone.
            measured: self.plan.layout.moving().end,
            has_feedback: self.pace().is_some(),
        })
    }

    /// Where vectors begin: in the leaf, where two of its dimensions are there for each exponent. Of a bracket and H alone they
    /// are all known, and vectors begin anywhere for those beyond, but on a long lattice.
    fn begins(&self, which: &[Indicator]) -> Begins {
        let last = Indicators::exponents_of(which);
        let is_long = self.method.lattice().is_some();
        if self.system.has_forces() || self.is_extended() || is_long || last > self.dimension() {
            return Begins::InLeaf;
        }
        let values = self.leaf_directions(2 * last);
        let values = values.values(1, &self.system.parameter_values());
        let vectors = values.map(|mut values| values.at(&self.plan.initial).to_vec());
        let fit = |vectors| Indicators::are_independent(vectors, self.dimension());
        match vectors.is_ok_and(|vectors| !fit(vectors)) {
            true => Begins::Anywhere,
            false => Begins::InLeaf,
        }
    }

    /// The columns of the tensor at a state.
    fn tensor_columns(&self) -> StateFunctions {
        let (system, d) = (Arc::new(self.system.clone()), self.dimension());
        StateFunctions::each(d * d, move |parameters| {
            Ok(LeafDirections::columns(&system, parameters)?.into())
        })
    }

    /// So many vectors in the symplectic leaf of a state, one after the other.
    fn leaf_directions(&self, count: usize) -> StateFunctions {
        let numbers = match &self.method {
            Stepping::Lattice(lattice) => lattice.numbers.as_ref(),
            _ => None,
        };
        let system = Arc::new(numbers.unwrap_or(&self.system).clone());
        let d = self.dimension();
        StateFunctions::each(count * d, move |parameters| {
            Ok(LeafDirections::new(&system, parameters, count)?.into())
        })
    }

    /// Whether the motion is a flow on a symplectic leaf of two dimensions at most, forces or not: such a motion is not chaotic.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an entry of the tensor has no code.
    pub fn is_planar(&self) -> Result<bool, BuildError> {
        if self.method.lattice().is_some() || self.method.noise().is_some() {
            return Ok(false);
        }
        let beside = match &self.extension {
            None => 0,
            // A pace alone: the orbits of x are those of the time.
            Some(extension) if extension.pace.is_some() && !self.knows_time(extension) => 2,
            Some(_) => return Ok(false),
        };
        // Three vectors are never independent in two dimensions.
        let directions = self.leaf_directions(3 + beside);
        let mut directions = directions.values(1, &self.system.parameter_values())?;
        let vectors = directions.at(&self.plan.initial).to_vec();
        Ok(!Indicators::are_independent(vectors, self.dimension()))
    }

    /// Whether H, entries of the tensor, forces or the pace name the time, or the tensor has no entries and may name it.
    fn knows_time(&self, extension: &Extension) -> bool {
        self.system.expressions().is_none_or(|formulas| {
            let names_it = |part: &Expression| part.variables().contains(&extension.clock.time);
            formulas.tensor().is_empty() || formulas.parts().any(names_it)
        })
    }
}

/// Functions of a long lattice's state.
fn of_lattice(functions: &LatticeFunctions) -> StateFunctions {
    let functions = functions.clone();
    StateFunctions::each(functions.observables(), move |parameters| {
        Ok(functions.at(parameters).into())
    })
}
