//! A whole scene.

use std::ops::Range;
use std::path::Path;

use leafwise_core::Registry;
use toml::de::DeTable;

use super::ensemble::{EnsembleSection, read_ensemble};
use super::error::{SceneErrors, SceneProblem, SceneProblemCause, source_text};
use super::field::FieldSpec;
use super::located::{Located, Place, Source};
use super::method::{MethodSection, read_method};
use super::overrides::apply_overrides;
use super::plugin::{PluginSpec, read_plugins};
use super::reader::{Problems, Table, end_of};
use super::run::{InitialSpec, RunSection, count_steps, read_run};
use super::schema::SCENE;
use super::sweep::{SweepSection, read_sweep};
use super::system::read_system;
use super::system_section::SystemSection;
use crate::diagnostic::{SceneDiagnostic, formula_span};

/// A scene: its text and what the text says.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDocument {
    /// The file name, for messages.
    pub name: String,
    /// The text as run: after overrides. Places in [`Source::Scene`] refer to it.
    pub text: String,
    /// The library fragment used, as id and text.
    pub fragment: Option<(String, String)>,
    /// The Poisson manifold and the Hamiltonian.
    pub system: SystemSection,
    /// The integrator and its step.
    pub method: MethodSection,
    /// Where to start, how far to go, what to keep.
    pub run: RunSection,
    /// Many initial states or parameter sets at once.
    pub ensemble: Option<EnsembleSection>,
    /// One run for each of many settings.
    pub sweep: Option<SweepSection>,
    /// Shared libraries to load first.
    pub plugins: Vec<PluginSpec>,
}

impl SceneDocument {
    /// Reads a scene as [`parse_with`](Self::parse_with) does; Casimirs are not looked for.
    ///
    /// # Errors
    /// Those of [`parse_with`](Self::parse_with).
    pub(crate) fn read_with(
        name: &str,
        text: &str,
        overrides: &[(String, String)],
        registry: &Registry,
    ) -> Result<Self, SceneErrors> {
        let mut problems = Problems::default();
        let mut fragment = None;
        let effective = apply_overrides(text, overrides, &mut problems);
        let sections = match &effective {
            Some(effective) => read(effective, registry, &mut fragment, &mut problems),
            None => None,
        };
        let text = effective.unwrap_or_else(|| text.to_owned());
        let name = name.to_owned();
        match sections {
            Some((system, method, run, ensemble, sweep, plugins)) if problems.0.is_empty() => {
                Ok(Self {
                    name,
                    text,
                    fragment,
                    system,
                    method,
                    run,
                    ensemble,
                    sweep,
                    plugins,
                })
            }
            _ => {
                let mut problems = without_consequences(problems.0);
                problems.sort_by_key(|problem| match problem.place.source {
                    Source::Override(_) => (0, problem.place.span.start),
                    Source::Scene => (1, problem.place.span.start),
                    Source::Library(_) => (2, problem.place.span.start),
                });
                // The text is then not that of the file.
                let name = match overrides.is_empty() {
                    true => name,
                    false => format!("{name} with --set"),
                };
                Err(SceneErrors {
                    name,
                    text,
                    fragment,
                    problems,
                })
            }
        }
    }

    /// Where the files are that it names: beside it.
    pub fn directory(&self) -> &Path {
        Path::new(&self.name).parent().unwrap_or(Path::new(""))
    }

    /// The files that it reads values of sites and tables from; an array in the place of a file by its table's name.
    pub fn files(&self) -> Vec<String> {
        let fields = match &self.run.initial.value {
            InitialSpec::Fields(fields) => fields.as_slice(),
            InitialSpec::Vector(_) => &[],
        };
        let sites = self.system.sites.iter().chain(fields);
        let matrices = self.system.matrices.iter().map(|matrix| &matrix.field);
        let all = sites.map(|(_, field)| field).chain(matrices);
        let files = all.filter_map(|field| match field {
            FieldSpec::File { file, .. } => Some(file.value.clone()),
            _ => None,
        });
        let tables = self.system.tables.iter().filter_map(|(name, table)| {
            match (&table.numbers, &table.file) {
                (Some(_), _) => Some(format!("the array `{}`", name.value)),
                (None, file) => file.as_ref().map(|file| file.value.clone()),
            }
        });
        files.chain(tables).collect()
    }

