//! Declaration of a plugin, copied out of the library and checked.

pub use leafwise_core::part::Dimensions;

use leafwise_core::PartKind;
use leafwise_core::part::PartInfo;
use leafwise_core::part_description::PartDescription;
use leafwise_plugin_abi::{
    LW_FLAG_COTANGENT_CHART, LW_FLAG_EXACT, LW_FLAG_NOT_SELF_ADJOINT, LW_FLAG_REVERSIBLE,
    LW_FLAG_SELF_ADJOINT, LW_FLAG_SYMPLECTIC, LW_FLAG_UNCORRECTED, LW_STRUCTURE_EXACT, LwDynamics,
    LwLifecycle, LwRealization, LwStepMap, LwSystem,
};

/// Declaration of a plugin: its name, version, licence and parts.
#[derive(Clone, Debug)]
pub struct PluginDeclaration {
    /// The plugin's own name, the vendor of its parts' ids.
    pub id: String,
    /// Its version.
    pub version: String,
    /// Its licence, where it states one.
    pub license: Option<String>,
    /// The compiler or toolchain that built it, where it says so.
    pub toolchain: Option<String>,
    /// The interface it needs, as `major.minor`.
    pub abi: String,
    /// Its parts.
    pub parts: Vec<PartDeclaration>,
}

/// Declaration of a part, read before any instance exists.
#[derive(Clone, Debug)]
pub struct PartDeclaration {
    /// Id, kind, texts and parameters.
    pub description: PartDescription,
    /// The order it declares; what counts depends on its kind.
    pub order: i32,
    /// `LW_STRUCTURE_…`, or the order of its tensor defect.
    pub structure: i32,
    /// The dimensions it serves.
    pub dimensions: Dimensions,
    /// Its promises.
    pub flags: Flags,
    /// Its formulas as pairs of key and text; none where it is numbers alone.
    pub formulas: Vec<(String, String)>,
    /// Its functions; `None` where it is formulas alone.
    pub functions: Option<Functions>,
}

/// The values of a part come from formulas or from functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValuePath {
    /// From formulas: exact derivatives and series of any order.
    Expressions,
    /// From functions that compute numbers.
    Numbers,
}

impl ValuePath {
    /// The words of all, the preferred way first.
    pub const WORDS: [&str; 2] = [Self::Expressions.word(), Self::Numbers.word()];

    /// The word of scenes and manifests.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Expressions => "expressions",
            Self::Numbers => "numbers",
        }
    }
}

impl PartDeclaration {
    /// The part's id.
    pub fn id(&self) -> &str {
        &self.description.name
    }

    /// The part's kind.
    pub fn kind(&self) -> PartKind {
        self.description.kind
    }

    /// Where its values may come from, the preferred way first.
    pub fn paths(&self) -> &'static [ValuePath] {
        match (self.formulas.is_empty(), self.functions.is_some()) {
            (false, true) => &[ValuePath::Expressions, ValuePath::Numbers],
            (false, false) => &[ValuePath::Expressions],
            (true, _) => &[ValuePath::Numbers],
        }
    }

    /// Its description as registered, leaked so that it lives as long as the program runs.
    pub(crate) fn info(&self) -> &'static PartInfo {
        const WORDS: &[&str] = &ValuePath::WORDS;
        let words = match self.paths() {
            [ValuePath::Expressions] => &WORDS[..1],
            [ValuePath::Numbers] => &WORDS[1..],
            _ => WORDS,
        };
        self.description.clone().leak(words)
    }
}

/// The promises of a part, as its flags say; unknown ones are ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags(pub(crate) u32);

impl Flags {
    /// The promises with these `LW_FLAG_…` bits.
    pub fn new(bits: u32) -> Self {
        Self(bits)
    }

    fn has(self, flag: u32) -> bool {
        self.0 & flag != 0
    }

    /// Realization: exact to round-off.
    pub fn is_exact(self) -> bool {
        self.has(LW_FLAG_EXACT)
    }

    /// Dynamic approximation: L is Lagrangian to round-off.
    pub fn is_symplectic(self) -> bool {
        self.has(LW_FLAG_SYMPLECTIC)
    }

