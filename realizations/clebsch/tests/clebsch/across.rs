//! The way across fibres, block by block.

use leafwise_clebsch::across::Across;
use leafwise_clebsch::algebras::known;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, largest};
use proptest::collection::vec;
use proptest::prelude::*;

/// Algebras whose forms have orthogonal blocks.
const WITH_BLOCKS: [&str; 2] = ["so(3)", "e(3)"];

#[test]
fn rotations_and_rigid_motions_have_blocks() {
    let has_blocks = known().iter().filter(|known| {
        let algebra = &known.algebra;
        Across::of(&algebra.forms, algebra.groups).is_some()
    });
    let names: Vec<&str> = has_blocks.map(|known| known.algebra.name).collect();
    for name in WITH_BLOCKS {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    assert!(names.len() < known().len(), "{names:?}");
}

proptest! {
    /// J(z + δ) − J(z) = r up to J(δ), which is quadratic: by r of 1e-9 of z, below 1e-17 of it.
    #[test]
    fn the_way_leads_to_the_fibre(z in vec(0.3..2.0_f64, 8), rest in vec(-1.0..1.0_f64, 6)) {
        let mut cases = 0;
        for known in known() {
            let (forms, groups) = (&known.algebra.forms, known.algebra.groups);
            let Some(across) = Across::of(forms, groups) else {
                continue;
            };
            let (n, d) = (forms.coordinates(), forms.count());
            let z = &z[..n];
            let rest: Vec<f64> = rest[..d].iter().map(|r| 1e-9 * r).collect();
            let mut moved = z.to_vec();
            across.add::<8>(forms, &rest, &mut moved);
            for k in 0..d {
                // D_k δ with the mean of both ends is the change itself.
                let change: f64 = forms.products(k).iter().map(|&(factor, a, b)| {
                    let [mean_a, mean_b] = [a, b].map(|i| 0.5 * (z[i] + moved[i]));
                    factor * (mean_a * (moved[b] - z[b]) + (moved[a] - z[a]) * mean_b)
                }).sum();
                // Each z + δ is rounded, and at most 8 products of z, of factors up to 1, meet in a row; δ is within 8 |r|.
                let bound = 16.0 * UNIT_ROUNDOFF * largest(z) * largest(z) + 64.0 * 1e-18;
                prop_assert!((change - rest[k]).abs() <= bound, "{}: {change:e} {:e}", known.algebra.name, rest[k]);
            }
            cases += 1;
        }
        prop_assert!(cases >= WITH_BLOCKS.len());
    }
}
