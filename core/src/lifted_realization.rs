//! Realizations that are coordinates with a constant tensor and nothing else.

use std::sync::Arc;

use crate::lift::Lift;
use crate::realization::{Abilities, Accuracy, RealizationData};

/// The realization data (ℝⁿ, Ω, J) of a [`Lift`]: J stands in the place of α.
#[derive(Clone, Debug)]
pub struct LiftedRealization {
    description: String,
    dimension: usize,
    lift: Arc<dyn Lift>,
}

impl LiftedRealization {
    /// The realization of a tensor in `dimension` coordinates x; `description` is its line in reports.
    pub fn new(
        description: impl Into<String>,
        dimension: usize,
        lift: impl Lift + 'static,
    ) -> Self {
        Self {
            description: description.into(),
            dimension,
            lift: Arc::new(lift),
        }
    }
}

impl RealizationData for LiftedRealization {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        self.description.clone()
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            lift: Some(Arc::clone(&self.lift)),
            ..Abilities::default()
        }
    }
}
