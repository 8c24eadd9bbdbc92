//! States at any times and events, against samples and sections of the same run.

use leafwise_walk::Direction;
use proptest::prelude::*;

use super::{Prepared, StopAfter};
use crate::{Asked, Event, Retraced, run_in_memory};

/// A driven oscillator with steps in either direction, samples at times and a section.
fn scene(step: f64, times: &[f64]) -> String {
    format!(
        r#"
[system]
variables   = ["q", "p"]
bracket     = {{ "q,p" = "1" }}
convention  = "{{x,H}}"
hamiltonian = "p^2/2 + q^2/2 + q^4/8 + q*cos(2*t)/5"
[method]
realization = "auto"
dynamics    = {{ name = "hamilton-jacobi", order = 4 }}
time-step   = {step:?}
[run]
initial = [1.5, 0]
steps   = 1500
section = {{ at = "q = 0.25*p", direction = "down" }}
record  = {{ times = {times:?}, observables = ["energy"] }}
"#
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever the order in which they are asked for: the bits of samples at these times, in few steps.
    #[test]
    fn states_are_those_of_samples(
        parts in prop::collection::vec(0.0..1.0_f64, 1..12),
        on_steps in prop::collection::vec(0_u32..=1500, 1..4),
        step in prop_oneof![Just(0.02), Just(-0.03)],
        order in any::<u64>(),
    ) {
        let end = 1500.0 * step;
        let mut times: Vec<f64> = parts.iter().map(|part| part * end).collect();
        times.extend(on_steps.iter().map(|steps| f64::from(*steps) * step));
        times.sort_by(|one, other| one.abs().total_cmp(&other.abs()));
        times.dedup();
        times.retain(|time| *time != 0.0);
        prop_assume!(!times.is_empty());
        let Prepared { document, registry, composed } = Prepared::new(&scene(step, &times));
        let run = run_in_memory(&document, &composed, &registry, Asked::default(), &mut StopAfter(u32::MAX));
        let samples = run.expect("a run").samples;
        let states: Vec<&[f64]> = samples.chunks_exact(4).skip(1).map(|row| &row[1..3]).collect();
        let mut retraced = Retraced::of(composed).expect("steps of the time itself");
        let turn = (order % times.len() as u64) as usize;
        let mut asked: Vec<usize> = (0..times.len()).collect();
        asked.rotate_left(turn);
        for at in asked.iter().chain(asked.iter().rev()) {
            let state = retraced.at(times[*at], &mut || true).expect("a state");
            prop_assert_eq!(&state[..], states[*at]);
        }
        // The run once, and no more than what lies between two kept states and a shorter step for each time.
        prop_assert!(retraced.steps() <= 1500 + 2 * times.len() as u64 * 3);
    }

    /// An event on the surface of a section finds the section's crossings, up to that at which it ends the run.
    #[test]
    fn events_are_crossings_of_a_section(last in prop::option::of(1_u64..4), step in prop_oneof![Just(0.02), Just(-0.03)]) {
        let Prepared { document, registry, composed } = Prepared::new(&scene(step, &[step * 700.0]));
        let section = |text, direction| composed.section(&document, text, direction).expect("a surface");
        let events = [
            Event { section: section("q = 0.25*p", Direction::Down), act: None, last },
            Event { section: section("q = p/4", Direction::Both), act: None, last: None },
        ];
        let asked = Asked { events: &events, ..Asked::default() };
        let run = run_in_memory(&document, &composed, &registry, asked, &mut StopAfter(u32::MAX)).expect("a run");
        let crossings = run.crossings.expect("a section");
        let rows: Vec<&[f64]> = crossings.chunks_exact(4).collect();
        prop_assert!(rows.len() as u64 >= last.unwrap_or(3));
        prop_assert_eq!(run.events[0].len(), rows.len());
        for (found, row) in run.events[0].iter().zip(&rows) {
            prop_assert_eq!(found.time, row[0]);
            prop_assert_eq!(&found.state[..], &row[1..3]);
        }
        prop_assert!(run.events[1].len() >= 2 * rows.len() - 1);
        match last {
            None => prop_assert_eq!(run.ended_by, None),
            Some(last) => {
                prop_assert_eq!((run.ended_by, run.events[0].len() as u64), (Some(0), last));
                let end = run.events[0].last().expect("a crossing");
                prop_assert_eq!(run.report.time, end.time);
                prop_assert_eq!(&run.report.final_state, &end.state);
                prop_assert_eq!(run.report.outcome.stopped_by(), Some("q = 0.25*p"));
            }
        }
    }
}

#[test]
fn what_is_asked_for_may_be_given_up() {
    let Prepared { composed, .. } = Prepared::new(&scene(0.02, &[1.0]));
    let mut retraced = Retraced::of(composed).expect("steps of the time itself");
    assert_eq!(
        retraced.at(20.0, &mut || false),
        Err(crate::Retrace::Interrupted)
    );
    assert!(retraced.at(20.0, &mut || true).is_ok());
}
