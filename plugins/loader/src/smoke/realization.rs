//! A realization of numbers on the problems it serves.

use std::ffi::c_void;

use leafwise_plugin_abi::{LwMapFn, LwRealization};

use super::answers::Tester;
use super::compare::{derivative, equal, largest};
use super::function::{Function, Points};
use super::problems::{lend, problems};
use super::{Subject, TestProblem};
use crate::foreign::ForeignPart;
use crate::smoke_failure::SmokeFailure;
use crate::trial_points::{momenta, states};

/// The ε at which maps are tried.
const EPSILON: f64 = 0.5;

/// Tries the part on each problem that it serves.
pub(super) fn try_part(subject: &mut Subject, table: &LwRealization) -> Result<(), SmokeFailure> {
    for problem in problems(subject.maker.part.dimensions) {
        let d = problem.system.dimension();
        let lend = || lend(&problem);
        let mut run = |part: &ForeignPart, tester: &mut Tester| {
            let ask = |f: unsafe extern "C" fn(*mut c_void) -> usize| {
                // SAFETY: a function of the instance's own table.
                tester.instance.ask(|instance| unsafe { f(instance) })
            };
            let space = table.space_dimension.map_or(0, ask);
            let is_pair = part.has_cotangent_chart();
            if space < 2 * d || space > 1 << 20 || (is_pair && space != 2 * d) {
                return Err(SmokeFailure::Shape {
                    problem: format!("space_dimension is {space}, for a system of dimension {d}"),
                });
            }
            let mut trial = Trial {
                tester,
                table,
                d,
                space,
                is_pair,
                is_reversible: part.is_reversible(),
            };
            trial.run(&problem)
        };
        subject.on_problem(&problem.name, d, &lend, &mut run)?;
    }
    Ok(())
}

struct Trial<'a> {
    tester: &'a mut Tester,
    table: &'a LwRealization,
    d: usize,
    space: usize,
    is_pair: bool,
    is_reversible: bool,
}

type Answers = Option<Vec<Vec<f64>>>;

