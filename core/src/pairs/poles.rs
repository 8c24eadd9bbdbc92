//! Poles between sites, which no step crosses: denominators of one pair or site that change their sign.
//!
//! Bodies on a line that pass through each other are such a pair; where bodies move in a plane, r² is never negative. The
//! denominators of functions of sums are not looked at.

use std::collections::BTreeSet;
use std::sync::Arc;

use leafwise_expression::{Expression, Graph, Term, Workspace};
use leafwise_solver::{Crossing, StepCheck, looks};

use super::BodyShape;
use super::function::BodySum;
use super::matrix::PairEntry;
use super::site_code::SiteCode;
use super::system::BodySystem;
use crate::error::{BuildError, StepError};

/// Longest text of a denominator in a message.
const MOST_PARTS: usize = 60;

/// The denominators of sites and pairs whose signs can change.
#[derive(Debug)]
struct BodyPoles {
    shape: BodyShape,
    variables: Vec<String>,
    parameters: Vec<String>,
    of_pairs: Option<Denominators>,
    of_sites: Option<Denominators>,
}

/// Denominators in the variables of a pair's formula.
#[derive(Debug)]
struct Denominators {
    graph: Graph,
    /// Functions that have a pole where one of them vanishes.
    field: Vec<Term>,
    terms: Vec<Term>,
    code: SiteCode,
    looks: &'static [f64],
    reads: BTreeSet<usize>,
}

/// Maker of the check of steps of so many lanes with these parameters.
type Make = Box<dyn Fn(usize, &[f64]) -> Box<dyn StepCheck> + Send + Sync>;

impl BodySystem {
    /// Makes the check that no step crosses a pole; `None` where there is none.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or derivative has no code.
    pub(super) fn poles(&self) -> Result<Option<Make>, BuildError> {
        let poles = BodyPoles::of(self)?.map(Arc::new);
        Ok(poles.map(|poles| -> Make {
            Box::new(move |lanes, parameters| Arc::clone(&poles).check(lanes, parameters))
        }))
    }
}

impl BodyPoles {
    /// Those of a system; `None` where all denominators are of one sign.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or derivative has no code.
    fn of(system: &BodySystem) -> Result<Option<Self>, BuildError> {
        let sums = &system.hamiltonian.sums;
        let formulas = |part: fn(&BodySum) -> &Expression| sums.iter().map(part).collect();
        let entries = system.bracket.iter().map(|(_, entry)| entry);
        let entries = entries.chain(system.forces.formulas()).collect();
        let of = |formulas: Vec<&Expression>, entries: Vec<&Expression>| {
            Denominators::of(&system.shape, &formulas, &entries, system.parameters.len())
        };
        let (of_pairs, of_sites) = (
            of(formulas(|sum| &sum.pair), Vec::new())?,
            of(formulas(|sum| &sum.site), entries)?,
        );
        let parameters = system.parameters.iter().map(|p| p.name.clone());
        Ok((of_pairs.is_some() || of_sites.is_some()).then(|| Self {
            shape: system.shape.clone(),
            variables: system.variables.clone(),
            parameters: parameters.collect(),
            of_pairs,
            of_sites,
        }))
    }
}

impl Denominators {
    /// Of terms of H, by whose slopes poles are told, and of entries of the tensor.
    fn of(
        shape: &BodyShape,
        formulas: &[&Expression],
        entries: &[&Expression],
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        let mut graph = Graph::compilable();
        let inputs: Vec<Term> = (0..shape.variables()).map(|at| graph.input(at)).collect();
        let of_terms = formulas.len();
        let mut functions = Vec::with_capacity(of_terms + entries.len());
        for formula in formulas.iter().chain(entries) {
            let variable = &mut |_: &mut _, at: usize| Ok(inputs[at].clone());
            functions.push(formula.evaluate_in(&mut graph, variable)?);
        }
        let terms = graph.denominators(&functions)?;
        if terms.is_empty() {
            return Ok(None);
        }
        let mut field = functions.split_off(of_terms);
        for term in &functions {
            field.extend(graph.gradient(term, 2 * shape.families)?);
        }
        graph.unless_refused(())?;
        let code = SiteCode::new(inputs.len(), parameters, |own, rows| {
            Ok(graph.evaluate_in(own, &terms, rows)?)
        })?;
        Ok(Some(Self {
            looks: looks(&graph, &terms),
            reads: graph.inputs_read(&terms).into_iter().collect(),
            graph,
            field,
            terms,
            code,
        }))
    }
}

