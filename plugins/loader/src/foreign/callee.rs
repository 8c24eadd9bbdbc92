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
    /// What makes another instance, and whether several trajectories are served: where one breaks it the
    /// others go on with a new one.
    make: Option<Box<Make>>,
    serves_several: bool,
}

type Make = dyn Fn() -> Result<Instance, CallFailure> + Send;

impl Callee {
    pub(super) fn new(
        part: &Arc<ForeignPart>,
        making: Making<'_>,
        lent: Result<Lent, CallFailure>,
    ) -> Self {
        Self {
            part: Arc::clone(part),
            instance: lent.and_then(|lent| Instance::new(part, making, lent)),
            make: None,
            serves_several: false,
        }
    }

    /// An instance for points of several trajectories, which `make` makes anew where one of them broke
    /// it.
    pub(super) fn shared(
        part: &Arc<ForeignPart>,
        make: impl Fn() -> Result<Instance, CallFailure> + Send + 'static,
    ) -> Self {
        Self {
            part: Arc::clone(part),
            instance: make(),
            make: Some(Box::new(make)),
            serves_several: false,
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
        outcome.map_err(|failure| self.failed(name, failure))
    }

    #[cold]
    fn failed(&mut self, name: &str, failure: CallFailure) -> StepError {
        if let (CallFailure::Broken { .. }, true, Some(make)) =
            (&failure, self.serves_several, &self.make)
        {
            self.instance = make();
        }
        failure.of_step(self.part.name(), name)
    }
}
