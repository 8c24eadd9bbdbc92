//! Names that formulas may refer to, and the errors of formulas placed in the file.

use leafwise_core::BuildError;
use leafwise_core::lattice::LatticeGeometry;
use leafwise_expression::syntax::{
    Boundary, Formula, Scope, SiteNames, SyntaxError, SyntaxErrorKind, VECTOR_FUNCTIONS,
    function_names,
};
use leafwise_expression::{AlgebraError, Expression, Graph, Rational};

use super::Refusal;
use super::dense::WRITTEN_LIMIT;
use super::geometry::geometry;
use super::own_columns::about_own_columns;
use super::tables::tables;
use super::time::{about_time, is_time};
use crate::document::{Located, Number, SceneDocument, nearest};

/// The variables, parameters and families of a scene, with the families as long as those of `lattice`; `N` as a
/// number stays the true length.
///
/// # Errors
/// A table whose file or numbers make none, underlined in the scene.
pub(super) fn declared(
    document: &SceneDocument,
    lattice: &LatticeGeometry,
) -> Result<Scope, Refusal> {
    let system = &document.system;
    let names = |list: &[Located<String>]| -> Vec<String> {
        list.iter().map(|name| name.value.clone()).collect()
    };
    let parameters: Vec<String> = system
        .parameters
        .iter()
        .map(|(name, _)| name.value.clone())
        .collect();
    let mut scope = Scope::new()
        .with_variables(&names(&system.variables))
        .with_parameters(&parameters);
    let mut offset = system.variables.len();
    for ((name, _), (_, sites)) in system.families.iter().zip(&lattice.families) {
        scope = match lattice.axes.len() {
            1 => scope.with_family(&name.value, offset, *sites),
            _ => scope.with_lattice(&name.value, offset, &lattice.lengths()),
        };
        offset += sites;
    }
    if let Some(longest) = system.families.iter().map(|(_, length)| length.value).max() {
        scope = scope.with_length(longest);
    }
    let boundaries = lattice.axes.iter().map(|axis| match axis.periodic {
        true => Boundary::Periodic,
        false => Boundary::Open,
    });
    scope = scope
        .with_boundaries(&boundaries.collect::<Vec<_>>())
        .with_rings(&geometry(document).lengths());
    for table in tables(document)? {
        scope = scope.with_table(table);
    }
    Ok(scope)
}

/// The names of the coordinates: single variables, then the members of each family, `x[0]`, `x[1]`, … or `x[0,0]`, ….
pub(super) fn coordinate_names(document: &SceneDocument, lattice: &LatticeGeometry) -> Vec<String> {
    let system = &document.system;
    let singles = system.variables.iter().map(|name| name.value.clone());
    let members = (0..lattice.dimension()).map(|member| lattice.name(member));
    singles.chain(members).collect()
}

/// Refuses names that formulas use for something else.
pub(super) fn check_names(document: &SceneDocument) -> Result<(), Refusal> {
    let system = &document.system;
    let declared = system
        .variables
        .iter()
        .chain(system.families.iter().map(|(name, _)| name))
        .chain(system.parameters.iter().map(|(name, _)| name))
        .chain(system.define.iter().map(|(name, _)| name))
        .chain(system.matrices.iter().map(|matrix| &matrix.name));
    for name in declared.clone() {
        Scope::check_name(&name.value).map_err(|error| refusal(document, name, &error))?;
    }
    // Where there are vectors, formulas call functions of them.
    let mut vectors = system.all_vectors().map(|vector| &vector.name).peekable();
    if vectors.peek().is_some() {
        for name in declared.chain(vectors) {
            if VECTOR_FUNCTIONS.contains(&name.value.as_str()) {
                let error = SyntaxError {
                    span: 0..name.value.len(),
                    kind: SyntaxErrorKind::ReservedName {
                        name: name.value.clone(),
                    },
                    suggestion: None,
                };
                return Err(refusal(document, name, &error));
            }
        }
    }
    for (name, _) in &system.tables {
        Scope::check_table_name(&name.value).map_err(|error| refusal(document, name, &error))?;
    }
    let energy = system
        .casimirs
        .iter()
        .find(|(name, _)| name.value == "energy");
    if let Some((name, _)) = energy {
        return Err(Box::new(document.diagnostic(
            &name.place(),
            "a Casimir cannot be called `energy`: that is the Hamiltonian's value",
            "taken",
            Some("give the Casimir another name".to_owned()),
        )));
    }
    Ok(())
}

