//! H less Casimirs, for lifts that move slowly along their fibres.

use std::cell::{OnceCell, RefCell};

use leafwise_expression::{Arithmetic, Expression, Graph, Kernel, Polynomial, Ring, Term};

use super::Lift;
use crate::error::BuildError;
use crate::system::SystemFormulas;

/// Products of terms that the normal form of H may take.
const MOST_PRODUCTS: u64 = 1 << 20;

/// A normal form of H of no more terms a coordinate is taken in its place, where something is taken off.
const SHORT: usize = 10;

/// States of the short walk.
const STATES: usize = 64;

/// Steps of the short walk: this part of the time in which the state changes by itself.
const STEP: f64 = 0.25;

/// A state of the motion with ∇H there.
#[derive(Clone, Debug)]
pub struct Met {
    /// x.
    pub x: Vec<f64>,
    /// ∇H(x).
    pub slopes: Vec<f64>,
}

/// Basis on which a lift chooses Casimirs: the system, normal forms, and states of the motion with ∇H there.
#[derive(Debug)]
pub struct Slowing<'a> {
    /// The system.
    pub system: &'a SystemFormulas,
    /// The ring of normal forms.
    pub ring: Ring,
    /// The normal form of H, where it has one.
    pub hamiltonian: Option<Polynomial>,
    met: OnceCell<Vec<Met>>,
    /// ∇H as code of the graph's inputs, where it has code.
    slopes: OnceCell<Option<(RefCell<Graph>, Vec<Term>)>>,
}

impl<'a> Slowing<'a> {
    fn new(system: &'a SystemFormulas) -> Self {
        let mut ring = Ring::limited(system.dimension(), MOST_PRODUCTS);
        let variable = &mut |ring: &mut Ring, at| Ok(ring.variable(at));
        let normal = system.hamiltonian().evaluate_in(&mut ring, variable);
        let hamiltonian = normal.ok().filter(|_| ring.refusal().is_none());
        ring.allow(MOST_PRODUCTS);
        Self {
            system,
            ring,
            hamiltonian,
            met: OnceCell::new(),
            slopes: OnceCell::new(),
        }
    }

    /// Some states that the motion from the system's state comes by, with rounding and truncation: none where it has no code.
    pub fn met(&self) -> &[Met] {
        self.met
            .get_or_init(|| walk(self.system).unwrap_or_default())
    }
}

impl Slowing<'_> {
    /// The Hessians of H by these coordinates at the states [met](Self::met), row-major; none where H has no second derivatives.
    pub fn curvatures(&self, places: &[usize]) -> Vec<Vec<f64>> {
        let slopes = || {
            let (mut graph, energy) = energy(self.system).ok()?;
            let slopes = graph.gradient(&energy, self.system.dimension()).ok()?;
            Some((RefCell::new(graph), slopes))
        };
        let Some((graph, slopes)) = self.slopes.get_or_init(slopes) else {
            return Vec::new();
        };
        let hessian = || -> Result<Vec<Vec<f64>>, BuildError> {
            let d = self.system.dimension();
            let mut graph = graph.borrow_mut();
            let mut outputs = Vec::with_capacity(places.len() * places.len());
            for i in places {
                let row = graph.gradient(&slopes[*i], d)?;
                outputs.extend(places.iter().map(|j| row[*j].clone()));
            }
            let parameters = self.system.parameter_values();
            let kernel = Kernel::compile(&graph, &outputs, parameters.len(), d);
            let mut workspace = kernel.workspace(1);
            kernel.prepare(&mut workspace, &parameters, &[1.0], &[1.0]);
            let values = self.met().iter().map(|met| {
                let mut values = vec![0.0; outputs.len()];
                kernel.evaluate(&mut workspace, &met.x, &mut values);
                values
            });
            Ok(values.collect())
        };
        hessian().unwrap_or_default()
    }
}

/// H as code of the graph's inputs.
fn energy(system: &SystemFormulas) -> Result<(Graph, Term), BuildError> {
    let mut graph = Graph::new();
    let inputs: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
    let energy = system
        .hamiltonian()
        .evaluate_in(&mut graph, &mut |_, at| Ok(inputs[at].clone()))?;
    Ok((graph, energy))
}

/// H less what a lift takes off; `None` where that is nothing.
pub(super) fn slower(
    lift: &dyn Lift,
    system: &SystemFormulas,
) -> Result<Option<SystemFormulas>, BuildError> {
    let d = system.dimension();
    let places: Vec<usize> = (0..d).collect();
    let mut slowing = Slowing::new(system);
    let taken = lift.slowing(&mut slowing, &places)?;
    let Slowing {
        mut ring,
        hamiltonian,
        ..
    } = slowing;
    if taken.is_zero() || ring.refusal().is_some() {
        return Ok(None);
    }
    let slower = match hamiltonian {
        Some(normal) if normal.terms().len() <= SHORT * d => {
            let rest = ring.subtract(&normal, &taken);
            ring.formula(&rest)
        }
        _ => {
            let taken = Expression::Negate(Box::new(ring.formula(&taken)));
            Expression::Sum(vec![system.hamiltonian().clone(), taken])
        }
    };
    system.with_hamiltonian(slower).map(Some)
}

/// States along ẋ = X_H(x) from the system's own, by the classical method of order 4, as far as numbers are finite.
fn walk(system: &SystemFormulas) -> Result<Vec<Met>, BuildError> {
    let d = system.dimension();
    let (mut graph, energy) = energy(system)?;
    let inputs: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let slopes = graph.gradient(&energy, d)?;
    let rows = system.apply_tensor(&mut graph, &inputs, &slopes)?;
    let outputs = [rows, slopes].concat();
    let parameters = system.parameter_values();
    let kernel = Kernel::compile(&graph, &outputs, parameters.len(), d);
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &parameters, &[1.0], &[1.0]);
    let mut values = vec![0.0; 2 * d];
    let mut at = |x: &[f64]| {
        kernel.evaluate(&mut workspace, x, &mut values);
        let (rows, slopes) = values.split_at(d);
        let field: Vec<f64> = rows.iter().map(|row| -row).collect();
        (field, slopes.to_vec())
    };
    let largest = |v: &[f64]| v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let moved = |x: &[f64], by: f64, field: &[f64]| -> Vec<f64> {
        x.iter().zip(field).map(|(x, f)| x + by * f).collect()
    };
    let mut x = system.near().to_vec();
    let mut met = Vec::with_capacity(STATES);
    let mut step = 0.0;
    for _ in 0..STATES {
        let (first, slopes) = at(&x);
        if !first.iter().chain(&slopes).all(|v| v.is_finite()) {
            break;
        }
        if met.is_empty() {
            let speed = largest(&first);
            step = if speed > 0.0 {
                STEP * largest(&x) / speed
            } else {
                0.0
            };
        }
        met.push(Met {
            x: x.clone(),
            slopes,
        });
        if step == 0.0 {
            break;
        }
        let (second, _) = at(&moved(&x, 0.5 * step, &first));
        let (third, _) = at(&moved(&x, 0.5 * step, &second));
        let (fourth, _) = at(&moved(&x, step, &third));
        for i in 0..d {
            x[i] += step / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]);
        }
    }
    Ok(met)
}
