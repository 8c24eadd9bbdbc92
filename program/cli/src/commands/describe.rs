//! `leafwise describe`: one part, library system or Lie algebra.

use leafwise::core::part::PartInfo;
use leafwise::core::{Origin, Registry};
use leafwise::scene::compose::{LIE_ALGEBRAS, LieAlgebra};
use leafwise::scene::document::nearest;
use leafwise::scene::json::object;
use leafwise::systems::{LibrarySystem, SystemError};
use serde::Serialize;

use crate::arguments::{DescribeArguments, PluginArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

/// Name that leaves the choice of a part to the program.
const AUTO: &str = "auto";

/// Meaning of `auto` as a realization, and as dynamics.
const AUTO_MEANS: [&str; 2] = [
    "an exact closed form that fits the tensor, the most specific one; where there is none, the realization exact to \
     round-off whose steps take the fewest operations, or karasev-truncated on a long lattice. `run --explain` shows the \
     choice and its reason",
    "hamilton-jacobi of order 4, of order 2 over a system of numbers",
];

/// Text wider than this is wrapped.
const WIDTH: usize = 88;

/// The object of `describe --json`.
#[derive(Serialize)]
struct DescriptionJson {
    #[serde(flatten)]
    named: Described,
    #[serde(skip_serializing_if = "Option::is_none")]
    lie_algebra: Option<Described>,
}

/// Entry that a name stands for: a part, a library system or a Lie algebra.
#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum Described {
    Part {
        #[serde(flatten)]
        info: &'static PartInfo,
        origin: Origin,
    },
    System {
        name: &'static str,
        kind: &'static str,
        title: String,
        summary: String,
        dimension: usize,
        orbit: String,
        literature: String,
        time_step: f64,
        system: &'static str,
    },
    LieAlgebra {
        name: &'static str,
        kind: &'static str,
        summary: &'static str,
        variables: &'static [&'static str],
        #[serde(serialize_with = "object")]
        bracket: Vec<(String, String)>,
    },
    Auto {
        name: &'static str,
        realization: &'static str,
        dynamics: &'static str,
    },
}

/// Describes what the name stands for; returns the exit code.
///
/// # Errors
/// [`Failure::Usage`] with the nearest name when there is none such.
pub fn execute(
    arguments: &DescribeArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let name = arguments.name.as_str();
    let registry = Parts::new(plugins)?.registry;
    let mut found: Vec<(Vec<String>, Described)> = Vec::new();
    // A system of the library is described by its text.
    let system = leafwise::systems::find(name);
    let mut listing = registry.listing().into_iter();
    let found_part = listing.find(|(info, _)| info.name == name);
    if let Some((info, origin)) = found_part.filter(|_| system.is_none()) {
        let origin = origin.clone();
        found.push((part(info, &origin), Described::Part { info, origin }));
    }
    if let Some(system) = system {
        let text = system_text(system);
        found.push(text.map_err(|error| Failure::usage(error.to_string(), "report this"))?);
    }
    found.extend(LieAlgebra::find(name).map(lie_algebra));
    if name == AUTO {
        let [realization, dynamics] = AUTO_MEANS;
        let mut lines = vec![format!("{AUTO} (in place of a part's name)"), String::new()];
        labelled(&mut lines, "realization", realization);
        labelled(&mut lines, "dynamics", dynamics);
        found.push((
            lines,
            Described::Auto {
                name: AUTO,
                realization,
                dynamics,
            },
        ));
    }
    let mut found = found.into_iter();
    let Some((mut lines, named)) = found.next() else {
        return Err(unknown(name, &registry));
    };
    // A name may stand for a system and for the Lie algebra it lives on.
    let lie_algebra = found.next().map(|(others, algebra)| {
        lines.push(String::new());
        lines.extend(others);
        algebra
    });
    if arguments.json {
        console.json(&DescriptionJson { named, lie_algebra });
    } else {
        lines.iter().for_each(|line| console.result(line));
    }
    Ok(exit::DONE)
}

fn unknown(name: &str, registry: &Registry) -> Failure {
    let mut known: Vec<&str> = registry.parts().iter().map(|info| info.name).collect();
    known.extend(LIE_ALGEBRAS.iter().map(|algebra| algebra.name));
    let help = match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "`leafwise list` prints every name".to_owned(),
    };
    Failure::usage(format!("nothing is called `{name}`"), help)
}

