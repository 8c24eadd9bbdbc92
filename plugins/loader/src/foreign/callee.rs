//! An instance that an evaluator calls, or the reason why there is none.

use std::sync::{Arc, Mutex};

use leafwise_core::part::ParameterSetting;
use leafwise_core::{BuildError, StepError};
use leafwise_plugin_abi::LwMapFn;

use super::batch::Output;
use super::failure::CallFailure;
use super::instance::{Call, Instance};
use super::making::{HostObjects, Making};
use super::part::ForeignPart;
use crate::floating_point::{ControlWord, note_change};

/// One evaluator's instance, or the failure of making it. Where it could not be made, every call returns that failure.
/// An evaluator is asked for at other values of the parameters than those that were served before; no refusal can be
/// given there any more.
pub(super) struct Callee {
    part: Arc<ForeignPart>,
    instance: Result<Instance, CallFailure>,
    /// Makes another instance.
    make: Box<Make>,
    /// Where the instance goes in the end, and the bits of the parameters that it is made for.
    idle: Idle,
    values: Vec<u64>,
    /// Whether several trajectories are served: where one breaks the instance the others go on with a
    /// new one.
    serves_several: bool,
    /// How this thread computes, and the calls since that was last looked at.
    control: ControlWord,
    calls: u8,
}

/// An instance, behind the bits of the parameters that it was made for.
type Kept = (Vec<u64>, Instance);

/// Instances that no evaluator uses at present, each with the values of the parameters that it was made for. Making one may take long, and
/// a run asks for some seventy evaluators, one after the other; results do not depend on what an instance was called for before.
#[derive(Clone, Debug, Default)]
pub(super) struct Idle(Arc<Mutex<Vec<Kept>>>);

/// Idle instances that are kept at most.
const MOST_IDLE: usize = 8;

impl Idle {
    fn take(&self, values: &[u64]) -> Option<Instance> {
        let mut idle = self.0.lock().ok()?;
        let at = idle.iter().position(|(of, _)| of == values)?;
        Some(idle.swap_remove(at).1)
    }

    fn keep(&self, values: Vec<u64>, instance: Instance) {
        let Ok(mut idle) = self.0.lock() else {
            return;
        };
        // The oldest one goes; ended outside the lock, as it may take long.
        let oldest = (idle.len() >= MOST_IDLE).then(|| idle.remove(0));
        idle.push((values, instance));
        drop(idle);
        drop(oldest);
    }
}

type Make = dyn Fn() -> Result<Instance, CallFailure> + Send;

/// After so many calls the control word is compared: reading it costs as much as a small call.
const BETWEEN_LOOKS: u8 = 64;

impl Callee {
    /// An idle instance for these parameters, or a new one with what `lend` lends it. It is made anew where one of several
    /// trajectories broke it.
    pub(super) fn new(
        part: &Arc<ForeignPart>,
        idle: &Idle,
        parameters: &[f64],
        (dimension, settings): (usize, Vec<(String, ParameterSetting)>),
        lend: impl Fn() -> Result<HostObjects, BuildError> + Send + 'static,
    ) -> Self {
        let own = Arc::clone(part);
        let make = move || {
            let making = Making {
                dimension,
                settings: &settings,
            };
            let lent = lend().map_err(|error| CallFailure::Unsupported {
                message: error.to_string(),
            })?;
            Instance::new(&own, making, lent)
        };
        let values: Vec<u64> = parameters.iter().map(|value| value.to_bits()).collect();
        Self {
            part: Arc::clone(part),
            control: ControlWord::read(),
            instance: idle.take(&values).map_or_else(&make, Ok),
            idle: idle.clone(),
            values,
            make: Box::new(make),
            serves_several: false,
            calls: 0,
        }
    }

    /// Evaluates a function, called `name` in messages. Inlined into its callers, as what it calls: what
    /// they know of a call is then no memory to fill and read.
    #[inline(always)]
    pub(super) fn evaluate(
        &mut self,
        name: &str,
        function: LwMapFn,
        call: &Call<'_>,
        output: Output<'_>,
    ) -> Result<(), StepError> {
        self.serves_several |= call.count > 1;
        let outcome = match &mut self.instance {
            Ok(instance) => instance.evaluate(function, call, output),
            Err(failure) => return Err(failure.clone().of_step(self.part.name(), "create")),
        };
        self.calls += 1;
        if self.calls == BETWEEN_LOOKS {
            self.look(name)?;
        }
        outcome.map_err(|failure| self.failed(name, failure))
    }

    /// Restores how this thread computes; an error where calls have changed it.
    #[cold]
    fn look(&mut self, name: &str) -> Result<(), StepError> {
        self.calls = 0;
        self.control.restore("called").map_err(|refusal| {
            let message = refusal.to_string();
            CallFailure::FloatingPoint { message }.of_step(self.part.name(), name)
        })
    }

    #[cold]
    fn failed(&mut self, name: &str, failure: CallFailure) -> StepError {
        if let (CallFailure::Broken { .. }, true) = (&failure, self.serves_several) {
            self.instance = (self.make)();
        }
        failure.of_step(self.part.name(), name)
    }
}

impl Drop for Callee {
    /// Restores how this thread computes and gives the instance back to the idle ones. A change by the last calls is
    /// only noted, as it can fail no call any more.
    fn drop(&mut self) {
        if let Err(refusal) = self.control.restore("called") {
            note_change(format!("{}: {refusal}", self.part.name()));
        }
        let message = String::new();
        let last = std::mem::replace(
            &mut self.instance,
            Err(CallFailure::Unsupported { message }),
        );
        if let Ok(instance) = last
            && !instance.is_broken()
        {
            self.idle.keep(std::mem::take(&mut self.values), instance);
        }
    }
}
