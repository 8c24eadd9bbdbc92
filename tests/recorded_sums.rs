//! Recorded functions of sums over sites, and the temperature of spins, against the sums added one by one.

use leafwise::core::Registry;
use leafwise::scene::{ComposedRun, compose};
use leafwise_tests::scenes::{composed, document};

/// Values of the formulas that a run records, at its initial state.
fn recorded(run: &ComposedRun) -> Vec<f64> {
    let functions = run.recorded_functions().expect("code");
    let mut values = functions
        .values(1, &run.system.parameter_values())
        .expect("code");
    values.at(&run.plan.initial).to_vec()
}

const INITIAL: [&str; 3] = ["0.3 + sin(AT)", "cos(2*AT + 1)", "0.4*sin(3*AT)"];

/// Spins on a lattice, each bond −J s·s' and a field along z, with these observables.
fn spins(lengths: &str, boundary: &str, observables: &str) -> ComposedRun {
    let axes = lengths.matches(',').count() + 1;
    let [here, indices, count] = [
        ["i", "i", "i"],
        ["i,j", "i, j", "i + 7*j"],
        ["i,j,k", "i, j, k", "i + 7*j + 0.3*k"],
    ][axes - 1];
    let ahead = ["i", "j", "k"][..axes]
        .iter()
        .map(|axis| here.replace(axis, &format!("{axis}+1")));
    let bonds: Vec<String> = ahead
        .map(|there| format!("dot(s[{here}], s[{there}])"))
        .collect();
    let initial = ["x", "y", "z"].iter().zip(INITIAL).map(|(c, value)| {
        format!(
            "\"s.{c}[{here}]\" = \"{}\"",
            value.replace("AT", &format!("({count})"))
        )
    });
    let initial: Vec<String> = initial.collect();
    composed(&format!(
        "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = [{lengths}] }} }}\nboundary = \"{boundary}\"\n\
         bracket = {{ lie-algebra = \"so3\" }}\nparameters = {{ J = 0.7 }}\n\
         hamiltonian = \"-J*sum({indices}, {}) - 0.3*sum({indices}, s.z[{here}])\"\n\
         [method]\nstepper = \"sublattices\"\ntime-step = 0.01\n\
         [run]\nsteps = 1\nrecord = {{ observables = [{}] }}\ninitial = {{ {} }}\n",
        bonds.join(" + "),
        observables
            .replace("HERE", here)
            .replace("INDICES", indices),
        initial.join(", ")
    ))
}

/// Spins of a state, whose coordinates are those of all x, of all y, of all z.
fn vectors(state: &[f64]) -> Vec<[f64; 3]> {
    let sites = state.len() / 3;
    let at = |site| [0, 1, 2].map(|c| state[c * sites + site]);
    (0..sites).map(at).collect()
}

const LATTICES: [(&str, &str); 8] = [
    ("8", "open"),
    ("60", "periodic"),
    ("400", "periodic"),
    ("401", "open"),
    ("20, 22", "periodic"),
    ("20, 21", "open"),
    ("8, 6, 8", "periodic"),
    ("7, 8, 9", "open"),
];

#[test]
fn functions_of_sums_are_those_of_sums_added_one_by_one() {
    let observables = "{ q = \"sum(INDICES, s.z[HERE])^2/3\" }, { a = \"norm(sum(INDICES, s[HERE]))\" }, \
        { b = \"sum(INDICES, s.x[HERE])*sum(INDICES, s.x[HERE]*s.y[HERE])/(1 + sum(INDICES, s.z[HERE]^2))\" }, \
        { c = \"if(sum(INDICES, s.z[HERE]) > sum(INDICES, s.x[HERE]), sum(INDICES, s.y[HERE]), -J)\" }, \
        { d = \"sum(INDICES, s.y[HERE])\" }";
    for (lengths, boundary) in LATTICES {
        let run = spins(lengths, boundary, observables);
        let spins = vectors(&run.plan.initial);
        let sum = |of: &dyn Fn(&[f64; 3]) -> f64| spins.iter().map(of).sum::<f64>();
        let [x, y, z] = [0, 1, 2].map(|c| sum(&|s| s[c]));
        let xy = sum(&|s| s[0] * s[1]);
        let zz = sum(&|s| s[2] * s[2]);
        let c = if z > x { y } else { -0.7 };
        let norm = libm::sqrt(x * x + y * y + z * z);
        let expected = [z * z / 3.0, norm, x * xy / (1.0 + zz), c, y];
        let size = spins.len() as f64;
        let found = recorded(&run);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            // Sums of so many numbers of order 1, one after the other, at most squared.
            let bound = f64::EPSILON * size * (1.0 + expected.abs());
            assert!(
                (found - expected).abs() <= bound,
                "{lengths} {boundary}: {found} for {expected}"
            );
        }
    }
}

