//! `define`: names for formulas, and with them all names that a formula may use.
//!
//! A definition may use the others, whatever their order in the file, unless they lead back to it.

use std::collections::BTreeSet;

use leafwise_core::lattice::LatticeGeometry;
use leafwise_expression::Expression;
use leafwise_expression::syntax::{DEPTH_LIMIT, Formula, Scope, SyntaxErrorKind};

use super::Refusal;
use super::geometry::geometry;
use super::matrices::{matrices, order as order_of_matrices};
use super::names::{declared, function, parse_text, refusal};
use super::time::{TIME, names_time};
use crate::document::{Located, MatrixNumbers, SceneDocument};

/// Names that the formulas of a scene may use, with its families as long as those of `lattice`, and its definitions. `N` as a
/// number stays the true length.
///
/// The variable of index `time` is the time since the initial state, to which `t0` is added. Without this variable,
/// definitions that name the time are left out.
pub(super) fn scope(
    document: &SceneDocument,
    lattice: &LatticeGeometry,
    time: Option<usize>,
) -> Result<Scope, Refusal> {
    let mut scope = declared(document, lattice)?;
    if let Some(time) = time {
        scope = scope.with_variable(TIME, time);
        if let Some(t0) = &document.run.t0 {
            let since = Formula::parse(&format!("{TIME} + ({})", t0.value.literal));
            let value = since.and_then(|formula| formula.resolve(&scope, None));
            let value = value.map_err(|error| {
                let (place, help) = (t0.place(), None);
                Box::new(document.diagnostic(&place, error.to_string(), "here", help))
            })?;
            scope = scope.with_definition(TIME, value.unwrap_or(Expression::Variable(time)));
        }
    }
    let define = &document.system.define;
    check_observables(document)?;
    let parsed = parsed(document)?;
    for at in order(document, &parsed)? {
        let (name, formula) = &define[at];
        if time.is_none() && names_time(document, formula) {
            continue;
        }
        if names_families(document, &parsed[at]) {
            check_families(document, &scope, formula, &parsed[at])?;
            continue;
        }
        let value = function(document, &scope, formula)?;
        if value.height() > DEPTH_LIMIT {
            return Err(Box::new(document.diagnostic(
                &document.place_in_formula(formula, 0..formula.value.len()),
                format!(
                    "`{}` and its definitions are nested more than {DEPTH_LIMIT} levels deep",
                    name.value
                ),
                "in this formula",
                Some("define fewer steps of it".to_owned()),
            )));
        }
        scope = scope.with_definition(&name.value, value);
    }
    let order = order_of_matrices(document);
    for (name, numbers) in matrices(document, &scope)? {
        scope = scope.with_matrix(&name, order, numbers);
    }
    Ok(scope)
}

/// Every definition's formula. Of errors the first is told that is no consequence of another: that a definition is no vector may be.
fn parsed(document: &SceneDocument) -> Result<Vec<Formula>, Refusal> {
    let define = &document.system.define;
    let is_defined = |text: &str| define.iter().any(|(name, _)| name.value == text);
    let mut all = Vec::with_capacity(define.len());
    let mut first = None;
    for (_, formula) in define {
        match parse_text(document, &formula.value) {
            Ok(parsed) => all.push(parsed),
            Err(error) => {
                let is_consequence = matches!(&error.kind, SyntaxErrorKind::NoVector { text, .. } if is_defined(text));
                let refused = refusal(document, formula, &error);
                if !is_consequence {
                    return Err(refused);
                }
                first = first.or(Some(refused));
            }
        }
    }
    first.map_or(Ok(all), Err)
}

/// The numbers of all matrices, in the order of the text.
///
/// # Errors
/// As `matrices`.
pub(super) fn numbers_of_matrices(document: &SceneDocument) -> Result<Vec<MatrixNumbers>, Refusal> {
    if document.system.matrices.is_empty() {
        return Ok(Vec::new());
    }
    let scope = scope(document, &geometry(document), None)?;
    let all = matrices(document, &scope)?.into_iter();
    Ok(all.map(|(_, numbers)| numbers).collect())
}

