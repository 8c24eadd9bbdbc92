//! Solov'ev's equilibrium as a g-file, against its closed form.

#![allow(
    clippy::print_stdout,
    reason = "measured errors, read with --nocapture"
)]

use std::f64::consts::PI;
use std::fmt::Write;

use leafwise_equilibrium::{Equilibrium, EquilibriumError, Geqdsk, Ions, Species, written};

/// The field on the axis.
const B: f64 = 2.0;
/// The axis' radius.
const R0: f64 = 1.6;
/// The elongation.
const K: f64 = 1.5;
/// The safety factor on the axis.
const Q: f64 = 1.2;
/// The outer radius of the edge.
const OUTER: f64 = 2.1;

/// ψ = B/(2 R0² k q) (R² Z² + k²/4 (R² − R0²)²) (L. Solov'ev, 1968), a polynomial.
fn psi(r: f64, z: f64) -> f64 {
    let width = r * r - R0 * R0;
    B / (2.0 * R0 * R0 * K * Q) * (r * r * z * z + K * K / 4.0 * width * width)
}

/// F = B R0 + `excess` (1 − s), and its derivative by s is −`excess`.
fn geqdsk(nodes: usize, excess: f64) -> String {
    let at =
        |[first, last]: [f64; 2], i: usize| first + (last - first) * i as f64 / (nodes - 1) as f64;
    let (r, z) = ([0.75, 2.2], [-1.1, 1.1]);
    let edge = psi(OUTER, 0.0);
    let mut text = format!(
        "{:<48}{:4}{nodes:4}{nodes:4}\n",
        "  EFITD   Solovev 01/01/2026  #000001  1000ms", 3
    );
    let mut block = |numbers: Vec<f64>| {
        for line in numbers.chunks(5) {
            for number in line {
                let _ = write!(text, "{}", fortran(*number));
            }
            text.push('\n');
        }
    };
    block(vec![r[1] - r[0], z[1] - z[0], R0, r[0], 0.0]);
    block(vec![R0, 0.0, 0.0, edge, B]);
    block(vec![1e6, 0.0, 0.0, R0, 0.0]);
    block(vec![0.0, 0.0, edge, 0.0, 0.0]);
    let part = |i: usize| i as f64 / (nodes - 1) as f64;
    block(
        (0..nodes)
            .map(|i| B * R0 + excess * (1.0 - part(i)))
            .collect(),
    );
    for _ in 0..3 {
        block(vec![0.0; nodes]);
    }
    let rows = (0..nodes).flat_map(|j| (0..nodes).map(move |i| (i, j)));
    block(rows.map(|(i, j)| psi(at(r, i), at(z, j))).collect());
    block(vec![0.0; nodes]);
    text.push_str("    0    0\n");
    text
}

/// Text behind the nodes, as some programs write it, with whole numbers in it or not.
#[test]
fn text_behind_the_nodes_is_no_number_of_them() {
    let plain = geqdsk(33, -0.3);
    let expected = Geqdsk::parse(&plain).expect("a g-file");
    let (first, rest) = plain.split_once('\n').expect("lines");
    let spaced = format!("EFIT of #7 {:5} 33 33", 3);
    for header in [
        format!("{first} cerqtk"),
        format!("{first} run 12 of 2026"),
        format!("{first} 05 06"),
        format!("{spaced} cerqtk"),
        format!("{spaced} 2 s"),
    ] {
        let found = Geqdsk::parse(&format!("{header}\n{rest}"));
        let found = found.unwrap_or_else(|error| panic!("{header}: {error}"));
        assert_eq!(
            (found.nodes, found.f),
            (expected.nodes, expected.f.clone()),
            "{header}"
        );
    }
    assert!(matches!(
        Geqdsk::parse("a text without nodes\n1 2"),
        Err(EquilibriumError::Header)
    ));
}

/// F passes 0 between two nodes, and lies on one.
#[test]
fn a_field_without_a_toroidal_part_is_told_by_its_node() {
    // F = 3.2 − x (1 − s), 0 at s = 1 − 3.2/x.
    for (excess, f) in [(-6.4, 0.0), (-6.0, -0.175)] {
        match Geqdsk::parse(&geqdsk(33, excess)) {
            Err(EquilibriumError::NoToroidalField {
                node,
                count,
                surface,
                f: found,
            }) => {
                let at = (1.0 - 3.2 / -excess) * 32.0;
                assert_eq!((node, count), (at as usize + 1, 33));
                assert_eq!(surface, (node - 1) as f64 / 32.0);
                assert!((found - f).abs() < 1e-9, "{found}");
            }
            other => panic!("{excess}: {other:?}"),
        }
    }
}

