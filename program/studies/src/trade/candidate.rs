//! A method on a scene, ready to be run at any setting.

use std::borrow::Cow;
use std::fmt;

use leafwise_core::part::{ParameterDefault, ParameterInfo, ParameterSetting, PartKind};
use leafwise_core::{MapProperties, Registry};
use leafwise_expression::words::counted;
use leafwise_scene::compose::{refuse_acts, refuse_noise};
use leafwise_scene::document::{MethodParts, MethodTable, PartUse};
use leafwise_scene::json::optional;
use leafwise_scene::{ComposedRun, SceneDocument, compose};
use serde::Serialize;

use super::arrival::way;
use super::error::TradeError;

/// Parameters that are always named.
const ORDERS: [&str; 3] = ["order", "stages", "tolerance"];

/// Beyond, numbers of steps are no whole doubles any more on the finest of the grids.
const MOST_STEPS: f64 = (1_u64 << 40) as f64;

/// A scene on which methods are compared.
pub struct Bench<'a> {
    document: &'a SceneDocument,
    registry: &'a Registry,
    own: ComposedRun,
    time: f64,
    extent: f64,
    steps: u64,
}

impl<'a> Bench<'a> {
    /// Takes a scene's system and initial state over `time`, or to the scene's own end time.
    ///
    /// # Errors
    /// Returns [`TradeError::Refused`] with the scene's first error. Returns [`TradeError::NoTime`] for a run that ends
    /// where it begins, and [`TradeError::TooLong`] for one of more than 2⁴⁰ steps. Of a table it is [`TradeError::OneLength`].
    pub fn new(
        document: &'a SceneDocument,
        registry: &'a Registry,
        time: Option<f64>,
    ) -> Result<Self, TradeError> {
        refuse_noise(
            document,
            "methods are not compared by their errors on the motion",
            "compare them on a copy of the scene without noise",
        )
        .map_err(TradeError::Refused)?;
        if let Some(stop) = &document.run.stop {
            return Err(TradeError::Refused(Box::new(document.diagnostic(
                &stop.place(),
                "methods are not compared with a `stop`: they are compared at one time, which a run that stops may not reach",
                "here",
                Some("compare methods on a copy of the scene without it".to_owned()),
            ))));
        }
        refuse_acts(
            document,
            "methods are not compared",
            "compare methods on a copy of the scene without `set`",
        )
        .map_err(TradeError::Refused)?;
        let own = compose(document, registry)?;
        if let Some(length) = own.table_step() {
            return Err(TradeError::OneLength { length });
        }
        let step = own.plan.epsilon * own.plan.h;
        let (time, extent) = match own.time_place() {
            None => {
                let time = time.unwrap_or(own.plan.steps as f64 * step);
                (time, time)
            }
            Some(place) => way(&own, place, time.or(own.plan.until))?,
        };
        if !time.is_finite() || time == 0.0 {
            return Err(TradeError::NoTime { time });
        }
        let steps = libm::round((extent / step).abs()).max(1.0);
        if steps > MOST_STEPS {
            return Err(TradeError::TooLong { time, steps });
        }
        let steps = steps as u64;
        Ok(Self {
            document,
            registry,
            own,
            time,
            extent,
            steps,
        })
    }

    /// The same over another time.
    ///
    /// # Errors
    /// Those of [`Bench::new`].
    pub fn over(&self, time: f64) -> Result<Self, TradeError> {
        Self::new(self.document, self.registry, Some(time))
    }

    /// The scene.
    pub fn document(&self) -> &SceneDocument {
        self.document
    }

    /// The parts that methods are built of.
    pub fn registry(&self) -> &Registry {
        self.registry
    }

    /// The part of a kind that serves every system, to this order.
    pub(super) fn of_order(&self, kind: PartKind, order: usize) -> PartUse {
        let part = self.registry.of_order(kind);
        PartUse::named(part.map_or("auto", |info| info.name)).with("order", order as i64)
    }

    /// The scene with its own method.
    pub fn own(&self) -> &ComposedRun {
        &self.own
    }

    /// The scene's own method, `auto` replaced by what was taken.
    pub fn own_method(&self) -> Option<MethodTable> {
        self.resolved(&self.own)
    }

    /// The method of a composed scene, without parameters that have their usual values and are no
    /// orders.
    fn resolved(&self, run: &ComposedRun) -> Option<MethodTable> {
        let mut method = MethodTable::of_choices(&run.plan.parts)?;
        let infos = self.registry.parts();
        let simplify = |part: &mut PartUse| {
            let info = infos.iter().find(|info| info.name == part.name);
            part.parameters.retain(|(name, value)| {
                let known = info.and_then(|i| i.parameters.iter().find(|p| p.name == name));
                let usual = known.map(|p| ParameterSetting::from(p.default));
                ORDERS.contains(&name.as_str()) || usual.as_ref() != Some(value)
            });
        };
        match &mut method.parts {
            MethodParts::Stepper(stepper) => simplify(stepper),
            MethodParts::Pair {
                realization,
                dynamics,
            } => {
                simplify(realization);
                simplify(dynamics);
            }
        }
        if let Some(composition) = &mut method.composition {
            simplify(composition);
        }
        Some(method)
    }

