//! One part of an entry.

use leafwise_core::PartKind;
use leafwise_core::part_description::PartDescription;
use leafwise_plugin_abi::{
    LW_KIND_DYNAMICS, LW_KIND_REALIZATION, LW_KIND_STEP_MAP, LW_KIND_SYSTEM, LwPart,
};

use super::memory::{LONGEST_TEXT, copy, formulas, required_text, table, text};
use super::{is_word, parameters};
use crate::declaration::{
    Dimensions, Flags, Functions, PartDeclaration, ValuePath, broken_promise,
};
use crate::error::Refusal;

/// Copies and checks a part of the plugin `vendor`.
///
/// # Safety
/// `pointer` stands in the list of parts of an entry of this version.
pub(super) unsafe fn read(
    place: usize,
    pointer: *const LwPart,
    vendor: &str,
) -> Result<PartDeclaration, Refusal> {
    if pointer.is_null() {
        return Err(Refusal::List {
            what: "the list of parts".to_owned(),
            problem: format!("entry {place} is NULL"),
        });
    }
    // SAFETY: a part of this version; so are its strings, lists and tables, here and below.
    let part = unsafe { copy(pointer) }?;
    // SAFETY: as above.
    let id = unsafe { required_text(|| format!("the id of part {place}"), part.id) }?;
    check_id(&id, vendor)?;
    // SAFETY: as above.
    let summary = unsafe { required_text(|| format!("part {id}: summary"), part.summary) }?;
    let optional = |what: &'static str, pointer| {
        // SAFETY: as above.
        unsafe { text(|| format!("part {id}: {what}"), pointer, LONGEST_TEXT) }
            .map(Option::unwrap_or_default)
    };
    let kind = kind(&id, part.kind)?;
    // SAFETY: as above.
    let formulas = unsafe { formulas(&id, part.expressions, part.expression_count) }?;
    // SAFETY: as above.
    let functions = unsafe { functions(&id, &part, kind) }?;
    // SAFETY: as above.
    let mut parameters = unsafe {
        let is_system = kind == PartKind::System;
        parameters::read(&id, is_system, part.parameters, part.parameter_count)
    }?;
    let declaration = PartDeclaration {
        description: PartDescription {
            name: id.clone(),
            kind,
            summary,
            declares: optional("declares", part.declares)?,
            domain: optional("domain", part.domain)?,
            literature: optional("reference", part.reference)?,
            parameters: Vec::new(),
        },
        order: part.order,
        structure: part.structure,
        dimensions: Dimensions {
            least: part.dim_min.max(1) as usize,
            most: (part.dim_max != 0).then_some(part.dim_max as usize),
        },
        flags: Flags(part.flags),
        formulas,
        functions,
    };
    check(&declaration)?;
    if declaration.paths() == [ValuePath::Expressions, ValuePath::Numbers] {
        parameters.push(parameters::path());
    }
    let mut declaration = declaration;
    declaration.description.parameters = parameters;
    Ok(declaration)
}

fn check_id(id: &str, vendor: &str) -> Result<(), Refusal> {
    let problem = match id.split_once('/') {
        Some((own, name)) if is_word(own) && is_word(name) => {
            if own == vendor {
                return Ok(());
            }
            format!("it begins with the plugin's id, `{vendor}/`")
        }
        _ => format!("an id is `{vendor}/name` in lower-case letters, digits and `-`"),
    };
    Err(Refusal::Id {
        id: id.to_owned(),
        problem,
    })
}

fn kind(id: &str, kind: u32) -> Result<PartKind, Refusal> {
    match kind {
        LW_KIND_SYSTEM => Ok(PartKind::System),
        LW_KIND_REALIZATION => Ok(PartKind::Realization),
        LW_KIND_DYNAMICS => Ok(PartKind::Dynamics),
        LW_KIND_STEP_MAP => Ok(PartKind::Stepper),
        other => Err(Refusal::Declaration {
            part: id.to_owned(),
            problem: format!("kind {other} is unknown"),
        }),
    }
}

/// The table of functions, with all that its kind cannot do without.
///
/// # Safety
/// `part` is a part of this version, of this kind.
unsafe fn functions(id: &str, part: &LwPart, kind: PartKind) -> Result<Option<Functions>, Refusal> {
    if part.functions.is_null() {
        return Ok(None);
    }
    // SAFETY: the part's kind says which table the pointer leads to.
    let functions = unsafe {
        match kind {
            PartKind::System => Functions::System(table(id, part.functions)?),
            PartKind::Realization => Functions::Realization(table(id, part.functions)?),
            PartKind::Dynamics => Functions::Dynamics(table(id, part.functions)?),
            _ => Functions::StepMap(table(id, part.functions)?),
        }
    };
    match functions.missing(Flags(part.flags)) {
        None => Ok(Some(functions)),
        Some(function) => Err(Refusal::MissingFunction {
            part: id.to_owned(),
            function: function.to_owned(),
        }),
    }
}

/// Refuses a declaration that contradicts itself.
fn check(part: &PartDeclaration) -> Result<(), Refusal> {
    let (flags, kind) = (part.flags, part.kind());
    let one_form_and_more = matches!(&part.functions, Some(Functions::Dynamics(table))
        if [table.one_form, table.embedding, table.flow].iter().flatten().count() > 1);
    let problem = if part.formulas.is_empty() && part.functions.is_none() {
        "it has neither functions nor expressions".to_owned()
    } else if part
        .dimensions
        .most
        .is_some_and(|most| most < part.dimensions.least)
    {
        "dim_max is less than dim_min".to_owned()
    } else if let Some(problem) = broken_promise(kind, part.order, part.structure, flags) {
        problem
    } else if kind == PartKind::Realization
        && !part.formulas.is_empty()
        && !flags.has_cotangent_chart()
    {
        "formulas of a realization need LW_FLAG_COTANGENT_CHART".to_owned()
    } else if one_form_and_more {
        "exactly one of one_form, embedding and flow may be present".to_owned()
    } else {
        return Ok(());
    };
    Err(Refusal::Declaration {
        part: part.id().to_owned(),
        problem,
    })
}
