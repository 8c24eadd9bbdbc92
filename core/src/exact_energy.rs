//! Steps that keep the energy of the first state, by multiples of Casimirs.
//!
//! H − Σ λ_c C_c has the motion of H for all λ; its steps differ. Each step takes λ with H(x_{k+1}(λ)) = H(x_0).
//!
//! Each is a Poisson map, so that the orbit keeps H and every Casimir to round-off. λ depends on the state: as a whole this
//! is no Poisson map. Cf. E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, section IV.4: a projection keeps the
//! same values, and not the leaf's geometry.

use std::sync::Arc;

use leafwise_expression::Expression;

use crate::error::{BuildError, StepError};
use crate::solver::{
    MapAbilities, MapProperties, Setting, SolverStatistics, StepMap, Stepper, Structure,
};
use crate::system::{Parameter, PoissonSystem, SystemFormulas, SystemInvariants};
use crate::two_sum;
use crate::walk::column;

/// Secants of one search, at most.
const MOST_SECANTS: usize = 12;

/// Secants that may not halve the error.
const MOST_SLOW: usize = 2;

/// Halvings and secants in a bracket, at most.
const MOST_IN_BRACKET: usize = 60;

/// Roundings of the energy that are taken for none: one of each coordinate, and one of H.
const ROUNDINGS: f64 = 1.0;

/// The same of the best step, where none is better.
const MOST_ROUNDINGS: f64 = 16.0;

/// The first change of the multiples, over their units: the energy's size over the Casimir's.
const FIRST_CHANGE: f64 = 1.0 / 1024.0;

/// The largest change of the multiples by a secant, over their units.
const LARGEST_SECANT: f64 = 0.125;

/// The largest change of the multiples that is looked at, over their units.
const LARGEST_CHANGE: f64 = 8.0;

/// The name of the key, in messages.
const NAME: &str = "energy = \"exact\"";

/// The system whose steps are taken: H less a multiple of each Casimir, whose multiples are parameters behind its own, all 0.
/// H itself is less the multiples of [`SystemFormulas::energy_casimir`], from where the search begins.
///
/// # Errors
/// [`BuildError::NotMade`] without a Casimir, or with forces.
pub fn with_multiples(system: &SystemFormulas) -> Result<SystemFormulas, BuildError> {
    let refuse = |reason: &str| {
        Err(BuildError::NotMade {
            part: NAME,
            reason: reason.to_owned(),
        })
    };
    if system.casimirs().is_empty() {
        return refuse(
            "the system declares no Casimirs, and there is nothing to take a multiple of; take a shorter step or a \
             higher order",
        );
    }
    if !system.forces().is_empty() {
        return refuse("forces change the energy; take them out, or leave `energy` out");
    }
    let own = system.parameters().len();
    let base = match system.energy_casimir()? {
        Some(shorter) => system.with_hamiltonian(shorter)?,
        None => system.clone(),
    };
    let casimirs = system.casimirs().iter();
    let terms = casimirs.enumerate().map(|(at, casimir)| {
        let multiple = Expression::Parameter(own + at);
        let product = Expression::Product(vec![multiple, casimir.expression.clone()]);
        Expression::Negate(Box::new(product))
    });
    let terms: Vec<Expression> = terms.collect();
    let further = (0..terms.len()).map(|at| Parameter {
        name: format!("multiple of Casimir {}", at + 1),
        // Of no special value: what parts are chosen by has to see every Casimir.
        value: 0.0625 * (at + 1) as f64,
    });
    base.with_parameters(further)
        .with_perturbation(Expression::Sum(terms))
}

/// A map of the system [with multiples](with_multiples), which finds them in each step.
pub struct ExactEnergy {
    map: Arc<dyn StepMap>,
    system: PoissonSystem,
    multiples: usize,
}