/// The sites that a key with these indices stands for.
///
/// # Errors
/// An index that counts along two axes, the key underlined.
pub(super) fn sites_of(
    document: &SceneDocument,
    scope: &Scope,
    key: &Located<String>,
    names: &[&str],
) -> Result<Vec<usize>, Refusal> {
    scope.sites_of(names).map_err(|error| {
        let help = Some("write one index an axis, as in \"x[i,j]\"".to_owned());
        let (message, label) = (error.to_string(), "of two axes");
        Box::new(document.diagnostic(&key.place(), message, label, help))
    })
}

/// Parses a formula of the scene.
pub(super) fn parse(
    document: &SceneDocument,
    formula: &Located<String>,
) -> Result<Formula, Refusal> {
    parse_text(document, &formula.value).map_err(|error| refusal(document, formula, &error))
}

/// Parses a formula in the components of the scene's vectors, definitions of families written out in it.
pub(super) fn parse_text(document: &SceneDocument, text: &str) -> Result<Formula, SyntaxError> {
    let formula = Formula::parse(text)?.with_sites(&document.system.site_names)?;
    let formula = in_components(document, formula)?;
    with_families(document, formula)
}

/// A formula with the definitions written out that name families: such a one stands for a formula, which long lattices repeat.
pub(super) fn with_families(
    document: &SceneDocument,
    mut formula: Formula,
) -> Result<Formula, SyntaxError> {
    let define = definitions_of_families(document);
    let define: Vec<(&str, &Formula)> = define.iter().map(|(name, of)| (&**name, of)).collect();
    // Each round goes one level deeper. Those that lead back to themselves are refused where they are ordered.
    for _ in 0..define.len() {
        let names = formula.references();
        if !define.iter().any(|(name, _)| names.contains(name)) {
            break;
        }
        formula = formula.written_out(&define)?;
    }
    Ok(formula)
}

/// Definitions that name families, themselves or by others, in components. What is wrong with one is told where it stands.
fn definitions_of_families(document: &SceneDocument) -> Vec<(String, Formula)> {
    let system = &document.system;
    if system.families.is_empty() {
        return Vec::new();
    }
    let mut others: Vec<(String, Formula)> = (system.define.iter())
        .filter_map(|(name, formula)| {
            let parsed = Formula::parse(&formula.value);
            let parsed = parsed.and_then(|formula| formula.with_sites(&system.site_names));
            let parsed = parsed.and_then(|formula| in_components(document, formula));
            Some((name.value.clone(), parsed.ok()?))
        })
        .collect();
    let mut found = Vec::new();
    loop {
        let names_one = |name: &str| {
            let mut families = system.families.iter();
            families.any(|(family, _)| family.value == name)
                || found
                    .iter()
                    .any(|(known, _): &(String, Formula)| known == name)
        };
        let (more, rest): (Vec<_>, Vec<_>) = others.into_iter().partition(|(_, formula)| {
            let is_one = formula.free_indices().is_empty();
            is_one && formula.references().into_iter().any(names_one)
        });
        if more.is_empty() {
            return found;
        }
        found.extend(more);
        others = rest;
    }
}

fn in_components(document: &SceneDocument, formula: Formula) -> Result<Formula, SyntaxError> {
    let vectors = document.system.named_vectors();
    // A formula that would be a vector, were it right, is told by what is wrong in it.
    let broken = formula.components(&vectors).err();
    formula
        .in_components(&vectors)
        .map_err(|error| match error.kind {
            SyntaxErrorKind::VectorAsNumber { .. } => broken.unwrap_or(error),
            _ => error,
        })
}

/// A number as a rational.
pub(super) fn exact(
    document: &SceneDocument,
    number: &Located<Number>,
) -> Result<Rational, Refusal> {
    Rational::parse_decimal(&number.value.literal).map_err(|error| {
        Box::new(document.diagnostic(&number.place(), error.to_string(), "here", None))
    })
}

/// The expression of a formula of the state, with code.
pub(super) fn function(
    document: &SceneDocument,
    scope: &Scope,
    formula: &Located<String>,
) -> Result<Expression, Refusal> {
    let parsed = parse(document, formula)?;
    let expression = parsed
        .resolve(scope, None)
        .map_err(|error| refusal(document, formula, &error))?
        .unwrap_or_else(|| Expression::Sum(Vec::new()));
    check_code(document, formula, &expression)?;
    Ok(expression)
}

