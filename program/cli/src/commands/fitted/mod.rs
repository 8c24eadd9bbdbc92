//! Scenes that generating functions are fitted to: shared by `learn` and `tabulate`.

use leafwise::generating_function::{NAME as DYNAMICS, TIME_STEP};
use leafwise::learn::{LearnError, Learned};
use leafwise::scene::compose::compose;
use leafwise::scene::{
    ComposedRun, MethodParts, MethodTable, PartUse, RewriteError, SceneDocument, with_hamiltonian,
    with_system,
};

mod basis;

pub(super) use self::basis::{axes, degree};
use crate::bar::while_building;
use crate::failure::Failure;
use crate::plugins::Parts;
use crate::pulse::Shown;
use crate::scene::SceneText;

/// The scene over a realization with a chart: its own where it names one, else the one that fits the tensor.
pub(super) fn with_chart(
    parts: &mut Parts,
    document: &SceneDocument,
    shown: Shown,
) -> Result<(SceneDocument, ComposedRun), Failure> {
    let run = while_building(shown, || compose(document, &parts.registry))?;
    if run.system.has_forces() {
        return Err(Failure::usage(
            "a motion with forces or friction is not a Hamiltonian flow, and has no generating function",
            format!(
                "{} of the scene, and remove their work from the data",
                run.without_forces()
            ),
        ));
    }
    let own = run.method.written().filter(|method| {
        let abilities = method.realization().abilities();
        abilities.ends.is_some() && abilities.lift.is_none()
    });
    let named = MethodTable::of_choices(&run.plan.parts).and_then(|table| match table.parts {
        MethodParts::Pair { realization, .. } if own.is_some() => Some(realization),
        _ => None,
    });
    let realization = named.unwrap_or_else(|| PartUse::named("auto"));
    let table = MethodTable::pair(realization, PartUse::named(DYNAMICS).with("order", 2_i64));
    let text = table.write_into(
        &document.text,
        run.plan.epsilon * run.plan.h,
        run.plan.steps,
    );
    let text = text.map_err(unwritten)?;
    let document = again(parts, document, text)?;
    let run = while_building(shown, || compose(&document, &parts.registry))?;
    Ok((document, run))
}

/// The scene with another text.
pub(super) fn again(
    parts: &mut Parts,
    document: &SceneDocument,
    text: String,
) -> Result<SceneDocument, Failure> {
    parts.document(SceneText::again(document, text), document.directory())
}

/// The scene of the learned map of this time step: H, and Ŝ by S_1 = H and what is beside it. A table holds for this step alone.
pub(super) fn learned_scene(
    document: &SceneDocument,
    run: &ComposedRun,
    learned: &Learned,
    (time_step, is_table): (f64, bool),
) -> Result<String, Failure> {
    let text = match with_hamiltonian(&document.text, &learned.hamiltonian).map_err(unwritten)? {
        Some(text) => text,
        None => {
            let system = run.system.formulas("learning")?;
            let fragment = with_hamiltonian(&system.fragment(), &learned.hamiltonian);
            let fragment = fragment.map_err(unwritten)?.unwrap_or_default();
            with_system(&document.text, &fragment).map_err(unwritten)?
        }
    };
    let coefficients: Vec<&str> = std::iter::once("H")
        .chain(learned.further.as_deref())
        .collect();
    let mut table = MethodTable::of_choices(&run.plan.parts)
        .ok_or_else(|| Failure::usage("a stepper has no map to learn", "name a realization"))?;
    if let MethodParts::Pair { dynamics, .. } = &mut table.parts {
        *dynamics = PartUse::named(DYNAMICS)
            .with("S", coefficients.join("; ").as_str())
            .with("order", 2_i64);
        if is_table {
            *dynamics = dynamics.clone().with(TIME_STEP, time_step.abs());
        }
    }
    table
        .write_into(&text, time_step, run.plan.steps)
        .map_err(unwritten)
}

/// A refusal of a scene that is not written anew.
pub(super) fn unwritten(error: RewriteError) -> Failure {
    Failure::usage(
        error.to_string(),
        "name a scene with [system], [method] and [run]",
    )
}

/// A refusal whose help names the page of the command.
pub(super) fn refused(error: LearnError, command: &str) -> Failure {
    match error {
        LearnError::Build(error) => error.into(),
        error => Failure::usage(
            error.to_string(),
            format!("`leafwise explain {command}` says what is fitted to pairs"),
        ),
    }
}
