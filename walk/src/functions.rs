//! Functions of a state, at the parameters of one lane or of several.

use std::sync::Arc;

use leafwise_core::system::SystemObservables;
use leafwise_core::walk::column;
use leafwise_core::{BuildError, Observer};

/// Makes an observer of one state at values of parameters.
type Make = dyn Fn(&[f64]) -> Result<Observer, BuildError> + Send + Sync;

/// Functions f₁(x), …, f_n(x) of a state and of parameters, compiled once for all that evaluate them.
#[derive(Clone)]
pub struct StateFunctions(Source);

#[derive(Clone)]
enum Source {
    Code(Box<SystemObservables>),
    Each { count: usize, make: Arc<Make> },
}

impl StateFunctions {
    /// Functions without code: an observer for each lane.
    pub fn each(
        count: usize,
        make: impl Fn(&[f64]) -> Result<Observer, BuildError> + Send + Sync + 'static,
    ) -> Self {
        let make = Arc::new(make);
        Self(Source::Each { count, make })
    }

    /// n, the number of functions.
    pub fn count(&self) -> usize {
        match &self.0 {
            Source::Code(code) => code.observables(),
            Source::Each { count, .. } => *count,
        }
    }

    /// Whether they are code, which many lanes share.
    pub fn is_code(&self) -> bool {
        matches!(self.0, Source::Code(_))
    }

    /// Evaluates in `lanes` at their `parameters`, a structure of arrays.
    ///
    /// # Errors
    /// [`BuildError`] where there is no observer for a lane.
    pub fn values(&self, lanes: usize, parameters: &[f64]) -> Result<FunctionValues, BuildError> {
        let evaluator = match &self.0 {
            Source::Code(code) => Evaluator::Code(code.side_by_side(lanes, parameters)),
            Source::Each { make, .. } => {
                let own = |lane: usize| column(parameters, lane, lanes);
                let observers = (0..lanes).map(|lane| make(&own(lane)));
                Evaluator::Each {
                    make: Arc::clone(make),
                    observers: observers.collect::<Result<_, _>>()?,
                    state: Vec::new(),
                    own: vec![0.0; self.count()],
                }
            }
        };
        Ok(FunctionValues {
            evaluator,
            values: vec![0.0; self.count() * lanes],
            origins: Vec::new(),
        })
    }
}

impl From<SystemObservables> for StateFunctions {
    fn from(code: SystemObservables) -> Self {
        Self(Source::Code(Box::new(code)))
    }
}

/// Values of [`StateFunctions`] in all lanes: function i of lane w at `[i*lanes + w]`.
pub struct FunctionValues {
    evaluator: Evaluator,
    values: Vec<f64>,
    origins: Vec<f64>,
}

enum Evaluator {
    Code(SystemObservables),
    Each {
        make: Arc<Make>,
        observers: Vec<Observer>,
        state: Vec<f64>,
        own: Vec<f64>,
    },
}

impl FunctionValues {
    /// Takes a number of each lane from its first function: e_0 from H + e, so that it is the balance H − ∫ ∂H/∂t dt.
    pub fn measure_from(&mut self, origins: &[f64]) {
        self.origins.clear();
        self.origins.extend_from_slice(origins);
    }

    /// Takes other parameters, as many lanes of them. Code allocates nothing for them, observers are made anew.
    ///
    /// # Errors
    /// [`BuildError`] where there is no observer for a lane.
    pub fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), BuildError> {
        match &mut self.evaluator {
            Evaluator::Code(code) => code.set_parameters(parameters),
            Evaluator::Each {
                make, observers, ..
            } => {
                let lanes = observers.len();
                for (lane, observer) in observers.iter_mut().enumerate() {
                    *observer = make(&column(parameters, lane, lanes))?;
                }
            }
        }
        Ok(())
    }

    /// The values at states, a structure of arrays.
    pub fn at(&mut self, states: &[f64]) -> &[f64] {
        if self.values.is_empty() {
            return &self.values;
        }
        match &mut self.evaluator {
            Evaluator::Code(code) => code.evaluate(states, &mut self.values),
            Evaluator::Each { observers, .. } if observers.len() == 1 => {
                observers[0].evaluate(states, &mut self.values);
            }
            Evaluator::Each {
                observers,
                state,
                own,
                ..
            } => {
                let lanes = observers.len();
                for (lane, observer) in observers.iter_mut().enumerate() {
                    state.clear();
                    state.extend(states.iter().skip(lane).step_by(lanes));
                    observer.evaluate(state, own);
                    let places = self.values.iter_mut().skip(lane).step_by(lanes);
                    places.zip(&*own).for_each(|(place, value)| *place = *value);
                }
            }
        }
        let first = self.values.iter_mut().zip(&self.origins);
        first.for_each(|(value, origin)| *value -= origin);
        &self.values
    }

    /// The values where they were evaluated last.
    pub fn last(&self) -> &[f64] {
        &self.values
    }
}

impl From<FunctionValues> for Observer {
    fn from(mut functions: FunctionValues) -> Self {
        Self::new(functions.values.len(), move |state, values| {
            values.copy_from_slice(functions.at(state));
        })
    }
}
