//! Step maps as numbers.

use std::mem::size_of;

use leafwise_plugin_abi::{LW_KIND_STEP_MAP, LwPart, LwStepMap};

use crate::fail::Fail;
use crate::instance::{Part, lifecycle};
use crate::map::{Steps, map, maps, optional};

/// A step map Φ_{ε,h}: M → M that needs no realization. Implicit maps start each solve from x alone.
pub trait StepMap: Part {
    /// Whether [`tangent`](Self::tangent) is offered: the tensor defect needs it.
    const TANGENT: bool = false;
    /// Φ(x + low) − (x + low), d numbers, formed without adding x back. The vector `low`, d numbers
    /// or empty, holds the part of the host's compensated state beyond a double, less than an ulp
    /// of x. A map may ignore it.
    ///
    /// # Errors
    /// [`Fail::Outside`] where the map is not defined or a solve does not converge.
    fn increment(
        &mut self,
        steps: Steps,
        x: &[f64],
        low: &[f64],
        out: &mut [f64],
    ) -> Result<(), Fail>;
    /// DΦ(x), d × d numbers, row-major, exact through any inner solve.
    ///
    /// # Errors
    /// As [`increment`](Self::increment).
    fn tangent(&mut self, steps: Steps, x: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (steps, x, out);
        Err(Fail::unsupported("no tangent of the step map"))
    }
}

maps! { StepMap:
    Increment = |part, at, out| part.increment(at.steps, at.point, at.v, out);
    Tangent = |part, at, out| part.tangent(at.steps, at.point, out);
}

struct Table<T>(T);
impl<T: StepMap> Table<T> {
    const FUNCTIONS: &'static LwStepMap = &LwStepMap {
        struct_size: size_of::<LwStepMap>() as u32,
        reserved: 0,
        life: lifecycle::<T>(),
        increment: map::<T, Increment>(),
        tangent: optional::<T, Tangent>(T::TANGENT),
    };
}

/// The entry of a step map in a plugin's list.
pub const fn step_map_part<T: StepMap>() -> LwPart {
    let mut part = T::INFO.part(LW_KIND_STEP_MAP);
    part.functions = std::ptr::from_ref(Table::<T>::FUNCTIONS).cast();
    part
}
