//! Numbers for every two sites of a chain.

use std::fs;
use std::path::Path;

use leafwise_core::Registry;

use super::{compose_system, document};
use crate::document::SceneDocument;

const CHAIN: &str = "families = { q = 3, p = 3 }\nbracket = { \"q[i],p[i]\" = \"-1\" }\n\
                     hamiltonian = \"sum(i, p[i]^2/2) + sum(i, j, J[i,j]*q[i]^2*q[j])\"\n";
const START: &str = "initial = { \"q[i]\" = [1, 3, 5], \"p[i]\" = 0 }";

fn chain(parameters: &str) -> String {
    format!("{CHAIN}parameters = {{ {parameters} }}")
}

/// As `numpy.save` writes doubles.
fn npy(shape: &str, values: &[f64]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// A folder with files of numbers, right and wrong.
fn files() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes);
    let whole: Vec<f64> = (0..9).map(f64::from).collect();
    write("j.csv", b"0,1,2\n3,4,5\n6,7,8\n").expect("written");
    write("j.json", b"[[0,1,2],[3,4,5],[6,7,8]]").expect("written");
    write("j.npy", &npy("(3, 3)", &whole)).expect("written");
    write("row.npy", &npy("(9,)", &whole)).expect("written");
    let mut broken = whole;
    broken[5] = f64::NAN;
    write("nan.npy", &npy("(3, 3)", &broken)).expect("written");
    write("nan.csv", b"0,1,2\n3,4,nan\n6,7,8\n").expect("written");
    write("short.csv", b"0,1\n3,4\n").expect("written");
    write("site.npy", &npy("(3,)", &[1.0, 3.0, 5.0])).expect("written");
    folder
}

fn beside(folder: &Path, system: &str, start: &str) -> SceneDocument {
    let mut document = document(system, start);
    document.name = folder.join("scene.toml").display().to_string();
    document
}

/// J_ij = 3i + j, from each place where numbers may stand: H is Σ J_ij q_i² q_j, and has no more coordinates.
#[test]
fn numbers_from_each_place_are_one_matrix() {
    let folder = files();
    let q = [1.0, 3.0, 5.0];
    let pairs = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    let expected: f64 = pairs
        .map(|(i, j)| (3 * i + j) as f64 * q[i] * q[i] * q[j])
        .sum();
    for parameters in [
        "\"J[i,j]\" = \"3*i + j\"",
        "a = 1.5, b = \"2*a\", \"J[k,l]\" = \"b*k + l\"",
        "\"J[i,j]\" = [[0, 1, 2], [3, 4, 5], [6, 7, 8]]",
        "\"J[i,j]\" = { file = \"j.csv\" }",
        "\"J[i,j]\" = { file = \"j.json\" }",
        "\"J[i,j]\" = { file = \"j.npy\" }",
    ] {
        for start in [
            START,
            "initial = { \"q[i]\" = { file = \"site.npy\" }, \"p[i]\" = 0 }",
        ] {
            let scene = beside(folder.path(), &chain(parameters), start);
            let composed = compose_system(&scene).expect("a system");
            assert_eq!(composed.initial, [1.0, 3.0, 5.0, 0.0, 0.0, 0.0]);
            let formulas = composed.system.expressions().expect("formulas");
            let energy = formulas.hamiltonian().evaluate(&composed.initial, &[1.5]);
            assert_eq!(energy, expected, "{parameters}");
        }
    }
}

/// Neighbours on a ring and single entries, where the chain is written out.
#[test]
fn entries_are_named_as_sites_are() {
    let scene = CHAIN.replace(
        "sum(i, j, J[i,j]*q[i]^2*q[j])",
        "sum(i, J[i,i+1]*q[i]) + J[2,N-1]*q[0] + sum(j, J[1,j]*p[j])",
    );
    let scene = format!("{scene}parameters = {{ \"J[i,j]\" = \"3*i + j\" }}");
    let composed = compose_system(&document(&scene, START)).expect("a system");
    let formulas = composed.system.expressions().expect("formulas");
    // J_01 + 3 J_12 + 5 J_20 + J_22, and Σ J_1j p_j.
    let state = [1.0, 3.0, 5.0, 1.0, 1.0, 1.0];
    let expected = 1.0 + 15.0 + 30.0 + 8.0 + 12.0 + 1.5;
    assert_eq!(formulas.hamiltonian().evaluate(&state, &[]), expected);
}

