//! Dynamic approximations as numbers.

use std::mem::size_of;

use leafwise_plugin_abi::{LW_KIND_DYNAMICS, LwDynamics, LwPart};

use crate::fail::Fail;
use crate::instance::{Part, lifecycle};
use crate::map::{Steps, map, maps, optional};

/// A generating function: L(y) = (y, θ̂(y)) in the realization's cotangent chart, θ̂ = dŜ_{ε,h}.
pub trait OneForm: Part {
    /// Whether [`jacobian`](Self::jacobian) is offered.
    const JACOBIAN: bool = false;
    /// θ̂(y), d numbers: a closed one-form.
    ///
    /// # Errors
    /// [`Fail::Outside`] where Ŝ is not defined.
    fn one_form(&mut self, steps: Steps, y: &[f64], out: &mut [f64]) -> Result<(), Fail>;
    /// Dθ̂(y), a symmetric d × d matrix.
    ///
    /// # Errors
    /// As [`one_form`](Self::one_form).
    fn jacobian(&mut self, steps: Steps, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (steps, y, out);
        Err(Fail::unsupported("no derivative of the one-form"))
    }
}

/// A bisection given by its points: y ↦ L(y) ∈ S.
pub trait Embedding: Part {
    /// Whether [`jacobian`](Self::jacobian) is offered.
    const JACOBIAN: bool = false;
    /// L(y), d_S numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] where an inner solve fails.
    fn embedding(&mut self, steps: Steps, y: &[f64], out: &mut [f64]) -> Result<(), Fail>;
    /// DL(y), d_S × d numbers, row-major.
    ///
    /// # Errors
    /// As [`embedding`](Self::embedding).
    fn jacobian(&mut self, steps: Steps, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (steps, y, out);
        Err(Fail::unsupported("no derivative of the embedding"))
    }
}

/// A symplectic integrator's map Σ_{ε,h} of the collective Hamiltonian H∘α̂_ε: L(y) = Σ(σ(y)).
pub trait Flow: Part {
    /// Whether [`jacobian`](Self::jacobian) is offered.
    const JACOBIAN: bool = false;
    /// Σ(z), d_S numbers.
    ///
    /// # Errors
    /// [`Fail::Outside`] where an inner solve fails.
    fn flow(&mut self, steps: Steps, z: &[f64], out: &mut [f64]) -> Result<(), Fail>;
    /// DΣ(z), d_S × d_S numbers, row-major.
    ///
    /// # Errors
    /// As [`flow`](Self::flow).
    fn jacobian(&mut self, steps: Steps, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let _ = (steps, z, out);
        Err(Fail::unsupported("no derivative of the flow"))
    }
}

maps! { OneForm:
    Theta = |part, at, out| part.one_form(at.steps, at.point, out);
    ThetaJacobian = |part, at, out| part.jacobian(at.steps, at.point, out);
}
maps! { Embedding:
    Point = |part, at, out| part.embedding(at.steps, at.point, out);
    PointJacobian = |part, at, out| part.jacobian(at.steps, at.point, out);
}
maps! { Flow:
    Sigma = |part, at, out| part.flow(at.steps, at.point, out);
    SigmaJacobian = |part, at, out| part.jacobian(at.steps, at.point, out);
}

const fn table<T: Part>() -> LwDynamics {
    LwDynamics {
        struct_size: size_of::<LwDynamics>() as u32,
        reserved: 0,
        life: lifecycle::<T>(),
        one_form: None,
        one_form_jacobian: None,
        embedding: None,
        embedding_jacobian: None,
        flow: None,
        flow_jacobian: None,
    }
}

struct OneFormTable<T>(T);
impl<T: OneForm> OneFormTable<T> {
    const FUNCTIONS: &'static LwDynamics = &LwDynamics {
        one_form: map::<T, Theta>(),
        one_form_jacobian: optional::<T, ThetaJacobian>(T::JACOBIAN),
        ..table::<T>()
    };
}

struct EmbeddingTable<T>(T);
impl<T: Embedding> EmbeddingTable<T> {
    const FUNCTIONS: &'static LwDynamics = &LwDynamics {
        embedding: map::<T, Point>(),
        embedding_jacobian: optional::<T, PointJacobian>(T::JACOBIAN),
        ..table::<T>()
    };
}

struct FlowTable<T>(T);
impl<T: Flow> FlowTable<T> {
    const FUNCTIONS: &'static LwDynamics = &LwDynamics {
        flow: map::<T, Sigma>(),
        flow_jacobian: optional::<T, SigmaJacobian>(T::JACOBIAN),
        ..table::<T>()
    };
}

const fn part<T: Part>(functions: &'static LwDynamics) -> LwPart {
    let mut part = T::INFO.part(LW_KIND_DYNAMICS);
    part.functions = std::ptr::from_ref(functions).cast();
    part
}

/// The entry of a generating function in a plugin's list.
pub const fn one_form_part<T: OneForm>() -> LwPart {
    part::<T>(OneFormTable::<T>::FUNCTIONS)
}

/// The entry of an embedding in a plugin's list.
pub const fn embedding_part<T: Embedding>() -> LwPart {
    part::<T>(EmbeddingTable::<T>::FUNCTIONS)
}

/// The entry of a symplectic integrator in a plugin's list.
pub const fn flow_part<T: Flow>() -> LwPart {
    part::<T>(FlowTable::<T>::FUNCTIONS)
}
