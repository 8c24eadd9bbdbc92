//! Strang's product of the flows of sites and of pairs of sites, for sums over pairs in a loop.
//!
//! The flow of one pair is found in formulas, as that of a system of two sites. In a round of pairs that share no site all
//! turn at once, by the same code. All pairs of N sites are N − 1 rounds of an even number N, and N of an odd one.

use std::sync::Arc;

use leafwise_core::part::{PartInfo, PartParameters};
use leafwise_core::solver::{
    ExplicitMap, Factored, Inverse, Lanes, MapAbilities, MapProperties, Pieces, StepMap,
    StepReport, Stepper, Structure, Trajectories,
};
use leafwise_core::system::{BodyPlace, BodyTerms};
use leafwise_core::{BuildError, Differential, StepError, SystemFormulas};

use crate::arrangement::named_order;
use crate::piece::NAME;
use crate::product::{Product, Splits, evaluations};
use crate::rounds::rounds_of_all;
use crate::schedule::{Flow, STRANG, passes};

/// φ¹_{t/2} ∘ … ∘ φʳ_t ∘ … ∘ φ¹_{t/2}, a piece of H the terms of all sites, or those of the pairs of a round.
#[derive(Clone)]
pub(crate) struct FlowsOfTerms {
    shared: Arc<Shared>,
    /// The pieces in the order of χ.
    pieces: Arc<[Commuting]>,
}

struct Shared {
    terms: Arc<BodyTerms>,
    /// Flows of one site or one pair.
    flows: Vec<ExplicitMap>,
}

/// Terms with disjoint sites, which move at once by one flow.
#[derive(Clone)]
struct Commuting {
    /// The number of the flow.
    flow: usize,
    /// How many of the two sites it moves.
    moves: usize,
    /// The sites of each term.
    sites: Arc<[[usize; 2]]>,
}

impl FlowsOfTerms {
    /// The product for these terms, whose flows `flows_of` finds piece by piece.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] where a term has no exact flow, or that of a pair is a product of several.
    pub(crate) fn new(
        info: &'static PartInfo,
        terms: Arc<BodyTerms>,
        parameters: &PartParameters,
        flows_of: impl Fn(&SystemFormulas) -> Result<Vec<ExplicitMap>, BuildError>,
    ) -> Result<Self, BuildError> {
        let sites = terms.sites;
        let (mut flows, mut pieces) = (Vec::new(), Vec::new());
        if let Some(site) = &terms.site {
            for flow in flows_of(site)? {
                pieces.push(Commuting {
                    flow: flows.len(),
                    moves: 1,
                    sites: (0..sites).map(|i| [i, i]).collect(),
                });
                flows.push(flow);
            }
        }
        if let Some(pair) = &terms.pair {
            let found = flows_of(pair)?;
            let count = found.len();
            let Ok([flow]) = <[ExplicitMap; 1]>::try_from(found) else {
                return Err(BuildError::DoesNotFit {
                    part: NAME,
                    reason: format!(
                        "the terms of a pair of sites have no flow together, but are {count} pieces: in loops each pair is one"
                    ),
                });
            };
            for round in rounds_of_all(sites) {
                pieces.push(Commuting {
                    flow: flows.len(),
                    moves: 2,
                    sites: round.into(),
                });
            }
            flows.push(flow);
        }
        if let Some(order) = named_order(info, parameters, pieces.len())? {
            pieces = order.into_iter().map(|at| pieces[at].clone()).collect();
        }
        Ok(Self {
            shared: Arc::new(Shared { terms, flows }),
            pieces: pieces.into(),
        })
    }

    /// The same as a composition asks for the parts.
    ///
    /// # Errors
    /// [`BuildError::Pieces`] where they are not of that kind.
    fn arranged(&self, asked: Pieces) -> Result<Self, BuildError> {
        match asked {
            Pieces::Any => Ok(self.clone()),
            Pieces::Nystrom { .. } | Pieces::Perturbed => Err(BuildError::Pieces {
                asked,
                map: self.describe(),
                reason: "its pieces are rounds of pairs".to_owned(),
            }),
        }
    }

    /// The flows of a product of χ and χ*, each with what `make` makes of its flow over its part of the time.
    fn flows<T>(&self, parts: &[f64], make: impl Fn(&ExplicitMap, usize, f64) -> T) -> Steps<T> {
        let order: Vec<usize> = (0..self.pieces.len()).collect();
        let mut made: Vec<([u64; 3], T)> = Vec::new();
        let mut flows = Vec::new();
        for Flow { piece, part } in passes(&order, parts) {
            let Commuting { flow, sites, .. } = &self.pieces[piece];
            let key = [*flow as u64, sites.len() as u64, part.to_bits()];
            let by = made.iter().position(|(own, _)| *own == key);
            flows.push((piece, by.unwrap_or(made.len())));
            if by.is_none() {
                let flow = &self.shared.flows[*flow];
                made.push((key, make(flow, sites.len(), part)));
            }
        }
        Steps {
            map: self.clone(),
            flows,
            made: made.into_iter().map(|(_, made)| made).collect(),
        }
    }
}