/// A pedestal of F of a width w of s is told where it is thinner than a cell, and followed where it is not. One cell is 0.07 of s there.
#[test]
fn a_thin_pedestal_is_told() {
    let with = |nodes: usize, width: f64| {
        let mut file = Geqdsk::parse(&geqdsk(nodes, 0.0)).expect("a g-file");
        let count = file.f.len() - 1;
        for (at, f) in file.f.iter_mut().enumerate() {
            *f += 0.05 * libm::tanh((at as f64 / count as f64 - 0.8) / width);
        }
        Equilibrium::new(file, 5).expect("an equilibrium").smeared()
    };
    let smeared = with(65, 0.02).expect("a thin pedestal");
    assert!(
        (0.7..0.9).contains(&smeared.surface) && smeared.part > 0.02,
        "{smeared:?}"
    );
    assert_eq!(with(65, 0.2), None);
    assert_eq!(with(257, 0.1), None);
    assert_eq!(equilibrium(65, -0.3).smeared(), None);
    assert_eq!(equilibrium(33, 0.0).smeared(), None);
}

/// A wave over Solov'ev's flux, below it noise of 1 %: the estimate is that of the noise, and of the spline's error where ψ is smooth.
#[test]
fn rough_and_coarse_fluxes_are_told() {
    let range = psi(OUTER, 0.0);
    let of = |nodes: usize, more: &dyn Fn(f64, f64, usize) -> f64| {
        let mut file = Geqdsk::parse(&geqdsk(nodes, 0.0)).expect("a g-file");
        for (at, number) in file.psi.iter_mut().enumerate() {
            let (i, j) = (at / nodes, at % nodes);
            let part = |at: usize| at as f64 / (nodes - 1) as f64;
            *number += more(0.75 + 1.45 * part(i), 2.2 * part(j) - 1.1, at);
        }
        file
    };
    let roughness = |file: Geqdsk| {
        Equilibrium::new(file, 5)
            .expect("an equilibrium")
            .roughness()
    };
    // A polynomial of degree 4 is met, to the ten digits of the file.
    assert!(roughness(of(33, &|_, _, _| 0.0)).expect("nodes") < 1e-7);
    for size in [3e-3, 1e-2] {
        // But not at the axis, which is to stay an extremum.
        let noise = |r: f64, z: f64, at: usize| match libm::hypot(r - R0, z) < 0.2 {
            true => 0.0,
            false => size * range * libm::sin((at * at) as f64),
        };
        let found = roughness(of(65, &noise)).expect("nodes");
        println!("noise of {size}: {found:.1e}");
        // Splines through half of the nodes overshoot by less than 1.6 along each axis.
        assert!((size / 4.0..6.0 * size).contains(&found), "{found}");
    }
    // A wave along R, which the table meets to an error that is known between the nodes.
    for (nodes, waves) in [(33, 20.0), (65, 20.0), (65, 40.0), (129, 40.0)] {
        let wave = |r: f64, _: f64, _: usize| 1e-4 * range * libm::sin(waves * r);
        let file = of(nodes, &wave);
        let equilibrium = Equilibrium::new(file, 5).expect("an equilibrium");
        let places = (0..2000).map(|k| 1.2 + 0.8 * f64::from(k) / 2000.0);
        let [axis, edge] = equilibrium.file().psi_range;
        let off = places.map(|r| {
            let flux = axis + (edge - axis) * equilibrium.flux([r, 0.1]);
            (flux - psi(r, 0.1) - wave(r, 0.0, 0)).abs() / range
        });
        let off = off.fold(0.0, f64::max);
        let found = equilibrium.roughness().expect("nodes");
        println!("{nodes} nodes, waves of {waves}: off by {off:.1e}, {found:.1e} told");
        assert!(
            found + DIGITS > off / 4.0 && found < 200.0 * off + DIGITS,
            "{found:e} {off:e}"
        );
    }
}

/// As the format 1PE16.9.
fn fortran(number: f64) -> String {
    let text = format!("{number:.9E}");
    let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>16}", format!("{mantissa}E{sign}{:02}", exponent.abs()))
}

fn equilibrium(nodes: usize, excess: f64) -> Equilibrium {
    let file = Geqdsk::parse(&geqdsk(nodes, excess)).expect("a g-file");
    Equilibrium::new(file, 5).expect("an equilibrium")
}

fn alphas(members: u32) -> Ions {
    Ions {
        species: Species::Alpha,
        energy: 3500.0,
        pitch: -0.3,
        surface: 0.5,
        members,
        seed: 1,
    }
}

/// The numbers have ten digits: fields agree to a few units of the last over a cell's width.
const DIGITS: f64 = 1e-9;

