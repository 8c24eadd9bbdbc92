//! Bodies are told from the sites of a lattice.

use leafwise_core::Registry;

use super::{compose, document};

const VECTORS: &str = "families = { p = { components = [\"x\", \"y\"], length = 3 }, q = { components = [\"x\", \"y\"], length = 3 } }\n\
                       bracket = \"canonical\"\n";

/// The names of the places x and y of a scene's bodies, if it has any.
fn places(system: &str) -> Option<[String; 2]> {
    let document = document(system, "initial = { \"x[i]\" = 0.5 }");
    let sites = super::super::Sites::of(&document);
    let named = |family: usize| sites.geometry.families[family].0.clone();
    sites.plane.map(|plane| plane.map(named))
}

fn two(text: [&str; 2]) -> Option<[String; 2]> {
    Some(text.map(str::to_owned))
}

#[test]
fn bodies_have_two_places_and_no_neighbours() {
    let pairs = "hamiltonian = \"sum(i<j, 1/((q.x[i] - q.x[j])^2 + (q.y[i] - q.y[j])^2)) + sum(i, p.x[i]^2 + p.y[i]^2)\"\n";
    assert_eq!(places(&format!("{VECTORS}{pairs}")), two(["q.x", "q.y"]));
    let vortices = "families = { x = 3, y = 3 }\nhamiltonian = \"sum(i<j, ln((x[i] - x[j])^2 + (y[i] - y[j])^2))\"\n";
    let bracket = "bracket = { \"x[i],y[i]\" = \"1\" }\n";
    assert_eq!(places(&format!("{vortices}{bracket}")), two(["x", "y"]));
    let alone = "families = { x = 3, y = 3 }\nhamiltonian = \"sum(i, x[i]^2 + y[i]^2)\"\n";
    assert_eq!(places(&format!("{alone}{bracket}")), two(["x", "y"]));

    // A neighbour in H, in a definition, in a force and in a key of the bracket.
    let chain = "hamiltonian = \"sum(i, (q.x[i+1] - q.x[i])^2 + q.y[i]^2)\"\n";
    assert_eq!(places(&format!("{VECTORS}{chain}")), None);
    let defined = "define = { bond = \"(x[i-1] - x[i])^2\" }\nfamilies = { x = 3, y = 3 }\nhamiltonian = \"sum(i, bond)\"\n";
    assert_eq!(places(&format!("{defined}{bracket}")), None);
    let forced = "forces = { \"x[i]\" = \"y[i+1]\" }\n";
    assert_eq!(places(&format!("{alone}{bracket}{forced}")), None);
    let next = "bracket = { \"x[i],y[i]\" = \"1\", \"x[i],y[i+1]\" = \"0.5\" }\n";
    assert_eq!(places(&format!("{alone}{next}")), None);

    // One place, a plane of sites, and components of a Lie algebra.
    let line = "families = { q = 3, p = 3 }\nbracket = \"canonical\"\nhamiltonian = \"sum(i<j, cos(q[i] - q[j]))\"\n";
    assert_eq!(places(line), None);
    let plane = "families = { x = [2, 2], y = [2, 2] }\nbracket = { \"x[i,j],y[i,j]\" = \"1\" }\nhamiltonian = \"sum(i, j, x[i,j]^2)\"\n";
    assert_eq!(places(plane), None);
    let spins = "families = { s = { components = [\"x\", \"y\", \"z\"], length = 3 } }\nbracket = { lie-algebra = \"so3\" }\n\
                 hamiltonian = \"sum(i<j, s.x[i]*s.x[j])\"\n";
    assert_eq!(places(spins), None);
}

/// Spins are vectors x, y, z with so(3)'s bracket, also as a summand, and no others.
#[test]
fn spins_are_vectors_of_so3() {
    let vectors = "families = { u = { components = [\"x\", \"y\", \"z\"], length = 3 }, s = { components = [\"x\", \"y\", \"z\"], length = 3 } }\n\
                   hamiltonian = \"sum(i, s.x[i])\"\n";
    let bracket = |u: &str| {
        format!(
            "bracket = {{ sum = [{{ variables = [\"u\"], bracket = {u} }}, {{ variables = [\"s\"], bracket = {{ lie-algebra = \"so3\" }} }}] }}\n"
        )
    };
    let spins = |system: String| {
        let document = document(&system, "initial = { \"s.x[i]\" = 0.5 }");
        super::super::Sites::of(&document).spins
    };
    let heisenberg = "{ lie-algebra = \"sl2\" }";
    assert_eq!(
        spins(format!("{vectors}{}", bracket(heisenberg))),
        [[3, 4, 5]]
    );
    let so3 = "bracket = { lie-algebra = \"so3\" }\n";
    assert_eq!(spins(format!("{vectors}{so3}")), [[0, 1, 2], [3, 4, 5]]);
}

/// Vectors are fields, families fields of their own, and momenta are told by their names.
#[test]
fn fields_are_families_and_vectors() {
    let system = "families = { p = { components = [\"x\", \"y\"], length = 3 }, q = { components = [\"x\", \"y\"], length = 3 }, a = 3, p_a = 3, pa = 3, pb = 3, theta = 3, L = 3 }\n\
                  bracket = { \"q.x[i],p.x[i]\" = \"1\" }\nhamiltonian = \"sum(i, q.x[i])\"\n";
    let fields =
        super::super::Sites::of(&document(system, "initial = { \"a[i]\" = 0.5 }")).fields();
    let told: Vec<_> = fields
        .iter()
        .map(|field| (field.name.as_str(), &field.families[..], field.is_momentum))
        .collect();
    let expected: [(&str, &[usize], bool); 8] = [
        ("p", &[0, 1], true),
        ("q", &[2, 3], false),
        ("a", &[4], false),
        ("p_a", &[5], true),
        ("pa", &[6], true),
        ("pb", &[7], false),
        ("theta", &[8], false),
        ("L", &[9], true),
    ];
    assert_eq!(told, expected);
}

/// The library's bodies are drawn as such, and the place of a family is that in the state.
#[test]
fn coordinates_stand_where_the_state_has_them() {
    let vortices = "variables = [\"a\", \"b\"]\nfamilies = { x = 3, y = 3 }\nbracket = { \"a,b\" = \"1\", \"x[i],y[i]\" = \"1\" }\n\
                    hamiltonian = \"a^2 + b^2 + sum(i<j, (x[i] - x[j])^2)\"\n";
    let document = document(vortices, "initial = [1, 2, 3, 4, 5, 6, 7, 8]");
    let run = compose(&document, &Registry::with_builtin()).expect("a run");
    let sites = &run.plan.sites;
    let own = run.own(&run.plan.initial);
    assert_eq!(own[sites.coordinates(1)], [6.0, 7.0, 8.0]);
}
