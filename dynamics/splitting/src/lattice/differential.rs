//! The differential of a lattice's splitting: flow after flow, each by its sweep.
//!
//! The inverse of φʳ_{t_r} ∘ … ∘ φ¹_{t_1} is φ¹_{−t_1} ∘ … ∘ φʳ_{−t_r}, and is pulled back through as such.

use std::sync::Arc;

use leafwise_core::lattice::{Fields, SlopesAlong};
use leafwise_core::solver::Stepper;
use leafwise_core::{Differential, StepError};

use super::sweeps::Shared;
use crate::schedule::{Flow, passes};

/// The flows of a step, or of its inverse, from the point where they begin.
struct Way {
    along: SlopesAlong,
    from: Vec<f64>,
    /// Whether the slopes are those there, and whether by parameters too.
    known: Option<bool>,
}

impl Way {
    fn new(
        shared: &Shared,
        flows: impl Iterator<Item = Flow>,
        parameters: &[f64],
        (epsilon, h): (f64, f64),
    ) -> Option<Self> {
        let stages = flows.map(|flow| (flow.piece, flow.part * h));
        let mut along = SlopesAlong::new(&shared.slopes, stages, parameters, epsilon)?;
        shared.write_constants(along.fields_mut());
        Some(Self {
            along,
            from: vec![0.0; shared.cells.sites().dimension()],
            known: None,
        })
    }

    fn find(&mut self, shared: &Shared, by_parameters: bool) -> &mut SlopesAlong {
        if self.known.is_none_or(|known| by_parameters && !known) {
            let state = self.along.fields_mut().get_mut(shared.state);
            shared.cells.gather(&self.from, 0, 1, state);
            self.along.run(by_parameters);
            self.known = Some(by_parameters);
        }
        &mut self.along
    }
}

/// Steps of a splitting with their differentials.
pub(super) struct SweptFlows {
    stepper: Box<dyn Stepper>,
    shared: Arc<Shared>,
    /// The step and its inverse; none where a flow has no derivative.
    ways: Option<[Way; 2]>,
    moved: Fields,
    parameters: usize,
}

impl SweptFlows {
    pub(super) fn new(
        stepper: Box<dyn Stepper>,
        shared: Arc<Shared>,
        parts: &[f64],
        parameters: &[f64],
        sizes: (f64, f64),
    ) -> Self {
        let flows = passes(&shared.order, parts);
        let back = flows.iter().rev().map(|flow| Flow {
            part: -flow.part,
            ..*flow
        });
        let step = Way::new(&shared, flows.iter().copied(), parameters, sizes);
        let inverse = Way::new(&shared, back, parameters, sizes);
        Self {
            stepper,
            ways: step.zip(inverse).map(|(step, inverse)| [step, inverse]),
            moved: shared.slopes.empty_fields(),
            parameters: parameters.len(),
            shared,
        }
    }

    fn pull_along(
        &mut self,
        way: usize,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        let ways = self.ways.as_mut().ok_or(StepError::NoTangent)?;
        let Shared { cells, state, .. } = self.shared.as_ref();
        let along = ways[way].find(&self.shared, !gradient.is_empty());
        cells.gather(covector, 0, 1, self.moved.get_mut(*state));
        along.pull(&mut self.moved, gradient);
        cells.scatter(self.moved.get(*state), covector, 0, 1);
        Ok(())
    }
}

impl Differential for SweptFlows {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        let mut outcome = [Ok(())];
        self.stepper.increment(x, low, increment, &mut outcome);
        let [outcome] = outcome;
        outcome?;
        if let Some([step, inverse]) = &mut self.ways {
            [step.known, inverse.known] = [None, None];
            step.from.copy_from_slice(x);
            let ends = x.iter().zip(&*increment).map(|(x, change)| x + change);
            inverse
                .from
                .iter_mut()
                .zip(ends)
                .for_each(|(to, end)| *to = end);
        }
        Ok(())
    }

    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        let [step, _] = self.ways.as_mut().ok_or(StepError::NoTangent)?;
        let Shared { cells, state, .. } = self.shared.as_ref();
        let (d, count) = (step.from.len(), self.parameters);
        let along = step.find(&self.shared, !parameters.is_empty());
        for (at, tangent) in tangents.chunks_exact_mut(d).enumerate() {
            let own = match parameters {
                [] => &[],
                all => &all[at * count..][..count],
            };
            cells.gather(tangent, 0, 1, self.moved.get_mut(*state));
            along.push(&mut self.moved, own);
            cells.scatter(self.moved.get(*state), tangent, 0, 1);
        }
        Ok(())
    }

    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        self.pull_along(0, covector, gradient)
    }

    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        self.pull_along(1, covector, gradient)
    }

    fn knows_parameters(&self) -> bool {
        self.ways
            .as_ref()
            .is_some_and(|[step, _]| step.along.knows_parameters())
    }

    fn operations(&self) -> Option<u64> {
        let own = self.ways.iter().flatten().map(|way| way.along.operations());
        Some(self.stepper.statistics().operations? + own.sum::<u64>())
    }
}
