//! Fields in Boozer coordinates between surfaces and nodes, and numbers that are none.

#![allow(
    clippy::print_stdout,
    reason = "measured orders, read with --nocapture"
)]

use std::f64::consts::PI;

use leafwise_equilibrium::{Boozer, BoozerData, Ions, Species, written_in_boozer};

const PERIODS: u32 = 5;

/// A change that makes numbers none of a field.
type Spoil = fn(&mut BoozerData);

/// |B| of s, θ and ζ.
type Strength = fn(f64, f64, f64) -> f64;

/// On K surfaces from `first` on, with so many nodes of θ and ζ.
fn data(strength: Strength, (surfaces, first): (usize, f64), nodes: [usize; 2]) -> BoozerData {
    let at = |k: usize| first + (1.0 - first) * k as f64 / (surfaces - 1) as f64;
    let s: Vec<f64> = (0..surfaces).map(at).collect();
    let of = |f: fn(f64) -> f64| s.iter().map(|s| f(*s)).collect::<Vec<f64>>();
    let mut numbers = Vec::new();
    for s in &s {
        for j in 0..nodes[0] {
            for l in 0..nodes[1] {
                let theta = 2.0 * PI * j as f64 / nodes[0] as f64;
                let zeta = 2.0 * PI * l as f64 / (nodes[1] as f64 * f64::from(PERIODS));
                numbers.push(strength(*s, theta, zeta));
            }
        }
    }
    BoozerData {
        periods: PERIODS,
        edge_flux: 0.3,
        iota: of(|s| 0.4 + 0.1 * s),
        g: of(|s| 3.0 - 0.2 * s * s),
        i: of(|s| 0.05 * s),
        s,
        nodes,
        strength: numbers,
    }
}

/// Harmonics that fall as s^(m/2), and smooth functions of s.
fn stellarator(s: f64, theta: f64, zeta: f64) -> f64 {
    let root = libm::sqrt(s);
    let helical = 2.0 * theta - 5.0 * zeta;
    let other = 3.0 * theta + 5.0 * zeta;
    2.0 + 0.1 * s - 0.2 * root * libm::cos(theta)
        + 0.15 * s * libm::cos(helical) * libm::exp(-s)
        + 0.03 * s * root * libm::sin(other)
}

/// The largest error at places between nodes, up to s = 1 and within a tenth beyond.
fn errors(strength: Strength, field: &Boozer) -> [f64; 2] {
    [(0.0, 1.0), (1.0, 1.1)].map(|(from, to)| {
        let places = (0..400).map(|k| {
            let part = f64::from(k) / 400.0;
            let (theta, zeta) = (6.1 * f64::from(k), 3.7 * f64::from(k));
            let s = from + (to - from) * part;
            (field.strength(s, theta, zeta) - strength(s, theta, zeta)).abs()
        });
        places.fold(0.0, f64::max)
    })
}

/// Harmonics whose numbers over √s^m are polynomials are met to round-off; others to order 6 in the distance of surfaces, where the
/// first one is on the axis, or half such a distance from it. Where it stays at s = 0.05, the axis is extrapolated to over a
/// distance that stays, and the error ends at that of a polynomial's.
#[test]
fn the_field_is_met_between_surfaces() {
    let linear: Strength = |s, theta, zeta| {
        2.0 - 0.2 * libm::sqrt(s) * libm::cos(theta) + 0.1 * s * libm::cos(2.0 * theta - 5.0 * zeta)
    };
    let field = Boozer::new(data(linear, (8, 0.0), [8, 6])).expect("a field");
    let [within, beyond] = errors(linear, &field);
    assert!(within < 1e-13, "{within:e}");
    assert!(beyond < 1e-2, "{beyond:e}");
    let of = |surfaces, first| {
        let field = Boozer::new(data(stellarator, (surfaces, first), [16, 9]));
        errors(stellarator, &field.expect("a field"))[0]
    };
    // Half meshes as those of VMEC, of which half a distance is left out at the axis.
    for half in [0.0, 0.5] {
        let first = |surfaces: usize| half / (surfaces as f64 - 1.0 + half);
        let found = [9, 17, 33].map(|surfaces| of(surfaces, first(surfaces)));
        println!("half a distance times {}: off by {found:?}", 2.0 * half);
        // Order 6 is met from below: the next term is one of h⁷.
        let order = |at: usize| libm::log2(found[at] / found[at + 1]);
        assert!(order(0) > 5.0 && order(1) > 5.5, "{found:?}");
    }
    let found = [9, 17, 33].map(|surfaces| of(surfaces, 0.05));
    println!("from s = 0.05: off by {found:?}");
    let order = libm::log2(found[1] / found[2]);
    assert!(order < 5.5, "an order of {order}, which the guide denies");
}

