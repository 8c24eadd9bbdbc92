//! The judge convicts: a result of another Hamiltonian is neither confirmed nor taken for a warning.

use leafwise::core::Registry;
use leafwise_fuzz_checks::judge::{Verdict, judge};
use leafwise_fuzz_checks::scene::RandomScene;
use leafwise_fuzz_checks::source::{Source, random_bytes};

/// Most scenes that are confirmed are not once the judge believes in a Hamiltonian larger by a thousandth: 161 of 221
/// among 400. The rest are those whose own error is larger, such as adaptive ones of a tolerance of 1e-4, or whose
/// motion is shorter than what the judge lets pass.
#[test]
fn a_motion_that_is_wrong_by_a_thousandth_is_suspicious() {
    let registry = Registry::with_builtin();
    let (mut confirmed, mut convicted) = (0, 0);
    for index in 0..240 {
        let mut scene = RandomScene::drawn(&mut Source::new(&random_bytes(5, index, 1024)));
        if judge(&scene, &registry) != Verdict::Confirmed {
            continue;
        }
        confirmed += 1;
        scene.hamiltonian = scene.hamiltonian.times(1.001);
        convicted += usize::from(judge(&scene, &registry) != Verdict::Confirmed);
    }
    assert!(confirmed >= 80, "{confirmed} scenes are confirmed");
    assert!(
        10 * convicted >= 6 * confirmed,
        "{convicted} of {confirmed} are convicted"
    );
}
