//! Empty structs to fill in, and leave to put constant ones into a `static`.

use core::mem::{size_of, zeroed};

use crate::{
    LwCreate, LwDynamics, LwEntry, LwError, LwExpression, LwHostRealization, LwHostSystem,
    LwLifecycle, LwMapCall, LwParameter, LwPart, LwProperties, LwRealization, LwStepMap, LwSystem,
};

macro_rules! empty {
    ($($name:ident),*) => {$(
        impl $name {
            /// All zero and NULL, `struct_size` excepted: what is left out stays absent when fields
            /// are appended.
            pub const fn empty() -> Self {
                // SAFETY: every field is an integer, a double, a raw pointer or an optional function
                // pointer, or a struct of such: zero is a value of each.
                let mut value: Self = unsafe { zeroed() };
                value.struct_size = size_of::<Self>() as u32;
                value
            }
        }
    )*};
}

empty!(
    LwCreate,
    LwDynamics,
    LwEntry,
    LwError,
    LwHostRealization,
    LwHostSystem,
    LwMapCall,
    LwPart,
    LwProperties,
    LwRealization,
    LwStepMap,
    LwSystem
);

impl LwLifecycle {
    /// All NULL.
    pub const fn empty() -> Self {
        Self {
            create: None,
            destroy: None,
            properties: None,
        }
    }
}

macro_rules! constant {
    ($($name:ident),*) => {$(
        // SAFETY: constant data by contract: it and what its pointers reach is never written.
        unsafe impl Sync for $name {}
        // SAFETY: as above.
        unsafe impl Send for $name {}
    )*};
}

constant!(LwEntry, LwExpression, LwParameter, LwPart);