/// Profiles are met too, and the current over s has a value on the axis.
#[test]
fn profiles_are_met() {
    let field = Boozer::new(data(stellarator, (9, 0.0), [8, 6])).expect("a field");
    for s in [0.0, 0.03, 0.5, 0.77, 1.0] {
        assert!((field.iota(s) - 0.4 - 0.1 * s).abs() < 1e-14);
        assert!((field.g(s) - 3.0 + 0.2 * s * s).abs() < 1e-13);
        assert!((field.i_over_s(s) - 0.05).abs() < 1e-15);
    }
    assert!(!field.is_axisymmetric());
}

fn ions(members: u32) -> Ions {
    Ions {
        species: Species::Alpha,
        energy: 3500.0,
        pitch: -0.3,
        surface: 0.4,
        members,
        seed: 7,
    }
}

/// The mean of B² over starts that are uniform in volume, in proportion to 1/B², is one over the mean of 1/B² over the angles.
#[test]
fn starts_are_uniform_in_the_volume() {
    let field = Boozer::new(data(stellarator, (13, 0.0), [16, 9])).expect("a field");
    let starts = field.starts(&ions(4000)).expect("starts");
    let speed = Species::Alpha.speed(3500.0).expect("a speed");
    let (mut squares, mut pitches) = (0.0, 0.0);
    for start in &starts {
        let [x, y, zeta, rho] = start.state;
        assert!((x * x + y * y - 0.4).abs() < 1e-14);
        let b = field.strength(0.4, libm::atan2(y, x), zeta);
        let energy = rho * rho * b * b / 2.0 + start.moment * b;
        assert!((2.0 * energy / (speed * speed) - 1.0).abs() < 1e-12);
        squares += b * b / starts.len() as f64;
        pitches += rho * b / speed / starts.len() as f64;
    }
    let mut mean = 0.0;
    for j in 0..64 {
        for l in 0..64 {
            let (theta, zeta) = (PI * f64::from(j) / 32.0, PI * f64::from(l) / 160.0);
            mean += libm::pow(stellarator(0.4, theta, zeta), -2.0) / 4096.0;
        }
    }
    // B² varies by ±0.6, u/v by 1/√3: four standard deviations of 4000 draws.
    assert!(
        (squares - 1.0 / mean).abs() < 0.04,
        "{squares} {}",
        1.0 / mean
    );
    assert!(pitches.abs() < 4.0 / libm::sqrt(3.0 * 4000.0), "{pitches}");
}