    /// A diagnostic at a place of this scene.
    pub fn diagnostic(
        &self,
        place: &Place,
        message: impl Into<String>,
        label: impl Into<String>,
        help: Option<String>,
    ) -> SceneDiagnostic {
        let (source_name, source_text) = source_text(
            &place.source,
            &self.name,
            &self.text,
            self.fragment.as_ref(),
        );
        SceneDiagnostic {
            message: message.into(),
            label: label.into(),
            source_name,
            source_text,
            span: place.span.clone(),
            help,
        }
    }

    /// The place of the bytes `inner` of a formula: the exact piece of the file where the
    /// string is written plainly, the whole string where it has escapes.
    pub fn place_in_formula(&self, formula: &Located<String>, inner: Range<usize>) -> Place {
        let (_, text) = source_text(
            &formula.source,
            &self.name,
            &self.text,
            self.fragment.as_ref(),
        );
        Place {
            source: formula.source.clone(),
            span: formula_span(&text, formula.span.clone(), inner),
        }
    }
}

/// Drops "needs `epsilon`" where "unknown key `epsillon`, did you mean `epsilon`?" stands.
fn without_consequences(problems: Vec<SceneProblem>) -> Vec<SceneProblem> {
    let misspelled: Vec<(String, String)> = problems
        .iter()
        .filter_map(|problem| match &problem.cause {
            SceneProblemCause::UnknownKey {
                table,
                nearest: Some(key),
                ..
            } => Some((table.clone(), key.clone())),
            _ => None,
        })
        .collect();
    let is_consequence = |problem: &SceneProblem| match &problem.cause {
        SceneProblemCause::MissingKey { table, key, .. } => {
            let stands_for =
                |k: &str| k == key || (["epsilon", "h"].contains(&k) && key == "time-step");
            misspelled.iter().any(|(t, k)| t == table && stands_for(k))
        }
        _ => false,
    };
    problems
        .into_iter()
        .filter(|problem| !is_consequence(problem))
        .collect()
}

type Sections = (
    SystemSection,
    MethodSection,
    RunSection,
    Option<EnsembleSection>,
    Option<SweepSection>,
    Vec<PluginSpec>,
);

fn read(
    text: &str,
    registry: &Registry,
    fragment: &mut Option<(String, String)>,
    problems: &mut Problems,
) -> Option<Sections> {
    let document = match DeTable::parse(text) {
        Ok(document) => document,
        Err(error) => {
            problems.syntax(error.message(), error.span(), (text, Source::Scene));
            return None;
        }
    };
    let root = Table::new("the scene", document.get_ref(), end_of(text), text);
    root.only(&SCENE, problems);
    let mut section = |key: &str, example: &str| {
        root.require(key, example, problems)
            .and_then(|item| item.table(&format!("[{key}]"), "a table", problems))
    };
    let system = section("system", "[system] with library = \"rigid-body\"");
    let method = section(
        "method",
        "[method] with realization = \"auto\", dynamics = \"auto\" and time-step = 0.1",
    );
    let run = section("run", "[run] with initial = [1, 3, 3] and steps = 1000");
    let system = system
        .as_ref()
        .and_then(|table| read_system(table, registry, fragment, problems));
    let mut method = method
        .as_ref()
        .and_then(|table| read_method(table, registry, problems));
    let run = run
        .as_ref()
        .and_then(|table| read_run(table, system.as_ref(), problems))
        .map(|mut run| {
            // Where the step or the end is given twice, neither is known.
            if let Some(method) = method.as_mut().filter(|_| !problems.has_conflict()) {
                count_steps(&mut run, method, problems);
            }
            run
        });
    let ensemble = match root.get("ensemble") {
        Some(item) => item
            .table("[ensemble]", "a table", problems)
            .and_then(|table| read_ensemble(&table, system.as_ref(), problems))
            .map(Some),
        None => Some(None),
    };
    let sweep = match root.get("sweep") {
        Some(item) => item
            .table("[sweep]", "a table", problems)
            .and_then(|table| read_sweep(&table, system.as_ref(), problems))
            .map(Some),
        None => Some(None),
    };
    let plugins = read_plugins(&root, problems);
    Some((system?, method?, run?, ensemble?, sweep?, plugins?))
}
