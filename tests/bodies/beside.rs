//! Forces, friction and noise beside sums over pairs.

use std::fmt::Write as _;

use leafwise::core::noise::normals_of;
use leafwise::core::{Registry, StepError, Walk};
use leafwise::scene::compose::compose;
use leafwise_tests::scenes::{composed, document, end};

use super::in_loops;

/// Balls on springs that attract each other, with what stands beside: `{i}` of a template is the index, and the number of a
/// site where all is written out.
struct Beside {
    method: &'static str,
    forces: [&'static str; 2],
    damping: bool,
    friction: [&'static str; 2],
    noise: &'static [&'static str],
}

const ALONE: Beside = Beside {
    method: "",
    forces: ["", ""],
    damping: false,
    friction: ["", ""],
    noise: &[],
};

/// η_q = 0.3 p and η_p = 0.1 sin q, which no momentum drives.
const FORCES: [&str; 2] = ["0.3*p{i}", "0.1*sin(q{i})"];
const FRICTION: [&str; 2] = ["-0.05*q{i}", "-a*p{i}^3"];

/// Noise without forces.
fn noisy_cases() -> [Beside; 6] {
    let of = |noise, method| Beside {
        noise,
        method,
        ..ALONE
    };
    [
        of(&["q{i}", "p{i}*q{i}"], "stepper = \"implicit-midpoint\""),
        of(&["sum(i, cos(q{i}))"], "stepper = \"implicit-midpoint\""),
        of(&["q{i}"], "stepper = \"rk4\""),
        of(&["sin(q{i})", "q{i}^4"], "stepper = \"splitting\""),
        of(
            &["sin(q{i})", "p{i}"],
            "stepper = \"splitting\"\nnoise = \"split\"",
        ),
        of(
            &["sum(i, p{i})", "q{i}"],
            "stepper = \"splitting\"\nnoise = \"split\"",
        ),
    ]
}

/// A formula at a site, or with its index.
fn at(text: &str, site: Option<usize>) -> String {
    match site {
        None => text.replace("{i}", "[i]"),
        Some(site) => text.replace("{i}", &site.to_string()),
    }
}

impl Beside {
    /// The scene, with sums by indices or all terms written out.
    fn scene(&self, sites: usize, is_written: bool) -> String {
        let all: Vec<Option<usize>> = match is_written {
            false => vec![None],
            true => (0..sites).map(Some).collect(),
        };
        let mut text = String::from("[system]\nparameters = { a = 0.2 }\nconvention = \"{x,H}\"\n");
        let mut energy = String::from("0");
        if is_written {
            let names = |name: &str| {
                let all = (0..sites).map(|i| format!("\"{name}{i}\""));
                all.collect::<Vec<_>>().join(", ")
            };
            let _ = writeln!(text, "variables = [{}, {}]", names("q"), names("p"));
            for i in 0..sites {
                let _ = write!(energy, " + p{i}^2/2 + q{i}^4/4");
                for j in i + 1..sites {
                    let _ = write!(energy, " - a/(1 + (q{i} - q{j})^2)/{sites}");
                }
            }
        } else {
            let _ = writeln!(text, "families = {{ q = {sites}, p = {sites} }}");
            energy =
                "sum(i, p[i]^2/2 + q[i]^4/4) - a*sum(i<j, 1/(1 + (q[i] - q[j])^2))/N".to_owned();
        }
        let table = |entries: Vec<(String, String)>| {
            let entries = entries
                .iter()
                .map(|(key, value)| format!("\"{key}\" = \"{value}\""));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        };
        let of_sites = |formulas: [&str; 2]| {
            let keys = all
                .iter()
                .flat_map(|site| [(0, "q{i}", *site), (1, "p{i}", *site)]);
            let entries = keys.filter(|(c, ..)| !formulas[*c].is_empty());
            table(
                entries
                    .map(|(c, key, site)| (at(key, site), at(formulas[c], site)))
                    .collect(),
            )
        };
        let pairs = all
            .iter()
            .map(|site| (at("q{i},p{i}", *site), "1".to_owned()));
        let _ = writeln!(text, "bracket = {}", table(pairs.collect()));
        let _ = writeln!(text, "hamiltonian = \"{energy}\"");
        for (key, formulas) in [("forces", self.forces), ("friction", self.friction)] {
            if formulas != ["", ""] {
                let _ = writeln!(text, "{key} = {}", of_sites(formulas));
            }
        }
        if self.damping {
            let metric = of_sites(["1 + q{i}^2", "0.5"]);
            let _ = writeln!(text, "damping = {{ rate = \"a\", metric = {metric} }}");
        }
        let mut channels = Vec::new();
        for channel in self.noise {
            match channel.strip_prefix("sum(i, ") {
                Some(term) if is_written => {
                    let term = &term[..term.len() - 1];
                    let terms = all.iter().map(|site| at(term, *site));
                    channels.push(terms.collect::<Vec<_>>().join(" + "));
                }
                _ if channel.starts_with("sum") => channels.push(at(channel, None)),
                _ => channels.extend(all.iter().map(|site| at(channel, *site))),
            }
        }
        let channels = channels.iter();
        let channels =
            channels.map(|own| format!("{{ hamiltonian = \"{own}\", strength = \"sqrt(a)\" }}"));
        let channels: Vec<String> = channels.collect();
        if !channels.is_empty() {
            let _ = writeln!(text, "noise = [{}]", channels.join(", "));
        }
        let start = |i: usize| [libm::sin(1.3 * i as f64), 0.3 * libm::cos(0.7 * i as f64)];
        let initial: Vec<String> = (0..2)
            .flat_map(|c| (0..sites).map(move |i| format!("{:e}", start(i)[c])))
            .collect();
        let initial = match is_written {
            true => format!("[{}]", initial.join(", ")),
            false => "{ \"q[i]\" = \"sin(1.3*i)\", \"p[i]\" = \"0.3*cos(0.7*i)\" }".to_owned(),
        };
        let method = self.method;
        let _ = write!(
            text,
            "[method]\n{method}\ntime-step = 0.05\n[run]\nsteps = 10\nseed = 7\ninitial = {initial}\n"
        );
        text
    }
}

/// Ten steps in loops are those of the system written out, with the same random numbers: forces of size 1 over t = 0.5, and sums
/// of 18 terms in another order.
#[test]
fn noise_beside_pairs_moves_as_written_out() {
    for case in noisy_cases() {
        for sites in [16, 18] {
            let run = in_loops(&case.scene(sites, false));
            let whole = composed(&case.scene(sites, true));
            assert!(whole.system.expressions().is_some());
            assert_eq!(
                run.work_of_forces(),
                whole.work_of_forces(),
                "{}",
                case.method
            );
            let (found, expected) = (end(&run), end(&whole));
            let moved = found.iter().zip(&run.plan.initial);
            assert!(moved.map(|(end, x)| (end - x).abs()).fold(0.0, f64::max) > 0.1);
            for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert!(
                    (found - expected).abs() <= 1e-12,
                    "{} {:?} {sites} {at}: {found} {expected}",
                    case.method,
                    case.noise
                );
            }
        }
    }
}