/// Refuses an expression of a formula that has no code.
pub(super) fn check_code(
    document: &SceneDocument,
    formula: &Located<String>,
    expression: &Expression,
) -> Result<(), Refusal> {
    let mut graph = Graph::new();
    let code = expression.evaluate_in(&mut graph, &mut |graph, at| Ok(graph.input(at)));
    code.map(|_| ())
        .map_err(|error| algebra_refusal(document, formula, &error))
}

/// An error of a formula, with the piece it is about underlined in the file.
pub(super) fn refusal(
    document: &SceneDocument,
    formula: &Located<String>,
    error: &SyntaxError,
) -> Refusal {
    let place = document.place_in_formula(formula, error.span.clone());
    if let Some((message, help)) = about_a_long_lattice(document, formula, &error.kind) {
        return Box::new(document.diagnostic(&place, message, "here", help));
    }
    if matches!(&error.kind, SyntaxErrorKind::UnknownName { name } if is_time(document, name))
        && let Some((message, help)) = about_time(document, formula)
    {
        return Box::new(document.diagnostic(&place, message, "the time", Some(help)));
    }
    if matches!(&error.kind, SyntaxErrorKind::UnknownName { .. })
        && let Some((message, help, length)) =
            about_own_columns(document, formula, error.span.start)
    {
        let name = error.span.start..error.span.start + length;
        let place = document.place_in_formula(formula, name);
        return Box::new(document.diagnostic(&place, message, "in a formula", Some(help)));
    }
    let label = match &error.kind {
        SyntaxErrorKind::UnknownName { .. } => "neither a variable nor a parameter of this scene",
        SyntaxErrorKind::UnknownFunction { .. } => "not a function",
        SyntaxErrorKind::UnexpectedEnd { .. } => "something is missing here",
        SyntaxErrorKind::UnknownSite { .. } => "no site of this name",
        _ => "here",
    };
    let of_vectors = about_vectors(document, &error.kind);
    let help = match (&error.suggestion, &error.kind) {
        _ if of_vectors.is_some() => of_vectors,
        (Some(_), SyntaxErrorKind::UnknownName { name }) if name == "e" => {
            Some("e^x is written exp(x), and e itself exp(1)".to_owned())
        }
        (Some(name), SyntaxErrorKind::UnknownFunction { .. }) => {
            Some(format!("did you mean `{name}`? {}", vocabulary(document)))
        }
        (Some(name), _) => Some(format!("did you mean `{name}`?")),
        (None, SyntaxErrorKind::UnknownName { name }) => Some(unknown_name_help(document, name)),
        (None, SyntaxErrorKind::UnexpectedCharacter { character: '=' }) => {
            Some("a formula has no `=`: write only the right-hand side".to_owned())
        }
        (None, SyntaxErrorKind::IndexAsNumber { name }) => Some(format!(
            "values that differ from site to site are a parameter of sites: w[{name}] in the formula, and \"w[{name}]\" = \"…\" in \
             [system.parameters], a formula of {name}"
        )),
        (None, SyntaxErrorKind::UnknownIndex { name }) => {
            of_one_number(document, formula, name).or_else(|| of_all_sites(document, formula, name))
        }
        (None, SyntaxErrorKind::LengthOfAxes) => Some(format!(
            "the lattice has {} sites: write {}",
            document.system.axes.iter().product::<usize>(),
            (document.system.axes.iter())
                .map(usize::to_string)
                .collect::<Vec<_>>()
                .join(" or ")
        )),
        (None, SyntaxErrorKind::UnknownFunction { .. }) => Some(vocabulary(document)),
        (None, SyntaxErrorKind::UnknownSite { .. }) => Some(format!(
            "{}; an index of all sites is i, j, k, l, m or n",
            sites_by_name(&document.system.site_names)
        )),
        (None, _) => None,
    };
    Box::new(document.diagnostic(&place, error.kind.to_string(), label, help))
}

/// Where values of sites belong that stand in a number for all sites.
fn of_one_number(
    document: &SceneDocument,
    formula: &Located<String>,
    index: &str,
) -> Option<String> {
    let system = &document.system;
    let mut channels = system.noise.iter();
    if channels.any(|channel| channel.strength == *formula) {
        return Some(format!(
            "one strength serves all sites: values of sites multiply the Hamiltonian, as in {{ hamiltonian = \"a[{index}]*q[{index}]\" }}"
        ));
    }
    let damping = system.forces.damping.as_ref()?;
    (damping.rate == *formula).then(|| {
        format!(
            "one rate serves all sites: values of sites stand in the metric, as in metric = {{ \"p[{index}]\" = \"a[{index}]\" }}"
        )
    })
}