impl BodyPoles {
    /// The check of steps of so many lanes.
    fn check(self: Arc<Self>, lanes: usize, parameters: &[f64]) -> Box<dyn StepCheck> {
        let d = self.shape.dimension();
        let mut check = CrossingsOfBodies {
            lanes,
            parameters: Vec::new(),
            of_pairs: None,
            of_sites: None,
            start: vec![0.0; d],
            increment: vec![0.0; d],
            places: Vec::new(),
            rows: vec![0.0; self.shape.variables() * self.shape.sites],
            values: [Vec::new(), Vec::new()],
            poles: self,
        };
        check.set_parameters(parameters);
        Box::new(check)
    }
}

/// The denominators of all pairs and sites at two parts of a step, one after the other.
struct CrossingsOfBodies {
    poles: Arc<BodyPoles>,
    lanes: usize,
    /// Of each lane.
    parameters: Vec<Vec<f64>>,
    of_pairs: Option<Vec<Workspace>>,
    of_sites: Option<Vec<Workspace>>,
    /// x and Δ of one lane, and states along Δ.
    start: Vec<f64>,
    increment: Vec<f64>,
    places: Vec<Vec<f64>>,
    /// The variables of pairs, a row each.
    rows: Vec<f64>,
    /// Denominators before and after a part of the step.
    values: [Vec<f64>; 2],
}

impl CrossingsOfBodies {
    /// The states at the parts of a step that are looked at.
    fn go_along(&mut self, looks: &[f64]) {
        self.places.resize_with(looks.len(), Vec::new);
        for (place, part) in self.places.iter_mut().zip(looks) {
            let way = self.start.iter().zip(&self.increment);
            place.clear();
            place.extend(way.map(|(x, change)| x + part * change));
        }
    }

    /// The first pole of a lane.
    fn pole(&mut self, lane: usize) -> Option<StepError> {
        let poles = Arc::clone(&self.poles);
        let sites = poles.shape.sites;
        if let Some(own) = &poles.of_sites {
            self.go_along(own.looks);
            let found = self.crossing(own, lane, (0, 0, sites), false);
            if found.is_some() {
                return found;
            }
        }
        let own = poles.of_pairs.as_ref()?;
        self.go_along(own.looks);
        (0..sites).find_map(|i| self.crossing(own, lane, (i, i + 1, sites - 1 - i), true))
    }

    /// A pole of the pairs of site i with so many sites from j on, or of so many sites.
    fn crossing(
        &mut self,
        own: &Denominators,
        lane: usize,
        (i, j, count): (usize, usize, usize),
        is_pair: bool,
    ) -> Option<StepError> {
        if count == 0 {
            return None;
        }
        for look in 0..own.looks.len() {
            self.evaluate(own, lane, (look, i, j, count), is_pair);
            let [before, after] = &self.values;
            if look == 0 {
                continue;
            }
            for at in 0..after.len() {
                if before[at].signum() == after[at].signum() {
                    continue;
                }
                let (which, other) = (at / count, j + at % count);
                let pair = if is_pair { [i, other] } else { [other, other] };
                let crossing = Crossing {
                    graph: &own.graph,
                    field: &own.field,
                    denominator: &own.terms[which],
                    parameters: self.parameters[lane].clone(),
                    start: self.variables(&self.start, pair, true),
                    increment: self.variables(&self.increment, pair, false),
                };
                if crossing.is_pole((own.looks[look - 1], own.looks[look])) {
                    return Some(StepError::Pole {
                        denominator: self.poles.written(own, which, pair),
                        before: before[at],
                        after: after[at],
                    });
                }
            }
        }
        None
    }