#[test]
fn field_and_axis_are_those_of_the_closed_form() {
    let equilibrium = equilibrium(33, 0.0);
    let [r, z] = equilibrium.axis();
    assert!((r - R0).abs() < DIGITS && z.abs() < DIGITS, "{r} {z}");
    assert!((equilibrium.axis_safety_factor() - Q).abs() < 1e-7);
    let factor = B / (2.0 * R0 * R0 * K * Q);
    for (r, z) in [(1.1, 0.3), (1.6, -0.7), (2.05, 0.1)] {
        let along_z = factor * 2.0 * r * r * z;
        let along_r = factor * (2.0 * r * z * z + K * K * r * (r * r - R0 * R0));
        let expected = [-along_z / r, along_r / r, B * R0 / r];
        let found = equilibrium.field([r, z]);
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 100.0 * DIGITS,
                "{found} {expected}"
            );
        }
    }
}

/// q = (1/2π) ∮ F/(R² χ′) dχ along B, with R² = R0² + w cos χ and R Z = (k w/2) sin χ on a surface.
#[test]
fn safety_factors_are_those_of_the_integral() {
    let equilibrium = equilibrium(65, 0.0);
    for s in [0.1, 0.5, 0.9] {
        let w = libm::sqrt(s) * (OUTER * OUTER - R0 * R0);
        let count = 4096;
        let sum: f64 = (0..count)
            .map(|i| {
                let chi = 2.0 * PI * f64::from(i) / f64::from(count);
                let square = R0 * R0 + w * libm::cos(chi);
                // dR/dτ = −ψ_Z/R, dφ/dτ = F/R²: dχ/dτ follows from R² = R0² + w cos χ.
                let rate = B / (2.0 * R0 * R0 * K * Q) * 2.0 * K * libm::sqrt(square);
                B * R0 / square / rate
            })
            .sum();
        let expected = sum / f64::from(count);
        let found = equilibrium.safety_factor(s).expect("a closed surface");
        assert!(
            (found - expected).abs() < 1e-7,
            "s = {s}: {found} {expected}"
        );
    }
}

/// With F(ψ) not constant, F at every point within the edge, to the order of the spline.
#[test]
fn a_toroidal_field_that_varies_is_met_within_the_edge() {
    let largest = [33, 65].map(|nodes| {
        let equilibrium = equilibrium(nodes, -0.3);
        let mut largest: f64 = 0.0;
        for i in 0..40 {
            for j in 0..40 {
                let (r, z) = (0.9 + 0.03 * f64::from(i), -0.9 + 0.045 * f64::from(j));
                let s = psi(r, z) / psi(OUTER, 0.0);
                if s < 0.95 {
                    let expected = (B * R0 - 0.3 * (1.0 - s)) / r;
                    let error = equilibrium.field([r, z])[2] - expected;
                    largest = largest.max(error.abs());
                }
            }
        }
        largest
    });
    assert!(largest[0] < 1e-4 && largest[1] < 4e-6, "{largest:?}");
}

#[test]
fn starts_lie_on_the_surface_with_the_energy() {
    let equilibrium = equilibrium(33, 0.0);
    let speed = Species::Alpha.speed(3500.0).expect("a speed");
    let starts = alphas(2000).starts(&equilibrium).expect("starts");
    let mut pitch = 0.0;
    for start in &starts {
        let [r, z, turn, u] = start.state;
        // Points between two of the surface's: chords of 512 angles.
        assert!((equilibrium.flux([r, z]) - 0.5).abs() < 1e-3);
        assert!((0.0..2.0 * PI).contains(&turn));
        let energy = u * u / 2.0 + start.moment * equilibrium.strength([r, z]);
        assert!((2.0 * energy / (speed * speed) - 1.0).abs() < 1e-12);
        pitch += u / speed;
    }
    // Uniform in [−1, 1]: the mean of 2000 has the deviation 0.0129.
    assert!((pitch / 2000.0).abs() < 5.0 * 0.0129, "{pitch}");
    assert_eq!(starts, alphas(2000).starts(&equilibrium).expect("starts"));
}

/// Numbers without spaces between, exponents by D and lines of other lengths make the same equilibrium.
#[test]
fn dialects_are_read() {
    let text = geqdsk(9, -0.3);
    let expected = Geqdsk::parse(&text).expect("a g-file");
    let (head, body) = text.split_once('\n').expect("lines");
    let glued: String = body
        .lines()
        .map(|line| line.replace(" -", "-"))
        .collect::<Vec<_>>()
        .join("\n");
    let lines: String = body.split_whitespace().collect::<Vec<_>>().join("\n");
    for body in [
        body.replace('E', "D"),
        glued,
        lines,
        body.replace('\n', "\r\n"),
    ] {
        assert_eq!(
            Geqdsk::parse(&format!("{head}\n{body}")).expect("a g-file"),
            expected
        );
    }
    // Fortran writes exponents of three digits without their letter.
    let zeros = " 0.000000000E+00 0.000000000E+00";
    let tiny = text.replacen(zeros, " 1.23456789-103-9.87654321-101", 1);
    let tiny = Geqdsk::parse(&tiny).expect("a g-file");
    assert_eq!(tiny.psi, expected.psi);
    // Columns of four places without a space between.
    let wide = geqdsk(9, 0.0).replacen("   3   9   9", "   31024  16", 1);
    let error = Geqdsk::parse(&wide).expect_err("fewer numbers");
    assert!(
        error.to_string().contains("the file ends in F = R B_phi"),
        "{error}"
    );
    let short: Vec<&str> = text.split_whitespace().collect();
    assert!(Geqdsk::parse(&short.join(" ")).is_err());
}

