//! Products with the Jacobian of a field, in loops as the field itself.
//!
//! With K(x, c) = Σ_a c_a ∂H/∂x_a, ∇²H c is ∇_x K. K is a function of sums over sites and pairs of twice as many families:
//! Σ_k F_k(S) T_k, T_k the derivative of S_k along c. So a product with the Hessian costs a few evaluations of ∇H.

use std::sync::Arc;

use leafwise_expression::operators::Quantity;
use leafwise_expression::{Expression, Workspace};

use super::BodyShape;
use super::bracket::{BodyMotion, applied};
use super::function::{BodyFunction, BodySum};
use super::site_code::SiteCode;
use super::values::{Slopes, SlopesCode};
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;

impl BodyFunction {
    /// f(x) and c as families behind those of x: Σ_a c_a ∂f/∂x_a.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no derivative.
    fn along(&self, shape: &BodyShape) -> Result<Self, BuildError> {
        let (families, count) = (shape.families, self.sums.len());
        // Behind the coordinates of a site stand those of c.
        let places = shape.places_beside(families);
        let along = |formula: &Expression| -> Result<Expression, BuildError> {
            let moving = formula.variables().into_iter();
            let terms = moving.filter(|v| *v < 2 * families).map(|variable| {
                let slope = formula.derivative(Quantity::Variable(variable))?;
                let velocity = Expression::Variable(places[variable] + families);
                Ok(Expression::Product(vec![
                    slope.with_variables(&places),
                    velocity,
                ]))
            });
            let terms = terms.collect::<Result<_, BuildError>>()?;
            Ok(Expression::Sum(terms))
        };
        let mut sums = self.with_families(shape, families).sums;
        for sum in &self.sums {
            sums.push(BodySum {
                site: along(&sum.site)?,
                pair: along(&sum.pair)?,
            });
        }
        let terms = (0..count).map(|k| {
            let slope = self.outer.derivative(Quantity::Variable(k))?;
            Ok(Expression::Product(vec![
                slope,
                Expression::Variable(count + k),
            ]))
        });
        let terms = terms.collect::<Result<_, BuildError>>()?;
        Ok(Self {
            outer: Expression::Sum(terms),
            sums,
        })
    }
}

/// The code of products with the Jacobian of a field.
pub(super) struct TangentCode {
    shape: BodyShape,
    hessian: Arc<SlopesCode>,
    gradient: Arc<SlopesCode>,
    /// Πv.
    tensor: SiteCode,
    tensor_families: Vec<usize>,
    /// Where the tensor depends on coordinates, at rest or not: (D_vΠ)g, and Σ_ij w_i ∂Π_ij g_j, of rows of x, v or w, and g.
    of_tensor: Option<[(SiteCode, Vec<usize>); 2]>,
}

impl TangentCode {
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or derivative has no code.
    pub(super) fn new(
        system: &BodyMotion<'_>,
        gradient: &Arc<SlopesCode>,
    ) -> Result<Self, BuildError> {
        let (shape, parameters) = (system.shape, system.parameters);
        let families = shape.families;
        let doubled = BodyShape {
            families: 2 * families,
            ..shape.clone()
        };
        let own: Vec<usize> = (0..families).collect();
        let along = system.hamiltonian.along(shape)?;
        let hessian = SlopesCode::new(&along, &doubled, &own, parameters, |_, _, gradient| {
            Ok(gradient[..families].iter().cloned().enumerate().collect())
        })?;
        let mut tensor_families = Vec::new();
        let tensor = SiteCode::new(2 * families, parameters, |graph, rows| {
            let (x, v) = rows.split_at(families);
            let results = applied(system.bracket, graph, x, v, false)?;
            let (families, terms) = results.into_iter().unzip();
            tensor_families = families;
            Ok(terms)
        })?;
        let is_constant = |(_, entry): &(_, Expression)| entry.variables().is_empty();
        let of_tensor = match system.bracket.iter().all(is_constant) {
            true => None,
            false => Some([Self::pushed(system)?, Self::pulled(system)?]),
        };
        Ok(Self {
            shape: shape.clone(),
            hessian: Arc::new(hessian),
            gradient: Arc::clone(gradient),
            tensor,
            tensor_families,
            of_tensor,
        })
    }

    /// (D_vΠ)g.
    fn pushed(system: &BodyMotion<'_>) -> Result<(SiteCode, Vec<usize>), BuildError> {
        let families = system.shape.families;
        let mut of_results = Vec::new();
        let code = SiteCode::new(3 * families, system.parameters, |graph, rows| {
            let (x, rest) = rows.split_at(families);
            let (v, g) = rest.split_at(families);
            let mut changed = Vec::new();
            for (at, entry) in system.bracket {
                let mut parts = Vec::new();
                for family in entry.variables() {
                    let slope = entry.derivative(Quantity::Variable(family))?;
                    parts.push(Expression::Product(vec![
                        slope,
                        Expression::Variable(families + family),
                    ]));
                }
                changed.push((*at, Expression::Sum(parts)));
            }
            let variables = [x, v].concat();
            let results = applied(&changed, graph, &variables, g, false)?;
            let (families, terms) = results.into_iter().unzip();
            of_results = families;
            Ok(terms)
        })?;
        Ok((code, of_results))
    }

