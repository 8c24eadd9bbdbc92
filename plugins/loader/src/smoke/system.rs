//! A system of numbers at a few states.

use leafwise_plugin_abi::{LwMapFn, LwSystem};

use super::Subject;
use super::answers::Tester;
use super::compare::{derivative, equal, largest};
use super::function::{Function, Points};
use crate::foreign::{ForeignPart, HostObjects, names};
use crate::smoke_failure::SmokeFailure;
use crate::trial_points::{momenta, states};

/// Tries every function of the part's own system.
pub(super) fn try_part(subject: &mut Subject, table: &LwSystem) -> Result<(), SmokeFailure> {
    let parameters: Vec<String> = subject
        .maker
        .settings
        .iter()
        .map(|(name, _)| name.clone())
        .collect();
    let mut run = |part: &ForeignPart, tester: &mut Tester| {
        let own: Vec<&str> = parameters.iter().map(String::as_str).collect();
        let names = names(&tester.instance, table, &own);
        let (variables, casimirs) = names.map_err(|problem| SmokeFailure::Shape { problem })?;
        let d = variables.len();
        if !part.dimensions.contains(d) {
            return Err(SmokeFailure::Shape {
                problem: format!(
                    "dimension is {d}, and the part declares {}",
                    part.dimensions
                ),
            });
        }
        let mut trial = Trial {
            tester,
            table,
            d,
            casimirs: casimirs.len(),
        };
        for state in states(d) {
            if trial.at(&state)? {
                return Ok(true);
            }
        }
        Ok(false)
    };
    subject.on_problem("itself", 0, &|| Some(HostObjects::default()), &mut run)
}

struct Trial<'a> {
    tester: &'a mut Tester,
    table: &'a LwSystem,
    d: usize,
    casimirs: usize,
}

impl Trial<'_> {
    fn evaluate(
        &mut self,
        name: &str,
        function: LwMapFn,
        results: usize,
        points: &Points,
    ) -> Result<Option<Vec<Vec<f64>>>, SmokeFailure> {
        let function = Function {
            name,
            function,
            results,
            epsilon: 1.0,
            h: 0.0,
        };
        self.tester.try_at(&function, points)
    }

    /// Tries all functions around a state; false where it is outside the system's domain.
    fn at(&mut self, state: &[f64]) -> Result<bool, SmokeFailure> {
        let (table, d) = (*self.table, self.d);
        let near: Vec<Vec<f64>> = [0.0, 1e-3, -2e-3]
            .iter()
            .map(|shift| state.iter().map(|x| x * (1.0 + shift)).collect())
            .collect();
        let points = |v: bool, w: bool| Points {
            point: near.clone(),
            v: if v { momenta(d) } else { Vec::new() },
            w: if w { states(d) } else { Vec::new() },
        };
        let with_v = points(true, false);
        let Some(applied) = self.evaluate("tensor", table.tensor, d, &with_v)? else {
            return Ok(false);
        };
        let alone = points(false, false);
        let energy = self.evaluate("hamiltonian", table.hamiltonian, 1, &alone)?;
        let gradient = self.evaluate("gradient", table.gradient, d, &alone)?;
        let (Some(_), Some(gradient)) = (energy, gradient) else {
            return Ok(false);
        };
        let rotated = Points {
            v: with_v.v.iter().cycle().skip(1).take(3).cloned().collect(),
            ..with_v.clone()
        };
        let other = self.evaluate("tensor", table.tensor, d, &rotated)?;
        for i in 0..near.len() {
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let scale = largest(&with_v.v[i]) * largest(&applied[i]) * d as f64;
            equal(
                "v.Pi(y)v = 0",
                &[dot(&with_v.v[i], &applied[i])],
                &[0.0],
                scale,
            )?;
            if let Some(other) = &other {
                let scale = largest(&rotated.v[i]) * largest(&applied[i]) * d as f64 + scale;
                let (ab, ba) = (
                    dot(&rotated.v[i], &applied[i]),
                    -dot(&with_v.v[i], &other[i]),
                );
                equal("w.Pi(y)v = -v.Pi(y)w", &[ab], &[ba], scale)?;
            }
        }
        if d <= 64 {
            derivative("gradient", &gradient[0], &near[0], |y| {
                let one = Points::of(vec![y.to_vec()]);
                let found = self.evaluate("hamiltonian", table.hamiltonian, 1, &one)?;
                Ok(found.map(|mut all| all.swap_remove(0)))
            })?;
        }
        self.optional(&with_v, &points(true, true), &alone)?;
        Ok(true)
    }

    fn optional(
        &mut self,
        with_v: &Points,
        with_both: &Points,
        alone: &Points,
    ) -> Result<(), SmokeFailure> {
        let (table, d, casimirs) = (*self.table, self.d, self.casimirs);
        let functions = [
            ("casimirs", table.casimirs, casimirs, alone),
            (
                "casimir_gradients",
                table.casimir_gradients,
                casimirs * d,
                alone,
            ),
            ("tensor_tangent", table.tensor_tangent, d, with_both),
            ("hessian", table.hessian, d, with_v),
        ];
        for (name, function, results, points) in functions {
            if function.is_none() || results == 0 {
                continue;
            }
            let found = self.evaluate(name, function, results, points)?;
            let (Some(found), "casimir_gradients") = (found, name) else {
                continue;
            };
            for gradient in found[0].chunks(d) {
                self.is_casimir(&alone.point[0], gradient)?;
            }
        }
        Ok(())
    }

    /// Π∇C = 0.
    fn is_casimir(&mut self, y: &[f64], gradient: &[f64]) -> Result<(), SmokeFailure> {
        let points = Points {
            point: vec![y.to_vec()],
            v: vec![gradient.to_vec()],
            w: Vec::new(),
        };
        let tensor = self.table.tensor;
        if let Some(applied) = self.evaluate("tensor", tensor, self.d, &points)? {
            let scale = largest(gradient) * (1.0 + largest(y)) * self.d as f64;
            equal("Pi grad C = 0", &applied[0], &vec![0.0; self.d], scale)?;
        }
        Ok(())
    }
}