impl ExactEnergy {
    /// Steps of `map`, whose last parameters are the multiples of the Casimirs of `system`.
    ///
    /// # Errors
    /// [`BuildError::NotMade`] for a map that is no Poisson map.
    pub fn new(map: Arc<dyn StepMap>, system: PoissonSystem) -> Result<Self, BuildError> {
        if map.properties().structure != Structure::Exact {
            return Err(BuildError::NotMade {
                part: NAME,
                reason: format!(
                    "the steps of {} do not keep Casimirs to round-off; take an exact realization",
                    map.describe()
                ),
            });
        }
        let multiples = system.casimir_names().len();
        Ok(Self {
            map,
            system,
            multiples,
        })
    }
}

impl StepMap for ExactEnergy {
    fn dimension(&self) -> usize {
        self.map.dimension()
    }

    fn properties(&self) -> MapProperties {
        let MapProperties { order, .. } = self.map.properties();
        MapProperties {
            order,
            structure: Structure::Leaves,
            self_adjoint: Some(false),
        }
    }

    fn describe(&self) -> String {
        let which = match self.multiples {
            1 => "a multiple of the Casimir",
            _ => "multiples of the Casimirs",
        };
        format!("{} with exact energy by {which}", self.map.describe())
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            kernels: self.map.abilities().kernels,
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let lane = |lane: usize| {
            let mut own = column(parameters, lane, lanes);
            let invariants = SystemInvariants::new(&self.system, &own);
            own.resize(own.len() + self.multiples, 0.0);
            LaneOfEnergy {
                stepper: self.map.stepper(1, &own, epsilon, h),
                map: Arc::clone(&self.map),
                step_sizes: (epsilon, h),
                invariants: invariants.expect("it was evaluated when the map was made"),
                own: own.len() - self.multiples,
                parameters: own,
                target: f64::NAN,
                values: vec![0.0; 1 + self.multiples],
                state: vec![0.0; self.map.dimension()],
                spent: SolverStatistics::default(),
            }
        };
        Box::new(ExactEnergyStepper {
            lanes: (0..lanes).map(lane).collect(),
            statistics: SolverStatistics::default(),
        })
    }
}

/// One thread's steps, lane after lane.
struct ExactEnergyStepper {
    lanes: Vec<LaneOfEnergy>,
    statistics: SolverStatistics,
}

/// One trajectory's multiples.
struct LaneOfEnergy {
    stepper: Box<dyn Stepper>,
    map: Arc<dyn StepMap>,
    step_sizes: (f64, f64),
    /// Energy and Casimirs.
    invariants: SystemInvariants,
    /// The system's parameters, so many, and the multiples behind them.
    parameters: Vec<f64>,
    own: usize,
    /// H(x_0); not a number before the first step.
    target: f64,
    /// Room for the invariants and a state.
    values: Vec<f64>,
    state: Vec<f64>,
    /// Work of steppers that take no other parameters.
    spent: SolverStatistics,
}

/// Where a step begins.
#[derive(Clone, Copy)]
struct Begin<'a> {
    x: &'a [f64],
    low: &'a [f64],
    memory: &'a [f64],
}

/// A change of the multiples along a line, and the energy's error of the step there.
#[derive(Clone, Copy)]
struct ErrorAt {
    change: f64,
    error: f64,
}

/// Multiples along a line.
struct Line<'a, 'b> {
    of: &'a mut LaneOfEnergy,
    from: &'a [f64],
    direction: &'a [f64],
    /// The error that is taken for none.
    least: f64,
    begin: Begin<'b>,
    increment: &'a mut [f64],
}

impl Line<'_, '_> {
    fn multiples(&self, change: f64) -> Vec<f64> {
        let places = self.from.iter().zip(self.direction);
        places.map(|(from, along)| from + change * along).collect()
    }

    /// `None` where the step cannot be made.
    fn at(&mut self, change: f64) -> Option<ErrorAt> {
        let multiples = self.multiples(change);
        let error = self
            .of
            .attempt(&multiples, self.begin, self.increment)
            .ok()?;
        Some(ErrorAt { change, error })
    }

