//! Plan of a sweep: the methods that its settings need, each composed once.

use std::collections::BTreeMap;
use std::ops::Range;

use leafwise_core::Registry;

use super::columns::SweepColumns;
use super::settings::{Settings, section};
use crate::RunError;
use crate::start::checked;
use crate::state_error::refuse_estimate;
use leafwise_scene::SceneErrors;
use leafwise_scene::compose::{ComposedRun, Refusal, SceneChecks, compose};
use leafwise_scene::document::{RecordSpec, SceneDocument};

/// A sweep with the methods of its settings.
///
/// A row is that of the run with the setting's values, to the bit. Settings that differ in parameters, initial state and steps
/// share a method, whose parts chose what they are made of at the scene's own parameters: `[method] chosen-at` of a single run.
pub struct ComposedSweep<'a> {
    /// The scene's own run.
    pub base: ComposedRun,
    /// Its checks.
    pub(super) checks: SceneChecks,
    pub(super) settings: Settings,
    pub(super) columns: SweepColumns,
    registry: &'a Registry,
    composed: Vec<Composed>,
    /// The settings that it is composed for, and the method of each.
    items: Range<u64>,
    methods: Vec<u32>,
}

/// A method with the scene that it is of, whose own values stand where settings do not say.
struct Composed {
    document: SceneDocument,
    run: ComposedRun,
}

/// Settings between two that are told of.
const TOLD_EVERY: u64 = 64;

/// Values by keys.
type Pairs<'a> = Vec<(&'a str, &'a str)>;

/// Builds the methods of some settings, and checks every one of these. None is run before all are known to be valid.
/// Now and then `progress` is told how many of how many were.
///
/// # Errors
/// [`RunError::Refused`] for the first setting whose scene is not valid, underlined in that scene.
pub fn compose_sweep<'a>(
    document: &SceneDocument,
    registry: &'a Registry,
    settings: Settings,
    items: Range<u64>,
    allow_non_poisson: bool,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<ComposedSweep<'a>, RunError> {
    refuse_estimate(document, "a sweep").map_err(RunError::Refused)?;
    let mut own = recording(document.clone()).map_err(RunError::Refused)?;
    let base = compose(&own, registry).map_err(RunError::Refused)?;
    let checks = checked(&own, &base, allow_non_poisson)?;
    // The text is read again for each method, and never for a setting.
    own.sweep = None;
    let columns = SweepColumns::of(&settings, &base);
    let mut sweep = ComposedSweep {
        composed: vec![Composed {
            document: own,
            run: base.clone(),
        }],
        base,
        checks,
        settings,
        columns,
        registry,
        methods: Vec::with_capacity((items.end - items.start) as usize),
        items: items.clone(),
    };
    let mut known = BTreeMap::from([(Vec::new(), 0)]);
    let (first, count) = (items.start, items.end - items.start);
    for setting in items {
        let done = setting - first;
        if done.is_multiple_of(TOLD_EVERY) {
            progress(done, count);
        }
        let before = sweep.methods();
        let method = sweep.method_of(setting, document, &mut known, allow_non_poisson)?;
        sweep.methods.push(method as u32);
        let run = sweep.run(setting).map_err(RunError::Refused)?;
        if let Some(run) = run.filter(|_| sweep.methods() > before) {
            sweep.check_columns(setting, &run)?;
        }
    }
    Ok(sweep)
}

/// The scene with what the sweep records.
fn recording(mut document: SceneDocument) -> Result<SceneDocument, Refusal> {
    let observables = section(&document)?.observables.clone();
    document.run.record = RecordSpec {
        every: u64::MAX,
        interval: None,
        times: None,
        observables,
        states: None,
        drift_every: document.run.record.drift_every,
    };
    Ok(document)
}

