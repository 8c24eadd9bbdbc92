//! Measuring process of `leafwise plugin check`: it tries a library, and measures its parts against what they declare.

use std::path::Path;

use leafwise::conformance::{Conformance, Finding, conformance};
use leafwise::core::PartKind;
use leafwise::plugins::{LoadedPlugin, PluginRequest, Tried};
use leafwise::verify::Judgement;
use serde::Serialize;

use crate::arguments::{PluginArguments, PluginCheckArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

/// The object of `plugin check --json`.
#[derive(Serialize)]
struct MeasuresJson<'a> {
    outcome: &'static str,
    plugin: Library<'a>,
    parts: Vec<Part<'a>>,
}

/// The library.
#[derive(Serialize)]
struct Library<'a> {
    path: &'a Path,
    sha256: &'a str,
    id: &'a str,
    version: &'a str,
    abi: &'a str,
}

/// One of its parts.
#[derive(Serialize)]
struct Part<'a> {
    id: &'a str,
    kind: PartKind,
    met: bool,
    measured: bool,
    #[serde(flatten)]
    tried: &'a Tried,
    findings: &'a [Finding],
}

impl<'a> MeasuresJson<'a> {
    fn of(plugin: &'a LoadedPlugin, reports: &'a [(Conformance, &Tried)], is_met: bool) -> Self {
        let declaration = &plugin.declaration;
        let part = |(report, tried): &'a (Conformance, &Tried)| Part {
            id: report.part.name,
            kind: report.part.kind,
            met: report.is_met(),
            measured: report.is_measured(),
            tried,
            findings: &report.findings,
        };
        Self {
            outcome: if is_met { "met" } else { "not met" },
            plugin: Library {
                path: &plugin.path,
                sha256: &plugin.sha256,
                id: &declaration.id,
                version: &declaration.version,
                abi: &declaration.abi,
            },
            parts: reports.iter().map(part).collect(),
        }
    }
}

/// Tries the library in a process of its own, loads it, and measures every part; returns the exit code.
///
/// # Errors
/// [`Failure::Plugin`] where the library is refused.
pub fn execute(
    arguments: &PluginCheckArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let mut parts = Parts::trying_anew(plugins)?;
    let plugin = parts.load(&PluginRequest::new(&arguments.path), Path::new("."))?;
    if !arguments.json {
        head(&plugin).iter().for_each(|line| console.result(line));
    }
    let mut reports = Vec::with_capacity(plugin.declaration.parts.len());
    for (declared, tried) in plugin.declaration.parts.iter().zip(&plugin.tried) {
        let report = conformance(&parts.registry, declared.id())?;
        if !arguments.json {
            console.result(&format!(
                "\n{}, a {}",
                declared.id(),
                declared.kind().noun()
            ));
            body(&report, tried)
                .iter()
                .for_each(|line| console.result(line));
        }
        reports.push((report, tried));
    }
    let broken = count(&reports, Judgement::NotMet);
    let unmeasured = unmeasured(&reports);
    let is_met = broken == 0 && unmeasured.is_empty();
    if arguments.json {
        console.json(&MeasuresJson::of(&plugin, &reports, is_met));
    } else {
        console.result("");
        verdict(&reports, broken, &unmeasured)
            .iter()
            .for_each(|line| console.result(line));
    }
    Ok(if is_met {
        exit::DONE
    } else {
        exit::CHECK_FAILED
    })
}

/// The parts of which nothing is known.
fn unmeasured(reports: &[(Conformance, &Tried)]) -> Vec<&'static str> {
    let unknown = reports.iter().filter(|(report, _)| !report.is_measured());
    unknown.map(|(report, _)| report.part.name).collect()
}

fn count(reports: &[(Conformance, &Tried)], judgement: Judgement) -> usize {
    let findings = reports.iter().flat_map(|(report, _)| &report.findings);
    findings.filter(|f| f.judgement == judgement).count()
}

/// Lines on a library, as it declares itself: path, id and version, SHA-256 and ABI, then licence and toolchain where
/// it names them.
fn head(plugin: &LoadedPlugin) -> Vec<String> {
    let declaration = &plugin.declaration;
    let mut rows = vec![
        vec![
            "  plugin".to_owned(),
            format!("{} {}", declaration.id, declaration.version),
        ],
        vec!["  sha256".to_owned(), plugin.sha256.clone()],
        vec!["  ABI".to_owned(), declaration.abi.clone()],
    ];
    let optional = [
        ("  licence", &declaration.license),
        ("  toolchain", &declaration.toolchain),
    ];
    for (label, said) in optional {
        if let Some(said) = said {
            rows.push(vec![label.to_owned(), said.clone()]);
        }
    }
    let mut lines = vec![plugin.path.display().to_string()];
    lines.extend(words(&rows));
    lines
}

/// The contract, then what was measured, problem by problem.
fn body(report: &Conformance, tried: &Tried) -> Vec<String> {
    let mut rows = vec![contract(tried)];
    rows.extend(static_data(tried));
    rows.extend(report.findings.iter().map(row));
    words(&rows)
}

/// Row on the contract of calls: a library that breaks it would have been refused.
fn contract(tried: &Tried) -> Vec<String> {
    let (mark, on) = if tried.problems.is_empty() {
        let why = match tried.refusals.as_slice() {
            [] => "it has formulas alone, which are not called".to_owned(),
            reasons => format!("no problem here fits it; {}", reasons.join("; ")),
        };
        ("-", why)
    } else {
        ("ok", format!("on {}", tried.problems.join(", ")))
    };
    vec![
        format!("  {mark}"),
        "calls: finite, repeatable, alone as in a batch and on several threads, nothing else written"
            .to_owned(),
        on,
    ]
}

/// Row on the library's static data, which instances share and which may be harmless; `None` where no function writes
/// any.
fn static_data(tried: &Tried) -> Option<Vec<String>> {
    let functions = &tried.writing_static_data;
    (!functions.is_empty()).then(|| {
        vec![
            "  ?".to_owned(),
            "static data of the library".to_owned(),
            format!(
                "written in {}: instances run on several threads at once, so put scratch space in \
                 the instance or on the stack",
                functions.join(", ")
            ),
        ]
    })
}

fn row(finding: &Finding) -> Vec<String> {
    let mark = match finding.judgement {
        Judgement::Met => "ok",
        Judgement::NotMet => "FAILS",
        Judgement::Undecided => "?",
        Judgement::Open => "-",
    };
    let place = match finding.path {
        Some(path) => format!("{} ({path})", finding.problem),
        None => finding.problem.clone(),
    };
    vec![
        format!("  {mark}"),
        finding.quantity.clone(),
        format!("{}: {}", place, finding.found),
    ]
}

fn verdict(reports: &[(Conformance, &Tried)], broken: usize, unmeasured: &[&str]) -> Vec<String> {
    let all: usize = reports
        .iter()
        .map(|(report, _)| report.findings.len())
        .sum();
    let mut lines = vec![match broken {
        0 => format!("no measurement contradicts what is declared ({all} measurements)"),
        1 => format!("one of {all} measurements contradicts what is declared"),
        many => format!("{many} of {all} measurements contradict what is declared"),
    }];
    if !unmeasured.is_empty() {
        lines.push(format!(
            "nothing could be measured of {}: offer a system that it serves in the same plugin",
            unmeasured.join(", ")
        ));
    }
    let undecided = count(reports, Judgement::Undecided);
    if undecided > 0 {
        lines.push(format!(
            "{undecided} with a `?` decide nothing: too few errors lie between round-off and the \
             range where powers of the step rule"
        ));
    }
    lines
}
