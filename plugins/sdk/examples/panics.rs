//! A plugin for the loader's tests: a step map that panics whenever it is called.

use leafwise_plugin_sdk::{Create, Fail, Info, Part, StepMap, Steps, export_plugin};

struct Panics;

impl Part for Panics {
    const INFO: Info = Info::new(c"panics/always", c"indexes an empty list").order(1);

    fn create(_: &Create<'_>) -> Result<Self, Fail> {
        Ok(Self)
    }
}

impl StepMap for Panics {
    fn increment(&mut self, _: Steps, x: &[f64], _: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        out[0] = x[..0][x.len()];
        Ok(())
    }
}

export_plugin! { id: "panics", license: "MIT OR Apache-2.0", parts: [step_map Panics] }