    /// The change with the smallest error that is found from no change, where it is `error`.
    fn search(&mut self, error: f64) -> ErrorAt {
        let start = ErrorAt { change: 0.0, error };
        let near = self.by_secants(start);
        if near.error.abs() <= MOST_ROUNDINGS * self.least {
            return near;
        }
        let far = self.by_looking_around(start);
        match far.error.abs() < near.error.abs() {
            true => far,
            false => near,
        }
    }

    /// Secants from a small change on, while they are short and halve the error.
    fn by_secants(&mut self, start: ErrorAt) -> ErrorAt {
        let (mut before, mut best, mut slow) = (start, start, 0);
        let Some(mut last) = self.at(FIRST_CHANGE) else {
            return best;
        };
        for _ in 0..MOST_SECANTS {
            if last.error.abs() < best.error.abs() {
                best = last;
            }
            let change = zero_between(before, last);
            let is_short = change.abs() <= LARGEST_SECANT;
            if best.error.abs() <= self.least || slow > MOST_SLOW || !is_short {
                break;
            }
            let Some(next) = self.at(change) else { break };
            slow += usize::from(next.error.abs() > 0.5 * last.error.abs());
            (before, last) = (last, next);
        }
        best
    }

    /// Changes that double on both sides, until the error has another sign; then what is between.
    fn by_looking_around(&mut self, start: ErrorAt) -> ErrorAt {
        let mut sides = [Some(start); 2];
        let mut change = FIRST_CHANGE;
        while change <= LARGEST_CHANGE {
            for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
                let Some(last) = *side else { continue };
                let next = self.at(sign * change);
                if let Some(next) = next
                    && (next.error > 0.0) != (last.error > 0.0)
                {
                    return self.between(last, next);
                }
                *side = next;
            }
            change *= 2.0;
        }
        start
    }

    /// The zero between two changes with errors of two signs: secants whose resting end counts half, and halvings.
    fn between(&mut self, mut a: ErrorAt, mut b: ErrorAt) -> ErrorAt {
        let mut best = match a.error.abs() < b.error.abs() {
            true => a,
            false => b,
        };
        for round in 0..MOST_IN_BRACKET {
            let change = match round % 3 {
                2 => 0.5 * (a.change + b.change),
                _ => zero_between(a, b),
            };
            if best.error.abs() <= self.least || change == a.change || change == b.change {
                break;
            }
            let Some(next) = self.at(change) else { break };
            if next.error.abs() < best.error.abs() {
                best = next;
            }
            if (next.error > 0.0) == (b.error > 0.0) {
                a.error *= 0.5;
            } else {
                a = b;
            }
            b = next;
        }
        best
    }
}

/// Where the line through two errors is 0.
fn zero_between(a: ErrorAt, b: ErrorAt) -> f64 {
    b.change - b.error * (b.change - a.change) / (b.error - a.error)
}

impl LaneOfEnergy {
    fn work(&self) -> SolverStatistics {
        self.spent.and(self.stepper.statistics())
    }

    fn multiples(&self) -> &[f64] {
        &self.parameters[self.own..]
    }

    /// The energy's error of the step with these multiples, which is left in `increment`.
    fn attempt(
        &mut self,
        multiples: &[f64],
        Begin { x, low, memory }: Begin<'_>,
        increment: &mut [f64],
    ) -> Result<f64, StepError> {
        self.parameters[self.own..].copy_from_slice(multiples);
        if !self.stepper.set(Setting::Parameters(&self.parameters)) {
            self.spent = self.work();
            let (epsilon, h) = self.step_sizes;
            self.stepper = self.map.stepper(1, &self.parameters, epsilon, h);
        }
        // Steps that are tried leave nothing behind.
        let restored = self.stepper.restore(memory);
        debug_assert!(restored.is_ok(), "it is of the same map");
        let mut outcome = [Ok(())];
        self.stepper.increment(x, low, increment, &mut outcome);
        let [outcome] = outcome;
        outcome?;
        let places = x.iter().zip(low).zip(&*increment);
        for (state, ((x, low), change)) in self.state.iter_mut().zip(places) {
            *state = two_sum(*x, change + low).0;
        }
        self.invariants.evaluate(&self.state, &mut self.values);
        let error = self.values[0] - self.target;
        match error.is_finite() {
            true => Ok(error),
            false => Err(StepError::NonFinite { what: "the energy" }),
        }
    }

