//! Stop and go on: a checkpoint holds all that later steps depend on, so a run continues to the same
//! bits as if it had never stopped.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use leafwise::prelude::*;

fn steps(walk: &mut Walk, count: usize) -> Result<(), StepError> {
    (0..count).try_for_each(|_| walk.step())
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut oscillators = SystemBuilder::new();
    let [q, r, p, s] = oscillators.variables(["q", "r", "p", "s"]);
    oscillators.bracket(q, p, -1);
    oscillators.bracket(r, s, -1);
    oscillators.hamiltonian((p * p + s * s + q * q + r * r) / 2 + q * q * r - r.pow(3) / 3);
    let system = oscillators.build()?;
    let method = Registry::with_builtin().automatic(&system, 4)?;
    let start = || Walk::new(&method, &[], 1.0, 0.1, &[0.1, 0.3, 0.2, -0.1]);

    let mut whole = start();
    steps(&mut whole, 500)?;

    let mut first = start();
    steps(&mut first, 200)?;
    let checkpoint = first.checkpoint();
    drop(first);
    let mut second = start();
    second
        .restore(&checkpoint)
        .map_err(|d| format!("the checkpoint is not of dimension {d}"))?;
    steps(&mut second, 300)?;

    println!("whole:   {:?}", whole.state());
    println!("resumed: {:?}", second.state());
    assert_eq!(whole.checkpoint(), second.checkpoint());
    Ok(())
}
