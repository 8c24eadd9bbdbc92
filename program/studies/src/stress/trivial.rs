//! No tensor, no Hamiltonian, nothing to do.

use leafwise_core::{PoissonSystem, Walk};

use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::{method, problem, same_bits, so3_with};

pub(super) const CASES: [Case; 2] = [
    Case {
        family: "trivial",
        name: "zero-hamiltonian",
        asked: "so(3)* with H = 0, 7/3, 0*x1 and x2 - x2, ten steps",
        expected: "x' = {H, x} = 0: state and compensation keep every bit",
        run: zero_hamiltonian,
    },
    Case {
        family: "trivial",
        name: "zero-tensor",
        asked: "{xi, xj} = 0, written or left out, H = x1^2 x3 + exp(x2), ten steps",
        expected: "x' = -Pi dH = 0: state and compensation keep every bit",
        run: zero_tensor,
    },
];

/// Takes ten steps over three truncations and tells whether no bit has changed.
pub(super) fn rests(tally: &mut Tally, name: &str, system: &PoissonSystem, x: &[f64]) {
    for (n, m) in [(1, 2), (4, 4), (6, 6)] {
        let outcome = method(system, n, m).and_then(|method| {
            let parameters = system.parameter_values();
            let mut walk = Walk::new(&method, &parameters, 0.1, 2.0, x);
            walk.advance(10)?;
            let is_whole = walk.compensation().iter().all(|low| *low == 0.0);
            Ok(is_whole && same_bits(walk.state(), x))
        });
        let is_met = matches!(outcome, Ok(true));
        tally.take(is_met, || match outcome {
            Ok(_) => format!("{name} moves from {x:?}, n = {n}, m = {m}"),
            Err(error) => format!("{name} from {x:?}, n = {n}, m = {m}: {error}"),
        });
    }
}

fn zero_hamiltonian(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    let x = [0.1, -1.0 / 3.0, 5.7e5];
    for hamiltonian in ["0", "7/3", "0*x1", "x2 - x2"] {
        let system = problem(&so3_with(hamiltonian), &x)?.system;
        rests(&mut tally, hamiltonian, &system, &x);
    }
    Ok(tally.outcome(|count| format!("{count} runs at rest to the bit")))
}

fn zero_tensor(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    let x = [0.1, -1.0 / 3.0, 5.7];
    for bracket in ["{}", "{ \"x1,x2\" = \"0\", \"x2,x3\" = \"x1 - x1\" }"] {
        let system = format!(
            "variables = [\"x1\", \"x2\", \"x3\"]\nbracket = {bracket}\n\
             hamiltonian = \"x1^2*x3 + exp(x2)\"\n"
        );
        rests(&mut tally, bracket, &problem(&system, &x)?.system, &x);
    }
    Ok(tally.outcome(|count| format!("{count} runs at rest to the bit")))
}
