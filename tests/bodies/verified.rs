//! Defects and declarations of many bodies, along a few directions.

use leafwise::core::Registry;
use leafwise::core::diagnostics::TensorDefect;
use leafwise::verify::{Problem, Progress, Refused, Row, SurveyOptions, survey};

use leafwise_tests::scenes::document;

use super::{METHODS, gravity, in_loops};

/// Bodies whose bracket is (1 + e s_i)/m_i with s_i = 1 at the body 17 and 0 at all others.
fn planted(sites: usize, e: &str, method: &str) -> String {
    gravity(sites, method)
        .replace(
            "e = 0.1 }",
            "\"s[i]\" = \"exp(-1000*(i - 17)^2)\", e = 0.1 }",
        )
        .replace("\"1/m[i]\"", &format!("\"(1 + {e}*s[i])/m[i]\""))
}

/// Along four random directions steps of splitting and Gauss keep the tensor of 300 bodies as well as differences tell. The map
/// of a tensor that is off by 1 % at one body is told from it, and so is one that keeps none.
#[test]
fn defects_of_one_body_are_found_along_a_few_directions() {
    let sites = 300;
    let defect = |of_tensor: &str, of_map: &str, method: &str| {
        let system = in_loops(&planted(sites, of_tensor, METHODS[0])).system;
        let run = in_loops(&planted(sites, of_map, method));
        let (values, x) = (system.parameter_values(), &run.plan.initial);
        let mut instrument =
            TensorDefect::new(&system, run.method.map(), &values, 1.0, 0.05).expect("code");
        let measured = instrument.measure_sampled(x).expect("a step");
        let measured = measured.expect("a tensor of one body");
        let [defect, floor] = [measured.relative(), measured.relative_floor()];
        (defect.expect("a tensor"), floor.expect("a tensor"))
    };
    for method in [METHODS[1], METHODS[3], METHODS[4]] {
        let (kept, floor) = defect("0", "0", method);
        assert!(
            kept <= 4.0 * floor && floor <= 1e-6,
            "{method}: {kept:e} {floor:e}"
        );
        let (found, floor) = defect("0", "1e-2", method);
        assert!(found > 16.0 * floor, "{method}: {found:e} {floor:e}");
    }
    let (found, floor) = defect("0", "0", METHODS[0]);
    assert!(found > 16.0 * floor, "{found:e} {floor:e}");
}

/// Nothing is told of the progress.
struct Silent;

impl Progress for Silent {
    fn problem(&mut self, _: &str, _: usize) {}
    fn refused(&mut self, _: &Refused) {}
    fn row(&mut self, _: &Row) {}
}

/// `verify` measures the scene's own method on many bodies, and says along how many directions.
#[test]
fn many_bodies_are_verified_along_a_few_directions() {
    let document = document(&gravity(60, METHODS[4]), &[]);
    let registry = Registry::with_builtin();
    let problem = Problem::with_method(&document, &registry).expect("a problem");
    let options = SurveyOptions {
        full: false,
        threads: std::num::NonZeroUsize::MIN,
    };
    let survey = survey(&registry, &[problem], &options, &mut Silent).expect("a flow");
    assert!(survey.is_met() && survey.rows.len() == 1, "{survey:?}");
    let [sampled] = &survey.sampled[..] else {
        panic!("{survey:?}");
    };
    assert!(sampled.coordinates == 420 && sampled.covectors == 4 && sampled.is_own_alone);
}