/// The fewest sites, and a few more, whose pairs are taken in loops beside forces: above 1024 coordinates.
const MANY: usize = 520;

/// Random numbers of a step: one for each channel, and site of it.
fn drawn(channel: u32, step: u64) -> f64 {
    libm::sin(0.7 * f64::from(channel) + 1.3 * step as f64)
}

/// The field of a case at a state, by loops written here, with w of channels q and p·q at step `step` of size t.
fn by_hand(case: &Beside, x: &[f64], step: u64, t: f64) -> Vec<f64> {
    let n = x.len() / 2;
    let (a, size) = (0.2, n as f64);
    let (q, p) = x.split_at(n);
    let mut field = vec![0.0; 2 * n];
    for i in 0..n {
        let mut slope = q[i] * q[i] * q[i];
        for j in 0..n {
            let apart = q[i] - q[j];
            let well = 1.0 + apart * apart;
            slope += 2.0 * a * apart / (size * well * well);
        }
        let free = [p[i], -slope];
        let mut form = [slope, p[i]];
        if case.forces != ["", ""] {
            form[0] += 0.3 * p[i];
            form[1] += 0.1 * libm::sin(q[i]);
        }
        if case.damping {
            // Of the motion under H alone.
            form[0] += a * (1.0 + q[i] * q[i]) * free[0];
            form[1] += a * 0.5 * free[1];
        }
        if !case.noise.is_empty() {
            let w = [0, 1].map(|channel| {
                let channel = (channel * n + i) as u32;
                libm::sqrt(a) * drawn(channel, step) / libm::sqrt(t)
            });
            form[0] += w[0] + w[1] * p[i];
            form[1] += w[1] * q[i];
        }
        field[i] = form[1];
        field[n + i] = -form[0];
        if case.friction != ["", ""] {
            field[i] -= 0.05 * q[i];
            field[n + i] -= a * p[i] * p[i] * p[i];
        }
    }
    field
}