impl StepMap for FlowsOfTerms {
    fn dimension(&self) -> usize {
        self.shared.terms.dimension()
    }

    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 2,
            structure: Structure::Exact,
            self_adjoint: Some(true),
        }
    }

    fn describe(&self) -> String {
        let pieces = self.pieces.len();
        let noun = if pieces == 1 { "piece" } else { "pieces" };
        format!("{NAME} into {pieces} {noun}, disjoint pairs of sites at once")
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.passes_stepper(&STRANG, lanes, parameters, epsilon, h)
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        self.passes_differential(&STRANG, parameters, epsilon, h)
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            factored: Some(Factored {
                factors: Product::factors(self),
                pieces: self.pieces.len(),
                arranged: Some(Box::new(|asked| Ok(Arc::new(self.arranged(asked)?)))),
                product: Box::new(|parts| Some(Arc::new(Product::new(self, parts)))),
            }),
            ..MapAbilities::default()
        }
    }
}

impl Splits for FlowsOfTerms {
    fn passes_stepper(
        &self,
        parts: &[f64],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper> {
        let make = |parameters: &[f64]| Rounds {
            evaluations: evaluations(parts),
            state: vec![0.0; self.dimension()],
            room: [Vec::new(), Vec::new()],
            outcome: Vec::new(),
            steps: self.flows(parts, |flow, terms, part| {
                let each = |value: &f64| std::iter::repeat_n(*value, terms);
                let parameters: Vec<f64> = parameters.iter().flat_map(each).collect();
                flow.stepper(terms, &parameters, epsilon, part * h)
            }),
        };
        Box::new(Lanes::apart(lanes, self.dimension(), parameters, make))
    }

    fn passes_differential(
        &self,
        parts: &[f64],
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Differential> {
        let d = self.shared.terms.variables();
        Box::new(TermTangents {
            steps: self.flows(parts, |flow, _, part| {
                flow.differential(parameters, (epsilon, part * h), Inverse::Opposite)
            }),
            from: vec![0.0; self.dimension()],
            states: Vec::new(),
            point: vec![0.0; d],
            change: vec![0.0; d],
            vectors: Vec::new(),
        })
    }
}

/// Flows one after the other, each by a piece's number and that of what takes it.
struct Steps<T> {
    map: FlowsOfTerms,
    flows: Vec<(usize, usize)>,
    made: Vec<T>,
}

/// Steps of one trajectory.
///
/// The state between flows is plain doubles; the flows' increments add up apart from it.
struct Rounds {
    steps: Steps<Box<dyn Stepper>>,
    /// The number of evaluations that a step counts as.
    evaluations: u64,
    state: Vec<f64>,
    /// Coordinates of all terms of a piece and their changes, coordinate after coordinate.
    room: [Vec<f64>; 2],
    outcome: Vec<Result<(), StepError>>,
}

impl Rounds {
    fn run(&mut self, x: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        increment.fill(0.0);
        self.state.copy_from_slice(x);
        let Steps { map, flows, made } = &mut self.steps;
        let (terms, pieces) = (&map.shared.terms, &map.pieces);
        for (piece, by) in flows.iter() {
            let Commuting { moves, sites, .. } = &pieces[*piece];
            let count = sites.len();
            let [points, changes] = &mut self.room;
            points.resize(count * terms.variables(), 0.0);
            changes.resize(points.len(), 0.0);
            self.outcome.clear();
            self.outcome.resize(count, Ok(()));
            for (term, sites) in sites.iter().enumerate() {
                for (c, place) in terms.places(*sites).enumerate() {
                    points[c * count + term] = match place {
                        BodyPlace::Coordinate(at) => self.state[at],
                        BodyPlace::Entry(number) => number,
                    };
                }
            }
            made[*by].increment(points, points, changes, &mut self.outcome);
            let moved = moves * terms.families;
            for (term, sites) in sites.iter().enumerate() {
                std::mem::replace(&mut self.outcome[term], Ok(()))?;
                for (c, place) in terms.places(*sites).take(moved).enumerate() {
                    let BodyPlace::Coordinate(at) = place else {
                        continue;
                    };
                    increment[at] += changes[c * count + term];
                    self.state[at] = x[at] + increment[at];
                }
            }
        }
        Ok(())
    }
}

impl Trajectories for Rounds {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let outcome = self.run(x, increment);
        for taken in taken {
            match &outcome {
                Ok(()) => taken.evaluations += self.evaluations,
                Err(error) => taken.fail(error.clone()),
            }
        }
    }

    fn operations(&self) -> Option<u64> {
        let made = self.steps.made.iter();
        Some(made.filter_map(|own| own.statistics().operations).sum())
    }
}

/// Steps of one trajectory with their differentials: flow after flow, pair after pair.
struct TermTangents {
    steps: Steps<Box<dyn Differential>>,
    /// Where the last step began, and the state before each of its flows where they are known.
    from: Vec<f64>,
    states: Vec<Vec<f64>>,
    /// Of one or two sites: coordinates and their change, and vectors.
    point: Vec<f64>,
    change: Vec<f64>,
    vectors: Vec<f64>,
}

impl TermTangents {
    /// The step from where the last one began, and the states before its flows.
    fn run(&mut self, increment: &mut [f64]) -> Result<(), StepError> {
        increment.fill(0.0);
        let mut state = self.from.clone();
        self.states.clear();
        for at in 0..self.steps.flows.len() {
            let before = state.clone();
            for (term, moved) in self.terms(at) {
                self.step_of(at, &term, &before)?;
                for (c, place) in term.iter().take(moved).enumerate() {
                    if let BodyPlace::Coordinate(place) = place {
                        increment[*place] += self.change[c];
                        state[*place] = self.from[*place] + increment[*place];
                    }
                }
            }
            self.states.push(before);
        }
        Ok(())
    }