/// Nodes at 0 and at the end of a period are one place: the last one is left out, and the field is that without it.
#[test]
fn repeated_ends_are_left_out() {
    let good = data(stellarator, (6, 0.0), [8, 6]);
    let plain = Boozer::new(good.clone()).expect("a field");
    for repeats in [[true, false], [false, true], [true, true]] {
        let [theta, zeta] = repeats.map(usize::from);
        let mut longer = good.clone();
        longer.nodes = [8 + theta, 6 + zeta];
        longer.strength.clear();
        for surface in good.strength.chunks(48) {
            for j in 0..8 + theta {
                let row = &surface[(j % 8) * 6..][..6];
                longer.strength.extend((0..6 + zeta).map(|l| row[l % 6]));
            }
        }
        let field = Boozer::new(longer).expect("a field");
        assert_eq!(field.repeated(), repeats);
        assert_eq!(field.data(), plain.data());
    }
    assert_eq!(plain.repeated(), [false; 2]);
    // A field that is the same at all angles repeats nothing.
    let even = Boozer::new(data(|_, _, _| 2.0, (6, 0.0), [8, 6])).expect("a field");
    assert_eq!((even.repeated(), even.data().nodes), ([false; 2], [8, 6]));
    assert!(even.is_axisymmetric());
}

/// Numbers that differ by the round-off of a sum are one along ζ, others are not.
#[test]
fn round_off_along_zeta_breaks_no_symmetry() {
    let tokamak: Strength = |s, theta, _| 2.0 - 0.2 * libm::sqrt(s) * libm::cos(theta);
    let of = |off: f64| {
        let mut data = data(tokamak, (6, 0.0), [8, 6]);
        data.strength[48 + 3] += off;
        Boozer::new(data).expect("a field").is_axisymmetric()
    };
    assert!(of(0.0) && of(8.0 * f64::EPSILON));
    assert!(!of(1e-9));
}

/// Tables that leave the numbers' range by more than half of it are told, with the place; those of smooth numbers are not.
#[test]
fn tables_that_leave_the_numbers_are_told() {
    let of = |spoil: &dyn Fn(&mut BoozerData)| {
        let mut data = data(stellarator, (13, 0.0), [8, 6]);
        spoil(&mut data);
        let field = Boozer::new(data).expect("a field");
        let departures = field.departures().iter();
        let told = departures.map(|one| (one.name, one.place.clone()));
        told.collect::<Vec<_>>()
    };
    assert_eq!(of(&|_| ()), []);
    // Surfaces from 0 to 0.55 and one at the edge. The polynomials of degree 5 over the gap, nine distances wide, take a hundredth at
    // its beginning 47 times in its middle.
    let gap = of(&|data| {
        for (at, s) in data.s.iter_mut().enumerate() {
            *s = if at == 12 { 1.0 } else { at as f64 / 20.0 };
        }
        data.strength[11 * 48..12 * 48]
            .iter_mut()
            .for_each(|b| *b *= 1.01);
    });
    let place = "between the surfaces s = 0.55 and 1".to_owned();
    assert!(gap.contains(&("|B|", place)), "{gap:?}");
    // A transform that rises within the last surfaces.
    let steep = of(&|data| {
        let rising = data.iota.iter_mut().zip(&data.s);
        rising.for_each(|(iota, s)| *iota = libm::exp(6.0 * (s - 1.0)));
    });
    assert_eq!(
        steep,
        [("iota", "beyond the last surface, s = 1".to_owned())]
    );
}

/// With a transform of nearly 0 a step is still a part of the way along a field period.
#[test]
fn the_step_is_short_for_a_field_without_a_transform() {
    let step = |iota: f64| {
        let mut data = data(
            |s, theta, _| 2.0 - 0.2 * libm::sqrt(s) * libm::cos(theta),
            (6, 0.0),
            [8, 1],
        );
        data.iota = vec![iota; 6];
        let field = Boozer::new(data).expect("a field");
        let written = written_in_boozer(&field, &ions(0), (17, 5), "B.json").expect("a scene");
        let line = written
            .scene
            .lines()
            .find(|line| line.starts_with("time-step"));
        let number = line
            .and_then(|line| line.split('=').nth(1))
            .expect("a step");
        number.trim().parse::<f64>().expect("a number")
    };
    // 2π(G + ιI)/(B v) over forty parts of a field period: shorter than around the short way, below ι = 1/2.
    let [none, tiny, small] = [0.0, 1e-12, 0.1].map(step);
    assert_eq!(none, tiny);
    assert!((small / none - 1.0).abs() < 0.05, "{small} {none}");
    assert!(step(2.0) < none / 3.9);
}

