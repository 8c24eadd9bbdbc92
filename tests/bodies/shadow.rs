//! Shadow energies of many bodies, in loops.

use std::fmt::Write as _;

use leafwise::core::Registry;
use leafwise::scene::compose::{ShadowEnergy, compose};
use leafwise_tests::scenes::{composed, document};

use super::in_loops;

/// Rotors with masses, two terms of a pair and a field: H, with sums by indices or written out, as text.
fn rotors(sites: usize, method: &str, is_written: bool) -> String {
    let mut energy = String::from("0");
    let mut names = [String::new(), String::new()];
    let mut bracket = String::new();
    for i in 0..sites {
        let mass = format!("({})", 1.0 + 0.125 * (i % 4) as f64);
        let _ = write!(energy, " + p{i}^2/(2*{mass}) + sin(q{i})");
        for j in i + 1..sites {
            let _ = write!(
                energy,
                " - cos(q{i} - q{j})/{sites} + sin(q{i} + 2*q{j})/100"
            );
        }
        let _ = write!(names[0], "\"q{i}\", ");
        let _ = write!(names[1], "\"p{i}\", ");
        let _ = write!(bracket, "\"q{i},p{i}\" = \"1\", ");
    }
    let number = |at: f64| format!("{at:e}");
    let q = (0..sites).map(|i| number(libm::sin(1.3 * i as f64)));
    let p = (0..sites).map(|i| number(0.3 * libm::cos(0.7 * i as f64)));
    let initial: Vec<String> = q.chain(p).collect();
    let masses = (0..sites).map(|i| number(1.0 + 0.125 * (i % 4) as f64));
    let masses: Vec<String> = masses.collect();
    let system = match is_written {
        true => format!(
            "variables = [{}{}]\nbracket = {{ {bracket} }}\nhamiltonian = \"{energy}\"\n",
            names[0], names[1]
        ),
        false => format!(
            "families = {{ q = {sites}, p = {sites} }}\nbracket = {{ \"q[i],p[i]\" = \"1\" }}\nparameters = {{ \"m[i]\" = [{}] }}\n\
             hamiltonian = \"sum(i, p[i]^2/(2*m[i]) + sin(q[i])) + sum(i<j, sin(q[i] + 2*q[j])/100 - cos(q[i] - q[j])/N)\"\n",
            masses.join(", ")
        ),
    };
    let initial = match is_written {
        true => format!("[{}]", initial.join(", ")),
        false => format!(
            "{{ \"q[i]\" = [{}], \"p[i]\" = [{}] }}",
            initial[..sites].join(", "),
            initial[sites..].join(", ")
        ),
    };
    format!(
        "[system]\nconvention = \"{{x,H}}\"\n{system}[method]\n{method}\ntime-step = 0.2\n[run]\nsteps = 10\n\
         record = {{ observables = [\"shadow-energy of order 4\", \"energy\"] }}\ninitial = {initial}\n"
    )
}

/// H̃ in loops is that of the formulas, with either part outside: at three states, to the rounding of sums of 24² terms of size 1.
#[test]
fn shadow_energies_in_loops_are_those_of_the_formulas() {
    let sites = 24;
    for method in [
        "stepper = \"splitting\"",
        "stepper = { name = \"splitting\", pieces = \"2 1\" }",
    ] {
        let (run, whole) = (
            in_loops(&rotors(sites, method, false)),
            composed(&rotors(sites, method, true)),
        );
        assert!(whole.system.expressions().is_some());
        let mut found = run
            .recorded_functions()
            .expect("code")
            .values(1, &[])
            .expect("code");
        let mut expected = whole
            .recorded_functions()
            .expect("code")
            .values(1, &[])
            .expect("code");
        let mut energies = Vec::new();
        for turn in [0.0, 0.5, 2.0] {
            let x = run.plan.initial.iter().enumerate();
            // Masses, behind the coordinates, stay.
            let at = |(i, x): (usize, &f64)| match i < 2 * sites {
                true => x + libm::sin(turn * i as f64),
                false => *x,
            };
            let x: Vec<f64> = x.map(at).collect();
            let [own, other] = [found.at(&x)[0], expected.at(&x[..2 * sites])[0]];
            assert!(
                (own - other).abs() <= 1e-12,
                "{method} {turn}: {own} {other}"
            );
            energies.push(own);
        }
        assert!(
            energies
                .windows(2)
                .all(|two| (two[0] - two[1]).abs() > 1e-3)
        );
    }
}

/// Over the same time, steps half as long keep H̃ sixteen times as well, and H four times.
#[test]
fn shadow_energies_in_loops_are_kept_to_order_four() {
    let change = |h: f64| {
        let text = rotors(60, "stepper = \"splitting\"", false);
        let run = in_loops(&text.replace("time-step = 0.2", &format!("time-step = {h:?}")));
        let mut functions = run
            .recorded_functions()
            .expect("code")
            .values(1, &[])
            .expect("code");
        let mut walk = run.walk();
        let mut energies = |x: &[f64]| functions.at(x)[0];
        let first = energies(&run.plan.initial);
        let mut largest = 0.0_f64;
        for _ in 0..(4.0 / h) as usize {
            walk.advance(1).expect("a step");
            largest = largest.max((energies(walk.state()) - first).abs());
        }
        largest
    };
    let ratio = change(0.1) / change(0.05);
    assert!((14.0..18.0).contains(&ratio), "{ratio}");
}

/// Where formulas are asked for, the advice is a record that is taken.
#[test]
fn formulas_of_a_shadow_energy_in_loops_are_refused_with_a_record() {
    let record = "record = { observables = [\"energy\", \"shadow-energy\"] }";
    let text = rotors(60, "stepper = \"splitting\"", false);
    let line = text.lines().find(|line| line.starts_with("record"));
    let run = in_loops(&text.replace(line.expect("a record"), record));
    assert_eq!(run.plan.shadow.map(|shadow| shadow.order), Some(4));
    let refused = ShadowEnergy::of(&run.system, run.method.map(), 0.2, None);
    let refused = refused.map(|_| ()).expect_err("no formulas");
    assert!(refused.help.contains(record), "{}", refused.help);
}

/// Of maps whose shadow energy takes more than two brackets it is refused with the mathematics; of few bodies all is written out.
#[test]
fn other_shadow_energies_of_many_bodies_are_refused() {
    let composed_of = "stepper = \"splitting\"\ncomposition = \"suzuki-4\"";
    let gauss = "stepper = { name = \"gauss\", stages = 2 }";
    for (method, order) in [(composed_of, 4), (gauss, 4), ("stepper = \"splitting\"", 6)] {
        let text = rotors(40, method, false).replace("order 4", &format!("order {order}"));
        let refusal = compose(&document(&text, &[]), &Registry::with_builtin());
        let refusal = refusal.map(|_| ()).expect_err("no such energy");
        for part in ["`splitting` of order 4", "fewer than 24 bodies"] {
            assert!(refusal.message.contains(part), "{}", refusal.message);
        }
    }
    let springs = "[system]\nfamilies = { q = 16, p = 16 }\nbracket = \"canonical\"\n\
                   hamiltonian = \"sum(i, p[i]^2/2) + sum(i<j, (q[i] - q[j])^2)/N\"\n[method]\nstepper = \"splitting\"\n\
                   time-step = 0.05\n[run]\nsteps = 10\nrecord = { observables = [\"shadow-energy of order 6\"] }\n\
                   initial = { \"q[i]\" = \"sin(1.3*i)\", \"p[i]\" = 0 }\n";
    assert!(composed(springs).system.expressions().is_some());
}
