//! `leafwise orbit --continue`: the family of an orbit, as text, JSON, a table and a figure.

use std::path::Path;

use leafwise::orbit::{Along, Ends, FamilyOrbit, Following, Hold, Mark, OrbitFamily, follow};
use leafwise::report::{Chart, ChartAxis, PanelSeries, Stroke};
use leafwise::run::csv::Table;
use leafwise::scene::compose::ComposedRun;
use serde::Serialize;

use super::{OrbitJson, refused};
use crate::arguments::OrbitArguments;
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::{make_directory, write, write_json};
use crate::table::{aligned_after, short};

/// The object of `orbit --continue --json`.
#[derive(Serialize)]
struct FamilyJson<'a> {
    /// The quantity that is continued.
    along: &'a str,
    /// Where the family ends: `reached`, `returned`, `many`, `equilibrium`, `no-branch` or `lost`.
    ends: &'static str,
    /// Why, where no further orbit closes.
    reason: Option<String>,
    orbits: Vec<MemberJson>,
}

/// An orbit of it.
#[derive(Serialize)]
struct MemberJson {
    value: f64,
    /// `fold`, `branch`, `period-doubling`, `energy-fold` or `krein`.
    mark: Option<&'static str>,
    #[serde(flatten)]
    orbit: OrbitJson,
}

/// Follows the family and prints its orbits. Returns the exit code.
///
/// # Errors
/// [`Failure`] where the first orbit does not close, for what cannot be continued, and for files that cannot be written.
pub(super) fn execute(
    (arguments, method): (&OrbitArguments, String),
    run: &ComposedRun,
    (period, steps, hold): (f64, u64, Hold),
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let (name, to) = named(arguments.along.as_deref().unwrap_or_default())?;
    let following = Following {
        along: match name {
            "energy" => Along::Energy,
            "period" => Along::Period,
            parameter => Along::Parameter(parameter.to_owned()),
        },
        to,
        most: arguments.orbits,
        branch: arguments.branch,
    };
    if let Some(directory) = &arguments.out {
        make_directory(directory)?;
    }
    let shown = console.shown(false);
    let follow = || follow(run, (period, steps), hold, &following);
    let family = while_building(shown, follow).map_err(refused)?;
    let names = run.names();
    let json = || FamilyJson {
        along: name,
        ends: ends(&family.ends).0,
        reason: match &family.ends {
            Ends::Lost(error) => Some(error.to_string()),
            _ => None,
        },
        orbits: (family.members.iter())
            .map(|member| MemberJson {
                value: member.value,
                mark: member.mark.map(mark),
                orbit: OrbitJson::of(&member.orbit, &names),
            })
            .collect(),
    };
    if let Some(directory) = &arguments.out {
        write_files(directory, (name, &family, &names))?;
        write_json(&directory.join("family.json"), &json())?;
    }
    if arguments.json {
        console.json(&json());
    } else {
        console.result(&format!("A family of periodic orbits of {method}"));
        console.result("");
        for line in aligned_after(&rows(name, &family), 1) {
            console.result(&line);
        }
        console.result("");
    }
    let told = ends(&family.ends).1;
    match &family.ends {
        Ends::Reached => console.prose(told),
        Ends::Lost(error) => console.warn(&format!("{told}: {error}")),
        _ => console.warn(told),
    }
    Ok(match family.ends {
        Ends::Reached => exit::DONE,
        _ => exit::SOME_FAILED,
    })
}

/// NAME=TO.
fn named(text: &str) -> Result<(&str, f64), Failure> {
    let parts = text.split_once('=');
    let parts = parts.and_then(|(name, to)| Some((name.trim(), to.trim().parse().ok()?)));
    parts.ok_or_else(|| {
        Failure::usage(
            format!("--continue {text} names no value"),
            "as in --continue energy=-1.5, --continue period=7 or --continue mu=0.1",
        )
    })
}

fn mark(mark: Mark) -> &'static str {
    match mark {
        Mark::Fold => "fold",
        Mark::Branch => "branch",
        Mark::Doubling => "period-doubling",
        Mark::EnergyFold => "energy-fold",
        Mark::Krein => "krein",
    }
}

