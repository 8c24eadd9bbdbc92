//! Linear tensors by name for the tests of this crate.

use leafwise_core::PoissonSystem;
use leafwise_tests::library;
use leafwise_tests::systems::from_formulas;

/// Every algebra the claims are made for: compact, semidirect, split, with conjugate pairs of
/// roots, nilpotent, solvable, one with coordinates of different roots.
pub const ALGEBRAS: [&str; 10] = [
    "rigid-body",
    "so4",
    "se3",
    "heavy-top",
    "sl2",
    "lorentz",
    "heisenberg",
    "affine",
    "toda-3",
    "so5",
];

/// The system of one of [`ALGEBRAS`].
pub fn algebra(name: &str) -> PoissonSystem {
    match name {
        "sl2" => from_formulas(
            &["h", "e", "f"],
            &[("a", 0.8)],
            &[("h,e", "2*e"), ("h,f", "-2*f"), ("e,f", "h")],
            "h^2/2 + a*e^2 + f^2/3 + e*f/4 + h/5",
            &[("killing", "h^2 + 4*e*f")],
        ),
        "heisenberg" => from_formulas(
            &["q", "p", "c"],
            &[],
            &[("q,p", "c")],
            "p^2/2 + q^2/2 + q^4/10 + c*q",
            &[("c", "c")],
        ),
        // Brackets that depend on a parameter, and an algebra that is not unimodular.
        "affine" => from_formulas(
            &["x", "y", "z"],
            &[("a", 0.7), ("b", 1.5)],
            &[("x,y", "a*y + b*z"), ("x,z", "a*z - b*y")],
            "x^2/2 + y^2 + z^2/3 + x*y/4",
            &[],
        ),
        "lorentz" => from_formulas(
            &["j1", "j2", "j3", "k1", "k2", "k3"],
            &[],
            &[
                ("j1,j2", "j3"),
                ("j2,j3", "j1"),
                ("j3,j1", "j2"),
                ("j1,k2", "k3"),
                ("j2,k3", "k1"),
                ("j3,k1", "k2"),
                ("k1,j2", "k3"),
                ("k2,j3", "k1"),
                ("k3,j1", "k2"),
                ("k1,k2", "-j3"),
                ("k2,k3", "-j1"),
                ("k3,k1", "-j2"),
            ],
            "j1^2/2 + j2^2/3 + j3^2/5 + k1^2/4 + k2^2/6 + k3^2/7",
            &[
                ("difference", "j1^2 + j2^2 + j3^2 - k1^2 - k2^2 - k3^2"),
                ("product", "j1*k1 + j2*k2 + j3*k3"),
            ],
        ),
        // Flaschka's variables of three particles on a line.
        "toda-3" => from_formulas(
            &["a1", "a2", "b1", "b2", "b3"],
            &[],
            &[
                ("a1,b1", "-a1"),
                ("a1,b2", "a1"),
                ("a2,b2", "-a2"),
                ("a2,b3", "a2"),
            ],
            "b1^2/2 + b2^2/2 + b3^2/2 + a1^2 + a2^2",
            &[("momentum", "b1 + b2 + b3")],
        ),
        "so5" => rotations(5),
        id => library(id).system,
    }
}

/// A rigid body in n dimensions: {m_ij, m_jk} = m_ik and its images under permutations.
fn rotations(n: usize) -> PoissonSystem {
    let name = |i: usize, j: usize| format!("m{i}{j}");
    let signed = |i: usize, j: usize| {
        if i < j {
            name(i, j)
        } else {
            format!("-{}", name(j, i))
        }
    };
    let mut bracket = Vec::new();
    for i in 1..=n {
        for j in i + 1..=n {
            for k in j + 1..=n {
                let pair = |a: String, b: String| format!("{a},{b}");
                bracket.push((pair(name(i, j), name(j, k)), signed(i, k)));
                bracket.push((pair(name(j, k), name(i, k)), signed(i, j)));
                bracket.push((pair(name(i, j), name(i, k)), signed(k, j)));
            }
        }
    }
    let variables: Vec<String> = (1..=n)
        .flat_map(|i| (i + 1..=n).map(move |j| name(i, j)))
        .collect();
    let energy: Vec<String> = (2..)
        .zip(&variables)
        .map(|(k, v)| format!("{v}^2/{k}"))
        .collect();
    let square: Vec<String> = variables.iter().map(|v| format!("{v}^2")).collect();
    let bracket: Vec<(&str, &str)> = bracket
        .iter()
        .map(|(pair, entry)| (pair.as_str(), entry.as_str()))
        .collect();
    from_formulas(
        &variables.iter().map(String::as_str).collect::<Vec<_>>(),
        &[],
        &bracket,
        &energy.join(" + "),
        &[("square", &square.join(" + "))],
    )
}
