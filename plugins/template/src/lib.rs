//! A plugin with one system: rename `my`, replace the oscillator, add parts.

use leafwise_plugin_sdk::{Create, Fail, Info, Parameter, Part, System, export_plugin};

/// The harmonic oscillator: {q, p} = −1, H = (p² + ω² q²)/2, so that q̇ = p, ṗ = −ω² q.
struct Oscillator {
    omega: f64,
}

impl Part for Oscillator {
    const INFO: Info = Info::new(c"my/oscillator", c"harmonic oscillator").parameters(&[
        Parameter::new(c"omega", c"angular frequency", c"1.0"),
    ]);

    fn create(args: &Create<'_>) -> Result<Self, Fail> {
        Ok(Self {
            omega: args.real("omega")?,
        })
    }
}

impl System for Oscillator {
    fn dimension(&self) -> usize {
        2
    }

    // Π(y)·v with Π_12 = {q, p} = −1.
    fn tensor(&mut self, _y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        out[0] = -v[1];
        out[1] = v[0];
        Ok(())
    }

    fn hamiltonian(&mut self, y: &[f64]) -> Result<f64, Fail> {
        let (q, p) = (self.omega * y[0], y[1]);
        Ok(0.5 * (p * p + q * q))
    }

    fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        out[0] = self.omega * self.omega * y[0];
        out[1] = y[1];
        Ok(())
    }
}

export_plugin! { id: "my", license: "MIT OR Apache-2.0", parts: [system Oscillator] }