    /// Denominators at a part of the step behind those at the part before.
    fn evaluate(
        &mut self,
        own: &Denominators,
        lane: usize,
        (look, i, j, count): (usize, usize, usize, usize),
        is_pair: bool,
    ) {
        let shape = &self.poles.shape;
        let (families, sites) = (shape.families, shape.sites);
        let place = &self.places[look];
        for variable in &own.reads {
            let row = &mut self.rows[variable * sites..][..count];
            let first = |at: usize| if is_pair { i } else { j + at };
            match shape.entry_of(*variable) {
                Some((matrix, entry)) => {
                    let entry = PairEntry::numbered(entry);
                    for (at, row) in row.iter_mut().enumerate() {
                        *row = entry.of(&shape.matrices[matrix], [first(at), j + at]);
                    }
                }
                None if is_pair && *variable < families => row.fill(place[variable * sites + i]),
                None => row.copy_from_slice(&place[variable % families * sites + j..][..count]),
            }
        }
        self.values.swap(0, 1);
        let values = &mut self.values[1];
        values.resize(own.terms.len() * count, 0.0);
        let workspaces = if is_pair {
            &mut self.of_pairs
        } else {
            &mut self.of_sites
        };
        let Some(workspaces) = workspaces else {
            return;
        };
        let row = |at: usize| &self.rows[at * sites..][..count];
        own.code
            .evaluate(&mut workspaces[lane], count, row, |which, place, found| {
                values[which * count + place..][..found.len()].copy_from_slice(found);
            });
    }

    /// The variables of a pair's formula, of coordinates of all sites; entries of matrices, or 0.
    fn variables(&self, x: &[f64], pair: [usize; 2], has_entries: bool) -> Vec<f64> {
        let shape = &self.poles.shape;
        let value = |variable: usize| match shape.entry_of(variable) {
            Some((matrix, entry)) if has_entries => {
                PairEntry::numbered(entry).of(&shape.matrices[matrix], pair)
            }
            Some(_) => 0.0,
            None => {
                let site = pair[variable / shape.families];
                x[variable % shape.families * shape.sites + site]
            }
        };
        (0..shape.variables()).map(value).collect()
    }
}

impl BodyPoles {
    /// A denominator of two sites in the names of a scene.
    fn written(&self, own: &Denominators, which: usize, pair: [usize; 2]) -> String {
        let shape = &self.shape;
        let name = |variable: usize| match shape.entry_of(variable) {
            Some((matrix, entry)) => {
                let (row, column) = (pair[usize::from(entry & 2 != 0)], pair[entry & 1]);
                format!("matrix {matrix} at [{row},{column}]")
            }
            None => {
                let site = pair[variable / shape.families];
                self.variables[variable % shape.families * shape.sites + site].clone()
            }
        };
        let names: Vec<String> = (0..shape.variables()).map(name).collect();
        match own.graph.formula(&own.terms[which], MOST_PARTS) {
            Some(formula) => formula.written(&names, &self.parameters),
            None => format!("a long denominator of sites {} and {}", pair[0], pair[1]),
        }
    }
}

impl StepCheck for CrossingsOfBodies {
    fn reads(&self, coordinate: usize) -> bool {
        let family = coordinate / self.poles.shape.sites;
        let (families, entries) = (self.poles.shape.families, 2 * self.poles.shape.families);
        let all = [&self.poles.of_pairs, &self.poles.of_sites];
        let mut reads = all.into_iter().flatten().flat_map(|own| &own.reads);
        reads.any(|variable| *variable < entries && variable % families == family)
    }

    fn set_parameters(&mut self, parameters: &[f64]) {
        let lanes = self.lanes;
        let of_lane = |lane: usize| -> Vec<f64> {
            parameters
                .iter()
                .skip(lane)
                .step_by(lanes)
                .copied()
                .collect()
        };
        self.parameters = (0..lanes).map(of_lane).collect();
        let workspaces = |own: &Option<Denominators>| {
            let code = own.as_ref().map(|own| &own.code);
            code.map(|code| self.parameters.iter().map(|p| code.workspace(p)).collect())
        };
        [self.of_pairs, self.of_sites] =
            [&self.poles.of_pairs, &self.poles.of_sites].map(workspaces);
    }

    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        let lanes = outcome.len();
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            if outcome.is_err() {
                continue;
            }
            for (own, all) in [(&mut self.start, x), (&mut self.increment, increment)] {
                let of_lane = all.iter().skip(lane).step_by(lanes);
                own.iter_mut().zip(of_lane).for_each(|(own, x)| *own = *x);
            }
            if let Some(pole) = self.pole(lane) {
                *outcome = Err(pole);
            }
        }
    }
}