#[test]
fn what_is_no_matrix_is_refused_where_it_stands() {
    let folder = files();
    for (parameters, piece, said) in [
        (
            "\"J[i,j]\" = [[0, 1], [2, 3]]",
            "[[0, 1], [2, 3]]",
            "shape [2, 2], and there are 3 sites",
        ),
        ("\"J[i,j]\" = [1, 2, 3]", "[1, 2, 3]", "shape [3]"),
        ("\"J[i,j]\" = \"1/(i - j)\"", "1/(i - j)", "J[0,0] is inf"),
        ("\"J[i,j]\" = \"q[i]\"", "q[i", "`q` "),
        ("\"J[i,j]\" = \"k\"", "k", "unknown name `k`"),
        (
            "\"J[i,j]\" = { file = \"none.npy\" }",
            "\"none.npy\"",
            "cannot read",
        ),
        (
            "\"J[i,j]\" = { file = \"row.npy\" }",
            "\"row.npy\"",
            "shape [9]",
        ),
        (
            "\"J[i,j]\" = { file = \"short.csv\" }",
            "\"short.csv\"",
            "shape [2, 2]",
        ),
        (
            "\"J[i,j]\" = { file = \"nan.npy\" }",
            "\"nan.npy\"",
            "J[1,2] is NaN",
        ),
        (
            "\"J[i,j]\" = { file = \"nan.csv\" }",
            "\"nan.csv\"",
            "row 2 holds NaN",
        ),
        (
            "\"J[i,j]\" = { file = \"j.csv\", column = \"J\" }",
            "\"J\"",
            "`J` is a matrix",
        ),
        (
            "\"J[i,j]\" = 1, \"b[i]\" = [[1, 2, 3]]",
            "[[1, 2, 3]]",
            "the numbers have the shape [1, 3], and the sites of `b[i]` have the shape [3]",
        ),
    ] {
        let scene = beside(folder.path(), &chain(parameters), START);
        let refusal = compose_system(&scene).expect_err(parameters);
        assert!(
            refusal.message.contains(said),
            "{parameters}: {}",
            refusal.message
        );
        let found = &refusal.source_text[refusal.span.clone()];
        assert_eq!(found, piece, "{parameters}");
    }
    for (named, said) in [
        ("J[i]", "1"),
        ("J", "2"),
        ("J[i,3]", "J[0] to J[2]"),
        ("J[i,k]", "`k`"),
    ] {
        let scene = CHAIN.replace("J[i,j]", named);
        let scene = format!("{scene}parameters = {{ \"J[i,j]\" = 1 }}");
        let refusal = compose_system(&document(&scene, START)).expect_err(named);
        assert!(
            refusal.message.contains(said),
            "{named}: {}",
            refusal.message
        );
    }
}

#[test]
fn keys_that_are_a_part_of_a_matrix_are_told_when_a_scene_is_read() {
    for (parameters, said) in [
        ("\"J[0,1]\" = 1", "single entries"),
        ("\"J[i,1]\" = 1", "a part of its entries"),
        ("\"J[i,j+1]\" = 1", "a part of its entries"),
        ("\"J[i,i]\" = 1", "its diagonal"),
        ("\"J[i,j]\" = 1, \"J[k,l]\" = 2", "`J` is declared twice"),
        ("\"q[i,j]\" = 1", "`q` is declared twice"),
    ] {
        let system = chain(parameters);
        let text =
            format!("[system]\n{system}\n[method]\ntime-step = 0.1\n[run]\nsteps = 1\n{START}\n");
        let errors = SceneDocument::parse("scene.toml", &text, &Registry::empty());
        let errors = errors.expect_err(said).diagnostics();
        assert!(
            errors.iter().any(|error| error.message.contains(said)),
            "{said}: {errors:?}"
        );
    }
}

/// Grids of numbers, wherever they stand, are values of a plane's sites; in space the rows are those of the last axis.
#[test]
fn grids_are_values_of_sites() {
    let folder = files();
    let numbers: Vec<f64> = (0..9).map(f64::from).collect();
    for (lengths, indices) in [("[3, 3]", "i,j"), ("[3, 1, 3]", "i,j,k")] {
        let system = format!(
            "families = {{ q = {lengths}, p = {lengths} }}\nbracket = {{ \"q[{indices}],p[{indices}]\" = 1 }}\n\
             hamiltonian = \"sum({indices}, p[{indices}]^2/2)\""
        );
        let start = |values: &str| {
            format!("initial = {{ \"q[{indices}]\" = {values}, \"p[{indices}]\" = 0 }}")
        };
        for values in [
            "{ file = \"j.csv\" }",
            "{ file = \"j.json\" }",
            "{ file = \"j.npy\" }",
            "{ file = \"row.npy\" }",
        ] {
            let scene = beside(folder.path(), &system, &start(values));
            let composed = compose_system(&scene).expect(values);
            assert_eq!(composed.initial[..9], numbers, "{lengths} {values}");
        }
        let scene = beside(folder.path(), &system, &start("{ file = \"short.csv\" }"));
        let refusal = compose_system(&scene).expect_err("four numbers");
        assert!(
            refusal.message.contains("4 numbers, and `q` has 9 sites"),
            "{}",
            refusal.message
        );
    }
}