    /// The time over which methods are compared.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Length that the steps divide: the time, or with a pace the fictitious time τ that its method takes to come
    /// there.
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// The number of steps that the scene's own step makes of it.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The names of the invariants: the energy, then the Casimirs.
    pub fn invariants(&self) -> Vec<String> {
        let casimirs = self.own.system.casimir_names().into_iter();
        std::iter::once("energy")
            .chain(casimirs)
            .map(str::to_owned)
            .collect()
    }

    /// The scene with another method, as it would be run.
    ///
    /// # Errors
    /// Why the method does not fit, in words.
    pub fn compose(
        &self,
        method: &MethodTable,
        time_step: f64,
        steps: u64,
    ) -> Result<ComposedRun, String> {
        let text = method
            .write_into(&self.document.text, time_step, steps)
            .map_err(|error| error.to_string())?;
        let document = SceneDocument::parse(&self.document.name, &text, self.registry)
            .map_err(|error| error.to_string())?;
        compose(&document, self.registry).map_err(|refusal| refusal.line())
    }
}

/// Quantity that is varied to trade cost for accuracy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knob {
    /// The number of steps.
    Steps,
    /// The tolerance of a method that chooses its own steps inside each step of the scene.
    Tolerance,
}

/// One choice of what is varied.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// The number of steps.
    pub steps: u64,
    /// The tolerance, for an adaptive method.
    #[serde(serialize_with = "optional")]
    pub tolerance: Option<f64>,
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.tolerance {
            Some(tolerance) => write!(f, "tolerance {tolerance:e}"),
            None => f.write_str(&counted(self.steps as usize, "step")),
        }
    }
}

/// A method that fits a scene.
pub struct Candidate {
    /// The method; an adaptive one without its tolerance.
    pub method: MethodTable,
    /// Quantity that is varied: steps or tolerance.
    pub knob: Knob,
    /// One line: parts and orders.
    pub name: String,
    /// Properties that the method declares: order, structure, symmetry.
    pub properties: MapProperties,
    /// The method built; for an adaptive one at the default tolerance.
    pub run: ComposedRun,
}

/// The parameter by which a stepper chooses its own steps.
const TOLERANCE: &str = "tolerance";

impl Candidate {
    /// Builds a method for a scene; `auto` is replaced by what is taken.
    ///
    /// # Errors
    /// Why it does not fit, in words.
    pub fn build(bench: &Bench<'_>, method: &MethodTable) -> Result<Self, String> {
        let time_step = bench.extent / bench.steps as f64;
        let run = bench.compose(method, time_step, bench.steps)?;
        let knob = knob(bench.registry, method);
        let resolved = bench.resolved(&run);
        let method = match knob {
            Knob::Steps => resolved.unwrap_or_else(|| method.clone()),
            Knob::Tolerance => method.clone(),
        };
        Ok(Self {
            name: method.to_string(),
            properties: run.method.map().properties(),
            method,
            knob,
            run,
        })
    }

    /// The method at a setting, as a scene would say it.
    pub fn method_at(&self, setting: Setting) -> MethodTable {
        let mut method = self.method.clone();
        if let (Some(tolerance), MethodParts::Stepper(stepper)) =
            (setting.tolerance, &mut method.parts)
        {
            *stepper = stepper.clone().with(TOLERANCE, tolerance);
        }
        method
    }

    /// The method built for a setting: itself, or an adaptive one at its tolerance.
    ///
    /// # Errors
    /// Why it does not fit, in words.
    pub fn run_at(
        &self,
        bench: &Bench<'_>,
        setting: Setting,
    ) -> Result<Cow<'_, ComposedRun>, String> {
        if setting.tolerance.is_none() {
            return Ok(Cow::Borrowed(&self.run));
        }
        let time_step = bench.extent / setting.steps as f64;
        let run = bench.compose(&self.method_at(setting), time_step, setting.steps)?;
        Ok(Cow::Owned(run))
    }
}

/// An adaptive stepper whose tolerance is left open is varied by it.
fn knob(registry: &Registry, method: &MethodTable) -> Knob {
    let MethodParts::Stepper(stepper) = &method.parts else {
        return Knob::Steps;
    };
    let is_adaptive = registry.parts().into_iter().any(|info| {
        let takes = |p: &ParameterInfo| {
            p.name == TOLERANCE && matches!(p.default, ParameterDefault::Real(_))
        };
        info.kind == PartKind::Stepper
            && info.name == stepper.name
            && info.parameters.iter().any(takes)
    });
    if is_adaptive && stepper.parameter(TOLERANCE).is_none() && method.composition.is_none() {
        Knob::Tolerance
    } else {
        Knob::Steps
    }
}
