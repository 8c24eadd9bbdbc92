//! ẋ as text: what `check` and `run --explain` print of a system.

use leafwise::core::system::{Convention, MotionClass};
use leafwise::scene::SceneDocument;
use leafwise::scene::compose::{ComposedRun, LeftOut, Motion, Refusal, left_out};
use leafwise::scene::json::{Double, object};
use serde::Serialize;

use crate::table::words;

/// Variables whose formulas are printed.
const MOST_SHOWN: usize = 24;

/// Characters of a formula that are printed.
const WIDTH: usize = 200;

/// ẋ of every variable, a line each; nothing where it has no value at the initial state.
pub(super) fn lines(run: &ComposedRun) -> Vec<String> {
    let Some(motion) = Motion::of(run) else {
        let is_short = run.system.dimension() < run.dimension();
        let why = "  Motion: no site is away from both open ends by what H couples: it is not written out";
        return is_short.then(|| why.to_owned()).into_iter().collect();
    };
    let convention = run.system.expressions().map(|system| system.convention());
    let definition = match (&run.contact, convention) {
        (Some(_), _) => ", q' = dH/dp, p' = -dH/dq - p dH/ds, s' = p dH/dp - H",
        (None, Some(Convention::HamiltonianSecond)) => ", x' = {x, H}",
        (None, Some(Convention::HamiltonianFirst)) => ", x' = {H, x}",
        (None, None) => "",
    };
    let forced = match run.system.motion() {
        MotionClass::Hamiltonian => "",
        MotionClass::OnLeaves => " with forces",
        MotionClass::OffLeaves => " with friction",
    };
    let noise = Motion::of_noise(run);
    let stochastic = match noise.is_empty() {
        true => "",
        false => ", and noise",
    };
    let heading = format!("{definition}{forced}{stochastic}");
    let mut lines = block("Motion", &heading, motion);
    lines.extend(turning(run));
    for (text, field) in noise {
        lines.extend(block(&format!("Noise of {text}"), ", o dW", field));
    }
    lines
}

/// Which way three coordinates turn whose bracket is that of rotations, and that stand in no other one.
fn turning(run: &ComposedRun) -> Option<String> {
    let system = run.system.expressions()?;
    let tensor = system.tensor();
    let (&(a, b), first) = tensor.first_key_value()?;
    let c = tensor
        .keys()
        .find_map(|&(i, j)| (i == a && j != b).then_some(j))?;
    let is_of_them = |at: usize| [a, b, c].contains(&at);
    let entries: Vec<_> = (tensor.iter())
        .filter(|((i, j), _)| is_of_them(*i) || is_of_them(*j))
        .collect();
    if entries.len() != 3
        || !entries
            .iter()
            .all(|((i, j), _)| is_of_them(*i) && is_of_them(*j))
    {
        return None;
    }
    let state: Vec<f64> = (1..=system.dimension())
        .map(|at| 1.0 + 0.25 * at as f64)
        .collect();
    let parameters = system.parameter_values();
    // With ẋ = -Π ∂H: x × ∂H where Π_ab = x_c.
    let sign = first.evaluate(&state, &parameters) / state[c];
    let is_rotation = entries.iter().all(|((i, j), entry)| {
        let k = [a, b, c].into_iter().find(|at| at != i && at != j);
        let value = entry.evaluate(&state, &parameters);
        // Of (a, b) and (b, c) the sign is that of (a, b), of (a, c) the other one.
        let own = if (*i, *j) == (a.min(c), a.max(c)) {
            -sign
        } else {
            sign
        };
        k.is_some_and(|k| (value - own * state[k]).abs() <= 1e-12 * state[k])
    });
    if !is_rotation || (sign.abs() - 1.0).abs() > 1e-12 {
        return None;
    }
    let names: Vec<&str> = [a, b, c]
        .iter()
        .map(|at| system.variables()[*at].as_str())
        .collect();
    // Of names in another order the product has another sign.
    if !names.is_sorted() {
        return None;
    }
    let names = names.join(", ");
    let (body, spin) = ("m' = m × ω with ω = ∂H/∂m", "s' = s × (-∂H/∂s)");
    Some(match sign > 0.0 {
        true => format!(
            "  ({names}) turns as a body, {body}; by the other convention as a spin, {spin}"
        ),
        false => format!(
            "  ({names}) turns as a spin, {spin}; by the other convention as a body, {body}"
        ),
    })
}