impl Trial<'_> {
    fn evaluate(
        &mut self,
        name: &str,
        function: LwMapFn,
        results: usize,
        points: &Points,
    ) -> Result<Answers, SmokeFailure> {
        if function.is_none() {
            return Ok(None);
        }
        let function = Function {
            name,
            function,
            results,
            epsilon: EPSILON,
            h: 0.0,
        };
        self.tester.try_at(&function, points)
    }

    /// Tries all functions; false where the problem's states are outside the domain.
    fn run(&mut self, problem: &TestProblem) -> Result<bool, SmokeFailure> {
        let states = states(self.d);
        let Some(section) = self.section(&states)? else {
            return Ok(false);
        };
        let on_section = Points::of(section.clone());
        let (alpha, beta) = (self.table.alpha, self.table.beta);
        let ends = [
            ("alpha", alpha, "alpha(x,0)=x"),
            ("beta", beta, "beta(x,0)=x"),
        ];
        for (name, function, identity) in ends {
            let Some(found) = self.evaluate(name, function, self.d, &on_section)? else {
                return Ok(false);
            };
            for (found, x) in found.iter().zip(&states) {
                let identity = format!("bisection identity {identity} on {}", problem.name);
                equal(&identity, found, x, 1.0)?;
            }
        }
        let (points, reversed) = self.points(&states, section)?;
        self.maps(&points, reversed.as_ref())?;
        Ok(true)
    }

    /// σ at the states.
    fn section(&mut self, states: &[Vec<f64>]) -> Result<Answers, SmokeFailure> {
        if self.table.sigma.is_some() {
            let points = Points::of(states.to_vec());
            return self.evaluate("sigma", self.table.sigma, self.space, &points);
        }
        let pair = |x: &Vec<f64>| [x.clone(), vec![0.0; self.space - self.d]].concat();
        Ok(Some(states.iter().map(pair).collect()))
    }

    /// Points near the section, and their images under inversion where that is known.
    fn points(
        &mut self,
        states: &[Vec<f64>],
        section: Vec<Vec<f64>>,
    ) -> Result<(Points, Option<Points>), SmokeFailure> {
        let momenta = momenta(self.d);
        let pair = |sign: f64| {
            let pairs = states.iter().zip(&momenta);
            let pairs = pairs.map(|(x, p)| x.iter().copied().chain(p.iter().map(|p| sign * p)));
            Points::of(pairs.map(Iterator::collect).collect())
        };
        if self.is_pair {
            return Ok((pair(1.0), Some(pair(-1.0))));
        }
        let charted = Points {
            point: states.to_vec(),
            v: momenta.clone(),
            w: Vec::new(),
        };
        let z = self.evaluate("chart", self.table.chart, self.space, &charted)?;
        let columns = self.space * 2 * self.d;
        let function = self.table.chart_jacobian;
        self.evaluate("chart_jacobian", function, columns, &charted)?;
        if z.is_some() {
            let origin = Points {
                v: vec![vec![0.0; self.d]; states.len()],
                ..charted
            };
            let z = self.evaluate("chart", self.table.chart, self.space, &origin)?;
            for (found, expected) in z.iter().flatten().zip(&section) {
                equal("chart(x,0)=sigma(x)", found, expected, 1.0)?;
            }
        }
        Ok((Points::of(z.unwrap_or(section)), None))
    }

    /// All maps at points near the section.
    fn maps(&mut self, points: &Points, reversed: Option<&Points>) -> Result<(), SmokeFailure> {
        let (table, d, s) = (*self.table, self.d, self.space);
        let alpha = self.evaluate("alpha", table.alpha, d, points)?;
        let beta = self.evaluate("beta", table.beta, d, points)?;
        let (Some(alpha), Some(beta)) = (alpha, beta) else {
            return Ok(());
        };
        self.evaluate("domain", table.domain, 1, points)?;
        if let (true, Some(reversed)) = (self.is_reversible, reversed) {
            let mirrored = self.evaluate("alpha", table.alpha, d, reversed)?;
            for (beta, mirrored) in beta.iter().zip(mirrored.iter().flatten()) {
                equal("beta(x,p)=alpha(x,-p)", beta, mirrored, 1.0)?;
            }
        }
        let ends = self.evaluate("ends", table.ends, 3 * d, points)?;
        for (at, ends) in ends.iter().flatten().enumerate() {
            let (base, rest) = ends.split_at(d);
            let (offset, increment) = rest.split_at(d);
            let scale = 1.0 + largest(&alpha[at]);
            let sum: Vec<f64> = base.iter().zip(offset).map(|(b, o)| b + o).collect();
            equal("base + offset = beta", &sum, &beta[at], scale)?;
            let ab: Vec<f64> = alpha[at]
                .iter()
                .zip(&beta[at])
                .map(|(a, b)| a - b)
                .collect();
            equal("increment = alpha - beta", increment, &ab, scale)?;
        }
        let of_alpha = self.evaluate("alpha_jacobian", table.alpha_jacobian, d * s, points)?;
        let function = table.beta_with_jacobian;
        let of_beta = self.evaluate("beta_with_jacobian", function, d + d * s, points)?;
        let of_ends = self.evaluate("ends_jacobian", table.ends_jacobian, 2 * d * s, points)?;
        if !self.is_pair {
            return Ok(());
        }
        let z = &points.point[0];
        let mut value = |name: &str, function: LwMapFn, z: &[f64]| {
            let found = self.evaluate(name, function, d, &Points::of(vec![z.to_vec()]))?;
            Ok(found.map(|mut all| all.swap_remove(0)))
        };
        if let Some(jacobian) = of_alpha {
            derivative("alpha_jacobian", &jacobian[0], z, |z| {
                value("alpha", table.alpha, z)
            })?;
        }
        if let Some(both) = of_beta {
            let (own, jacobian) = both[0].split_at(d);
            equal("beta_with_jacobian begins with beta", own, &beta[0], 1.0)?;
            derivative("beta_with_jacobian", jacobian, z, |z| {
                value("beta", table.beta, z)
            })?;
        }
        if let Some(both) = of_ends {
            let (target, increment) = both[0].split_at(d * s);
            derivative("ends_jacobian, beta", target, z, |z| {
                value("beta", table.beta, z)
            })?;
            let sum: Vec<f64> = target.iter().zip(increment).map(|(t, i)| t + i).collect();
            derivative("ends_jacobian, alpha", &sum, z, |z| {
                value("alpha", table.alpha, z)
            })?;
        }
        Ok(())
    }
}