    /// |I| + Σ |x_i ∂_i I| of each invariant, by differences: u times it is what rounding the state changes.
    fn sizes(&mut self, x: &[f64]) -> Vec<f64> {
        /// A step of 2⁻²⁰ of a coordinate.
        const PART: f64 = 1.0 / (1 << 20) as f64;
        self.invariants.evaluate(x, &mut self.values);
        let here = self.values.clone();
        let mut sizes: Vec<f64> = here.iter().map(|value| value.abs()).collect();
        self.state.copy_from_slice(x);
        for i in 0..x.len() {
            self.state[i] = x[i] + PART * x[i];
            self.invariants.evaluate(&self.state, &mut self.values);
            for ((size, there), here) in sizes.iter_mut().zip(&self.values).zip(&here) {
                *size += (there - here).abs() / PART;
            }
            self.state[i] = x[i];
        }
        sizes
    }

    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        let sizes = self.sizes(x);
        if self.target.is_nan() {
            self.invariants.evaluate(x, &mut self.values);
            self.target = self.values[0];
        }
        let units: Vec<f64> = (sizes[1..].iter())
            .map(|casimir| {
                if *casimir > 0.0 {
                    sizes[0] / casimir
                } else {
                    0.0
                }
            })
            .collect();
        let least = ROUNDINGS * 0.5 * f64::EPSILON * sizes[0];
        let before = self.multiples().to_vec();
        let memory = self.stepper.memory();
        let begin = Begin {
            x,
            low,
            memory: &memory,
        };
        let found = self.search((&units, least), begin, increment);
        if found.is_err() {
            self.parameters[self.own..].copy_from_slice(&before);
            let restored = self.stepper.restore(&memory);
            debug_assert!(restored.is_ok(), "it is of the same map");
        }
        found
    }

    /// Multiples at which the energy's error is 0, the nearest to the last one of one Casimir. Of several Casimirs they are those
    /// of least norm along the energy's slopes, else a multiple of one alone.
    fn search(
        &mut self,
        (units, least): (&[f64], f64),
        begin: Begin<'_>,
        increment: &mut [f64],
    ) -> Result<(), StepError> {
        let from = match units.len() {
            1 => self.multiples().to_vec(),
            several => vec![0.0; several],
        };
        let error = self.attempt(&from, begin, increment)?;
        if error.abs() <= least {
            return Ok(());
        }
        let mut best = ErrorAt { change: 0.0, error };
        for direction in self.directions((units, &from, error), begin, increment) {
            let mut line = Line {
                of: self,
                from: &from,
                direction: &direction,
                least,
                begin,
                increment,
            };
            let found = line.search(error);
            if found.error.abs() <= MOST_ROUNDINGS * least {
                let multiples = line.multiples(found.change);
                return self.attempt(&multiples, begin, increment).map(|_| ());
            }
            if found.error.abs() < best.error.abs() {
                best = found;
            }
        }
        if best.error.abs() <= MOST_ROUNDINGS * least {
            return self.attempt(&from, begin, increment).map(|_| ());
        }
        Err(StepError::Part {
            part: NAME.to_owned(),
            message: format!(
                "no multiple of the Casimirs keeps the energy in this step, which errs by {:.1e}; take a shorter step, declare a \
                 further Casimir, or leave `energy` out",
                best.error
            ),
        })
    }

    /// Changes of the multiples to look along, each one unit long: first the slopes of the energy.
    fn directions(
        &mut self,
        (units, from, error): (&[f64], &[f64], f64),
        begin: Begin<'_>,
        increment: &mut [f64],
    ) -> Vec<Vec<f64>> {
        let count = units.len();
        let axis = |c: usize| {
            let mut axis = vec![0.0; count];
            axis[c] = units[c];
            axis
        };
        let axes = (0..count).filter(|c| units[*c] > 0.0).map(axis);
        let axes: Vec<Vec<f64>> = axes.collect();
        if axes.len() < 2 {
            return axes;
        }
        let mut slopes = vec![0.0; count];
        for axis in &axes {
            let there: Vec<f64> = (from.iter().zip(axis))
                .map(|(multiple, unit)| multiple + FIRST_CHANGE * unit)
                .collect();
            if let Ok(changed) = self.attempt(&there, begin, increment) {
                (slopes.iter_mut().zip(axis))
                    .filter(|(_, unit)| **unit > 0.0)
                    .for_each(|(own, unit)| *own = (changed - error) / unit);
            }
        }
        // One unit long, of all Casimirs together.
        let length: f64 = (slopes.iter().zip(units))
            .filter(|(_, unit)| **unit > 0.0)
            .map(|(slope, unit)| slope.abs() / unit)
            .sum();
        let along: Vec<f64> = slopes.iter().map(|slope| slope / length).collect();
        let is_one = along.iter().all(|part| part.is_finite());
        is_one.then_some(along).into_iter().chain(axes).collect()
    }

    fn restart(&mut self) {
        self.stepper.restart();
        self.parameters[self.own..].fill(0.0);
        self.target = f64::NAN;
    }

    fn memory(&self) -> Vec<f64> {
        let own = std::iter::once(&self.target);
        let own = own.chain(self.multiples());
        let mut memory: Vec<f64> = own.copied().collect();
        memory.extend(self.stepper.memory());
        memory
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let count = self.parameters.len() - self.own;
        let (own, inner) = memory.split_at(1 + count);
        self.target = own[0];
        self.parameters[self.own..].copy_from_slice(&own[1..]);
        if !self.stepper.set(Setting::Parameters(&self.parameters)) {
            let (epsilon, h) = self.step_sizes;
            self.stepper = self.map.stepper(1, &self.parameters, epsilon, h);
        }
        self.stepper.restore(inner)
    }
}

