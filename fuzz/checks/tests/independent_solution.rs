//! The solution that judges others, against known ones.

use leafwise_fuzz_checks::reference::solution;

#[test]
fn an_oscillator_is_followed_to_round_off_and_a_pole_is_reported() {
    let turn = |x: &[f64]| vec![x[1], -x[0]];
    let states = solution(&turn, &[1.0, 0.0], 1.0, 4, &mut [1.0, 1.0]);
    let states = states.expect("a solution").states;
    for (t, x) in states.iter().enumerate() {
        let t = t as f64;
        let error = (x[0] - libm::cos(t)).abs().max((x[1] + libm::sin(t)).abs());
        // Thirteen digits a step, and a few dozen steps.
        assert!(error <= 1e-11, "{t}: {error:e}");
    }
    // 1/(1 − t) has a pole at 1.
    let square = |x: &[f64]| vec![x[0] * x[0]];
    assert!(solution(&square, &[1.0], 2.0, 1, &mut [1.0]).is_none());
}