#[test]
fn numbers_that_are_no_field_are_told() {
    let good = data(stellarator, (6, 0.0), [8, 6]);
    assert!(Boozer::new(good.clone()).is_ok());
    let cases: [(Spoil, &str); 20] = [
        (|data| data.periods = 0, "`periods` is 0"),
        (|data| data.edge_flux = 0.0, "is 0"),
        (
            |data| data.edge_flux = f64::NAN,
            "`psi` is NaN: it must be finite",
        ),
        (
            |data| data.edge_flux = 1e-300,
            "`psi` is 1e-300 Wb/rad: with |B| = 2",
        ),
        (|data| data.edge_flux = -1e200, "the major radius"),
        (
            |data| data.periods = u32::MAX,
            "`periods` is 4294967295: a torus has 1 to 1000",
        ),
        (
            |data| data.strength[5] += 1e-3,
            "the axis is one point for all theta",
        ),
        // Between the surfaces s = 0.8 and 1, and beyond.
        (
            |data| data.strength[288 - 48..].iter_mut().for_each(|b| *b = 1e-3),
            "beyond the last surface, s = 1: give surfaces there",
        ),
        // Surfaces at 0.6 and more, and a field that falls to the axis.
        (
            |data| {
                data.s.iter_mut().for_each(|s| *s = 0.6 + 0.4 * *s);
                let each = data.strength.len() / 6;
                for (at, b) in data.strength.iter_mut().enumerate() {
                    *b = libm::exp(8.0 * (at / each) as f64 / 5.0);
                }
            },
            "before the first surface, s = 0.6: give surfaces there",
        ),
        (
            |data| {
                data.nodes = [4, 6];
                let kept = |at: &usize| at % 48 < 24;
                data.strength = (0..288).filter(kept).map(|at| data.strength[at]).collect();
                for surface in data.strength.chunks_mut(24) {
                    let first = surface[..6].to_vec();
                    surface[18..].copy_from_slice(&first);
                }
            },
            "3 nodes of theta and 6 of zeta but for the last one, which repeats the first",
        ),
        (|data| data.s[2] = 0.0, "rises from 0"),
        (|data| data.s[5] = 1.5, "`s` is 1.5 at surface 6"),
        (
            |data| data.s.iter_mut().for_each(|s| *s /= 4.0),
            "`s` ends at 0.25",
        ),
        (|data| data.iota.truncate(5), "`iota` has 5 numbers"),
        (|data| data.i.truncate(5), "`I` has 5 numbers"),
        (|data| data.strength.truncate(287), "`B` has 287 numbers"),
        (|data| data.strength[100] = -1.0, "`B` is -1 on surface 3"),
        (|data| data.g[3] = -3.0, "`G + iota I`"),
        (|data| data.i[0] = 0.1, "where no current is enclosed"),
        (
            |data| data.iota[1] = f64::INFINITY,
            "`iota` is inf on surface 2: it must be finite",
        ),
    ];
    for (spoil, message) in cases {
        let mut data = good.clone();
        spoil(&mut data);
        let error = Boozer::new(data).expect_err(message).to_string();
        assert!(error.contains(message), "{error}");
    }
    let field = Boozer::new(good).expect("a field");
    for (ions, message) in [
        (
            Ions {
                pitch: 2.0,
                ..ions(0)
            },
            "from -1 to 1",
        ),
        (
            Ions {
                surface: 1.0,
                ..ions(0)
            },
            "between the axis",
        ),
        (
            Ions {
                energy: 1e9,
                ..ions(0)
            },
            "not relativistic",
        ),
    ] {
        let error = written_in_boozer(&field, &ions, (17, 5), "B.json").expect_err(message);
        assert!(error.to_string().contains(message), "{error}");
    }
}