fn part(info: &PartInfo, origin: &Origin) -> Vec<String> {
    let mut lines = vec![
        format!("{} ({})", info.name, info.kind.noun()),
        String::new(),
    ];
    for (label, text) in [
        ("what", info.summary),
        ("declares", info.declares),
        ("domain", info.domain),
        ("literature", info.literature),
        ("origin", &origin.to_string()),
    ] {
        if !text.is_empty() {
            labelled(&mut lines, label, text);
        }
    }
    lines.push(String::new());
    if info.parameters.is_empty() {
        lines.push("  no parameters".to_owned());
        return lines;
    }
    lines.push("  parameters:".to_owned());
    let rows: Vec<Vec<String>> = info
        .parameters
        .iter()
        .map(|p| {
            vec![
                format!("    {}", p.name),
                format!("{} (default {})", p.summary, p.default),
            ]
        })
        .collect();
    lines.extend(words(&rows));
    lines
}

pub(super) fn system_text(system: &LibrarySystem) -> Result<(Vec<String>, Described), SystemError> {
    let (about, defaults) = (system.about()?, system.defaults()?);
    let dimension = system.dimension()?;
    let mut lines = vec![
        format!("{} (library system): {}", system.id, about.title),
        String::new(),
    ];
    labelled(&mut lines, "what", &about.summary);
    labelled(&mut lines, "dimension", &dimension.to_string());
    labelled(&mut lines, "orbit", &about.orbit);
    labelled(&mut lines, "literature", &about.reference.to_string());
    lines.push(String::new());
    let table = system.text.split("[system]").nth(1).unwrap_or_default();
    let table = table.split("[default]").next().unwrap_or_default();
    lines.push("  [system]".to_owned());
    lines.extend(
        table
            .trim()
            .lines()
            .map(|line| format!("  {line}").trim_end().to_owned()),
    );
    lines.push(String::new());
    let steps = match &defaults.paced {
        Some(paced) => format!("at the pace {}", paced.pace),
        None => format!("of {}", defaults.time_step),
    };
    lines.push(format!(
        "  `leafwise new --library {}` writes a scene of it, with steps {steps}.",
        system.id
    ));
    let described = Described::System {
        name: system.id,
        kind: "system",
        title: about.title,
        summary: about.summary,
        dimension,
        orbit: about.orbit,
        literature: about.reference.to_string(),
        time_step: defaults.time_step,
        system: table.trim(),
    };
    Ok((lines, described))
}

fn lie_algebra(algebra: &LieAlgebra) -> (Vec<String>, Described) {
    let coordinate = |k: usize| algebra.coordinates[k];
    let entries: Vec<(String, String)> = algebra
        .bracket
        .iter()
        .map(|(i, j, terms)| {
            let sum: Vec<String> = terms
                .iter()
                .map(|(coefficient, k)| match coefficient {
                    1 => coordinate(*k).to_owned(),
                    -1 => format!("-{}", coordinate(*k)),
                    _ => format!("{coefficient}*{}", coordinate(*k)),
                })
                .collect();
            (
                format!("{},{}", coordinate(*i), coordinate(*j)),
                sum.join(" + "),
            )
        })
        .collect();
    let mut lines = vec![
        format!("{} (Lie algebra): {}", algebra.name, algebra.summary),
        String::new(),
        format!("  variables = {:?}", algebra.coordinates),
        format!(
            "  bracket   = {{ lie-algebra = \"{}\" }}    which is",
            algebra.name
        ),
        String::new(),
    ];
    lines.extend(
        entries
            .iter()
            .map(|(pair, value)| format!("  {{{pair}}} = {value}")),
    );
    let described = Described::LieAlgebra {
        name: algebra.name,
        kind: "lie-algebra",
        summary: algebra.summary,
        variables: algebra.coordinates,
        bracket: entries,
    };
    (lines, described)
}

/// A label with its text beside it, wrapped.
fn labelled(lines: &mut Vec<String>, label: &str, text: &str) {
    let mut line = format!("  {label:<12}");
    let mut is_empty = true;
    for word in text.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines.push(std::mem::replace(&mut line, " ".repeat(14)));
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    lines.push(line);
}
