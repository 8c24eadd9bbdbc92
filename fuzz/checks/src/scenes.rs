//! Random scenes take a few steps: finite states or a typed failure, the same bits by machine code.

use leafwise::core::{Registry, StepMap, Walk};
use leafwise::expression::Execution;
use leafwise::scene::{ComposedRun, SceneDocument, compose};

use crate::Reached;
use crate::scene::RandomScene;
use crate::source::Source;

const STEPS: usize = 3;

/// A random scene, or behind a byte 255 a scene's text.
///
/// # Errors
/// A state that is not finite, or bits that differ, with the scene.
pub fn check(bytes: &[u8]) -> Result<Reached, String> {
    let text = match bytes.split_first() {
        Some((255, text)) => String::from_utf8_lossy(text).into_owned(),
        _ => RandomScene::drawn(&mut Source::new(bytes)).text,
    };
    same_bits(&text, STEPS).map_err(|what| format!("{what}\n{text}"))
}

/// Whether a scene is composed and stepped, to the same bits by both kernels.
///
/// # Errors
/// What is wrong.
pub fn same_bits(text: &str, steps: usize) -> Result<Reached, String> {
    let registry = Registry::with_builtin();
    let Ok(document) = SceneDocument::parse("scene.toml", text, &registry) else {
        return Ok(Reached::Refusal);
    };
    if document.system.dimension() > crate::LARGEST {
        return Ok(Reached::Refusal);
    }
    let Ok(run) = compose(&document, &registry) else {
        return Ok(Reached::Refusal);
    };
    same_bits_of(&run, steps)
}

/// Whether a run steps to the same bits by both kernels.
///
/// # Errors
/// What is wrong.
pub fn same_bits_of(run: &ComposedRun, steps: usize) -> Result<Reached, String> {
    let [interpreted, compiled] =
        [Execution::Interpreted, Execution::Compiled].map(|how| states(run, how, steps));
    if interpreted
        .iter()
        .flatten()
        .any(|x| !f64::from_bits(*x).is_finite())
    {
        return Err(format!("a state is not finite: {interpreted:x?}"));
    }
    if interpreted != compiled {
        return Err(format!(
            "machine code leads to {compiled:x?}, the interpreter to {interpreted:x?}"
        ));
    }
    let has_stepped = interpreted.len() > 1;
    Ok(if has_stepped {
        Reached::Comparison
    } else {
        Reached::Refusal
    })
}

/// The states that the run comes to, up to a typed failure.
fn states(run: &ComposedRun, how: Execution, steps: usize) -> Vec<Vec<u64>> {
    // What workers are made for is that of the process; checks that set it hold a lock.
    let _held = crate::EXECUTION
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    how.set_default_of_process();
    let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect();
    let plan = &run.plan;
    let map: &dyn StepMap = run.method.map();
    let values = run.system.parameter_values();
    let mut walk = Walk::new(map, &values, plan.epsilon, plan.h, &plan.initial);
    let mut states = vec![bits(walk.state())];
    for _ in 0..steps {
        if walk.step().is_err() {
            break;
        }
        states.push(bits(walk.state()));
    }
    states
}
