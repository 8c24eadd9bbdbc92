//! An instance that a worker calls, or the reason why there is none.

use std::sync::Arc;

use leafwise_core::StepError;
use leafwise_plugin_abi::LwMapFn;

use super::batch::Output;
use super::failure::CallFailure;
use super::instance::{Call, Instance, Lent, Making};
use super::part::ForeignPart;

/// One worker's instance. Where it could not be made, every call says why: a worker is asked for
/// where no refusal can be given any more, for other values of parameters that did well before.
pub(super) struct Callee {
    part: Arc<ForeignPart>,
    instance: Result<Instance, CallFailure>,
}

impl Callee {
    pub(super) fn new(
        part: &Arc<ForeignPart>,
        making: Making<'_>,
        lent: Result<Lent, CallFailure>,
    ) -> Self {
        Self {
            part: Arc::clone(part),
            instance: lent.and_then(|lent| Instance::new(part, making, lent)),
        }
    }

    /// Evaluates a function, called `name` in messages.
    #[inline]
    pub(super) fn evaluate(
        &mut self,
        name: &str,
        function: LwMapFn,
        call: &Call<'_>,
        output: Output<'_>,
    ) -> Result<(), StepError> {
        let part = self.part.name();
        match &mut self.instance {
            Ok(instance) => instance
                .evaluate(function, call, output)
                .map_err(|failure| failure.of_step(part, name)),
            Err(failure) => Err(failure.clone().of_step(part, "create")),
        }
    }
}
