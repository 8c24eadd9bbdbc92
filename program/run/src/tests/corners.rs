//! Crossings beside corners and jumps of what is compared: of a motion without force they are known.

use super::{Prepared, StopAfter};
use crate::{Asked, Recorded, run_in_memory};

/// q = 0.3 + 3 t and a particle at r = (−2.08, 5e-4) + t (1, 0).
fn recorded(more: &str) -> Recorded {
    let text = format!(
        r#"
[system]
variables   = ["q", "x", "y", "p", "px", "py"]
bracket     = {{ canonical = [["q", "p"], ["x", "px"], ["y", "py"]] }}
hamiltonian = "(p^2 + px^2 + py^2)/2"
[method]
stepper   = "splitting"
time-step = 0.1
[run]
initial = [0.3, -2.08, 0.0005, 3, 1, 0]
steps   = 400
{more}
"#
    );
    let Prepared {
        document,
        registry,
        composed,
    } = Prepared::new(&text);
    let mut progress = StopAfter(u32::MAX);
    let asked = Asked::default();
    run_in_memory(&document, &composed, &registry, asked, &mut progress).expect("a run")
}

/// Times of crossings, each to round-off.
fn times(at: &str, direction: &str) -> Vec<f64> {
    let section = format!("section = {{ at = \"{at}\", direction = \"{direction}\" }}");
    let rows = recorded(&section).crossings.expect("a section");
    rows.chunks_exact(8).map(|row| row[0]).collect()
}

fn agree(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(
        found.len(),
        expected.len(),
        "{what}: {found:?} {expected:?}"
    );
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() < 1e-11,
            "{what}: {found} {expected}"
        );
    }
}

/// Times at which q is one of these.
fn at(places: &[f64]) -> Vec<f64> {
    places.iter().map(|q| (q - 0.3) / 3.0).collect()
}

/// A remainder and an angle cross in one step with their jump, which itself crosses nothing.
#[test]
fn crossings_beside_a_jump_are_found_and_jumps_are_none() {
    let turn = std::f64::consts::TAU;
    let turns = |from: f64| -> Vec<f64> {
        let places = (0..20).map(|k| from + turn * f64::from(k));
        places.filter(|q| *q < 120.3).collect()
    };
    for (text, place) in [
        ("mod(q, 2*pi) = 6.2", 6.2),
        ("atan2(sin(q), cos(q)) = 3.1", 3.1),
        ("mod(q, 2*pi) = 0.05", turn + 0.05),
        ("q/(2*pi) - floor(q/(2*pi)) = 0.99", 0.99 * turn),
        ("mod(q, 2*pi) = 3", 3.0),
    ] {
        let expected = at(&turns(place));
        assert!(expected.len() >= 18);
        agree(&times(text, "up"), &expected, text);
        agree(&times(text, "down"), &[], text);
        agree(&times(text, "both"), &expected, text);
    }
    agree(&times("floor(q) = 5.5", "both"), &[], "floor");
}

/// Windows far narrower than a step.
#[test]
fn corners_within_a_step_are_found() {
    let near = "abs(q - 4.77) = 1e-3";
    agree(&times(near, "down"), &at(&[4.769]), near);
    agree(&times(near, "both"), &at(&[4.769, 4.771]), near);
    let least = "min(q - 4.77, 4.7705 - q) = 0";
    agree(&times(least, "both"), &at(&[4.77, 4.7705]), least);
    let choice = "if(q > 4.77, 4.771 - q, 2*(q - 4.7695)) = 0";
    agree(&times(choice, "both"), &at(&[4.7695, 4.771]), choice);
    let reach = libm::sqrt(1e-4 - 2.5e-7);
    let both = [2.08 - reach, 2.08 + reach];
    for norm in ["sqrt(x^2 + y^2) = 0.01", "-2*sqrt(x*x + y^2) = -0.02"] {
        agree(&times(norm, "both"), &both, norm);
    }
    for (stop, end) in [
        ("sqrt(x^2 + y^2) < 0.01", both[0]),
        ("abs(q - 4.77) < 1e-3", at(&[4.769])[0]),
        ("q > 4.77 and q < 4.771", at(&[4.77])[0]),
        ("mod(q, 2*pi) > 6.27", at(&[6.27])[0]),
        ("mod(q, 1) < 1e-3", at(&[1.0])[0]),
        ("not (q < 4.77 or q > 4.7701)", at(&[4.77])[0]),
    ] {
        let run = recorded(&format!("stop = \"{stop}\""));
        agree(&[run.report.time], &[end], stop);
    }
}
