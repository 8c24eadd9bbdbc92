//! Declaration of a part, as constant data.

use std::ffi::CStr;

use leafwise_plugin_abi::{
    LW_FLAG_COTANGENT_CHART, LW_FLAG_EXACT, LW_FLAG_NOT_SELF_ADJOINT, LW_FLAG_REVERSIBLE,
    LW_FLAG_SELF_ADJOINT, LW_FLAG_SYMPLECTIC, LW_FLAG_UNCORRECTED, LW_STRUCTURE_EXACT,
    LW_STRUCTURE_NONE, LwExpression, LwParameter, LwPart,
};

/// One parameter of a part.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct Parameter(LwParameter);

impl Parameter {
    /// A parameter with its default as a JSON literal, which is also its type: `c"4"` is a whole
    /// number, `c"4.0"` a number, `c"\"none\""` a word.
    pub const fn new(name: &'static CStr, summary: &'static CStr, default: &'static CStr) -> Self {
        Self(LwParameter {
            name: name.as_ptr(),
            summary: summary.as_ptr(),
            default_json: default.as_ptr(),
        })
    }
}

// SAFETY: three pointers to constant strings.
unsafe impl Sync for Parameter {}

/// One formula of a part; its keys are listed at `LwExpression` of `leafwise-plugin-abi`.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct Formula(LwExpression);

impl Formula {
    /// The formula of `key`, in the syntax of a scene.
    pub const fn new(key: &'static CStr, formula: &'static CStr) -> Self {
        Self(LwExpression {
            key: key.as_ptr(),
            formula: formula.as_ptr(),
        })
    }
}

// SAFETY: two pointers to constant strings.
unsafe impl Sync for Formula {}

/// How well a step map keeps the Poisson structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// Not a Poisson map, or not known to be one.
    None,
    /// Φ_* π − π = O(t^{n+1}).
    Order(u16),
    /// A Poisson map to round-off.
    Exact,
}

/// Declaration of a part about itself: built as a constant, field by field.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    part: LwPart,
}

impl Info {
    /// A part `vendor/name` (lower-case letters, digits, `-`) and one line that says what it is.
    /// Undeclared: order 1, not exact, symmetry unknown, any dimension.
    pub const fn new(id: &'static CStr, summary: &'static CStr) -> Self {
        let mut part = LwPart::empty();
        part.id = id.as_ptr();
        part.summary = summary.as_ptr();
        part.order = 1;
        part.structure = LW_STRUCTURE_NONE;
        Self { part }
    }

    /// Its promises in words.
    pub const fn declares(mut self, words: &'static CStr) -> Self {
        self.part.declares = words.as_ptr();
        self
    }

    /// Where it is defined, in words: states, tensors, step sizes.
    pub const fn domain(mut self, words: &'static CStr) -> Self {
        self.part.domain = words.as_ptr();
        self
    }

    /// Where it is published.
    pub const fn reference(mut self, words: &'static CStr) -> Self {
        self.part.reference = words.as_ptr();
        self
    }

    /// Its parameters.
    pub const fn parameters(mut self, parameters: &'static [Parameter]) -> Self {
        self.part.parameters = parameters.as_ptr().cast();
        self.part.parameter_count = parameters.len();
        self
    }

    /// Its formulas.
    pub const fn formulas(mut self, formulas: &'static [Formula]) -> Self {
        self.part.expressions = formulas.as_ptr().cast();
        self.part.expression_count = formulas.len();
        self
    }

    /// Realization: n of α̂ = α + O(ε^{n+1}); dynamic approximation: m in h; step map: in t = εh.
    pub const fn order(mut self, order: u16) -> Self {
        self.part.order = order as i32;
        self
    }

    /// The dimensions d it serves, both ends included.
    pub const fn dimensions(mut self, least: u32, most: u32) -> Self {
        self.part.dim_min = least;
        self.part.dim_max = most;
        self
    }

    /// Realization: α̂ is Poisson and β̂ anti-Poisson to round-off.
    pub const fn exact(self) -> Self {
        self.flag(LW_FLAG_EXACT)
    }

    /// Realization: S = T*M with z = (x, p), ω canonical, σ(x) = (x, 0).
    pub const fn cotangent_chart(self) -> Self {
        self.flag(LW_FLAG_COTANGENT_CHART)
    }

    /// Realization in a cotangent chart: β̂(x, p) = α̂(x, −p).
    pub const fn reversible(self) -> Self {
        self.flag(LW_FLAG_REVERSIBLE)
    }

    /// Dynamic approximation: L is Lagrangian to round-off.
    pub const fn symplectic(self) -> Self {
        self.flag(LW_FLAG_SYMPLECTIC)
    }

    /// Dynamic approximation, step map: whether Φ_{−h} ∘ Φ_h = id.
    pub const fn self_adjoint(self, holds: bool) -> Self {
        self.flag(if holds {
            LW_FLAG_SELF_ADJOINT
        } else {
            LW_FLAG_NOT_SELF_ADJOINT
        })
    }

    /// Dynamic approximation: the host takes y = x_k instead of solving β̂(L(y)) = x_k.
    pub const fn uncorrected(self) -> Self {
        self.flag(LW_FLAG_UNCORRECTED)
    }

    /// Step map: how well it keeps the structure.
    pub const fn structure(mut self, structure: Structure) -> Self {
        self.part.structure = match structure {
            Structure::None => LW_STRUCTURE_NONE,
            Structure::Order(n) => n as i32,
            Structure::Exact => LW_STRUCTURE_EXACT,
        };
        self
    }

    const fn flag(mut self, flag: u32) -> Self {
        self.part.flags |= flag;
        self
    }

    pub(crate) const fn part(self, kind: u32) -> LwPart {
        let mut part = self.part;
        part.kind = kind;
        part
    }

    pub(crate) const fn has(&self, flag: u32) -> bool {
        self.part.flags & flag != 0
    }
}