    /// The coordinates of each term of a flow's piece, and how many of them it moves.
    fn terms(&self, at: usize) -> Vec<(Vec<BodyPlace>, usize)> {
        let map = &self.steps.map;
        let Commuting { moves, sites, .. } = &map.pieces[self.steps.flows[at].0];
        let terms = &map.shared.terms;
        let moved = moves * terms.families;
        let sites = sites.iter();
        sites
            .map(|sites| (terms.places(*sites).collect(), moved))
            .collect()
    }

    /// The step of a term of a flow from a state.
    fn step_of(&mut self, at: usize, term: &[BodyPlace], state: &[f64]) -> Result<(), StepError> {
        for (value, place) in self.point.iter_mut().zip(term) {
            *value = match place {
                BodyPlace::Coordinate(at) => state[*at],
                BodyPlace::Entry(number) => *number,
            };
        }
        let flow = &mut self.steps.made[self.steps.flows[at].1];
        flow.step(&self.point, &vec![0.0; self.point.len()], &mut self.change)
    }

    /// Applies `act` to the part of a vector at the sites of each term of a flow.
    fn act(
        &mut self,
        at: usize,
        vector: &mut [f64],
        mut act: impl FnMut(&mut dyn Differential, &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), StepError> {
        let states = std::mem::take(&mut self.states);
        let done = self.act_from(at, &states[at], vector, &mut act);
        self.states = states;
        done
    }

    /// The same from the state before the flow.
    fn act_from(
        &mut self,
        at: usize,
        state: &[f64],
        vector: &mut [f64],
        act: &mut impl FnMut(&mut dyn Differential, &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), StepError> {
        for (term, moved) in self.terms(at) {
            self.step_of(at, &term, state)?;
            self.vectors.clear();
            // A site that stands twice has its vector once.
            self.vectors
                .extend(term.iter().enumerate().map(|(c, place)| match place {
                    BodyPlace::Coordinate(at) if c < moved => vector[*at],
                    _ => 0.0,
                }));
            let by = self.steps.flows[at].1;
            act(self.steps.made[by].as_mut(), &mut self.vectors)?;
            for (place, value) in term.iter().take(moved).zip(&self.vectors) {
                if let BodyPlace::Coordinate(at) = place {
                    vector[*at] = *value;
                }
            }
        }
        Ok(())
    }

    fn find(&mut self) -> Result<(), StepError> {
        if self.states.is_empty() {
            let mut increment = vec![0.0; self.from.len()];
            self.run(&mut increment)?;
        }
        Ok(())
    }
}

impl Differential for TermTangents {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.from.copy_from_slice(x);
        self.run(increment)?;
        match increment.iter().all(|change| change.is_finite()) {
            true => Ok(()),
            false => Err(StepError::OF_INCREMENT),
        }
    }

    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        self.find()?;
        let d = self.from.len();
        let vectors = (tangents.len() / d).max(1);
        let parameters_each = parameters.len() / vectors;
        for (k, tangent) in tangents.chunks_exact_mut(d).enumerate() {
            let own = &parameters[k * parameters_each..][..parameters_each];
            for at in 0..self.steps.flows.len() {
                self.act(at, tangent, |flow, vector| flow.push(vector, own))?;
            }
        }
        Ok(())
    }

    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        self.find()?;
        for at in (0..self.steps.flows.len()).rev() {
            self.act(at, covector, |flow, vector| flow.pull(vector, gradient))?;
        }
        Ok(())
    }

    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        self.find()?;
        for at in 0..self.steps.flows.len() {
            self.act(at, covector, |flow, vector| {
                flow.pull_inverse(vector, gradient)
            })?;
        }
        Ok(())
    }

    fn knows_parameters(&self) -> bool {
        self.steps.made.iter().all(|flow| flow.knows_parameters())
    }

    fn operations(&self) -> Option<u64> {
        let made = self.steps.made.iter();
        made.map(|flow| flow.operations()).sum()
    }
}