/// |s × ∂H|² and −2 s·∂H of every spin, with the fields of the bonds that are there.
#[test]
fn the_temperature_of_spins_is_that_of_their_fields() {
    for (lengths, boundary) in LATTICES {
        let run = spins(lengths, boundary, "\"spin-temperature\"");
        let spins = vectors(&run.plan.initial);
        let lengths: Vec<usize> = lengths
            .split(", ")
            .map(|n| n.parse().expect("a number"))
            .collect();
        let (mut turns, mut along) = (0.0, 0.0);
        for (site, s) in spins.iter().enumerate() {
            let mut field = [0.0, 0.0, 0.3];
            let mut stride = spins.len();
            for length in &lengths {
                stride /= length;
                let place = site / stride % length;
                for there in [place as isize - 1, place as isize + 1] {
                    let wrapped = there.rem_euclid(*length as isize) as usize;
                    if boundary == "open" && wrapped as isize != there {
                        continue;
                    }
                    let other = spins[site + wrapped * stride - place * stride];
                    field.iter_mut().zip(other).for_each(|(b, s)| *b += 0.7 * s);
                }
            }
            let [x, y, z] = *s;
            let cross = [
                y * field[2] - z * field[1],
                z * field[0] - x * field[2],
                x * field[1] - y * field[0],
            ];
            turns += cross.iter().map(|c| c * c).sum::<f64>();
            along += 2.0 * s.iter().zip(field).map(|(s, b)| s * b).sum::<f64>();
        }
        let (found, expected) = (recorded(&run), turns / along);
        let bound = f64::EPSILON * spins.len() as f64 * (1.0 + expected.abs());
        assert!(
            (found[0] - expected).abs() <= 8.0 * bound,
            "{lengths:?} {boundary}: {found:?} for {expected}"
        );
    }
}

/// Factors of the brackets, a number or one of each site, leave the temperature as it is.
#[test]
fn the_temperature_of_spins_knows_no_factor_of_their_brackets() {
    let of = |sites: usize, factor: &str| {
        let entry = |pair: [&str; 3]| {
            let [a, b, c] = pair;
            format!("\"s.{a}[i],s.{b}[i]\" = \"{factor}*s.{c}[i]\"")
        };
        let entries = [["x", "y", "z"], ["y", "z", "x"], ["z", "x", "y"]].map(entry);
        let run = composed(&format!(
            "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }} }}\n\
             bracket = {{ {} }}\nparameters = {{ c = 1.7, \"g[i]\" = \"1 + 0.5*sin(i)\" }}\n\
             hamiltonian = \"-sum(i, dot(s[i], s[i+1])) - 0.2*sum(i, s.z[i]^2)\"\n\
             [method]\nstepper = \"rk4\"\ntime-step = 0.01\n[run]\nsteps = 1\nrecord = {{ observables = [\"spin-temperature\"] }}\n\
             initial = {{ \"s.x[i]\" = \"sin(i)\", \"s.y[i]\" = \"cos(2*i)\", \"s.z[i]\" = \"0.4\" }}\n",
            entries.join(", ")
        ));
        recorded(&run)[0]
    };
    for sites in [4, 20, 400] {
        let expected = of(sites, "-1");
        for factor in ["2", "c", "1/g[i]"] {
            let found = of(sites, factor);
            let off = (found - expected).abs();
            assert!(
                off <= 1e-13 * expected.abs(),
                "{sites} {factor}: {found} for {expected}"
            );
        }
    }
}

/// Coordinates of single sites beside sums, and an anisotropy by a parameter of sites, on more than 1024 coordinates.
#[test]
fn single_sites_stand_beside_sums() {
    let run = spins(
        "400",
        "periodic",
        "\"s.x[399]*sum(i, s.z[i])^2\", \"s.x[3]^2 + J\"",
    );
    let spins = vectors(&run.plan.initial);
    let z: f64 = spins.iter().map(|s| s[2]).sum();
    let expected = [spins[399][0] * z * z, spins[3][0] * spins[3][0] + 0.7];
    let found = recorded(&run);
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= 1e-13 * (1.0 + expected.abs()),
            "{found} for {expected}"
        );
    }
}

