//! Realization data as numbers.

use std::ffi::c_void;
use std::mem::size_of;

use leafwise_plugin_abi::{LW_FLAG_COTANGENT_CHART, LW_KIND_REALIZATION, LwPart, LwRealization};

use crate::fail::Fail;
use crate::instance::{Instance, Part, lifecycle};
use crate::map::{map, maps, optional};

/// Realization data (S, ω, α̂_ε, β̂_ε, σ) of (M, επ): α̂ Poisson, β̂ anti-Poisson, exactly or to the
/// declared order, α̂∘σ = β̂∘σ = id. In a cotangent chart implement
/// [`ChartRealization`](crate::ChartRealization) instead.
///
/// Points z of S have d_S numbers. Outside the domain maps return [`Fail::Outside`], never a number.
pub trait Realization: Part {
    /// Whether [`ends`](Self::ends) is offered: it saves a few units of round-off a step.
    const ENDS: bool = false;
    /// Whether [`alpha_jacobian`](Self::alpha_jacobian) and
    /// [`beta_with_jacobian`](Self::beta_with_jacobian) are offered.
    const JACOBIANS: bool = false;
    /// Whether [`ends_jacobian`](Self::ends_jacobian) is offered.
    const ENDS_JACOBIAN: bool = false;
    /// Whether [`domain`](Self::domain) is offered.
    const DOMAIN: bool = false;
    /// Whether [`chart`](Self::chart) is offered.
    const CHART: bool = false;
    /// Whether [`chart_jacobian`](Self::chart_jacobian) is offered.
    const CHART_JACOBIAN: bool = false;

    /// d_S.
    fn space_dimension(&self) -> usize;
    /// α̂_ε(z), d numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the domain.
    fn alpha(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail>;
    /// β̂_ε(z), d numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the domain.
    fn beta(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail>;
    /// σ(x), d_S numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] where x is outside M.
    fn sigma(&mut self, x: &[f64], out: &mut [f64]) -> Result<(), Fail>;
    /// A base point near both ends, β̂ − base, α̂ − β̂: 3 d numbers. The last two are formed
    /// directly and not as differences of the ends.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the domain.
    fn ends(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (epsilon, z, out);
        Err(missing("ends"))
    }
    /// Dα̂(z), d × d_S numbers, row-major.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the domain.
    fn alpha_jacobian(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (epsilon, z, out);
        Err(missing("alpha_jacobian"))
    }
    /// β̂(z), then Dβ̂(z): d + d × d_S numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the domain.
    fn beta_with_jacobian(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (epsilon, z, out);
        Err(missing("beta_with_jacobian"))
    }
    /// Dβ̂(z), then D(α̂ − β̂)(z): 2 × d × d_S numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the domain.
    fn ends_jacobian(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (epsilon, z, out);
        Err(missing("ends_jacobian"))
    }
    /// How far z is from σ over how far the domain reaches there: less than 1 inside.
    ///
    /// # Errors
    /// None is expected.
    fn domain(&mut self, epsilon: f64, z: &[f64]) -> Result<f64, Fail> {
        let _ = (epsilon, z);
        Err(missing("domain"))
    }
    /// The symplectic chart χ(x, p) about σ, χ(x, 0) = σ(x): d_S numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the chart.
    fn chart(&mut self, epsilon: f64, x: &[f64], p: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (epsilon, x, p, out);
        Err(missing("chart"))
    }
    /// Dχ(x, p), d_S × 2 d numbers, the columns of x first.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the chart.
    fn chart_jacobian(
        &mut self,
        epsilon: f64,
        x: &[f64],
        p: &[f64],
        out: &mut [f64],
    ) -> Result<(), Fail> {
        let _ = (epsilon, x, p, out);
        Err(missing("chart_jacobian"))
    }
}

fn missing(what: &str) -> Fail {
    Fail::unsupported(format!("the realization offers no `{what}`"))
}

maps! { Realization:
    Alpha = |part, at, out| part.alpha(at.steps.epsilon, at.point, out);
    Beta = |part, at, out| part.beta(at.steps.epsilon, at.point, out);
    Sigma = |part, at, out| part.sigma(at.point, out);
    Ends = |part, at, out| part.ends(at.steps.epsilon, at.point, out);
    AlphaJacobian = |part, at, out| part.alpha_jacobian(at.steps.epsilon, at.point, out);
    BetaWithJacobian = |part, at, out| part.beta_with_jacobian(at.steps.epsilon, at.point, out);
    EndsJacobian = |part, at, out| part.ends_jacobian(at.steps.epsilon, at.point, out);
    Domain = |part, at, out| {
        out[0] = part.domain(at.steps.epsilon, at.point)?;
        Ok(())
    };
    Chart = |part, at, out| part.chart(at.steps.epsilon, at.point, at.v, out);
    ChartJacobian = |part, at, out| part.chart_jacobian(at.steps.epsilon, at.point, at.v, out);
}

struct Table<T>(T);

impl<T: Realization> Table<T> {
    const FUNCTIONS: &'static LwRealization = &LwRealization {
        struct_size: size_of::<LwRealization>() as u32,
        reserved: 0,
        life: lifecycle::<T>(),
        space_dimension: Some(space_dimension::<T>),
        alpha: map::<T, Alpha>(),
        beta: map::<T, Beta>(),
        sigma: optional::<T, Sigma>(!T::INFO.has(LW_FLAG_COTANGENT_CHART)),
        ends: optional::<T, Ends>(T::ENDS),
        alpha_jacobian: optional::<T, AlphaJacobian>(T::JACOBIANS),
        beta_with_jacobian: optional::<T, BetaWithJacobian>(T::JACOBIANS),
        ends_jacobian: optional::<T, EndsJacobian>(T::ENDS_JACOBIAN),
        domain: optional::<T, Domain>(T::DOMAIN),
        chart: optional::<T, Chart>(T::CHART),
        chart_jacobian: optional::<T, ChartJacobian>(T::CHART_JACOBIAN),
    };
}

/// The entry of a realization in a plugin's list.
pub const fn realization_part<T: Realization>() -> LwPart {
    let mut part = T::INFO.part(LW_KIND_REALIZATION);
    part.functions = std::ptr::from_ref(Table::<T>::FUNCTIONS).cast();
    part
}

unsafe extern "C" fn space_dimension<T: Realization>(instance: *mut c_void) -> usize {
    // SAFETY: NULL, or what `create::<T>` made.
    let instance = unsafe { instance.cast::<Instance<T>>().as_ref() };
    let read = std::panic::AssertUnwindSafe(|| instance.map(|i| i.part.space_dimension()));
    match std::panic::catch_unwind(read) {
        Ok(value) => value.unwrap_or(0),
        Err(payload) => {
            std::mem::forget(payload);
            0
        }
    }
}