/// How each site of an observable is recorded, or all together.
fn of_all_sites(
    document: &SceneDocument,
    formula: &Located<String>,
    index: &str,
) -> Option<String> {
    let (system, text) = (&document.system, formula.value.trim());
    let mut recorded = document.run.record.observables.iter();
    let is_recorded = recorded.any(|own| own.formula.place() == formula.place());
    let names_it = |family: &str| text.contains(&format!("{family}[{index}"));
    let mut families = system.families.iter().map(|(family, _)| &family.value);
    let family = families.find(|family| system.axes.is_empty() && names_it(family));
    let family = family.filter(|_| is_recorded)?;
    Some(format!(
        "an observable is one number: sum({index}, {text}); states = [\"{family}\"] records every {family}[{index}]"
    ))
}

/// How numbers come of a vector that stands where a number is meant, or a component behind the site.
fn about_vectors(document: &SceneDocument, kind: &SyntaxErrorKind) -> Option<String> {
    let named = document.system.named_vectors();
    match kind {
        SyntaxErrorKind::VectorAsNumber { components, .. } => Some(match components.split_first() {
            Some((first, _)) => format!(
                "its components are {}: write one, such as {first}, or dot(a, b), a number of two vectors, or norm(a)",
                components.join(", ")
            ),
            None => "write dot(a, b), a number of two vectors, or norm(a)".to_owned(),
        }),
        SyntaxErrorKind::NoVector { vectors, .. } => Some(match vectors.is_empty() {
            true => "vectors are declared by their components: variables = { r = 3, p = 3 }, or families = { s = { components = \
                     [\"x\", \"y\", \"z\"], length = 100 } }"
                .to_owned(),
            false => format!("vectors of this scene: {}", vectors.join(", ")),
        }),
        SyntaxErrorKind::UnexpectedCharacter { character: '.' } => {
            let vector = named.first()?;
            Some(format!(
                "`{}` is a family of vectors with the components {}: write {}[i]",
                vector.name,
                vector.components.join(", "),
                vector.components.first()?
            ))
        }
        _ => None,
    }
}

/// A single site of a long lattice, whose formulas are tried on a shorter one.
fn about_a_long_lattice(
    document: &SceneDocument,
    formula: &Located<String>,
    kind: &SyntaxErrorKind,
) -> Option<(String, Option<String>)> {
    const RECORDED: &str = "single coordinates are recorded by their names, one as observables = [\"q[500]\"], \
                            many as states = [\"q[::100]\"]";
    const RECORDED_OF_AXES: &str = "parts are recorded as they are, states = [\"q[2,:]\"], and single coordinates also by formulas, \
                                    observables = [\"q[3,4]^2\"]";
    match kind {
        SyntaxErrorKind::IndexOutOfRange {
            name,
            position,
            length,
        } => {
            let mut families = document.system.families.iter();
            let whole = families.find(|(family, _)| family.value == *name)?.1.value;
            if whole == *length {
                return None;
            }
            let is_there = usize::try_from(*position).is_ok_and(|position| position < whole);
            Some(match is_there {
                true => (
                    format!(
                        "a formula on a lattice of this length repeats from site to site, and cannot name the \
                         site {name}[{position}]"
                    ),
                    Some(RECORDED.to_owned()),
                ),
                false => (
                    format!(
                        "`{name}` has the members {name}[0] to {name}[{}], not {name}[{position}]",
                        whole - 1
                    ),
                    None,
                ),
            })
        }
        SyntaxErrorKind::SiteOutOfRange {
            name,
            axis,
            position,
            length,
        } => {
            let whole = *document.system.axes.get(*axis)?;
            let is_there = usize::try_from(*position).is_ok_and(|position| position < whole);
            if whole == *length {
                return None;
            }
            Some(match is_there {
                true => (
                    format!(
                        "a formula on a lattice of this size repeats from site to site, and cannot name single sites of \
                         `{name}`"
                    ),
                    None,
                ),
                false => (
                    format!(
                        "`{name}` has the sites 0 to {} along axis {axis}, not {position}",
                        whole - 1
                    ),
                    None,
                ),
            })
        }
        SyntaxErrorKind::NotASumOverSites
        | SyntaxErrorKind::SumInATemplate
        | SyntaxErrorKind::SiteInATemplate { .. } => {
            let mut recorded = document.run.record.observables.iter();
            let is_recorded = recorded.any(|observable| observable.formula == *formula);
            let coordinates = document.system.coordinates();
            let forces = document.system.forces.one_form.iter();
            let mut forces = forces.flat_map(|own| own.value.formulas());
            let is_force = forces.any(|own| own.place() == formula.place());
            let kind_of = match kind {
                SyntaxErrorKind::SumInATemplate if is_recorded => {
                    "this sum does not run over all sites, or it couples every site with all others"
                        .to_owned()
                }
                kind => kind.to_string(),
            };
            let message = format!(
                "{kind_of}; such formulas are written out on lattices of at most {WRITTEN_LIMIT} coordinates, and this one has \
                 {coordinates}"
            );
            let help = match kind {
                SyntaxErrorKind::SumInATemplate
                    if is_recorded && document.system.axes.is_empty() =>
                {
                    "sums over all sites are recorded, and any functions of them: sum(i, j, q[i]*p[j]) is sum(i, q[i])*sum(i, p[i]), \
                     and sum(i<j, q[i]*q[j]) is (sum(i, q[i])^2 - sum(i, q[i]^2))/2"
                }
                SyntaxErrorKind::SiteInATemplate { .. } if is_recorded => {
                    "write single sites outside of the sum: sum(i, q[3]*q[i]) is q[3]*sum(i, q[i])"
                }
                _ if is_recorded && !document.system.axes.is_empty() => RECORDED_OF_AXES,
                _ if is_recorded => RECORDED,
                SyntaxErrorKind::SumInATemplate if is_force => {
                    "shorten the lattice; of a force with a potential write that into the Hamiltonian, whose functions of sums are \
                     taken in loops, as sum(i, cos(q[i]))^2/N"
                }
                SyntaxErrorKind::SumInATemplate => {
                    "shorten the lattice, or couple sites at fixed distances, as q[i+5]"
                }
                _ => {
                    "values of single sites are a parameter of sites: a[i] in the formula, \"a[i]\" = 0 and \"a[3]\" = 1 in \
                     [system.parameters]"
                }
            };
            Some((message, Some(help.to_owned())))
        }
        _ => None,
    }
}