/// Steps beside forces of each kind, and beside noise too, are those of loops written here: four stages of rk4, and the equation of the
/// implicit midpoint. Velocities are below 10 and a step is 1/20 long; a solve ends at the round-off of a state of 1040 coordinates.
#[test]
fn steps_beside_forces_are_those_of_loops_written_by_hand() {
    let noise: &[&str] = &["q{i}", "p{i}*q{i}"];
    let of = |method, forces, damping, friction| Beside {
        method,
        forces,
        damping,
        friction,
        noise: &[],
    };
    let (rk4, midpoint) = ("stepper = \"rk4\"", "stepper = \"implicit-midpoint\"");
    let none = ["", ""];
    let mut cases = vec![
        of(rk4, FORCES, false, none),
        of(rk4, none, true, none),
        of(rk4, none, false, FRICTION),
        of(midpoint, FORCES, true, FRICTION),
    ];
    for method in [rk4, midpoint] {
        cases.push(Beside {
            noise,
            ..of(method, FORCES, true, none)
        });
    }
    for case in cases {
        let run = in_loops(&case.scene(MANY, false));
        let t = 0.05;
        let parameters = run.system.parameter_values();
        let own = run
            .method
            .noisy()
            .map(|map| map.with_normals(normals_of(|_, channel, step| drawn(channel, step))));
        let map = own.as_ref().map_or(run.method.map(), |map| map);
        let mut walk = Walk::new(map, &parameters, 1.0, t, &run.plan.initial);
        for step in 0..3 {
            let x = walk.state().to_vec();
            walk.advance(1).expect("a step");
            let found = walk.state();
            let at = |slope: &[f64], part: f64| -> Vec<f64> {
                x.iter().zip(slope).map(|(x, v)| x + part * t * v).collect()
            };
            let slope = if case.method == rk4 {
                let first = by_hand(&case, &x, step, t);
                let second = by_hand(&case, &at(&first, 0.5), step, t);
                let third = by_hand(&case, &at(&second, 0.5), step, t);
                let fourth = by_hand(&case, &at(&third, 1.0), step, t);
                let rows = first.iter().zip(&second).zip(third.iter().zip(&fourth));
                rows.map(|((a, b), (c, d))| (a + 2.0 * b + 2.0 * c + d) / 6.0)
                    .collect()
            } else {
                let middle = x.iter().zip(found).map(|(x, y)| 0.5 * (x + y));
                by_hand(&case, &middle.collect::<Vec<_>>(), step, t)
            };
            for (i, (found, expected)) in found.iter().zip(at(&slope, 1.0)).enumerate() {
                assert!(
                    (found - expected).abs() <= 1e-13,
                    "{} {} {:?} {step} {i}: {found} {expected}",
                    case.method,
                    case.damping,
                    case.noise
                );
            }
        }
    }
}

/// Gauss methods of order 8, Taylor series and an embedded pair have the same motion: 0.05⁸ is 4e-11, times derivatives below 10.
#[test]
fn methods_beside_forces_agree() {
    let ends = [
        "stepper = { name = \"gauss\", stages = 4 }",
        "stepper = \"taylor\"",
        "stepper = \"dop853\"",
    ];
    let ends = ends.map(|method| {
        let case = Beside {
            method,
            forces: FORCES,
            damping: true,
            friction: FRICTION,
            noise: &[],
        };
        end(&in_loops(&case.scene(MANY, false)))
    });
    for other in &ends[1..] {
        for (at, (a, b)) in ends[0].iter().zip(other).enumerate() {
            assert!((a - b).abs() <= 1e-9, "{at}: {a} {b}");
        }
    }
}

/// In loops a step is solved by iteration. Rates γ_i t between 0 and 9, another one at each site, keep it from converging. A
/// shorter step, as the help says, takes place.
#[test]
fn strong_damping_in_loops_takes_shorter_steps() {
    let strong = Beside {
        method: "stepper = \"implicit-midpoint\"",
        forces: ["180*sin(2*q{i})^2*p{i}", "0"],
        ..ALONE
    };
    let scene = strong.scene(MANY, false);
    let failed = in_loops(&scene).walk().step().map(|_| ());
    assert!(
        matches!(failed, Err(StepError::NoConvergence { .. })),
        "{failed:?}"
    );
    let shorter = scene.replace("time-step = 0.05", "time-step = \"0.05/6\"");
    assert!(scene != shorter);
    end(&in_loops(&shorter));
}

