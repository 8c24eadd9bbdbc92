//! The host's own maps, for a part to call.

use std::ffi::{CStr, c_char, c_void};

use leafwise_plugin_abi::{
    LW_DISCARD, LW_FLAG_COTANGENT_CHART, LW_FLAG_EXACT, LW_OK, LW_UNSUPPORTED, LwError,
    LwHostRealization, LwHostSystem, LwInput, LwMapCall, LwMapFn, LwOutput,
};

use crate::fail::Fail;

/// The Poisson system that a part serves, its parameters fixed. Keep it in the instance: it stays
/// valid as long as that; call it only from the part's own functions.
#[derive(Clone, Copy, Debug)]
pub struct HostSystem {
    raw: *const LwHostSystem,
    dimension: usize,
}

// SAFETY: the host lets a part use its system on whichever thread it calls the part.
unsafe impl Send for HostSystem {}

impl HostSystem {
    pub(crate) fn new(raw: *const LwHostSystem, dimension: usize) -> Result<Self, Fail> {
        // SAFETY: NULL, or the host's system.
        let functions = unsafe { raw.as_ref() }.map(|system| system.functions);
        match functions {
            Some(functions) if !functions.is_null() => Ok(Self { raw, dimension }),
            _ => Err(Fail::unsupported("the host gave no system")),
        }
    }

    /// d.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Π(y)·v, d numbers, Π_ij = {x_i, x_j}.
    ///
    /// # Errors
    /// What the host's map says.
    pub fn tensor(&self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (instance, functions) = self.table();
        call(functions.tensor, "Π(y)·v", instance, 1.0, [y, v, &[]], out)
    }

    /// H(y).
    ///
    /// # Errors
    /// What the host's map says.
    pub fn hamiltonian(&self, y: &[f64]) -> Result<f64, Fail> {
        let (instance, functions) = self.table();
        let mut value = [0.0];
        let function = functions.hamiltonian;
        call(function, "H", instance, 1.0, [y, &[], &[]], &mut value)?;
        Ok(value[0])
    }

    /// ∇H(y), d numbers.
    ///
    /// # Errors
    /// What the host's map says.
    pub fn gradient(&self, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (instance, functions) = self.table();
        call(functions.gradient, "∇H", instance, 1.0, [y, &[], &[]], out)
    }

    /// Σ_jk ∂_k Π_ij(y) v_j w_k, d numbers.
    ///
    /// # Errors
    /// [`Fail::Unsupported`] where the system is given by numbers alone.
    pub fn tensor_tangent(
        &self,
        y: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> Result<(), Fail> {
        let (instance, functions) = self.table();
        let function = functions.tensor_tangent;
        call(function, "D(Π(y)·v)·w", instance, 1.0, [y, v, w], out)
    }

    /// D²H(y)·v, d numbers.
    ///
    /// # Errors
    /// [`Fail::Unsupported`] where the system is given by numbers alone.
    pub fn hessian(&self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (instance, functions) = self.table();
        call(functions.hessian, "D²H·v", instance, 1.0, [y, v, &[]], out)
    }

    fn table(&self) -> (*mut c_void, &leafwise_plugin_abi::LwSystem) {
        // SAFETY: checked in `new`; the host keeps both alive as long as the instance.
        unsafe { ((*self.raw).instance, &*(*self.raw).functions) }
    }
}

/// The realization that a dynamic approximation serves; kept and called as [`HostSystem`].
#[derive(Clone, Copy, Debug)]
pub struct HostRealization {
    raw: *const LwHostRealization,
}

// SAFETY: the host lets a part use its realization on whichever thread it calls the part.
unsafe impl Send for HostRealization {}

impl HostRealization {
    pub(crate) fn new(raw: *const LwHostRealization) -> Result<Self, Fail> {
        // SAFETY: NULL, or the host's realization.
        let functions = unsafe { raw.as_ref() }.map(|realization| realization.functions);
        match functions {
            Some(functions) if !functions.is_null() => Ok(Self { raw }),
            _ => Err(Fail::unsupported("the host gave no realization")),
        }
    }