/// The terms that are left out at the ends of an open lattice, a line each.
///
/// # Errors
/// A formula that cannot be read.
pub(super) fn ends(document: &SceneDocument) -> Result<Vec<String>, Refusal> {
    let left_out = left_out(document)?;
    let mut lines = Vec::new();
    for own in left_out.chunk_by(|a, b| a.of == b.of) {
        let rows: Vec<Vec<String>> = (own.iter())
            .map(|LeftOut { term, places, .. }| {
                let term = match term.chars().count() > WIDTH {
                    true => cut(term),
                    false => term.clone(),
                };
                vec![format!("    {term}"), of_sites(places)]
            })
            .collect();
        lines.push(format!(
            "  Left out of {}, beyond the open ends:",
            own[0].of
        ));
        lines.extend(words(&rows));
    }
    Ok(lines)
}

/// Ranges of sites that are printed.
const MOST_RANGES: usize = 12;

/// Sites by the values of their indices: `of sites 3 … 7` along one axis, `of sites [:,5]` where there are several.
fn of_sites(places: &[Vec<usize>]) -> String {
    let along = |(axis, values): (usize, &Vec<usize>)| {
        let runs = values.chunk_by(|a, b| a + 1 == *b).map(|run| match run {
            [first, .., last] => format!("{first} … {last}"),
            _ => run[0].to_string(),
        });
        let within = |run: String| {
            let indices = (0..places.len()).map(|of| if of == axis { run.as_str() } else { ":" });
            let indices = indices.collect::<Vec<_>>().join(",");
            if places.len() > 1 {
                format!("[{indices}]")
            } else {
                indices
            }
        };
        runs.map(within).collect::<Vec<_>>()
    };
    let runs: Vec<String> = places.iter().enumerate().flat_map(along).collect();
    match (&places, runs.len()) {
        (_, 0 | MOST_RANGES..) => "of the sites next to the ends".to_owned(),
        ([one], 1) if one.len() == 1 => format!("of site {}", runs[0]),
        _ => format!("of sites {}", runs.join(", ")),
    }
}

/// The rows of a field under a heading.
fn block(what: &str, definition: &str, motion: Motion) -> Vec<String> {
    let (place, rows) = match motion {
        Motion::Formulas(rows) => (String::new(), shown(rows)),
        Motion::Site(rows) => (format!(" at a site {}", indices(&rows)), shown(rows)),
        Motion::Values(rows) => (
            " at the initial state".to_owned(),
            rows.into_iter()
                .map(|(name, value)| (name, format!("{value:?}")))
                .collect(),
        ),
    };
    let more = rows.len().saturating_sub(MOST_SHOWN);
    let rows = rows.into_iter().take(MOST_SHOWN);
    let rows: Vec<Vec<String>> = rows
        .map(|(name, text)| vec![format!("    {name}'"), format!("= {text}")])
        .collect();
    let mut lines = vec![format!("  {what}{place}{definition}:")];
    lines.extend(words(&rows));
    if more > 0 {
        lines.push(format!(
            "    … and {more} more: `leafwise check SCENE --json` prints all"
        ));
    }
    lines
}

/// The indices of a site, `i` or `i,j`, from the name of a coordinate there.
fn indices(rows: &[(String, Option<String>)]) -> &str {
    let name = rows.first().map(|(name, _)| name.as_str());
    let indices = name.and_then(|name| name.split_once('['));
    indices.map_or("i", |(_, indices)| indices.trim_end_matches(']'))
}

fn shown(rows: Vec<(String, Option<String>)>) -> Vec<(String, String)> {
    let text = |formula: Option<String>| match formula {
        None => "a formula too long to be read".to_owned(),
        Some(formula) if formula.chars().count() > WIDTH => cut(&formula),
        Some(formula) => formula,
    };
    rows.into_iter()
        .map(|(name, formula)| (name, text(formula)))
        .collect()
}

/// A formula's first terms.
fn cut(formula: &str) -> String {
    let first: String = formula.chars().take(WIDTH).collect();
    let end = first.rfind([' ', '*']).unwrap_or(first.len());
    format!(
        "{} … ({} characters)",
        first[..end].trim_end(),
        formula.chars().count()
    )
}

/// ẋ by the variables' names: formulas, `null` for one too long, numbers for a system of numbers.
#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum MotionJson {
    #[serde(serialize_with = "object")]
    Formulas(Vec<(String, Option<String>)>),
    #[serde(serialize_with = "object")]
    Values(Vec<(String, Double)>),
}

impl From<Motion> for MotionJson {
    fn from(motion: Motion) -> Self {
        let double = |(name, value)| (name, Double(value));
        match motion {
            Motion::Formulas(rows) | Motion::Site(rows) => Self::Formulas(rows),
            Motion::Values(rows) => Self::Values(rows.into_iter().map(double).collect()),
        }
    }
}