impl Stepper for ExactEnergyStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = self.lanes.len();
        let d = x.len() / lanes;
        let mut change = vec![0.0; d];
        for (at, lane) in self.lanes.iter_mut().enumerate() {
            let own = [x, low].map(|all| column(all, at, lanes));
            let before = lane.work().evaluations;
            outcome[at] = lane.step(&own[0], &own[1], &mut change);
            if outcome[at].is_err() {
                change.fill(0.0);
            }
            let evaluations = lane.work().evaluations - before;
            self.statistics.count(evaluations, outcome[at].is_ok());
            let places = increment.iter_mut().skip(at).step_by(lanes);
            places.zip(&change).for_each(|(place, own)| *place = *own);
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        self.lanes[lane].stepper.solution(0)
    }

    fn restart(&mut self) {
        self.lanes.iter_mut().for_each(LaneOfEnergy::restart);
    }

    fn statistics(&self) -> SolverStatistics {
        let work = self.lanes.iter().map(LaneOfEnergy::work);
        let work = work.fold(SolverStatistics::default(), SolverStatistics::and);
        SolverStatistics {
            operations: work.operations,
            rounded: work.rounded,
            held: work.held,
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        self.lanes.iter().flat_map(LaneOfEnergy::memory).collect()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let lengths: Vec<usize> = self.lanes.iter().map(|lane| lane.memory().len()).collect();
        let expected = lengths.iter().sum();
        if memory.len() != expected {
            return Err(expected);
        }
        let mut rest = memory;
        for (lane, length) in self.lanes.iter_mut().zip(lengths) {
            let (own, others) = rest.split_at(length);
            lane.restore(own)?;
            rest = others;
        }
        Ok(())
    }
}
