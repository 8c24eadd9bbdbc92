//! The parts `so3-exponential`, `so3-cayley` and `so3-group`.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem, RealizationData};

use crate::chart::Chart;
use crate::cotangent::So3Cotangent;
use crate::group::So3Group;

const LITERATURE: &str = "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic \
                          Realizations, section 2; Marsden, Ratiu, Introduction to Mechanics and \
                          Symmetry, chapters 13 and 15";

static EXPONENTIAL: PartInfo = PartInfo {
    name: "so3-exponential",
    kind: PartKind::Realization,
    summary: "T*SO(3) in the exponential chart: Karasev's realization of so(3)*, summed",
    declares: "exact; self-adjoint",
    domain: "{x1,x2} = -a x3 cyclic with constant a of either sign; eps*|a|*|p| < 2 pi, checked",
    literature: LITERATURE,
    parameters: &[],
};

static CAYLEY: PartInfo = PartInfo {
    name: "so3-cayley",
    kind: PartKind::Realization,
    summary: "T*SO(3) in the Cayley chart: rational, of degree two in p",
    declares: "exact; self-adjoint",
    domain: "{x1,x2} = -a x3 cyclic with constant a of either sign; every p",
    literature: LITERATURE,
    parameters: &[],
};

pub(crate) static GROUP: PartInfo = PartInfo {
    name: "so3-group",
    kind: PartKind::Realization,
    summary: "T*SO(3) as pairs of a unit quaternion and a momentum",
    declares: "exact; self-adjoint",
    domain: "{x1,x2} = -a x3 cyclic with constant a of either sign; every rotation, in the \
             exponential chart those by an angle below 2 pi, checked",
    literature: LITERATURE,
    parameters: &[ParameterInfo {
        name: "chart",
        summary: "the chart of rotations about the section: cayley or exponential",
        default: ParameterDefault::Text("cayley"),
    }],
};

/// The name of the part on T*M in this chart.
pub(crate) fn cotangent_name(chart: Chart) -> &'static str {
    match chart {
        Chart::Exponential => EXPONENTIAL.name,
        Chart::Cayley => CAYLEY.name,
    }
}

struct Cotangent(Chart);

impl RealizationPart for Cotangent {
    fn info(&self) -> &'static PartInfo {
        match self.0 {
            Chart::Exponential => &EXPONENTIAL,
            Chart::Cayley => &CAYLEY,
        }
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError> {
        parameters.refuse_unknown(self.info())?;
        Ok(Arc::new(So3Cotangent::new(system, self.0)?))
    }
}

struct Group;

impl RealizationPart for Group {
    fn info(&self) -> &'static PartInfo {
        &GROUP
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError> {
        let chart = match parameters.word(&GROUP, "chart", &["cayley", "exponential"])? {
            "cayley" => Chart::Cayley,
            _ => Chart::Exponential,
        };
        Ok(Arc::new(So3Group::new(system, chart)?))
    }
}

leafwise_core::built_in!(Realization, Cotangent(Chart::Exponential));
leafwise_core::built_in!(Realization, Cotangent(Chart::Cayley));
leafwise_core::built_in!(Realization, Group);
