//! The frozen layout: sizes and offsets in bytes, checked when this crate is compiled.

use core::mem::{align_of, offset_of, size_of};

use crate::{
    LW_FROZEN_BYTES, LwCreate, LwDynamics, LwEntry, LwError, LwExpression, LwHostRealization,
    LwHostSystem, LwInput, LwLifecycle, LwMapCall, LwOutput, LwParameter, LwPart, LwProperties,
    LwRealization, LwSetting, LwStepMap, LwSystem,
};

/// The layout of one struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TypeLayout {
    /// Its name, the same in C.
    pub name: &'static str,
    /// Its size in bytes.
    pub size: usize,
    /// All its fields with their offsets in bytes.
    pub fields: &'static [(&'static str, usize)],
}

macro_rules! layout {
    ($($name:ident: $size:literal { $($field:ident: $offset:literal),* $(,)? })*) => {
        $(const _: () = {
            assert!(size_of::<$name>() == $size);
            assert!(align_of::<$name>() <= 8);
            $(assert!(offset_of!($name, $field) == $offset);)*
            // A field that the table forgets does not compile.
            const fn _all_fields(value: $name) {
                let $name { $($field: _),* } = value;
            }
        };)*

        /// Every struct of ABI 1.0.
        pub const LAYOUT: &[TypeLayout] = &[$(TypeLayout {
            name: stringify!($name),
            size: $size,
            fields: &[$((stringify!($field), $offset)),*],
        }),*];
    };
}

const _: () = assert!(offset_of!(LwEntry, parts) == LW_FROZEN_BYTES);

layout! {
    LwError: 32 { struct_size: 0, capacity: 4, message: 8, point: 16, ratio: 24 }
    LwInput: 32 { data: 0, dim: 8, point_stride: 16, coordinate_stride: 24 }
    LwOutput: 32 { data: 0, dim: 8, point_stride: 16, coordinate_stride: 24 }
    LwMapCall: 160 {
        struct_size: 0, reserved: 4, count: 8, epsilon: 16, h: 24,
        point: 32, v: 64, w: 96, output: 128,
    }
    LwSetting: 40 { name: 0, kind: 8, reserved: 12, integer: 16, real: 24, text: 32 }
    LwCreate: 56 {
        struct_size: 0, reserved: 4, dim: 8, params: 16, settings: 24, setting_count: 32,
        system: 40, realization: 48,
    }
    LwProperties: 16 { struct_size: 0, order: 4, structure: 8, flags: 12 }
    LwLifecycle: 24 { create: 0, destroy: 8, properties: 16 }
    LwHostSystem: 24 { struct_size: 0, flags: 4, instance: 8, functions: 16 }
    LwHostRealization: 32 {
        struct_size: 0, flags: 4, order: 8, reserved: 12, instance: 16, functions: 24,
    }
    LwSystem: 120 {
        struct_size: 0, reserved: 4, life: 8, dimension: 32, variable_name: 40, tensor: 48,
        hamiltonian: 56, gradient: 64, casimir_count: 72, casimir_name: 80, casimirs: 88,
        casimir_gradients: 96, tensor_tangent: 104, hessian: 112,
    }
    LwRealization: 120 {
        struct_size: 0, reserved: 4, life: 8, space_dimension: 32, alpha: 40, beta: 48, sigma: 56,
        ends: 64, alpha_jacobian: 72, beta_with_jacobian: 80, ends_jacobian: 88, domain: 96,
        chart: 104, chart_jacobian: 112,
    }
    LwDynamics: 80 {
        struct_size: 0, reserved: 4, life: 8, one_form: 32, one_form_jacobian: 40, embedding: 48,
        embedding_jacobian: 56, flow: 64, flow_jacobian: 72,
    }
    LwStepMap: 48 { struct_size: 0, reserved: 4, life: 8, increment: 32, tangent: 40 }
    LwExpression: 16 { key: 0, formula: 8 }
    LwParameter: 24 { name: 0, summary: 8, default_json: 16 }
    LwPart: 112 {
        struct_size: 0, kind: 4, id: 8, summary: 16, declares: 24, domain: 32, reference: 40,
        parameters: 48, parameter_count: 56, expressions: 64, expression_count: 72, functions: 80,
        order: 88, structure: 92, dim_min: 96, dim_max: 100, flags: 104, reserved: 108,
    }
    LwEntry: 64 {
        magic: 0, abi_major: 8, abi_minor: 10, struct_size: 12, real_bytes: 16, part_count: 20,
        parts: 24, id: 32, version: 40, license: 48, toolchain: 56,
    }
}
