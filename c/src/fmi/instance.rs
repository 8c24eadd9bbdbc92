//! A unit of a scene: its variables, and its trajectory.

use std::collections::BTreeMap;
use std::path::Path;

use leafwise_cli::fmu::{Role, SCENE, Variable, token, variables};

use crate::call_error::CallError;
use crate::integrator::Integrator;
use crate::scene::Scene;

/// The part of a step by which times of a caller, sums of many, may be off.
const OFF: f64 = 1e-6;

/// The most steps of one communication step.
const MOST: f64 = 9e15;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Instantiated,
    Initialization,
    Step,
    Terminated,
}

/// A unit.
pub(super) struct UnitInstance {
    scene: Scene,
    variables: Vec<Variable>,
    /// Values that were set, by their variables' numbers.
    set: BTreeMap<usize, f64>,
    mode: Mode,
    start: f64,
    /// `None` before values are asked for, and after others were set.
    integrator: Option<Integrator>,
}

impl UnitInstance {
    /// The unit of the scene in a folder, which has this token.
    pub fn new(resources: &Path, given: &str) -> Result<Self, CallError> {
        let file = resources.join(SCENE);
        let scene = Scene::read(&file)?;
        let own = token(scene.text());
        if own != given {
            return Err(CallError::usage(format!(
                "the token {given} differs from the token of {}, {own}: export the unit again",
                file.display()
            )));
        }
        let equal = scene.run.has_equal_steps();
        equal.map_err(|uneven| CallError::usage(uneven.to_string()))?;
        Ok(Self {
            variables: variables(&scene.run),
            scene,
            set: BTreeMap::new(),
            mode: Mode::Instantiated,
            start: 0.0,
            integrator: None,
        })
    }

    fn must_be(&self, modes: &[Mode], what: &str) -> Result<(), CallError> {
        match modes.contains(&self.mode) {
            true => Ok(()),
            false => Err(CallError::usage(format!(
                "{what} is not allowed in the mode {:?}",
                self.mode
            ))),
        }
    }

    pub fn enter_initialization(&mut self, start: f64) -> Result<(), CallError> {
        self.must_be(&[Mode::Instantiated], "fmi3EnterInitializationMode")?;
        if !start.is_finite() {
            return Err(CallError::usage(format!("startTime is {start}")));
        }
        (self.start, self.mode) = (start, Mode::Initialization);
        Ok(())
    }

    pub fn exit_initialization(&mut self) -> Result<(), CallError> {
        self.must_be(&[Mode::Initialization], "fmi3ExitInitializationMode")?;
        self.integrator()?;
        self.mode = Mode::Step;
        Ok(())
    }

    pub fn terminate(&mut self) {
        self.mode = Mode::Terminated;
    }

    pub fn reset(&mut self) -> Result<(), CallError> {
        self.set.clear();
        (self.start, self.mode) = (0.0, Mode::Instantiated);
        self.integrator = None;
        Ok(())
    }

    /// The time of the trajectory.
    pub fn time(&self) -> f64 {
        let own = self.integrator.as_ref();
        self.start + own.map_or(0.0, Integrator::time)
    }

    /// The trajectory, begun with what was set.
    fn integrator(&mut self) -> Result<&mut Integrator, CallError> {
        if self.integrator.is_none() {
            self.integrator = Some(self.begun()?);
        }
        let own = self.integrator.as_mut();
        own.ok_or_else(|| CallError::usage("there is no trajectory"))
    }

    fn begun(&self) -> Result<Integrator, CallError> {
        let mut initial = self.scene.run.own(&self.scene.run.plan.initial).to_vec();
        let mut changed: Option<Scene> = None;
        for (number, value) in &self.set {
            let variable = &self.variables[*number];
            match variable.role {
                Role::Coordinate(at) => initial[at] = *value,
                Role::Parameter(at) => {
                    let from = changed.as_ref().unwrap_or(&self.scene);
                    let name = &from.run.system.parameters()[at].name;
                    let key = format!("system.parameters.{name}");
                    changed = Some(from.with(&key, &format!("{value:?}"))?);
                }
                Role::Time | Role::Invariant(_) => {}
            }
        }
        let from = changed.as_ref().unwrap_or(&self.scene);
        let is_moved = initial != from.run.own(&from.run.plan.initial);
        match is_moved {
            true => Integrator::new(&from.from(&initial)?),
            false => Integrator::new(from),
        }
    }

    fn variable(&self, reference: u32) -> Result<(usize, Role), CallError> {
        let number = reference as usize;
        match self.variables.get(number) {
            Some(variable) => Ok((number, variable.role)),
            None => Err(CallError::usage(format!(
                "there is no variable {reference}: the unit has {}",
                self.variables.len()
            ))),
        }
    }

    /// Values of variables.
    pub fn values(&mut self, references: &[u32]) -> Result<Vec<f64>, CallError> {
        let asked = references.iter().map(|reference| self.variable(*reference));
        let asked: Vec<(usize, Role)> = asked.collect::<Result<_, _>>()?;
        let mut values = Vec::with_capacity(asked.len());
        for (number, role) in asked {
            let own = self.integrator()?;
            values.push(match role {
                Role::Coordinate(at) => own.state()[at],
                Role::Invariant(at) => own.invariants()[at],
                Role::Time => self.time(),
                Role::Parameter(_) => {
                    let set = self.set.get(&number).copied();
                    set.or(self.variables[number].start).unwrap_or(f64::NAN)
                }
            });
        }
        Ok(values)
    }

    /// Sets parameters and initial values: all of them, or none.
    pub fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        self.must_be(
            &[Mode::Instantiated, Mode::Initialization],
            "fmi3SetFloat64",
        )?;
        let asked = references.iter().map(|reference| self.variable(*reference));
        let asked: Vec<(usize, Role)> = asked.collect::<Result<_, _>>()?;
        for ((number, role), value) in asked.iter().zip(values) {
            let name = &self.variables[*number].name;
            if matches!(role, Role::Time | Role::Invariant(_)) {
                return Err(CallError::usage(format!("{name} cannot be set")));
            }
            if !value.is_finite() {
                let message = format!("{value} for {name} is not a finite number");
                return Err(CallError::usage(message));
            }
        }
        let before = self.set.clone();
        let numbers = asked.iter().map(|(number, _)| *number);
        self.set.extend(numbers.zip(values.iter().copied()));
        match self.begun() {
            Ok(begun) => {
                self.integrator = Some(begun);
                Ok(())
            }
            Err(refusal) => {
                self.set = before;
                Err(refusal)
            }
        }
    }

    /// Makes the steps from a time over another.
    pub fn advance(&mut self, time: f64, step: f64) -> Result<(), CallError> {
        self.must_be(&[Mode::Step], "fmi3DoStep")?;
        let h = self.scene.shape().time_step;
        let now = self.time();
        if (time - now).abs() > OFF * h.abs() || time.is_nan() {
            return Err(CallError::usage(format!(
                "currentCommunicationPoint is {time}, and the unit is at {now}"
            )));
        }
        let count = (step / h).round();
        let is_whole = (step - count * h).abs() <= OFF * h.abs() && (1.0..=MOST).contains(&count);
        if !is_whole {
            return Err(CallError::usage(format!(
                "communicationStepSize is {step}, which is not a multiple of the scene's time-step, {h}"
            )));
        }
        self.integrator()?.advance(count as u64)
    }
}