/// The definitions, each after those that it uses; of those that may come next the first in the file.
fn order(document: &SceneDocument, parsed: &[Formula]) -> Result<Vec<usize>, Refusal> {
    let define = &document.system.define;
    let uses: Vec<BTreeSet<usize>> = parsed
        .iter()
        .map(|formula| {
            let names = formula.references();
            let named = |(name, _): &(Located<String>, _)| names.contains(name.value.as_str());
            (0..define.len()).filter(|at| named(&define[*at])).collect()
        })
        .collect();
    let mut order = Vec::with_capacity(define.len());
    let mut left: BTreeSet<usize> = (0..define.len()).collect();
    while let Some(first) = left.first().copied() {
        let mut ready = left.iter().filter(|at| uses[**at].is_disjoint(&left));
        let Some(next) = ready.next().copied() else {
            return Err(cycle(document, first, &left, &uses));
        };
        left.remove(&next);
        order.push(next);
    }
    Ok(order)
}

/// Each of `left` uses another of them: following the first use leads round.
fn cycle(
    document: &SceneDocument,
    first: usize,
    left: &BTreeSet<usize>,
    uses: &[BTreeSet<usize>],
) -> Refusal {
    let mut path = vec![first];
    let start = loop {
        let last = path[path.len() - 1];
        let next = uses[last].intersection(left).next().copied();
        // There is one: what is left uses what is left.
        let next = next.unwrap_or(last);
        if let Some(start) = path.iter().position(|at| *at == next) {
            break start;
        }
        path.push(next);
    };
    let name = |at: &usize| format!("`{}`", document.system.define[*at].0.value);
    let round = &path[start..];
    let (defined, formula) = &document.system.define[round[0]];
    let through = match &round[1..] {
        [] => "uses itself".to_owned(),
        others => {
            let others: Vec<String> = others.iter().map(name).collect();
            format!("is defined by itself, through {}", others.join(", "))
        }
    };
    Box::new(document.diagnostic(
        &document.place_in_formula(formula, 0..formula.value.len()),
        format!("`{}` {through}", defined.value),
        "leads back to this definition",
        Some("write one of them without the others".to_owned()),
    ))
}

fn names_families(document: &SceneDocument, parsed: &Formula) -> bool {
    let names = parsed.references();
    let mut families = document.system.families.iter();
    families.any(|(family, _)| names.contains(family.value.as_str()))
}

/// A definition has one value; members of a family are many. One that sums over them, or names single ones, is written out where it is
/// used: of names here the unknown ones are told.
fn check_families(
    document: &SceneDocument,
    scope: &Scope,
    formula: &Located<String>,
    parsed: &Formula,
) -> Result<(), Refusal> {
    if let Some(index) = parsed
        .free_indices()
        .into_iter()
        .find(|name| !name.is_empty())
    {
        return Err(Box::new(document.diagnostic(
            &document.place_in_formula(formula, 0..formula.value.len()),
            format!("a definition has one value, and this one has another for every `{index}`"),
            "of every site",
            Some(format!(
                "sum over the sites, as in \"sum({index}, …)\", or write it out in the formulas that use it"
            )),
        )));
    }
    match parsed.resolve(scope, None) {
        Err(error) if matches!(error.kind, SyntaxErrorKind::UnknownName { .. }) => {
            Err(refusal(document, formula, &error))
        }
        _ => Ok(()),
    }
}

/// The names of invariants are taken: as an observable a name stands for one thing.
fn check_observables(document: &SceneDocument) -> Result<(), Refusal> {
    let system = &document.system;
    for (name, _) in &system.define {
        let casimir = system.casimirs.iter().find(|(c, _)| c.value == name.value);
        let is_taken = match casimir {
            Some((_, formula)) => formula.value.trim() != name.value,
            None => name.value == "energy",
        };
        if is_taken {
            let what = match casimir {
                Some(_) => "a Casimir",
                None => "the Hamiltonian's value",
            };
            return Err(Box::new(document.diagnostic(
                &name.place(),
                format!(
                    "a definition cannot be called `{}`: that is {what}",
                    name.value
                ),
                "taken",
                Some("give the definition another name".to_owned()),
            )));
        }
    }
    Ok(())
}