    /// Σ_ij w_i ∂Π_ij g_j by every family.
    fn pulled(system: &BodyMotion<'_>) -> Result<(SiteCode, Vec<usize>), BuildError> {
        let families = system.shape.families;
        let mut of_results = Vec::new();
        let code = SiteCode::new(3 * families, system.parameters, |graph, rows| {
            let mut terms = Vec::new();
            for family in 0..families {
                let mut parts = Vec::new();
                for ((a, b), entry) in system.bracket {
                    if !entry.variables().contains(&family) {
                        continue;
                    }
                    let slope = entry.derivative(Quantity::Variable(family))?;
                    let product = |w: usize, g: usize| {
                        let [w, g] = [families + w, 2 * families + g].map(Expression::Variable);
                        Expression::Product(vec![slope.clone(), w, g])
                    };
                    parts.push(product(*a, *b));
                    parts.push(Expression::Negate(Box::new(product(*b, *a))));
                }
                if !parts.is_empty() {
                    let sum = Expression::Sum(parts);
                    terms.push(sum.evaluate_in(graph, &mut |_, at| Ok(rows[at].clone()))?);
                    of_results.push(family);
                }
            }
            Ok(terms)
        })?;
        Ok((code, of_results))
    }
}

/// One thread's products with the Jacobian of a field, or with its transpose.
pub(super) struct Tangents {
    code: Arc<TangentCode>,
    is_pulled: bool,
    hessian: Slopes,
    gradient: Option<Slopes>,
    tensor: Workspace,
    of_tensor: Option<[Workspace; 2]>,
    operations: u64,
    /// x and c, ∇²H c behind it rows of 0, ∇H, and a product of the tensor.
    point: Vec<f64>,
    of_hessian: Vec<f64>,
    slope: Vec<f64>,
    room: Vec<f64>,
}

impl Tangents {
    pub(super) fn new(code: &Arc<TangentCode>, parameters: &[f64], is_pulled: bool) -> Self {
        let d = code.shape.dimension();
        let of_tensor = code.of_tensor.as_ref();
        Self {
            hessian: Slopes::new(&code.hessian, 1, parameters),
            gradient: of_tensor.map(|_| Slopes::new(&code.gradient, 1, parameters)),
            tensor: code.tensor.workspace(parameters),
            of_tensor: of_tensor.map(|codes| [0, 1].map(|at| codes[at].0.workspace(parameters))),
            operations: 0,
            point: vec![0.0; 2 * d],
            of_hessian: vec![0.0; 2 * d],
            slope: vec![0.0; d],
            room: vec![0.0; d],
            is_pulled,
            code: Arc::clone(code),
        }
    }

    /// ∇²H c, with c in `room`.
    fn find_hessian(&mut self, y: &[f64]) {
        let (x, c) = self.point.split_at_mut(y.len());
        x.copy_from_slice(y);
        c.copy_from_slice(&self.room);
        self.hessian.evaluate(&self.point, &mut self.of_hessian);
        self.operations += self.code.hessian.work();
    }

    /// Πv in `room`.
    fn apply_tensor(&mut self, y: &[f64], v: &[f64]) {
        let code = &self.code;
        let rows = [y, v];
        apply(
            (&code.tensor, &code.tensor_families),
            &mut self.tensor,
            &rows,
            code.shape.sites,
            &mut self.room,
        );
    }

    /// Subtracts what the tensor's own change gives, with v or w.
    fn subtract_change(&mut self, which: usize, y: &[f64], vector: &[f64], out: &mut [f64]) {
        let (Some(gradient), Some(workspaces), Some(codes)) = (
            &mut self.gradient,
            &mut self.of_tensor,
            &self.code.of_tensor,
        ) else {
            return;
        };
        gradient.evaluate(y, &mut self.slope);
        self.operations += self.code.gradient.work();
        let (code, families) = &codes[which];
        let rows = [y, vector, &self.slope];
        let sites = self.code.shape.sites;
        apply(
            (code, families),
            &mut workspaces[which],
            &rows,
            sites,
            &mut self.room,
        );
        for (out, change) in out.iter_mut().zip(&self.room) {
            *out -= change;
        }
    }
}

/// Results of the code of a site, of rows of these states.
fn apply(
    (code, families): (&SiteCode, &[usize]),
    workspace: &mut Workspace,
    states: &[&[f64]],
    sites: usize,
    out: &mut [f64],
) {
    let count = out.len() / sites;
    let row = |at: usize| &states[at / count][at % count * sites..][..sites];
    out.fill(0.0);
    code.evaluate(workspace, sites, row, |result, place, values| {
        let start = families[result] * sites + place;
        out[start..][..values.len()].copy_from_slice(values);
    });
}

impl Evaluator for Tangents {
    fn values(&mut self, point: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let (y, vector) = point.split_at(out.len());
        match self.is_pulled {
            false => self.push(y, vector, out),
            true => self.pull(y, vector, out),
        }
        Ok(())
    }

    fn jacobians(&mut self, _points: &[f64], _out: &mut [f64]) -> Result<(), StepError> {
        Err(StepError::NoTangent)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}

impl Tangents {
    /// DX(y) v.
    fn push(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) {
        self.room.copy_from_slice(v);
        self.find_hessian(y);
        let of_hessian = std::mem::take(&mut self.of_hessian);
        self.apply_tensor(y, &of_hessian[..y.len()]);
        self.of_hessian = of_hessian;
        for (out, term) in out.iter_mut().zip(&self.room) {
            *out = -term;
        }
        self.subtract_change(0, y, v, out);
    }

    /// DX(y)ᵀ w.
    fn pull(&mut self, y: &[f64], w: &[f64], out: &mut [f64]) {
        self.apply_tensor(y, w);
        self.find_hessian(y);
        out.copy_from_slice(&self.of_hessian[..y.len()]);
        self.subtract_change(1, y, w, out);
    }
}
