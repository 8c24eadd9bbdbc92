//! Long lattices: templates of random families take two steps, to the same bits by both kernels.

use crate::Reached;
use crate::scenes::same_bits;
use crate::source::Source;

const STEPS: usize = 2;

/// One lattice.
///
/// # Errors
/// A state that is not finite, or bits that differ, with the scene.
pub fn check(bytes: &[u8]) -> Result<Reached, String> {
    let text = lattice(&mut Source::new(bytes));
    same_bits(&text, STEPS).map_err(|what| format!("{what}\n{text}"))
}

/// A chain of oscillators, of populations, of Toda's variables or of spins.
fn lattice(source: &mut Source<'_>) -> String {
    let length = 24 + source.below(60);
    let boundary = source.pick(&["periodic", "open"]);
    let (a, b, c) = (
        source.decimal(0.2, 2.0),
        source.decimal(-1.0, 1.0),
        source.decimal(0.1, 1.0),
    );
    let site = source.pick(&[
        "",
        "+ 0.1*sin(2*pi*i/N)",
        "+ 0.3*exp(-((i-8)/3)^2)",
        "+ 0.01*i",
    ]);
    let (families, bracket, hamiltonian, initial) = match source.below(4) {
        0 => {
            let coupling = source.pick(&[
                "(q[i+1] - q[i])^2/2",
                "exp(q[i] - q[i+1])",
                "cos(q[i+1] - q[i])",
                "(q[i+1] - q[i])^4/4",
                "1/(2 + (q[i+1] - q[i])^2)",
            ]);
            (
                format!("q = {length}, p = {length}"),
                "\"q[i],p[i]\" = \"-1\"".to_owned(),
                format!("sum(i, {a}*p[i]^2/2 + {c}*q[i]^2 + {b}*{coupling})"),
                format!("\"q[i]\" = \"0 {site}\", \"p[i]\" = \"{b}\""),
            )
        }
        1 => (
            format!("x = {length}"),
            "\"x[i],x[i+1]\" = \"x[i]*x[i+1]\"".to_owned(),
            format!("sum(i, x[i] - {a}*ln(x[i]) + {c}*x[i]*x[i+1])"),
            format!("\"x[i]\" = \"{a} {site}\""),
        ),
        2 => (
            format!("a = {length}, b = {length}"),
            "\"a[i],b[i]\" = \"a[i]\", \"a[i],b[i+1]\" = \"-a[i]\"".to_owned(),
            format!("sum(i, b[i]^2/2 + {a}*a[i]^2 + {b}*b[i]*b[i+1])"),
            format!("\"a[i]\" = \"0.5 {site}\", \"b[i]\" = \"{b}\""),
        ),
        _ => (
            format!("x = {length}, y = {length}, z = {length}"),
            "\"x[i],y[i]\" = \"-z[i]\", \"y[i],z[i]\" = \"-x[i]\", \"z[i],x[i]\" = \"-y[i]\""
                .to_owned(),
            format!("sum(i, x[i]*x[i+1] + {b}*y[i]*y[i+1] + {c}*z[i]^2)"),
            format!("\"x[i]\" = \"1\", \"y[i]\" = \"0 {site}\", \"z[i]\" = \"{b}\""),
        ),
    };
    let method = method(source);
    let step = source.pick(&[1e-3, 0.01, 0.05, 0.1, 0.3]);
    format!(
        "[system]\nfamilies = {{ {families} }}\nbracket = {{ {bracket} }}\nboundary = \"{boundary}\"\n\
         hamiltonian = \"{hamiltonian}\"\n[method]\n{method}time-step = {step:?}\n[run]\n\
         initial = {{ {initial} }}\nsteps = {STEPS}\n"
    )
}

fn method(source: &mut Source<'_>) -> String {
    let mut text = match source.below(3) {
        0 => "stepper = \"splitting\"\n".to_owned(),
        1 => format!(
            "realization = {{ name = \"karasev-truncated\", order = {} }}\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\n",
            1 + source.below(3)
        ),
        _ => {
            let order = 2 * (1 + source.below(2));
            format!(
                "realization = \"auto\"\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\n"
            )
        }
    };
    if source.chance(80) {
        let name = source.pick(&["suzuki-4", "kahan-li-6", "blanes-moan-4"]);
        text.push_str(&format!("composition = \"{name}\"\n"));
    }
    text
}
