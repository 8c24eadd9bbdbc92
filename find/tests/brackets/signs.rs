//! The sign of H and of the tensor, which the equations leave free.

use super::*;

/// Numbers 0 … below − 1, the same ones each time.
struct Draw(u64);

impl Draw {
    fn next(&mut self, below: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).expect("31 bits") % below
    }

    fn one_of(&mut self, of: &[&'static str]) -> &'static str {
        of[self.next(of.len())]
    }

    fn shuffled<T>(&mut self, mut of: Vec<T>) -> Vec<T> {
        for at in (1..of.len()).rev() {
            let other = self.next(at + 1);
            of.swap(at, other);
        }
        of
    }
}

/// {name, other}, 0 where it has no entry.
fn entry(found: &FoundBracket, name: &str, other: &str) -> String {
    let rows = found.rows();
    let mut named = rows.iter().filter_map(|([x, y], entry)| {
        if *x == name && *y == other {
            return Some(entry.clone());
        }
        (*x == other && *y == name).then(|| match entry.strip_prefix('-') {
            Some(positive) => positive.to_owned(),
            None => format!("-{entry}"),
        })
    });
    named.next().unwrap_or_else(|| "0".to_owned())
}

/// ∂²H/∂x² by the variable of this name, by a difference that is exact to round-off where H is quadratic in it.
fn curvature(found: &FoundBracket, name: &str) -> f64 {
    let names = found.system.variables();
    let at = names.iter().position(|n| n == name).expect("a variable");
    let value = |by: f64| {
        let mut x = vec![0.3; names.len()];
        x[at] += by;
        let values = found.system.parameter_values();
        found.hamiltonian.evaluate(&x, &values)
    };
    value(1.0) - 2.0 * value(0.0) + value(-1.0)
}

/// q' = p/m, p' = −∂V/∂q of one to three parts, coupled or not, with wells and hills: {q, p} = 1 and H has p²/(2m), in any order of the variables
/// where the forces are not linear, and where each position stands before its momentum also of linear ones, of which q' = p, p' = q is as good with
/// both exchanged.
#[test]
fn energies_of_momenta_are_positive() {
    let mut draw = Draw(44);
    let mut count = 0;
    for case in 0..120 {
        let parts = 1 + draw.next(3);
        let is_linear = case % 2 == 0;
        let is_coupled = parts > 1 && draw.next(2) == 0;
        let mut pairs = Vec::new();
        for k in 1..=parts {
            let mass = draw.one_of(&["1", "2", "3", "(1/2)"]);
            let sign = draw.one_of(&["", "-"]);
            let force = match is_linear {
                true => format!("{sign}{}*q{k}", 1 + draw.next(3)),
                false => format!(
                    "{sign}{}",
                    draw.one_of(&["q#^3", "sin(q#)", "q#^2", "(q#-q#^3)"])
                )
                .replace('#', &k.to_string()),
            };
            // −∂V/∂q of V = ± q_k q_{k+1}.
            let mut coupling = String::new();
            for other in [k - 1, k + 1] {
                if is_coupled && (1..=parts).contains(&other) {
                    coupling += &format!(" + q{other}");
                }
            }
            pairs.push([
                (format!("q{k}"), format!("p{k}/{mass}")),
                (format!("p{k}"), force + &coupling),
            ]);
        }
        let pairs = draw.shuffled(pairs);
        let rows: Vec<(String, String)> = match is_linear {
            true => pairs.into_iter().flatten().collect(),
            false => draw.shuffled(pairs.into_iter().flatten().collect()),
        };
        let rows: Vec<(&str, &str)> = rows.iter().map(|(x, f)| (x.as_str(), f.as_str())).collect();
        let found = bracket("parts", &equations(&rows, &[]));
        for k in 1..=parts {
            let [q, p] = [format!("q{k}"), format!("p{k}")];
            assert_eq!(entry(&found, &q, &p), "1", "{rows:?} {}", found.fragment());
            assert!(curvature(&found, &p) > 0.2, "{rows:?} {}", found.fragment());
            count += 1;
        }
    }
    assert!(count > 200, "{count}");
}

/// The pendulum in c = cos q, s = sin q and p, whose tensor is affine, and masses as parameters, in every order of the variables: no square of H is
/// negative. Heavy tops with their weight up and down, in the order of the books and its reverse, have the energy of the turning body.
#[test]
fn energies_of_momenta_are_positive_beside_other_coordinates() {
    let extended = [("c", "-p*s"), ("s", "p*c"), ("p", "-s")];
    let with_mass = [("q", "p/m"), ("p", "k*sin(q)"), ("t", "0*p")];
    let orders = [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ];
    for order in orders {
        let found = bracket("pendulum", &equations(&order.map(|at| extended[at]), &[]));
        let curvatures = ["c", "s", "p"].map(|name| curvature(&found, name));
        let sum: f64 = curvatures.iter().sum();
        let least = curvatures.into_iter().fold(0.0, f64::min);
        assert!(least > -1e-9 && sum > 0.1, "{}", found.fragment());
        for mass in [2, -2] {
            let number = Rational::from_integer;
            let parameters = [("m", number(mass)), ("k", number(1))];
            let rows = order.map(|at| with_mass[at]);
            let found = bracket("pendulum", &equations(&rows, &parameters));
            assert!(curvature(&found, "p") > 0.0, "{}", found.fragment());
        }
    }
    let up: Vec<String> = (HEAVY_TOP.iter())
        .map(|(_, f)| {
            f.replace("+ 0.", "@ 0.")
                .replace("- 0.", "+ 0.")
                .replace('@', "-")
        })
        .collect();
    let up: Vec<(&str, &str)> = (HEAVY_TOP.iter().zip(&up))
        .map(|((x, _), f)| (*x, f.as_str()))
        .collect();
    for rows in [HEAVY_TOP, &up] {
        let reverse: Vec<(&str, &str)> = rows.iter().rev().copied().collect();
        for rows in [rows, &reverse] {
            let found = bracket("heavy top", &equations(rows, &[]));
            for name in ["m1", "m2", "m3"] {
                assert!(curvature(&found, name) > 0.4, "{}", found.fragment());
            }
        }
    }
}
