//! Fields in Boozer coordinates between surfaces and nodes, and numbers that are none.

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

/// Harmonics whose numbers over √s^m are polynomials are met to round-off; others to order 6 in the distance of surfaces,
/// with a surface on the axis and without.
#[test]
fn the_field_is_met_between_surfaces() {
    let linear: Strength = |s, theta, zeta| {
        2.0 - 0.2 * libm::sqrt(s) * libm::cos(theta) + 0.1 * s * libm::cos(2.0 * theta - 5.0 * zeta)
    };
    let field = Boozer::new(data(linear, (8, 0.0), [8, 6])).expect("a field");
    let [within, beyond] = errors(linear, &field);
    assert!(within < 1e-13, "{within:e}");
    assert!(beyond < 1e-2, "{beyond:e}");
    for first in [0.0, 0.01] {
        let of = |surfaces| {
            let field = Boozer::new(data(stellarator, (surfaces, first), [16, 9]));
            errors(stellarator, &field.expect("a field"))[0]
        };
        let (coarse, fine) = (of(13), of(25));
        assert!(fine < 1e-9 && fine < coarse / 16.0, "{coarse:e} {fine:e}");
    }
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

#[test]
fn numbers_that_are_no_field_are_told() {
    let good = data(stellarator, (6, 0.0), [8, 6]);
    assert!(Boozer::new(good.clone()).is_ok());
    let cases: [(Spoil, &str); 13] = [
        (|data| data.periods = 0, "`periods` is 0"),
        (|data| data.edge_flux = 0.0, "is 0"),
        (|data| data.edge_flux = f64::NAN, "not finite"),
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
        (|data| data.iota[1] = f64::INFINITY, "not finite"),
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