#[test]
fn what_has_no_such_sum_is_refused_where_it_stands() {
    let refused = |observables: &str, with: (&str, &str)| {
        let text = "[system]\nfamilies = { s = { components = [\"x\", \"y\", \"z\"], length = 500 } }\n\
                    bracket = { lie-algebra = \"so3\" }\nhamiltonian = \"sum(i, s.x[i]*s.x[i+1])\"\n\
                    [method]\nstepper = \"splitting\"\ntime-step = 0.01\n\
                    [run]\nsteps = 1\nrecord = { observables = [OBSERVABLES] }\n\
                    initial = { \"s.x[i]\" = 1, \"s.y[i]\" = 0, \"s.z[i]\" = 0 }\n";
        let text = text
            .replace("OBSERVABLES", observables)
            .replace(with.0, with.1);
        compose(&document(&text, &[]), &Registry::with_builtin())
            .map(drop)
            .expect_err(observables)
            .message
            .clone()
    };
    let none = ("\n\n", "\n\n");
    for (observables, with, message) in [
        (
            "\"sum(i, s.z[i])^2/s.x[500]\"",
            none,
            "`s.x` has the members s.x[0] to s.x[499]",
        ),
        (
            "\"sum(i, sum(j, s.z[i]*s.z[j]))^2\"",
            none,
            "such formulas are written out on lattices of at most 1024",
        ),
        ("\"sum(i, w[i]*s.z[i])^2\"", none, "unknown name `w`"),
        (
            "\"D(sum(i, s.z[i]), s.z[3])\"",
            none,
            "this is not a combination of sums over sites",
        ),
        (
            "\"spin-temperature\"",
            ("{ lie-algebra = \"so3\" }", "{ \"s.x[i],s.y[i]\" = 1 }"),
            "`spin-temperature` is that of coordinates with the brackets of so(3)",
        ),
    ] {
        let found = refused(observables, with);
        assert!(found.contains(message), "{observables}: {found}");
    }
}

/// A row of a long plane is no sum over sites; it is recorded as the coordinates that it is.
#[test]
fn rows_of_planes_are_recorded_as_they_are() {
    let plane = |record: &str| {
        format!(
            "[system]\nfamilies = {{ q = [25, 24], p = [25, 24] }}\nbracket = \"canonical\"\n\
             hamiltonian = \"sum(i, j, p[i,j]^2/2 + q[i,j]*q[i+1,j])\"\n[method]\nstepper = \"splitting\"\ntime-step = 0.1\n\
             [run]\nsteps = 1\nrecord = {{ {record} }}\ninitial = {{ \"q[i,j]\" = \"i + 100*j\", \"p[i,j]\" = 0 }}\n"
        )
    };
    let registry = Registry::with_builtin();
    let refused = document(&plane("observables = [\"sum(j, q[2,j])\"]"), &[]);
    let refusal = compose(&refused, &registry).err().expect("refused");
    assert!(
        refusal
            .message
            .starts_with("this sum does not run over all sites"),
        "{}",
        refusal.message
    );
    let help = refusal.help.expect("a help");
    let (_, cure) = help.split_once("states = ").expect("a key");
    let (cure, _) = cure.split_once(']').expect("a list");
    let run = composed(&plane(&format!("states = {cure}]\"]")));
    assert_eq!(run.plan.states.names()[..2], ["q[2,0]", "q[2,1]"]);
    assert_eq!(run.plan.states.width(), 24);
}

/// Σ_i cos q_i M with M = Σ_i cos q_i: energies, motion and records are those of M with an index of another name.
#[test]
fn a_mean_field_by_a_name_is_that_of_its_formula() {
    let of = |sites: usize, energy: &str, m: &str| {
        let run = composed(&format!(
            "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = \"canonical\"\nconvention = \"{{x,H}}\"\n\
             define = {{ M = \"sum(i, cos(q[i]))\" }}\nhamiltonian = \"sum(i, p[i]^2/2) - {energy}/N\"\n\
             [method]\nstepper = \"rk4\"\ntime-step = 0.1\n[run]\nsteps = 10\n\
             record = {{ observables = [\"energy\", {{ m = \"{m}\" }}] }}\n\
             initial = {{ \"q[i]\" = \"sin(0.3*i^2)\", \"p[i]\" = \"cos(i)\" }}\n"
        ));
        let mut walk = run.walk();
        walk.advance(10).expect("every step");
        (walk.state().to_vec(), recorded(&run))
    };
    let mut found = 0;
    for sites in [12, 20, 600] {
        let by_name = of(sites, "sum(i, cos(q[i])*M)", "sum(i, q[i]*M)");
        let written = "sum(j, cos(q[j]))";
        let expected = of(
            sites,
            &format!("sum(i, cos(q[i])*{written})"),
            &format!("sum(i, q[i]*{written})"),
        );
        let pairs = by_name.0.iter().zip(&expected.0);
        let off = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(off < 1e-12, "{sites}: {off:e}");
        let [m, expected] = [by_name.1[0], expected.1[0]];
        assert!(
            (m - expected).abs() < 1e-12 * (sites * sites) as f64,
            "{m} for {expected}"
        );
        found += 1;
    }
    assert_eq!(found, 3);
}
