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

/// A quadratic of the place q, ±((q − c)² − r²), and a text of it.
#[derive(Clone, Copy)]
struct Part {
    centre: f64,
    radius: f64,
    is_inside: bool,
}

impl Part {
    fn holds(self, q: f64) -> bool {
        ((q - self.centre).abs() < self.radius) == self.is_inside
    }

    fn text(self) -> String {
        let Self { centre, radius, .. } = self;
        let sign = if self.is_inside { "<" } else { ">" };
        format!("(q - {centre:?})^2 {sign} {radius:?}^2")
    }
}

/// Parts that turn within a step of 0.3, joined by `and` and `or`: the run ends where the condition first holds, be it for a part of a
/// step that only two of them leave. Places where one changes its sign are known.
#[test]
fn parts_that_meet_within_a_step_are_found() {
    let mut seed = 1_u64;
    let mut drawn = |from: f64, to: f64| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * ((seed >> 11) as f64 / (1_u64 << 53) as f64)
    };
    let (mut found, mut narrow) = (0, 0);
    for case in 0..400 {
        let centre = drawn(4.5, 9.0);
        let parts: Vec<Part> = (0..3)
            .map(|_| Part {
                centre: (1e4 * (centre + drawn(-0.15, 0.15))).round() / 1e4,
                radius: (1e4 * drawn(0.01, 0.12)).round() / 1e4,
                is_inside: drawn(0.0, 1.0) < 0.7,
            })
            .collect();
        let [a, b, c] = parts[..] else {
            unreachable!("three of them");
        };
        let [x, y, z] = [a, b, c].map(Part::text);
        let (text, holds): (String, Box<dyn Fn(f64) -> bool>) = match case % 4 {
            0 => (
                format!("{x} and {y}"),
                Box::new(move |q| a.holds(q) && b.holds(q)),
            ),
            1 => (
                format!("({x} or {y}) and {z}"),
                Box::new(move |q| (a.holds(q) || b.holds(q)) && c.holds(q)),
            ),
            2 => (
                format!("not ({x} or not {y})"),
                Box::new(move |q| !a.holds(q) && b.holds(q)),
            ),
            _ => (
                format!("{x} and {y} and {z}"),
                Box::new(move |q| a.holds(q) && b.holds(q) && c.holds(q)),
            ),
        };
        let mut places: Vec<f64> = parts
            .iter()
            .flat_map(|part| [part.centre - part.radius, part.centre + part.radius])
            .collect();
        places.sort_by(f64::total_cmp);
        let middle = |pair: &[f64]| f64::midpoint(pair[0], pair[1]);
        let is_held = |pair: &&[f64]| holds(middle(pair)) && pair[1] - pair[0] > 0.0;
        let Some(first) = places.windows(2).find(is_held) else {
            continue;
        };
        // It does not hold from the beginning, nor for less than a thousandth of a step.
        if holds(0.3) || places.windows(2).any(|pair| pair[1] - pair[0] < 3e-4) {
            continue;
        }
        found += 1;
        narrow += u32::from(first[1] - first[0] < 0.03);
        let run = recorded(&format!("stop = \"{text}\""));
        agree(&[run.report.time], &at(&first[..1]), &text);
    }
    assert!(found > 150 && narrow > 20, "{found} {narrow}");
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
    for norm in [
        "sqrt(x^2 + y^2) = 0.01",
        "-2*sqrt(x*x + y^2) = -0.02",
        "(x^2 + y^2)^0.5 = 0.01",
        "sqrt(x^2 + y^2)/2 = 0.005",
    ] {
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