/// A word, and a sentence.
fn ends(ends: &Ends) -> (&'static str, &'static str) {
    match ends {
        Ends::Reached => ("reached", "the family reaches the value"),
        Ends::Returned => (
            "returned",
            "the family turns back by a fold, past its beginning, and never reaches the value",
        ),
        Ends::Many => ("many", "the family goes on: give more --orbits"),
        Ends::Equilibrium => (
            "equilibrium",
            "the family ends at an equilibrium, to which its orbits shrink",
        ),
        Ends::NoBranch => (
            "no-branch",
            "the family reaches the value before as many branch points: name another --branch, or a value further away",
        ),
        Ends::Lost(_) => ("lost", "the family cannot be followed further"),
    }
}

/// The largest multiplier's size.
fn largest(member: &FamilyOrbit) -> Option<f64> {
    let first = member.orbit.multipliers.first();
    first.map(|of| of.modulus())
}

fn rows(name: &str, family: &OrbitFamily) -> Vec<Vec<String>> {
    let is_own = name != "energy" && name != "period";
    let mut headings = vec!["orbit".to_owned()];
    headings.extend(is_own.then(|| name.to_owned()));
    headings.extend(["energy", "period", "largest multiplier", "stability"].map(str::to_owned));
    let mut rows = vec![headings];
    for (at, member) in family.members.iter().enumerate() {
        let label = member
            .mark
            .map_or_else(|| (at + 1).to_string(), |own| mark(own).to_owned());
        let mut row = vec![label];
        row.extend(is_own.then(|| short(member.value)));
        row.extend([
            short(member.orbit.energy),
            short(member.orbit.period),
            largest(member).map_or_else(String::new, |size| format!("{size:.6}")),
            match member.orbit.is_stable() {
                true => "stable".to_owned(),
                false => "unstable".to_owned(),
            },
        ]);
        rows.push(row);
    }
    rows
}

/// `family.csv` and `family.svg`: energy and period along the family, with its marks.
fn write_files(
    directory: &Path,
    (name, family, names): (&str, &OrbitFamily, &[String]),
) -> Result<(), Failure> {
    let headings = [
        "value",
        "mark",
        "energy",
        "period",
        "largest_multiplier",
        "stable",
    ];
    let mut table = Table::new(
        headings
            .iter()
            .copied()
            .chain(names.iter().map(String::as_str)),
    );
    for member in &family.members {
        let orbit = &member.orbit;
        table
            .number(member.value)
            .text(member.mark.map_or("", mark))
            .number(orbit.energy)
            .number(orbit.period)
            .optional(largest(member))
            .whole(u64::from(orbit.is_stable()))
            .numbers(orbit.state.iter().copied())
            .end_row();
    }
    write(&directory.join("family.csv"), table.as_str())?;
    let (title, over): (&str, fn(&FamilyOrbit) -> f64) = match name {
        "period" => ("energy", |member| member.orbit.energy),
        _ => ("period", |member| member.orbit.period),
    };
    let point = |member: &FamilyOrbit| (member.value, over(member));
    let curve = |name: &str, stroke, points: Vec<(f64, f64)>| PanelSeries {
        name: name.to_owned(),
        points,
        stroke,
    };
    let mut series = vec![curve(
        "family",
        Stroke::Line,
        family.members.iter().map(point).collect(),
    )];
    for own in [
        Mark::Fold,
        Mark::Branch,
        Mark::Doubling,
        Mark::EnergyFold,
        Mark::Krein,
    ] {
        let marked = family.members.iter();
        let marked = marked.filter(|member| member.mark == Some(own));
        let points: Vec<_> = marked.map(point).collect();
        if !points.is_empty() {
            series.push(curve(mark(own), Stroke::Points, points));
        }
    }
    let axis = |title: &str| ChartAxis {
        title: title.to_owned(),
        ..ChartAxis::default()
    };
    let chart = Chart {
        x: axis(name),
        y: axis(title),
        series,
        is_equal: false,
    };
    write(&directory.join("family.svg"), &chart.svg()?)
}