    /// Whether α̂ is Poisson to round-off.
    pub fn is_exact(&self) -> bool {
        self.flags() & LW_FLAG_EXACT != 0
    }

    /// Whether points of S are pairs (x, p) with σ(x) = (x, 0).
    pub fn has_cotangent_chart(&self) -> bool {
        self.flags() & LW_FLAG_COTANGENT_CHART != 0
    }

    /// d_S, the number of coordinates of a point of S; 0 where the host does not say.
    pub fn space_dimension(&self) -> usize {
        let (instance, functions) = self.table();
        // SAFETY: the host's function with the host's instance.
        functions
            .space_dimension
            .map_or(0, |function| unsafe { function(instance) })
    }

    /// α̂_ε(z), d numbers.
    ///
    /// # Errors
    /// What the host's map says: [`Fail::Outside`] outside its chart.
    pub fn alpha(&self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (instance, functions) = self.table();
        call(functions.alpha, "α̂", instance, epsilon, [z, &[], &[]], out)
    }

    /// β̂_ε(z), d numbers.
    ///
    /// # Errors
    /// What the host's map says.
    pub fn beta(&self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (instance, functions) = self.table();
        call(functions.beta, "β̂", instance, epsilon, [z, &[], &[]], out)
    }

    /// σ(x), d_S numbers.
    ///
    /// # Errors
    /// What the host's map says.
    pub fn sigma(&self, x: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (instance, functions) = self.table();
        call(functions.sigma, "σ", instance, 1.0, [x, &[], &[]], out)
    }

    /// Dα̂_ε(z), d × d_S numbers, row-major.
    ///
    /// # Errors
    /// [`Fail::Unsupported`] where the realization offers none.
    pub fn alpha_jacobian(&self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (instance, functions) = self.table();
        let function = functions.alpha_jacobian;
        call(function, "Dα̂", instance, epsilon, [z, &[], &[]], out)
    }

    fn flags(&self) -> u32 {
        // SAFETY: checked in `new`.
        unsafe { (*self.raw).flags }
    }

    fn table(&self) -> (*mut c_void, &leafwise_plugin_abi::LwRealization) {
        // SAFETY: checked in `new`; the host keeps both alive as long as the instance.
        unsafe { ((*self.raw).instance, &*(*self.raw).functions) }
    }
}

/// One point through a map of the host.
fn call(
    function: LwMapFn,
    what: &str,
    instance: *mut c_void,
    epsilon: f64,
    [point, v, w]: [&[f64]; 3],
    out: &mut [f64],
) -> Result<(), Fail> {
    let Some(function) = function else {
        return Err(Fail::unsupported(format!("the host offers no {what} here")));
    };
    let mut text = [0 as c_char; 256];
    let mut err = LwError::empty();
    err.capacity = text.len() as u32;
    err.message = text.as_mut_ptr();
    err.point = -1;
    let mut arguments = LwMapCall::empty();
    arguments.count = 1;
    arguments.epsilon = epsilon;
    arguments.point = input(point);
    arguments.v = input(v);
    arguments.w = input(w);
    arguments.output = LwOutput {
        data: out.as_mut_ptr(),
        dim: out.len(),
        point_stride: out.len(),
        coordinate_stride: 1,
    };
    // SAFETY: the host's function with its own instance; the buffers live during the call and have
    // the sizes they state.
    let status = unsafe { function(instance, &arguments, &mut err) };
    if status == LW_OK {
        return Ok(());
    }
    text[text.len() - 1] = 0;
    // SAFETY: a buffer of ours with a NUL at its end.
    let reason = unsafe { CStr::from_ptr(text.as_ptr()) }.to_string_lossy();
    let reason = format!("{what} of the host: {reason}");
    Err(match status {
        LW_DISCARD => Fail::outside(err.ratio, reason),
        LW_UNSUPPORTED => Fail::unsupported(reason),
        _ => Fail::error(reason),
    })
}

fn input(numbers: &[f64]) -> LwInput {
    LwInput {
        data: if numbers.is_empty() {
            std::ptr::null()
        } else {
            numbers.as_ptr()
        },
        dim: numbers.len(),
        point_stride: numbers.len(),
        coordinate_stride: 1,
    }
}
