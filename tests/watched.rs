//! Steps that are made many at once before they are looked at, against the same steps one by one.

use leafwise::core::{BuildError, Registry};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise::walk::{Ended, Look, Watched};
use proptest::prelude::*;

/// A particle before a wall at q = 0: long steps of a method that is no Poisson map jump behind it, where H has no value.
const WALL: &str = r#"
[system]
variables   = ["q", "p"]
bracket     = { "q,p" = 1 }
hamiltonian = "p^2/2 + q - ln(q)"
[method]
stepper     = "rk4"
time-step   = STEP
[run]
initial = [Q, 0.3]
steps   = 700
"#;

fn composed(q: f64, step: f64) -> ComposedRun {
    let text = WALL
        .replace("STEP", &format!("{step:?}"))
        .replace('Q', &format!("{q:?}"));
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("wall.toml", &text, &registry).expect("a scene");
    compose(&document, &registry).expect("a method")
}

/// All that a walk comes to, to the bit.
#[derive(Debug, Default, PartialEq)]
struct Story {
    made: Vec<(u64, u64, Vec<u64>)>,
    looked_at: Vec<(u64, Option<Vec<u64>>)>,
    ended: Vec<Ended>,
    evaluations: u64,
    state: Vec<u64>,
    steps: u64,
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// The story of strides: 0 is one step by itself.
fn story(run: &ComposedRun, strides: &[u64]) -> Story {
    let course = run.course(&[]).expect("code");
    let parameters = run.system.parameter_values();
    let start = (parameters.as_slice(), run.plan.initial.as_slice());
    let mut walk = Watched::new(&course, run.method.map(), 1, start).expect("a walk");
    let mut story = Story::default();
    let mut take = |look: Look<'_>| -> Result<(), BuildError> {
        match look {
            Look::Made(at) => story.made.push((at.steps, at.evaluations, bits(at.state))),
            Look::Step { at, invariants, .. } => {
                story.looked_at.push((at.steps, invariants.map(bits)));
            }
            Look::Steps(steps) => {
                for k in 0..steps.count {
                    let at = steps.at(k);
                    let invariants = [steps.invariant(0)[k]];
                    assert_eq!(steps.coordinate(1)[k].to_bits(), at.state[1].to_bits());
                    story.made.push((at.steps, at.evaluations, bits(at.state)));
                    story.looked_at.push((at.steps, Some(bits(&invariants))));
                }
            }
            Look::Ended { ended, .. } => story.ended.push(ended.clone()),
            Look::Sample { .. } | Look::Crossing { .. } => {}
        }
        Ok(())
    };
    walk.begin(&mut take).expect("a beginning");
    for stride in strides.iter().cycle() {
        match stride {
            0 => walk.step(&mut take),
            stride => walk.advance(*stride, &mut take),
        }
        .expect("steps");
        if walk.walk().living() == 0 {
            break;
        }
    }
    story.evaluations = walk.statistics().evaluations;
    story.state = bits(walk.walk().state());
    story.steps = walk.walk().steps();
    story
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Every look, and the work, is that of single steps, in whatever strides, to the end or to where H has no value.
    #[test]
    fn steps_at_once_are_steps_one_by_one(
        q in 0.2..3.0_f64,
        step in 0.02..0.9_f64,
        strides in prop::collection::vec(0..200_u64, 1..5),
    ) {
        let run = composed(q, step);
        let one_by_one = story(&run, &[0]);
        prop_assert_eq!(one_by_one.ended.len(), 1);
        prop_assert_eq!(&story(&run, &strides), &one_by_one);
    }
}

/// Both ends are drawn: the wall is jumped over, and it is not.
#[test]
fn both_ends_are_met() {
    let ends = [(0.3, 0.8), (1.5, 0.1)].map(|(q, step)| {
        let story = story(&composed(q, step), &[1000]);
        (story.steps, story.ended[0].why.clone())
    });
    assert!(ends[0].0 < 700 && ends[1].0 == 700, "{ends:?}");
}

/// What cannot be taken in leaves the walk where it was taken in.
#[test]
fn a_look_that_fails_leaves_the_walk_there() {
    let run = composed(1.5, 0.1);
    let course = run.course(&[]).expect("code");
    let (parameters, initial) = (run.system.parameter_values(), run.plan.initial.clone());
    let new = || {
        let start = (parameters.as_slice(), initial.as_slice());
        Watched::new(&course, run.method.map(), 1, start).expect("a walk")
    };
    let [mut full, mut whole] = [new(), new()];
    let refused = full.advance(100, &mut |look| match look {
        Look::Steps(steps) if steps.before < 37 && 37 < steps.before + steps.count as u64 => {
            steps.taken.set(37 - steps.before as usize);
            Err(BuildError::Dimension {
                what: "step 38".to_owned(),
                expected: 0,
                found: 38,
            })
        }
        _ => Ok(()),
    });
    assert!(refused.is_err());
    whole
        .advance::<BuildError, _>(37, &mut |_| Ok(()))
        .expect("steps");
    assert_eq!(full.walk().steps(), 37);
    assert_eq!(bits(full.walk().state()), bits(whole.walk().state()));
    assert_eq!(
        full.statistics().evaluations,
        whole.statistics().evaluations
    );
}
