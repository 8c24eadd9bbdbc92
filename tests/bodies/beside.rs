//! Forces, friction and noise beside sums over pairs.

use std::fmt::Write as _;

use leafwise::core::Registry;
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

fn cases() -> [Beside; 10] {
    let of = |method| Beside { method, ..ALONE };
    [
        Beside {
            forces: FORCES,
            ..of("stepper = \"implicit-midpoint\"")
        },
        Beside {
            forces: FORCES,
            noise: &["q{i}", "p{i}*q{i}"],
            ..of("stepper = \"implicit-midpoint\"")
        },
        Beside {
            damping: true,
            forces: FORCES,
            ..of("stepper = { name = \"gauss\", stages = 2 }")
        },
        Beside {
            friction: FRICTION,
            ..of("stepper = \"dop853\"")
        },
        Beside {
            friction: FRICTION,
            damping: true,
            forces: FORCES,
            ..of("stepper = \"taylor\"")
        },
        Beside {
            friction: FRICTION,
            noise: &["q{i}"],
            ..of("stepper = \"rk4\"")
        },
        Beside {
            noise: &["sin(q{i})", "q{i}^4"],
            ..of("stepper = \"splitting\"")
        },
        Beside {
            noise: &["sin(q{i})", "p{i}"],
            ..of("stepper = \"splitting\"\nnoise = \"split\"")
        },
        Beside {
            noise: &["sum(i, p{i})", "q{i}"],
            ..of("stepper = \"splitting\"\nnoise = \"split\"")
        },
        Beside {
            noise: &["sum(i, cos(q{i}))"],
            forces: FORCES,
            ..of("stepper = \"implicit-midpoint\"")
        },
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
                    let _ = write!(energy, " - a/(1 + (q{i} - q{j})^2)");
                }
            }
        } else {
            let _ = writeln!(text, "families = {{ q = {sites}, p = {sites} }}");
            energy = "sum(i, p[i]^2/2 + q[i]^4/4) - a*sum(i<j, 1/(1 + (q[i] - q[j])^2))".to_owned();
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
fn what_stands_beside_pairs_moves_as_written_out() {
    for case in cases() {
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
            assert_eq!(run.system.motion(), whole.system.motion());
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

/// What is no template of single sites is refused beyond a thousand coordinates, underlined; what the help shows is taken.
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
        assert!(
            help.contains("forces = { \"q[i]\" = \"0.1*p[i]\" }"),
            "{help}"
        );
    }
    for beside in [
        "forces = { \"q[i]\" = \"0.1*p[i]\" }",
        "noise = [{ hamiltonian = \"q[i]\", strength = 1 }]",
        "damping = { rate = 0.1 }",
    ] {
        in_loops(&scene(beside));
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
