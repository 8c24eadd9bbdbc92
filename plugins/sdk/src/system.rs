//! Systems as numbers.

use std::ffi::{CStr, c_char, c_void};
use std::mem::size_of;

use leafwise_plugin_abi::{LW_KIND_SYSTEM, LwPart, LwSystem};

use crate::fail::Fail;
use crate::instance::{Instance, Part, lifecycle};
use crate::map::{map, maps, optional};

/// A Poisson system ẋ = {H, x} = −Π ∇H as numbers; Π_ij = {x_i, x_j}.
///
/// Points y and covectors v have d numbers. Pure functions: the same point gives the same bits.
pub trait System: Part {
    /// Whether [`casimir_gradients`](Self::casimir_gradients) is offered.
    const CASIMIR_GRADIENTS: bool = false;
    /// Whether [`tensor_tangent`](Self::tensor_tangent) and [`hessian`](Self::hessian) are offered:
    /// exact tangents need them.
    const TANGENTS: bool = false;

    /// d ≥ 1.
    fn dimension(&self) -> usize;
    /// The variables' names; empty: x1, x2, ….
    fn variables(&self) -> &'static [&'static CStr] {
        &[]
    }
    /// Π(y)·v, (Π v)_i = Σ_j Π_ij(y) v_j; d numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] where Π is not defined.
    fn tensor(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail>;
    /// H(y).
    ///
    /// # Errors
    /// [`Fail::Outside`] where H is not defined.
    fn hamiltonian(&mut self, y: &[f64]) -> Result<f64, Fail>;
    /// ∇H(y), d numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] where H is not differentiable.
    fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), Fail>;
    /// The names of the Casimirs in reports.
    fn casimir_names(&self) -> &'static [&'static CStr] {
        &[]
    }
    /// The Casimirs at y, one number for each name.
    ///
    /// # Errors
    /// [`Fail::Outside`] where they are not defined.
    fn casimirs(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (y, out);
        Ok(())
    }
    /// Their gradients, C × d numbers, row-major.
    ///
    /// # Errors
    /// As [`casimirs`](Self::casimirs).
    fn casimir_gradients(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (y, out);
        Err(Fail::unsupported("no gradients of Casimirs"))
    }
    /// Σ_jk ∂_k Π_ij(y) v_j w_k, d numbers.
    ///
    /// # Errors
    /// As [`tensor`](Self::tensor).
    fn tensor_tangent(
        &mut self,
        y: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> Result<(), Fail> {
        let _ = (y, v, w, out);
        Err(Fail::unsupported("no derivative of the tensor"))
    }
    /// D²H(y)·v, d numbers.
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient).
    fn hessian(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (y, v, out);
        Err(Fail::unsupported("no second derivatives of H"))
    }
}

maps! { System:
    Tensor = |part, at, out| part.tensor(at.point, at.v, out);
    Hamiltonian = |part, at, out| {
        out[0] = part.hamiltonian(at.point)?;
        Ok(())
    };
    Gradient = |part, at, out| part.gradient(at.point, out);
    Casimirs = |part, at, out| part.casimirs(at.point, out);
    CasimirGradients = |part, at, out| part.casimir_gradients(at.point, out);
    TensorTangent = |part, at, out| part.tensor_tangent(at.point, at.v, at.w, out);
    Hessian = |part, at, out| part.hessian(at.point, at.v, out);
}

struct Table<T>(T);

impl<T: System> Table<T> {
    const FUNCTIONS: &'static LwSystem = &LwSystem {
        struct_size: size_of::<LwSystem>() as u32,
        reserved: 0,
        life: lifecycle::<T>(),
        dimension: Some(dimension::<T>),
        variable_name: Some(variable_name::<T>),
        tensor: map::<T, Tensor>(),
        hamiltonian: map::<T, Hamiltonian>(),
        gradient: map::<T, Gradient>(),
        casimir_count: Some(casimir_count::<T>),
        casimir_name: Some(casimir_name::<T>),
        casimirs: map::<T, Casimirs>(),
        casimir_gradients: optional::<T, CasimirGradients>(T::CASIMIR_GRADIENTS),
        tensor_tangent: optional::<T, TensorTangent>(T::TANGENTS),
        hessian: optional::<T, Hessian>(T::TANGENTS),
    };
}

/// The entry of a system in a plugin's list.
pub const fn system_part<T: System>() -> LwPart {
    let mut part = T::INFO.part(LW_KIND_SYSTEM);
    part.order = 0;
    part.functions = std::ptr::from_ref(Table::<T>::FUNCTIONS).cast();
    part
}

/// Reads a fact of an instance; `absent` after a panic or for NULL.
///
/// # Safety
/// `instance` is NULL or was made by `create::<T>`.
unsafe fn fact<T, R>(instance: *mut c_void, absent: R, read: impl FnOnce(&T) -> R) -> R {
    // SAFETY: the caller's promise.
    let Some(instance) = (unsafe { instance.cast::<Instance<T>>().as_ref() }) else {
        return absent;
    };
    let read = std::panic::AssertUnwindSafe(|| read(&instance.part));
    match std::panic::catch_unwind(read) {
        Ok(value) => value,
        Err(payload) => {
            std::mem::forget(payload);
            absent
        }
    }
}

unsafe extern "C" fn dimension<T: System>(instance: *mut c_void) -> usize {
    // SAFETY: the host passes what `create::<T>` made.
    unsafe { fact(instance, 0, T::dimension) }
}

unsafe extern "C" fn variable_name<T: System>(
    instance: *mut c_void,
    index: usize,
) -> *const c_char {
    let name = |part: &T| part.variables().get(index).map(|name| name.as_ptr());
    // SAFETY: the host passes what `create::<T>` made.
    unsafe { fact(instance, None, name) }.unwrap_or(std::ptr::null())
}

unsafe extern "C" fn casimir_count<T: System>(instance: *mut c_void) -> usize {
    // SAFETY: the host passes what `create::<T>` made.
    unsafe { fact(instance, 0, |part: &T| part.casimir_names().len()) }
}

unsafe extern "C" fn casimir_name<T: System>(instance: *mut c_void, index: usize) -> *const c_char {
    let name = |part: &T| part.casimir_names().get(index).map(|name| name.as_ptr());
    // SAFETY: the host passes what `create::<T>` made.
    unsafe { fact(instance, None, name) }.unwrap_or(std::ptr::null())
}
