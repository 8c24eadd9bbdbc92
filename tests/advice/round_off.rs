//! Round-off of states and derivatives, and energies beside their scale.

use leafwise::run::advice::AdviceKind;

use super::{of_kind, told_of_kind};

/// asinh(1e300 x) has the slope 1/x, and 1e300/√(1 + 1e600 x²) is 0 in doubles; asinh(1e140 x) has it there too.
#[test]
fn a_derivative_that_leaves_the_range_of_doubles_is_reported() {
    let text = |factor: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"-1\" }}\n\
             hamiltonian = \"p^2/2 + asinh({factor}*q)\"\n\
             [method]\nstepper = \"rk4\"\ntime-step = 0.01\n\
             [run]\ninitial = [1.5, 0.5]\nsteps = 4\n"
        )
    };
    let found = of_kind(&text("1e300"), AdviceKind::RoundOff).expect("told");
    assert!(
        found.message.contains("by q it is 0, by differences 0.67"),
        "{}",
        found.message
    );
    assert_eq!(of_kind(&text("1e140"), AdviceKind::RoundOff), None);
}

/// cos(kq) with kq = 2e16 and 2e9: round-off of q is 2 radians and 2e-7 of one.
#[test]
fn a_step_that_the_states_round_off_decides_is_reported() {
    let text = |k: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\n\
             hamiltonian = \"p^2/2 + sin({k}*q)/{k}\"\nconvention = \"{{x,H}}\"\n\
             [method]\nstepper = \"splitting\"\ntime-step = 1e-18\n\
             [run]\ninitial = [2.1, 1e-17]\nsteps = 8\n"
        )
    };
    let found = of_kind(&text("1e16"), AdviceKind::RoundOff).expect("a warning");
    assert!(found.message.contains("round-off"), "{}", found.message);
    assert_eq!(of_kind(&text("1e9"), AdviceKind::RoundOff), None);
}

/// A constant of 1e300 beside terms of 1, and one of 1e3.
#[test]
fn an_energy_below_its_own_round_off_is_reported() {
    let text = |constant: &str| {
        format!(
            "[system]\nvariables = [\"x\", \"y\", \"z\"]\nbracket = {{ lie-algebra = \"so3\" }}\n\
             hamiltonian = \"{constant} + x^2/2 + y^2/4 + z^2/6\"\n\
             [method]\nstepper = \"splitting\"\ntime-step = 0.05\n[run]\ninitial = [1, 3, 3]\nsteps = 100\n"
        )
    };
    let found = of_kind(&text("1e300"), AdviceKind::RoundOff).expect("a warning");
    assert!(found.change.contains("constant"), "{}", found.change);
    assert_eq!(of_kind(&text("1e3"), AdviceKind::RoundOff), None);
}

/// Energies that are right and near 0 where an orbit begins or waits, on lattices without recorded states, and with the
/// time; the same methods with errors of a hundredth and more are told.
#[test]
fn an_energy_is_judged_by_what_it_is_along_the_whole_orbit() {
    let duffing = |step: f64, steps: u64| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"p^2/2 - q^2/2 + q^4/4\"\n\
             [method]\nrealization = \"auto\"\ndynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\n\
             time-step = {step:?}\n[run]\ninitial = [1e-6, 0.0]\nsteps = {steps}\n"
        )
    };
    let kicks = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
                 hamiltonian = \"p^2/2 + 0.5*cos(q)*exp(-(sin(pi*(t-0.5))/0.05)^2)\"\n\
                 [method]\nstepper = \"dop853\"\ntime-step = 0.1\n[run]\ninitial = [1.0, 0.0]\nsteps = 100\n";
    let slope = |step: f64, well: &str| {
        format!(
            "[system]\nfamilies = {{ q = 100, p = 100 }}\nparameters = {{ h = 0.1 }}\nbracket = {{ \"q[i],p[i]\" = 1 }}\n\
             convention = \"{{x,H}}\"\nboundary = \"periodic\"\nhamiltonian = \"sum(i, p[i]^2/2 + h*q[i]{well})\"\n\
             [method]\nstepper = \"splitting\"\ntime-step = {step:?}\n\
             [run]\ninitial = {{ \"q[i]\" = \"0.3*sin(2*pi*i/N)\", \"p[i]\" = \"0\" }}\nsteps = 200\n"
        )
    };
    for right in [duffing(0.05, 1200), kicks.to_owned(), slope(0.1, "")] {
        assert_eq!(
            told_of_kind(&right, AdviceKind::EnergyError),
            None,
            "{right}"
        );
    }
    for wrong in [duffing(0.9, 70), slope(0.25, " + 10*q[i]^4 - 0.030375")] {
        let found = told_of_kind(&wrong, AdviceKind::EnergyError);
        assert!(found.is_some(), "{wrong}");
    }
}

/// Orbits whose radial momentum, latitude or both are 0: all of their motion is round-off. A pendulum at rest above, where sin π is
/// 1.2e-16.
#[test]
fn coordinates_at_rest_are_no_round_off() {
    let circular = |method: &str| {
        format!(
            "[system]\nvariables = [\"r\", \"phi\", \"pr\", \"L\"]\nbracket = {{ \"r,pr\" = \"1\", \"phi,L\" = \"1\" }}\n\
             convention = \"{{x,H}}\"\nhamiltonian = \"pr^2/2 + L^2/(2*r^2) - 1/r\"\n[method]\n{method}\ntime-step = 0.1\n\
             [run]\ninitial = [1.3, 0, 0, 1.140175425099138]\nsteps = 1000\n"
        )
    };
    // p_φ² = −g sin⁴θ/cos θ.
    let conical = |method: &str| {
        format!(
            "[system]\nvariables = [\"theta\", \"phi\", \"s\", \"L\"]\nbracket = {{ \"theta,s\" = \"1\", \"phi,L\" = \"1\" }}\n\
             convention = \"{{x,H}}\"\nhamiltonian = \"s^2/2 + L^2/(2*sin(theta)^2) + 9.81*cos(theta)\"\n[method]\n{method}\n\
             time-step = 0.02\n[run]\ninitial = [2.5, 0, 0, 1.253332117116018]\nsteps = 500\n"
        )
    };
    let pendulum = |method: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"p^2/2 - cos(q)\"\n[method]\n{method}\ntime-step = 0.1\n\
             [run]\ninitial = [3.141592653589793, 0]\nsteps = 50\n"
        )
    };
    for method in [
        "stepper = \"splitting\"",
        "stepper = \"gauss\"",
        "stepper = \"dop853\"",
        "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 6 }",
    ] {
        for text in [circular(method), conical(method), pendulum(method)] {
            for kind in [AdviceKind::RoundOff, AdviceKind::CoarseStep] {
                assert_eq!(told_of_kind(&text, kind), None, "{text}");
            }
        }
    }
}
