//! Taylor series of sums over pairs in loops.

use leafwise_tests::scenes::{composed, end};

use super::{gravity, in_loops, written_out};

const TAYLOR: &str = "stepper = \"taylor\"";

/// Taylor series of 16 bodies in loops: ten steps are those of the system written out by a Gauss method of order 16. Those of 300
/// bodies are its steps in loops.
#[test]
fn taylor_series_in_loops_are_those_written_out() {
    let reference = "stepper = { name = \"gauss\", stages = 8 }";
    for (expected, sites) in [
        (composed(&written_out(16, reference)), 16),
        (in_loops(&gravity(300, reference)), 300),
    ] {
        let (found, expected) = (end(&in_loops(&gravity(sites, TAYLOR))), end(&expected));
        for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!(
                (found - expected).abs() <= 1e-13,
                "{sites} {at}: {found} {expected}"
            );
        }
    }
}

/// Vortices, whose H does not separate, mean fields, couplings of every pair, and a bracket of the coordinates: a Taylor
/// series in loops, and a Gauss method of order 16 in steps of a quarter.
#[test]
fn taylor_series_take_every_sum_over_pairs() {
    let vortices = "bracket = { \"x[i],y[i]\" = \"1/g[i]\" }\nparameters = { \"g[i]\" = \"1 + 0.3*sin(i)\" }\n\
                    hamiltonian = \"-sum(i<j, g[i]*g[j]*ln((x[i] - x[j])^2 + (y[i] - y[j])^2))/(4*pi)\"";
    let mean = "bracket = { \"x[i],y[i]\" = \"1\" }\n\
                hamiltonian = \"sum(i, y[i]^2/2) + (N^2 - sum(i, cos(x[i]))^2 - sum(i, sin(x[i]))^2)/(2*N)\"";
    let coupled = "bracket = { \"x[i],y[i]\" = \"1\" }\nparameters = { \"J[i,j]\" = \"sin(3*i + 5*j)\" }\n\
                   hamiltonian = \"sum(i, y[i]^2/2) - sum(i<j, J[i,j]*cos(x[i] - x[j]))/N\"";
    let curved = "bracket = { \"x[i],y[i]\" = \"1 + x[i]^2\" }\n\
                  hamiltonian = \"sum(i, y[i]^2/2) + sum(i<j, sqrt(1 + (x[i] - x[j])^2 + y[i]^2*y[j]^2))/N\"";
    for system in [vortices, mean, coupled, curved] {
        let scene = |method: &str, steps: usize| {
            let step = 0.5 / steps as f64;
            format!(
                "[system]\nfamilies = {{ x = 20, y = 20 }}\n{system}\n[method]\n{method}\ntime-step = {step}\n\
                 [run]\nsteps = {steps}\ninitial = {{ \"x[i]\" = \"2*cos(2*pi*i/N) + 0.1*sin(3*i)\", \"y[i]\" = \"2*sin(2*pi*i/N) + 0.1*cos(2*i)\" }}\n"
            )
        };
        let reference = "stepper = { name = \"gauss\", stages = 8 }";
        let (found, expected) = (
            end(&in_loops(&scene(TAYLOR, 10))),
            end(&in_loops(&scene(reference, 40))),
        );
        for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!(
                (found - expected).abs() <= 2e-13,
                "{system} {at}: {found} {expected}"
            );
        }
    }
}

/// Bodies that start at rest and pull from all sides: the forces nearly cancel, and what is left is round-off of large terms.
#[test]
fn taylor_series_begin_at_rest() {
    let text = gravity(40, TAYLOR);
    let rest: String = text
        .lines()
        .filter(|line| {
            !["\"u[i]\"", "\"v[i]\"", "\"w[i]\""]
                .iter()
                .any(|own| line.starts_with(own))
        })
        .fold(String::new(), |text, line| text + line + "\n");
    let rest = format!("{rest}\"u[i]\" = 0\n\"v[i]\" = 0\n\"w[i]\" = 0\n");
    let reference = "stepper = { name = \"gauss\", stages = 8 }";
    let (found, expected) = (
        end(&in_loops(&rest)),
        end(&in_loops(&rest.replace(TAYLOR, reference))),
    );
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() <= 1e-13, "{found} {expected}");
    }
}