impl ComposedSweep<'_> {
    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The columns of the table.
    pub fn columns(&self) -> &SweepColumns {
        &self.columns
    }

    /// How many methods were composed, the scene's own among them.
    pub fn methods(&self) -> usize {
        self.composed.len()
    }

    /// The values of a setting that are given.
    fn pairs(&self, setting: u64) -> Pairs<'_> {
        let keys = self.settings.keys().iter();
        let pairs = keys.zip(self.settings.values(setting));
        pairs
            .filter_map(|(key, value)| Some((key.as_str(), value?)))
            .collect()
    }

    /// The place of a setting's method, composed unless it is `known`.
    fn method_of(
        &mut self,
        setting: u64,
        document: &SceneDocument,
        known: &mut BTreeMap<Vec<(String, String)>, usize>,
        allow_non_poisson: bool,
    ) -> Result<usize, RunError> {
        let pairs = self.pairs(setting);
        let mut probe = self.composed[0].document.clone();
        let mut made_of: Vec<(String, String)> = pairs
            .iter()
            .filter(|(key, value)| !probe.assign(key, value))
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
            .collect();
        loop {
            if let Some(place) = known.get(&made_of) {
                return Ok(*place);
            }
            let errors =
                |errors: SceneErrors| self.of_setting(setting, errors.diagnostics().remove(0));
            let read =
                SceneDocument::parse_with(&document.name, &document.text, &made_of, self.registry);
            let read = read.map_err(|e| RunError::Refused(errors(e)))?;
            let own = recording(read).map_err(RunError::Refused)?;
            // A key of another system may be none of values there.
            let mut probe = own.clone();
            let rest = pairs
                .iter()
                .filter(|(key, _)| !made_of.iter().any(|(known, _)| known == key));
            let wrong: Vec<_> = rest
                .filter(|(key, value)| !probe.assign(key, value))
                .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
                .collect();
            if !wrong.is_empty() {
                made_of.extend(wrong);
                continue;
            }
            let refused = |refusal: Refusal| RunError::Refused(self.of_setting(setting, *refusal));
            let mut own = own;
            own.sweep = None;
            let run = compose(&own, self.registry).map_err(refused)?;
            checked(&own, &run, allow_non_poisson).map_err(|error| match error {
                RunError::Refused(refusal) => refused(refusal),
                other => other,
            })?;
            let place = self.composed.len();
            known.insert(made_of, place);
            self.composed.push(Composed { document: own, run });
            return Ok(place);
        }
    }

    /// The run of a setting.
    ///
    /// # Errors
    /// What is wrong with it, underlined in its scene.
    pub(super) fn run(&self, setting: u64) -> Result<Option<ComposedRun>, Refusal> {
        let Some(method) = self.methods.get((setting - self.items.start) as usize) else {
            return Ok(None);
        };
        let composed = &self.composed[*method as usize];
        let mut document = composed.document.clone();
        let mut varied = Vec::new();
        for (key, value) in self.pairs(setting) {
            if document.assign(key, value)
                && let Some(name) = key.strip_prefix("system.parameters.")
            {
                varied.push(name);
            }
        }
        let own = |refusal: Refusal| self.of_setting(setting, *refusal);
        if let Some(run) = composed.run.at(&document).map_err(own)? {
            return Ok(Some(run));
        }
        let before = &composed.document.system.parameters;
        for (name, value) in before
            .iter()
            .filter(|(name, _)| varied.contains(&name.value.as_str()))
        {
            let chosen = &mut document.method.chosen_at;
            if !chosen.iter().any(|(known, _)| known.value == name.value) {
                chosen.push((name.clone(), value.clone()));
            }
        }
        compose(&document, self.registry).map(Some).map_err(own)
    }

    /// A diagnostic that names its setting.
    fn of_setting(&self, setting: u64, mut diagnostic: leafwise_scene::SceneDiagnostic) -> Refusal {
        let which = self.settings.describe(setting);
        diagnostic.message = format!("{which}: {}", diagnostic.message);
        diagnostic.source_name = diagnostic
            .source_name
            .replace("--set", &format!("setting {setting}"));
        Box::new(diagnostic)
    }

    /// All settings have the same columns.
    fn check_columns(&self, setting: u64, run: &ComposedRun) -> Result<(), RunError> {
        let found = SweepColumns::of(&self.settings, run);
        if found == self.columns {
            return Ok(());
        }
        let composed = &self.composed[0].document;
        let message = format!(
            "it has the columns {}, and the scene's own run {}",
            found.measured().join(", "),
            self.columns.measured().join(", ")
        );
        let place = &composed.system.hamiltonian.place();
        let help = "all settings of a sweep have the same Casimirs and observables: make a sweep for each system";
        let diagnostic = composed.diagnostic(place, message, "here", Some(help.to_owned()));
        Err(RunError::Refused(self.of_setting(setting, diagnostic)))
    }
}
