//! An instance that an evaluator calls, or the reason why there is none.

use std::sync::Arc;

use leafwise_core::StepError;
use leafwise_plugin_abi::LwMapFn;

use super::batch::Output;
use super::failure::CallFailure;
use super::instance::{Call, Instance};
use super::part::ForeignPart;
use crate::floating_point::{ControlWord, note_change};

/// One evaluator's instance. Where it could not be made, every call says why: an evaluator is asked for
/// where no refusal can be given any more, for other values of parameters that did well before.
pub(super) struct Callee {
    part: Arc<ForeignPart>,
    instance: Result<Instance, CallFailure>,
    /// Makes another instance.
    make: Box<Make>,
    /// Whether several trajectories are served: where one breaks the instance the others go on with a
    /// new one.
    serves_several: bool,
    /// How this thread computes, and the calls since that was last looked at.
    control: ControlWord,
    calls: u8,
}

type Make = dyn Fn() -> Result<Instance, CallFailure> + Send;

/// After so many calls the control word is compared: reading it costs as much as a small call.
const BETWEEN_LOOKS: u8 = 64;

impl Callee {
    /// An instance as `make` makes it, and makes it anew where one of several trajectories broke it.
    pub(super) fn new(
        part: &Arc<ForeignPart>,
        make: impl Fn() -> Result<Instance, CallFailure> + Send + 'static,
    ) -> Self {
        Self {
            part: Arc::clone(part),
            control: ControlWord::read(),
            instance: make(),
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
    /// What the last calls changed can fail no call any more.
    fn drop(&mut self) {
        if let Err(refusal) = self.control.restore("called") {
            note_change(format!("{}: {refusal}", self.part.name()));
        }
    }
}