/// Of any file that is cut, and of any with one wrong number, it is said where it is wrong; nothing panics.
#[test]
fn broken_files_are_refused() {
    let text = geqdsk(9, -0.3);
    let whole = text.len();
    let needed = text.rfind("    0    0").unwrap_or(whole);
    // Without safety factors it is whole; of the last number of the flux, digits may be missing unseen.
    let factors = 9 * 16 + 2;
    for at in (0..needed - factors - 17).step_by(7) {
        assert!(Geqdsk::parse(&text[..at]).is_err(), "cut at {at}");
    }
    let words: Vec<&str> = text.split_inclusive(' ').collect();
    for wrong in ["NaN", "****************", "inf", "1e999"] {
        let changed: String = words
            .iter()
            .enumerate()
            .map(|(at, word)| {
                if at + 40 == words.len() / 2 {
                    format!(" {wrong} ")
                } else {
                    (*word).to_owned()
                }
            })
            .collect();
        assert!(Geqdsk::parse(&changed).is_err(), "{wrong}");
    }
    let odd = |from: &str, to: &str| {
        let error = Geqdsk::parse(&text.replacen(from, to, 1))
            .and_then(|file| Equilibrium::new(file, 5))
            .expect_err("no equilibrium");
        error.to_string()
    };
    assert!(odd(" 7.500000000E-01", "-7.500000000E-01").contains("to one side of the axis R = 0"));
    // The flux on the axis is another one than the file gives.
    let told = [
        " 0.000000000E+00 4.177856445E-01",
        "-3.000000000E+00 4.177856445E-01",
    ];
    assert!(odd(told[0], told[1]).contains("the file gives -3"));
    assert!(
        odd(
            " 1.600000000E+00 0.000000000E+00 0.000000000E+00",
            " 9.000000000E-01 9.000000000E-01 0.000000000E+00"
        )
        .contains("no extremum")
    );
}

#[test]
fn ions_out_of_range_are_refused() {
    let equilibrium = equilibrium(33, 0.0);
    let refused = |ions: Ions| ions.start(&equilibrium).expect_err("refused").to_string();
    assert!(
        refused(Ions {
            energy: 1e6,
            ..alphas(0)
        })
        .contains("not relativistic")
    );
    assert!(
        refused(Ions {
            energy: f64::NAN,
            ..alphas(0)
        })
        .contains("above 0")
    );
    assert!(
        refused(Ions {
            pitch: 1.5,
            ..alphas(0)
        })
        .contains("from -1 to 1")
    );
    assert!(
        refused(Ions {
            surface: 1.5,
            ..alphas(0)
        })
        .contains("between the axis")
    );
    let open = Equilibrium::new(
        Geqdsk::parse(&geqdsk(33, 0.0).replacen(" 7.500000000E-01", " 1.100000000E+00", 1))
            .expect("a g-file"),
        5,
    );
    // The flux is another one on this grid, without an extremum at the axis that the file gives.
    assert!(matches!(open, Err(EquilibriumError::Odd(_))));
}

/// The files of the scene `tokamak_losses` are those that an import of its g-file writes.
#[test]
fn the_scene_of_losses_is_up_to_date() {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/tokamak");
    let read = |name: &str| std::fs::read_to_string(format!("{directory}/{name}")).expect("a file");
    assert_eq!(read("solovev.geqdsk"), geqdsk(33, 0.0));
    let written = written(&equilibrium(33, 0.0), &alphas(100), "solovev.geqdsk").expect("a scene");
    for (name, text) in &written.files {
        assert_eq!(read(name).as_bytes(), text, "{name}");
    }
    let scene =
        std::fs::read_to_string(format!("{directory}/../tokamak_losses.toml")).expect("a scene");
    let system = written
        .scene
        .split("[run]")
        .next()
        .and_then(|text| text.split_once("[system]"));
    let (_, system) = system.expect("a system");
    assert!(scene.contains(&system.replace("\"psi.csv\"", "\"tokamak/psi.csv\"")));
}
