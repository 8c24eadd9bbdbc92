//! Heisenberg's open chain at temperature against Fisher's closed forms: the cosines of neighbours are independent, of density
//! e^{K u} with K = J/kT, so that ⟨u⟩ = coth K − 1/K, Var u = 1/K² − 1/sinh² K, and ⟨s_i·s_{i+r}⟩ = ⟨u⟩^r (M. E. Fisher, American
//! Journal of Physics 32 (1964)).

use leafwise::core::Walk;
use leafwise_tests::scenes::composed;

/// J/kT.
const K: f64 = 2.0;

fn chain(sites: usize, step: f64) -> String {
    let channels = ["x", "y", "z"]
        .map(|c| format!("{{ hamiltonian = \"s.{c}[i]\", strength = \"sqrt(2*a/K)\" }}"));
    format!(
        "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }} }}\nboundary = \"open\"\n\
         bracket = {{ lie-algebra = \"so3\" }}\nparameters = {{ a = 0.5, K = {K:?} }}\n\
         hamiltonian = \"-sum(i, s.x[i]*s.x[i+1] + s.y[i]*s.y[i+1] + s.z[i]*s.z[i+1])\"\ndamping = {{ rate = \"a\" }}\n\
         noise = [{}]\n[method]\nstepper = \"sublattices\"\nnoise = \"split\"\ntime-step = {step:?}\n\
         [run]\nseed = 5\nsteps = 1\n[run.initial]\n\"s.x[i]\" = \"sin(0.9*i)\"\n\"s.y[i]\" = 0\n\"s.z[i]\" = \"cos(0.9*i)\"\n",
        channels.join(", ")
    )
}

fn fisher() -> f64 {
    1.0 / libm::tanh(K) - 1.0 / K
}

/// Var u.
fn variance() -> f64 {
    1.0 / (K * K) - 1.0 / (libm::sinh(K) * libm::sinh(K))
}

/// The spins of one state, component after component.
fn spins(state: &[f64]) -> Vec<[f64; 3]> {
    let sites = state.len() / 3;
    let spin = |i: usize| std::array::from_fn(|c| state[c * sites + i]);
    (0..sites).map(spin).collect()
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Eight spins: members that start alike and draw for themselves are independent, and so are their means over time.
#[test]
fn eight_hot_spins_have_fishers_energy() {
    let (run, members) = (composed(&chain(8, 0.1)), 256_usize);
    let each =
        |values: &[f64]| -> Vec<f64> { values.iter().flat_map(|v| vec![*v; members]).collect() };
    let (parameters, initial) = (
        each(&run.system.parameter_values()),
        each(&run.plan.initial),
    );
    let mut all = Walk::side_by_side(run.method.map(), members, (&parameters, &initial), 1.0, 0.1);
    let mut means = vec![0.0; members];
    let (before, steps) = (100, 400);
    for step in 0..before + steps {
        all.step().expect("a step");
        if step < before {
            continue;
        }
        let state = all.state();
        let at = |c: usize, i: usize, member: usize| state[(8 * c + i) * members + member];
        for (member, mean) in means.iter_mut().enumerate() {
            for c in 0..3 {
                let bonds = (0..7).map(|i| at(c, i, member) * at(c, i + 1, member));
                *mean -= bonds.sum::<f64>() / f64::from(steps);
            }
        }
    }
    let mean = means.iter().sum::<f64>() / members as f64;
    let squares: f64 = means.iter().map(|m| (m - mean) * (m - mean)).sum();
    let error = libm::sqrt(squares) / members as f64;
    let exact = -7.0 * fisher();
    println!("energy {mean} +- {error}, exact {exact}");
    assert!((exact + 3.761_20).abs() < 1e-5, "{exact}");
    assert!(
        error < 0.03 && (mean - exact).abs() < 3.0 * error,
        "{mean} ± {error}"
    );
}

/// Ten thousand spins in one motion. The energy of independent bonds has the closed form's variance, that of states far apart in
/// time falls with their number. The spin temperature Σ|s × B|²/2Σ s·B is a ratio of sums over sites, whose error is that of blocks
/// of sites, far longer than the correlation length −1/ln⟨u⟩ = 1.6.
#[test]
fn a_long_hot_chain_has_fishers_energy_and_its_temperature() {
    const SITES: usize = 10_000;
    const STATES: usize = 8;
    const BLOCK: usize = 100;
    let run = composed(&chain(SITES, 0.05));
    assert!(run.method.lattice().is_some());
    let mut walk = run.walk();
    walk.advance(200).expect("steps");
    let (mut bond, mut next) = (0.0, 0.0);
    let mut blocks: Vec<[f64; 2]> = Vec::new();
    let mut longest: f64 = 0.0;
    for _ in 0..STATES {
        // t = 5, ten times the time in which a damping of 1/2 takes a spin into a field of size 1 and 2.
        walk.advance(100).expect("steps");
        let s = spins(&walk.last(0).1);
        let pairs = |apart: usize| {
            s.iter()
                .zip(&s[apart..])
                .map(|(a, b)| dot(a, b))
                .sum::<f64>()
        };
        bond += pairs(1) / ((SITES - 1) * STATES) as f64;
        next += pairs(2) / ((SITES - 2) * STATES) as f64;
        for start in (0..SITES).step_by(BLOCK) {
            let mut sums = [0.0; 2];
            for i in start..start + BLOCK {
                let beside = [i.checked_sub(1), Some(i + 1).filter(|j| *j < SITES)];
                let field: [f64; 3] =
                    std::array::from_fn(|c| beside.iter().flatten().map(|j| s[*j][c]).sum::<f64>());
                let along = dot(&s[i], &field);
                sums[0] += dot(&s[i], &s[i]) * dot(&field, &field) - along * along;
                sums[1] += 2.0 * along;
            }
            blocks.push(sums);
        }
        longest = s.iter().fold(longest, |most, s| {
            most.max((libm::sqrt(dot(s, s)) - 1.0).abs())
        });
    }
    let error = libm::sqrt(variance() / (SITES * STATES) as f64);
    println!(
        "bond {bond} +- {error}, exact {}; lengths {longest:e}",
        fisher()
    );
    assert!(
        (bond - fisher()).abs() < 3.0 * error,
        "{bond} ± {error} for {}",
        fisher()
    );
    // ⟨(u u')²⟩ ≤ 1 bounds the variance of a pair, and neighbouring pairs share a bond.
    let square = fisher() * fisher();
    let bound = libm::sqrt(2.0 / (SITES * STATES) as f64);
    assert!((next - square).abs() < 3.0 * bound, "{next} for {square}");
    let count = blocks.len() as f64;
    let [above, below] = [0, 1].map(|at| blocks.iter().map(|sums| sums[at]).sum::<f64>() / count);
    let temperature = above / below;
    let off = blocks.iter().map(|sums| sums[0] - temperature * sums[1]);
    let error = libm::sqrt(off.map(|off| off * off).sum::<f64>()) / (count * below);
    println!("spin temperature {temperature} +- {error}");
    assert!(
        (temperature - 1.0 / K).abs() < 3.0 * error,
        "{temperature} ± {error}"
    );
    assert!(error < 0.01 / K, "{error}");
    assert!(longest < 1e-14, "{longest:e}");
}