/// Fewer bodies beside forces are written out: their steps have derivatives, and strong damping is solved by Newton's method.
#[test]
fn few_bodies_beside_forces_are_written_out() {
    for method in ["stepper = \"rk4\"", "stepper = \"implicit-midpoint\""] {
        let case = Beside {
            method,
            forces: ["400*p{i}", "0"],
            ..ALONE
        };
        let run = composed(&case.scene(16, false));
        assert!(run.system.expressions().is_some());
        let parameters = run.system.parameter_values();
        let mut steps = run.method.map().differential(&parameters, 1.0, 0.001);
        let x = &run.plan.initial;
        let mut increment = vec![0.0; x.len()];
        steps
            .step(x, &vec![0.0; x.len()], &mut increment)
            .expect("a step");
        let mut covector = vec![1.0; x.len()];
        steps.pull(&mut covector, &mut []).expect("a derivative");
    }
    let strong = Beside {
        method: "stepper = \"implicit-midpoint\"",
        forces: ["400*p{i}", "0"],
        ..ALONE
    };
    // γh = 20.
    end(&composed(&strong.scene(16, false)));
}

/// Springs between all pairs leave the centre of mass alone: Q″ = −Q − γQ′, by forces, by damping with the metric of q, and by
/// friction, at 600 sites. dop853 with its tolerance of 1e-12 a step is off by 1e-10 after 40 steps of size 1.
#[test]
fn centres_of_mass_are_damped_oscillators() {
    let gamma = 0.3;
    for beside in [
        "forces = { \"q[i]\" = \"0.3*p[i]\" }",
        "damping = { rate = 0.3, metric = { \"q[i]\" = 1 } }",
        "friction = { \"p[i]\" = \"-0.3*p[i]\" }",
    ] {
        let run = in_loops(&format!(
            "[system]\nfamilies = {{ q = 600, p = 600 }}\nbracket = \"canonical\"\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"sum(i, p[i]^2/2 + q[i]^2/2) + sum(i<j, (q[i] - q[j])^2)/N\"\n{beside}\n\
             [method]\nstepper = \"dop853\"\ntime-step = 0.1\n[run]\nsteps = 40\n\
             initial = {{ \"q[i]\" = \"1 + sin(1.3*i)\", \"p[i]\" = 0 }}\n"
        ));
        let centre = |x: &[f64]| x[..600].iter().sum::<f64>() / 600.0;
        let t = 4.0;
        let rate = libm::sqrt(1.0 - 0.25 * gamma * gamma);
        let turned = libm::cos(rate * t) + 0.5 * gamma / rate * libm::sin(rate * t);
        let expected = centre(&run.plan.initial) * libm::exp(-0.5 * gamma * t) * turned;
        let found = centre(&end(&run));
        assert!(
            (found - expected).abs() <= 1e-10,
            "{beside}: {found} {expected}"
        );
    }
}

/// Forces and noise of several sites are refused beyond a thousand coordinates, underlined; the template of the help is taken.
#[test]
fn what_is_no_template_of_a_site_is_refused_with_one_that_is() {
    let scene = |beside: &str| {
        format!(
            "[system]\nfamilies = {{ q = 600, p = 600 }}\nbracket = \"canonical\"\n\
             hamiltonian = \"sum(i, p[i]^2/2) + sum(i<j, (q[i] - q[j])^2)/N\"\n{beside}\n\
             [method]\nstepper = \"implicit-midpoint\"\ntime-step = 0.05\n[run]\nsteps = 1\n\
             initial = {{ \"q[i]\" = \"sin(1.3*i)\", \"p[i]\" = 0 }}\n"
        )
    };
    for (beside, kind) in [
        ("forces = { \"q[i]\" = \"0.1*p[i+1]\" }", "a force"),
        ("friction = { \"q[3]\" = \"0.1*p[3]\" }", "`friction`"),
        ("damping = { rate = \"p[0]^2\" }", "`damping`"),
        (
            "noise = [{ hamiltonian = \"q[i]*q[i+1]\", strength = 1 }]",
            "`noise`",
        ),
        (
            "noise = [{ hamiltonian = \"sum(i<j, q[i]*q[j])\", strength = 1 }]",
            "`noise`",
        ),
    ] {
        let refusal = compose(&document(&scene(beside), &[]), &Registry::with_builtin());
        let refusal = refusal.map(|_| ()).expect_err("looks at other sites");
        assert!(refusal.message.starts_with(kind), "{}", refusal.message);
        let help = refusal.help.clone().unwrap_or_default();
        let (_, template) = help.split_once(", as ").expect("a template");
        let (template, _) = template.split_once(", or shorten").expect("an end");
        in_loops(&scene(template));
    }
}