    /// Whether the induced map is its own adjoint; `None` where that is not known.
    pub fn self_adjoint(self) -> Option<bool> {
        match (
            self.has(LW_FLAG_SELF_ADJOINT),
            self.has(LW_FLAG_NOT_SELF_ADJOINT),
        ) {
            (true, false) => Some(true),
            (false, true) => Some(false),
            _ => None,
        }
    }

    /// Whether it is said to be self-adjoint and not to be.
    pub(crate) fn contradicts_itself(self) -> bool {
        self.has(LW_FLAG_SELF_ADJOINT) && self.has(LW_FLAG_NOT_SELF_ADJOINT)
    }

    /// Realization: points of S are pairs (x, p).
    pub fn has_cotangent_chart(self) -> bool {
        self.has(LW_FLAG_COTANGENT_CHART)
    }

    /// Realization: β̂(x, p) = α̂(x, −p).
    pub fn is_reversible(self) -> bool {
        self.has(LW_FLAG_REVERSIBLE)
    }

    /// Dynamic approximation: y = x_k is taken as it is.
    pub fn is_uncorrected(self) -> bool {
        self.has(LW_FLAG_UNCORRECTED)
    }
}

/// Contradiction in the promises of a part of this kind, in words; `None` where there is none.
pub(crate) fn broken_promise(
    kind: PartKind,
    order: i32,
    structure: i32,
    flags: Flags,
) -> Option<String> {
    let counts = match kind {
        PartKind::System => false,
        PartKind::Realization => !flags.is_exact(),
        _ => true,
    };
    if counts && order < 1 {
        Some(format!("order {order} is less than 1"))
    } else if structure < LW_STRUCTURE_EXACT {
        Some(format!("structure {structure} is unknown"))
    } else if flags.contradicts_itself() {
        Some("it is declared self-adjoint and not self-adjoint".to_owned())
    } else if flags.is_reversible() && !flags.has_cotangent_chart() {
        Some("LW_FLAG_REVERSIBLE needs LW_FLAG_COTANGENT_CHART".to_owned())
    } else {
        None
    }
}

/// The table of functions of a part.
#[derive(Clone, Copy, Debug)]
pub enum Functions {
    /// A system's.
    System(LwSystem),
    /// A realization's.
    Realization(LwRealization),
    /// A dynamic approximation's.
    Dynamics(LwDynamics),
    /// A step map's.
    StepMap(LwStepMap),
}

impl Functions {
    /// How instances are made.
    pub(crate) fn lifecycle(&self) -> &LwLifecycle {
        match self {
            Self::System(table) => &table.life,
            Self::Realization(table) => &table.life,
            Self::Dynamics(table) => &table.life,
            Self::StepMap(table) => &table.life,
        }
    }

    /// The first function that must be there and is not.
    pub(crate) fn missing(&self, flags: Flags) -> Option<&'static str> {
        let life = self.lifecycle();
        let mut required = vec![
            ("create", life.create.is_some()),
            ("destroy", life.destroy.is_some()),
        ];
        match self {
            Self::System(table) => {
                let has_casimirs = table.casimir_count.is_some();
                required.extend([
                    ("dimension", table.dimension.is_some()),
                    ("tensor", table.tensor.is_some()),
                    ("hamiltonian", table.hamiltonian.is_some()),
                    ("gradient", table.gradient.is_some()),
                    (
                        "casimir_name",
                        !has_casimirs || table.casimir_name.is_some(),
                    ),
                    ("casimirs", !has_casimirs || table.casimirs.is_some()),
                ]);
            }
            Self::Realization(table) => required.extend([
                ("space_dimension", table.space_dimension.is_some()),
                ("alpha", table.alpha.is_some()),
                ("beta", table.beta.is_some()),
                (
                    "sigma",
                    table.sigma.is_some() || flags.has_cotangent_chart(),
                ),
            ]),
            Self::Dynamics(table) => required.push((
                "one_form, embedding or flow",
                table.one_form.is_some() || table.embedding.is_some() || table.flow.is_some(),
            )),
            Self::StepMap(table) => required.push(("increment", table.increment.is_some())),
        }
        let absent = required.into_iter().find(|(_, is_there)| !is_there);
        absent.map(|(name, _)| name)
    }
}