/// All that a parenthesis may follow.
fn vocabulary(document: &SceneDocument) -> String {
    let names: Vec<&str> = function_names().collect();
    let tables = document.system.tables.iter();
    let tables: Vec<&str> = tables.map(|(name, _)| name.value.as_str()).collect();
    let tables = match tables.is_empty() {
        true => "numbers at nodes are a function by [system.tables]".to_owned(),
        false => format!("tables: {}", tables.join(", ")),
    };
    format!("functions: {}; {tables}", names.join(", "))
}

/// The names of sites, of many the first.
pub(super) fn sites_by_name(names: &SiteNames) -> String {
    const SHOWN: usize = 12;
    let shown: Vec<&str> = names.iter().take(SHOWN).collect();
    let more = names.iter().count() - shown.len();
    match more {
        0 => format!("sites of this scene: {}", shown.join(", ")),
        _ => format!("sites of this scene: {} and {more} more", shown.join(", ")),
    }
}

fn unknown_name_help(document: &SceneDocument, name: &str) -> String {
    let system = &document.system;
    let known: Vec<&str> = system
        .variables
        .iter()
        .chain(system.families.iter().map(|(name, _)| name))
        .chain(system.parameters.iter().map(|(name, _)| name))
        .chain(system.define.iter().map(|(name, _)| name))
        .chain(system.matrices.iter().map(|matrix| &matrix.name))
        .map(|name| name.value.as_str())
        .collect();
    if let (Some(_), Some((family, _))) =
        (system.site_names.position(name), system.families.first())
    {
        return format!(
            "`{name}` is the name of a site, and stands in brackets: {}[{name}]",
            family.value
        );
    }
    match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("names of this scene: {}", known.join(", ")),
    }
}

/// An error of a scene's formula, as one of its lattice.
#[expect(
    clippy::boxed_local,
    reason = "refusals are boxed, as errors of results"
)]
pub(super) fn of_lattice(refusal: Refusal) -> BuildError {
    BuildError::Lattice {
        message: refusal.message.clone(),
    }
}

/// A formula that the exact algebra cannot evaluate, underlined as a whole.
pub(super) fn algebra_refusal(
    document: &SceneDocument,
    formula: &Located<String>,
    error: &AlgebraError,
) -> Refusal {
    let place = document.place_in_formula(formula, 0..formula.value.len());
    Box::new(document.diagnostic(&place, error.to_string(), "in this formula", None))
}