/// Of a realization with its dynamics, which takes no pairs in a loop, the help names steppers that take the scene.
#[test]
fn steppers_that_are_named_take_what_stands_beside() {
    let scene = |beside: &str, method: &str| {
        format!(
            "[system]\nfamilies = {{ q = 600, p = 600 }}\nbracket = \"canonical\"\n\
             hamiltonian = \"sum(i, p[i]^2/2) + sum(i<j, (q[i] - q[j])^2)/N\"\n{beside}\n\
             [method]\n{method}\ntime-step = 0.05\n[run]\nsteps = 1\n\
             initial = {{ \"q[i]\" = \"sin(1.3*i)\", \"p[i]\" = 0 }}\n"
        )
    };
    for (beside, takes_splitting) in [
        ("", true),
        ("noise = [{ hamiltonian = \"q[i]\", strength = 1 }]", true),
        ("forces = { \"q[i]\" = \"0.1*p[i]\" }", false),
        ("friction = { \"p[i]\" = \"-0.1*p[i]\" }", false),
    ] {
        let refusal = compose(
            &document(&scene(beside, ""), &[]),
            &Registry::with_builtin(),
        );
        let refusal = refusal.map(|_| ()).expect_err("all pairs written out");
        let help = refusal.help.clone().unwrap_or_default();
        assert_eq!(help.contains("splitting"), takes_splitting, "{help}");
        let (_, names) = help.split_once(": ").expect("names");
        assert!(names.split(", ").count() > 3, "{help}");
        for name in names.split(", ") {
            let name = name.split(' ').next().unwrap_or_default();
            in_loops(&scene(beside, &format!("stepper = \"{name}\"")));
        }
    }
}

/// Rotors in the field of all, in a bath of temperature kT = 0.3: the mean of M = |Σ e^{iq}|/N solves M = I_1(M/kT)/I_0(M/kT),
/// M = 0.77313 (M. Antoni, S. Ruffo, *Clustering and relaxation in Hamiltonian long-range dynamics*, Phys. Rev. E 52 (1995)).
///
/// Means are of 40 states two correlation times apart. M fluctuates by √(χ kT/N) with χ ≤ 1, 0.022, and the bias of N rotors is of
/// order 1/N. Each mean has an error of 0.0035, and the bound is four of them. The kinetic temperature is that of 600·40 momenta.
#[test]
fn rotors_in_a_bath_have_the_magnetization_of_their_temperature() {
    for method in ["stepper = \"implicit-midpoint\"", "stepper = \"rk4\""] {
        let run = in_loops(&format!(
            "[system]\nfamilies = {{ q = 600, p = 600 }}\nbracket = \"canonical\"\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"sum(i, p[i]^2/2) - (sum(i, cos(q[i]))^2 + sum(i, sin(q[i]))^2)/(2*N)\"\n\
             forces = {{ \"q[i]\" = \"0.5*p[i]\" }}\n\
             noise = [{{ hamiltonian = \"q[i]\", strength = \"sqrt(0.3)\" }}]\n\
             [method]\n{method}\ntime-step = 0.1\n[run]\nsteps = 10\nseed = 3\n\
             initial = {{ \"q[i]\" = \"0.5*sin(1.3*i)\", \"p[i]\" = 0 }}\n"
        ));
        let mut walk = run.walk();
        let (mut magnetization, mut kinetic) = (0.0, 0.0);
        let states = 40;
        for at in 0..states + 10 {
            walk.advance(80).expect("steps");
            if at < 10 {
                continue;
            }
            let x = walk.state();
            let [c, s] =
                [libm::cos, libm::sin].map(|f| x[..600].iter().map(|q| f(*q)).sum::<f64>());
            magnetization += libm::hypot(c, s) / 600.0 / f64::from(states);
            kinetic += x[600..].iter().map(|p| p * p).sum::<f64>() / 600.0 / f64::from(states);
        }
        assert!(
            (magnetization - 0.77313).abs() <= 0.014,
            "{method}: {magnetization}"
        );
        let allowed = 4.0 * 0.3 * libm::sqrt(2.0 / (600.0 * f64::from(states)));
        assert!((kinetic - 0.3).abs() <= allowed, "{method}: {kinetic}");
    }
}
