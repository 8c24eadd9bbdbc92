//! An epidemic as a Poisson system.

use std::ffi::CStr;

use leafwise_plugin_sdk::{Create, Fail, Info, Parameter, Part, System};

/// Kermack and McKendrick's epidemic, susceptible S, infected I, removed R:
///
/// Ṡ = −r S I,  İ = r S I − a I,  Ṙ = a I,
///
/// with {S, I} = {I, R} = {R, S} = −r S I, H = R + (a/r) ln S and the Casimir S + I + R (Nutku,
/// J. Phys. A 23 (1990) L1145).
pub struct Epidemic {
    infection: f64,
    removal: f64,
}

impl Part for Epidemic {
    const INFO: Info = Info::new(c"example/epidemic", c"Kermack and McKendrick's epidemic")
        .domain(c"S > 0; infection > 0")
        .reference(c"Nutku, J. Phys. A 23 (1990) L1145-L1146")
        .parameters(&[
            Parameter::new(c"infection", c"r > 0, infections a contact", c"2.0"),
            Parameter::new(c"removal", c"a, the rate of removal", c"0.5"),
        ]);

    fn create(args: &Create<'_>) -> Result<Self, Fail> {
        let (infection, removal) = (args.real("infection")?, args.real("removal")?);
        if !(infection > 0.0 && infection.is_finite()) {
            return Err(Fail::unsupported(format!(
                "infection = {infection}: a positive number is needed"
            )));
        }
        Ok(Self { infection, removal })
    }
}

impl System for Epidemic {
    const TANGENTS: bool = true;
    const CASIMIR_GRADIENTS: bool = true;

    fn dimension(&self) -> usize {
        3
    }

    fn variables(&self) -> &'static [&'static CStr] {
        &[c"S", c"I", c"R"]
    }

    fn tensor(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let f = -self.infection * y[0] * y[1];
        out[0] = f * (v[1] - v[2]);
        out[1] = f * (v[2] - v[0]);
        out[2] = f * (v[0] - v[1]);
        Ok(())
    }

    fn hamiltonian(&mut self, y: &[f64]) -> Result<f64, Fail> {
        positive(y)?;
        Ok(y[2] + self.removal / self.infection * libm::log(y[0]))
    }

    fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        positive(y)?;
        out[0] = self.removal / self.infection / y[0];
        out[1] = 0.0;
        out[2] = 1.0;
        Ok(())
    }

    fn casimir_names(&self) -> &'static [&'static CStr] {
        &[c"population"]
    }

    fn casimirs(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        out[0] = y[0] + y[1] + y[2];
        Ok(())
    }

    fn casimir_gradients(&mut self, _y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        out.fill(1.0);
        Ok(())
    }

    fn tensor_tangent(
        &mut self,
        y: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> Result<(), Fail> {
        let f = -self.infection * (w[0] * y[1] + y[0] * w[1]);
        out[0] = f * (v[1] - v[2]);
        out[1] = f * (v[2] - v[0]);
        out[2] = f * (v[0] - v[1]);
        Ok(())
    }

    fn hessian(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        positive(y)?;
        out.fill(0.0);
        out[0] = -self.removal / self.infection / (y[0] * y[0]) * v[0];
        Ok(())
    }
}

fn positive(y: &[f64]) -> Result<(), Fail> {
    if y[0] > 0.0 {
        return Ok(());
    }
    Err(Fail::outside(
        0.0,
        format!("S = {}: the epidemic is defined for S > 0", y[0]),
    ))
}
