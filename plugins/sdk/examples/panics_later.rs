//! A plugin for the loader's tests: a step map that panics far from where it is tried.

use leafwise_plugin_sdk::{Create, Fail, Info, Part, StepMap, Steps, export_plugin};

/// Φ(x) = x + ε h e_1 where x1 < 2.
struct Later;

impl Part for Later {
    const INFO: Info = Info::new(c"panics/later", c"panics where x1 is 2 or more").order(1);

    fn create(_: &Create<'_>) -> Result<Self, Fail> {
        Ok(Self)
    }
}

impl StepMap for Later {
    fn increment(
        &mut self,
        steps: Steps,
        x: &[f64],
        _: &[f64],
        out: &mut [f64],
    ) -> Result<(), Fail> {
        assert!(x[0] < 2.0, "x1 = {} is too large", x[0]);
        out.fill(0.0);
        out[0] = steps.epsilon * steps.h;
        Ok(())
    }
}

export_plugin! { id: "panics", license: "MIT OR Apache-2.0", parts: [step_map Later] }
