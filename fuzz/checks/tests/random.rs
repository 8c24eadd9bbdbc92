//! The checks on random inputs of a fixed seed. `LEAFWISE_FUZZ_SEED` draws others, `LEAFWISE_FUZZ_CASES`
//! so many times as many.

use leafwise_fuzz_checks::lattices::Drawn;
use leafwise_fuzz_checks::source::random_bytes;
use leafwise_fuzz_checks::{
    Reached, documents, formulas, kernels, lattices, resumed, scenes, states,
};

fn from_environment(name: &str, usual: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text.parse().expect("a whole number"),
        Err(_) => usual,
    }
}

/// The seeds of the check called `name`, then `cases` inputs of `length` bytes, of which `share` percent at least
/// reach the comparison.
fn holds(
    name: &str,
    check: fn(&[u8]) -> Result<Reached, String>,
    cases: u64,
    length: usize,
    share: u64,
) {
    let folder = format!("{}/../seeds/{name}", env!("CARGO_MANIFEST_DIR"));
    for seed in std::fs::read_dir(folder).expect("seeds") {
        let path = seed.expect("a seed").path();
        let bytes = std::fs::read(&path).expect("a seed");
        if let Err(failure) = check(&bytes) {
            panic!("{}: {failure}", path.display());
        }
    }
    let seed = from_environment("LEAFWISE_FUZZ_SEED", 1);
    let cases = cases * from_environment("LEAFWISE_FUZZ_CASES", 1);
    let mut compared = 0;
    for index in 0..cases {
        match check(&random_bytes(seed, index, length)) {
            Ok(Reached::Comparison) => compared += 1,
            Ok(Reached::Refusal) => {}
            Err(failure) => panic!("seed {seed}, input {index}: {failure}"),
        }
    }
    assert!(
        100 * compared >= share * cases,
        "{compared} of {cases} inputs reached the comparison"
    );
}

#[test]
fn values_and_gradients_are_those_of_dual_numbers() {
    holds("formulas", formulas::check, 1500, 256, 50);
}

#[test]
fn kernels_have_the_same_bits_however_they_run() {
    holds("kernels", kernels::check, 3000, 1500, 90);
}

#[test]
fn scenes_step_to_finite_states_or_say_why_not() {
    holds("scenes", scenes::check, 60, 400, 50);
}

#[test]
fn lattices_step_as_they_do_written_out_to_the_same_bits_however_they_run() {
    holds("lattices", lattices::check, 60, 100, 70);
}

/// What the lattices of a seed are: near and far, of every remainder, ring and open, by templates and written out, by each method.
#[test]
fn lattices_are_drawn_of_every_kind() {
    let mut drawn: Vec<Drawn> = Vec::new();
    for index in 0..200 {
        let bytes = random_bytes(7, index, 100);
        drawn.push(lattices::only_drawn(&bytes));
    }
    let count = |is: &dyn Fn(&Drawn) -> bool| drawn.iter().filter(|drawn| is(drawn)).count();
    for (least, most) in [(0, 2), (3, 5), (6, 12), (13, 25), (26, 80)] {
        let found = count(&|d| (least..=most).contains(&d.lattice.farthest()));
        assert!(
            found >= 10,
            "{found} lattices name sites {least} to {most} apart"
        );
    }
    for period in 2..=4 {
        for remainder in 0..period {
            let found = count(&|d| !d.lattice.is_ring && d.lattice.length() % period == remainder);
            assert!(
                found >= 10,
                "{found} open ones of remainder {remainder} modulo {period}"
            );
        }
    }
    for name in [
        "splitting",
        "hamilton-jacobi",
        "karasev-truncated",
        "spherical-midpoint",
        "rk4",
        "gauss",
    ] {
        let found = count(&|d| d.method == name);
        assert!(found >= 2, "{found} by {name}");
    }
    assert!(count(&|d| d.lattice.is_ring) >= 50);
}

#[test]
fn texts_of_scenes_are_read_or_refused_at_their_place() {
    holds("documents", documents::check, 300, 700, 90);
}

#[test]
fn files_of_states_are_read_or_refused() {
    holds("states", states::check, 2000, 60, 90);
}

#[test]
fn a_changed_run_directory_resumes_to_the_same_result_or_is_refused_untouched() {
    holds("resumed", resumed::check, 100, 40, 90);
}
